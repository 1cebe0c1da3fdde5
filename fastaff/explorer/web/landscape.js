// The energy's minimum, and the energy from which orbits can escape over a saddle; in units of any size.

import { restingAt } from "./energy_surface.js";
import { reduced } from "./angles.js";

const RADII = 49, SMALLEST = 1e-8, LARGEST = 1e8, ANGLES = 12, TRIES = 60, LEAPS = 0.7, ARRIVED = 1e-9, APART = 1e-5;
const REMOTE = 1e3, DOWNWARD = 4000, FAR_AWAY = [1e4, 1e5, 1e6, 1e7, 1e8], SETTLED = 0.3;

/** Return {minimum, escape} of a surface's system at its angular momenta; null for what is not found. */
export function landscape(surface) {
  const plane = planeOf(surface), found = criticalPoints(plane);
  const minima = found.filter((point) => point.kind === "minimum").map((point) => point.value);
  const minimum = minima.length ? Math.min(...minima) : null;
  const saddles = found.filter((point) => point.kind === "saddle" && (minimum === null || point.value > minimum));
  const escape = [...saddles.filter((point) => leadsAway(plane, point)).map((point) => point.value), ...plateau(plane, minimum)];
  return { minimum, escape: escape.length ? Math.min(...escape) : null };
}

/** The least value far away, in an array, if it settles or rises in all directions; [] where it does not, or at the minimum. */
function plateau(plane, minimum) {
  const found = [];
  for (let j = 0; j < ANGLES && !plane.home; j += plane.stride) {
    const angle = plane.turn*(j + 0.5)/ANGLES, values = FAR_AWAY.map((r) => plane.value(r*Math.cos(angle), r*Math.sin(angle)));
    const steps = values.slice(1).map((value, k) => value - values[k]), size = Math.max(...values.map(Math.abs));
    const settles = steps.every((step, k) => !k || Math.abs(step) <= SETTLED*Math.abs(steps[k - 1]) + 1e-14*size);
    if (settles) { // at once, or as a power of the distance
      const [before, last] = steps.slice(-2);
      const value = values[values.length - 1] + (before === last ? 0 : last*last/(before - last));
      found.push(Math.abs(value) > 1e-9*size ? value : 0);
    } else if (!steps.every((step) => step > 0)) return [];
  }
  const least = Math.min(...found);
  return found.length && (minimum === null || least > minimum) ? [least] : [];
}

/** The effective potential of two coordinates, those of a plane or alpha, beta of a body, and its gradient. */
function planeOf({ system, P, body, mu, p_eta, p_gamma }) {
  if (system.rates) return restingPlane(system, P);
  const n = system.n, other = body ? 2 : 1, z = new Float64Array(2*n), force = new Float64Array(n);
  const E = body ? p_eta*p_eta/mu : 0, G = body ? p_gamma*p_gamma/mu : 0;
  const inside = (x, y) => { z[0] = x; z[other] = y; return system.margin(z, P) > 0; };
  return {
    turn: body ? Math.PI/2 : 2*Math.PI, stride: body ? 2 : 1, // of a body alpha and beta are not negative
    value: (x, y) => (inside(x, y) ? system.potential(z, P) + (E && E/(2*x*x)) + (G && G/(2*y*y)) : Infinity),
    gradient(x, y) {
      if (!inside(x, y)) return [NaN, NaN];
      system.force(z, P, force);
      return [-force[0] - (E && E/x**3), -force[other] - (G && G/y**3)];
    },
  };
}

/** The same of H(q, p): its least value over the momenta, whose slopes are those of H there. */
function restingPlane(system, P) {
  const f = new Float64Array(4), spans = system.periods(P).slice(0, 2);
  return {
    turn: 2*Math.PI, stride: 1, largest: Math.max(...spans.map((span) => span || LARGEST)),
    home: (x, k) => reduced(x, spans[k]), value: (x, y) => restingAt(system, P, x, y)?.value ?? Infinity,
    gradient(x, y) {
      const found = restingAt(system, P, x, y);
      if (!found) return [NaN, NaN];
      system.rates(found.z, P, f);
      return [-f[2], -f[3]];
    },
  };
}

