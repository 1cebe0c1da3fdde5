// Files for the reader: the picture of the section, and jobs that `fastaff run` takes.

import { drawSection } from "./view_section.js";
import { drawLabel, greek, shownNumber } from "./text.js";

export function offerFile(name, parts, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(parts, { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 20000);
}

// One line that says which section of which system this is.
export function captionOf(state, system) {
  const parts = Object.entries(state.parameters).map(([name, value]) => greek(name) + " = " + shownNumber(value, 6));
  if (system.kind === "map") {
    const plane = state.section.split(",");
    for (const [name, value] of Object.entries(state.others)) if (!plane.includes(name)) parts.push(greek(name) + " = " + shownNumber(value, 6));
    if (system.driven) parts.push("stroboscopic at t = " + shownNumber(state.phase, 6));
    return parts.join(", ");
  }
  if (state.energy !== null) parts.push("E = " + shownNumber(state.energy, 8));
  if (system.kind === "body") parts.push("p_η = " + shownNumber(state.p_eta, 6), "p_γ = " + shownNumber(state.p_gamma, 6));
  const crossed = state.section === "alpha-turning" ? "p_α = 0" : state.section === "beta-turning" ? "p_β = 0" : greek(state.section.replace("=c", "").replace("area", "D₁D₂")) + " = " + shownNumber(state.constant, 6);
  parts.push("section " + crossed + { 1: ", increasing", "-1": ", decreasing", 0: ", both ways" }[state.direction]);
  return parts.join(", ");
}

// The picture of the section with axes, twice as fine as on the screen, as a Blob.
export function pictureOf(section, scene, title, caption) {
  const scale = 2, head = 50;
  for (let i = 0; i < 400 && drawSection(section, scene, scale); i++);
  const { width, height } = section.frame;
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: width * scale, height: (height + head) * scale });
  const ctx = canvas.getContext("2d");
  ctx.scale(scale, scale);
  ctx.fillStyle = scene.colours.plot;
  ctx.fillRect(0, 0, width, height + head);
  ctx.fillStyle = scene.colours.text;
  drawLabel(ctx, title, 14, 20, 15);
  ctx.fillStyle = scene.colours.quiet;
  const room = width - 28;
  const size = Math.min(12, (12 * room) / Math.max(1, drawLabel(document.createElement("canvas").getContext("2d"), caption, 0, 0, 12)));
  drawLabel(ctx, caption, 14, 40, size);
  for (const layer of [section.canvases.back, section.canvases.points, section.canvases.front]) {
    if (layer.width && layer.height) ctx.drawImage(layer, 0, head, width, height);
  }
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

const tomlText = (text) => JSON.stringify(text).replaceAll("\u007f", "\\u007f");
const tomlNumber = (value) => (Number.isInteger(value) && Math.abs(value) < 1e15 ? value.toFixed(1) : String(value).replace("e+", "e"));
const tomlKey = (name) => (/^[A-Za-z0-9_-]+$/.test(name) ? name : tomlText(name));

function tomlModel(state, given) {
  // A model keeps a number that is its drive_period as a field "period", which no parameter of its text can be.
  const keyOf = (name) => (name === "period" && "drive_period" in given ? "drive_period" : name);
  const parameters = Object.entries(state.parameters).map(([name, value]) => [keyOf(name), value]);
  const job = { ...given, ...Object.fromEntries(parameters.filter(([name]) => name in given)) };
  const lines = ["[model]"];
  for (const [key, value] of Object.entries(job)) lines.push(key + " = " + (Array.isArray(value) ? "[" + value.map(tomlText).join(", ") + "]" : tomlText(String(value))));
  const own = "formula" in job || "hamiltonian" in job || state.energy === null;
  const letters = [];
  for (const [name, value] of parameters) {
    if (name in given) continue;
    if (own && name !== "mu") letters.push(tomlKey(name) + " = " + tomlNumber(value));
    else lines.push(tomlKey(name) + " = " + tomlNumber(value));
  }
  if (letters.length) lines.push("parameter = {" + letters.join(", ") + "}");
  return lines;
}

// A job as TOML. starts: lines of its table [initial_conditions]; null where no text describes the system.
export function jobText(state, system, starts) {
  if (!system.job) return null;
  const crossings = ["[poincare]", "crossings = " + state.crossings, ""];
  const run = ["[options]", "scheme = " + tomlText(state.scheme), "accuracy = " + String(state.accuracy), ""];
  if (system.driven) return [...tomlModel(state, system.job), "", "[energy_surface]", "section = " + tomlText("t=" + state.phase), "", "[initial_conditions]", ...starts, "", ...run, ...crossings].join("\n");
  if (system.kind === "map") return [...tomlModel(state, system.job), "", "[initial_conditions]", ...starts, "", ...crossings].join("\n");
  const section = state.section.replace("=c", "=" + String(state.constant));
  return [
    ...tomlModel(state, system.job),
    "",
    "[energy_surface]",
    ...(state.energy === null ? [] : ["energy = " + tomlNumber(state.energy)]),
    ...(system.kind === "body" ? ["p_eta = " + tomlNumber(state.p_eta), "p_gamma = " + tomlNumber(state.p_gamma)] : []),
    "section = " + tomlText(section),
    "direction = " + state.direction,
    "",
    "[initial_conditions]",
    ...starts,
    "",
    ...run,
    ...crossings,
  ].join("\n");
}

export function fileOfStarts(name) {
  return ["file = " + tomlText(name)];
}

// A grid over the view of a map's plane, of angles within half a period of 0.
export function planeOfStarts(view, cells, state, periods) {
  const plane = state.section.split(","), ends = view.map((end, k) => (periods[k >> 1] ? Math.min(periods[k >> 1] / 2, Math.max(-periods[k >> 1] / 2, end)) : end));
  const axes = plane.map((name, k) => tomlText(name + "=" + ends[2 * k] + ":" + ends[2 * k + 1] + ":" + cells));
  const others = Object.entries(state.others).filter(([name, value]) => !plane.includes(name) && value !== 0);
  const fixed = others.map(([name, value]) => tomlText(name + "=" + value));
  return ["axes = [" + axes.join(", ") + "]", ...(fixed.length ? ["fixed = [" + fixed.join(", ") + "]"] : [])];
}

export function gridOfStarts(view, cells) {
  const range = (low, high) => tomlText(low + ":" + high);
  return ["grid = " + tomlText(cells + "x" + cells), "q_range = " + range(view[0], view[1]), "p_range = " + range(view[2], view[3])];
}

// Phase points as an .npy file (NumPy's format 1.0): float64, (2n, orbits), rows one after another.
export function npyOf(states) {
  const rows = states[0].length;
  const head = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + rows + ", " + states.length + "), }";
  const padded = head.padEnd(Math.ceil((head.length + 11) / 64) * 64 - 11) + "\n";
  const bytes = new Uint8Array(10 + padded.length + 8 * rows * states.length);
  bytes.set([0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, padded.length & 255, padded.length >> 8]);
  bytes.set(new TextEncoder().encode(padded), 10);
  const numbers = new DataView(bytes.buffer, 10 + padded.length);
  for (let row = 0; row < rows; row++) states.forEach((state, i) => numbers.setFloat64(8 * (row * states.length + i), state[row], true));
  return bytes;
}
