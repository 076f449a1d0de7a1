// Puts the page together: node build.mjs PROGRAM.wasm TOOLS PAGE.html, TOOLS
// being the folder where esbuild and the WASI shim are installed.

import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { gzipSync } from "node:zlib";
import { basename, join, resolve } from "node:path";

const [program, tools, page] = process.argv.slice(2).map((path) => resolve(path));
const top = resolve(import.meta.dirname, "..");
const read = (path) => readFileSync(join(top, path), "utf8");
const esbuild = createRequire(join(tools, "package.json"))("esbuild");

const EXAMPLES = [
  "examples/suspension/mbs_dirdyna_suspension.m",
  "examples/models/bogie.mbs",
  "examples/models/double-pendulum.mbs",
  "examples/robots/arm.urdf",
  "tests/passes/balance/cascade.rvir",
];
const worker = esbuild.buildSync({
  entryPoints: [join(top, "web/worker.js")],
  nodePaths: [join(tools, "node_modules")],
  bundle: true, minify: true, write: false, format: "iife", logLevel: "error",
}).outputFiles[0].text;
const licence = (name) => readFileSync(join(tools, "node_modules", name), "utf8");
const parts = {
  style: read("src/present/src/page/page.css") + read("web/style.css"),
  licences: `robovec\n\n${read("LICENSE-MIT")}\n@bjorn3/browser_wasi_shim\n\n${licence("@bjorn3/browser_wasi_shim/LICENSE-MIT")}`.replaceAll("<", "&lt;"),
  examples: JSON.stringify(Object.fromEntries(EXAMPLES.map((path) => [basename(path), read(path)]))).replaceAll("<", "\\u003c"),
  worker: worker.replaceAll("</script", "<\\/script"),
  program: gzipSync(readFileSync(program), { level: 9 }).toString("base64"),
  main: read("web/main.js"),
};
const text = read("web/page.html").replace(/\{\{(\w+)\}\}/g, (_, name) => parts[name]);
writeFileSync(page, text);
console.log(`${page}: ${(text.length / 1e6).toFixed(1)} MB, program ${(readFileSync(program).length / 1e6).toFixed(1)} MB`);
