// Drives the page in Chromium: node page.mjs PAGE.html TOOLS PROGRAMS, TOOLS
// the folder where playwright-core is installed, PROGRAMS that of the native
// programs.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [address, tools, natives] = process.argv.slice(2).map((path) => resolve(path));
const top = resolve(import.meta.dirname, "../..");
const { chromium } = createRequire(join(tools, "package.json"))("playwright-core");
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

async function open(options) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  const start = performance.now();
  page.on("console", (message) => troubles.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => troubles.push(`error: ${error.message}`));
  page.on("request", (request) => { if (!/^(blob|data):/.test(request.url())) requests.push(request.url()); });
  await page.goto(pathToFileURL(address).href);
  await idle(page);
  console.log(`ready after ${seconds(start)}`);
  return page;
}

const troubles = [], requests = [];
const seconds = (start) => `${((performance.now() - start) / 1000).toFixed(2)} s`;
const idle = (page) => page.waitForFunction(() => !document.getElementById("run").disabled, null, { timeout: 120_000 });
const text = (page, selector) => page.textContent(selector);

async function shows(page, selector, wanted) {
  const found = await text(page, selector);
  assert.ok(wanted.test(found), `${wanted} is not in ${found.slice(0, 400)}`);
}

async function run(page) {
  const start = performance.now();
  await page.click("#run");
  await idle(page);
  return performance.now() - start;
}

async function tab(page, name) {
  await page.click(`#tabs button:text-is("${name}")`);
  await idle(page);
}

// What the native program writes of an example.
function native(path, passes) {
  const folder = mkdtempSync(join(tmpdir(), "playground-"));
  const made = spawnSync(join(natives, "robovec-opt"), [join(top, path), `--passes=${passes}`, "-o", join(folder, "out")]);
  assert.equal(made.status, 0, String(made.stderr));
  const written = readFileSync(join(folder, "out"), "utf8");
  rmSync(folder, { recursive: true });
  return written;
}

const page = await open({});
await page.selectOption("#example", "bogie.mbs");
const times = [await run(page), await run(page)];
console.log(`bogie through $shorten: ${times.map((time) => `${(time / 1000).toFixed(2)} s`).join(", then ")}`);
assert.ok(times[0] < 3000, "the bogie takes 3 s or more");
assert.ok(await text(page, "#code") === native("examples/models/bogie.mbs", "$shorten"), "the code of the bogie is another one");
await shows(page, "#answer", /3765 → 3699 operations.*proved equal after each of 6 passes.*Input against result: dirdyna: real, equal/s);
for (const [name, wanted] of [["Report", /ASAPCycle/], ["Error", /reference certified/], ["Diagnostics", /robovec-opt bogie\.mbs/]]) {
  await tab(page, name);
  await shows(page, "#panel", wanted);
}
await tab(page, "View");
await page.frameLocator("iframe").locator("h1").waitFor();

// Other languages and other ends of pipelines.
await page.selectOption("#example", "mbs_dirdyna_suspension.m");
await page.fill("#passes", "$cpu,codegen{target=c}");
await run(page);
await shows(page, "#code", /void mbs_dirdyna\(/);

// Mistakes are told, and the page goes on.
await page.fill("#text", "function broken\nthis is no equation;");
await run(page);
await shows(page, "#answer", /error/);
await page.fill("#passes", "shorter");
await run(page);
await shows(page, "#answer", /error.*shorter/s);

// A run is stopped, and the next one works.
await page.selectOption("#example", "bogie.mbs");
await page.fill("#passes", "atomise,optimise");
await page.click("#run");
await page.waitForTimeout(300);
await page.click("#stop");
await idle(page);
assert.equal(await text(page, "#state"), "Stopped.");
await page.fill("#passes", "$shorten,place");
await run(page);
await shows(page, "#answer", /555 cycles/);

for (const [name, options] of [["light", {}], ["dark", { colorScheme: "dark" }], ["narrow", { viewport: { width: 400, height: 800 } }]]) {
  const other = await open(options);
  await run(other);
  const wide = await other.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `${name}: ${wide} pixels too wide`);
  if (process.env.PICTURES) await other.screenshot({ path: join(process.env.PICTURES, `${name}.png`), fullPage: name === "narrow" });
}

await browser.close();
assert.deepEqual(troubles, []);
assert.deepEqual([...new Set(requests)], [pathToFileURL(address).href]);
console.log("no request but for the page, nothing on the console");
