// Claims: search and filter, how a number is repeated, links into experiments that are closed.
const rows = [...document.querySelectorAll(".experiment tbody tr")].map(row => ({ row, text: row.textContent.toLowerCase() }));
const experiments = [...document.querySelectorAll(".experiment")].map(box => ({
  box, open: box.open, title: `${box.querySelector("summary").textContent} ${box.dataset.case} ${box.dataset.paper}`.toLowerCase(),
}));
const titles = new Map(experiments.map(e => [e.box, e.title]));
const search = document.getElementById("search"), filter = document.getElementById("filter");
const fits = ({ row, text }, title, words) => (!filter.value || row.classList.contains(filter.value)) && words.every(w => text.includes(w) || title.includes(w));
const sift = () => {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean), all = !words.length && !filter.value;
  const of = new Map(experiments.map(e => [e.box, 0]));
  document.querySelectorAll("tr.how").forEach(row => row.remove());
  let found = 0;
  for (const entry of rows) {
    const box = entry.row.closest(".experiment");
    const shown = all || fits(entry, titles.get(box), words);
    entry.row.hidden = !shown;
    if (shown) { ++found; of.set(box, of.get(box) + 1); }
  }
  for (const e of experiments) {
    e.box.hidden = !of.get(e.box);
    e.box.open = all ? e.open : of.get(e.box) > 0;
  }
  for (const section of document.querySelectorAll(".study")) section.hidden = !all && ![...section.querySelectorAll(".experiment")].some(box => !box.hidden);
  document.documentElement.classList.toggle("filtering", !all);
  document.getElementById("found").textContent = all ? "" : `${found} of ${rows.length}`;
};
search.oninput = filter.oninput = sift;

/// How the number of a row is repeated, under it.
const how = link => {
  const row = link.closest("tr"), box = row.closest(".experiment");
  if (row.nextSibling?.className === "how") { row.nextSibling.remove(); return; }
  const told = document.createElement("tr"), cell = document.createElement("td");
  told.className = "how";
  cell.colSpan = 6;
  const code = (text) => { const c = document.createElement("code"); c.textContent = text; return c; };
  const toml = link.cloneNode();
  toml.textContent = toml.getAttribute("href");
  toml.removeAttribute("title");
  cell.append("measured again by ", code(link.title), "; scenario ", toml);
  const flown = [...box.querySelectorAll("p code")].find(c => c.textContent.startsWith("gyrostat run"));
  if (flown) cell.append(", flown by ", code(flown.textContent), " in the folder of this page");
  told.append(cell);
  row.after(told);
};
document.addEventListener("click", event => {
  const link = event.target.closest(".measured a");
  if (link && !event.ctrlKey && !event.metaKey && !event.shiftKey) { event.preventDefault(); how(link); return; }
  const all = event.target.closest("button.all");
  if (all) {
    const boxes = [...all.closest(".claims").querySelectorAll(".experiment")], open = boxes.some(box => !box.open);
    boxes.forEach(box => { box.open = open; });
    all.textContent = open ? "close all" : "open all";
  }
});
const go = () => {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const box = target?.closest(".experiment");
  if (!box) return;
  if (search.value || filter.value) { search.value = filter.value = ""; sift(); }
  box.open = true;
  document.querySelectorAll("tr.here").forEach(row => row.classList.remove("here"));
  target.classList.add("here");
  target.scrollIntoView({ block: "center" });
};
window.addEventListener("hashchange", go);
document.addEventListener("click", event => { if (event.target.closest('a[href^="#"]')) setTimeout(go); });
go();
gyrostat.claims = () => ({ rows: rows.length, shown: rows.filter(e => !e.row.hidden).length, experiments: experiments.length });
