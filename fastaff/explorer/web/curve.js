// The rotation number of a closed curve of any shape: points in their order along the curve, not about a centre.

import { averages, displacements, fittedLines, meanTurn, rotationNumber, wrapped } from "./readings.js";

const LEAST_ON_CURVE = 64, MOST_ON_CURVE = 2048, TRIED_LINES = 3, TRIED_HARMONICS = 4;
const CLOSED = 1.25; // length of the polygon over that of every second point: 1 on a curve, 2 of what fills an area
const MOST_BACKWARDS = 0.03; // of a turn; rounding alone on a curve, above a tenth of a turn for crescents
const AGREES = 2; // of the sum of the errors of both numbers

/** The rotation number of points u, v, u, v, ... about the inside of their curve: about their mean where that sees all of it. */
export function curveRotation(points) {
  const about = rotationNumber(points);
  if (about === null || seenFromMean(points)) return about;
  const along = alongCurve(points);
  if (along === null) return about;
  const apart = Math.abs(about.value - along.value), differ = Math.min(apart, 1 - apart) > AGREES*(about.error + along.error);
  return differ || along.error < about.error ? along : about;
}

/**
 * Whether the mean sees all of a closed curve around it: the angles leave no gap of half a turn, and their cyclic order is
 * that of their images, as on a circle. From a place off the curve's inside, both sides of a crescent move against each other.
 */
function seenFromMean(points) {
  const [u, v] = columns(points), angle = u.map((x, k) => Math.atan2(v[k], x)), order = Uint32Array.from(u.keys()).sort((i, j) => angle[i] - angle[j]);
  const widest = Math.max(...[...order.keys()].map((at) => (at ? angle[order[at]] - angle[order[at - 1]] : 2*Math.PI + angle[order[0]] - angle[order.at(-1)])));
  return widest < Math.PI && backwards(order.filter((k) => k + 1 < u.length), angle) < MOST_BACKWARDS*2*Math.PI;
}

/** How far the images of points in the order of their angles go backwards, in one turn. */
function backwards(order, angle) {
  let sum = 0;
  for (let at = 0; at < order.length; at++) {
    const step = angle[order[(at + 1) % order.length] + 1] - angle[order[at] + 1];
    sum += Math.max(0, -wrapped(step));
  }
  return sum;
}

/** Whether the polygon through points in an order is no longer than a curve is. */
function isCurve(order, u, v) { return !(polygon(order, u, v).at(-1) > CLOSED*polygon(order.filter((_, k) => k % 2 === 0), u, v).at(-1)); }

/** Coordinates of the points, each about its mean in units of its spread. */
function columns(points) {
  const count = Math.min(points.length/2, MOST_ON_CURVE);
  return [0, 1].map((k) => scaled(Float64Array.from({ length: count }, (_, j) => points[2*j + k])));
}

/**
 * The mean advance of points u, v, u, v, ... along their closed curve, counterclockwise, in turns per crossing with an
 * error; null where they are on no curve. The order along a curve of rotation number w is that of the fractions of k w:
 * of the candidates that the lines of u + i v give, it is the one whose polygon is shortest.
 */
export function alongCurve(points) {
  if (points.length < 2*LEAST_ON_CURVE) return null;
  const [u, v] = columns(points);
  const tried = candidates(u, v).map((turn) => orderedBy(turn, u, v)).sort((a, b) => a.length - b.length);
  if (!tried.length || !(tried[0].length > 0)) return null;
  const [best] = tried;
  if (!isCurve(best.order, u, v)) return null;
  const found = meanTurn(displacements(placesAlong(best, u, v)).map((x) => x/(2*Math.PI)));
  const turns = area(best.order, u, v) > 0 ? found.value : -found.value, apart = found.value - best.turn;
  return { value: turns - Math.ceil(turns - 0.5), error: found.error + Math.abs(apart - Math.round(apart)) };
}

/** Values about their mean in units of their spread, that lengths are those of both coordinates alike. */
function scaled(values) {
  const [mean] = averages(values, values.length), away = values.map((x) => x - mean), [square] = averages(away.map((x) => x*x), values.length);
  return square > 0 ? away.map((x) => x/Math.sqrt(square)) : away;
}

/** Rotation numbers of which the strongest lines of u + i v, or their differences, are a harmonic. */
function candidates(u, v) {
  const lines = fittedLines(u, v).slice(0, TRIED_LINES).map(({ nu }) => nu);
  const harmonics = [...lines, ...lines.flatMap((one, k) => lines.slice(0, k).map((other) => one - other))], found = [];
  for (const line of harmonics) for (let m = 1; m <= TRIED_HARMONICS; m++) for (let l = 0; l < m; l++) found.push((line + l)/m);
  return found;
}

/** The points in the order of the fractions of k turns, and the length of their polygon. */
function orderedBy(turn, u, v) {
  const place = u.map((_, k) => k*turn - Math.floor(k*turn)), order = Uint32Array.from(u.keys()).sort((i, j) => place[i] - place[j]);
  return { turn, order, length: polygon(order, u, v).at(-1) };
}

/** The length of the closed polygon from its first point to each of the others, and around. */
function polygon(order, u, v) {
  const walked = new Float64Array(order.length + 1);
  for (let k = 0; k < order.length; k++) {
    const i = order[k], j = order[(k + 1) % order.length];
    walked[k + 1] = walked[k] + Math.hypot(u[j] - u[i], v[j] - v[i]);
  }
  return walked;
}

/** The place of each point along its curve, from -pi to pi. */
function placesAlong({ order }, u, v) {
  const walked = polygon(order, u, v), length = walked.at(-1), places = new Float64Array(order.length);
  order.forEach((k, at) => { places[k] = 2*Math.PI*walked[at]/length - Math.PI; });
  return places;
}

/** Twice the area of a polygon, positive where it turns counterclockwise. */
function area(order, u, v) {
  let sum = 0;
  for (let k = 0; k < order.length; k++) {
    const i = order[k], j = order[(k + 1) % order.length];
    sum += u[i]*v[j] - u[j]*v[i];
  }
  return sum;
}
