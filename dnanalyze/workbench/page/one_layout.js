// Bokeh lays out the whole page at every change of a size or of what is visible; while a page
// opens they come by the dozen. Here it does so once a frame of the screen at most.
export function render({ view }) {
  let root = view;
  while (root.parent?.invalidate_layout) root = root.parent;
  const layOut = root.invalidate_layout.bind(root);
  let asked = false;
  root.invalidate_layout = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      layOut();
    });
  };
  return document.createElement("span");
}
