// The orbits of the page: their points in double precision, their readings, and what undo brings back.

import { orbitColour, rgbOf, shadeColour } from "./colours.js";

const UNDONE = 30; // actions that can be undone
const QUIET = 50; // natural periods since the last crossing after which an orbit that can leave has left

export function makeOrbits() {
  return { shown: new Map(), actions: [], next: 1, nextMark: 1, chosen: null, total: 0, paintedBy: "classification", span: null };
}

// number is what the worker knows it by; mark is what people see, and its colour: an orbit that starts anew on another
// surface keeps its mark.
export function newOrbit(number, mark, point) {
  return {
    number, mark, point, home: null, z0: null, step: null, points: new Float64Array(256), count: 0, hidden: false, paint: "undecided",
    reading: { crossings: 0, time: 0, rotation: null, lyapunov: null, megno: null, classification: "undecided", energy_error: null, frequencies: null, status: "running" },
  };
}

// Add points u, v, u, v, ... of an orbit; false where they do not follow what there is.
export function addPoints(orbits, orbit, first, points) {
  const more = points.length / 2;
  if (first !== orbit.count) return false;
  if (2 * (orbit.count + more) > orbit.points.length) {
    const wider = new Float64Array(Math.max(2 * orbit.points.length, 2 * (orbit.count + more)));
    wider.set(orbit.points.subarray(0, 2 * orbit.count));
    orbit.points = wider;
  }
  orbit.points.set(points, 2 * orbit.count);
  orbit.count += more;
  if (orbits.shown.has(orbit.number)) orbits.total += more;
  return true;
}

// Show an orbit that is not shown, as when it is launched or brought back.
export function showOrbit(orbits, orbit) {
  if (orbits.shown.has(orbit.number)) return;
  orbits.shown.set(orbit.number, orbit);
  orbits.total += orbit.count;
}

export function removeOrbit(orbits, number) {
  const orbit = orbits.shown.get(number);
  if (!orbit) return null;
  orbits.shown.delete(number);
  orbits.total -= orbit.count;
  if (orbits.chosen === number) orbits.chosen = null;
  return orbit;
}

// Remember an action, {launched: numbers} or {removed: orbits}; returns orbits that no undo can bring back any more.
export function remember(orbits, action) {
  orbits.actions.push(action);
  const old = orbits.actions.length > UNDONE ? orbits.actions.shift() : null;
  return old?.removed ?? [];
}

// An orbit by its number, shown or to be brought back by undo.
export function knownOrbit(orbits, number) {
  const orbit = orbits.shown.get(number);
  if (orbit) return orbit;
  for (const action of orbits.actions) {
    const found = action.removed?.find((entry) => entry.number === number);
    if (found) return found;
  }
  return null;
}

export function colourOf(orbit, theme) {
  return orbit.paint === null ? orbitColour(orbit.mark - 1, theme) : shadeColour(orbit.paint, theme);
}

export function colourBytes(orbit, theme) {
  return rgbOf(colourOf(orbit, theme));
}

// Whether an orbit has a rotation number: a chaotic one has none.
export function hasRotation(orbit) {
  const { rotation, classification } = orbit.reading;
  return classification !== "chaotic" && Boolean(rotation) && Number.isFinite(rotation.value) && !(rotation.error > 0.05);
}

// Whether an orbit has left, or has not come back to the section and will not; opens: whether its energy lets it go.
export function hasLeft({ reading, count }, opens) {
  const status = reading.status.toLowerCase();
  return status === "escaped" || (status === "no more crossings" && !count) || (opens && reading.quiet > QUIET);
}

// How many orbits have each classification, as a sentence.
export function summaryOf(orbits) {
  const counts = { regular: 0, chaotic: 0, undecided: 0 };
  for (const orbit of orbits.shown.values()) counts[orbit.reading.classification] = (counts[orbit.reading.classification] ?? 0) + 1;
  const parts = Object.entries(counts).filter(([, count]) => count).map(([classification, count]) => count + " " + classification);
  const size = orbits.shown.size;
  return size ? size + (size === 1 ? " orbit" : " orbits") + (parts.length ? " (" + parts.join(", ") + ")" : "") : "no orbits";
}

// The point nearest to (u, v) in units du, dv within `reach` of them: {orbit, index, u, v} or null.
export function nearestPoint(orbits, u, v, du, dv, reach) {
  let best = reach * reach, found = null;
  for (const orbit of orbits.shown.values()) {
    if (orbit.hidden) continue;
    const p = orbit.points;
    for (let i = 0; i < 2 * orbit.count; i += 2) {
      const x = (p[i] - u) / du;
      if (x > reach || x < -reach) continue;
      const y = (p[i + 1] - v) / dv;
      const d = x * x + y * y;
      if (d < best) {
        best = d;
        found = { orbit, index: i / 2 };
      }
    }
  }
  return found && { ...found, u: found.orbit.points[2 * found.index], v: found.orbit.points[2 * found.index + 1] };
}
