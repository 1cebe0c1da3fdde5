// Sections of H(q, p) of two degrees of freedom and of flows dz/dt = f(z): their points, how far they reach.

import { reduced } from "./angles.js";
import { Flow } from "./engine.js";
import { motionOfEquations } from "./equations.js";
import { ends } from "./map_plane.js";
import { bisected, bothSigns, endOf, geometric, label, monotone, wrong } from "./sections.js";

const LEAST_ROW = 1e-6, MOST_ROW = 1e6, ROW_LOOKS = 8, BOX_CELLS = 64, SAME_WEIGHT = 1e-9, ON_ENERGY = 1e-9, REST_SWEEPS = 30, BEYOND = 1.3, ZOOMS = 12, ZOOMED = 8;
const FLOW_BENT = 0.5, FLOW_STARTS = 16, FLOW_TURNS = 60, FLOW_PACE = 0.3, SPREAD_ROWS = [0.8191725133961645, 0.6710436067037893, 0.5497004779019703];

/** What sections of rows have in common: q_i = c, modulo the period where q_i is an angle, over two other rows. */
class RowSection {
  constructor(system, P, names, { section, constant = null, direction = 1 }, sections) {
    const at = sections.indexOf(section);
    if (at < 0) throw wrong("section", `the section must be one of ${sections.join(", ")}, got ${section}`);
    if (constant !== null && !Number.isFinite(constant)) throw wrong("section", `constant must be a finite number, got ${constant}`);
    if (![1, 0, -1].includes(direction)) throw wrong("direction", `direction must be +1, -1 or 0, got ${direction}`);
    Object.assign(this, { system, P, section, constant: constant ?? 0, direction, index: at, spans: system.periods(P), body: false });
    if (this.spans.some((span, r) => !(Number.isFinite(span) && (system.winds[r] ? span > 0 : span === 0)))) {
      throw wrong("parameter", `the periods of angles must be positive, got ${this.spans.filter((span) => span).join(", ")}`);
    }
    const turn = 2*Math.PI/this.spans[at], c = this.constant;
    this.value = this.spans[at] ? (z) => Math.sin(turn*(z[at] - c))/turn : (z) => z[at] - c;
  }

  seen(rows, names) {
    Object.assign(this, { seenRows: rows, seenSpans: rows.map((r) => this.spans[r]), axes: rows.map((r) => names[r]) });
    this.labels = this.axes.map(label);
  }

  counts(z) { return !this.spans[this.index] || Math.cos(2*Math.PI*(z[this.index] - this.constant)/this.spans[this.index]) > 0; }

  project(z, out, at) { for (let k = 0; k < 2; k++) out[at + k] = reduced(z[this.seenRows[k]], this.spans[this.seenRows[k]]); }

  /** Which points at the middles of width x height cells of a rectangle are allowed: 1 or 0, from the lower left. */
  mask([u0, u1, v0, v1], width, height) {
    const allowed = new Uint8Array(width*height);
    for (let j = 0; j < height; j++) {
      for (let i = 0; i < width; i++) allowed[j*width + i] = Number(this.allows(u0 + (u1 - u0)*(i + 0.5)/width, v0 + (v1 - v0)*(j + 0.5)/height));
    }
    return allowed;
  }

  allows(u, v) { return this.lift(u, v) !== null; }
}

/** A section of an energy surface of H(q, p). */
export class EnergySurface extends RowSection {
  constructor(system, P, { coordinates, momenta }, choice) {
    super(system, P, coordinates, choice, coordinates.map((name) => `${name}=c`));
    if (!Number.isFinite(choice.energy)) throw wrong("energy", `energy must be a finite number, got ${choice.energy}`);
    Object.assign(this, { energy: choice.energy, coordinates });
    this.seen([1 - this.index, 3 - this.index], [...coordinates, ...momenta]);
    this.f = new Float64Array(4);
    this.ofDegreeTwo = this.isOfDegreeTwo();
    this.cells = this.ofDegreeTwo ? 256 : 96;
  }

