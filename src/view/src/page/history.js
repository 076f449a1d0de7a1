// The story of the chosen value: when it is there and why not before, its
// operands and readers, its equations, and every pass that changed it.

function story(page) {
  const s = page.state, i = page.statement(s);
  if (page.line) return lineStory(page);
  if (i < 0) return [el("h3", null, "Select a value to see its history"), el("p", null, "Why it is late, the equations it comes from, and every pass that changed it.")];
  const { fn } = page, state = fn.states[s], last = state.last(i);
  const parts = [el("h3", { id: "chosen" }, state.name(i)), el("p", { class: "code" }, state.written(i))];
  const facts = [`available at cycle ${state.arrivals[i]} of ${state.path}, ` + (state.slacks[i] ? `slack ${state.slacks[i]}` : "on a longest path")];
  if (state.errors[i] !== null) facts.push(`relative error ${small(state.errors[i])} in ${fn.format} at one state`);
  parts.push(el("p", null, facts.join("; ")));
  if (last >= 0) parts.push(el("p", null, "It waits for ", page.link(s, last), `, available at cycle ${state.arrivals[last]}. `,
    el("button", { class: "value", id: "why", onclick: () => page.go({ tab: "path" }) }, "The whole chain")));
  const value = state.isOutput(i) ? last : i;
  if (fn.schedule && state === fn.end && value >= 0 && value < state.values && fn.schedule.element[value] >= 0) {
    const plan = fn.schedule;
    parts.push(el("p", null, `On ${plan.elements[plan.element[value]]} at cycle ${plan.cycle[value]}, readable from cycle ${plan.cycle[value] + plan.delay[value]}: ${fn.why(value)}.`));
  }
  parts.push(...links(page, s, "Operands", state.operands(i)), ...links(page, s, "Read by", state.readers(i)));
  parts.push(...joints(page, state, i));
  parts.push(el("h3", null, "Equations"), ...places(page, state.places(i)));
  parts.push(el("h3", null, "What the passes made of it"));
  parts.push(...steps(page, s, i));
  if (state.isOutput(i) && last >= 0 && state.text(i) === state.name(last)) {
    parts.push(el("h3", null, "It is set to ", page.link(s, last)), ...places(page, state.places(last)), ...steps(page, s, last));
  }
  return parts;
}

function links(page, s, title, list) {
  if (list.length === 0) return [];
  const shown = list.slice(0, 12).flatMap((k, number) => [number ? ", " : "", page.link(s, k)]);
  return [el("p", null, title + " ", ...shown, list.length > 12 ? ` and ${list.length - 12} more` : "")];
}

// The joints whose numbers stand in a statement.
function joints(page, state, i) {
  const found = new Set();
  for (const [, indices] of (state.name(i) + " " + state.text(i)).matchAll(/\b(?:q|qd|qdd|Qq|c|M|Minv|\w+_q|\w+_qd|\w+_Qq)\[([\d,]+)\]/g))
    for (const index of indices.split(",")) if (DATA.joints[index - 1]) found.add(Number(index));
  if (found.size === 0) return [];
  const shown = [...found].slice(0, 6).map(index => {
    const { name, place } = DATA.joints[index - 1];
    const link = place ? el("button", { class: "value", onclick: () => page.go({ tab: "source", file: place[0], at: place[1] }) }, name) : name;
    return el("span", null, `${index}: `, link, "  ");
  });
  return [el("p", null, found.size === 1 ? "Joint " : "Joints ", ...shown)];
}

function places(page, list) {
  const shown = list.slice(0, 6).map(place => el("p", { class: "code equation" },
    el("button", { class: "value", onclick: () => page.go({ tab: "source", file: place[0], at: place[1] }) }, placeText(place)), "  " + lineOf(place)));
  if (list.length > 6) shown.push(el("p", null, `and ${list.length - 6} more`));
  return shown.length ? shown : [el("p", null, "no known equation")];
}

// From what was read to the state that is looked at, changes only.
function steps(page, s, i) {
  const { fn } = page, ancestry = fn.ancestry(s, i).reverse(), shown = [];
  const timing = ([k, j]) => `available at cycle ${fn.states[k].arrivals[j]} of ${fn.states[k].path}, error ${small(fn.states[k].errors[j])}`;
  const [first, start] = ancestry[0];
  const begun = fn.states[first];
  shown.push(el("div", { class: "step" }, el("b", null, begun.pass === null ? "as read" : begun.pass), ...begun.rule(start).map(rule => el("span", { class: "rule" }, rule)),
    el("div", { class: "code after" }, `${begun.name(start)} = ${begun.written(start)}`), el("div", { class: "soft" }, timing(ancestry[0]))));
  for (let k = 1; k < ancestry.length; k++) {
    const [was, old] = ancestry[k - 1], [is, now] = ancestry[k];
    const before = fn.states[was], after = fn.states[is], rules = after.rule(now);
    const left = before.written(old), right = after.written(now);
    if (left === right && before.name(old) === after.name(now) && before.text(old) === after.text(now) && rules.length === 0) continue;
    shown.push(el("div", { class: "step" },
      el("button", { class: "value", title: "show this pass", onclick: () => page.go({ tab: "passes", s: is, v: after.name(now) }) }, after.pass),
      " ", ...(rules.length ? rules.map(rule => el("span", { class: "rule" }, rule)) : [el("span", { class: "soft does" }, summary(after.pass))]),
      left === right ? el("div", { class: "code" }, right) : el("div", { class: "code before" }, `${before.name(old)} = ${left}`),
      left === right ? null : el("div", { class: "code after" }, `${after.name(now)} = ${right}`),
      el("div", { class: "soft" }, timing(ancestry[k]))));
  }
  return shown;
}

// What a pass does, where it told no rule of its own.
function summary(pass) { return DATA.summaries[pass.replace(/[{].*/, "")] || ""; }

// What was made of a line of the source.
function lineStory(page) {
  const [file, line] = page.line, s = page.state, state = page.fn.states[s], made = [];
  for (let i = 0; i < state.count && made.length < 200; i++) if (state.places(i).some(place => place[0] === file && place[1] === line)) made.push(i);
  const share = page.fn.heats.get(file + ":" + line) || 0;
  return [el("h3", null, `${DATA.files[file].name}, line ${line}`), el("p", { class: "code" }, lineOf([file, line])),
    el("p", null, `${made.length} statements of the state ${state.pass === null ? "as read" : "after " + state.pass} come from it` + (share ? `; ${percent(share)} of the errors of the outputs` : "")),
    ...made.map(i => el("p", { class: "code" }, page.link(s, i), " = " + state.text(i)))];
}
