// Goes through a page as somebody would who asks why an output is late, and
// writes what was seen into the document. One click at a time; what a click
// shows is there when the address has changed.
const told = [];
const errors = [];
addEventListener("error", event => errors.push(event.message));
addEventListener("unhandledrejection", event => errors.push(String(event.reason)));
for (const level of ["error", "warn"]) {
  console[level] = (...words) => errors.push(`${level}: ${words.join(" ")}`);
}
const wait = () => new Promise(done => setTimeout(done, 60));
const click = async element => {
  if (!element) throw new Error("nothing to click after " + told.join("; "));
  element.click();
  await wait();
};
const say = (key, value) => told.push(`${key}=${value}`);
async function drive() {
  await wait();
  // The page opens on the pass that changed most, its gain on top.
  say("opens", /\d+ \u2192 \d+ cycles/.test(document.querySelector("#answer .answer").textContent) && document.getElementById("pass").selectedIndex > 0);
  await click(document.getElementById("tab-late"));
  say("outputs", document.querySelectorAll("#outputs tbody tr").length);
  // Five clicks with that on the tab: the latest output, its chain, an operation that a rule made.
  await click(document.querySelector("#outputs tbody button"));
  say("chosen", document.getElementById("chosen").textContent);
  say("equations", document.querySelectorAll("#story .equation").length);
  await click(document.getElementById("why"));
  const rows = [...document.querySelectorAll("#chain tbody tr")];
  say("chain", rows.length);
  const ruled = rows.find(row => row.lastChild.textContent.includes("(")) || rows[0];
  await click(ruled);
  say("rules", document.querySelectorAll("#story .rule").length);
  say("reasons", document.querySelectorAll("#story .rule, #story .does").length);
  say("steps", document.querySelectorAll("#story .step").length);
  say("equation", document.querySelector("#story .equation").textContent.trim().replace(/\s+/g, " "));
  await click(document.querySelector("#story .step button.value"));
  say("pass", document.getElementById("pass").selectedOptions[0].textContent);
  say("clicks", clicks);
  say("lines", document.querySelectorAll(".lines .line").length);
  for (const tab of ["graph", "schedule", "source", "report", "passes", "late"]) {
    await click(document.getElementById("tab-" + tab));
    await wait();
    say(tab, document.getElementById("panel").children.length > 0);
    if (tab === "graph") say("nodes", document.querySelectorAll(".node").length > 1);
    if (tab === "schedule") say("ink", [...document.querySelector("canvas").getContext("2d").getImageData(80, 30, 300, 60).data].some(part => part > 0));
    if (tab === "source") say("heat", [...document.querySelectorAll(".lines .line")].length > 0);
    const wide = document.documentElement.scrollWidth <= innerWidth + 1;
    if (!wide) say(tab, "too wide");
  }
}
let clicks = 0;
addEventListener("click", () => clicks++, true);
drive().catch(error => errors.push(String(error))).then(() => {
  const box = document.createElement("pre");
  box.id = "told";
  // What was loaded but the page itself.
  say("requests", performance.getEntriesByType("resource").length);
  box.textContent = [...told, `errors=${errors.join(" | ")}`].join("\n");
  document.body.append(box);
});