  /** Whether dv/dp of the momentum that is solved for depends on no momentum, at places of all sizes. */
  isOfDegreeTwo() {
    const i = this.index, z = new Float64Array(4), weight = () => { this.system.column(z, 2 + i, this.P, this.f); return this.f[i]; };
    for (let k = 0; k < 12; k++) {
      const size = 10**(k % 4 - 1.5);
      for (let r = 0; r < 4; r++) z[r] = size*Math.sin(1 + 7*k + 3*r);
      z[i] = this.constant;
      const before = weight();
      z[2 + i] += size; z[3 - i] -= 0.7*size;
      const now = weight();
      if (Number.isFinite(before + now) && !(Math.abs(now - before) <= SAME_WEIGHT*Math.abs(before))) return false;
    }
    return true;
  }

  refusal(u, v) { return `${this.labels[0]} = ${u.toPrecision(5)}, ${this.labels[1]} = ${v.toPrecision(5)} is not on the energy surface`; }

  /** The state over a point, or null: the momentum whose velocity has the sign of the direction, the outermost of several. */
  lift(u, v) {
    const z = new Float64Array(4), i = this.index, half = this.spans[1 - i]/2;
    if (half && !(Math.abs(u) <= half)) return null;
    z[i] = this.constant; z[1 - i] = u; z[3 - i] = v;
    const found = this.ofDegreeTwo ? this.parabola(z) : this.outermost(z);
    if (!Number.isFinite(found)) return null;
    z[2 + i] = found;
    if (!(this.system.margin(z, this.P) > 0)) return null;
    const H = this.system.energy(z, this.P), size = this.system.kinetic(z, this.P) + Math.abs(H) + Math.abs(this.energy);
    return Math.abs(H - this.energy) <= ON_ENERGY*size ? z : null;
  }

  /** The root of H = H0 + v p + w p^2/2 with the velocity +-sqrt(v^2 + 2 w (E - H0)), bettered once; as surface_roots.py. */
  parabola(z) {
    const { system, P, f } = this, i = this.index, sign = this.direction < 0 ? -1 : 1;
    system.rates(z, P, f);
    const v = f[i], rest = this.energy - system.energy(z, P);
    system.column(z, 2 + i, P, f);
    const speed = sign*Math.sqrt(v*v + 2*f[i]*rest), p = v*sign > 0 ? 2*rest/(v + speed) : (speed - v)/f[i];
    z[2 + i] = p;
    const miss = system.energy(z, P) - this.energy;
    system.rates(z, P, f);
    z[2 + i] = p - miss/f[i];
    return Math.abs(system.energy(z, P) - this.energy) < Math.abs(miss) ? z[2 + i] : p;
  }

  outermost(z) {
    const sign = this.direction < 0 ? -1 : 1, row = 2 + this.index;
    const room = (x) => {
      z[row] = sign*x;
      const left = this.system.margin(z, this.P) > 0 ? this.energy - this.system.energy(z, this.P) : NaN;
      return Number.isNaN(left) ? -Infinity : left;
    };
    const found = monotone(room, this.nodes ?? (this.nodes = bothSigns(geometric(LEAST_ROW, MOST_ROW, ROW_LOOKS))));
    for (let k = found.x.length - 1; k > 0; k--) {
      if (found.f[k - 1] >= 0 && found.f[k] < 0) return sign*bisected(room, found.x[k - 1], found.x[k], false, 0);
    }
    return NaN;
  }

