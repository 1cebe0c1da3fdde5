// The body itself: the image of the unit disc under phi, with its material lines, beside the disc undeformed.

import { fittedContext, makeFrame } from "./frame.js";
import { stateNow } from "./motion.js";
import { colourOf } from "./orbits.js";
import { sayInstead } from "./view_configuration.js";

const RINGS = [1, 2 / 3, 1 / 3];
const SPOKES = 8; // half lines from the centre
const ROUND = 72; // points of a ring

export function makeBodyView(canvas) {
  return { canvas, frame: makeFrame({ left: 0, right: 0, top: 0, bottom: 0 }), reach: 1.2, of: null };
}

// The largest stretch there is in the windows of the motion, so that the body stays in the picture.
function reachOf(view, motion) {
  const key = motion.orbit + ":" + motion.windows.length + ":" + (motion.windows.at(-1)?.from ?? 0);
  if (view.of === key) return view.reach;
  let most = 1.05;
  for (const part of motion.windows) {
    for (let i = 0; i < part.samples; i++) {
      const [x, y, z, u] = part.states.subarray(i * part.rows, i * part.rows + 4);
      most = Math.max(most, (Math.hypot(x + u, z - y) + Math.hypot(x - u, y + z)) / 2);
    }
  }
  view.reach = view.of?.startsWith(motion.orbit + ":") ? Math.max(view.reach, most) : most;
  view.of = key;
  return view.reach;
}

export function drawBody(view, { motion, orbit, theme, colours }) {
  const { frame } = view;
  const ctx = fittedContext(view.canvas, frame);
  const now = orbit && stateNow(motion);
  if (!now) return sayInstead(ctx, frame, colours, orbit ? "Computing the motion." : "Launch an orbit to see the body move.");
  const [x, y, z, u] = now;
  const scale = (0.46 * Math.min(frame.width, frame.height)) / reachOf(view, motion);
  const colour = colourOf(orbit, theme);
  ctx.translate(frame.width / 2, frame.height / 2);
  ctx.lineJoin = "round";
  const path = (points, closed) => {
    ctx.beginPath();
    for (const [a, b] of points) ctx.lineTo(scale * (x * a + y * b), -scale * (z * a + u * b));
    if (closed) ctx.closePath();
  };
  ctx.strokeStyle = colours.quiet;
  ctx.setLineDash([4, 4]);
  ctx.beginPath();
  ctx.arc(0, 0, scale, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.setLineDash([]);
  for (const ring of RINGS) {
    path(circle(ring), true);
    if (ring === 1) {
      ctx.globalAlpha = 0.2;
      ctx.fillStyle = colour;
      ctx.fill();
      ctx.globalAlpha = 1;
    }
    ctx.strokeStyle = colour;
    ctx.lineWidth = ring === 1 ? 2.2 : 1;
    ctx.stroke();
  }
  for (let k = 0; k < SPOKES; k++) {
    const angle = (2 * Math.PI * k) / SPOKES;
    path([[0, 0], [Math.cos(angle), Math.sin(angle)]], false);
    ctx.strokeStyle = k === 0 ? colours.text : colour;
    ctx.lineWidth = k === 0 ? 2.6 : 1;
    ctx.stroke();
  }
  ctx.fillStyle = colours.text;
  ctx.beginPath();
  ctx.arc(scale * x, -scale * z, 3.6, 0, 2 * Math.PI);
  ctx.fill();
}

const circle = (radius) => Array.from({ length: ROUND }, (_, k) => [radius * Math.cos((2 * Math.PI * k) / ROUND), radius * Math.sin((2 * Math.PI * k) / ROUND)]);
