// The page shows what `robovec explore --plan` computed; nothing is fetched. Figures
// are drawn already, tables are filled and have what all pages give them; this
// file adds verdicts of other models, and a chart of one's own choice.
const data = JSON.parse(document.getElementById("data").textContent);
const clock = `${data.mhz} MHz (${data.clock_origin})`;
const byId = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";
const draw = (name, attributes, text) => {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
};
const short = (value) =>
  value >= 100 ? Math.round(value).toLocaleString("en-US").replaceAll(",", "\u202f") : String(+value.toPrecision(3));

// The verdicts of another model.
const cards = byId("cards");
const cpuSentence = (verdict) => {
  const found = data.cpu.find((cpu) => cpu.model === verdict.model && cpu.pipeline === verdict.pipeline);
  if (!found) return "Time of the same function on one CPU core: not measured; run the study with --cpu.";
  if (found.microseconds === null) return `One CPU core: ${found.remark}.`;
  const best = verdict.knee.cheapest ?? verdict.knee.fastest;
  const own = best && best.cycles / data.mhz;
  const ratio = own && found.microseconds / own;
  const relation = !own ? "" : ratio >= 1
    ? ` The elements take ${own.toFixed(2)} µs at ${clock}, ${ratio.toFixed(1)} times as fast.`
    : ` The elements take ${own.toFixed(2)} µs at ${clock}: the core is ${(1 / ratio).toFixed(1)} times as fast.`;
  return `The same function on one core of ${found.processor}: ${found.microseconds.toFixed(2)} µs in double precision (${found.compiler}).${relation}`;
};
// One line per kind of equations and pipeline of the same system.
function inShort(verdicts) {
  const rows = verdicts.map((verdict) => {
    const best = verdict.knee.cheapest ?? verdict.knee.fastest;
    const core = data.cpu.find((cpu) => cpu.model === verdict.model && cpu.pipeline === verdict.pipeline)?.microseconds;
    const number = (value) => make("td", { class: "n" }, value === undefined || value === null ? "" : value.toFixed(2));
    return make("tr", {},
      make("td", {}, verdict.formulation), make("td", {}, verdict.pipeline),
      make("td", {}, best ? `${verdict.knee.cheapest ? "" : "more than "}${best.n_add + best.n_multi} = ${best.n_add} adders + ${best.n_multi} multipliers` : ""),
      number(best && best.cycles / data.mhz), number(core));
  });
  const heads = ["equations", "pipeline", "useful processing elements", `time with them at ${clock} (µs)`, "one CPU core (µs)"];
  const head = make("thead", {}, make("tr", {}, ...heads.map((text) => make("th", {}, text))));
  return make("table", {}, head, make("tbody", {}, ...rows));
}
function showVerdicts(model) {
  const list = data.verdicts.filter((verdict) => verdict.model === model);
  // The verdicts of this model follow as cards; a table compares them with others only.
  const same = data.verdicts.filter((verdict) => verdict.system === list[0]?.system);
  byId("short").replaceChildren(...(same.length > list.length ? [inShort(same)] : []));
  cards.replaceChildren(...list.map((verdict) => {
    const zones = make("table", { class: "zones" }, make("tbody", {},
      ...verdict.zones.map((zone) => make("tr", {}, ...zone.map((text) => make("td", {}, text))))));
    return make("div", { class: "card" },
      make("h3", {}, `${verdict.model}, ${verdict.pipeline}: `, make("code", {}, data.pipelines[verdict.pipeline])),
      make("p", { class: "answer" }, verdict.answer),
      make("p", {}, verdict.cost),
      make("ul", {}, ...verdict.reasons.map((reason) => make("li", {}, reason))),
      zones,
      make("p", { class: "cpu" }, cpuSentence(verdict)));
  }));
}
const chooser = byId("verdict-model");
chooser.replaceChildren(...[...new Set(data.verdicts.map((verdict) => verdict.model))].map((name) => make("option", {}, name)));
chooser.addEventListener("change", () => {
  address.set("verdict", chooser.value);
  showVerdicts(chooser.value);
});
if (data.verdicts.some((verdict) => verdict.model === address.get("verdict"))) chooser.value = address.get("verdict");
if (data.verdicts.length) showVerdicts(chooser.value);

// Figures by words of their titles.
const findFigures = (text) => {
  const words = text.toLowerCase().split(/\s+/);
  for (const figure of document.querySelectorAll("#figures figure")) {
    const content = figure.textContent.toLowerCase();
    figure.hidden = !words.every((word) => content.includes(word));
  }
};
byId("find").value = address.get("find");
findFigures(byId("find").value);
byId("find").addEventListener("input", (event) => {
  address.set("find", event.target.value.trim());
  findFigures(event.target.value);
});

