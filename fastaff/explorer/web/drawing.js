// One loop of frames: only what has changed is drawn, and nothing runs while nothing changes.

import { backgroundDiffers, backgroundValue } from "./background.js";
import { innerOf, insideFrame, toPlane } from "./frame.js";
import { askMotion, tickMotion } from "./motion.js";
import { repaint, showScale } from "./paint.js";
import { hasRotation, nearestPoint, summaryOf } from "./orbits.js";
import { systemOf } from "./state.js";
import { drawTable } from "./table.js";
import { greek, shownNumber, shownRotation, writeLabel } from "./text.js";
import { askBifurcations, drawBifurcations } from "./view_bifurcations.js";
import { drawBody } from "./view_body.js";
import { drawConfiguration } from "./view_configuration.js";
import { countAround } from "./view_density.js";
import { drawFrequency } from "./view_frequency.js";
import { drawSection, isAllowed, showsDensity } from "./view_section.js";
import { drawSeries } from "./view_series.js";

const CALM = 160; // milliseconds between two drawings of table and frequency view

export function makeDrawing(app) {
  app.waiting = false;
  app.lastCalm = 0;
  app.frames = 0;
  app.drawSection = () => drawSection(app.section, sceneOf(app));
}

// Ask that parts be drawn in the next frame: "section", "configuration", "body", "frequency", "table", "hover".
export function askFrame(app, ...names) {
  for (const name of names) app.dirty.add(name);
  if (app.waiting) return;
  app.waiting = true;
  requestAnimationFrame((now) => {
    app.waiting = false;
    drawFrame(app, now);
  });
}

export function sceneOf(app) {
  const system = systemOf(app.setup, app.state);
  const orbit = app.orbits.shown.get(app.orbits.chosen) ?? null;
  const labels = { section: app.section.surface?.labels ?? ["u", "v"], places: system.kind === "body" ? ["α", "β"] : system.coordinates };
  labels.series = system.line ? [system.coordinates[0], system.coordinates[0]].map(greek) : labels.section;
  return { isLine: Boolean(system.line), orbits: app.orbits, background: app.background, state: app.state, theme: app.theme, colours: app.colours, kind: system.kind, motion: app.motion, orbit, labels };
}

function drawFrame(app, now) {
  const { dirty, motion } = app;
  app.frames++;
  const scene = sceneOf(app);
  const next = [];
  if (app.paintStale && now - (app.paintedAt ?? -Infinity) > CALM) {
    Object.assign(app, { paintStale: false, paintedAt: now });
    if (repaint(app.orbits)) {
      if (app.section.layer) app.section.layer.stale = true;
      for (const name of ["section", "configuration", "body", "frequency", "table"]) dirty.add(name);
    }
    showScale(app.part("scale"), app.orbits, app.theme);
  } else if (app.paintStale) next.push("paint");
  dirty.delete("paint");
  if (dirty.delete("section") && drawSection(app.section, scene)) next.push("section");
  if (dirty.delete("hover")) drawReadout(app);
  if (dirty.has("table") || dirty.has("frequency")) {
    if (now - app.lastCalm > CALM) {
      app.lastCalm = now;
      if (dirty.has("table") && scene.kind === "map") drawSeries(app.series, scene);
      if (dirty.delete("table")) {
        drawTable(app.table, app.orbits, app.theme);
        app.part("empty").hidden = app.orbits.shown.size > 0;
        app.part("count").textContent = summaryOf(app.orbits) + " · " + app.orbits.total.toLocaleString("en").replaceAll(",", "\u202f") + " points" + (showsDensity(app.section, app.orbits) ? ", density" : "");
      }
      if (dirty.delete("frequency")) {
        if (scene.isLine) drawDiagram(app, scene);
        else drawFrequency(app.frequency, scene);
      }
    } else next.push(dirty.has("table") ? "table" : "frequency");
  }
  const moves = scene.kind !== "map";
  if (moves && tickMotion(motion, now) && scene.orbit) {
    next.push("moving");
    dirty.add("configuration");
    if (scene.kind === "body") dirty.add("body");
  }
  if (moves && scene.orbit) askMotion(motion, scene.orbit);
  dirty.delete("moving");
  if (dirty.delete("configuration") && moves) {
    drawConfiguration(app.configuration, scene);
    app.part("moment").textContent = scene.orbit && motion.windows.length ? "t = " + motion.time.toFixed(1) : "";
  }
  if (dirty.delete("body") && scene.kind === "body") drawBody(app.body, scene);
  if (next.length || dirty.size) askFrame(app, ...next);
}

