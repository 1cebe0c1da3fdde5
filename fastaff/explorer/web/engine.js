// Orbits: the package's splitting schemes, steps chosen by trial, crossings, one tangent vector, what is read of them.

import { SectionWatch } from "./crossings.js";
import { curveRotation } from "./curve.js";
import { motionOfEquations } from "./equations.js";
import { fundamentalFrequencies } from "./readings.js";

const TRIAL_SPAN = 16, TRIAL_MOMENTS = 4, MEASURABLE = 3e-12, FIRST_PHASE = 0.25, COARSEST = 1.2, FINEST = 1.5e-3;
const SHARE = 0.25, SAFETY = 0.5, HALVINGS = 3, HORIZON = 64, CHECKED = 16, SAME = 0.1;
const LOOK_STEPS = 64, LOOK_PHASE = 0.2, LOOK_RANGE = [0.08, 0.5], LEAP = 32;
const FARTHEST = 1e6, PATIENCE = 2000, LONGEST = 1e8, LN10 = Math.log(10), CALM_PERIODS = 200, MEGNO_LIMIT = 5;
export const SAMPLED = 4096, KEPT_FOR_ROTATION = 1 << 15;
const WAY_STEPS = 256; // at least, to where an orbit that can leave counts as escaped
const SAMPLE_PHASE = 0.35, ROUNDING_OF_ENERGY = 8*2.220446049250313e-16;

/** The steps of a scheme for a system with parameters P: advance moves a state in place. */
export class Flow {
  constructor(system, P, scheme, h) {
    Object.assign(this, { system, P, scheme, h, n: system.n });
    this.a = scheme.aArray ?? (scheme.aArray = Float64Array.from(scheme.a));
    this.b = scheme.bArray ?? (scheme.bArray = Float64Array.from(scheme.b));
    this.part = new Float64Array(system.n);
  }

  advance(z, tau, count = 1) { this.system.march(z, this.P, this.a, this.b, tau, count); }

  derivative(z, out) {
    if (this.system.rates) { this.system.rates(z, this.P, out); return; }
    this.system.velocity(z, this.P, this.part);
    for (let i = 0; i < this.n; i++) out[i] = this.part[i];
    this.system.force(z, this.P, this.part);
    for (let i = 0; i < this.n; i++) out[this.n + i] = this.part[i];
  }

  energy(z) { return this.system.kinetic(z, this.P) + this.system.potential(z, this.P); }

  with(h) { return new Flow(this.system, this.P, this.scheme, h); }
}

/** The inverse masses W_ii of the coordinates: dv/dp at small momenta. */
function inverseMasses({ system, P, n }) {
  const z = new Float64Array(2*n), v = new Float64Array(n);
  return Array.from({ length: n }, (_, i) => {
    z.fill(0); z[n + i] = 1e-3;
    system.velocity(z, P, v);
    return Math.abs(v[i]/1e-3) || 1;
  });
}

/** What the motion of an orbit is like: natural frequency, amplitudes, largest kinetic energy, escape radius. */
export function motionOf(system, P, scheme, z0) {
  const flow = new Flow(system, P, scheme, 1), n = flow.n;
  if (system.rates) return motionOfEquations(flow, z0);
  const W = inverseMasses(flow), f = new Float64Array(2*n);
  let step = LOOK_PHASE/firstRate(flow, z0, W), rate = 0, kinetic = 0, reach = 0;
  for (let round = 0; round < 14; round++) {
    const z = Float64Array.from(z0);
    let pull = 0, move = 0, failed = false;
    kinetic = reach = 0;
    for (let k = 0; k <= LOOK_STEPS; k++) {
      if (k) flow.advance(z, step);
      flow.derivative(z, f);
      let pulled = 0, moved = 0, far = 0;
      for (let i = 0; i < n; i++) {
        pulled += W[i]*f[n + i]**2; moved += z[n + i]*f[i]; far += z[i]**2;
      }
      const T = system.kinetic(z, P);
      if (!Number.isFinite(pulled + moved + T) || !(system.margin(z, P) > 0)) { failed = true; break; }
      pull += pulled; move += moved; kinetic = Math.max(kinetic, T); reach = Math.max(reach, Math.sqrt(far));
    }
    const now = Math.sqrt(pull/move), moves = Number.isFinite(now) && now > 0;
    if (moves) rate = now;
    const phase = rate*step;
    if (!failed && !moves) break;
    if (!failed && phase >= LOOK_RANGE[0] && phase <= LOOK_RANGE[1]) break;
    step *= failed ? 1/LEAP : Math.min(Math.max(LOOK_PHASE/phase, 1/LEAP), LEAP);
  }
  rate = rate || 1;
  const position = W.map((w) => Math.sqrt(2*kinetic*w)/rate || 1), momentum = W.map((w) => Math.sqrt(2*kinetic/w) || 1);
  return { rate, kinetic, size: Float64Array.from([...position, ...momentum]), W, radius: FARTHEST*(reach || 1) };
}

