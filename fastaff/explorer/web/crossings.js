// Crossings of a section: found at full steps, located on the scheme's own flow. As kernels/crossings.py, for one orbit.

const FINE = 2.5e-16, NOISE = 1e-12, SWEEPS = 100, BARELY = 5e-324, START = 8*2.220446049250313e-16, NUDGE = 1e-6;

/** Whether a parabola through three values of one sign may reach zero beside the middle one. */
function dips(earlier, before, now, first, second) {
  const nearest = Math.abs(before) < Math.abs(now) && Math.abs(before) <= Math.abs(earlier);
  if (!(nearest && before*now > 0 && before*earlier > 0)) return false;
  const bend = 2*((now - before)/second - (before - earlier)/first)/(first + second);
  return 4*Math.abs(before) <= Math.abs(bend)*Math.max(first, second)**2;
}

/** The next fraction of a bracket: inverse quadratic interpolation where it is safe. Chandrupatla 1997. */
function chandrupatla(x1, f1, x2, f2, x3, f3) {
  const xi = (x1 - x2)/(x3 - x2), phi = (f1 - f2)/(f3 - f2);
  if (phi*phi < xi && (1 - phi)*(1 - phi) < 1 - xi) {
    return f1/(f2 - f1)*f3/(f2 - f3) + (x3 - x1)/(x2 - x1)*f1/(f3 - f1)*f2/(f3 - f2);
  }
  return 0.5;
}

/** Looks at the section after every step of one orbit. flow: {h, advance(z, tau), derivative(z, out)}. */
export class SectionWatch {
  constructor(flow, value, direction, z0) {
    this.flow = flow; this.value = value; this.direction = direction;
    this.state = Float64Array.from(z0); this.work = new Float64Array(z0.length); this.at = new Float64Array(z0.length);
    this.time = 0; this.timeBefore = -flow.h;
    this.before = this.startValue(z0);
    this.work.set(z0); flow.advance(this.work, -flow.h);
    this.earlier = value(this.work);
  }

  /** The section function at the start; where that is on the section, only the sign that it has just after. */
  startValue(z) {
    const { flow, value, work } = this, now = value(z), slope = new Float64Array(z.length);
    flow.derivative(z, slope);
    for (let r = 0; r < z.length; r++) work[r] = z[r] + NUDGE*flow.h*slope[r];
    const change = (value(work) - now)/NUDGE;
    let size = Math.abs(change);
    for (let r = 0; r < z.length; r++) {
      work.set(z); work[r] = z[r]*(1 + NUDGE);
      size += Math.abs(value(work) - now)/NUDGE;
    }
    if (!(Math.abs(now) <= START*size)) return now;
    return Math.abs(change) > 1e-9*size ? BARELY*Math.sign(change) : 0;
  }

  /** Look at the state z at time t, a step later; hand each crossing of that step to found(time, state). */
  look(z, t, found) {
    const now = this.value(z), { before, earlier, direction } = this;
    const rises = before < 0 && now >= 0, falls = before > 0 && now <= 0;
    if ((rises && direction >= 0) || (falls && direction <= 0)) {
      if (Math.abs(before) === BARELY) this.returned(t - this.time, found);
      else this.root(0, before, t - this.time, now, found);
    } else if (dips(earlier, before, now, this.time - this.timeBefore, t - this.time)) {
      this.pair(this.timeBefore - this.time, t - this.time, found);
    }
    this.earlier = before; this.before = now;
    this.timeBefore = this.time; this.time = t;
    this.state.set(z);
  }

  /** The section function a fractional step after the last state; that state is left in `at`. */
  after(tau) {
    this.at.set(this.state);
    this.flow.advance(this.at, tau);
    return this.value(this.at);
  }

  /** Crossings of a suspected pair between the times low and high: split at the extremum, then both. */
  pair(low, high, found) {
    const begin = low, end = high;
    let inner = 0, value = this.after(0);
    for (let k = 0; k < 60; k++) {
      const tau = inner + 0.3819660112501051*((high - inner > inner - low ? high : low) - inner), f = this.after(tau);
      if (value*f < 0) { inner = tau; value = f; break; }
      if (Math.abs(f) < Math.abs(value)) {
        if (tau > inner) low = inner; else high = inner;
        inner = tau; value = f;
      } else if (tau > inner) high = tau; else low = tau;
    }
    for (const [x1, x2] of [[begin, inner], [inner, end]]) this.between(x1, x2, found);
  }

  /** The crossing between two times, if there is one the right way. */
  between(x1, x2, found) {
    const f1 = this.after(x1), f2 = this.after(x2);
    if (f1*f2 > 0 || (f2 - f1)*this.direction < 0) return;
    this.root(x1, f1, x2, f2, found);
  }

  /** The crossing of a first step that began on the section: from where the function has left it. */
  returned(x2, found) {
    const last = this.after(x2);
    let tau = x2;
    for (let k = 0; k < 90; k++) {
      tau *= 0.7;
      if (this.after(tau)*last < 0) return this.between(tau, x2, found);
    }
  }

  /** Find the root between x1 and x2 and hand over its time and state. */
  root(x1, f1, x2, f2, found) {
    const whole = Math.abs(x2 - x1);
    let x3 = x1, f3 = f1, last = Infinity, tau, f;
    if (!(f1*f2 < 0)) {
      tau = Math.abs(f1) <= Math.abs(f2) ? x1 : x2;
      this.after(tau);
      return found(this.time + tau, this.at);
    }
    tau = x1 + (x2 - x1)*(f1/(f1 - f2));
    for (let sweep = 1; ; sweep++) {
      f = this.after(tau);
      if ((f > 0) === (f1 > 0)) { x3 = x1; f3 = f1; } else { x3 = x2; f3 = f2; x2 = x1; f2 = f1; }
      x1 = tau; f1 = f;
      const width = Math.abs(x2 - x1), fraction = chandrupatla(x1, f1, x2, f2, x3, f3);
      const change = Math.abs(f1/(f2 - f1))*width;
      const settled = change <= FINE*whole || (change <= NOISE*whole && Math.abs(f) > 0.5*last);
      last = Math.abs(f);
      if (settled || width <= 2.4e-16*whole || sweep >= SWEEPS) {
        if (!(Math.abs(f1) <= Math.min(Math.abs(f2), Math.abs(f3)))) {
          tau = Math.abs(f2) <= Math.abs(f3) ? x2 : x3;
          this.after(tau);
        }
        return found(this.time + tau, this.at);
      }
      const least = 1.2e-16*whole/width;
      tau = x1 + Math.min(Math.max(fraction, least), 1 - least)*(x2 - x1);
    }
  }
}
