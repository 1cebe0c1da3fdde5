// Configuration space: the region that the energy allows with lines of equal potential, the trace of the chosen orbit, where it is now.

import { rgbOf } from "./colours.js";
import { clipToInner, drawAxes, drawExtent, evenView, fittedContext, imageOf, makeFrame, toPixel, widened } from "./frame.js";
import { colourOf } from "./orbits.js";
import { reduced } from "./angles.js";
import { alphaBeta, stateNow } from "./motion.js";

const LEVELS = 6; // shades of the potential below the energy

export function makeConfiguration(canvas) {
  return { canvas, frame: makeFrame({ left: 42, right: 10, top: 8, bottom: 32 }), region: null, image: null, imageTheme: "", extent: null, still: null, stillOf: "", revision: 0 };
}

export function takeRegion(view, region) {
  Object.assign(view, { region, image: null, extent: null, revision: view.revision + 1 });
}

const placeOf = (view, kind, states, at) => (kind === "body" ? alphaBeta(states[at], states[at + 1], states[at + 2], states[at + 3]) : [0, 1].map((k) => reduced(states[at + k], view.region?.spans?.[k])));

function regionPicture(view, theme, colours) {
  if (view.image && view.imageTheme === theme) return view.image;
  const { values, width, height } = view.region;
  let least = 0;
  for (const value of values) if (value < least) least = value;
  const plot = rgbOf(colours.plot), deep = rgbOf(colours.accent);
  view.image = imageOf(width, height, (i) => {
    if (!(values[i] <= 0)) return [0, 0, 0, 0];
    const share = Math.min(LEVELS - 1, Math.floor((values[i] / least) * LEVELS)) / LEVELS;
    return [...plot.map((value, c) => value + (deep[c] - value) * 0.4 * share), 255];
  });
  view.imageTheme = theme;
  return view.image;
}

export function drawConfiguration(view, { kind, motion, orbit, labels, theme, colours }) {
  const { frame } = view;
  const ctx = fittedContext(view.canvas, frame);
  Object.assign(frame, { labels: view.region?.labels ?? labels.places, spans: view.region?.spans });
  const extent = view.region?.extent ?? traceExtent(view, motion, kind);
  if (!extent) return sayInstead(ctx, frame, colours, "Launch an orbit to see its trace.");
  frame.view = evenView(frame, widened(extent, 0.03));
  drawStill(view, { kind, motion, orbit, theme, colours }, extent);
  ctx.drawImage(view.still, 0, 0, frame.width, frame.height);
  const now = orbit && stateNow(motion);
  if (now) dot(ctx, toPixel(frame, ...placeOf(view, kind, now, 0)), colourOf(orbit, theme), colours);
  return undefined;
}

// What does not move, drawn once for each orbit, window of its motion, size and theme.
function drawStill(view, { kind, motion, orbit, theme, colours }, extent) {
  const { frame, canvas } = view;
  const key = [orbit?.number, orbit?.mark, motion.windows.map((part) => part.from), frame.view, canvas.width, canvas.height, theme, view.revision].join();
  if (view.stillOf === key) return;
  view.stillOf = key;
  view.still ??= document.createElement("canvas");
  Object.assign(view.still, { width: canvas.width, height: canvas.height });
  const ctx = view.still.getContext("2d");
  ctx.scale(canvas.width / frame.width, canvas.height / frame.height);
  ctx.save();
  clipToInner(ctx, frame);
  ctx.fillStyle = view.region ? colours.inaccessible : colours.plot;
  ctx.fillRect(0, 0, frame.width, frame.height);
  if (view.region) drawExtent(ctx, frame, regionPicture(view, theme, colours), extent, true);
  if (view.region) drawCuts(ctx, frame, cutsOf(view.region, kind), colours);
  if (orbit) {
    ctx.strokeStyle = colourOf(orbit, theme);
    ctx.lineWidth = 1;
    for (const part of motion.windows) trace(ctx, view, part, kind);
  }
  ctx.restore();
  drawAxes(ctx, frame, colours, 11);
}

// Pieces [u0, v0, u1, v1] of the edges of what is drawn at which the region goes on; not where an angle goes round or alpha is 0.
export function cutsOf({ values, width, height, extent: [u0, u1, v0, v1], spans }, kind) {
  const found = [], du = (u1 - u0) / width, dv = (v1 - v0) / height;
  const along = (count, cell, piece) => {
    for (let k = 0; k < count; k++) if (values[cell(k)] <= 0) found.push(piece(k));
  };
  const starts = (end) => kind === "body" && end <= 0;
  if (!spans?.[0]) {
    if (!starts(u0)) along(height, (k) => k * width, (k) => [u0, v0 + k * dv, u0, v0 + (k + 1) * dv]);
    along(height, (k) => (k + 1) * width - 1, (k) => [u1, v0 + k * dv, u1, v0 + (k + 1) * dv]);
  }
  if (!spans?.[1]) {
    if (!starts(v0)) along(width, (k) => k, (k) => [u0 + k * du, v0, u0 + (k + 1) * du, v0]);
    along(width, (k) => (height - 1) * width + k, (k) => [u0 + k * du, v1, u0 + (k + 1) * du, v1]);
  }
  return found;
}

// Mark where the region is cut, though orbits can go on.
function drawCuts(ctx, frame, cuts, colours) {
  if (!cuts.length) return;
  ctx.save();
  ctx.strokeStyle = colours.accent;
  ctx.lineWidth = 2;
  ctx.setLineDash([4, 4]);
  ctx.beginPath();
  let end = "";
  for (const [u0, v0, u1, v1] of cuts) {
    if (end !== [u0, v0].join()) ctx.moveTo(...toPixel(frame, u0, v0));
    ctx.lineTo(...toPixel(frame, u1, v1));
    end = [u1, v1].join();
  }
  ctx.stroke();
  ctx.restore();
}

function traceExtent(view, motion, kind) {
  if (view.extent || !motion.windows.length) return view.extent;
  const part = motion.windows[0];
  const found = [Infinity, -Infinity, Infinity, -Infinity];
  for (let i = 0; i < part.samples; i++) {
    const [u, v] = placeOf(view, kind, part.states, i * part.rows);
    found[0] = Math.min(found[0], u);
    found[1] = Math.max(found[1], u);
    found[2] = Math.min(found[2], v);
    found[3] = Math.max(found[3], v);
  }
  return (view.extent = widened(found, 0.1));
}

function trace(ctx, view, part, kind) {
  const { frame } = view, spans = view.region?.spans ?? [0, 0];
  let before = null;
  ctx.globalAlpha = 0.65;
  ctx.beginPath();
  for (let i = 0; i < part.samples; i++) {
    const place = placeOf(view, kind, part.states, i * part.rows), winds = before && spans.some((span, k) => span && Math.abs(place[k] - before[k]) > span / 2);
    if (i && !winds) ctx.lineTo(...toPixel(frame, ...place));
    else ctx.moveTo(...toPixel(frame, ...place));
    before = place;
  }
  ctx.stroke();
  ctx.globalAlpha = 1;
}

function dot(ctx, [x, y], colour, colours) {
  ctx.fillStyle = colour;
  ctx.strokeStyle = colours.text;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.arc(x, y, 5, 0, 2 * Math.PI);
  ctx.fill();
  ctx.stroke();
}

// A sentence where there is nothing to draw.
export function sayInstead(ctx, frame, colours, text) {
  ctx.fillStyle = colours.quiet;
  ctx.font = "13px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.textBaseline = "middle";
  ctx.fillText(text, frame.width / 2, frame.height / 2);
}