/** A frequency to begin with: of small oscillations along the force, or of the path. */
function firstRate(flow, z, W) {
  const { n } = flow, f = new Float64Array(2*n), g = new Float64Array(2*n), x = Float64Array.from(z);
  flow.derivative(z, f);
  let size = 0, pull = 0;
  for (let i = 0; i < n; i++) { size += z[i]**2; pull += (W[i]*f[n + i])**2; }
  size = Math.sqrt(size) || 1; pull = Math.sqrt(pull);
  let best = 0;
  for (let kind = 0; kind < 2; kind++) {
    const u = Array.from({ length: n }, (_, i) => (kind ? Math.sqrt(W[i])*(1 + 0.618*i) : W[i]*f[n + i]));
    const length = Math.hypot(...u);
    if (!(length > 0)) continue;
    for (let i = 0; i < n; i++) x[i] = z[i] + 1e-6*size*u[i]/length;
    flow.derivative(x, g);
    let change = 0;
    for (let i = 0; i < n; i++) change += (W[i]*(g[n + i] - f[n + i]))**2;
    const rate = Math.sqrt(Math.sqrt(change)/(1e-6*size));
    if (Number.isFinite(rate)) best = Math.max(best, rate);
  }
  return best > 0 ? best : pull > 0 ? 0.3*Math.sqrt(pull/size) : 1;
}

function distance(z, y, size) {
  let most = 0;
  for (let r = 0; r < z.length; r++) {
    const apart = Math.abs(z[r] - y[r])/size[r];
    if (!(apart <= most)) most = apart;
  }
  return most;
}

/** The step whose local error over a span of the motion is `error`, and the error expected there; as flows/trials.py. */
export function chosenStep(flow, z0, motion, error) {
  const order = flow.scheme.order, { rate, size } = motion, wanted = Math.max(error, MEASURABLE);
  let step = FIRST_PHASE/rate, known = NaN;
  for (let trial = 0; trial < 8; trial++) {
    const apart = halving(flow, z0, step, size, TRIAL_SPAN/rate);
    known = apart;
    const change = Number.isFinite(apart) ? (wanted/Math.max(apart, 1e-14))**(1/order) : 0;
    const next = clip(step*clip(change, 0.25, 3), FINEST/rate, COARSEST/rate);
    if ((change >= 0.6 && change <= 1.6) || next === step) break;
    step = next;
  }
  known = Math.max(Number.isFinite(known) ? known : 1, 1e-14);
  const last = clip(step*clip((error/known)**(1/order), 0.1, 1.6), FINEST/rate, COARSEST/rate);
  return { step: last, local: known*(last/step)**order };
}

function halving(flow, z0, step, size, time) {
  const z = Float64Array.from(z0), y = Float64Array.from(z0), count = Math.max(1, Math.ceil(time/(TRIAL_MOMENTS*step)));
  const h = time/(TRIAL_MOMENTS*count);
  let most = 0;
  for (let k = 0; k < TRIAL_MOMENTS; k++) {
    flow.advance(z, h, count);
    flow.advance(y, h/2, 2*count);
    const apart = distance(z, y, size);
    if (!Number.isFinite(apart)) return k ? most : Infinity;
    most = Math.max(most, apart);
  }
  return most;
}

