// The schedule: elements over cycles, transfers, memory. Drawn on a canvas, so
// that thousands of cycles can be moved and zoomed.

const ROW = 18, LEFT = 74, AXIS = 22, CHART = 46;

function colours() {
  const style = getComputedStyle(document.documentElement);
  const of = name => style.getPropertyValue("--" + name).trim();
  return { ink: of("ink"), soft: of("soft"), rule: of("rule"), ground: of("ground"), accent: of("accent"), hot: of("hot"), paper: of("paper") };
}

function scheduleTab(page) {
  const { fn } = page, plan = fn.schedule;
  if (!plan) return [el("p", null, "The last state has no schedule: end the pipeline with place.")];
  const elements = plan.elements.length;
  const span = page.span || [0, plan.cycles];
  const transfers = new Uint32Array(plan.cycles + 2);
  for (const [, cycle] of plan.writes) transfers[Math.min(cycle, plan.cycles)]++;
  const height = AXIS + elements * ROW + 10 + CHART + 10 + (plan.memory.length ? CHART * 2 + 10 : 0);
  const canvas = el("canvas", { style: `height:${height}px`, tabindex: "0", "aria-label": "schedule: elements over cycles" });
  const move = (from, to) => {
    const length = Math.min(plan.cycles, Math.max(8, to - from));
    const start = Math.min(Math.max(0, from), plan.cycles - length);
    span[0] = start; span[1] = start + length;
    page.span = span;
    draw();
  };
  const zoom = (factor, centre) => { const [from, to] = span; move(centre - (centre - from) * factor, centre + (to - centre) * factor); };
  const draw = () => drawSchedule(page, canvas, span, transfers, height);
  const cycleAt = event => span[0] + (event.offsetX - LEFT) / (canvas.clientWidth - LEFT) * (span[1] - span[0]);
  const hit = event => {
    const row = Math.floor((event.offsetY - AXIS) / ROW), cycle = Math.floor(cycleAt(event));
    if (row < 0 || row >= elements || event.offsetX < LEFT) return -1;
    let best = -1;
    const reach = (span[1] - span[0]) / canvas.clientWidth * 3;
    for (let i = 0; i < plan.element.length; i++)
      if (plan.element[i] === row && Math.abs(plan.cycle[i] - cycle) <= reach && (best < 0 || Math.abs(plan.cycle[i] - cycle) < Math.abs(plan.cycle[best] - cycle))) best = i;
    return best;
  };
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(event.deltaY > 0 ? 1.25 : 0.8, cycleAt(event)); }, { passive: false });
  let grabbed = null;
  canvas.addEventListener("pointerdown", event => { grabbed = [event.offsetX, span[0], span[1], false]; });
  canvas.addEventListener("pointermove", event => {
    if (grabbed && event.buttons) {
      const moved = (event.offsetX - grabbed[0]) / (canvas.clientWidth - LEFT) * (grabbed[2] - grabbed[1]);
      if (Math.abs(event.offsetX - grabbed[0]) > 3) grabbed[3] = true;
      move(grabbed[1] - moved, grabbed[2] - moved);
      return;
    }
    const i = hit(event);
    tip(event, i < 0 ? "" : `${fn.end.name(i)} = ${fn.end.text(i)}\n${plan.elements[plan.element[i]]}, cycle ${plan.cycle[i]}, readable from ${plan.cycle[i] + plan.delay[i]}\n${fn.why(i)}`);
  });
  canvas.addEventListener("pointerup", event => {
    const dragged = grabbed && grabbed[3];
    grabbed = null;
    const i = dragged ? -1 : hit(event);
    if (i >= 0) page.choose(fn.end.number, i);
  });
  canvas.addEventListener("pointerleave", event => tip(event, ""));
  canvas.addEventListener("keydown", event => {
    const length = span[1] - span[0];
    const keys = { ArrowLeft: () => move(span[0] - length / 4, span[1] - length / 4), ArrowRight: () => move(span[0] + length / 4, span[1] + length / 4),
      "+": () => zoom(0.5, (span[0] + span[1]) / 2), "-": () => zoom(2, (span[0] + span[1]) / 2) };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  queueMicrotask(draw);
  const i = page.statement(fn.end.number);
  const button = (text, what) => el("button", { onclick: what }, text);
  const issued = plan.element.filter(element => element >= 0).length;
  return [el("div", { class: "bar" }, button("zoom in", () => zoom(0.5, (span[0] + span[1]) / 2)), button("zoom out", () => zoom(2, (span[0] + span[1]) / 2)),
    button("all", () => move(0, plan.cycles)), i >= 0 && i < fn.end.values && plan.element[i] >= 0 ? button("to " + fn.end.name(i), () => move(plan.cycle[i] - 40, plan.cycle[i] + 40)) : null,
    el("span", { class: "legend" }, el("span", { style: "background:var(--soft)" }), "operation", el("span", { style: "background:var(--hot)" }), "on a longest path", el("span", { style: "background:var(--accent)" }), "chosen, and what it waited for")),
    el("p", { class: "caption" }, `${plan.cycles} cycles on ${fn.machine}, no schedule is shorter than ${plan.bound}; ${percent(issued / (plan.cycles * elements))} of all issue slots is used. The wheel zooms, dragging moves; an operation tells why it waited.`), canvas];
}

// The operations that a scheduled value waited for, one after the other.
function waited(fn, i) {
  const found = new Set();
  for (let k = i; k >= 0 && !found.has(k); k = fn.schedule.last[k]) found.add(k);
  return found;
}

function drawSchedule(page, canvas, [from, to], transfers, height) {
  const { fn } = page, plan = fn.schedule, ink = colours();
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth;
  if (width === 0) return;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const paint = canvas.getContext("2d");
  paint.scale(ratio, ratio);
  paint.font = "11px sans-serif";
  const x = cycle => LEFT + (cycle - from) / (to - from) * (width - LEFT);
  const unit = (width - LEFT) / (to - from);
  axis(paint, x, from, to, height, ink);
  plan.elements.forEach((name, row) => {
    paint.fillStyle = row % 2 ? ink.paper : ink.ground;
    paint.fillRect(LEFT, AXIS + row * ROW, width - LEFT, ROW);
    paint.fillStyle = ink.ink;
    paint.fillText(name, 4, AXIS + row * ROW + 13);
  });
  const i = page.statement(fn.end.number);
  const value = i >= fn.end.values ? fn.end.last(i) : i;
  const chain = value >= 0 ? waited(fn, value) : new Set();
  const bar = k => { paint.fillRect(x(plan.cycle[k]), AXIS + plan.element[k] * ROW + 2, Math.max(1, unit - (unit > 4 ? 1 : 0)), ROW - 4); };
  const seen = k => plan.element[k] >= 0 && plan.cycle[k] >= from - 1 && plan.cycle[k] <= to;
  for (let k = 0; k < plan.element.length; k++) if (seen(k) && !chain.has(k)) { paint.fillStyle = fn.end.slacks[k] ? ink.soft : ink.hot; bar(k); }
  paint.fillStyle = ink.accent;
  for (const k of chain) if (seen(k)) { bar(k); paint.fillRect(x(plan.cycle[k]), AXIS + plan.element[k] * ROW + ROW - 3, Math.max(1, unit * plan.delay[k]), 2); }
  if (unit > 34) for (let k = 0; k < plan.element.length; k++) if (seen(k)) { paint.fillStyle = ink.paper; paint.fillText(clip(fn.end.name(k), Math.floor(unit / 7)), x(plan.cycle[k]) + 2, AXIS + plan.element[k] * ROW + 13); }
  let top = AXIS + plan.elements.length * ROW + 10;
  chart(paint, "transfers", [[transfers, 1]], { x, from, to, top, high: CHART, width, ink });
  if (plan.memory.length) {
    top += CHART + 10;
    chart(paint, "words", plan.memory.map(words => [words, plan.slice]), { x, from, to, top, high: CHART * 2, width, ink });
  }
}

function axis(paint, x, from, to, height, ink) {
  const step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 50000].find(step => (to - from) / step < 14) || 100000;
  for (let cycle = Math.ceil(from / step) * step; cycle <= to; cycle += step) {
    paint.fillStyle = ink.rule;
    paint.fillRect(x(cycle), AXIS - 4, 1, height);
    paint.fillStyle = ink.soft;
    paint.fillText(String(cycle), x(cycle) + 2, 12);
  }
  paint.fillText("cycle", 4, 12);
}

