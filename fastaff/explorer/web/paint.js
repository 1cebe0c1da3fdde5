// What the colour of an orbit says: its classification, itself, its rotation number or its MEGNO.

import { SHADES, shadeColour } from "./colours.js";
import { hasRotation } from "./orbits.js";
import { shownNumber } from "./text.js";

export const PAINTS = [["classification", "classification"], ["orbit", "orbit"], ["rotation", "rotation number"], ["megno", "MEGNO"]];

const MEGNO_SPAN = [Math.log2(1.5), 4]; // 2 is regular; 16 and more has one colour

const isSea = (orbit) => orbit.reading.classification === "chaotic";

function painted(orbit, what) {
  if (what === "megno") return Number.isFinite(orbit.reading.megno) && orbit.reading.megno > 0 ? Math.log2(orbit.reading.megno) : NaN;
  return what !== "orbit" && hasRotation(orbit) && !(what === "classification" && isSea(orbit)) ? orbit.reading.rotation.value : NaN;
}

// Give all orbits their colours anew; true where one has changed.
export function repaint(orbits) {
  const what = orbits.paintedBy, shown = [...orbits.shown.values()];
  const values = shown.map((orbit) => painted(orbit, what)), known = values.filter((value) => !Number.isNaN(value));
  const [low, high] = what === "megno" ? MEGNO_SPAN : [Math.min(...known), Math.max(...known)];
  orbits.span = known.length && what !== "orbit" ? [low, high] : null;
  let changed = false;
  shown.forEach((orbit, k) => {
    const share = high > low ? Math.min(1, Math.max(0, (values[k] - low) / (high - low))) : 0.5;
    const paint = what === "orbit" ? null : !Number.isNaN(values[k]) ? Math.round(SHADES * share) : what === "classification" && isSea(orbit) ? "sea" : "open";
    changed ||= paint !== orbit.paint;
    orbit.paint = paint;
  });
  return changed;
}

// Say beside the list what the colours are.
export function showScale(element, orbits, theme) {
  const { span, paintedBy } = orbits;
  element.hidden = !span;
  if (!span) return;
  const [low, high] = paintedBy === "megno" ? ["≤ 1.5", "≥ 16"] : span.map((end) => shownNumber(end, 3));
  const [from, bar, to] = element.children;
  from.textContent = (paintedBy === "megno" ? "" : "ν ") + low;
  to.textContent = high === low ? "" : high + (paintedBy === "classification" ? ", chaotic grey" : "");
  const stops = Array.from({ length: 9 }, (_, k) => shadeColour(Math.round((SHADES * k) / 8), theme));
  bar.style.background = "linear-gradient(to right, " + stops.join(", ") + ")";
}
