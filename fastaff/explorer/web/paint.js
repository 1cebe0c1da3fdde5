// What the colour of an orbit says: its classification, itself, its rotation number or its MEGNO.

import { SHADES, shadeColour } from "./colours.js";
import { hasRotation } from "./orbits.js";
import { shownEnds } from "./text.js";

export const PAINTS = [["classification", "classification"], ["orbit", "orbit"], ["rotation", "rotation number"], ["megno", "MEGNO"]];

const MEGNO_SPAN = [Math.log2(1.5), 4]; // 2 is regular; 16 and more has one colour

const SETTLED = 5e-3; // turns: errors of regular orbits after 100 crossings, by which most chaotic ones are known as such

const VALUES = { // what the colour scale says of an orbit, NaN where it says nothing
  classification: (orbit) => (orbit.reading.classification === "regular" || isSettled(orbit) ? turnsOf(orbit) : NaN),
  orbit: () => NaN,
  rotation: turnsOf,
  megno: ({ reading: { megno } }) => (megno > 0 ? Math.log2(megno) : NaN),
};

function turnsOf(orbit) {
  return hasRotation(orbit) ? orbit.reading.rotation.value : NaN;
}

// Whether the rotation number of an orbit without a classification is known well enough to be a colour.
function isSettled(orbit) {
  return hasRotation(orbit) && orbit.reading.rotation.error < SETTLED;
}

// The colour of an orbit beside the scale: that of its classification, or of what is not known.
function plainPaint(orbit, what) {
  if (what === "orbit") return null;
  return what === "classification" ? orbit.reading.classification : "undecided";
}

// Give all orbits their colours anew; true where one has changed.
export function repaint(orbits) {
  const what = orbits.paintedBy, shown = [...orbits.shown.values()];
  const values = shown.map(VALUES[what]), known = values.filter((value) => !Number.isNaN(value));
  const [low, high] = what === "megno" ? MEGNO_SPAN : [Math.min(...known), Math.max(...known)];
  orbits.span = known.length ? [low, high] : null;
  let changed = false;
  shown.forEach((orbit, k) => {
    const share = high > low ? Math.min(1, Math.max(0, (values[k] - low) / (high - low))) : 0.5;
    const paint = Number.isNaN(values[k]) ? plainPaint(orbit, what) : Math.round(SHADES * share);
    changed ||= paint !== orbit.paint;
    orbit.paint = paint;
  });
  return changed;
}

// Say beside the list what the colours are: the scale of a quantity, and a swatch of each colour beside it.
export function showScale(element, orbits, theme) {
  const { span, paintedBy } = orbits, [scale, from, bar, to, swatches] = ["[data-part=scale-name]", "[data-part=scale-from]", ".ramp", "[data-part=scale-to]", "[data-part=swatches]"].map((part) => element.querySelector(part));
  element.hidden = paintedBy === "orbit" || !orbits.shown.size;
  for (const piece of [scale, bar]) piece.hidden = !span;
  for (const piece of [from, to]) piece.hidden = !span;
  swatches.replaceChildren(...besideScale(orbits).map(([paint, text]) => swatchOf(shadeColour(paint, theme), text)));
  scale.textContent = { classification: "not chaotic, ν", rotation: "ν", megno: "MEGNO" }[paintedBy];
  const stops = Array.from({ length: 9 }, (_, k) => shadeColour(Math.round((SHADES * k) / 8), theme));
  bar.style.background = "linear-gradient(to right, " + stops.join(", ") + ")";
  if (!span) return;
  const [low, high] = paintedBy === "megno" ? ["≤ 1.5", "≥ 16"] : shownEnds(...span);
  from.textContent = low;
  to.textContent = high === low ? "" : high;
}

// The colours beside the scale that occur, [paint, text] of each.
function besideScale({ paintedBy, shown }) {
  const paints = new Set([...shown.values()].map(({ paint }) => paint));
  const all = paintedBy === "classification" ? [["regular", "regular, no ν"], ["undecided", "undecided, no ν"], ["chaotic", "chaotic"]] : [["undecided", "not known"]];
  return all.filter(([paint]) => paints.has(paint));
}

function swatchOf(colour, text) {
  const found = document.createElement("span"), patch = document.createElement("span");
  found.className = "state";
  patch.className = "patch";
  patch.style.background = colour;
  found.append(patch, text);
  return found;
}
