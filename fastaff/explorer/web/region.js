// The part of configuration space that orbits of a surface reach: alpha, beta of a body, two coordinates of a plane system.

import { restingAt } from "./energy_surface.js";

const CELLS = 64, DOUBLINGS = 14;

/** Return {labels, extent, width, height, values}: potential with p_eta and p_gamma minus energy, in rows from the lowest;
 * NaN outside of the domain and where it is negative without being joined to the section; null where there is no point. */
export function regionOf(surface, reach, width, height) {
  const seed = seedOf(surface, reach);
  if (!seed) return null;
  const height0 = heightOver(surface), spans = surface.spans?.slice(0, 2) ?? [0, 0], winds = spans.some((span) => span > 0);
  const scale = Math.max(...seed.map(Math.abs), reach[1] - reach[0]);
  let extent = enclosing(height0, seed, scale, surface.body);
  if (extent === null) {
    const half = 1.5*Math.max(...reach.map(Math.abs));
    extent = surface.body ? [0, seed[0] + half, 0, seed[1] + half] : [-half, half, -half, half];
  } else {
    for (let pass = 0; pass < 2; pass++) extent = boxOf(filled(height0, seed, extent, CELLS, CELLS), extent, CELLS, CELLS, surface.body) ?? extent;
  }
  extent = extent.map((end, k) => (spans[k >> 1] ? (k % 2 - 0.5)*spans[k >> 1] : end));
  const { values, inside } = filled(height0, seed, extent, width, height);
  for (let i = 0; i < values.length; i++) if (values[i] <= 0 && !inside[i] && !winds) values[i] = NaN;
  const labels = surface.body ? ["α", "β"] : [...surface.coordinates];
  return { labels, extent, width, height, values, spans };
}

/** Potential minus energy as a function of the two coordinates. */
function heightOver(surface) {
  if (surface.spans) return (x, y) => (restingAt(surface.system, surface.P, x, y)?.value ?? NaN) - surface.energy;
  if (surface.body) return (alpha, beta) => -surface.room(alpha, beta)/(2*surface.mu);
  const z = new Float64Array(4);
  return (x, y) => {
    z[0] = x; z[1] = y;
    return surface.system.margin(z, surface.P) > 0 ? surface.system.potential(z, surface.P) - surface.energy : NaN;
  };
}

/** A place that an orbit of the section passes. */
function seedOf(surface, [u0, u1, v0, v1]) {
  for (const share of [0.5, 0.25, 0.75, 0.4, 0.6, 0.1, 0.9, 0.33, 0.02]) {
    for (const other of [0.5, 0.53, 0.4, 0.6, 0.2, 0.8]) {
      const z = surface.lift(u0 + (u1 - u0)*share, v0 + (v1 - v0)*other);
      if (z) return surface.body ? [Math.hypot(z[0], z[1]), Math.hypot(z[2], z[3])] : [z[0], z[1]];
    }
  }
  return null;
}

/** A box around the seed that the region does not leave, from a twentieth of a scale on; null where it goes on and on. */
function enclosing(heightAt, [q, r], scale, body) {
  let half = 0.05*scale || 0.05;
  for (let k = 0; k < DOUBLINGS; k++, half *= 2) {
    const extent = [q - half, q + half, r - half, r + half].map((end, i) => (body && i % 2 === 0 ? Math.max(0, end) : end));
    const found = filled(heightAt, [q, r], extent, CELLS, CELLS);
    const box = boxOf(found, extent, CELLS, CELLS, body);
    if (box && box.every((end, i) => (i % 2 ? end <= extent[i] : end >= extent[i] || (body && end <= 0)))) return box;
  }
  return null;
}

/** Heights on a grid, and which cells below zero are joined to the seed's. */
function filled(heightAt, [q, r], [q0, q1, r0, r1], width, height) {
  const values = new Float32Array(width*height), inside = new Uint8Array(width*height);
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) {
      values[row*width + column] = heightAt(q0 + (q1 - q0)*(column + 0.5)/width, r0 + (r1 - r0)*(row + 0.5)/height);
    }
  }
  const at = (low, high, x, count) => Math.min(count - 1, Math.max(0, Math.floor((x - low)/(high - low)*count)));
  const first = at(r0, r1, r, height)*width + at(q0, q1, q, width);
  const waiting = [first];
  inside[first] = 1;
  while (waiting.length) {
    const cell = waiting.pop(), column = cell % width, row = (cell - column)/width;
    for (const [c, l] of [[column + 1, row], [column - 1, row], [column, row + 1], [column, row - 1]]) {
      if (c < 0 || l < 0 || c >= width || l >= height || inside[l*width + c] || !(values[l*width + c] <= 0)) continue;
      inside[l*width + c] = 1;
      waiting.push(l*width + c);
    }
  }
  return { values, inside };
}

/** The extent of the joined cells with a cell around them. */
function boxOf({ inside }, [q0, q1, r0, r1], width, height, body) {
  let c0 = width, c1 = -1, l0 = height, l1 = -1;
  inside.forEach((is, cell) => {
    if (!is) return;
    const column = cell % width, row = (cell - column)/width;
    c0 = Math.min(c0, column); c1 = Math.max(c1, column); l0 = Math.min(l0, row); l1 = Math.max(l1, row);
  });
  if (c1 < 0) return null;
  const dq = (q1 - q0)/width, dr = (r1 - r0)/height;
  const least = (end) => (body ? Math.max(0, end) : end);
  return [least(q0 + (c0 - 1.5)*dq), q0 + (c1 + 2.5)*dq, least(r0 + (l0 - 1.5)*dr), r0 + (l1 + 2.5)*dr];
}
