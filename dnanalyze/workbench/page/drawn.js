// A browser makes all panes of a place, then draws them in one go: after that this tells of it. A
// timer and not a frame of the screen, which a page behind others does not have.
export function render({ model }) {
  setTimeout(() => model.send_msg(true));
  return document.createElement("span");
}
