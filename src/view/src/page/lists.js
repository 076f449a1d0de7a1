// Long lists, of which only the lines in sight are in the document.

const LINE = 20;

// A list of `count` lines; `draw(number)` gives the element of one.
function virtualList(count, draw, first = 0) {
  const inner = el("div", { style: `height:${Math.max(1, count) * LINE}px;position:relative` });
  const box = el("div", { class: "lines", tabindex: "0" }, inner);
  let from = -1, to = -1;
  const show = () => {
    const top = Math.max(0, Math.floor(box.scrollTop / LINE) - 10);
    const bottom = Math.min(count, top + Math.ceil((box.clientHeight || 600) / LINE) + 20);
    if (top === from && bottom === to) return;
    from = top; to = bottom;
    const lines = [];
    for (let i = top; i < bottom; i++) {
      const line = draw(i);
      line.style.top = i * LINE + "px";
      lines.push(line);
    }
    inner.replaceChildren(...lines);
  };
  box.addEventListener("scroll", show, { passive: true });
  queueMicrotask(() => { box.scrollTop = Math.max(0, first * LINE - 120); from = -1; show(); });
  return box;
}

// Pairs of statements before and after a pass, in the order of those before:
// [before or -1, after or -1].
function pairs(fn, s) {
  const after = fn.states[s];
  if (s === 0) return Array.from({ length: after.count }, (_, i) => [-1, i]);
  const before = fn.states[s - 1];
  const children = Array.from({ length: before.count }, () => []);
  const orphans = new Map();
  let anchor = -1;
  for (let i = 0; i < after.count; i++) {
    const origin = after.origins[i];
    if (origin >= 0) { children[origin].push(i); anchor = i; }
    else if (orphans.has(anchor)) orphans.get(anchor).push(i);
    else orphans.set(anchor, [i]);
  }
  const rows = (orphans.get(-1) || []).map(i => [-1, i]);
  children.forEach((made, j) => {
    if (made.length === 0) rows.push([j, -1]);
    made.forEach((i, k) => {
      rows.push([k === 0 ? j : -1, i]);
      for (const orphan of orphans.get(i) || []) rows.push([-1, orphan]);
    });
  });
  return rows;
}

function kindOf(fn, s, [j, i]) {
  if (s === 0) return "";
  if (j < 0) return "new";
  if (i < 0) return "gone";
  const same = fn.states[s - 1].text(j) === fn.states[s].text(i);
  return same && fn.states[s - 1].name(j) === fn.states[s].name(i) ? "" : "changed";
}

function statementCell(state, i) {
  if (i < 0) return el("span", { style: "overflow:hidden" });
  const when = `${state.arrivals[i]}${state.slacks[i] ? "" : "*"}`;
  return el("span", { style: "overflow:hidden", "data-statement": i },
    el("span", { class: state.slacks[i] ? "when" : "when critical", title: "available at cycle; * on a longest path" }, when),
    `${state.name(i)} = ${state.text(i)}`);
}

function passesTab(page) {
  const { fn } = page, s = page.state;
  const after = fn.states[s], before = fn.states[s - 1];
  const select = el("select", { id: "pass", "aria-label": "pass", onchange: event => page.go({ s: event.target.value }) },
    ...fn.states.map((state, k) => el("option", { value: k, selected: k === s }, state.pass === null ? "as read" : `${k}. ${state.pass}`)));
  const only = el("input", { type: "checkbox", checked: page.only, onchange: event => page.go({ only: event.target.checked ? "1" : "" }) });
  const find = el("input", { type: "search", placeholder: "name or text", value: page.query, onchange: event => page.go({ q: event.target.value }) });
  let rows = pairs(fn, s);
  if (page.only) rows = rows.filter(row => kindOf(fn, s, row) !== "");
  const query = page.query.toLowerCase();
  if (query) rows = rows.filter(([j, i]) => (j >= 0 && (before.name(j) + " = " + before.text(j)).toLowerCase().includes(query)) ||
    (i >= 0 && (after.name(i) + " = " + after.text(i)).toLowerCase().includes(query)));
  const chosen = rows.findIndex(([j, i]) => i >= 0 && i === page.statement(s) || j >= 0 && i < 0 && j === page.statement(s - 1));
  const draw = number => {
    const [j, i] = rows[number];
    const mark = number === chosen ? " chosen" : "";
    const style = `display:grid;grid-template-columns:${s === 0 ? "1fr" : "1fr 1fr"};gap:10px;width:100%`;
    const choose = event => {
      const left = event.target.closest("[data-statement]") === event.currentTarget.firstChild;
      if (j >= 0 && (i < 0 || left)) page.choose(s - 1, j); else page.choose(s, i);
    };
    const cells = s === 0 ? [statementCell(after, i)] : [statementCell(before, j), statementCell(after, i)];
    return el("div", { class: "line " + kindOf(fn, s, [j, i]) + mark, style, onclick: choose }, ...cells);
  };
  const legend = el("span", { class: "legend" }, el("span", { style: "background:var(--changed)" }), "changed",
    el("span", { style: "background:var(--made)" }), "new", el("span", { style: "background:var(--lost)" }), "gone");
  const figures = s === 0 ? `${after.count} statements, longest path ${after.path} cycles` :
    `${before.count} to ${after.count} statements, longest path ${before.path} to ${after.path} cycles, ${rows.length} lines shown`;
  return [el("div", { class: "bar" }, el("label", null, "after pass ", select), el("label", null, only, " only what changed"), find, legend),
    el("p", { class: "caption" }, figures), virtualList(rows.length, draw, Math.max(0, chosen))];
}

function sourceTab(page) {
  const { fn } = page;
  const known = DATA.files.map((file, number) => number).filter(number => DATA.files[number].lines);
  const file = known.includes(page.file) ? page.file : known[0];
  if (file === undefined) return [el("p", null, "The text of the equations is not at hand.")];
  const most = Math.max(1e-12, ...fn.heat.map(([, , share]) => share));
  const state = fn.states[page.state], i = page.statement(page.state);
  const marked = new Set(i < 0 ? [] : state.places(i).filter(([of]) => of === file).map(([, line]) => line));
  if (page.at && page.file === file) marked.add(page.at);
  const lines = DATA.files[file].lines;
  const draw = number => {
    const share = fn.heats.get(file + ":" + (number + 1)) || 0;
    const heat = share ? `background:color-mix(in srgb, var(--hot) ${(60 * Math.sqrt(share / most)).toFixed(0)}%, transparent)` : "";
    return el("div", { class: "line" + (marked.has(number + 1) ? " chosen" : ""), style: heat, "data-line": number + 1,
      title: share ? `${percent(share)} of the errors of the outputs` : "", onclick: () => page.chooseLine(file, number + 1) },
      el("span", { class: "when" }, String(number + 1)), lines[number]);
  };
  const first = page.at && page.file === file ? page.at : Math.min(...marked, lines.length);
  const files = known.length < 2 ? null : el("div", { class: "bar" }, el("select", { "aria-label": "file", onchange: event => page.go({ file: event.target.value, at: "" }) },
    ...known.map(number => el("option", { value: number, selected: number === file }, DATA.files[number].name))));
  return [files, el("p", { class: "caption" }, `${DATA.files[file].name}: the redder, the larger the share of a line in the errors of all outputs (${fn.format}, ${percent(fn.heat.reduce((sum, [, , share]) => sum + share, 0))} have a line). A click shows what was made of a line.`),
    virtualList(lines.length, draw, marked.size ? first : 0)];
}