// Curves over cycles with their largest value; each list has an entry per slice.
function chart(paint, title, curves, { x, from, to, top, high, width, ink }) {
  const most = Math.max(1, ...curves.map(([list]) => list.reduce((a, b) => Math.max(a, b), 0)));
  paint.fillStyle = ink.soft;
  paint.fillText(title, 4, top + 12);
  paint.fillText("at most " + most, 4, top + 26);
  paint.strokeStyle = ink.rule;
  paint.strokeRect(LEFT, top, width - LEFT, high);
  curves.forEach(([list, slice], number) => {
    paint.strokeStyle = curves.length === 1 ? ink.accent : `hsl(${Math.round(360 * number / curves.length)} 60% 50%)`;
    paint.beginPath();
    for (let k = Math.max(0, Math.floor(from / slice) - 1); k < list.length && k * slice <= to; k++) {
      const y = top + high - list[k] / most * (high - 4);
      paint.lineTo(Math.max(LEFT, x(k * slice)), y);
      paint.lineTo(Math.max(LEFT, x((k + 1) * slice)), y);
    }
    paint.stroke();
  });
}

function tip(event, text) {
  const box = document.getElementById("tip");
  box.style.display = text ? "block" : "none";
  box.textContent = text;
  box.style.left = Math.min(event.clientX + 14, innerWidth - 330) + "px";
  box.style.top = Math.min(event.clientY + 14, innerHeight - 100) + "px";
}