  /** The rectangle [u0, u1, v0, v1] around what is allowed and joined to its middle; null where nothing is. */
  extent() {
    const half = this.spans[1 - this.index]/2, line = bothSigns(geometric(LEAST_ROW, MOST_ROW, this.ofDegreeTwo ? ROW_LOOKS : 4));
    const u = half ? Array.from({ length: BOX_CELLS + 1 }, (_, k) => half*(2*k/BOX_CELLS - 1)) : line, v = line;
    const is = u.map((x) => v.map((y) => this.allows(x, y)));
    const kept = joined(is, u, v);
    if (!kept.length) return null;
    const place = (k, i) => [u, v][k][Math.min([u, v][k].length - 1, Math.max(0, i))];
    let box = [0, 1].flatMap((k) => {
      const at = kept.map((cell) => cell[k]), low = Math.min(...at), high = Math.max(...at), last = [u, v][k].length - 1;
      if (low > 0 && high < last) return [place(k, low - 1), place(k, high + 1)];
      if (half && k === 0) return [-half, half];
      const inner = edgesOf(is, [u, v], k), far = BEYOND*(inner.length ? Math.max(...inner.map(Math.abs)) : 1); // it goes on and on
      return [-far, far];
    });
    box = this.withoutPole(box, v);
    for (let pass = 0; pass < 3; pass++) box = this.tightened(box, half);
    return box;
  }

  /** A rectangle whose momenta end where a view does: there is no end of them at a pole of the potential. */
  withoutPole([u0, u1, v0, v1], momenta) {
    const size = (u) => momenta.findLast((v) => v >= 0 && (this.allows(u, v) || this.allows(u, -v))) ?? 0;
    let width = (u1 - u0)/BOX_CELLS, places = Array.from({ length: BOX_CELLS }, (_, k) => u0 + width*(k + 0.5)), sizes = places.map(size);
    const all = sizes;
    for (let zoom = 0; zoom < ZOOMS; zoom++, width *= 2/ZOOMED) {
      const at = places[sizes.indexOf(Math.max(...sizes))];
      places = Array.from({ length: 2*ZOOMED + 1 }, (_, k) => at + width*(k/ZOOMED - 1));
      sizes = places.map(size);
    }
    const most = Math.max(...sizes), end = endOf(all, most);
    return end < most ? [u0, u1, -BEYOND*end, BEYOND*end] : [u0, u1, v0, v1];
  }

  /** A rectangle with what is allowed in it and a cell around. */
  tightened([u0, u1, v0, v1], half) {
    const allowed = this.mask([u0, u1, v0, v1], BOX_CELLS, BOX_CELLS), du = (u1 - u0)/BOX_CELLS, dv = (v1 - v0)/BOX_CELLS;
    const i = [], j = [];
    allowed.forEach((is, cell) => { if (is) { i.push(cell % BOX_CELLS); j.push(Math.floor(cell/BOX_CELLS)); } });
    if (!i.length) return [u0, u1, v0, v1];
    const [low, high] = half ? [-half, half] : [u0 + (Math.min(...i) - 1)*du, u0 + (Math.max(...i) + 2)*du];
    return [low, high, v0 + (Math.min(...j) - 1)*dv, v0 + (Math.max(...j) + 2)*dv];
  }
}

/** The cells joined to the one nearest to the middle among those that are, by places u and v. */
function joined(is, u, v) {
  let first = null, least = Infinity;
  is.forEach((row, i) => row.forEach((one, j) => {
    const away = Math.hypot(u[i], v[j]);
    if (one && away < least) { least = away; first = [i, j]; }
  }));
  const found = [], waiting = first ? [first] : [], seen = new Set();
  while (waiting.length) {
    const [i, j] = waiting.pop(), key = i*v.length + j;
    if (!is[i]?.[j] || seen.has(key)) continue;
    seen.add(key);
    found.push([i, j]);
    waiting.push([i + 1, j], [i - 1, j], [i, j + 1], [i, j - 1]);
  }
  return found;
}

/** Where along an axis what is allowed begins or ends. */
function edgesOf(is, lines, k) {
  const found = [];
  is.forEach((row, i) => row.forEach((one, j) => {
    const next = k ? row[j + 1] : is[i + 1]?.[j];
    if (next !== undefined && next !== one) found.push(lines[k][(k ? j : i) + 1]);
  }));
  return found;
}

