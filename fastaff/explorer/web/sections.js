// Surfaces of section, and the energy surface over them: section functions, lifts of points, the allowed region.

const SECTION_AXES = {
  "alpha-turning": ["beta", "p_beta"], "alpha=c": ["beta", "p_beta"], "area=c": ["beta", "p_beta"],
  "beta-turning": ["alpha", "p_alpha"], "beta=c": ["alpha", "p_alpha"],
};
const LETTERS = { alpha: "α", beta: "β" };
const TINY = 1e-9, NODES_PER_DECADE = 40, LEAST = 1e-9, CHANGED = 0.5;
const USUAL = 0.9, STEEP = 1e3; // as in section_edge.py

export function label(name) {
  const plain = name.replace(/^p_/, ""), letter = LETTERS[plain] ?? plain;
  return name.startsWith("p_") ? `p_${letter}` : letter;
}

/** A section of one energy surface of a system; throws an Error {what, message} for what does not suit. */
export class Surface {
  constructor(system, P, coordinates, choice) {
    this.system = system; this.P = P; this.body = system.kind === "body";
    const { energy, section, constant = null, direction = 1, p_eta = 0, p_gamma = 0 } = choice;
    Object.assign(this, { energy, section, constant: constant ?? 0, direction, p_eta, p_gamma, coordinates });
    const named = this.body ? Object.keys(SECTION_AXES) : coordinates.map((name) => `${name}=c`);
    if (!named.includes(section)) {
      throw wrong("section", `the section must be one of ${named.join(", ")}, got ${section}`);
    }
    for (const [what, value] of Object.entries({ energy, p_eta, p_gamma, constant: this.constant })) {
      if (!Number.isFinite(value)) throw wrong(what, `${what} must be a finite number, got ${value}`);
    }
    if (![1, 0, -1].includes(direction)) throw wrong("direction", `direction must be +1, -1 or 0, got ${direction}`);
    if ((section === "alpha=c" || section === "beta=c") && !(this.constant >= 0)) {
      throw wrong("section", `${section} needs a number c of at least 0, got ${this.constant}`);
    }
    if (this.body) {
      this.mu = P[system.parameters.indexOf("mu")];
      this.axes = SECTION_AXES[section];
    } else {
      this.index = named.indexOf(section);
      const other = coordinates[1 - this.index];
      this.axes = [other, `p_${other}`];
      const unit = new Float64Array(4);
      unit[2 + this.index] = 1; this.weight = system.kinetic(unit, P);
      unit[2 + this.index] = 0; unit[3 - this.index] = 1; this.otherWeight = system.kinetic(unit, P);
      this.probe = new Float64Array(4);
    }
    this.labels = this.axes.map(label);
    this.turning = section.endsWith("-turning");
    this.value = this.sectionFunction();
  }

  sectionFunction() {
    const c = this.constant, i = this.index;
    switch (this.section) {
      case "alpha-turning": return (z) => z[0]*z[4] + z[1]*z[5];
      case "beta-turning": return (z) => z[2]*z[6] + z[3]*z[7];
      case "alpha=c": return (z) => Math.sqrt(z[0]*z[0] + z[1]*z[1]) - c;
      case "beta=c": return (z) => Math.sqrt(z[2]*z[2] + z[3]*z[3]) - c;
      case "area=c": return (z) => (z[0]*z[0] + z[1]*z[1] - z[2]*z[2] - z[3]*z[3])/2 - c;
      default: return (z) => z[i] - c;
    }
  }

  /** Whether a zero of the section function is on the section. */
  counts() { return true; }

  /** Section coordinates u, v of a state, written to out[at], out[at + 1]. */
  project(z, out, at) {
    if (!this.body) { out[at] = z[1 - this.index]; out[at + 1] = z[3 - this.index]; return; }
    const k = this.axes[0] === "beta" ? 2 : 0, r = Math.hypot(z[k], z[k + 1]);
    out[at] = r;
    out[at + 1] = r > 0 ? (z[k]*z[k + 4] + z[k + 1]*z[k + 5])/r : Math.hypot(z[k + 4], z[k + 5]);
  }