// The bifurcation diagram of a map of one variable, from where the chosen orbit starts.
function drawDiagram(app, { state, orbit, labels, theme, colours }) {
  const { bifurcations: view, panel, ready } = app, limits = (name) => [panel.parameters[name].from, panel.parameters[name].to];
  if (ready && app.section.surface) askBifurcations(view, { state, orbit, limits, send: app.send });
  drawBifurcations(view, { state, label: labels.series[0], theme, colours });
}

const IMAGE_DIGITS = 4; // of an image between the points of a graph

// The line under the section: where the pointer is, what is there.
function drawReadout(app) {
  const { section, pointer, part } = app;
  const before = section.hover;
  section.hover = null;
  if (section.surface && pointer && insideFrame(section.frame, ...pointer)) writeLabel(part("readout"), readoutAt(app, pointer));
  else part("readout").replaceChildren();
  if (before || section.hover) app.dirty.add("section");
}

// The height of a graph x, y, x, y, ... at x, NaN beside it and where it jumps.
function heightOf(graph, x) {
  const count = graph.length / 2, place = ((x - graph[0]) / (graph[2 * count - 2] - graph[0])) * (count - 1), k = Math.floor(place);
  return k >= 0 && k < count - 1 ? graph[2 * k + 1] + (place - k) * (graph[2 * k + 3] - graph[2 * k + 1]) : NaN;
}

function readoutAt(app, [x, y]) {
  const { section, orbits, background, state } = app;
  const { frame, surface } = section;
  const inner = innerOf(frame);
  const [u, v] = toPlane(frame, x, y);
  const [u0, u1, v0, v1] = frame.view;
  const digits = Math.max(4, Math.ceil(-Math.log10((u1 - u0) / Math.max(Math.abs(u0), Math.abs(u1)))) + 3);
  const upward = surface.graph ? heightOf(surface.graph, u) : v, shown = surface.graph ? IMAGE_DIGITS : digits;
  const said = [surface.labels[0] + " = " + shownNumber(u, digits) + (Number.isFinite(upward) ? ", " + surface.labels[1] + " = " + shownNumber(upward, shown) : "")];
  if (!isAllowed(surface, u, v)) said.push(surface.periods ? "outside the map" : "inaccessible");
  if (background && section.wantsBackground && !backgroundDiffers(background, state)) {
    const value = backgroundValue(background, u, v, surface.periods);
    if (!Number.isNaN(value)) said.push(background.label + " " + shownNumber(value, 4) + " (map)");
  }
  if (showsDensity(section, orbits)) {
    const ratio = section.density.width / inner.width;
    said.push(countAround(section.density, Math.round((x - inner.x) * ratio), Math.round((y - inner.y) * ratio), 2) + " points here");
    return said.join(" · ");
  }
  const near = nearestPoint(orbits, u, v, (u1 - u0) / inner.width, (v1 - v0) / inner.height, 9);
  if (near) {
    section.hover = near;
    const { reading, mark } = near.orbit;
    said.push("orbit " + mark + (app.root.dataset.kind === "map" ? ", iterate " : ", crossing ") + (near.index + 1) + ": " + reading.classification);
    if (hasRotation(near.orbit)) said.push("ν = " + shownRotation(reading.rotation));
    if (Number.isFinite(reading.megno)) said.push("MEGNO " + shownNumber(reading.megno, 3));
    if (Number.isFinite(reading.energy_error)) said.push("|ΔE| " + shownNumber(reading.energy_error, 2));
  }
  return said.join(" · ");
}
