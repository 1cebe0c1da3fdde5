// Each orbit as a point: its rotation number against where it starts, or two of its frequencies.

import { clipToInner, drawAxes, fittedContext, innerOf, insideFrame, makeFrame, toPixel, widened } from "./frame.js";
import { colourOf, hasRotation } from "./orbits.js";
import { sayInstead } from "./view_configuration.js";

export function makeFrequency(canvas) {
  return { canvas, frame: makeFrame({ left: 50, right: 10, top: 8, bottom: 32 }), axes: "first", places: [] };
}

// What the axes can be: names for people by key.
export function frequencyAxes(labels, system) {
  const found = [["first", "ν against " + labels[0]], ["second", "ν against " + labels[1]]];
  const count = { body: 4, plane: 2, map: system.coordinates.length }[system.kind], sign = letterOf(system.kind);
  for (let i = 0; i < count; i++) for (let k = i + 1; k < count; k++) found.push([i + ":" + k, sign + "_" + (i + 1) + ", " + sign + "_" + (k + 1)]);
  return found;
}

// Frequencies of systems in time, tunes of maps.
function letterOf(kind) {
  return kind === "map" ? "ν" : "ω";
}

function placed(view, orbit) {
  const { rotation, frequencies } = orbit.reading;
  if (view.axes === "first" || view.axes === "second") {
    if (!orbit.point || !hasRotation(orbit)) return null;
    return [orbit.point[view.axes === "first" ? 0 : 1], rotation.value, 0, rotation.error];
  }
  const [i, k] = view.axes.split(":").map(Number);
  const values = frequencies?.values;
  if (!(values && Number.isFinite(values[i]) && Number.isFinite(values[k]))) return null;
  return [values[i], values[k], frequencies.errors?.[i] ?? 0, frequencies.errors?.[k] ?? 0];
}

export function drawFrequency(view, { orbits, kind, labels: { section: labels }, theme, colours }) {
  const { frame } = view;
  const ctx = fittedContext(view.canvas, frame);
  view.places = [];
  for (const orbit of orbits.shown.values()) {
    const place = orbit.hidden ? null : placed(view, orbit);
    if (place) view.places.push({ orbit, place });
  }
  if (!view.places.length) return sayInstead(ctx, frame, colours, "Each orbit becomes a point here.");
  const byPosition = view.axes === "first" || view.axes === "second";
  frame.labels = byPosition ? [labels[view.axes === "first" ? 0 : 1], "rotation number ν"] : view.axes.split(":").map((i) => letterOf(kind) + "_" + (Number(i) + 1));
  const ends = [Infinity, -Infinity, Infinity, -Infinity];
  for (const { place: [u, v] } of view.places) {
    ends[0] = Math.min(ends[0], u);
    ends[1] = Math.max(ends[1], u);
    ends[2] = Math.min(ends[2], v);
    ends[3] = Math.max(ends[3], v);
  }
  for (const i of [0, 2]) {
    const middle = (ends[i] + ends[i + 1]) / 2, least = 1e-3 * Math.max(kind === "map" && i ? 1 : 1e-3, Math.abs(middle));
    if (ends[i + 1] - ends[i] < least) [ends[i], ends[i + 1]] = [middle - least, middle + least];
  }
  frame.view = widened(ends, 0.09);
  drawAxes(ctx, frame, colours, 11);
  ctx.save();
  clipToInner(ctx, frame);
  for (const { orbit, place } of view.places) drawOrbit(ctx, frame, orbit, place, orbit.number === orbits.chosen, theme, colours);
  ctx.restore();
}

function drawOrbit(ctx, frame, orbit, [u, v, du, dv], isChosen, theme, colours) {
  const [x, y] = toPixel(frame, u, v);
  const inner = innerOf(frame);
  const half = [Math.abs(toPixel(frame, u + (du || 0), v)[0] - x), Math.abs(toPixel(frame, u, v + (dv || 0))[1] - y)];
  ctx.strokeStyle = ctx.fillStyle = colourOf(orbit, theme);
  ctx.lineWidth = 1;
  ctx.beginPath();
  if (half[0] > 3 && half[0] < inner.width) (ctx.moveTo(x - half[0], y), ctx.lineTo(x + half[0], y));
  if (half[1] > 3 && half[1] < inner.height) (ctx.moveTo(x, y - half[1]), ctx.lineTo(x, y + half[1]));
  ctx.stroke();
  ctx.beginPath();
  ctx.arc(x, y, isChosen ? 5.5 : 3.2, 0, 2 * Math.PI);
  if (orbit.reading.classification === "chaotic") ctx.stroke();
  else ctx.fill();
  if (!isChosen) return;
  ctx.strokeStyle = colours.text;
  ctx.lineWidth = 1.5;
  ctx.stroke();
}

// The orbit drawn nearest to a pixel, null where none is within reach.
export function orbitAt(view, x, y) {
  if (!insideFrame(view.frame, x, y)) return null;
  let best = 14, found = null;
  for (const { orbit, place } of view.places) {
    const [px, py] = toPixel(view.frame, place[0], place[1]);
    const away = Math.hypot(px - x, py - y);
    if (away < best) [best, found] = [away, orbit];
  }
  return found;
}