  /** 2 mu (energy - H) at rest in alpha, beta: the squared momentum that is left; -Infinity outside of the domain. */
  room(alpha, beta) {
    const A = alpha*alpha, B = beta*beta;
    if (!(this.system.inside(A, B, this.P) > 0)) return -Infinity;
    const eta = this.p_eta ? (this.p_eta/alpha)**2 : 0, gamma = this.p_gamma ? (this.p_gamma/beta)**2 : 0;
    const left = 2*this.mu*(this.energy - this.system.V(A, B, this.P)) - eta - gamma;
    return Number.isNaN(left) ? -Infinity : left;
  }

  /** The largest v^2 over u on the section, negative where nothing is allowed. */
  top(u) {
    if (!this.body) {
      const z = this.probe;
      z.fill(0); z[this.index] = this.constant; z[1 - this.index] = u;
      if (!(this.system.margin(z, this.P) > 0)) return -Infinity;
      const left = (this.energy - this.system.potential(z, this.P))/this.otherWeight;
      return Number.isNaN(left) ? -Infinity : left;
    }
    if (this.section === "alpha=c") return this.room(this.constant, u);
    if (this.section === "beta=c") return this.room(u, this.constant);
    if (this.section === "area=c") {
      const A = 2*this.constant + u*u;
      if (!(A > 0)) return -Infinity;
      // p_alpha^2 + v^2 = room, and the branch of the direction: alpha p_alpha - u v has its sign.
      return this.room(Math.sqrt(A), u);
    }
    return highest((x) => this.radial(x, u), this.radii ?? (this.radii = this.happens(u)));
  }

  radial(x, u) { return this.section === "alpha-turning" ? this.room(x, u) : this.room(u, x); }

  /** Nodes around all places where the room over u has extrema or zeros. */
  happens(u) {
    let low = Infinity, high = 0;
    const coarse = geometric(1e-12, 1e12, 12);
    for (const other of u === undefined ? coarse : [u, u/4, u*4, u/16, u*16]) {
      const f = coarse.map((x) => this.radial(x, other));
      for (let k = 1; k + 1 < f.length; k++) {
        const extremum = f[k] > -Infinity && ((f[k] >= f[k - 1] && f[k] > f[k + 1]) || (f[k] <= f[k - 1] && f[k] < f[k + 1]));
        if (extremum || (f[k] >= 0) !== (f[k + 1] >= 0)) { low = Math.min(low, coarse[k]); high = Math.max(high, coarse[k + 1]); }
      }
    }
    return high > 0 ? geometric(low/1e3, high*1e3, NODES_PER_DECADE) : coarse;
  }

  /** Whether a point of the section is reached by this energy. */
  allows(u, v, top = this.top(u)) {
    if (this.body && u < 0) return false;
    if (!(top >= v*v)) return false;
    if (this.section !== "area=c" || !this.direction) return true;
    const alpha = Math.sqrt(2*this.constant + u*u);
    return (alpha*Math.sqrt(top - v*v)*this.direction - u*v)*this.direction >= 0;
  }

  refusal(u, v) { return `${this.labels[0]} = ${u.toPrecision(5)}, ${this.labels[1]} = ${v.toPrecision(5)} is not on the energy surface`; }

  /** The state over a point of the section, or null; of several sheets the first. */
  lift(u, v) {
    const z = this.body ? this.liftBody(u, v) : this.liftPlane(u, v);
    if (!z || !z.every(Number.isFinite) || !(this.system.margin(z, this.P) > 0)) return null;
    const T = this.system.kinetic(z, this.P), V = this.system.potential(z, this.P);
    return Math.abs(T + V - this.energy) <= TINY*(T + Math.abs(V) + Math.abs(this.energy)) ? z : null;
  }

  liftPlane(u, v) {
    const z = new Float64Array(4), i = this.index;
    z[i] = this.constant; z[1 - i] = u; z[3 - i] = v;
    const left = (this.energy - this.system.kinetic(z, this.P) - this.system.potential(z, this.P))/this.weight;
    if (!(left >= 0)) return null;
    z[2 + i] = Math.sqrt(left)*(this.direction < 0 ? -1 : 1);
    return z;
  }

  liftBody(u, v) {
    if (u < 0) return null;
    const sign = this.direction < 0 ? -1 : 1, c = this.constant;
    const missing = (left) => (left >= 0 ? Math.sqrt(left)*sign : NaN);
    switch (this.section) {
      case "alpha=c": return this.planes(c, missing(this.room(c, u) - v*v), u, v);
      case "beta=c": return this.planes(u, v, c, missing(this.room(u, c) - v*v));
      case "area=c": {
        const alpha = Math.sqrt(2*c + u*u), p = missing(this.room(alpha, u) - v*v);
        return (alpha*p - u*v)*this.direction >= 0 ? this.planes(alpha, p, u, v) : null;
      }
      default: return this.liftTurning(u, v);
    }
  }

