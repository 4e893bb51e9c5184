"use strict";
(() => {
  const tools = document.querySelector(".tools");
  const body = document.querySelector("#matrix tbody");
  if (!tools || !body) return;
  tools.hidden = false;
  const rows = [...body.rows];
  const filter = document.getElementById("filter");
  const only = document.getElementById("only");
  const shown = document.getElementById("shown");
  const show = () => {
    const wanted = filter.value.toLowerCase();
    let count = 0;
    for (const row of rows) {
      const fits = row.dataset.name.toLowerCase().includes(wanted) && (!only.checked || row.dataset.bad === "1");
      row.hidden = !fits;
      if (fits) count += 1;
    }
    shown.textContent = `${count} of ${rows.length} recordings`;
  };
  const sort = (order) => {
    body.append(...[...rows].sort(order));
  };
  const byName = (a, b) => (a.dataset.name < b.dataset.name ? -1 : 1);
  const byWorst = (a, b) => b.dataset.bad - a.dataset.bad || a.dataset.margin - b.dataset.margin || byName(a, b);
  filter.addEventListener("input", show);
  only.addEventListener("change", show);
  document.getElementById("by-name").addEventListener("click", () => sort(byName));
  document.getElementById("by-worst").addEventListener("click", () => sort(byWorst));
  show();
})();
