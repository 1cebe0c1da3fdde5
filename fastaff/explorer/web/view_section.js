// The section: accessible region, background map, points or their density, axes and marks, on three canvases.

import { MAP_COVER, backgroundDiffers, backgroundExtents, drawColourBar } from "./background.js";
import { clipToInner, drawAxes, drawExtent, fittedContext, innerOf, makeFrame, toPixel, widened } from "./frame.js";
import { colourOf } from "./orbits.js";
import { aimDensity, countDensity, densityImage, makeDensity } from "./view_density.js";
import { outlineOf } from "./outline.js";
import { drawCobweb } from "./view_cobweb.js";
import { drawPoints, makePointLayer, pointSize } from "./view_points.js";
import { makeRaster, rasterPoints } from "./view_raster.js";

export const MANY = 1e6; // points from which on their density is drawn

const FEW = 40; // orbits up to which all starting points are marked

const BAR_ROOM = 62; // room for the colour bar

export function makeSection(canvases) {
  const layer = makePointLayer(canvases.points);
  return {
    canvases, frame: makeFrame(), surface: null, region: null, layer, software: layer?.software ?? true, raster: makeRaster(), density: makeDensity(),
    wantsDensity: false, wantsBackground: true, cursor: null, box: null, hover: null, past: [], revision: 0,
  };
}

export function showsDensity(section, orbits) {
  return section.wantsDensity || orbits.total > MANY;
}

export function backgroundShown(section, background, state) {
  return background && section.wantsBackground && !backgroundDiffers(background, state);
}

// Take a new surface; the view is kept where it is still of use.
export function takeSurface(section, surface, keepView) {
  section.surface = surface;
  section.region = surface.open ? null : pathOf(surface.outline ?? outlineOf(surface.allowed, surface.extent, surface.width, surface.height));
  Object.assign(section.frame, { labels: surface.labels, spans: surface.spans });
  if (keepView) return;
  section.frame.view = widened(surface.extent, 0.04);
  section.past = [];
}

// The polygons of an outline as one path in the plane.
function pathOf(outline) {
  const path = new Path2D();
  let begins = true;
  for (let k = 0; k < outline.length; k += 2) {
    const ends = Number.isNaN(outline[k]);
    if (ends) path.closePath();
    else if (begins) path.moveTo(outline[k], outline[k + 1]);
    else path.lineTo(outline[k], outline[k + 1]);
    begins = ends;
  }
  return path;
}

export function changeView(section, view, kept = true) {
  const [u0, u1, v0, v1] = view;
  const size = section.surface?.extent ?? [-1, 1, -1, 1];
  const least = 1e-13 * Math.max(1e-3, Math.abs(u0), Math.abs(u1), Math.abs(v0), Math.abs(v1));
  if (!(u1 - u0 > 64 * least && v1 - v0 > 64 * least)) return false;
  if (u1 - u0 > 20 * (size[1] - size[0]) || v1 - v0 > 20 * (size[3] - size[2])) return false;
  if (kept) section.past.push(section.frame.view);
  if (section.past.length > 100) section.past.shift();
  section.frame.view = [u0, u1, v0, v1];
  return true;
}

// Zoom by a factor about (u, v).
export function zoomView(section, u, v, factor, kept) {
  const [u0, u1, v0, v1] = section.frame.view;
  return changeView(section, [u + (u0 - u) * factor, u + (u1 - u) * factor, v + (v0 - v) * factor, v + (v1 - v) * factor], kept);
}

export function wholeView(section) {
  if (section.surface) changeView(section, widened(section.surface.extent, 0.04));
}

export function isAllowed(surface, u, v) {
  if (surface.open) return inPeriod(u, surface.periods[0]) && inPeriod(v, surface.periods[1]);
  const [u0, u1, v0, v1] = surface.extent;
  const column = Math.floor(((u - u0) / (u1 - u0)) * surface.width), row = Math.floor(((v - v0) / (v1 - v0)) * surface.height);
  return column >= 0 && row >= 0 && column < surface.width && row < surface.height && surface.allowed[row * surface.width + column] !== 0;
}

const inPeriod = (x, period) => !period || (x >= -period / 2 && x < period / 2);

// A view without what is beyond half a period of 0, of axes that have one.
const withinPeriods = (view, periods) => view.map((end, k) => (periods?.[k >> 1] ? ((k % 2) - 0.5) * periods[k >> 1] : end));

// Fill what there is of the plane of a map without an edge: all, of angles one period.
function drawOpen(ctx, frame, periods, colour) {
  const [u0, u1, v0, v1] = withinPeriods(frame.view, periods), [x0, y1] = toPixel(frame, u0, v0), [x1, y0] = toPixel(frame, u1, v1);
  ctx.fillStyle = colour;
  ctx.fillRect(x0, y0, x1 - x0, y1 - y0);
}

// Keep drawing to a rectangle of the plane.
function clipTo(ctx, frame, [u0, u1, v0, v1]) {
  const [x0, y1] = toPixel(frame, u0, v0), [x1, y0] = toPixel(frame, u1, v1);
  ctx.beginPath();
  ctx.rect(x0, y0, x1 - x0, y1 - y0);
  ctx.clip();
}