  liftTurning(u, v) {
    const { x, through } = this.turningPoint(u, v);
    if (Number.isNaN(x)) return null;
    const alpha = this.section === "alpha-turning";
    const z = alpha ? this.planes(x, 0, u, v) : this.planes(u, v, x, 0);
    if (through > 0) z[alpha ? 5 : 7] = through;
    return z;
  }

  planes(alpha, pAlpha, beta, pBeta) {
    const a = this.p_eta ? this.p_eta/alpha : 0, b = this.p_gamma ? this.p_gamma/beta : 0;
    return Float64Array.of(alpha, 0, beta, 0, pAlpha, a, pBeta, b);
  }

  /** The turning point of the missing radius: the inner one for direction +1, else the outer one, of the outermost well. */
  turningPoint(u, v) {
    const f = (x) => this.radial(x, u), level = v*v, up = this.direction > 0, found = monotone(f, this.happens(u));
    const roots = [];
    for (let k = 1; k < found.x.length; k++) {
      const before = found.f[k - 1] >= level, after = found.f[k] >= level;
      if (before !== after && after === up) roots.push(bisected(f, found.x[k - 1], found.x[k], up, level));
    }
    const open = found.f[found.f.length - 1] >= level && up && roots.length > 1;
    if (roots.length) return { x: roots[roots.length - (open ? 2 : 1)], through: 0 };
    // No angular momentum: the motion goes through the axis.
    const axis = up && found.f[0] >= level ? f(0) - level : NaN;
    return axis >= 0 ? { x: 0, through: Math.sqrt(axis) } : { x: NaN, through: 0 };
  }

  /** The rectangle [u0, u1, v0, v1] around what is allowed; null where nothing is. */
  extent() {
    if (this.turning) this.radii = this.happens();
    const nodes = this.body ? [0, ...geometric(LEAST, 1e9, NODES_PER_DECADE)] : bothSigns(geometric(LEAST, 1e9, NODES_PER_DECADE));
    const found = monotone((u) => this.top(u), nodes), ranges = intervals((u) => this.top(u), found);
    if (!ranges.length) return null;
    const bounded = ranges.filter(([a, b]) => Number.isFinite(a) && Number.isFinite(b));
    let reach = Math.max(...found.x.slice(1, -1).map(Math.abs), ...ranges.flat().filter(Number.isFinite).map(Math.abs), LEAST);
    if (!bounded.length && reach < 10*LEAST) { // where it differs from far away
      const far = this.top(nodes[nodes.length - 1]);
      reach = nodes.findLast((u) => u > 0 && !(Math.abs(this.top(u) - far) <= CHANGED*Math.abs(far))) ?? reach;
    }
    let [low, high] = [Infinity, -Infinity];
    for (const [a, b] of bounded.length ? bounded : ranges) {
      low = Math.min(low, Math.max(a, this.body ? 0 : -1.3*reach));
      high = Math.max(high, Math.min(b, 1.3*reach));
    }
    const tops = Array.from({ length: 401 }, (_, k) => Math.max(0, finite(this.top(low + (high - low)*k/400))));
    let top = Math.max(...tops);
    for (let k = 0; k < found.x.length; k++) {
      if (found.x[k] >= low && found.x[k] <= high) top = Math.max(top, finite(found.f[k]));
    }
    const du = 0.03*(high - low) || LEAST, dv = 1.03*endOf(tops.map(Math.sqrt), Math.sqrt(top)) || LEAST;
    return [this.body ? Math.max(0, low - du) : low - du, high + du, -dv, dv];
  }

  /** Which points at the middles of width x height cells of a rectangle are allowed: 1 or 0, from the lower left. */
  mask([u0, u1, v0, v1], width, height) {
    const allowed = new Uint8Array(width*height);
    for (let i = 0; i < width; i++) {
      const u = u0 + (u1 - u0)*(i + 0.5)/width;
      if (this.body && u < 0) continue;
      const top = this.top(u);
      if (!(top >= 0)) continue;
      for (let j = 0; j < height; j++) {
        const v = v0 + (v1 - v0)*(j + 0.5)/height;
        if (this.allows(u, v, top)) allowed[j*width + i] = 1;
      }
    }
    return allowed;
  }
}

