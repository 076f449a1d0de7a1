// What is looked at stands in the address, so that a view can be kept, sent
// and gone back to.

const TABS = [["late", "Outputs", lateTab], ["passes", "Passes", passesTab], ["path", "Longest path", pathTab], ["graph", "Graph", graphTab],
  ["schedule", "Schedule", scheduleTab], ["source", "Source", sourceTab], ["report", "Report", page => [el("pre", null, page.fn.report)]]];

const page = {
  span: null,
  line: null,
  read() {
    const given = new URLSearchParams(location.hash.slice(1));
    this.fn = FUNCTIONS[Math.min(Number(given.get("f")) || 0, FUNCTIONS.length - 1)];
    const last = this.fn.end.number;
    // A page that is opened shows what changed most.
    const first = [...given.keys()].every(key => key === "f");
    this.state = given.has("s") ? Math.min(Math.max(0, Number(given.get("s")) || 0), last) : first ? this.fn.mostChanged() : last;
    this.tab = TABS.find(([name]) => name === (given.get("tab") || (first ? "passes" : ""))) || TABS[0];
    this.name = given.get("v") || "";
    this.query = given.get("q") || "";
    this.only = given.get("only") === "1";
    this.file = given.has("file") ? Number(given.get("file")) : -1;
    this.at = Number(given.get("at")) || 0;
    this.depth = Number(given.get("d")) || 4;
  },
  // Changes what is looked at; an empty word takes one away.
  go(change) {
    const now = new URLSearchParams(location.hash.slice(1));
    for (const [key, value] of Object.entries(change)) if (value === "" || value === null) now.delete(key); else now.set(key, String(value));
    if (!("line" in change)) this.line = null;
    location.hash = now.toString();
  },
  // The number of the chosen statement in a state, or -1.
  statement(s) { return s < 0 || !this.name ? -1 : this.fn.states[s].find(this.name); },
  choose(s, i) { this.go({ s, v: this.fn.states[s].name(i) }); },
  chooseLine(file, line) { this.line = [file, line]; this.fill(); },
  latest(s) {
    const state = this.fn.states[s];
    let best = state.values < state.count ? state.values : 0;
    for (let i = state.values; i < state.count; i++) if (state.arrivals[i] > state.arrivals[best]) best = i;
    return best;
  },
  link(s, i) { return el("button", { class: "value", onclick: () => this.choose(s, i) }, this.fn.states[s].name(i)); },
  fill() { document.getElementById("story").replaceChildren(...story(this)); },
  show() {
    this.read();
    const tabs = TABS.map(tab => el("button", { role: "tab", id: "tab-" + tab[0], "aria-selected": String(tab === this.tab), onclick: () => this.go({ tab: tab[0] }) }, tab[1]));
    if (FUNCTIONS.length > 1) tabs.unshift(el("select", { "aria-label": "function", onchange: event => this.go({ f: event.target.value, s: "", v: "" }) },
      ...FUNCTIONS.map((fn, k) => el("option", { value: k, selected: fn === this.fn }, fn.name))));
    document.getElementById("tabs").replaceChildren(...tabs);
    document.getElementById("panel").replaceChildren(...this.tab[2](this).filter(part => part));
    this.fill();
  },
};

document.getElementById("title").textContent = `${DATA.title}: ${DATA.pipeline}`;
document.getElementById("subtitle").textContent = `robovec ${DATA.robovec}`;
document.getElementById("answer").replaceChildren(...FUNCTIONS.map(fn => el("p", { class: "answer" },
  `${FUNCTIONS.length > 1 ? fn.name + ": " : ""}longest path ${fn.states[0].path} \u2192 ${fn.end.path} cycles`,
  el("span", { class: "soft" }, fn.mostChanged() ? `, most of it by the pass ${fn.states[fn.mostChanged()].pass}` : ""))));
addEventListener("hashchange", () => page.show());
addEventListener("resize", () => { if (page.tab[0] === "schedule") page.show(); });
page.show();
