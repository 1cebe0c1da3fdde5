// The bifurcation diagram of a map of one variable: iterates against a parameter; a click chooses its value.

import { clipToInner, drawAxes, fittedContext, innerOf, insideFrame, makeFrame, toPixel, toPlane, widened } from "./frame.js";
import { greek } from "./text.js";
import { sayInstead } from "./view_configuration.js";

const COLUMNS = 500, TRANSIENT = 1000, KEPT = 256;
const FAINT = 0.35; // opacity of a pixel that one iterate meets

export function makeBifurcations(canvas) {
  return { canvas, frame: makeFrame({ left: 50, right: 10, top: 8, bottom: 36 }), parameter: null, asked: "", found: null, image: null, imageOf: "" };
}

// Ask for the diagram where another one is wanted; limits: [from, to] of each parameter's slider.
export function askBifurcations(view, { state, orbit, limits, send }) {
  const names = Object.keys(state.parameters);
  if (!names.includes(view.parameter)) view.parameter = names[0] ?? null;
  const name = view.parameter, now = state.parameters[name];
  if (name === null || !orbit?.z0) return;
  const others = names.filter((one) => one !== name).map((one) => state.parameters[one]);
  const key = [state.system, state.formula, state.periodic, name, ...others, orbit.z0[0], ...limits(name)].join();
  const inside = view.found === null || (now >= view.found.from && now <= view.found.to);
  if (view.asked === key && (inside || view.outside === now)) return;
  Object.assign(view, { asked: key, outside: now });
  send({ type: "bifurcations", key, parameter: name, range: limits(name), columns: COLUMNS, start: orbit.z0[0], transient: TRANSIENT, kept: KEPT });
}

// Take an answer; false where it is of an older question.
export function takeBifurcations(view, message) {
  if (message.key !== view.asked) return false;
  view.found = message.from === null ? null : message;
  view.imageOf = "";
  return true;
}

export function drawBifurcations(view, { state, label, theme, colours }) {
  const { frame, found, parameter } = view, ctx = fittedContext(view.canvas, frame);
  if (parameter === null) return sayInstead(ctx, frame, colours, "The map has no parameter.");
  if (!found) return sayInstead(ctx, frame, colours, view.asked ? "Orbits escape at all values." : "Launch an orbit to see its iterates.");
  const known = found.points.filter((x) => !Number.isNaN(x)), low = known.reduce((a, b) => Math.min(a, b), Infinity), high = known.reduce((a, b) => Math.max(a, b), -Infinity);
  frame.view = [found.from, found.to, ...widened([0, 1, low, high === low ? low + 1 : high], 0.04).slice(2)];
  frame.labels = [greek(parameter), label];
  const inner = innerOf(frame), ratio = view.canvas.width / frame.width;
  const size = [Math.round(inner.width * ratio), Math.round(inner.height * ratio)], key = [...size, theme, ...frame.view].join();
  if (view.imageOf !== key) Object.assign(view, { imageOf: key, image: imageOfPoints(found, frame.view, ...size, colours.text) });
  ctx.drawImage(view.image, inner.x, inner.y, inner.width, inner.height);
  drawAxes(ctx, frame, colours, 11);
  ctx.save();
  clipToInner(ctx, frame);
  const [x] = toPixel(frame, state.parameters[parameter], 0);
  ctx.strokeStyle = colours.accent;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.moveTo(x, inner.y);
  ctx.lineTo(x, inner.y + inner.height);
  ctx.stroke();
  return ctx.restore();
}

// The points on a grid of pixels, darker where more of them meet.
function imageOfPoints({ points, values, from, to }, [, , v0, v1], width, height, colour) {
  const counts = new Uint16Array(width * height), kept = points.length / values.length;
  const column = (value) => Math.min(width - 1, Math.floor(((value - from) / (to - from)) * width)), step = Math.max(1, Math.ceil(width / values.length));
  values.forEach((value, k) => {
    const first = column(value - (to - from) / values.length / 2);
    for (let j = 0; j < kept; j++) {
      const row = Math.floor(((v1 - points[k * kept + j]) / (v1 - v0)) * height);
      if (!(row >= 0 && row < height)) continue;
      for (let i = first; i < Math.min(width, first + step); i++) counts[row * width + i]++;
    }
  });
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width, height });
  const ctx = canvas.getContext("2d");
  ctx.fillStyle = colour;
  ctx.fillRect(0, 0, width, height);
  const image = ctx.getImageData(0, 0, width, height);
  counts.forEach((count, at) => { image.data[4 * at + 3] = 255 * Math.min(1, FAINT * count); });
  ctx.putImageData(image, 0, 0);
  return canvas;
}

// The value of the parameter at a pixel, to a thousandth of the range; null beside the diagram.
export function valueAt({ frame, found }, x, y) {
  if (!found || !insideFrame(frame, x, y)) return null;
  const [value] = toPlane(frame, x, y), places = Math.max(0, Math.ceil(-Math.log10((found.to - found.from) / 1000)));
  return Number(value.toFixed(Math.min(places, 12)));
}