function clip(x, low, high) { return Math.min(Math.max(x, low), high); }

/** The first crossings of an orbit: times and states, at most so many and up to a time. */
function firstCrossings(flow, surface, z0, count, longest) {
  const watch = new SectionWatch(flow, surface.value, surface.direction, z0), found = [];
  const z = Float64Array.from(z0);
  for (let k = 1; found.length < count && k*flow.h <= longest; k++) {
    flow.advance(z, flow.h);
    if (!Number.isFinite(flow.energy(z)) || !(flow.system.margin(z, flow.P) > 0)) break;
    watch.look(z, k*flow.h, (time, state) => {
      if (time > 0 && surface.counts(state)) found.push({ time, state: Float64Array.from(state) });
    });
  }
  return found.slice(0, count);
}

/** A step for which the first crossings have the accuracy, and the error that a run with twice the step shows. */
export function stepFor(system, P, scheme, surface, z0, accuracy) {
  const motion = motionOf(system, P, scheme, z0), flow = new Flow(system, P, scheme, 1), { rate, size } = motion;
  const period = 2*Math.PI/rate, spans = Math.max(2*HORIZON*2*Math.PI/TRIAL_SPAN, 1);
  let { step, local } = chosenStep(flow, z0, motion, SHARE*accuracy/spans);
  const part = SAFETY*scheme.order/(2**scheme.order - 1), longest = 4*CHECKED*period;
  let coarse = firstCrossings(flow.with(2*step), surface, z0, CHECKED, longest), fine, error, count;
  for (let round = 0; ; round++) {
    fine = firstCrossings(flow.with(step), surface, z0, CHECKED, longest);
    error = 0; count = 0;
    for (; count < Math.min(fine.length, coarse.length); count++) {
      const apart = Math.max(distance(fine[count].state, coarse[count].state, size),
        Math.abs(fine[count].time - coarse[count].time)*rate);
      if (!(apart < SAME)) break;
      error = Math.max(error, part*apart);
    }
    error = Math.max(error, local);
    if (error <= accuracy || error > accuracy*2**scheme.order || round >= HALVINGS || step*rate <= FINEST) break;
    coarse = fine; step /= 2; local /= 2**scheme.order;
  }
  return { step, motion, error: { value: error, crossings: count } };
}

/** One tangent vector: MEGNO, the largest Lyapunov exponent and what they say; as chaos_map of the package. */
export class Tangent {
  constructor(flow, motion, start, stride = 2**Math.floor(Math.log2(clip(1/(motion.rate*flow.h), 1, 2**40)))) {
    const { n } = flow, own = motion.W.map((w) => Math.sqrt(motion.rate/w));
    this.scale = motion.scale ?? Float64Array.from([...own, ...own.map((s) => 1/s)]);
    this.u = this.scale.map((s, r) => start[r]/s);
    this.rate = motion.rate;
    this.stride = this.left = stride;
    this.length = this.last = this.weighted = this.area = this.megno = 0;
    this.history = [];
    this.normalise();
    this.length = 0;
  }

  square() {
    let square = 0;
    for (let r = 0; r < this.u.length; r++) square += (this.scale[r]*this.u[r])**2;
    return square;
  }

  normalise() {
    const length = Math.sqrt(this.square());
    for (let r = 0; r < this.u.length; r++) this.u[r] /= length;
    return Math.log(length);
  }

  /** Look at the vector at time t, a step later. */
  look(t) {
    if (--this.left > 0 && (this.left & 7 || this.square() < LONGEST)) return;
    this.left = this.stride;
    this.renew(t);
  }

  /** Make its length 1 again, and keep what it has grown by since it last was. */
  renew(t) {
    if (!(t > this.last)) return;
    if (this.square() === 0) this.isLost = true; // on a superstable cycle, whose exponent is minus infinity
    if (this.isLost) return;
    const gained = this.normalise(), { last } = this;
    this.length += gained;
    this.weighted += 0.5*(last + t)*gained;
    const megno = 2*this.weighted/t;
    this.area += 0.5*(megno + this.megno)*(t - last);
    this.megno = megno; this.last = t;
    const kept = this.history[this.history.length - 1];
    if (!kept || t >= 1.02*kept.time) this.history.push({ time: t, megno: this.area/t, decades: this.length/LN10 });
  }

