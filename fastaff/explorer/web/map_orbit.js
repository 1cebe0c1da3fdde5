// Orbits of maps: iterates, one tangent vector by the exact derivative, what is read of them.

import { KEPT_FOR_ROTATION, Numbers, SAMPLED, Tangent } from "./engine.js";
import { reduced } from "./angles.js";
import { curveRotation } from "./curve.js";
import { fundamentalFrequencies, windingNumber } from "./readings.js";
import { wrong } from "./sections.js";

const RENEWED = 8, ITERATES = 2048, LOCKED = 12;

/** An orbit of iterates, followed slice by slice; its time is their number. */
export class MapOrbit {
  constructor(id, point, z0, plane, { P, frame, crossings }) {
    const system = plane.system.suited?.(z0) ?? plane.system;
    Object.assign(this, { id, point, z0, plane, system, P, wanted: crossings, batch: Math.ceil(ITERATES/(system.steps ?? 1)) });
    this.z = Float64Array.from(z0);
    this.motion = motionOfMap(system, P, plane.rowPeriods, z0);
    this.tangent = new Tangent({ n: system.n, h: 1 }, this.motion, system.line ? [1, 0] : frame, RENEWED); // one variable: its other row is idle
    this.wound = Array.from({ length: system.n }, (_, i) => i).filter((i) => system.winds[i]);
    this.width = 2*system.n + this.wound.length;
    this.block = new Float64Array(RENEWED*this.width);
    Object.assign(this, { points: new Numbers(), times: new Numbers(), states: new Numbers(), steps: 0, sent: 0, status: "running" });
    this.turns = this.wound.map(() => new Numbers());
    this.before = reduced(z0[0], plane.periods[0]); // the iterate before the next
    this.keep(this.z, 0);
  }

  get count() { return this.times.length; }

  get time() { return this.steps; }

  /** Keep the state for the lines of its signals. */
  keep(block, at) {
    const rows = 2*this.system.n;
    if (this.states.length < SAMPLED*rows) for (let r = 0; r < rows; r++) this.states.push(block[at + r]);
  }

  /** Follow the orbit for some iterates. */
  run(count) {
    const { system, P, z, tangent, block, width } = this;
    for (let left = count; left > 0 && this.status === "running";) {
      const wanted = Math.min(RENEWED - this.steps % RENEWED, this.wanted - this.count);
      const taken = system.iterates(z, tangent.u, P, wanted, block), inside = system.margin(z, P) > 0;
      for (let k = 0; k < taken && this.status === "running"; k++) this.take(k*width, inside || k < taken - 1);
      left -= wanted;
      if (this.steps % RENEWED === 0 || this.status !== "running") tangent.renew(this.steps);
    }
  }

  /** Take the iterate that begins at a place of the block. */
  take(at, inside) {
    const { block, turns, system, plane } = this, first = at + turns.length, rows = 2*system.n, [i, j] = plane.rows, [T, S] = plane.periods;
    let sum = 0;
    for (let r = 0; r < rows; r++) sum += 0*block[first + r];
    if (sum !== 0) { this.end("escaped"); return; }
    if (!inside) { this.end("lost"); return; }
    const u = reduced(block[first + i], T);
    if (system.line) this.points.push(this.before, u); // an iterate and its image
    else this.points.push(u, reduced(block[first + j], S));
    this.before = u;
    this.times.push(++this.steps);
    this.keep(block, first);
    if (this.steps <= KEPT_FOR_ROTATION) for (let k = 0; k < turns.length; k++) turns[k].push(block[at + k]);
    if (this.count >= this.wanted) this.end("done");
  }

  end(status) { if (this.status === "running") this.status = status; }

  /** What is known of the orbit by now. */
  reading() {
    const own = this.tangent.reading();
    if (this.status === "escaped" || this.status === "lost") own.classification = "undecided";
    const kept = Math.min(this.count, KEPT_FOR_ROTATION);
    if (!(kept < 1.2*(this.read ?? 0)) || this.status !== "running") {
      if (kept !== this.read) {
        this.frequencies = this.lines(kept);
        this.rotation = this.turning(kept);
      }
      this.read = kept;
    }
    return {
      crossings: this.count, time: this.steps, rotation: this.rotation ?? null, ...own, energy_error: null,
      frequencies: this.frequencies ?? null, status: this.status, step: 1, error: null,
    };
  }

