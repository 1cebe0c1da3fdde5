// The plane of a coordinate of a map and its momentum: where its points are, which of them are in its domain, how far it reaches.

import { reduced } from "./angles.js";
import { wrong } from "./sections.js";

const HOME = { sizes: 45, smallest: 1e-5, perDecade: 4, tried: 64, starts: 256, looks: 200, long: 1000, far: 1e3, some: 1/16, bent: 0.5, bends: 5, quantile: 0.005, edge: 0.06 };
const PLASTIC = [0.7548776662466927, 0.5698402909980532]; // shares of the unit square that fill it evenly

/** A plane (q_i, p_i) of a map; `others` are the start values of its other rows by name. */
export class MapPlane {
  constructor(system, P, { coordinates, momenta }, { section, others = {} }) {
    const planes = coordinates.map((name, i) => `${name},${momenta[i]}`), names = [...coordinates, ...momenta];
    if (!planes.includes(section)) throw wrong("section", `the plane must be one of ${planes.join("; ")}, got ${section}`);
    Object.assign(this, { system, P, section, energy: null, constant: null, index: planes.indexOf(section), isMap: true });
    this.rows = [this.index, system.n + this.index];
    this.axes = this.labels = this.rows.map((r) => names[r]);
    this.start = Float64Array.from(names, (name, r) => {
      const value = this.rows.includes(r) ? 0 : others?.[name] ?? 0;
      if (!Number.isFinite(value)) throw wrong("section", `${name} must be a finite number, got ${value}`);
      return value;
    });
    this.rowPeriods = system.periods(P);
    for (const r of names.keys()) {
      const period = this.rowPeriods[r];
      if (!(Number.isFinite(period) && (system.winds[r] ? period > 0 : period === 0))) {
        throw wrong("parameter", `the period of ${names[r]} must be positive, got ${period}`);
      }
    }
    this.periods = this.rows.map((r) => this.rowPeriods[r]);
  }

  /** Section coordinates of a state, angles in [-T/2, T/2). */
  project(z, out, at) {
    for (let k = 0; k < 2; k++) out[at + k] = reduced(z[this.rows[k]], this.periods[k]);
  }

  /** The state over a point, null outside of the map's domain. */
  lift(u, v) {
    const z = this.start.slice();
    z[this.rows[0]] = reduced(u, this.periods[0]); z[this.rows[1]] = reduced(v, this.periods[1]);
    return z.every(Number.isFinite) && this.system.margin(z, this.P) > 0 ? z : null;
  }

  /** Whether a point, of angles within half a period of 0, is in the domain. */
  allows(u, v) { return reduced(u, this.periods[0]) === u && reduced(v, this.periods[1]) === v && this.lift(u, v) !== null; }

  refusal(u, v) { return `${this.labels[0]} = ${u.toPrecision(5)}, ${this.labels[1]} = ${v.toPrecision(5)} is not in the domain of the map`; }

  /** The rectangle [u0, u1, v0, v1] to begin with: whole periods, and what stays bounded or where the map is no straight one. */
  extent() {
    if (this.system.home) {
      const [T] = this.periods, [size, reach] = this.system.home();
      return [T ? -T/2 : -size, T ? T/2 : size, -reach, reach];
    }
    const [T, S] = this.periods, turn = T && S ? 0 : T ? this.turn(0) : S ? this.turn(1) : 0;
    const [u0, u1, v0, v1] = (T && S) || turn ? square(turn/2) : this.bounds();
    return [T ? -T/2 : u0, T ? T/2 : u1, S ? -S/2 : v0, S ? S/2 : v1];
  }

  /** The change of its partner with which the angle k winds by a turn more in each iterate; 0 where it has none. */
  turn(k) {
    const z = this.start.slice(), w = new Float64Array(z.length), out = new Float64Array(z.length);
    w[this.rows[1 - k]] = 1;
    this.system.tangent(z, w, this.P, out);
    const turn = Math.abs(this.periods[k]/out[this.rows[k]]);
    return Number.isFinite(turn) ? turn : 0;
  }

