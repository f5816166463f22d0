// The ranked candidates: hovering shows a candidate's curve, a click on "Add" adds it.
export function render({ model, el }) {
  const list = document.createElement("div");
  list.className = "list";
  el.appendChild(list);
  const text = (tag, content, cls) => {
    const made = document.createElement(tag);
    made.textContent = content;
    if (cls) made.className = cls;
    return made;
  };
  const draw = () => {
    list.replaceChildren();
    if (model.rows.length) {
      const head = document.createElement("div");
      head.className = "head quiet";
      head.append(text("span", ""), text("span", "confidence"), text("span", "error after"));
      list.append(head);
    }
    for (const c of model.rows) {
      const row = document.createElement("div");
      row.className = "row";
      const head = document.createElement("div");
      head.className = "head";
      const name = text("span", c.name, "name");
      name.append(" ", text("small", c.effect, "quiet"));
      head.append(
        name,
        text("span", c.confidence, "number"),
        text("span", c.error, "number"),
      );
      if (c.can_add) {
        const button = text("button", "Add");
        button.disabled = model.busy;
        button.onclick = () => model.send_msg({ add: c.effect });
        head.append(button);
      }
      const bar = document.createElement("div");
      bar.className = "bar";
      const explained = Math.round(100 * c.explained);
      bar.title = `explains ${explained} % of the model error above 1`;
      bar.append(document.createElement("span"));
      bar.firstChild.style.width = `${explained}%`;
      row.append(head, bar, text("div", c.evidence, "evidence"));
      row.onmouseenter = () => model.send_msg({ hover: c.effect });
      row.onmouseleave = () => model.send_msg({ hover: "" });
      list.append(row);
    }
  };
  model.on("rows", draw);
  model.on("busy", draw);
  draw();
}