/** The least H over the momenta at a place (q0, q1): {value, p}; null where H has no minimum over them. */
export function restingAt(system, P, q0, q1) {
  const z = Float64Array.of(q0, q1, 0, 0), f = new Float64Array(4), a = new Float64Array(4), b = new Float64Array(4);
  for (let k = 0; k < REST_SWEEPS; k++) {
    if (!(system.margin(z, P) > 0)) return null;
    system.rates(z, P, f);
    system.column(z, 2, P, a); system.column(z, 3, P, b);
    const det = a[0]*b[1] - b[0]*a[1];
    if (!(det > 0 && a[0] > 0)) return null;
    const dp = [(b[1]*f[0] - b[0]*f[1])/det, (a[0]*f[1] - a[1]*f[0])/det];
    z[2] -= dp[0]; z[3] -= dp[1];
    if (Math.hypot(...dp) <= 1e-12*(Math.hypot(z[2], z[3]) + 1e-12)) return { value: system.energy(z, P), z };
  }
  return null;
}

/** A section q_i = c of a flow, over its first two other variables; the rest start at `others`. */
export class FlowSection extends RowSection {
  constructor(system, P, { coordinates, scheme }, choice) {
    super(system, P, coordinates, choice, coordinates.map((name) => `${name}=c`));
    Object.assign(this, { energy: null, scheme });
    this.periods = [0, 0];
    this.seen([...coordinates.keys()].filter((r) => r !== this.index).slice(0, 2), coordinates);
    this.start = Float64Array.from(coordinates, (name) => choice.others?.[name] ?? 0);
    this.start[this.index] = this.constant;
  }

  refusal(u, v) { return `${this.labels[0]} = ${u.toPrecision(5)}, ${this.labels[1]} = ${v.toPrecision(5)} is not in the domain of the equations`; }

  lift(u, v) {
    const z = this.start.slice();
    z[this.seenRows[0]] = u; z[this.seenRows[1]] = v;
    return z.every(Number.isFinite) && this.system.margin(z, this.P) > 0 ? z : null;
  }

  /** A rectangle around the crossings to which orbits from around come. */
  extent() {
    const size = this.bend(), u = [], v = [], at = new Float64Array(2), rows = this.system.rows;
    for (let k = 0; k < FLOW_STARTS; k++) {
      const z = this.tried(k, size);
      const motion = motionOfEquations(new Flow(this.system, this.P, this.scheme, 1), z), flow = new Flow(this.system, this.P, this.scheme, FLOW_PACE/motion.rate);
      let before = this.value(z);
      for (let step = 0; step*FLOW_PACE < 2*Math.PI*FLOW_TURNS; step++) {
        flow.advance(z, flow.h);
        const now = this.value(z);
        if (!Number.isFinite(now) || z.some((x, r) => r < rows && Math.abs(x) > 1e6*size)) break;
        if (2*step*FLOW_PACE > 2*Math.PI*FLOW_TURNS && before*now < 0 && (now - before)*this.direction >= 0) { this.project(z, at, 0); u.push(at[0]); v.push(at[1]); }
        before = now;
      }
    }
    const found = [...ends(u), ...ends(v)];
    return u.length && found.every(Number.isFinite) && found[1] > found[0] && found[3] > found[2] ? found : [-size, size, -size, size];
  }

  tried(k, size) { return this.start.map((x, r) => (!this.seenRows.includes(r) ? x : size*(2*((0.5 + (k + 1)*SPREAD_ROWS[r % 3]) % 1) - 1))); }

  /** A size at which the rates have other derivatives than at the middle of the section. */
  bend() {
    const { system, P } = this, out = new Float64Array(system.rows);
    const slopes = (z) => [...z.keys()].flatMap((r) => { system.column(z, r, P, out); return [...out]; });
    const first = slopes(this.start), most = Math.max(...first.map(Math.abs));
    for (const size of geometric(1e-5, 1e5, 4)) {
      for (let k = 0; k < FLOW_STARTS; k++) {
        const other = slopes(this.tried(k, size));
        if (!(Math.max(...other.map((x, r) => Math.abs(x - first[r]))) <= FLOW_BENT*most)) return 2*size;
      }
    }
    return 1;
  }
}
