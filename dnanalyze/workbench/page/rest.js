// A slider rests from when the browser has drawn its curve: what the server sends, a busy one draws
// later, and its keys come later too. A move meanwhile makes what is told here that of an old draft.
export function render({ model }) {
  let waiting;
  model.on("drawn", () => {
    clearTimeout(waiting);
    const draft = model.drawn;
    const painted = () => {
      waiting = setTimeout(() => model.send_msg(draft), model.rest_ms);
    };
    requestAnimationFrame(() => requestAnimationFrame(painted));
  });
  return document.createElement("span");
}