/** Critical points, by Newton's method from distances of all sizes in many directions; as energy_limits of the package. */
function criticalPoints(plane) {
  const found = [];
  for (let i = 0; i < RADII; i++) {
    const r = SMALLEST*((plane.largest ?? LARGEST)/SMALLEST)**(i/(RADII - 1));
    for (let j = 0; j < ANGLES; j += plane.stride) {
      const angle = plane.turn*(j + 0.5)/ANGLES, point = newton(plane, r*Math.cos(angle), r*Math.sin(angle));
      if (point && plane.home) Object.assign(point, { x: plane.home(point.x, 0), y: plane.home(point.y, 1) });
      if (point && !found.some((one) => Math.hypot(one.x - point.x, one.y - point.y) <= 1e-5*Math.hypot(one.x, one.y))) found.push(point);
    }
  }
  return found;
}

/** Gradient and second derivatives, these by differences of the gradient. */
function slopes(plane, x, y) {
  const r = Math.hypot(x, y), h = APART*(Math.abs(x) + 1e-4*r), k = APART*(Math.abs(y) + 1e-4*r);
  const [gx, gy] = plane.gradient(x, y), east = plane.gradient(x + h, y), west = plane.gradient(x - h, y);
  const north = plane.gradient(x, y + k), south = plane.gradient(x, y - k);
  const xy = (east[1] - west[1])/(4*h) + (north[0] - south[0])/(4*k);
  return { gx, gy, xx: (east[0] - west[0])/(2*h), yy: (north[1] - south[1])/(2*k), xy };
}

function newton(plane, x0, y0) {
  const r0 = Math.hypot(x0, y0);
  let x = x0, y = y0, d = null;
  for (let step = 0; step < TRIES; step++) {
    const r = Math.hypot(x, y);
    if (!(r > ARRIVED*r0)) return critical(plane, x, y, r0, d);
    d = slopes(plane, x, y);
    const det = d.xx*d.yy - d.xy*d.xy;
    if (!Number.isFinite(det) || det === 0) return null;
    let dx = -(d.yy*d.gx - d.xy*d.gy)/det, dy = -(d.xx*d.gy - d.xy*d.gx)/det;
    const length = Math.hypot(dx, dy);
    if (length <= ARRIVED*r) return critical(plane, x, y, 0, d);
    if (length > LEAPS*r) { dx *= LEAPS*r/length; dy *= LEAPS*r/length; }
    x += dx; y += dy;
  }
  return null;
}

/** The critical point that a search has come to; one from the distance `shrunk` that has come to the origin, if that is one. */
function critical(plane, x, y, shrunk, d) {
  const det = d.xx*d.yy - d.xy*d.xy;
  const at = shrunk ? [0, 0] : [x, y], value = plane.value(...at), scale = Math.max(Math.abs(d.xx), Math.abs(d.yy), Math.abs(d.xy));
  if (!Number.isFinite(value) || !(Math.abs(det) > 1e-8*scale*scale)) return null;
  const slope = shrunk ? Math.hypot(...plane.gradient(0, 0)) : 0, rounding = 1e-15*shrunk;
  if (slope > scale*Math.max(1e-3*Math.hypot(x, y), rounding)) return null;
  return { x: at[0], y: at[1], value, kind: det < 0 ? "saddle" : d.xx > 0 ? "minimum" : "maximum", d };
}

/** Whether the way down from one side of a saddle goes to infinity and from the other it does not. */
function leadsAway(plane, { x, y, d }) {
  const angle = 0.5*Math.atan2(2*d.xy, d.xx - d.yy) + Math.PI/2, size = Math.hypot(x, y) || 1;
  const ends = [1, -1].map((sign) => goesAway(plane, x + sign*1e-3*size*Math.cos(angle), y + sign*1e-3*size*Math.sin(angle), size));
  return ends[0] !== ends[1];
}

function goesAway(plane, x0, y0, size) {
  let x = x0, y = y0, step = 1e-3*size, value = plane.value(x, y), least = null;
  for (let k = 0; k < DOWNWARD; k++) {
    const [gx, gy] = plane.gradient(x, y), length = Math.hypot(gx, gy);
    least ??= 1e-9*length;
    if (!(length > least)) return false;
    const nx = x - step*gx/length, ny = y - step*gy/length, next = plane.value(nx, ny);
    if (next < value) { x = nx; y = ny; value = next; step *= 1.3; } else step /= 2;
    if (step < 1e-10*size) return false;
    if (Math.hypot(x, y) > REMOTE*size || value === -Infinity) return true;
  }
  return false;
}