  /** MEGNO's mean, the exponent, and the classification of both together: as the package's, but regular no sooner than after
   * CALM_PERIODS, since nearly half of the orbits that look regular after 20 turn out to be chaotic. */
  reading() {
    const t = this.last;
    if (this.isLost) return { megno: null, lyapunov: null, classification: "regular" };
    if (!(t > 0)) return { megno: null, lyapunov: null, classification: "undecided" };
    const now = { megno: this.area/t, decades: this.length/LN10 };
    let before = null;
    for (const entry of this.history) if (entry.time <= 0.5*t*(1 + 1e-12)) before = entry;
    const phase = this.rate*t, long = phase >= 2*Math.PI*CALM_PERIODS;
    const classifications = before ? [
      judged(now.megno > MEGNO_LIMIT, now.megno < 2.5 || now.megno < 0.95*before.megno, long),
      judged(now.decades > 4 + Math.log10(Math.max(phase, 10)), now.decades - before.decades < Math.log10(2) + 0.75, long),
    ] : [];
    const chaotic = classifications.includes("chaotic"), regular = classifications.includes("regular");
    const classification = chaotic === regular ? "undecided" : chaotic ? "chaotic" : "regular";
    return { megno: now.megno, lyapunov: this.length/t, classification };
  }
}

function judged(beyond, calm, long) {
  return beyond && !calm ? "chaotic" : calm && !beyond && long ? "regular" : "undecided";
}

function lengthOf(z, n) { return Math.hypot(...z.subarray(0, n)); }

/** The time in which a start runs through a share of the way to where it counts as escaped. */
function shareOfWay(flow, z0, far) {
  const f = new Float64Array(z0.length);
  flow.derivative(z0, f);
  return far/(WAY_STEPS*lengthOf(f, flow.n)) || Infinity;
}

/** Numbers that grow in number. */
export class Numbers {
  constructor() { this.array = new Float64Array(1024); this.length = 0; }

  push(...values) {
    if (this.length + values.length > this.array.length) {
      const larger = new Float64Array(2*this.array.length);
      larger.set(this.array);
      this.array = larger;
    }
    for (const value of values) this.array[this.length++] = value;
  }

  view(first = 0, last = this.length) { return this.array.subarray(first, last); }
}

/** An orbit that is followed slice by slice. */
export class Orbit {
  constructor(id, point, z0, surface, { system, P, scheme, accuracy, frame, crossings }) {
    Object.assign(this, { id, point, z0, surface, system, P, wanted: crossings });
    const chosen = stepFor(system, P, scheme, surface, z0, accuracy), far = surface.far ?? Infinity;
    chosen.motion.radius = Math.min(chosen.motion.radius, Math.max(far, 2*lengthOf(z0, system.n)));
    chosen.step = Math.min(chosen.step, shareOfWay(new Flow(system, P, scheme, 1), z0, far));
    this.motion = chosen.motion; this.error = chosen.error;
    this.flow = new Flow(system, P, scheme, chosen.step);
    this.z = Float64Array.from(z0);
    this.watch = new SectionWatch(this.flow, surface.value, surface.direction, z0);
    this.tangent = system.hasTangent ? new Tangent(this.flow, this.motion, frame) : null;
    this.steps = 0; this.points = new Numbers(); this.times = new Numbers(); this.sent = 0;
    this.startEnergy = this.flow.energy(z0); this.energyError = 0; this.largest = this.motion.kinetic || 1;
    this.status = "running"; this.lastCrossing = 0;
    this.every = Math.max(1, Math.floor(SAMPLE_PHASE/(this.motion.rate*chosen.step)));
    this.samples = new Numbers(); this.signal = new Float64Array(4*system.angles.length);
    this.pair = new Float64Array(2);
    this.patience = PATIENCE*2*Math.PI/this.motion.rate;
    this.sample();
  }

  get count() { return this.times.length; }

  get time() { return this.steps*this.flow.h; }

