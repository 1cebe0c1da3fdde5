// A stored chaos or frequency map that lies under the section: its numbers, image, colour bar and where it applies.

import { MAP_TABLE } from "./colours.js";
import { imageOf } from "./frame.js";
import { drawLabel, shownNumber, ticksBetween } from "./text.js";

export const MAP_COVER = 0.6; // how much of the ground the map covers, so that points on it are seen

// The record of the set-up with its numbers and image; null where there is none.
export function makeBackground(record) {
  if (!record) return null;
  const bytes = Uint8Array.from(atob(record.values), (sign) => sign.charCodeAt(0));
  const values = new Float32Array(bytes.buffer);
  const background = { ...record, values };
  background.image = imageOf(record.width, record.height, (i) => {
    const share = shareOf(background, values[i]);
    if (Number.isNaN(share)) return [0, 0, 0, 0];
    const at = 3 * Math.round(255 * share);
    return [MAP_TABLE[at], MAP_TABLE[at + 1], MAP_TABLE[at + 2], 255];
  });
  return background;
}

// Where a value is between low (0) and high (1) of the colours.
function shareOf(background, value) {
  const { low, high, log } = background;
  const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Number.isNaN(value) ? NaN : Math.min(1, Math.max(0, share));
}

// Where an axis from low to high has a coordinate of that period, or none.
function placeOn(x, low, high, period) {
  if (!period || (x >= low && x < high)) return x;
  const turned = x - period * Math.floor((x - low) / period);
  return turned < high ? turned : NaN;
}

// The extents at which a map is seen in the first period of its axes.
export function backgroundExtents(background, periods) {
  const [u0, u1, v0, v1] = background.extent;
  const shifts = (low, high, period) => {
    if (!period) return [0];
    const found = [];
    for (let k = Math.ceil(-high / period - 0.5); low + k * period < period / 2 && found.length < 4; k++) if (high + k * period > -period / 2) found.push(k * period);
    return found;
  };
  const [first, second] = periods ?? [0, 0];
  return shifts(u0, u1, first).flatMap((du) => shifts(v0, v1, second).map((dv) => [u0 + du, u1 + du, v0 + dv, v1 + dv]));
}

// The value of the cell at (u, v), NaN where there is none.
export function backgroundValue(background, uGiven, vGiven, periods) {
  const [u0, u1, v0, v1] = background.extent, [first, second] = periods ?? [0, 0];
  const u = placeOn(uGiven, u0, u1, first), v = placeOn(vGiven, v0, v1, second);
  if (Number.isNaN(u + v)) return NaN;
  const column = Math.floor(((u - u0) / (u1 - u0)) * background.width), row = Math.floor(((v - v0) / (v1 - v0)) * background.height);
  if (column < 0 || row < 0 || column >= background.width || row >= background.height) return NaN;
  return background.values[row * background.width + column];
}

// The first thing in which the state is not that of the map, as a sentence; null where it applies.
export function backgroundDiffers(background, state) {
  const of = background.of ?? {};
  for (const name of ["system", "energy", "section", "constant", "direction", "p_eta", "p_gamma"]) {
    const mine = of[name] ?? null, other = state[name] ?? null;
    if (name in of && mine !== other) return name.replace("_", " ") + " " + (typeof mine === "number" ? shownNumber(mine, 6) : mine);
  }
  for (const [name, value] of Object.entries(of.others ?? {})) {
    if (state.others[name] !== value && !state.section.split(",").includes(name)) return name + " = " + shownNumber(value, 6);
  }
  for (const [name, value] of Object.entries(of.parameters ?? {})) {
    if (state.parameters[name] !== undefined && state.parameters[name] !== value) return name + " = " + shownNumber(value, 6);
  }
  return null;
}

// A bar of the colours at the right end of a rectangle of the context.
export function drawColourBar(ctx, background, inner, colours) {
  const width = 11, height = Math.min(inner.height * 0.6, 220), x = inner.x + inner.width + 12, y = inner.y + 18;
  const low = background.log ? Math.log10(background.low) : background.low, high = background.log ? Math.log10(background.high) : background.high;
  ctx.globalAlpha = MAP_COVER;
  for (let i = 0; i < Math.round(height); i++) {
    const at = 3 * Math.round(255 * (1 - i / (height - 1)));
    ctx.fillStyle = "rgb(" + MAP_TABLE.slice(at, at + 3).join() + ")";
    ctx.fillRect(x, Math.round(y) + i, width, 1);
  }
  ctx.globalAlpha = 1;
  ctx.strokeStyle = colours.quiet;
  ctx.fillStyle = colours.text;
  ctx.strokeRect(x + 0.5, y + 0.5, width - 1, height);
  ctx.textBaseline = "middle";
  for (const tick of ticksBetween(low, high, height / 36)) {
    if (background.log && tick.value !== Math.round(tick.value)) continue;
    const at = y + height - ((tick.value - low) / (high - low)) * height;
    ctx.fillRect(x + width - 3, at, 3, 1);
    ctx.font = "11px system-ui, sans-serif";
    ctx.textAlign = "left";
    ctx.fillText(background.log ? shownNumber(10 ** tick.value, 1) : tick.text, x + width + 4, at);
  }
  ctx.textBaseline = "alphabetic";
  drawLabel(ctx, background.label, inner.x + inner.width + 58, inner.y + 10, 12, "right");
}
