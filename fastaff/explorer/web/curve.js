// The rotation number of a closed curve of any shape or of a chain of islands; none where the points tell neither.

import { averages, displacements, fittedLines, meanTurn, rotationNumber, wrapped } from "./readings.js";

const LEAST_ON_CURVE = 64, MOST_ON_CURVE = 2048, TRIED_LINES = 3, TRIED_HARMONICS = 4;
const LONGER_THAN_TREE = 1.1; // an open polygon over the shortest tree: 1 on a curve, more where it leaps between islands
const MOST_ISLANDS = 60, LEAST_VISITS = 8; // points of each island
const LEAST_TURNS = 2; // of an island about its own centre: the points of an arc of one curve make less than one
const ROUNDING = 1e-14; // of a fraction, in turns
const MOST_BACKWARDS = 0.03; // of a turn; rounding alone on a curve, above a tenth of a turn for crescents

/**
 * The rotation number of points u, v, u, v, ..., null where they are few and where they are neither a curve nor a chain. That
 * of a chain is p/q, with q and the secondary turns about an island in q crossings; that of a curve is about the mean of the
 * points where that sees all of it, else the mean advance along the curve.
 */
export function curveRotation(points) {
  const about = rotationNumber(points);
  if (about === null) return null;
  return chainRotation(points) ?? (seenFromMean(points) ? about : alongCurve(points));
}

/**
 * The rotation number of a chain of islands about its centre, null where the points show no chain. The points of an island
 * are joined in the shortest tree, of which q - 1 edges lead from one to another, or alone in their sector about the mean.
 * Points of one curve near a fraction p/q part alike, but those of an island turn about its centre.
 */
function chainRotation(points) {
  const [u, v] = columns(points), count = u.length, { from, to } = shortestTree(u, v), most = Math.min(MOST_ISLANDS, Math.floor(count/LEAST_VISITS));
  const angle = u.map((x, k) => Math.atan2(v[k], x)), around = Uint32Array.from(u.keys()).sort((i, j) => angle[i] - angle[j]);
  for (let q = 2; q <= most; q++) {
    const joined = from.reduce((sum, end, k) => sum + Number((end - to[k]) % q !== 0), 0) === q - 1;
    const sectors = around.reduce((sum, k, at) => sum + Number((around[(at + 1) % count] - k) % q !== 0), 0);
    if (!joined && sectors !== q) continue;
    const visits = Array.from({ length: q }, (_, island) => [u, v].map((x) => x.filter((_, k) => k % q === island)));
    if (visits.some(([x, y]) => !(Math.max(turnsOf(x, y), turnsOf(everySecond(x), everySecond(y))) >= LEAST_TURNS))) continue;
    const p = placesMoved(visits.map(([x, y]) => [meanOf(x), meanOf(y)]));
    if (p === null) return null;
    const own = new Float64Array(2*Math.floor(points.length/2/q));
    for (let j = 0; j < own.length; j++) own[j] = points[2*(q*((j >> 1) + 1) - 1) + j % 2];
    const turning = curveRotation(own);
    return { value: p/q, error: ROUNDING, q, secondary: turning && { value: turning.value, error: turning.error } };
  }
  return null;
}

/** The shortest tree through points, by the method of Prim: both ends of each edge, and its length. */
function shortestTree(u, v) {
  const count = u.length, from = new Uint32Array(count - 1), to = new Uint32Array(count - 1);
  const nearest = new Uint32Array(count), away = new Float64Array(count).fill(Infinity), inside = new Uint8Array(count);
  let last = 0, length = 0;
  for (let edge = 0; edge < count - 1; edge++) {
    inside[last] = 1;
    let next = -1;
    for (let k = 0; k < count; k++) {
      if (inside[k]) continue;
      const apart = (u[k] - u[last])**2 + (v[k] - v[last])**2;
      if (apart < away[k]) { away[k] = apart; nearest[k] = last; }
      if (next < 0 || away[k] < away[next]) next = k;
    }
    from[edge] = nearest[next]; to[edge] = next;
    length += Math.sqrt(away[next]);
    last = next;
  }
  return { from, to, length };
}

function meanOf(x) { return x.reduce((sum, value) => sum + value, 0)/x.length; }

/** Every second value: a thin island turns by halves, of which the sign is left to chance. */
function everySecond(x) { return x.filter((_, k) => k % 2 === 0); }

/** The turns that points make about their mean, whichever way. */
function turnsOf(x, y) {
  const [mx, my] = [meanOf(x), meanOf(y)], angle = x.map((value, k) => Math.atan2(y[k] - my, value - mx));
  let sum = 0;
  for (let k = 1; k < angle.length; k++) sum += wrapped(angle[k] - angle[k - 1]);
  return Math.abs(sum)/(2*Math.PI);
}

/** By how many places around their mean each of the islands moves to the next; null if not by the same. */
function placesMoved(centres) {
  const q = centres.length, [mx, my] = [0, 1].map((k) => meanOf(centres.map((centre) => centre[k])));
  const angle = centres.map(([x, y]) => Math.atan2(y - my, x - mx)), rank = new Uint32Array(q);
  [...angle.keys()].sort((i, j) => angle[i] - angle[j]).forEach((island, place) => { rank[island] = place; });
  const steps = centres.map((_, k) => (rank[(k + 1) % q] - rank[k] + q) % q), [p] = steps;
  if (steps.some((step) => step !== p)) return null;
  return 2*p <= q ? p : p - q;
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

/** Whether the polygon of points in an order is hardly longer than the shortest tree through them. */
function isCurve({ order, length }, u, v) {
  const walked = polygon(order, u, v);
  let longest = 0;
  for (let k = 0; k < order.length; k++) longest = Math.max(longest, walked[k + 1] - walked[k]);
  return length - longest <= LONGER_THAN_TREE*shortestTree(u, v).length;
}

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
  if (!isCurve(best, u, v)) return null;
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