  /** The start k of the square of some half width. */
  tried(k, size) {
    const z = this.start.slice();
    for (let i = 0; i < 2; i++) {
      const place = (0.5 + (k + 1)*PLASTIC[i]) % 1, period = this.periods[i];
      z[this.rows[i]] = period ? place*period : size*(2*place - 1);
    }
    return z;
  }

  /** Whether a start stays within `far` for so many iterates; sees(state, iterate) looks at them. */
  stays(z, far, count, sees) {
    const out = new Float64Array(3*z.length), w = new Float64Array(z.length);
    for (let k = 0; k < count; k++) {
      if (!(this.system.margin(z, this.P) > 0)) return false;
      this.system.iterates(z, w, this.P, 1, out);
      if (!(this.rows.every((r, i) => this.periods[i] > 0 || Math.abs(z[r]) < far))) return false;
      sees?.(z, k);
    }
    return true;
  }

  bounds() {
    let size = null, all = true;
    for (let k = HOME.sizes - 1; k >= 0 && size === null; k--) {
      const own = HOME.smallest*10**(k/HOME.perDecade);
      let kept = 0;
      for (let i = 0; i < HOME.tried; i++) kept += this.stays(this.tried(i, own), HOME.far*own, HOME.looks);
      all &&= kept === HOME.tried;
      if (kept >= HOME.some*HOME.tried) size = own;
    }
    if (size === null || all) return square(this.bend());
    const u = [], v = [], at = new Float64Array(2);
    for (let i = 0; i < HOME.starts; i++) {
      const own = [];
      const stayed = this.stays(this.tried(i, size), HOME.far*size, HOME.long, (z, k) => {
        if (2*k >= HOME.long) { this.project(z, at, 0); own.push(at[0], at[1]); }
      });
      if (stayed) for (let k = 0; k < own.length; k += 2) { u.push(own[k]); v.push(own[k + 1]); }
    }
    const found = [...ends(u), ...ends(v)];
    return found.every(Number.isFinite) ? found : square(size);
  }

  /** A size at which the derivative of the map is another than at the origin. */
  bend() {
    const first = this.derivative(this.start), most = Math.max(...first.map(Math.abs));
    for (let k = 0; k < HOME.sizes; k++) {
      const size = HOME.smallest*10**(k/HOME.perDecade);
      for (let i = 0; i < HOME.tried; i++) {
        const other = this.derivative(this.tried(i, size));
        if (!(Math.max(...other.map((x, r) => Math.abs(x - first[r]))) <= HOME.bent*most)) return HOME.bends*size;
      }
    }
    return 1;
  }

  derivative(z) {
    const out = new Float64Array(z.length), found = [];
    for (const r of this.rows) {
      this.system.tangent(z, Float64Array.from(z, (_, k) => (k === r ? 1 : 0)), this.P, out);
      found.push(...out);
    }
    return found;
  }

  /** Which points at the middles of width x height cells of a rectangle are in the domain: 1 or 0, from the lower left. */
  mask([u0, u1, v0, v1], width, height) {
    const allowed = new Uint8Array(width*height);
    for (let j = 0; j < height; j++) {
      for (let i = 0; i < width; i++) {
        allowed[j*width + i] = Number(this.allows(u0 + (u1 - u0)*(i + 0.5)/width, v0 + (v1 - v0)*(j + 0.5)/height));
      }
    }
    return allowed;
  }
}

export function square(size) { return [-size, size, -size, size]; }

/** Where all but a few of some numbers lie, with an edge around. */
export function ends(values) {
  const sorted = Float64Array.from(values).sort(), skip = Math.floor(HOME.quantile*sorted.length);
  const low = sorted[skip], high = sorted[sorted.length - 1 - skip], edge = HOME.edge*(high - low) || HOME.edge*Math.abs(high) || 1;
  return [low - edge, high + edge];
}
