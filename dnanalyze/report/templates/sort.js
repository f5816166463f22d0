// A click on a column's name sorts the table by it, a second click the other way round.
for (const table of document.querySelectorAll("table.sortable")) {
  table.querySelectorAll("th").forEach((head, column) => {
    head.tabIndex = 0;
    head.style.cursor = "pointer";
    head.title = "sort";
    const sort = () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      table.querySelectorAll("th").forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const body = table.tBodies[0];
      const text = (row) => row.cells[column].textContent.trim();
      const order = (a, b) => {
        const x = parseFloat(text(a)), y = parseFloat(text(b));
        if (isNaN(x) !== isNaN(y)) return isNaN(x) ? 1 : -1; // what has no number stays last
        return (down ? -1 : 1) * (isNaN(x) ? text(a).localeCompare(text(b)) : x - y);
      };
      const rows = [...body.rows].sort(order);
      body.append(...rows);
    };
    head.addEventListener("click", sort);
    head.addEventListener("keydown", (event) => event.key === "Enter" && sort());
  });
}
