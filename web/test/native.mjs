// Runs the programs in WebAssembly and as native ones on the same files and
// compares everything they write: node native.mjs PROGRAM.wasm PROGRAMS, the
// latter the folder of the native programs.

import { spawnSync } from "node:child_process";
import { closeSync, copyFileSync, mkdtempSync, openSync, readdirSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join, resolve } from "node:path";
import { WASI } from "node:wasi";

const [program, natives] = process.argv.slice(2).map((path) => resolve(path));
const module = await WebAssembly.compile(readFileSync(program));
const top = resolve(import.meta.dirname, "../..");
const under = (folder, ends) => readdirSync(join(top, folder), { recursive: true })
  .filter((name) => ends.some((end) => name.endsWith(end))).sort().map((name) => join(top, folder, name));

async function inWasm(args, cwd, streams) {
  const [stdout, stderr] = ["out", "err"].map((name) => openSync(join(streams, name), "w"));
  const wasi = new WASI({ version: "preview1", args, env: {}, preopens: { ".": cwd }, stdin: openSync("/dev/null"), stdout, stderr, returnOnExit: true });
  let status;
  try {
    status = wasi.start(await WebAssembly.instantiate(module, wasi.getImportObject()));
  } catch (error) {
    status = String(error);
  }
  closeSync(stdout);
  closeSync(stderr);
  return { status, stdout: readFileSync(join(streams, "out")), stderr: readFileSync(join(streams, "err")) };
}

function native([name, ...args], cwd) {
  return spawnSync(join(natives, name), args, { cwd, env: {}, maxBuffer: 1 << 30 });
}

// All that a call left, by name.
function left(folder) {
  const names = readdirSync(folder, { recursive: true }).sort();
  return names.filter((name) => statSync(join(folder, name)).isFile()).map((name) => [name, readFileSync(join(folder, name))]);
}

// What may differ: errors in binary64, which are measured with the sines of
// the system's library, numbers of the system's errors, and the progress of
// long runs, which WebAssembly does not print; counts end at 2^32.
const common = (data) => data.toString().replace(/error in f64: [^;\n]*/g, "error in f64")
  .replace(/\(os error \d+\)/g, "").replace(/^\d+ s: .*\n/gm, "")
  .replace(/arrays: \d{10,} is not/g, "arrays: too many is not");
// Of robots moreover the last digits of what is made of their angles.
const rounded = (text) => text.replace(/\d+\.\d+(e[-+]?\d+)?/g, (number) => Number(number).toPrecision(12));
let calls = 0, bytes = 0, excused = 0, differences = 0;

// Runs one command both ways on copies of files.
async function compare(args, files) {
  const folders = [0, 1, 2].map(() => mkdtempSync(join(tmpdir(), "playground-")));
  for (const file of files) for (const folder of folders.slice(0, 2)) copyFileSync(file, join(folder, basename(file)));
  const ours = await inWasm(args, folders[0], folders[2]), theirs = native(args, folders[1]);
  const [ourFiles, theirFiles] = [left(folders[0]), left(folders[1])];
  const what = [];
  const isRobot = files.some((file) => file.endsWith(".urdf"));
  const same = (name, mine, other) => {
    if (mine.equals(other)) return;
    const [a, b] = [mine, other].map((data) => isRobot ? rounded(common(data)) : common(data));
    if (a === b && (isRobot || name in ours)) excused += 1;
    else what.push(name);
  };
  if (ours.status !== theirs.status) what.push(`exit ${ours.status} and ${theirs.status}`);
  for (const stream of ["stdout", "stderr"]) same(stream, ours[stream], theirs[stream]);
  if (ourFiles.map(([name]) => name).join() !== theirFiles.map(([name]) => name).join()) what.push("names of files");
  else ourFiles.forEach(([name, data], k) => same(name, data, theirFiles[k][1]));
  calls += 1;
  bytes += theirs.stdout.length + theirs.stderr.length + theirFiles.reduce((sum, [, data]) => sum + data.length, 0);
  if (what.length > 0) {
    differences += 1;
    console.log(`DIFFERENT: ${args.join(" ")}: ${what.join(", ")}`);
    for (const stream of what.filter((name) => name in ours)) {
      const [mine, other] = [ours[stream], theirs[stream]].map((data) => data.toString().split("\n"));
      const line = mine.findIndex((text, k) => text !== other[k]);
      console.log(`  ${mine[line]}\n  ${other[line]}`);
    }
  }
  if (process.env.KEEP && what.length > 0) console.log(folders.join(" "));
  else for (const folder of folders) rmSync(folder, { recursive: true });
}

const models = [...under("examples/models", [".mbs"]), ...under("examples/robots", [".urdf"])];
const equations = under("examples/suspension", [".c", ".m", ".py"]);
const isLarge = (path) => /-(70|100|130)\.mbs$/.test(path);
const PIPELINES = ["$shorten", "$shorten,place", "$ahead,place", "$cpu,codegen{target=c}", "atomise,eqsat,cse,dce", "atomise,balance,cse,dce,accurate", "$shorten,trigonometry{order=5}"];
const opt = (file, passes, more = []) => compare(["robovec-opt", basename(file), `-passes=${passes}`, ...more, "-o", "out"], [file]);

for (const file of [...models, ...equations]) {
  await opt(file, "$shorten", isLarge(file) ? [] : ["--check-each"]);
  if (isLarge(file)) continue;
  for (const passes of PIPELINES.slice(1)) await opt(file, passes);
}
for (const file of models.filter((file) => !isLarge(file))) {
  for (const language of ["rvir", "c", "matlab", "python"]) await compare(["robovec", "gen", basename(file), "--function", "all", "--language", language, "-o", "out"], [file]);
  await compare(["robovec", "model", basename(file)], [file]);
  await compare(["robovec", "error", basename(file), "--passes", "$shorten", "--number", "f32,f16"], [file]);
}
const small = join(top, "examples/models/double-pendulum.mbs");
await opt(small, "$fpga");
await opt(small, "$shorten,place,codegen{target=rtl}", ["--machine", "side-split"]);
await opt(small, "$shorten,place", ["--simulate=4"]);
for (const file of under("examples/rounding", [".fpcore"])) await compare(["robovec", "error", basename(file), "--prove"], [file]);
const [before, after] = [".m", ".c"].map((end) => join(top, `examples/suspension/mbs_dirdyna_suspension${end}`));
await compare(["robovec", "check", basename(before), basename(after)], [before, after]);
for (const file of under("tests/errors", [".c", ".m", ".py", ".rvir"])) await compare(["robovec-opt", basename(file), "-passes=$shorten"], [file]);
for (const args of [["robovec-opt", "--list-passes"], ["robovec-opt", "--list-machines"], ["robovec-opt", "nothing.m"], ["robovec-opt", "-passes=nothing", "x.m"], ["robovec", "--help"]]) await compare(args, []);

console.log(`${calls} calls, ${(bytes / 1e6).toFixed(1)} MB written: ${differences} different, ${excused} only in what docs/playground.md names`);
process.exit(differences === 0 ? 0 : 1);
