// The history as a tree: a card for each step, children to the right of their parent.
const WIDTH = 168, HEIGHT = 62, GAP_X = 26, GAP_Y = 8;
const SVG = "http://www.w3.org/2000/svg";

export function render({ model, el }) {
  const scroller = document.createElement("div");
  scroller.className = "tree";
  el.append(scroller);

  const draw = () => {
    const nodes = model.nodes;
    const at = new Map(nodes.map((n) => [n.number, n]));
    const x = (n) => n.depth * (WIDTH + GAP_X), y = (n) => n.lane * (HEIGHT + GAP_Y);
    const field = document.createElement("div");
    const size = (f, of) => Math.max(0, ...nodes.map((n) => f(n) + of));
    const [width, height] = [size(x, WIDTH), size(y, HEIGHT)];
    field.style.cssText = `position:relative;width:${width}px;height:${height}px`;
    const lines = document.createElementNS(SVG, "svg");
    lines.setAttribute("width", width);
    lines.setAttribute("height", height);
    field.append(lines);
    for (const n of nodes) {
      const parent = at.get(n.parent);
      if (parent !== undefined) {
        const path = document.createElementNS(SVG, "path");
        const [x0, y0] = [x(parent) + WIDTH, y(parent) + HEIGHT / 2];
        const [x1, y1, middle] = [x(n), y(n) + HEIGHT / 2, x(n) - GAP_X / 2];
        path.setAttribute("d", `M${x0} ${y0} H${middle} V${y1} H${x1}`);
        lines.append(path);
      }
      const card = document.createElement("button");
      card.className = n.present ? "step present" : "step";
      card.title = n.tip;
      card.dataset.number = n.number;
      card.setAttribute("aria-current", n.present);
      card.style.cssText =
        `left:${x(n)}px;top:${y(n)}px;width:${WIDTH}px;height:${HEIGHT}px`;
      const text = document.createElement("span");
      text.className = "text";
      const title = document.createElement("span");
      title.className = "title";
      title.textContent = n.title;
      const error = document.createElement("span");
      error.className = "size";
      error.textContent = n.error;
      text.append(title, error);
      if (n.image) {
        const image = document.createElement("img");
        image.src = n.image;
        image.alt = "";
        card.append(image);
      }
      card.append(text);
      card.onclick = () => model.send_msg({ go: n.number });
      field.append(card);
    }
    scroller.replaceChildren(field);
    const present = nodes.find((n) => n.present);
    if (present !== undefined) {
      scroller.scrollLeft = x(present) + WIDTH - scroller.clientWidth;
      scroller.scrollTop = y(present) + HEIGHT - scroller.clientHeight;
    }
  };
  model.on("nodes", draw);
  draw();
}