export function wrong(what, message) { return Object.assign(new Error(message), { what }); }

/** Where a view of momenta ends: at the largest, or at those of USUAL of the places if that is STEEP times larger, as near a pole. */
export function endOf(sizes, most) {
  const sorted = sizes.filter((size) => size > 0).sort((a, b) => a - b), usual = sorted[Math.floor(USUAL*sorted.length)];
  return most > STEEP*usual ? usual : most;
}

function finite(x) { return Number.isFinite(x) ? x : 0; }

export function geometric(low, high, perDecade) {
  const count = 2 + Math.ceil(perDecade*Math.log10(high/low)), ratio = Math.log(high/low)/(count - 1);
  return Array.from({ length: count }, (_, k) => low*Math.exp(ratio*k));
}

export function bothSigns(x) { return [...x.map((v) => -v).reverse(), 0, ...x]; }

/** The place and value of the largest f between two points with one maximum between them; sign -1: the smallest. */
export function climb(f, low, high, sign = 1) {
  const golden = 0.3819660112501051;
  let a = low, b = high, x = a + golden*(b - a), fx = sign*f(x), y = b - golden*(b - a), fy = sign*f(y);
  for (let k = 0; k < 60 && b - a > 1e-12*(Math.abs(a) + Math.abs(b)); k++) {
    if (fx >= fy) { b = y; y = x; fy = fx; x = a + golden*(b - a); fx = sign*f(x); }
    else { a = x; x = y; fx = fy; y = b - golden*(b - a); fy = sign*f(y); }
  }
  return fx >= fy ? { x, f: sign*fx } : { x: y, f: sign*fy };
}

function highest(f, nodes) {
  let best = -Infinity, at = -1;
  const values = nodes.map(f);
  values.forEach((value, k) => { if (value > best) { best = value; at = k; } });
  for (let k = 1; k + 1 < nodes.length; k++) {
    const peak = values[k] >= values[k - 1] && values[k] > values[k + 1] && values[k] > -Infinity;
    if (peak && (k === at || values[k] > best - Math.abs(best))) best = Math.max(best, climb(f, nodes[k - 1], nodes[k + 1]).f);
  }
  return best;
}

/** The first node, all extrema that the nodes show, the last node: between neighbours f is monotone. */
export function monotone(f, nodes) {
  const values = nodes.map(f), x = [nodes[0]], y = [values[0]];
  for (let k = 1; k + 1 < nodes.length; k++) {
    const [a, b, c] = [values[k - 1], values[k], values[k + 1]];
    if (b === -Infinity) continue;
    const sign = b >= a && b > c ? 1 : b <= a && b < c ? -1 : 0;
    if (!sign) {
      if (a === -Infinity || c === -Infinity) { x.push(nodes[k]); y.push(b); }
      continue;
    }
    const found = climb(f, nodes[k - 1], nodes[k + 1], sign);
    x.push(found.x); y.push(found.f);
  }
  x.push(nodes[nodes.length - 1]); y.push(values[values.length - 1]);
  return { x, f: y };
}

/** The allowed one (f >= level) of the neighbouring doubles between which f crosses the level. */
export function bisected(f, low, high, up, level) {
  let a = low, b = high;
  for (let k = 0; k < 200; k++) {
    const middle = a > 0 && b > 4*a ? Math.sqrt(a*b) : a < 0 && a < 4*b && b < 0 ? -Math.sqrt(a*b) : (a + b)/2;
    if (!(middle > a && middle < b)) break;
    if ((f(middle) >= level) === up) b = middle; else a = middle;
  }
  return up ? b : a;
}

/** The intervals where f >= 0, of extrema found by `monotone`; infinite where they reach its ends. */
function intervals(f, found) {
  const ends = [];
  const { x, f: y } = found, last = x.length - 1;
  if (y[0] >= 0) ends.push(x[0] === 0 ? 0 : -Infinity);
  for (let k = 1; k <= last; k++) {
    const up = y[k] >= 0;
    if (up !== (y[k - 1] >= 0)) ends.push(bisected(f, x[k - 1], x[k], up, 0));
  }
  if (y[last] >= 0) ends.push(Infinity);
  const pairs = [];
  for (let k = 0; k + 1 < ends.length; k += 2) pairs.push([ends[k], ends[k + 1]]);
  return pairs;
}