  sample() {
    if (this.samples.length >= SAMPLED*this.signal.length) return;
    this.system.signals(this.z, this.P, this.signal);
    this.samples.push(...this.signal);
  }

  /** Follow the orbit for some steps. */
  run(steps) {
    const { flow, system, P, z, tangent, watch } = this, { a, b, h } = flow, found = (t, state) => this.crossed(t, state);
    for (let k = 0; k < steps && this.status === "running"; k++) {
      if (tangent) system.marchTangent(z, tangent.u, P, a, b, h, 1); else system.march(z, P, a, b, h, 1);
      this.steps++;
      const t = this.steps*h;
      if (!(system.margin(z, P) > 0)) { this.end(z.every(Number.isFinite) ? "out of domain" : "escaped"); break; }
      watch.look(z, t, found);
      if (tangent) tangent.look(t);
      if (this.steps % this.every === 0) this.sample();
      if ((this.steps & 15) === 0) this.check(t);
    }
  }

  /** End an orbit that has gone away. */
  check(t) {
    let square = 0;
    for (let i = 0; i < this.flow.n; i++) square += this.z[i]**2;
    if (!(square < this.motion.radius**2)) this.end("escaped");
    else if (t - this.lastCrossing > this.patience) this.end("no more crossings");
  }

  end(status) { if (this.status === "running") this.status = status; }

  crossed(time, state) {
    if (!(time > 0) || this.status !== "running" || !this.surface.counts(state)) return;
    this.surface.project(state, this.pair, 0);
    if (!Number.isFinite(this.pair[0] + this.pair[1])) { this.end("escaped"); return; }
    const T = this.system.kinetic(state, this.P), V = this.system.potential(state, this.P);
    this.largest = Math.max(this.largest, T);
    const rounding = ROUNDING_OF_ENERGY*(T + Math.abs(V) + Math.abs(this.startEnergy));
    this.energyError = Math.max(this.energyError, Math.abs(T + V - this.startEnergy) - rounding);
    this.points.push(this.pair[0], this.pair[1]);
    this.times.push(time);
    this.lastCrossing = time;
    if (this.count >= this.wanted) this.end("done");
  }

  /** What is known of the orbit by now. */
  reading() {
    const own = this.tangent?.reading() ?? { megno: null, lyapunov: null, classification: "undecided" };
    if (!this.count || this.status === "escaped" || this.status === "out of domain") own.classification = "undecided"; // tangent vectors grow on the way out
    const kept = Math.min(this.count, KEPT_FOR_ROTATION);
    if (!(kept < 1.2*(this.read ?? 0)) || this.status !== "running") {
      if (kept !== this.read) this.rotation = own.classification === "chaotic" ? null : curveRotation(this.points.view(0, 2*kept));
      this.frequencies = this.lines();
      this.read = kept;
    }
    return {
      crossings: this.count, time: this.time, rotation: this.rotation ?? null, ...own,
      energy_error: this.surface.energy === null ? null : this.energyError/this.largest, frequencies: this.frequencies ?? null, status: this.status,
      step: this.flow.h, error: this.error, quiet: (this.time - this.lastCrossing)*this.motion.rate/(2*Math.PI),
    };
  }

  lines() {
    const width = this.signal.length, rows = 2**Math.floor(Math.log2(this.samples.length/width));
    if (!width || rows === this.sampled) return this.frequencies;
    this.sampled = rows;
    return fundamentalFrequencies(this.samples.view(), width, this.every*this.flow.h, this.system.angles);
  }

  /** States at equal times from a run of its own: rows of them. */
  motionBetween(from, to, rows) {
    const z = Float64Array.from(this.z0), out = new Float64Array(rows*z.length), { h } = this.flow;
    let at = 0;
    for (let k = 0; k < rows; k++) {
      const t = rows > 1 ? from + (to - from)*k/(rows - 1) : from, whole = Math.floor(t/h + 1e-9);
      if (whole > at) { this.flow.advance(z, h, whole - at); at = whole; }
      const y = Float64Array.from(z);
      if (t - at*h > 1e-9*h) this.flow.advance(y, t - at*h);
      out.set(y, k*z.length);
    }
    return out;
  }
}
