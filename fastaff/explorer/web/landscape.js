// The energy's minimum, and the energy from which orbits can escape over a saddle.

const GRID = 33, STEPS = 60;

/** Return {minimum, escape} of a surface's system at its angular momenta; null for what is not found. */
export function landscape(surface) {
  const f = potentialOf(surface), [low, high] = f.range;
  const found = criticalPoints(f, low, high);
  const minima = found.filter((point) => point.kind === "minimum").map((point) => point.value);
  const minimum = minima.length ? Math.min(...minima) : null;
  const saddles = found.filter((point) => point.kind === "saddle" && (minimum === null || point.value > minimum));
  const escape = saddles.filter((point) => leadsAway(f, point)).map((point) => point.value);
  return { minimum, escape: escape.length ? Math.min(...escape) : null };
}

/** The effective potential of two coordinates: those of a plane; ln alpha and ln beta of a body. */
function potentialOf({ system, P, body, mu, p_eta, p_gamma }) {
  if (body) {
    const f = (s, t) => {
      const A = Math.exp(2*s), B = Math.exp(2*t);
      if (!(system.inside(A, B, P) > 0)) return Infinity;
      return system.V(A, B, P) + (p_eta*p_eta/A + p_gamma*p_gamma/B)/(2*mu);
    };
    return Object.assign(f, { range: [-9, 6], far: 40, log: true });
  }
  const z = new Float64Array(4);
  const f = (x, y) => {
    z[0] = x; z[1] = y;
    return system.margin(z, P) > 0 ? system.potential(z, P) : Infinity;
  };
  return Object.assign(f, { range: [-6, 6], far: 1e3, log: false });
}

/** Critical points of f, by Newton's method from where the slope is small on grids of three sizes. */
function criticalPoints(f, low, high) {
  const found = [];
  for (const size of f.log ? [1] : [1, 0.2, 5]) {
    const at = (k) => size*(low + (high - low)*(k + 0.37)/GRID);
    for (let i = 0; i < GRID; i++) {
      for (let j = 0; j < GRID; j++) {
        const point = newton(f, at(i), at(j), size*(high - low)/GRID);
        const near = (p) => Math.hypot(p.x - point.x, p.y - point.y) < 1e-5*(1 + Math.hypot(p.x, p.y));
        if (point && !found.some(near)) found.push(point);
      }
    }
  }
  return found;
}

function slopes(f, x, y) {
  const h = 1e-4*(1 + Math.abs(x)), k = 1e-4*(1 + Math.abs(y)), c = f(x, y);
  const [e, w, n, s] = [f(x + h, y), f(x - h, y), f(x, y + k), f(x, y - k)];
  return {
    c, gx: (e - w)/(2*h), gy: (n - s)/(2*k), xx: (e - 2*c + w)/(h*h), yy: (n - 2*c + s)/(k*k),
    xy: (f(x + h, y + k) - f(x + h, y - k) - f(x - h, y + k) + f(x - h, y - k))/(4*h*k),
  };
}

function newton(f, x0, y0, most) {
  let x = x0, y = y0;
  for (let step = 0; step < STEPS; step++) {
    const d = slopes(f, x, y), det = d.xx*d.yy - d.xy*d.xy;
    if (!Number.isFinite(det) || det === 0) return null;
    let dx = -(d.yy*d.gx - d.xy*d.gy)/det, dy = -(d.xx*d.gy - d.xy*d.gx)/det;
    const length = Math.hypot(dx, dy);
    if (length > most) { dx *= most/length; dy *= most/length; }
    x += dx; y += dy;
    if (Math.hypot(x - x0, y - y0) > 8*most) return null;
    if (length < 1e-9*(1 + Math.hypot(x, y))) {
      const value = f(x, y), scale = Math.max(Math.abs(d.xx), Math.abs(d.yy), Math.abs(d.xy));
      if (!Number.isFinite(value) || !(Math.abs(det) > 1e-8*scale*scale) || !(scale > 1e-6*(Math.abs(value) + 1e-3))) return null;
      return { x, y, value, kind: det < 0 ? "saddle" : d.xx > 0 ? "minimum" : "maximum", d };
    }
  }
  return null;
}

/** Whether the way down from one side of a saddle goes to infinity and from the other it does not. */
function leadsAway(f, { x, y, d }) {
  const angle = 0.5*Math.atan2(2*d.xy, d.xx - d.yy) + Math.PI/2;
  const ends = [1, -1].map((sign) => goesAway(f, x + sign*1e-3*Math.cos(angle), y + sign*1e-3*Math.sin(angle)));
  return ends[0] !== ends[1];
}

function goesAway(f, x0, y0) {
  let x = x0, y = y0, step = 1e-3, value = f(x, y);
  for (let k = 0; k < 4000; k++) {
    const { gx, gy } = slopes(f, x, y), length = Math.hypot(gx, gy);
    if (!(length > 1e-9)) return false;
    const nx = x - step*gx/length, ny = y - step*gy/length, next = f(nx, ny);
    if (next < value) { x = nx; y = ny; value = next; step *= 1.3; } else step /= 2;
    if (step < 1e-10) return false;
    if (Math.hypot(x, y) > f.far || value === -Infinity) return true;
  }
  return false;
}
