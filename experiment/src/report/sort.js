for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const key = (row) => row.cells[column].dataset.v ?? row.cells[column].textContent;
      const order = (a, b) => {
        const [s, t] = [key(a), key(b)];
        const [x, y] = [Number(s), Number(t)];
        // What is no number in a column of numbers has never been reached: last, either way.
        if (s === "NaN" || t === "NaN") return (s === "NaN") - (t === "NaN");
        const sign = up ? 1 : -1;
        return sign * (Number.isNaN(x) || Number.isNaN(y) ? s.localeCompare(t) : Math.abs(x) - Math.abs(y));
      };
      const body = table.tBodies[0];
      body.append(...[...body.rows].sort(order));
    });
  });
}
