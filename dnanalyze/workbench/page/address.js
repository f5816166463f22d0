// The browser's address names the session, so that a reload asks for it.
export function render({ model }) {
  window.history.replaceState(null, "", model.query);
  return document.createElement("span");
}