// A chart of one's own choice.
const QUANTITIES = {
  "time (µs)": { value: (p) => p.time_us, log: true },
  "cycles": { value: (p) => p.cycles, log: true },
  "parallelisation rate (%)": { value: (p) => 100 * p.rate, to: 100 },
  "adders busy (%)": { value: (p) => 100 * p.busy[0], to: 100 },
  "multipliers busy (%)": { value: (p) => 100 * p.busy[1], to: 100 },
  "memory of an adder (words)": { value: (p) => p.memory[0] },
  "memory of a multiplier (words)": { value: (p) => p.memory[1] },
  "buffer of an adder (words)": { value: (p) => p.buffer[0] },
  "buffer of a multiplier (words)": { value: (p) => p.buffer[1] },
};
const COLOURS = ["#0072b2", "#c44e00", "#00805e", "#a3528a", "#000000", "#9a7400", "#3b8fc4", "#7a3d00", "#5b5bd6", "#777777"];
const MOST_CURVES = COLOURS.length;
const usual = data.points.filter((p) => p.priority === "best" && p.choice === "preferential" && !p.failure);
let emphasised = null;

function boxes(id, names, chosen) {
  byId(id).append(...names.map((name) => {
    const box = make("input", { type: "checkbox", value: name });
    const kept = address.get(id);
    box.checked = kept ? kept.split("|").includes(name) : chosen(name);
    box.addEventListener("change", () => {
      address.set(id, checked(id).join("|"));
      redraw();
    });
    return make("label", {}, box, ` ${name}`);
  }));
}
const checked = (id) => [...byId(id).querySelectorAll("input:checked")].map((box) => box.value);

function selectedCurves() {
  const [models, pipelines, machines] = ["models", "pipelines", "machines"].map(checked);
  const [low, high] = [+byId("low").value || 0, +byId("high").value || Infinity];
  const curves = new Map();
  for (const point of usual) {
    const total = point.n_add + point.n_multi;
    if (!models.includes(point.model) || !pipelines.includes(point.pipeline) || !machines.includes(point.machine)) continue;
    if (total < low || total > high || (!byId("unequal").checked && point.n_add !== point.n_multi)) continue;
    const names = [[models, point.model], [pipelines, point.pipeline], [machines, point.machine]];
    const label = names.filter(([list]) => list.length > 1).map(([, name]) => name).join(", ") || point.model;
    if (!curves.has(label)) curves.set(label, []);
    curves.get(label).push(point);
  }
  for (const points of curves.values()) points.sort((a, b) => a.n_add + a.n_multi - b.n_add - b.n_multi || a.cycles - b.cycles);
  if (byId("unequal").checked) {
    // Of all splits of a number the best one is drawn.
    for (const [label, points] of curves) {
      const total = (p) => p.n_add + p.n_multi;
      curves.set(label, points.filter((p, index) => index === 0 || total(points[index - 1]) !== total(p)));
    }
  }
  return [...curves];
}

function redraw() {
  const name = byId("quantity").value;
  const quantity = QUANTITIES[name];
  const all = selectedCurves();
  const curves = all.slice(0, MOST_CURVES);
  const remark = all.length > MOST_CURVES ? `The first ${MOST_CURVES} of ${all.length} curves are drawn.` : "";
  byId("remark").textContent = curves.length ? remark : "Nothing was computed for this choice.";
  byId("chart").replaceChildren(...(curves.length ? [chart(curves, name, quantity)] : []));
  fillTable(all.flatMap(([, points]) => points));
}

function chart(curves, name, quantity) {
  const [width, height, left, top, right, bottom] = [980, 420, 64, 14, 250, 50];
  const svg = draw("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": name });
  const points = curves.flatMap(([, list]) => list);
  const cpu = name.startsWith("time") ? data.cpu.filter((c) => c.microseconds !== null && curves.some(([, list]) => list.some((p) => p.model === c.model && p.pipeline === c.pipeline))) : [];
  const values = points.map(quantity.value).concat(cpu.map((c) => c.microseconds));
  const totals = points.map((p) => p.n_add + p.n_multi);
  const x = scale(Math.min(...totals), Math.max(...totals), true, 2, left, width - right);
  const least = quantity.log ? Math.min(...values) : 0;
  const y = scale(least, quantity.to ?? Math.max(...values, least + 1e-9), quantity.log, 10, height - bottom, top);
  const frame = { x: left, y: top, width: width - left - right, height: height - top - bottom, class: "frame" };
  for (const tick of x.ticks) {
    svg.append(draw("line", { x1: x(tick), x2: x(tick), y1: top, y2: height - bottom, class: "grid" }));
    svg.append(draw("text", { x: x(tick), y: height - bottom + 16, "text-anchor": "middle" }, short(tick)));
  }
  for (const tick of y.ticks) {
    svg.append(draw("line", { x1: left, x2: width - right, y1: y(tick), y2: y(tick), class: "grid" }));
    svg.append(draw("text", { x: left - 6, y: y(tick) + 4, "text-anchor": "end" }, short(tick)));
  }
  svg.append(draw("rect", frame));
  svg.append(draw("text", { x: left + frame.width / 2, y: height - 12, "text-anchor": "middle", class: "axis" }, "processing elements, adders + multipliers"));
  svg.append(draw("text", { transform: `translate(14 ${top + frame.height / 2}) rotate(-90)`, "text-anchor": "middle", class: "axis" }, name));
  const ends = curves.map(([label, list], index) => {
    const colour = COLOURS[index];
    const group = draw("g", { class: `curve${emphasised && emphasised !== label ? " faded" : ""}` });
    const place = (p) => [x(p.n_add + p.n_multi), y(quantity.value(p))];
    group.append(draw("polyline", { points: list.map((p) => place(p).join(",")).join(" "), fill: "none", stroke: colour, "stroke-width": 1.8 }));
    for (const point of list) {
      const [cx, cy] = place(point);
      const mark = draw("circle", { cx, cy, r: 4, stroke: colour, "stroke-width": 1.4, fill: { parallelisation: colour, transition: `${colour}66`, saturation: "#fff" }[point.zone] ?? colour });
      mark.dataset.tip = describe(point);
      group.append(mark);
    }
    group.addEventListener("click", () => { emphasised = emphasised === label ? null : label; redraw(); });
    svg.append(group);
    return { label, colour, group, at: place(list.at(-1)) };
  });
  for (const core of cpu) {
    const height = y(core.microseconds);
    svg.append(draw("line", { x1: left, x2: width - right, y1: height, y2: height, stroke: "#666", "stroke-dasharray": "6 4" }));
    const label = `one CPU core: ${core.model}, ${core.pipeline}`;
    ends.push({ label, colour: "#666", group: svg, at: [width - right, height] });
  }
  ends.sort((a, b) => a.at[1] - b.at[1]);
  let last = top - 8;
  for (const end of ends) {
    last = Math.max(end.at[1], last + 13);
    const route = `${end.at[0] + 6},${end.at[1]} ${width - right + 5},${end.at[1]} ${width - right + 14},${last}`;
    end.group.append(draw("polyline", { points: route, fill: "none", stroke: "#aaa", "stroke-width": 0.6 }));
    end.group.append(draw("text", { x: width - right + 17, y: last + 4, style: `fill:${end.colour}` }, end.label));
  }
  return svg;
}

