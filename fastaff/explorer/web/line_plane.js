// The plane of a map of one variable: each point is an iterate x and its image; where its orbits are, the graph of the map.

import { reduced } from "./angles.js";
import { wrong } from "./sections.js";

const SIZES = 45, LEAST_SIZE = 1e-5, PER_DECADE = 4; // half widths of the intervals in which starts are tried
const TRIED_STARTS = 128, TRIED_ITERATES = 300, TOO_FAR = 1e3, SOME_STAY = 1/16; // the last two in half widths, in starts
const ROOM = 0.25; // of the range, beside what stays, that is looked at again
const GRAPH_POINTS = 4001, GRAPH_WIDTHS = 3; // the graph goes beyond the frame, for views that are moved

/** The plane (x, image of x) of a map of one variable. */
export class LinePlane {
  constructor(system, P, { coordinates }, { section }) {
    if (section !== coordinates[0]) throw wrong("section", `the plane must be ${coordinates[0]}, got ${section}`);
    Object.assign(this, { out: new Float64Array(2), system, P, section, energy: null, constant: null, index: 0, isMap: true, rows: [0, 0] });
    this.axes = [section, "image"];
    this.labels = [section, `image of ${section}`];
    this.rowPeriods = system.periods(P);
    const [period] = this.rowPeriods;
    if (!(Number.isFinite(period) && (system.winds[0] ? period > 0 : period === 0))) throw wrong("parameter", `the period of ${section} must be positive, got ${period}`);
    this.periods = [period, period];
  }

  image(x) {
    this.system.iterate([x, 0], this.P, this.out);
    return reduced(this.out[0], this.periods[0]);
  }

  /** The point of a state: where it is, and where it goes. */
  project(z, out, at) {
    out[at] = reduced(z[0], this.periods[0]);
    out[at + 1] = this.image(out[at]);
  }

  /** The state at a point's x, null outside of the map's domain. */
  lift(u) {
    const x = reduced(u, this.periods[0]), z = Float64Array.of(x, 0);
    return Number.isFinite(this.image(x)) && this.system.margin(z, this.P) > 0 ? z : null;
  }

  allows(u, v) { return reduced(u, this.periods[0]) === u && reduced(v, this.periods[0]) === v && this.lift(u) !== null; }

  refusal(u) { return `${this.section} = ${u.toPrecision(5)} is not in the domain of the map`; }

  /** The square [x0, x1, x0, x1] to begin with: a period, or where orbits stay. */
  extent() {
    const [period] = this.periods, [low, high] = period ? [-period/2, period/2] : this.bounds();
    return [low, high, low, high];
  }

  /** The iterates of a start, [] where it does not stay within `far`. */
  stays(x, far) {
    const found = new Float64Array(TRIED_ITERATES);
    for (let k = 0; k < TRIED_ITERATES; k++) {
      if (!(Math.abs(x) < far && this.system.margin([x, 0], this.P) > 0)) return [];
      found[k] = x = this.image(x);
    }
    return Math.abs(x) < far ? found : [];
  }

  /** The range of starts in an interval that stay and of their iterates, null where none does; share: how many of them stay. */
  range(low, high, far) {
    let least = Infinity, most = -Infinity, count = 0, late = [Infinity, -Infinity];
    for (let i = 0; i < TRIED_STARTS; i++) {
      const x = low + (high - low)*(i + 0.5)/TRIED_STARTS, found = this.stays(x, far);
      if (!found.length) continue;
      count++;
      least = Math.min(least, x, ...found); most = Math.max(most, x, ...found);
      const end = found.subarray(TRIED_ITERATES >> 1);
      late = [Math.min(late[0], ...end), Math.max(late[1], ...end)];
    }
    return count ? { low: least, high: most, late, share: count/TRIED_STARTS } : null;
  }

  /** Where starts stay, as far out as a share of them does; where all do at any distance, a range around their ends. */
  bounds() {
    const sizes = Array.from({ length: SIZES }, (_, k) => LEAST_SIZE*10**(k/PER_DECADE)).reverse();
    let at = 0, found = null;
    for (; at < SIZES && !(found?.share >= SOME_STAY); at++) found = this.range(-sizes[at], sizes[at], TOO_FAR*sizes[at]);
    if (!(found?.share >= SOME_STAY)) return [-1, 1];
    if (--at === 0) return aroundAttractor(this.range(-1, 1, TOO_FAR*sizes[0]).late); // from the farthest of all
    const { low, high } = found, room = ROOM*(high - low), again = this.range(low - room, high + room, TOO_FAR*sizes[at]);
    return [again.low, again.high];
  }

  /** Which cells of a rectangle are in the domain: whole columns. */
  mask([u0, u1, v0, v1], width, height) {
    const allowed = new Uint8Array(width*height);
    for (let i = 0; i < width; i++) {
      const is = Number(this.lift(u0 + (u1 - u0)*(i + 0.5)/width) !== null);
      for (let j = 0; j < height; j++) allowed[j*width + i] = is && Number(reduced(v0 + (v1 - v0)*(j + 0.5)/height, this.periods[0]) === v0 + (v1 - v0)*(j + 0.5)/height);
    }
    return allowed;
  }

  /** Points x, image, x, image, ... of the graph, NaN outside of the domain and where it jumps by a period. */
  graph([u0, u1]) {
    const [period] = this.periods, wide = period ? 0 : (GRAPH_WIDTHS - 1)/2*(u1 - u0), found = new Float64Array(2*GRAPH_POINTS);
    for (let k = 0, before = NaN; k < GRAPH_POINTS; k++) {
      const x = u0 - wide + (u1 - u0 + 2*wide)*k/(GRAPH_POINTS - 1), inside = this.system.margin([x, 0], this.P) > 0, image = inside ? this.image(x) : NaN;
      const jumps = period > 0 && Math.abs(image - before) > period/2;
      found[2*k] = x; found[2*k + 1] = jumps || !Number.isFinite(image) ? NaN : image;
      before = image;
    }
    return found;
  }
}

/** A range around where all orbits end, with 0 where that is one point. */
function aroundAttractor([low, high]) {
  const width = high - low;
  if (width > 1e-6*Math.max(Math.abs(low), Math.abs(high))) return [low - width/2, high + width/2];
  const size = Math.max(Math.abs(low), Math.abs(high)) || 1;
  return size < 1e-6 ? [-1, 1] : [Math.min(0, low) - size/2, Math.max(0, high) + size/2];
}
