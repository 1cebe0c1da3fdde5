// The same points without a graphics card: written into the pixels of an image, which on a processor is faster than WebGL.

import { colourBytes } from "./orbits.js";

export function makeRaster() {
  return { canvas: document.createElement("canvas"), image: null };
}

// An image of the points in a view, width by height pixels; `side` is the size of a point.
export function rasterPoints(raster, orbits, view, width, height, side, theme) {
  const { canvas } = raster;
  if (!raster.image || canvas.width !== width || canvas.height !== height) {
    Object.assign(canvas, { width, height });
    raster.image = canvas.getContext("2d").createImageData(width, height);
  }
  const pixels = new Uint32Array(raster.image.data.buffer);
  pixels.fill(0);
  const chosen = orbits.shown.get(orbits.chosen);
  for (const orbit of orbits.shown.values()) if (orbit !== chosen) writeOrbit(pixels, orbit, view, width, height, side, theme);
  if (chosen) writeOrbit(pixels, chosen, view, width, height, side + 1, theme);
  canvas.getContext("2d").putImageData(raster.image, 0, 0);
  return canvas;
}

function writeOrbit(pixels, orbit, [u0, u1, v0, v1], width, height, side, theme) {
  if (orbit.hidden) return;
  const [red, green, blue] = colourBytes(orbit, theme);
  const colour = ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
  const su = width / (u1 - u0), sv = height / (v1 - v0), half = (side - 1) / 2;
  const p = orbit.points, end = 2 * orbit.count;
  if (side === 1) {
    for (let i = 0; i < end; i += 2) {
      const x = (p[i] - u0) * su, y = (v1 - p[i + 1]) * sv;
      if (x >= 0 && y >= 0 && x < width && y < height) pixels[(y | 0) * width + (x | 0)] = colour;
    }
    return;
  }
  for (let i = 0; i < end; i += 2) {
    const x = Math.floor((p[i] - u0) * su - half), y = Math.floor((v1 - p[i + 1]) * sv - half);
    if (!(x > -side && y > -side && x < width && y < height)) continue;
    for (let row = Math.max(0, y); row < Math.min(height, y + side); row++) {
      for (let column = Math.max(0, x); column < Math.min(width, x + side); column++) {
        const corner = side > 2 && (row === y || row === y + side - 1) && (column === x || column === x + side - 1);
        if (!corner) pixels[row * width + column] = colour;
      }
    }
  }
}
