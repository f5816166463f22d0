// Families of statistics as bars, and the chosen family's statistics by operating point as cells.
const made = (tag, cls, text) => {
  const element = document.createElement(tag);
  if (cls) element.className = cls;
  if (text !== undefined) element.textContent = text;
  return element;
};
const html = (cls, content) => {  // the server escapes what comes from captures
  const element = made("span", cls);
  element.innerHTML = content;
  return element;
};

export function render({ model, el }) {
  const families = made("div", "families");
  families.setAttribute("role", "listbox");
  const matrix = made("div", "matrix");
  const list = made("div", "list");
  const more = made("button", "more");
  matrix.append(list, more);
  const pair = made("div", "pair");
  pair.append(families, matrix);
  el.append(pair);
  const host = el.getRootNode().host ?? el;
  let shown = "";  // the cell that was last brought into view, and the rows around it

  // Rows are shown whole: one that is cut looks like the last.
  const told = () => {
    const { tHead, tBodies } = list.querySelector("table");
    const top = list.scrollTop + tHead.offsetHeight - 1;
    const end = list.scrollTop + list.clientHeight + 1;
    const rows = [...tBodies[0].rows];
    const below = rows.filter((r) => r.offsetTop + r.offsetHeight > end);
    const whole = rows.filter((r) => r.offsetTop >= top && !below.includes(r));
    for (const r of rows) r.className = whole.length && !whole.includes(r) ? "cut" : "";
    more.textContent = below.length ? `▾ ${below.length} more` : "▴ first";
    more.onclick = () => {
      list.scrollTop = below.length ? below[0].offsetTop - tHead.offsetHeight : 0;
    };
  };
  // upright, many labels leave no width for the names of the statistics
  const many = () => model.columns.length > 8 || model.columns.join("").length > 48;
  const cut = () => {
    const table = list.querySelector("table");
    if (!table) return;
    const top = list.scrollTop;
    table.classList.toggle("steep", many());
    if (table.offsetWidth > list.clientWidth) table.classList.add("steep");
    list.style.maxHeight = "none";
    const room = parseFloat(getComputedStyle(host).maxHeight);
    more.hidden = !(table.offsetHeight > room);
    if (!more.hidden) list.style.maxHeight = `${room - more.offsetHeight}px`;
    list.scrollTop = top;
    told();
  };
  list.onscroll = told;
  const observer = new ResizeObserver(cut);
  observer.observe(host.getRootNode().host ?? host.parentElement ?? host);
  model.on("remove", () => observer.disconnect());

  const drawFamilies = () => {
    families.replaceChildren();
    for (const f of model.families) {
      const row = made("button", `family${f.chosen ? " chosen" : ""}`);
      row.title = f.tip;
      row.dataset.name = f.name;
      const bar = made("span", "bar");
      const fill = made("span", `fill${f.good ? " good" : ""}`);
      fill.style.width = `${f.width}%`;
      const mark = made("span", "mark");
      mark.style.left = `${f.mark}%`;
      mark.hidden = f.mark === null;
      const one = made("span", "one");
      one.style.left = `${model.one}%`;
      bar.append(fill, one, mark);
      row.append(made("span", "label", f.title), bar, made("span", "number", f.error));
      row.onclick = () => model.send_msg({ family: f.name });
      families.append(row);
    }
  };

  const drawMatrix = () => {
    const table = made("table");
    const head = table.createTHead().insertRow();
    const corner = made("th");
    corner.append(html("quiet", model.corner));
    head.append(corner);
    for (const c of model.columns) {
      const th = made("th");
      th.append(made("span", "", c));
      head.append(th);
    }
    const body = table.createTBody();
    for (const r of model.rows) {
      const row = body.insertRow();
      const title = made("th");
      title.append(html("", r.title));
      row.append(title);
      for (const c of r.cells) {
        const cell = row.insertCell();
        if (c === null) continue;
        const button = made("button", c.chosen ? "cell chosen" : "cell", c.z);
        button.style.background = c.colour;
        button.style.color = c.ink;
        button.title = c.tip;
        button.setAttribute("aria-pressed", c.chosen);
        button.onclick = () => model.send_msg({ cell: c.key });
        cell.append(button);
      }
    }
    list.replaceChildren(table);
    cut();
    const order = model.rows.map((r) => r.title).join();
    const chosen = order + model.rows.flatMap((r) => r.cells).find((c) => c?.chosen)?.key;
    const row = table.querySelector(".chosen")?.closest("tr");
    if (row && chosen !== shown) {
      const top = row.offsetTop - table.tHead.offsetHeight;
      const hidden = row.offsetTop + row.offsetHeight > list.scrollTop + list.clientHeight;
      if (hidden || top < list.scrollTop) list.scrollTop = top;
    }
    shown = chosen;
  };
  model.on("families", drawFamilies);
  model.on("rows", drawMatrix);
  drawFamilies();
  drawMatrix();
}
