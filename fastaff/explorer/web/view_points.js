// Points of all orbits by WebGL2: one buffer, one call. Positions are single precision relative to a place near the view, so
// that a deep zoom stays sharp; the double-precision points stay in the orbits.

import { colourBytes } from "./orbits.js";

const MOST_CHOSEN = 5e4; // points up to which the chosen orbit's are drawn larger
const FAR = 64; // half widths of the view from which single precision would show: 64 * 2^-24 of 400 pixels is 0.002

const STRIDE = 12; // bytes of a point: two floats and a colour of four bytes

const VERTEX = `#version 300 es
uniform vec2 middle; uniform vec2 scale; uniform float size;
layout(location = 0) in vec2 point; layout(location = 1) in vec4 tint;
out vec4 colour;
void main() {
  colour = tint;
  gl_Position = vec4((point - middle) * scale, 0.0, 1.0);
  gl_PointSize = size;
}`;

const ROUND_POINT = `#version 300 es
precision highp float;
uniform highp float size;
in vec4 colour; out vec4 shown;
void main() {
  float away = length(gl_PointCoord - 0.5) * size;
  float cover = clamp(size * 0.5 - away + 0.5, 0.0, 1.0);
  if (cover == 0.0) discard;
  shown = vec4(colour.rgb * cover, cover);
}`;

const SQUARE_POINT = `#version 300 es
precision mediump float;
in vec4 colour; out vec4 shown;
void main() { shown = colour; }`;

// A layer on a canvas, or null where the browser has no WebGL2.
export function makePointLayer(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: false, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: false });
  if (!gl) return null;
  const layer = { gl, canvas, origin: [0, 0], stored: 0, room: 0, waiting: new Map(), stale: true, chosenStale: true, chosenCount: 0, theme: "" };
  if (!prepareLayer(layer)) return null;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  layer.software = /swiftshader|llvmpipe|softpipe|software|basic render/i.test(named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "");
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => prepareLayer(layer));
  return layer;
}

function prepareLayer(layer) {
  const { gl } = layer;
  layer.round = pointProgram(gl, ROUND_POINT);
  layer.square = pointProgram(gl, SQUARE_POINT);
  if (!layer.round || !layer.square) return false;
  layer.all = pointArray(gl);
  layer.chosen = pointArray(gl);
  Object.assign(layer, { stale: true, chosenStale: true, room: 0, stored: 0 });
  // A point outside, so that shaders are ready before the first click.
  gl.bindBuffer(gl.ARRAY_BUFFER, layer.all.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([9, 9, 0]), gl.DYNAMIC_DRAW);
  for (const size of [1, 3]) drawArray(layer, layer.all, 1, size, [0, 0], [1, 1]);
  return true;
}

function pointProgram(gl, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  return { program, at: Object.fromEntries(["middle", "scale", "size"].map((name) => [name, gl.getUniformLocation(program, name)])) };
}

function pointArray(gl) {
  const array = gl.createVertexArray(), buffer = gl.createBuffer();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, STRIDE, 0);
  gl.enableVertexAttribArray(1);
  gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, STRIDE, 8);
  return { array, buffer };
}

// The bytes of points of orbits: parts are {orbit, first}.
function bytesOf(layer, parts, room) {
  const bytes = new ArrayBuffer(STRIDE * room), floats = new Float32Array(bytes), colours = new Uint32Array(bytes);
  const [u, v] = layer.origin;
  let k = 0;
  for (const { orbit, first } of parts) {
    const p = orbit.points, [red, green, blue] = colourBytes(orbit, layer.theme);
    const colour = ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
    for (let i = 2 * first; i < 2 * orbit.count; i += 2) {
      floats[k++] = p[i] - u;
      floats[k++] = p[i + 1] - v;
      colours[k++] = colour;
    }
  }
  return bytes;
}

const sizeOf = (parts) => parts.reduce((sum, { orbit, first }) => sum + orbit.count - first, 0);

// New points of an orbit, from `first` on: they go to the buffer together with those of others, before the next drawing.
export function appendPoints(layer, orbit, first) {
  if (!layer.stale && !orbit.hidden && !layer.waiting.has(orbit)) layer.waiting.set(orbit, first);
}

