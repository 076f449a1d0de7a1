// Outputs by time, the chain that makes a value late, and the dataflow graph
// around it.

function table(head, rows, given) {
  const body = el("tbody", null, ...rows);
  const sort = column => {
    const ascending = heads[column].getAttribute("aria-sort") !== "ascending";
    heads.forEach(head => head.removeAttribute("aria-sort"));
    heads[column].setAttribute("aria-sort", ascending ? "ascending" : "descending");
    const key = row => { const text = row.cells[column].textContent, number = parseFloat(text); return isNaN(number) ? text : number; };
    [...body.rows].sort((a, b) => { const x = key(a), y = key(b); return (x > y ? 1 : x < y ? -1 : 0) * (ascending ? 1 : -1); })
      .forEach(row => body.append(row));
  };
  const heads = head.map((text, column) => el("th", { class: "sort", tabindex: "0", onclick: () => sort(column),
    onkeydown: event => { if (event.key === "Enter") sort(column); } }, text));
  return el("div", { class: "scroll" }, el("table", given, el("thead", null, el("tr", null, ...heads)), body));
}
const cell = (text, number) => el("td", number ? { class: "n" } : null, text);

function lateTab(page) {
  const { fn } = page, state = fn.end, plan = fn.schedule;
  const outputs = [];
  for (let i = state.values; i < state.count; i++) outputs.push(i);
  outputs.sort((a, b) => state.arrivals[b] - state.arrivals[a] || a - b);
  const rows = outputs.map(i => {
    const value = state.last(i);
    const done = plan && value >= 0 && plan.element[value] >= 0 ? plan.cycle[value] + plan.delay[value] : "-";
    return el("tr", null, el("td", null, page.link(state.number, i)), cell(String(state.arrivals[i]), true),
      cell(String(state.slacks[i]), true), cell(String(done), true), cell(small(state.errors[i]), true));
  });
  const passes = fn.passes.map(pass => el("tr", null, cell(pass.name), cell(String(pass.operations), true), cell(String(pass.asap_cycle), true),
    cell((1000 * pass.cpu_s).toFixed(1), true), cell(pass.rounding ? small(pass.rounding.normwise.after.median) : "-", true),
    cell(pass.check ? (pass.check.failure ? "failed" : pass.check.result) : "-")));
  return [el("h2", null, "Which output is late"),
    el("p", { class: "caption" }, `Cycles of the longest chain that ends in an output, and how many cycles later it could be (0: on a longest path of ${state.path} cycles)` +
      (plan ? `; when it is done on ${fn.machine} (${plan.cycles} cycles, no schedule is shorter than ${plan.bound})` : "") + `; its rounding error in ${fn.format} at one state, relative. A click tells why.`),
    table(["output", "chain, cycles", "slack", "done at cycle", "error"], rows, { class: "data", id: "outputs" }),
    el("h2", null, "What the passes did"),
    table(["pass", "operations", "path, cycles", "time, ms", "normwise error in binary32, median, 2⁻²⁴", "checked"], passes, { class: "data" })];
}

// Which equation a statement comes from, in words.
function equation(state, i) {
  const places = state.places(i);
  if (places.length === 0) return "";
  return placeText(places[0]) + (places.length > 1 ? ` and ${places.length - 1} more` : "") + "  " + lineOf(places[0]);
}

