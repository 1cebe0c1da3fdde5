// A density image: how many points fall into each pixel of the view, counted from the double-precision points.

import { MAP_TABLE } from "./colours.js";

const SLICE = 1.5e6; // points counted in one frame

export function makeDensity() {
  return { key: "", counts: new Uint32Array(0), width: 0, height: 0, todo: [], most: 0, canvas: null, image: null, changed: true };
}

// Begin anew where the view, its size or the set of orbits is another.
export function aimDensity(density, orbits, view, width, height, revision) {
  const key = [view, width, height, revision].join();
  if (key === density.key) return;
  Object.assign(density, { key, view: [...view], width, height, counts: new Uint32Array(width * height), most: 0, changed: true });
  density.todo = [...orbits.shown.values()].filter((orbit) => !orbit.hidden).map((orbit) => ({ orbit, from: 0, to: orbit.count }));
}

// New points of an orbit, from `first` on.
export function queueDensity(density, orbit, first) {
  if (density.key && !orbit.hidden) density.todo.push({ orbit, from: first, to: orbit.count });
}

// Count some of what waits; true if there is more.
export function countDensity(density) {
  let left = SLICE;
  while (left > 0 && density.todo.length) {
    const part = density.todo[density.todo.length - 1];
    const to = Math.min(part.to, part.from + left);
    countPart(density, part.orbit.points, part.from, to);
    left -= to - part.from;
    part.from = to;
    if (part.from === part.to) density.todo.pop();
    density.changed = true;
  }
  return density.todo.length > 0;
}

function countPart(density, p, from, to) {
  const { counts, width, height, view: [u0, u1, v0, v1] } = density;
  const su = width / (u1 - u0), sv = height / (v1 - v0);
  let most = density.most;
  for (let i = 2 * from; i < 2 * to; i += 2) {
    const x = Math.floor((p[i] - u0) * su), y = Math.floor((v1 - p[i + 1]) * sv);
    if (x < 0 || y < 0 || x >= width || y >= height) continue;
    const count = ++counts[y * width + x];
    if (count > most) most = count;
  }
  density.most = most;
}

// How many points lie within `reach` pixels of pixel (x, y).
export function countAround(density, x, y, reach) {
  let sum = 0;
  for (let row = Math.max(0, y - reach); row <= Math.min(density.height - 1, y + reach); row++) {
    for (let column = Math.max(0, x - reach); column <= Math.min(density.width - 1, x + reach); column++) sum += density.counts[row * density.width + column];
  }
  return sum;
}

// The image of the counts, colours by their logarithm; dark is few on dark ground, many on light ground.
export function densityImage(density, theme) {
  if (!density.changed && density.theme === theme) return density.canvas;
  const { counts, width, height } = density;
  if (!density.canvas || density.canvas.width !== width || density.canvas.height !== height) {
    density.canvas = document.createElement("canvas");
    Object.assign(density.canvas, { width, height });
    density.image = null;
  }
  const ctx = density.canvas.getContext("2d");
  density.image ??= ctx.createImageData(width, height);
  const pixels = new Uint32Array(density.image.data.buffer);
  const shades = new Uint32Array(256);
  for (let i = 0; i < 256; i++) {
    const at = 3 * (theme === "dark" ? 40 + Math.round((i * 215) / 255) : 225 - Math.round((i * 225) / 255));
    shades[i] = 0xff000000 | (MAP_TABLE[at + 2] << 16) | (MAP_TABLE[at + 1] << 8) | MAP_TABLE[at];
  }
  const scale = 255 / Math.log(Math.max(2, density.most));
  for (let i = 0; i < counts.length; i++) pixels[i] = counts[i] ? shades[Math.min(255, Math.round(Math.log(counts[i]) * scale))] : 0;
  ctx.putImageData(density.image, 0, 0);
  Object.assign(density, { changed: false, theme });
  return density.canvas;
}
