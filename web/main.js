"use strict";
// The page: an input, a pipeline, and what the programs make of it. Every
// figure is from a program's output.

const $ = (id) => document.getElementById(id);
const el = (tag, properties, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const KINDS = [".mbs", ".m", ".c", ".py", ".rvir", ".urdf", ".xml"];
const MODELS = [".mbs", ".urdf", ".xml"];
const SHOWN = 400_000;
const EXAMPLES = JSON.parse($("examples").textContent);
const STOPPED = "stopped";

// ---- The worker: one call of a program after the other.

let module, worker, waiting = null, next = 0;

function newWorker() {
  worker?.terminate();
  const source = new Blob([$("worker").textContent], { type: "text/javascript" });
  const address = URL.createObjectURL(source);
  worker = new Worker(address);
  URL.revokeObjectURL(address);
  worker.onmessage = ({ data }) => { if (waiting?.id === data.id) waiting.resolve(data); };
  worker.onerror = (event) => {
    event.preventDefault();
    waiting?.resolve({ trap: event.message || "the worker ended", status: null, stdout: "", stderr: "", files: {}, milliseconds: 0 });
  };
}

function stop(reason) {
  newWorker();
  const asked = waiting;
  waiting = null;
  asked?.reject(new Error(reason));
}

// Runs a program; with files in a new folder that holds them, else in the one
// of the call before.
async function call(args, files) {
  const result = await new Promise((resolve, reject) => {
    waiting = { id: ++next, resolve, reject };
    worker.postMessage({ id: next, module, args, files });
  });
  waiting = null;
  if (result.trap !== null) newWorker();
  return { args, ...result };
}

async function unpack() {
  const text = atob($("program").textContent.trim());
  $("program").remove();
  const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  module = await WebAssembly.compile(await new Response(stream).arrayBuffer());
  newWorker();
}

// ---- The input.

let base = "input";

function take(name, text) {
  const end = KINDS.find((kind) => name.toLowerCase().endsWith(kind));
  base = (end ? name.slice(0, -end.length) : name).replace(/[^\w.-]/g, "_").replace(/^[.-]+/, "") || "input";
  if (end) $("kind").value = end;
  $("text").value = text;
}

const fileName = () => base + $("kind").value;

// Names and descriptions below a heading of a listing.
function listed(text, heading) {
  const lines = text.split("\n");
  const from = heading ? lines.indexOf(heading) + 1 : 0;
  const rest = lines.slice(from);
  const end = rest.findIndex((line) => line !== "" && heading && !line.startsWith(" "));
  const own = end < 0 ? rest : rest.slice(0, end);
  return own.map((line) => /^(?: {2})?(\S+) {2,}(\S.*)$/.exec(line)).filter((found) => found && found[1] !== "=").map((found) => [found[1], found[2]]);
}

function fill(select, first, entries) {
  const options = entries.map(([value, about]) => el("option", { value, title: about ?? "" }, value));
  select.replaceChildren(...(first === null ? [] : [el("option", { value: "" }, first)]), ...options);
}

async function learn() {
  const passes = await call(["robovec-opt", "--list-passes"], {});
  const machines = await call(["robovec-opt", "--list-machines"]);
  const version = await call(["robovec", "--version"]);
  if (passes.status !== 0) throw new Error(passes.trap ?? passes.stderr);
  const presets = listed(passes.stdout, "presets:"), known = listed(passes.stdout, "passes:");
  fill($("preset"), "choose", presets);
  fill($("pass"), "choose", known);
  fill($("machine"), null, listed(machines.stdout));
  $("machine").value = "thesis";
  $("preset").onchange = () => { $("passes").value = $("preset").value || $("passes").value; about(); };
  $("pass").onchange = () => {
    const written = $("passes").value.trim();
    $("passes").value = written + (written && $("pass").value ? "," : "") + $("pass").value;
    $("pass").value = "";
    about();
  };
  const about = () => {
    const last = $("passes").value.split(",").at(-1).replace(/\{.*/, "").trim();
    const found = [...presets, ...known].find(([name]) => name === last);
    $("about").textContent = found ? `${found[0]}: ${found[1]}` : "";
  };
  $("passes").oninput = about;
  about();
  $("version").textContent = version.stdout.trim() + ".";
}

// ---- A run.

let run = null;

const quoted = (word) => /^[\w./=,:@-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
const commandLine = (args) => args.map(quoted).join(" ");
const failed = (result) => result.status !== 0;

function trouble(result) {
  if (result.trap === null) return result.stderr;
  return `${result.stderr}\nThe program broke off: ${result.trap}.\nIt has 4 GB of memory at most here; larger problems want the program itself. The page goes on with a new one.`;
}

// The options that a run shares with its questions.
function options() {
  const wanted = $("function").value.trim();
  const passes = $("passes").value.trim();
  return [...(passes ? [`--passes=${passes}`] : []), ...($("machine").value ? ["--machine", $("machine").value] : []), ...(wanted ? ["--function", wanted] : [])];
}

async function start() {
  const name = fileName(), files = { [name]: $("text").value };
  run = { name, files, options: options(), calls: [], outputs: {}, report: null, tab: "Code", pages: {} };
  const mine = run;
  busy("compiling…");
  show();
  try {
    await compile(mine);
  } catch (error) {
    if (error.message !== STOPPED) throw error;
    mine.stopped = true;
  }
  busy(null);
  const total = mine.calls.reduce((sum, result) => sum + result.milliseconds, 0);
  $("state").textContent = mine.stopped ? "Stopped." : `${(total / 1000).toFixed(2)} s, programs called: ${mine.calls.length}.`;
  if (mine.calls.length > 0 && failed(mine.calls.at(-1)) && !mine.verdict) mine.tab = "Diagnostics";
  show();
}

async function compile(mine) {
  const ask = async (args, files) => {
    const result = await call(args, files);
    mine.calls.push(result);
    return result;
  };
  const made = await ask(["robovec-opt", mine.name, ...mine.options, "-o", "out"], mine.files);
  if (failed(made)) return;
  mine.outputs = made.files;
  mine.summary = made.stderr;
  show();
  busy("checking every pass…");
  const checked = await ask(["robovec-opt", mine.name, ...mine.options, "--check-each", "--report", "report.json", "-o", "checked"]);
  if (failed(checked)) return;
  mine.report = JSON.parse(checked.files["report.json"]);
  show();
  const kind = classOf(mine.report);
  if (!isText(mine) || kind === null) return;
  busy("comparing input and result…");
  let before = mine.name;
  if (MODELS.some((end) => before.endsWith(end))) {
    const wanted = $("function").value.trim();
    before = "before.rvir";
    const equations = await ask(["robovec", "gen", mine.name, ...(wanted ? ["--function", wanted] : []), "-o", before]);
    if (failed(equations)) return;
  }
  // Passes that make another function, such as derivatives, end in a no.
  mine.verdict = await ask(["robovec", "check", before, "out", "--class", kind]);
}

const isText = (mine) => mine.report.functions.every((f) => f.passes.every((pass) => !pass.name.startsWith("codegen")));

// The weakest class of all passes that `robovec check` knows; null where a
// pass approximates.
function classOf(report) {
  const classes = report.functions.flatMap((f) => f.passes.map((pass) => pass.check?.class));
  if (classes.includes("approximating") || classes.includes(undefined)) return null;
  return classes.includes("real-trig") ? "real-trig" : "real";
}

// ---- What is shown.

const small = (number) => number === 0 ? "0" : number.toExponential(1).replace("e+", "e");

function functionLines(f) {
  const lines = [];
  const checks = f.passes.map((pass) => pass.check).filter(Boolean);
  const rounded = f.passes.map((pass) => pass.rounding).filter(Boolean);
  if (checks.length > 0) {
    const measured = checks.filter((check) => check.result === "measured").length;
    const open = checks.find((check) => check.domain !== "same");
    const words = measured
      ? `${checks.length - measured} passes proved equal, ${measured} within its promise`
      : `proved equal after each of ${checks.length} passes`;
    lines.push(el("p", { className: "fine" }, `${f.name}: ${words}, at ${checks[0].points} random points of two prime fields` + (open ? `; domain ${open.domain}: ${open.condition}` : "") + "."));
  }
  if (rounded.length > 0) {
    const [first, last] = [rounded[0], rounded.at(-1)];
    const value = (side, key) => small(side[key] * first.unit);
    const pair = (key) => `${value(first.normwise.before, key)} → ${value(last.normwise.after, key)}`;
    lines.push(el("p", {}, `Error in binary32, of the largest element of an array: median ${pair("median")}, worst ${pair("worst")} (${first.states} random states).`));
  }
  return lines;
}

function answer() {
  const bad = run.calls.find((result) => failed(result) && result !== run.verdict);
  const cards = [];
  if (run.summary) {
    const lines = run.summary.split("\n").filter((line) => line.includes(" -> "));
    for (const line of lines) cards.push(el("p", { className: "answer" }, line.split("; error")[0].replaceAll("->", "→")));
    if (lines.length === 0) cards.push(el("p", { className: "answer" }, run.summary.split("\n")[0]));
  }
  cards.push(...(run.report?.functions ?? []).flatMap(functionLines));
  if (run.verdict) {
    const { stdout, stderr } = run.verdict;
    cards.push(el("p", { className: failed(run.verdict) ? "hard" : "fine" }, "Input against result: " + (stdout + stderr).trim()));
  }
  const parts = cards.length > 0 ? [el("div", { className: "card" }, ...cards)] : [];
  if (bad) parts.push(el("div", { className: "card failed" }, el("pre", { className: "bad" }, trouble(bad).trim())));
  $("answer").replaceChildren(...parts);
}

const TABS = { Code: code, Report: report, Error: error, View: view, Diagnostics: diagnostics };

function show() {
  answer();
  $("tabs").replaceChildren(...Object.keys(TABS).map((name) => {
    const open = () => { run.tab = name; show(); };
    const button = el("button", { type: "button", role: "tab", onclick: open }, name);
    button.setAttribute("aria-selected", name === run.tab);
    return button;
  }));
  $("panel").replaceChildren(...TABS[run.tab]());
}

function code() {
  const names = Object.keys(run.outputs).sort();
  if (names.length === 0) return [el("p", { className: "soft" }, "There is no result yet.")];
  if (!names.includes(run.file)) run.file = names[0];
  const text = run.outputs[run.file];
  const select = el("select", { onchange: () => { run.file = select.value; show(); } }, ...names.map((name) => el("option", { value: name }, shownName(name))));
  select.value = run.file;
  const save = el("button", { type: "button", onclick: () => download(shownName(run.file), text) }, "Save");
  const cut = text.length > SHOWN ? [el("p", { className: "soft" }, `The first ${SHOWN} of ${text.length} characters; Save has all.`)] : [];
  return [el("div", { className: "bar" }, select, save), ...cut, el("pre", { id: "code" }, text.slice(0, SHOWN))];
}

// A single result has the name of the input, with the end of its language.
function shownName(path) {
  if (path !== "out") return path.replace(/^out\//, "");
  const generated = run.report && !isText(run);
  return run.name.replace(/\.\w+$/, "") + (generated ? ".txt" : ".rvir");
}

function download(name, text) {
  const address = URL.createObjectURL(new Blob([text]));
  el("a", { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}

// A tab whose text a program makes when it is opened for the first time.
function asked(tab, args, made) {
  const page = run.pages[tab];
  if (page) return failed(page) ? [el("pre", { className: "bad" }, trouble(page).trim())] : made(page);
  if (!waiting && !run.stopped) ask(tab, args);
  return [el("p", { className: "soft" }, run.stopped ? "Stopped." : "Runs when the programs before it have ended…")];
}

async function ask(tab, args) {
  const mine = run;
  busy(`${args[0]}…`);
  try {
    mine.pages[tab] = await call(args, mine.files);
  } catch (problem) {
    if (problem.message !== STOPPED) throw problem;
    mine.pages[tab] = { args, status: 1, trap: null, stderr: "Stopped.", stdout: "", files: {}, milliseconds: 0 };
  }
  busy(null);
  mine.calls.push(mine.pages[tab]);
  $("state").textContent = `${(mine.pages[tab].milliseconds / 1000).toFixed(2)} s for ${tab}.`;
  if (mine === run) show();
}

const preformatted = (text) => [el("pre", {}, text.trim())];

function report() {
  const args = ["robovec-opt", run.name, ...run.options, "--check-each", "--report", "report.txt", "-o", "out"];
  return asked("Report", args, (page) => preformatted(page.files["report.txt"]));
}

function error() {
  return asked("Error", ["robovec", "error", run.name, ...run.options], (page) => preformatted(page.stdout));
}

function view() {
  return asked("View", ["robovec", "view", run.name, ...run.options, "-o", "view.html"], (page) => {
    const frame = el("iframe", { title: "The compilation", srcdoc: page.files["view.html"] });
    frame.setAttribute("sandbox", "allow-scripts");
    return [frame];
  });
}

function diagnostics() {
  return run.calls.flatMap((result) => [
    el("p", { className: "command" }, el("code", {}, commandLine(result.args)), ` exit ${result.status ?? "by a trap"}, ${(result.milliseconds / 1000).toFixed(2)} s`),
    ...(result.stderr || result.trap ? preformatted(trouble(result)) : []),
  ]);
}

function busy(text) {
  $("run").disabled = text !== null;
  $("stop").disabled = text === null;
  if (text) $("state").textContent = text;
}

// ---- The beginning.

function dropFiles() {
  const read = async (file) => { if (file) take(file.name, await file.text()); };
  $("file").onchange = () => read($("file").files[0]);
  addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("over"); });
  addEventListener("dragleave", () => document.body.classList.remove("over"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("over");
    read(event.dataTransfer.files[0]);
  });
}

async function begin() {
  fill($("example"), "choose", Object.keys(EXAMPLES).map((name) => [name]));
  fill($("kind"), null, KINDS.map((kind) => [kind]));
  $("example").onchange = () => { if ($("example").value) take($("example").value, EXAMPLES[$("example").value]); };
  $("example").value = Object.keys(EXAMPLES)[0];
  take($("example").value, EXAMPLES[$("example").value]);
  dropFiles();
  $("input").onsubmit = (event) => { event.preventDefault(); if (!$("run").disabled) start(); };
  $("stop").onclick = () => stop(STOPPED);
  await unpack();
  await learn();
  busy(null);
}

begin().catch((problem) => {
  $("state").textContent = `The program cannot run in this browser: ${problem.message}`;
  $("state").className = "bad";
});
