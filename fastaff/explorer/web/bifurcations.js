// The iterates of a map of one variable against a parameter, as `chaos.bifurcation_diagram`, and the range worth looking at.

import { wrong } from "./sections.js";

const COARSE = 128, RANGE_HALVINGS = 24; // values tried, and steps to an end of the range where orbits stay
const LEAST_SPREAD = 0.05; // of all iterates, from which those of one value are more than a point that is still approached
const BEFORE_SPLIT = 0.6; // of the range behind the first bifurcation, shown before it
const BLOCK = 64; // iterates in one call
const FARTHEST_ITERATE = 1e6;

/** The iterates kept of one start at one value of a parameter, after a transient; null where the orbit ends. */
function iteratesAt(system, P, start, transient, kept) {
  const z = Float64Array.of(start, 0), w = new Float64Array(2), width = 2 + Number(system.winds[0]), out = new Float64Array(width*BLOCK), found = new Float64Array(kept);
  for (let done = 0; done < transient + kept;) {
    const count = Math.min(BLOCK, transient + kept - done), taken = system.iterates(z, w, P, count, out);
    for (let k = 0; k < taken; k++) {
      const x = out[k*width + width - 2];
      if (!(Math.abs(x) < FARTHEST_ITERATE)) return null;
      if (done + k >= transient) found[done + k - transient] = x;
    }
    if (taken < count || !(system.margin(z, P) > 0)) return null;
    done += taken;
  }
  return found;
}

/** {from, to, values, points}: `kept` iterates at each of `columns` values, NaN where the orbit ends; null where all do. */
export function bifurcations(system, P, { parameter, range, columns, start, transient, kept }) {
  const index = system.parameters.indexOf(parameter);
  if (index < 0) throw wrong("parameter", `the parameter must be one of ${system.parameters.join(", ")}, got ${parameter}`);
  const own = Float64Array.from(P), at = (value, before = transient, count = kept) => { own[index] = value; return iteratesAt(system, own, start, before, count); };
  const ends = shownRange((value) => at(value, transient, COARSE), range, P[index]);
  if (!ends) return null;
  const [from, to] = ends, points = new Float64Array(columns*kept).fill(NaN), values = Float64Array.from({ length: columns }, (_, k) => from + (to - from)*(k + 0.5)/columns);
  values.forEach((value, k) => { const found = at(value); if (found) points.set(found, k*kept); });
  return { from, to, values, points };
}

/** The part of a range around the present value in which orbits stay, from somewhat before their first bifurcation on. */
function shownRange(at, [low, high], now) {
  const value = (k) => low + (high - low)*k/COARSE, found = Array.from({ length: COARSE + 1 }, (_, k) => at(value(k)));
  let first = Math.min(COARSE, Math.max(0, Math.round(COARSE*(now - low)/(high - low))));
  if (!found[first]) first = found.findIndex(Boolean);
  if (first < 0) return null;
  let last = first;
  while (first > 0 && found[first - 1]) first--;
  while (last < COARSE && found[last + 1]) last++;
  const from = first > 0 ? edgeOf(at, value(first), value(first - 1)) : low, to = last < COARSE ? edgeOf(at, value(last), value(last + 1)) : high;
  if (!(to > from)) return null;
  const spans = found.slice(first, last + 1).map((x) => [Math.min(...x), Math.max(...x)]);
  const all = Math.max(...spans.map(([, most]) => most)) - Math.min(...spans.map(([least]) => least));
  const split = spans.findIndex(([least, most]) => most - least > LEAST_SPREAD*all);
  return split > 0 ? [Math.max(from, value(first + split) - BEFORE_SPLIT*(to - value(first + split))), to] : [from, to];
}

/** The last value towards `outside` at which the orbit stays. */
function edgeOf(at, inside, outside) {
  for (let k = 0; k < RANGE_HALVINGS; k++) {
    const middle = (inside + outside)/2;
    if (at(middle)) inside = middle; else outside = middle;
  }
  return inside;
}
