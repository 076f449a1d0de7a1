// What the page holds, and what follows from it: operands, readers, the chain
// that makes a value late, the states it went through. A statement is named by
// its number in its state; values stand before outputs.

const DATA = JSON.parse(document.getElementById("data").textContent);
const NAME = /%[^\s()*+,\/-]+/g;

class State {
  constructor(data, number) {
    Object.assign(this, data);
    this.number = number;
    this.count = this.names.length;
  }
  name(i) { return DATA.texts[this.names[i]]; }
  text(i) { return DATA.texts[this.texts[i]]; }
  places(i) { return DATA.sources[this.sources[i]]; }
  isOutput(i) { return i >= this.values; }
  rule(i) { return (this.rules[i] || []).map(rule => DATA.texts[rule]); }
  find(name) {
    if (!this.numbers) {
      this.numbers = new Map();
      for (let i = 0; i < this.count; i++) this.numbers.set(this.name(i), i);
    }
    const found = this.numbers.get(name);
    return found === undefined ? -1 : found;
  }
  operands(i) {
    const found = [];
    for (const name of this.text(i).match(NAME) || []) {
      const operand = this.find(name);
      if (operand >= 0 && !found.includes(operand)) found.push(operand);
    }
    return found;
  }
  readers(i) {
    if (!this.readBy) {
      this.readBy = Array.from({ length: this.count }, () => []);
      for (let k = 0; k < this.count; k++) for (const j of this.operands(k)) this.readBy[j].push(k);
    }
    return this.readBy[i];
  }
  // The operand that comes last, or -1.
  last(i) {
    let last = -1;
    for (const j of this.operands(i)) if (last < 0 || this.arrivals[j] > this.arrivals[last]) last = j;
    return last;
  }
  // From the first operation to a statement, each the last operand of the next.
  chain(i) {
    const chain = [];
    for (let k = i; k >= 0; k = this.last(k)) chain.push(k);
    return chain.reverse();
  }
  // The statement with the values of its own equation written out, to a depth.
  written(i, depth = 6) {
    const base = this.name(i).replace(/\.\d+$/, "").replace(/^%/, "");
    const symbol = base.replace(/[\[,]/g, "_").replace(/\]/g, "");
    return this.text(i).replace(NAME, name => {
      const own = name.slice(1).replace(/\.\d+$/, "");
      const j = this.find(name);
      if (depth === 0 || j < 0 || (own !== base && own !== symbol) || this.readers(j).length !== 1) return name;
      const inner = this.written(j, depth - 1);
      return /[ +-]/.test(inner) ? "(" + inner + ")" : inner;
    });
  }
}

class Fn {
  constructor(data) {
    Object.assign(this, data);
    this.states = data.states.map((state, number) => new State(state, number));
    this.end = this.states[this.states.length - 1];
    this.heats = new Map(data.heat.map(([file, line, share]) => [file + ":" + line, share]));
  }
  // The state after the pass that shortened the longest path most, or changed
  // most statements where none did.
  mostChanged() {
    if (this.best !== undefined) return this.best;
    const measure = k => {
      const [before, after] = [this.states[k - 1], this.states[k]];
      return [before.path - after.path, Math.abs(before.count - after.count)];
    };
    this.best = 0;
    let most = [0, 0];
    for (let k = 1; k < this.states.length; k++) {
      const [path, count] = measure(k);
      if (path > most[0] || (path === most[0] && count > most[1])) [this.best, most] = [k, [path, count]];
    }
    return this.best;
  }
  // The states of a statement, the last first: statement i of state s, then
  // what that was made from, back to what was read.
  ancestry(s, i) {
    const steps = [];
    while (i >= 0 && s >= 0) {
      steps.push([s, i]);
      i = this.states[s].origins[i];
      s -= 1;
    }
    return steps;
  }
  // The passes that made a statement what it is, each with the rules it
  // applied.
  madeBy(s, i) {
    const found = [];
    const ancestry = this.ancestry(s, i).reverse();
    ancestry.forEach(([is, now], k) => {
      const state = this.states[is], rules = state.rule(now);
      if (state.pass === null) return;
      const old = k > 0 && this.states[ancestry[k - 1][0]];
      const same = old && old.name(ancestry[k - 1][1]) === state.name(now) && old.text(ancestry[k - 1][1]) === state.text(now);
      if (!same || rules.length) found.push([state.pass, rules]);
    });
    return found;
  }
  // Why a value starts when it does.
  why(i) {
    const plan = this.schedule;
    if (plan.element[i] < 0) return "computed by the host before the run";
    const cycle = plan.cycle[i], ready = plan.ready[i], free = plan.free[i];
    const kind = plan.elements[plan.element[i]].replace(/\d+$/, "");
    const last = plan.last[i] < 0 ? "its operands are there from the start" :
      `${this.end.name(plan.last[i])}, the last of its operands, can be read from cycle ${ready}`;
    if (cycle === ready) return plan.last[i] < 0 ? last : `${last}: it starts at once`;
    if (free === cycle) return `${last}, but every ${kind} was busy until cycle ${cycle}`;
    return `${last}, and some ${kind} was free at cycle ${free}; it was put off, since ` +
      (this.end.slacks[i] ? `it may be ${this.end.slacks[i]} cycles late without lengthening the longest path` :
        "reads or writes of memories were taken");
  }
}

const FUNCTIONS = DATA.functions.map(data => new Fn(data));

function lineOf([file, line]) {
  const lines = DATA.files[file].lines;
  return lines && lines[line - 1] !== undefined ? lines[line - 1].trim() : "";
}
function placeText([file, line]) { return `${DATA.files[file].name}:${line}`; }
function small(number) { return number === null || number === undefined ? "-" : number === 0 ? "0" : number.toExponential(1); }
function percent(share) { return (100 * share).toFixed(share < 0.0995 ? 2 : 1) + " %"; }

function el(tag, given, ...children) {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(given || {})) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== false) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter(child => child !== undefined && child !== null));
  return element;
}
