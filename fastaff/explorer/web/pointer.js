// Mouse, pen and fingers on a canvas: click, drag, box, wheel, pinch, hover, told to `act` in the plane of a frame.

import { insideFrame, toPlane } from "./frame.js";

const STILL = 5; // pixels that a click may move

// act: {click(u, v), hover(x, y) | hover(null), grab(), drag(view), box(x0, y0, x1, y1) | box(null), boxed(view), zoom(u, v, factor, begins), boxMode()}
export function followPointers(canvas, frame, act) {
  const held = new Map();
  let gesture = null;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    const [x, y] = place(event);
    if (!insideFrame(frame, x, y)) return;
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [x, y]);
    if (held.size === 2) gesture = { kind: "pinch", view: [...frame.view], from: twoOf(held), begun: false };
    else if (held.size === 1) gesture = { kind: "click", view: [...frame.view], x, y, boxed: event.shiftKey || act.boxMode() };
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = place(event);
    if (!held.has(event.pointerId)) {
      if (event.pointerType === "mouse" || event.pointerType === "pen") act.hover(insideFrame(frame, x, y) ? [x, y] : null);
      return;
    }
    held.set(event.pointerId, [x, y]);
    if (!gesture) return;
    if (gesture.kind === "click" && Math.hypot(x - gesture.x, y - gesture.y) > STILL) {
      gesture.kind = gesture.boxed ? "box" : "drag";
      if (gesture.kind === "drag") act.grab();
    }
    if (gesture.kind === "box") act.box([gesture.x, gesture.y, x, y]);
    if (gesture.kind === "drag") act.drag(movedView(frame, gesture, x, y));
    if (gesture.kind === "pinch" && held.size === 2) {
      if (!gesture.begun) act.grab();
      gesture.begun = true;
      act.drag(pinchedView(frame, gesture, twoOf(held)));
    }
  });
  const ended = (event, counts) => {
    if (!held.delete(event.pointerId)) return;
    const [x, y] = place(event);
    if (gesture?.kind === "click" && counts) act.click(...toPlane(frame, x, y));
    if (gesture?.kind === "box") {
      act.box(null);
      const [u0, v0] = toPlane(frame, gesture.x, gesture.y), [u1, v1] = toPlane(frame, x, y);
      if (counts && Math.abs(x - gesture.x) > STILL && Math.abs(y - gesture.y) > STILL) {
        act.boxed([Math.min(u0, u1), Math.max(u0, u1), Math.min(v0, v1), Math.max(v0, v1)]);
      }
    }
    gesture = null;
  };
  canvas.addEventListener("pointerup", (event) => ended(event, true));
  canvas.addEventListener("pointercancel", (event) => ended(event, false));
  canvas.addEventListener("pointerleave", () => act.hover(null));
  let wheeled = -Infinity;
  canvas.addEventListener("wheel", (event) => {
    const [x, y] = place(event);
    if (!insideFrame(frame, x, y)) return;
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 30 : event.deltaMode === 2 ? 300 : 1;
    act.zoom(...toPlane(frame, x, y), Math.exp(Math.max(-1, Math.min(1, event.deltaY * lines * 0.0016))), event.timeStamp - wheeled > 600);
    wheeled = event.timeStamp;
  }, { passive: false });
}

function twoOf(held) {
  const [[x0, y0], [x1, y1]] = [...held.values()];
  return { x: (x0 + x1) / 2, y: (y0 + y1) / 2, apart: Math.max(10, Math.hypot(x1 - x0, y1 - y0)) };
}

function movedView(frame, gesture, x, y) {
  const begun = { ...frame, view: gesture.view };
  const [u, v] = toPlane(begun, gesture.x, gesture.y), [uNow, vNow] = toPlane(begun, x, y);
  const [u0, u1, v0, v1] = gesture.view;
  return [u0 + u - uNow, u1 + u - uNow, v0 + v - vNow, v1 + v - vNow];
}

function pinchedView(frame, gesture, now) {
  const begun = { ...frame, view: gesture.view };
  const factor = gesture.from.apart / now.apart;
  const [u, v] = toPlane(begun, gesture.from.x, gesture.from.y);
  const view = gesture.view.map((end, i) => (i < 2 ? u : v) + (end - (i < 2 ? u : v)) * factor);
  return movedView(frame, { view, x: gesture.from.x, y: gesture.from.y }, now.x, now.y);
}
