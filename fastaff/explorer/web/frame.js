// A rectangle of a plane drawn on a canvas: from numbers to pixels and back, with axes. All lengths are CSS pixels.

import { drawLabel, ticksBetween } from "./text.js";

export function makeFrame(margins = { left: 54, right: 14, top: 10, bottom: 36 }) {
  return { view: [0, 1, 0, 1], width: 1, height: 1, margins, labels: ["", ""] };
}

export function innerOf(frame) {
  const { left, right, top, bottom } = frame.margins;
  return { x: left, y: top, width: Math.max(1, frame.width - left - right), height: Math.max(1, frame.height - top - bottom) };
}

export function toPixel(frame, u, v) {
  const inner = innerOf(frame);
  const [u0, u1, v0, v1] = frame.view;
  return [inner.x + ((u - u0) / (u1 - u0)) * inner.width, inner.y + ((v1 - v) / (v1 - v0)) * inner.height];
}

export function toPlane(frame, x, y) {
  const inner = innerOf(frame);
  const [u0, u1, v0, v1] = frame.view;
  return [u0 + ((x - inner.x) / inner.width) * (u1 - u0), v1 - ((y - inner.y) / inner.height) * (v1 - v0)];
}

export function insideFrame(frame, x, y) {
  const inner = innerOf(frame);
  return x >= inner.x && x <= inner.x + inner.width && y >= inner.y && y <= inner.y + inner.height;
}

// A view with the same unit of length on both axes that holds `extent`.
export function evenView(frame, extent) {
  const inner = innerOf(frame);
  const [u0, u1, v0, v1] = extent;
  const unit = Math.max((u1 - u0) / inner.width, (v1 - v0) / inner.height);
  const du = (unit * inner.width) / 2, dv = (unit * inner.height) / 2;
  const u = (u0 + u1) / 2, v = (v0 + v1) / 2;
  return [u - du, u + du, v - dv, v + dv];
}

// An extent with a margin around it.
export function widened(extent, share) {
  const [u0, u1, v0, v1] = extent;
  const du = (u1 - u0 || 1e-3) * share, dv = (v1 - v0 || 1e-3) * share;
  return [u0 - du, u1 + du, v0 - dv, v1 + dv];
}

// Fit a canvas to its place on the page and return its context, scaled to CSS pixels.
export function fittedContext(canvas, frame, scale) {
  const width = canvas.clientWidth || 1, height = canvas.clientHeight || 1;
  const ratio = scale ?? Math.min(3, globalThis.devicePixelRatio || 1);
  const columns = Math.round(width * ratio), rows = Math.round(height * ratio);
  if (canvas.width !== columns || canvas.height !== rows) {
    canvas.width = columns;
    canvas.height = rows;
  }
  frame.width = width;
  frame.height = height;
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return ctx;
}

export function clipToInner(ctx, frame) {
  const inner = innerOf(frame);
  ctx.beginPath();
  ctx.rect(inner.x, inner.y, inner.width, inner.height);
  ctx.clip();
}

export function drawAxes(ctx, frame, colours, size = 12) {
  const inner = innerOf(frame);
  const [u0, u1, v0, v1] = frame.view;
  const bottom = inner.y + inner.height;
  ctx.save();
  ctx.strokeStyle = colours.quiet;
  ctx.fillStyle = colours.text;
  ctx.lineWidth = 1;
  ctx.strokeRect(inner.x + 0.5, inner.y + 0.5, inner.width - 1, inner.height - 1);
  ctx.textBaseline = "alphabetic";
  ctx.beginPath();
  ctx.font = size - 1 + "px system-ui, sans-serif";
  ctx.textAlign = "center";
  let last = -Infinity;
  for (const tick of ticksBetween(u0, u1, Math.max(4, inner.width / 90), frame.spans?.[0])) {
    const x = Math.round(toPixel(frame, tick.value, v0)[0]) + 0.5;
    ctx.moveTo(x, bottom);
    ctx.lineTo(x, bottom - 5);
    const half = ctx.measureText(tick.text).width / 2;
    if (x - half < last + 6 || x + half > frame.width) continue;
    ctx.fillText(tick.text, x, bottom + size + 3);
    last = x + half;
  }
  ctx.textAlign = "right";
  ctx.textBaseline = "middle";
  for (const tick of ticksBetween(v0, v1, Math.max(3, inner.height / 48), frame.spans?.[1])) {
    const y = Math.round(toPixel(frame, u0, tick.value)[1]) + 0.5;
    ctx.moveTo(inner.x, y);
    ctx.lineTo(inner.x + 5, y);
    ctx.fillText(tick.text, inner.x - 5, Math.min(bottom - 4, Math.max(inner.y + 6, y)), inner.x - 5 - size - 4);
  }
  ctx.stroke();
  ctx.textBaseline = "alphabetic";
  drawLabel(ctx, frame.labels[0], inner.x + inner.width / 2, frame.height - 7, size + 1, "center");
  ctx.translate(size + 1, inner.y + inner.height / 2);
  ctx.rotate(-Math.PI / 2);
  drawLabel(ctx, frame.labels[1], 0, 0, size + 1, "center");
  ctx.restore();
}

// Draw an image whose pixels cover an extent, first row on top.
export function drawExtent(ctx, frame, image, extent, smooth) {
  const [x0, y1] = toPixel(frame, extent[0], extent[2]);
  const [x1, y0] = toPixel(frame, extent[1], extent[3]);
  ctx.imageSmoothingEnabled = smooth;
  ctx.drawImage(image, x0, y0, x1 - x0, y1 - y0);
}

// An image from numbers: rows from the lowest, `paint(i)` gives red, green, blue, alpha of number i.
export function imageOf(width, height, paint) {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const ctx = canvas.getContext("2d");
  const image = ctx.createImageData(width, height);
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) image.data.set(paint(row * width + column), 4 * ((height - 1 - row) * width + column));
  }
  ctx.putImageData(image, 0, 0);
  return canvas;
}