  /** What an angle winds in each iterate, nothing of one variable that is none; of other planes the turns about the centre or, beside others, the tune; of a chain of
   * islands with {q, secondary}: the turns about its own island in q iterates. */
  turning(kept) {
    const { index } = this.plane, k = this.wound.indexOf(index), { line } = this.system, alone = this.system.n === 1;
    if (line) return k < 0 ? null : windingNumber(this.turns[k].view(0, kept));
    if (k < 0 && !alone) {
      const value = this.frequencies?.values[index] ?? null;
      return value === null ? null : { value, error: this.frequencies.errors[index] };
    }
    const whole = k < 0 ? curveRotation(this.points.view(0, 2*kept)) : windingNumber(this.turns[k].view(0, kept));
    if (whole?.q) return whole;
    const q = whole ? lockedPeriod(whole, kept) : 0;
    if (!q) return whole;
    const visits = this.visits(q, kept, Math.round(q*whole.value), this.turns[k]);
    return { ...whole, q, secondary: alone ? curveRotation(visits) : tuneOf(visits) };
  }

  /** The iterates q, 2q, ... of the plane, an angle without the turns that the island makes. */
  visits(q, kept, p, turns) {
    const found = new Float64Array(2*Math.floor(kept/q)), [period] = this.plane.periods;
    let lifted = 0;
    for (let j = 0; j < kept; j++) {
      if (period) lifted += turns.array[j];
      if ((j + 1) % q) continue;
      const at = 2*((j + 1)/q - 1);
      found[at] = period ? period*(lifted - p*(j + 1)/q) : this.points.array[2*j];
      found[at + 1] = this.points.array[2*j + 1];
    }
    return found;
  }

  /** The tune of each plane that oscillates, the winding of each angle, in turns per iterate. */
  lines(kept) {
    const { n, angles } = this.system, rows = this.states.length/(2*n), signals = new Float64Array(4*n*rows), all = this.states.array;
    for (let s = 0; s < rows; s++) {
      for (let i = 0; i < n; i++) {
        signals[4*(s*n + i)] = all[2*s*n + i];
        signals[4*(s*n + i) + 2] = all[2*s*n + n + i];
      }
    }
    const whole = this.wound.length < n && !this.system.line ? fundamentalFrequencies(signals, 4*n, 1, angles) : null;
    const values = angles.map((_, i) => whole?.values[i] ?? null), errors = angles.map((_, i) => whole?.errors[i] ?? null);
    values.forEach((value, i) => { if (value !== null) values[i] = value - Math.floor(value); });
    this.wound.forEach((i, k) => {
      const found = windingNumber(this.turns[k].view(0, kept));
      values[i] = found?.value ?? null; errors[i] = found?.error ?? null;
    });
    return { names: angles, values, errors };
  }

  motionBetween() { throw wrong("orbit", "a map has no motion between its iterates"); }
}

/** The tune of points u, v, u, v, ... with an error, null where they are few. */
function tuneOf(points) {
  const count = Math.min(points.length/2, SAMPLED), signal = new Float64Array(4*count);
  for (let s = 0; s < count; s++) { signal[4*s] = points[2*s]; signal[4*s + 2] = points[2*s + 1]; }
  const found = fundamentalFrequencies(signal, 4, 1, ["own"]), value = found?.values[0] ?? null;
  return value === null ? null : { value, error: found.errors[0] };
}

/** The period up to which a rotation number is that of a chain of islands, 0 where it is none. */
function lockedPeriod({ value, error }, count) {
  for (let q = 1; q <= LOCKED; q++) {
    if (Math.abs(q*value - Math.round(q*value)) <= q*Math.min(error, 1/count)) return q;
  }
  return 0;
}

/** The scales of a map's orbit: a radian an iterate, the ratio of coordinates and momenta from the derivative; as flows/motion.py. */
function motionOfMap(system, P, periods, z0) {
  const { n } = system, rows = 2*n, usable = (x) => (Number.isFinite(x) && x > 0 ? x : 1);
  const M = Array.from({ length: rows }, (_, column) => {
    const image = new Float64Array(rows);
    system.tangent(z0, Float64Array.from({ length: rows }, (_, r) => Number(r === column)), P, image);
    return image;
  });
  const W = Array.from({ length: n }, (_, i) => {
    const pull = Math.abs(M[i][n + i]), push = Math.abs(M[n + i][i]);
    if (periods[i]) return 1/usable(push > 0 ? 1/push : 1);
    return 1/usable(pull > 0 && push > 0 ? Math.sqrt(pull/push) : push > 0 ? 1/push : pull);
  });
  return { rate: 1, W };
}
