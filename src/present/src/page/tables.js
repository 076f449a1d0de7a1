"use strict";
// What all pages with tables have: values under the pointer, tables that sort
// by a click on a head, show the rows that hold a text, and are saved as CSV.
// How tables are sorted and what is looked for stands in the address, so that
// a view can be kept and sent. Nothing is fetched.
const make = (name, attributes = {}, ...children) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
};

// The address: words and their values behind the `#`.
const address = {
  words: () => new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : ""),
  get: (word) => address.words().get(word) ?? "",
  set(word, value) {
    const words = address.words();
    if (value === "") words.delete(word);
    else words.set(word, value);
    // A bare `#` would scroll to the top, no change of the address does not.
    history.replaceState(null, "", `#${words}`);
  },
};

// Ways within the page keep what stands in the address.
document.querySelectorAll('a[href^="#"]').forEach((link) =>
  link.addEventListener("click", (event) => {
    event.preventDefault();
    document.querySelector(link.getAttribute("href"))?.scrollIntoView();
  }));

// Values under the pointer. Browsers show titles late; here they appear at once.
const tip = document.body.appendChild(make("div", { id: "tip", role: "tooltip" }));
document.addEventListener("mouseover", (event) => {
  const title = event.target.querySelector?.(":scope > title");
  if (title && event.target.ownerSVGElement) {
    event.target.dataset.tip = title.textContent;
    title.remove();
  }
  const text = event.target.dataset?.tip;
  tip.style.display = text ? "block" : "none";
  if (text) tip.textContent = text;
});
document.addEventListener("mousemove", (event) => {
  const left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8);
  tip.style.left = `${Math.max(left, 4)}px`;
  tip.style.top = `${Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8)}px`;
});

// Sorts a table by a column; empty cells come last, numbers by their size.
function sortBy(table, column, up) {
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head) => head.removeAttribute("aria-sort"));
  heads[column].setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = (row) => row.cells[column].textContent.trim();
  const compare = (a, b) => {
    if (key(a) === "" || key(b) === "") return (key(a) === "") - (key(b) === "");
    const [x, y] = [parseFloat(key(a)), parseFloat(key(b))];
    const order = isNaN(x) || isNaN(y) ? key(a).localeCompare(key(b)) : x - y;
    return up ? order : -order;
  };
  table.tBodies[0].append(...[...table.tBodies[0].rows].sort(compare));
}

// Shows the rows that hold all words of a text.
function filterBy(table, text) {
  const words = text.toLowerCase().split(/\s+/).filter((word) => word);
  for (const row of table.tBodies[0].rows) {
    const content = row.textContent.toLowerCase();
    row.hidden = !words.every((word) => content.includes(word));
  }
}

// The rows that are shown, as CSV.
function csvOf(table) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const line = (cells) => [...cells].map((cell) => quoted(cell.textContent.trim())).join(",");
  const rows = [...table.tBodies[0].rows].filter((row) => !row.hidden);
  return [table.tHead.rows[0], ...rows].map((row) => line(row.cells)).join("\n") + "\n";
}

function save(name, text) {
  const link = make("a", { download: name, href: URL.createObjectURL(new Blob([text], { type: "text/csv" })) });
  link.click();
  URL.revokeObjectURL(link.href);
}

// Gives a table all of it. `name` stands in the address and in file names.
function sortable(table, name) {
  if (table.dataset.name || !table.tHead || !table.tBodies[0]) return;
  table.dataset.name = name;
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head, column) => {
    head.classList.add("sort");
    head.tabIndex = 0;
    const sort = () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      sortBy(table, column, up);
      address.set(`sort-${name}`, `${up ? "" : "-"}${column + 1}`);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => event.key === "Enter" && sort());
  });
  const find = make("input", { type: "search", placeholder: "rows with …", "aria-label": "show rows with" });
  find.value = address.get(`find-${name}`);
  find.addEventListener("input", () => {
    filterBy(table, find.value);
    address.set(`find-${name}`, find.value.trim());
  });
  const csv = make("button", { type: "button" }, "CSV");
  csv.addEventListener("click", () => save(`${name}.csv`, csvOf(table)));
  table.before(make("p", { class: "tools" }, find, " ", csv));
  filterBy(table, find.value);
  const sorted = parseInt(address.get(`sort-${name}`), 10);
  if (sorted && Math.abs(sorted) <= heads.length) sortBy(table, Math.abs(sorted) - 1, sorted > 0);
}

// A folded table gets its tools when it is opened: some pages have thousands.
document.querySelectorAll("table.data").forEach((table, index) => {
  const folded = table.closest("details");
  const prepare = () => sortable(table, folded?.id || `table-${index + 1}`);
  if (!folded || folded.open) prepare();
  else folded.addEventListener("toggle", prepare, { once: true });
});