// A scale from values to pixels, with its marks.
function scale(low, high, isLog, base, from, to) {
  if (isLog) {
    low = Math.max(low, 1e-9) / 1.08;
    high = Math.max(high, low * 1.2) * 1.08;
  }
  const turn = isLog ? Math.log : (value) => value;
  const place = (value) => from + ((turn(Math.max(value, isLog ? 1e-9 : -Infinity)) - turn(low)) / (turn(high) - turn(low))) * (to - from);
  place.ticks = [];
  if (isLog && base === 2) for (let tick = 1; tick <= high; tick *= 2) place.ticks.push(tick);
  else if (isLog) for (let decade = 1e-3; decade <= high; decade *= 10) place.ticks.push(decade, 2 * decade, 5 * decade);
  else {
    const raw = (high - low) / 5;
    const decade = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((factor) => factor * decade >= raw) * decade;
    for (let tick = Math.ceil(low / step) * step; tick <= high * 1.0001; tick += step) place.ticks.push(+tick.toPrecision(10));
  }
  place.ticks = place.ticks.filter((tick) => tick >= low && tick <= high * 1.0001);
  return place;
}

const describe = (p) => [
  `${p.model}, ${p.pipeline}, ${p.machine}`,
  `${p.n_add} adders + ${p.n_multi} multipliers`,
  `${p.cycles} cycles (bound ${p.lower_bound}), ${p.time_us.toFixed(3)} µs`,
  `${(100 * p.rate).toFixed(1)} % of all issue slots used`,
  `${p.zone} zone`,
].join("\n");

const COLUMNS = [
  ["model", (p) => p.model], ["pipeline", (p) => p.pipeline], ["machine", (p) => p.machine],
  ["adders", (p) => p.n_add], ["multipliers", (p) => p.n_multi], ["cycles", (p) => p.cycles],
  ["lower bound", (p) => p.lower_bound], ["time (µs)", (p) => p.time_us.toFixed(3)],
  ["rate (%)", (p) => (100 * p.rate).toFixed(1)], ["zone", (p) => p.zone],
];
function fillTable(points) {
  const head = make("thead", {}, make("tr", {}, ...COLUMNS.map(([name]) => make("th", {}, name))));
  const cell = (value) => make("td", isNaN(parseFloat(value)) ? {} : { class: "n" }, String(value));
  const body = make("tbody", {}, ...points.map((p) => make("tr", {}, ...COLUMNS.map(([, get]) => cell(get(p))))));
  const table = make("table", {}, head, body);
  byId("selection").replaceChildren(table);
  sortable(table, "selection");
}

const names = (key) => [...new Set(usual.map((p) => p[key]))];
boxes("models", names("model"), (name) => name === data.headline);
boxes("pipelines", names("pipeline"), () => true);
boxes("machines", names("machine"), (name) => name === data.machine);
byId("quantity").append(...Object.keys(QUANTITIES).map((name) => make("option", {}, name)));
for (const id of ["quantity", "low", "high", "unequal"]) {
  const control = byId(id);
  const kept = address.get(id);
  if (control.type === "checkbox") control.checked = kept === "yes";
  else if (kept) control.value = kept;
  control.addEventListener("change", () => {
    address.set(id, control.type === "checkbox" ? (control.checked ? "yes" : "") : control.value);
    redraw();
  });
}
redraw();
