// A driven system as the map of its states after whole periods of the drive, by the package's schemes.

const FIRST_STEPS = 32, MOST_STEPS = 1 << 14, TRIAL_PERIODS = 4, PLACES = 64, LEAST_HOME = 1e-6, DECADES = 12, PER_TEN = 8, WIDER = 5, AROUND = 1.6;

/** The stroboscopic map at a phase: what a map's functions are, by so many steps a period. system: of coordinates x, t. */
export class Strobed {
  constructor(system, P, scheme, accuracy, phase, steps = FIRST_STEPS) {
    Object.assign(this, { base: system, P, scheme, accuracy, phase, steps, n: 1, kind: "map", winds: system.winds, angles: system.angles });
    this.period = system.period(null, P);
    this.h = this.period/steps;
    this.a = scheme.aArray ?? (scheme.aArray = Float64Array.from(scheme.a));
    this.b = scheme.bArray ?? (scheme.bArray = Float64Array.from(scheme.b));
    this.state = new Float64Array(4); this.vector = new Float64Array(4); this.place = new Float64Array(4);
  }

  periods() { return [this.winds[0] ? this.base.periods?.(this.P)[0] ?? 2*Math.PI : 0, 0]; }

  margin(z) {
    this.place[0] = z[0]; this.place[1] = this.phase;
    return this.base.margin(this.place, this.P);
  }

  /** One period; the state in `state`, the vector in `vector`. */
  advance(x, p, dx, dp) {
    const { state, vector } = this;
    state[0] = x; state[1] = this.phase; state[2] = p; state[3] = 0;
    vector[0] = dx; vector[1] = 0; vector[2] = dp; vector[3] = 0;
    this.base.marchTangent(state, vector, this.P, this.a, this.b, this.h, this.steps);
  }

  iterate(z, P, out) {
    this.advance(z[0], z[1], 0, 0);
    out[0] = this.state[0]; out[1] = this.state[2];
  }

  tangent(z, w, P, out) {
    this.advance(z[0], z[1], w[0], w[1]);
    out[0] = this.vector[0]; out[1] = this.vector[2];
  }

  iterates(z, w, P, count, out) {
    const { state, vector } = this, [period] = this.periods();
    let taken = 0, at = 0, inside = true;
    while (taken < count && inside) {
      this.advance(z[0], z[1], w[0], w[1]);
      let x = state[0];
      if (period) { out[at++] = (x - z[0])/period; x -= period*Math.round(x/period); }
      out[at++] = z[0] = x; out[at++] = z[1] = state[2];
      w[0] = vector[0]; w[1] = vector[2];
      taken++;
      inside = this.margin(z) > 0;
    }
    return taken;
  }

  /** The same with the steps that the first periods of an orbit need for the accuracy. */
  suited(z0) {
    const first = this.base.rates ? FIRST_STEPS/4 : FIRST_STEPS; // collocations are of higher order
    let before = this.with(first/2).trace(z0);
    for (let steps = first; ; steps *= 2) {
      const fine = this.with(steps), now = fine.trace(z0), size = [0, 1].map((r) => Math.max(...now.map((z) => Math.abs(z[r]))) || 1);
      const apart = Math.max(...now.map((z, k) => Math.max(...[0, 1].map((r) => Math.abs(z[r] - before[k][r])/size[r]))));
      // The finer run's error is 2^order times less; half of that is for what later periods add.
      if (apart <= this.accuracy*2**(this.scheme.order/2) || steps >= MOST_STEPS) return fine;
      before = now;
    }
  }

  with(steps) { return new Strobed(this.base, this.P, this.scheme, this.accuracy, this.phase, steps); }

  trace(z0) {
    const z = Float64Array.of(z0[0], this.phase, z0[1], 0);
    return Array.from({ length: TRIAL_PERIODS }, () => {
      z[1] = this.phase;
      this.base.march(z, this.P, this.a, this.b, this.h, this.steps);
      return [z[0], z[2]];
    });
  }

  /** Half widths of a first view, of coordinate and momentum: where the force is no straight one, and what falls so far. */
  home() {
    const { place, base, P } = this, out = new Float64Array(2), whole = Boolean(this.winds[0]);
    const at = (x) => { place[0] = x; place[1] = this.phase; place[2] = 1; place[3] = 0; return place; };
    const slope = (x) => { base.tangent(at(x), P, out); return out[0]; };
    const first = slope(0);
    let size = whole ? this.periods()[0]/2 : 1;
    for (let k = 0; k < DECADES*PER_TEN && !whole; k++) {
      const x = LEAST_HOME*10**(k/PER_TEN);
      if (Math.max(Math.abs(slope(x) - first), Math.abs(slope(-x) - first)) > 0.5*Math.abs(first)) { size = WIDER*x; break; }
    }
    let low = Infinity, high = -Infinity, most = 0;
    for (let k = 0; k <= PLACES; k++) {
      const x = size*(2*k/PLACES - 1), V = base.potential(at(x), P);
      base.force(place, P, out);
      most = Math.max(most, Math.abs(out[0]) || 0);
      if (Number.isFinite(V)) { low = Math.min(low, V); high = Math.max(high, V); }
    }
    base.velocity(at(0), P, out);
    const fall = whole ? 2*most : high - low;
    return [size, (whole ? AROUND : 1)*Math.sqrt(2*fall/Math.abs(out[0])) || 1];
  }
}
