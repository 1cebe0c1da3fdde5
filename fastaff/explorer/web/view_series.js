// The iterates of the chosen orbit of a map in their order: one coordinate of the plane against their number.

import { clipToInner, drawAxes, fittedContext, makeFrame, toPixel, widened } from "./frame.js";
import { colourOf } from "./orbits.js";
import { sayInstead } from "./view_configuration.js";

const MOST_DOTS = 6000;

export function makeSeries(canvas) {
  return { canvas, frame: makeFrame({ left: 50, right: 10, top: 8, bottom: 36 }), row: 1 };
}

export function drawSeries(view, { orbit, labels, theme, colours }) {
  const { frame, row } = view, ctx = fittedContext(view.canvas, frame);
  if (!orbit?.count) return sayInstead(ctx, frame, colours, "Launch an orbit to see its iterates.");
  const { points, count } = orbit, stride = Math.ceil(count / MOST_DOTS);
  let low = Infinity, high = -Infinity;
  for (let k = 0; k < count; k += stride) {
    low = Math.min(low, points[2 * k + row]);
    high = Math.max(high, points[2 * k + row]);
  }
  if (!(high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high)))) [low, high] = [low - (Math.abs(low) || 1), high + (Math.abs(high) || 1)];
  frame.view = [0, count + 1, ...widened([0, 1, low, high], 0.06).slice(2)];
  frame.labels = ["iterate", labels.series[row]];
  drawAxes(ctx, frame, colours, 11);
  ctx.save();
  clipToInner(ctx, frame);
  ctx.fillStyle = colourOf(orbit, theme);
  const size = count < 400 ? 2.4 : 1.4;
  for (let k = 0; k < count; k += stride) {
    const [x, y] = toPixel(frame, k + 1, points[2 * k + row]);
    ctx.fillRect(x - size / 2, y - size / 2, size, size);
  }
  return ctx.restore();
}