// Draw a map under the section, of axes that have a period within half of one, each place once.
function drawMap(ctx, frame, background, periods) {
  const [first, second] = periods ?? [0, 0];
  ctx.save();
  clipTo(ctx, frame, withinPeriods(frame.view, periods));
  ctx.globalAlpha = MAP_COVER;
  for (const extent of backgroundExtents(background, periods)) {
    const [a0, a1, b0, b1] = extent;
    ctx.save();
    clipTo(ctx, frame, [a0, first ? Math.min(a1, a0 + first) : a1, b0, second ? Math.min(b1, b0 + second) : b1]);
    drawExtent(ctx, frame, background.image, extent, false);
    ctx.restore();
  }
  ctx.restore();
}

function fillRegion(ctx, frame, path, colour) {
  const [x0, y0] = toPixel(frame, 0, 0), [x1, y1] = toPixel(frame, 1, 1);
  ctx.save();
  ctx.transform(x1 - x0, 0, 0, y1 - y0, x0, y0);
  ctx.fillStyle = colour;
  ctx.fill(path);
  ctx.restore();
}

// Draw all; returns true if there is more to draw in the next frame. scale: pixels of a CSS pixel, for pictures.
export function drawSection(section, { orbits, background, state, theme, colours }, scale) {
  const { frame, surface, canvases } = section;
  const ratio = scale ?? Math.min(3, globalThis.devicePixelRatio || 1);
  const withMap = surface && backgroundShown(section, background, state);
  frame.margins.right = withMap ? BAR_ROOM : 14;
  const ctx = fittedContext(canvases.back, frame, scale);
  const inner = innerOf(frame);
  const dense = showsDensity(section, orbits);
  let more = false;
  ctx.save();
  clipToInner(ctx, frame);
  ctx.fillStyle = surface ? colours.inaccessible : colours.plot;
  ctx.fillRect(inner.x, inner.y, inner.width, inner.height);
  if (surface?.open) drawOpen(ctx, frame, surface.periods, colours.plot);
  else if (surface) fillRegion(ctx, frame, section.region, colours.plot);
  if (withMap) drawMap(ctx, frame, background, surface.periods);
  if (surface?.graph) {
    const chosen = orbits.shown.get(orbits.chosen);
    drawCobweb(ctx, frame, surface, chosen, chosen && colourOf(chosen, theme), colours);
  }
  if (dense) {
    aimDensity(section.density, orbits, frame.view, Math.round(inner.width * ratio), Math.round(inner.height * ratio), section.revision);
    more = countDensity(section.density);
    drawExtent(ctx, frame, densityImage(section.density, theme), frame.view, false);
  } else {
    section.density.key = "";
    if (section.software) {
      const side = Math.max(1, Math.round(ratio * pointSize(orbits.total)));
      const image = rasterPoints(section.raster, orbits, frame.view, Math.round(inner.width * ratio), Math.round(inner.height * ratio), side, theme);
      drawExtent(ctx, frame, image, frame.view, false);
    }
  }
  ctx.restore();
  canvases.points.hidden = section.software;
  if (section.layer) drawPoints(section.layer, dense || section.software ? null : orbits, frame, inner, ratio, theme);
  drawFront(section, orbits, withMap ? background : null, theme, colours, scale);
  return more;
}

function drawFront(section, orbits, background, theme, colours, scale) {
  const { frame, canvases } = section;
  const ctx = fittedContext(canvases.front, frame, scale);
  const inner = innerOf(frame);
  drawAxes(ctx, frame, colours);
  if (background) drawColourBar(ctx, background, inner, colours);
  ctx.save();
  clipToInner(ctx, frame);
  const chosen = orbits.shown.get(orbits.chosen);
  for (const orbit of orbits.shown.size <= FEW ? orbits.shown.values() : chosen ? [chosen] : []) {
    if (!orbit.hidden && orbit.point) drawStart(ctx, frame, orbit, orbit === chosen, colourOf(orbit, theme), colours);
  }
  if (section.hover) ring(ctx, ...toPixel(frame, section.hover.u, section.hover.v), 5, colours.text);
  if (section.cursor) {
    const [x, y] = toPixel(frame, ...section.cursor);
    ctx.strokeStyle = colours.accent;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
      ctx.moveTo(x + 3 * dx, y + 3 * dy);
      ctx.lineTo(x + 12 * dx, y + 12 * dy);
    }
    ctx.stroke();
  }
  if (section.box) {
    const [x0, y0, x1, y1] = section.box;
    ctx.strokeStyle = colours.accent;
    ctx.setLineDash([5, 3]);
    ctx.strokeRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
  }
  ctx.restore();
}

function drawStart(ctx, frame, orbit, isChosen, colour, colours) {
  const [x, y] = toPixel(frame, ...orbit.point);
  ctx.fillStyle = colour;
  ctx.strokeStyle = isChosen ? colours.text : colours.plot;
  ctx.lineWidth = isChosen ? 2 : 1;
  ctx.beginPath();
  ctx.arc(x, y, isChosen ? 5 : 3.2, 0, 2 * Math.PI);
  ctx.fill();
  ctx.stroke();
}

function ring(ctx, x, y, radius, colour) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.stroke();
}


