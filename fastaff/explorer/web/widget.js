// The explorer in a notebook: its messages go to Python, where the package answers them.

import { startExplorer } from "./app.js";

/** Show the explorer of an anywidget's model in an element. */
export function mountExplorer(model, element) {
  const parsed = new DOMParser().parseFromString(model.get("markup"), "text/html");
  const root = document.importNode(parsed.querySelector(".explorer"), true);
  element.append(root);
  startExplorer(root, model.get("setup"), widgetBackend(model));
}

/** A backend over the messages of an anywidget's model; arrays come as buffers, named in `arrays`. */
function widgetBackend(model) {
  const backend = { onmessage: null, send: (message) => model.send(JSON.parse(JSON.stringify(message))) };
  model.on("msg:custom", ({ message, arrays }, buffers) => {
    const data = { ...message };
    arrays.forEach(([name, kind], k) => {
      const view = buffers[k], bytes = view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength);
      data[name] = kind === "u1" ? new Uint8Array(bytes) : new Float64Array(bytes);
    });
    backend.onmessage?.({ data });
  });
  return backend;
}
