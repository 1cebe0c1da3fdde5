// The cobweb of a map of one variable under the points of its plane: its graph, the diagonal, the steps of the chosen orbit.

import { toPixel } from "./frame.js";

const STEPS = 120; // iterates of the cobweb

export function drawCobweb(ctx, frame, { graph, periods }, orbit, colour, colours) {
  const [u0, u1, v0, v1] = frame.view;
  ctx.save();
  ctx.lineWidth = 1;
  ctx.strokeStyle = colours.line;
  stroke(ctx, frame, [Math.min(u0, v0), Math.min(u0, v0), Math.max(u1, v1), Math.max(u1, v1)]);
  ctx.lineWidth = 1.6;
  ctx.strokeStyle = colours.quiet;
  stroke(ctx, frame, graph);
  if (orbit && !orbit.hidden) {
    ctx.lineWidth = 1;
    ctx.globalAlpha = 0.7;
    ctx.strokeStyle = colour;
    stroke(ctx, frame, stepsOf(orbit, periods[0]));
  }
  ctx.restore();
}

// From the diagonal to the graph and back, once for each iterate; a step over a period is left out.
function stepsOf({ points, count, z0 }, period) {
  const found = z0 ? [z0[0], z0[0]] : [];
  for (let k = 0; k < Math.min(count, STEPS); k++) {
    const x = points[2 * k], image = points[2 * k + 1];
    if (period && k && Math.abs(x - points[2 * k - 2]) > period / 2) found.push(NaN, NaN);
    found.push(x, x, x, image, image, image);
  }
  return found;
}

// A line through points u, v, u, v, ..., broken where one is not a number.
function stroke(ctx, frame, points) {
  ctx.beginPath();
  for (let k = 0, begins = true; k < points.length; k += 2) {
    const isGap = Number.isNaN(points[k + 1]);
    if (!isGap) ctx[begins ? "moveTo" : "lineTo"](...toPixel(frame, points[k], points[k + 1]));
    begins = isGap;
  }
  ctx.stroke();
}