function pathTab(page) {
  const { fn } = page, s = page.state, state = fn.states[s];
  const i = page.statement(s) >= 0 ? page.statement(s) : page.latest(s);
  const chain = state.chain(i);
  const length = Math.max(1, state.arrivals[i]);
  const spent = new Map();
  const rows = chain.map(k => {
    const last = state.last(k), from = last < 0 ? 0 : state.arrivals[last], to = state.arrivals[k];
    const where = equation(state, k);
    spent.set(where, (spent.get(where) || 0) + to - from);
    const span = el("span", { class: "span", style: `margin-left:${100 * from / length}%;width:${100 * (to - from) / length}%` });
    return el("tr", { class: k === i ? "chosen" : "", onclick: () => page.choose(s, k), tabindex: "0", "data-statement": k,
      onkeydown: event => { if (event.key === "Enter") page.choose(s, k); } },
      cell(`${from} to ${to}`, true), el("td", { style: "min-width:120px;width:25%" }, span), el("td", { class: "code" }, `${state.name(k)} = ${state.text(k)}`),
      el("td", { class: "code" }, where), el("td", null, fn.madeBy(s, k).map(([pass, rules]) => rules.length ? `${pass.replace(/[{].*/, "")} (${rules.join(", ")})` : pass.replace(/[{].*/, "")).join(", ")));
  }).reverse();
  const by = [...spent].filter(([, cycles]) => cycles > 0).sort((a, b) => b[1] - a[1]);
  return [el("h2", null, "Why ", page.link(s, i), ` is available at cycle ${state.arrivals[i]} and not before`),
    el("p", { class: "caption" }, "Every line waits for the one below it, its last operand. " + (s === fn.end.number ? "State: the last one." : `State: after ${state.pass === null ? "reading" : state.pass}.`)),
    table(["cycles", "", "operation", "equation", "made by"], rows, { class: "data chain", id: "chain" }),
    el("h2", null, "Cycles of this chain, by equation"),
    table(["cycles", "equation"], by.map(([where, cycles]) => el("tr", null, cell(String(cycles), true), el("td", { class: "code" }, where || "no known equation"))), { class: "data" })];
}

const SVG = "http://www.w3.org/2000/svg";
function svg(tag, given, ...children) {
  const element = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(given)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

// What a value is made from, `depth` operations back, and who reads it.
function graphTab(page) {
  const { fn } = page, s = page.state, state = fn.states[s];
  const centre = page.statement(s) >= 0 ? page.statement(s) : page.latest(s);
  const depth = page.depth, most = 120;
  const columns = new Map([[centre, 0]]);
  let queue = [centre];
  for (let level = 1; level <= depth && columns.size < most; level++) {
    const next = [];
    for (const k of queue) for (const j of state.operands(k)) if (!columns.has(j) && columns.size < most) { columns.set(j, -level); next.push(j); }
    queue = next;
  }
  for (const k of state.readers(centre)) if (!columns.has(k) && columns.size < most + 12) columns.set(k, 1);
  const layers = new Map();
  for (const [k, column] of columns) layers.set(column, [...(layers.get(column) || []), k]);
  const WIDTH = 190, HEIGHT = 44, left = Math.min(...layers.keys());
  const at = new Map();
  for (const [column, list] of layers) list.sort((a, b) => state.arrivals[b] - state.arrivals[a] || a - b)
    .forEach((k, row) => at.set(k, [(column - left) * WIDTH + 10, row * HEIGHT + 10]));
  const wide = (Math.max(...layers.keys()) - left + 1) * WIDTH + 20, high = Math.max(...[...layers.values()].map(list => list.length)) * HEIGHT + 20;
  const drawing = svg("svg", { width: wide, height: high, viewBox: `0 0 ${wide} ${high}`, role: "img", "aria-label": "dataflow graph" });
  for (const [k] of columns) for (const j of state.operands(k)) {
    if (!at.has(j)) continue;
    const [x1, y1] = at.get(j), [x2, y2] = at.get(k), from = x1 + WIDTH - 40, middle = (from + x2) / 2;
    const hot = state.last(k) === j && state.slacks[k] === state.slacks[j];
    drawing.append(svg("path", { class: "edge" + (hot ? " critical" : ""), d: `M${from} ${y1 + 16}C${middle} ${y1 + 16} ${middle} ${y2 + 16} ${x2} ${y2 + 16}` }));
  }
  for (const [k, [x, y]] of at) {
    const name = state.name(k), text = state.text(k);
    const group = svg("g", { class: "node" + (state.slacks[k] ? "" : " critical") + (k === centre ? " chosen" : ""), tabindex: "0", transform: `translate(${x} ${y})` },
      svg("title", {}, document.createTextNode(`${name} = ${text}\navailable at cycle ${state.arrivals[k]}, slack ${state.slacks[k]}`)),
      svg("rect", { width: WIDTH - 40, height: 32, rx: 3 }),
      svg("text", { x: 6, y: 13 }, document.createTextNode(clip(name, 14) + "  @" + state.arrivals[k])),
      svg("text", { x: 6, y: 27 }, document.createTextNode(clip(text, 20))));
    group.addEventListener("click", () => page.choose(s, k));
    drawing.append(group);
  }
  const steps = el("select", { "aria-label": "depth", onchange: event => page.go({ d: event.target.value }) },
    ...[1, 2, 3, 4, 6, 8, 12].map(value => el("option", { value, selected: value === depth }, String(value))));
  return [el("div", { class: "bar" }, el("label", null, "operations back ", steps), el("span", { class: "caption" }, `${columns.size} statements` + (columns.size >= most ? ", no more are drawn" : "") + "; red: on a longest path, or the operand that comes last")),
    el("div", { class: "drawing" }, drawing)];
}
function clip(text, most) { return text.length > most ? text.slice(0, most - 1) + "…" : text; }
