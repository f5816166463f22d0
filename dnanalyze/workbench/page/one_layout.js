// Bokeh lays out the whole page at every change of a size or of what is visible; while a page
// opens they come by the dozen. Here it does so once a frame of the screen at most, and again
// where a plot was still being made, which has no layout yet.
const TRIES = 100, PAUSE_MS = 50;

export function render({ view }) {
  let root = view;
  while (root.parent?.invalidate_layout) root = root.parent;
  const compute = root.compute_layout.bind(root);
  let asked = false, failed = 0;
  const tried = (step) => {
    try {
      step();
      failed = 0;
    } catch (error) {
      failed += 1;
      if (failed > TRIES) throw error;
      setTimeout(() => root.invalidate_layout(), PAUSE_MS);
    }
  };
  root.compute_layout = () => {
    if (!asked) tried(compute);
  };
  root.invalidate_layout = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      tried(() => root.update_layout());
      root.compute_layout();
    });
  };
  return document.createElement("span");
}