function storeWaiting(layer, chosen) {
  const parts = [...layer.waiting].map(([orbit, first]) => ({ orbit, first }));
  const count = sizeOf(parts);
  layer.waiting.clear();
  if (parts.some(({ orbit }) => orbit.number === chosen)) layer.chosenStale = true;
  if (layer.stored + count > layer.room) {
    layer.stale = true;
    return;
  }
  const { gl } = layer;
  gl.bindBuffer(gl.ARRAY_BUFFER, layer.all.buffer);
  gl.bufferSubData(gl.ARRAY_BUFFER, STRIDE * layer.stored, bytesOf(layer, parts, count));
  layer.stored += count;
}

// All points anew, as when orbits have gone, the colours are others or the view is far away.
function rebuild(layer, orbits, origin, theme) {
  const { gl } = layer;
  const parts = [...orbits.shown.values()].filter((orbit) => !orbit.hidden).map((orbit) => ({ orbit, first: 0 }));
  layer.waiting.clear();
  Object.assign(layer, { origin, theme, stored: sizeOf(parts), stale: false, chosenStale: true });
  layer.room = Math.max(4096, Math.ceil(layer.stored * 1.6));
  gl.bindBuffer(gl.ARRAY_BUFFER, layer.all.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, bytesOf(layer, parts, layer.room), gl.DYNAMIC_DRAW);
}

function writeChosen(layer, orbit) {
  const { gl } = layer;
  layer.chosenCount = orbit && !orbit.hidden && orbit.count < MOST_CHOSEN ? orbit.count : 0;
  layer.chosenStale = false;
  if (!layer.chosenCount) return;
  gl.bindBuffer(gl.ARRAY_BUFFER, layer.chosen.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, bytesOf(layer, [{ orbit, first: 0 }], orbit.count), gl.DYNAMIC_DRAW);
}

// Draw what the frame shows, nothing where orbits is null; `inner` is its rectangle in CSS pixels, ratio the pixels of a CSS pixel.
export function drawPoints(layer, orbits, frame, inner, ratio, theme) {
  const { gl, canvas } = layer;
  if (gl.isContextLost()) return;
  const width = Math.round(frame.width * ratio), height = Math.round(frame.height * ratio);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  gl.disable(gl.SCISSOR_TEST);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT);
  if (!orbits) {
    layer.stale = true;
    return;
  }
  const [u0, u1, v0, v1] = frame.view;
  const middle = [(u0 + u1) / 2, (v0 + v1) / 2];
  const away = Math.max(Math.abs(middle[0] - layer.origin[0]) / (u1 - u0), Math.abs(middle[1] - layer.origin[1]) / (v1 - v0));
  if (layer.waiting.size && !layer.stale) storeWaiting(layer, orbits.chosen);
  if (layer.stale || theme !== layer.theme || away > FAR / 2) rebuild(layer, orbits, middle, theme);
  if (layer.chosenStale) writeChosen(layer, orbits.shown.get(orbits.chosen));
  const box = [inner.x * ratio, (frame.height - inner.y - inner.height) * ratio, inner.width * ratio, inner.height * ratio].map(Math.round);
  gl.viewport(...box);
  gl.scissor(...box);
  gl.enable(gl.SCISSOR_TEST);
  const shift = [middle[0] - layer.origin[0], middle[1] - layer.origin[1]], scale = [2 / (u1 - u0), 2 / (v1 - v0)];
  const size = ratio * pointSize(orbits.total);
  drawArray(layer, layer.all, layer.stored, size, shift, scale);
  drawArray(layer, layer.chosen, layer.chosenCount, size + ratio, shift, scale);
}

// The size of a point, in CSS pixels, when there are so many.
export function pointSize(total) {
  return total < 2e4 ? 2.6 : total < 1e5 ? 1.8 : 1;
}

// Round points with soft edges; square ones where they are so small that it cannot be seen.
function drawArray(layer, { array }, count, size, shift, scale) {
  if (!count) return;
  const { gl } = layer;
  const { program, at } = size < 2 ? layer.square : layer.round;
  if (size < 2) gl.disable(gl.BLEND);
  else gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.useProgram(program);
  gl.uniform2f(at.middle, ...shift);
  gl.uniform2f(at.scale, ...scale);
  gl.uniform1f(at.size, size);
  gl.bindVertexArray(array);
  gl.drawArrays(gl.POINTS, 0, count);
}
