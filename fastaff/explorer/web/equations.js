// Systems dz/dt = f(z), as H(q, p) and equations of motion, stepped by Gauss's collocation; what their motion is like.

const STAGE_SWEEPS = 64, CARRIED = 1e-13, FIRST_LOOKS = 64, FIRST_LOOK = 0.2, LOOK_BETWEEN = [0.08, 0.5], LOOK_ROUNDS = 14, LOOK_LEAP = 32, AWAY = 1e6, WORK_PANELS = 16;

/** Give a system of rates the functions that the engine asks of all systems. */
export function withSteps(system) {
  if (system.kind !== "equations") return system;
  const { rows, n, canonical } = system, f = new Float64Array(rows), g = new Float64Array(rows), e = new Float64Array(rows), work = new Map();
  const stages = (s) => {
    if (!work.has(s)) work.set(s, Array.from({ length: 3 }, () => new Float64Array(s*rows)));
    return work.get(s);
  };
  const half = (z, P) => {
    if (!canonical) return 0;
    system.rates(z, P, g);
    let sum = 0;
    for (let i = 0; i < n; i++) sum += z[n + i]*g[i];
    return Math.abs(sum)/2;
  };
  return Object.assign(system, system.driven ? atRest(system) : {
    kinetic: half,
    potential: (z, P) => (canonical ? system.energy(z, P) - half(z, P) : 0*z.reduce((sum, x) => sum + x)),
    velocity(z, P, out) { system.rates(z, P, g); for (let i = 0; i < n; i++) out[i] = g[i]; },
    force(z, P, out) { system.rates(z, P, g); for (let i = 0; n + i < rows; i++) out[i] = g[n + i]; },
  }, {
    march(z, P, a, b, h, count) { for (let k = 0; k < count; k++) collocate(system, z, null, P, a, b, h, f, stages(b.length)); },
    marchTangent(z, u, P, a, b, h, count) { for (let k = 0; k < count; k++) collocate(system, z, u, P, a, b, h, f, stages(b.length)); },
    /** The derivative (rows) of the rates by one row of z. */
    column(z, r, P, out) { e.fill(0); e[r] = 1; system.tangentRates(z, e, P, out); },
    signals(z, P, out) {
      const spans = system.periods(P);
      for (let i = 0; i < system.angles.length; i++) {
        out.fill(0, 4*i, 4*i + 4);
        if (spans[i]) out[4*i] = Math.sin(2*Math.PI*z[i]/spans[i]);
        else { out[4*i] = z[i]; out[4*i + 2] = z[n + i]; }
      }
    },
  });
}

/** Of a driven system of rows x, t, p what its first view is made of: force and inverse mass at p = 0, and the force's work. */
function atRest(system) {
  const at = new Float64Array(4), f = new Float64Array(4);
  const set = (z) => { at.set(z); at[2] = 0; return at; };
  const pull = (z, P) => { system.rates(set(z), P, f); return f[2]; };
  return {
    force(z, P, out) { out[0] = pull(z, P); },
    tangent(z, P, out) { system.column(set(z), 0, P, f); out[0] = f[2]; },
    velocity(z, P, out) { system.column(set(z), 2, P, f); out[0] = f[0]; },
    potential(z, P) {
      let sum = 0;
      for (let k = 0; k < WORK_PANELS; k++) sum -= pull([(k + 0.5)/WORK_PANELS*z[0], z[1], 0, 0], P)*z[0]/WORK_PANELS;
      return sum;
    },
  };
}

/** One step: Y_i = z + sum m_ij L_j, L_i = h b_i f(Y_i), to rounding; and of a tangent vector u, where there is one. */
function collocate(system, z, u, P, m, b, h, f, [L, Y, K]) {
  const rows = z.length, s = b.length;
  system.rates(z, P, f);
  for (let i = 0; i < s; i++) for (let r = 0; r < rows; r++) L[i*rows + r] = h*b[i]*f[r];
  for (let sweep = 0, last = Infinity; sweep < STAGE_SWEEPS; sweep++) {
    let change = 0;
    for (let i = 0; i < s; i++) {
      const at = i*rows, y = Y.subarray(at, at + rows);
      for (let r = 0; r < rows; r++) {
        let sum = z[r];
        for (let j = 0; j < s; j++) sum += m[i*s + j]*L[j*rows + r];
        y[r] = sum;
      }
      system.rates(y, P, f);
      for (let r = 0; r < rows; r++) {
        const next = h*b[i]*f[r], apart = Math.abs(next - L[at + r])/(Math.abs(z[r]) + Math.abs(next) + 1e-300);
        if (!(apart <= change)) change = apart;
        L[at + r] = next;
      }
    }
    if (!(change < last) && (change < 1e-12 || !(change < 1e3))) break;
    if (change < 1e-16) break;
    last = change;
  }
  if (u) carried(system, u, P, m, b, h, f, Y, K);
  for (let i = 0; i < s; i++) for (let r = 0; r < rows; r++) z[r] += L[i*rows + r];
}

/** The tangent vector through the stages of a step. */
function carried(system, u, P, m, b, h, f, Y, K) {
  const rows = u.length, s = b.length, w = new Float64Array(rows);
  K.fill(0);
  for (let sweep = 0; sweep < STAGE_SWEEPS; sweep++) {
    let change = 0, size = 0;
    for (let i = 0; i < s; i++) {
      const at = i*rows;
      for (let r = 0; r < rows; r++) {
        w[r] = u[r];
        for (let j = 0; j < s; j++) w[r] += m[i*s + j]*K[j*rows + r];
      }
      system.tangentRates(Y.subarray(at, at + rows), w, P, f);
      for (let r = 0; r < rows; r++) {
        const next = h*b[i]*f[r];
        change = Math.max(change, Math.abs(next - K[at + r])); size = Math.max(size, Math.abs(next), Math.abs(u[r]));
        K[at + r] = next;
      }
    }
    if (!(change > CARRIED*size)) break;
  }
  for (let i = 0; i < s; i++) for (let r = 0; r < rows; r++) u[r] += K[i*rows + r];
}

/** The scales of an orbit, as motionOf has them; of a flow its own turning and the extent of what is seen of it. */
export function motionOfEquations(flow, z0) {
  const { system, P, scheme } = flow, { rows, n, canonical } = system, f = new Float64Array(rows), df = new Float64Array(rows);
  const W = Array.from({ length: n }, (_, i) => {
    if (!canonical) return 1;
    system.column(z0, n + i, P, df);
    return Math.abs(df[i]) || 1;
  });
  let rate = 1, step = FIRST_LOOK, kinetic = 0, low, high, failed;
  system.rates(z0, P, f); system.tangentRates(z0, f, P, df);
  if (Math.hypot(...df) > 0 && Math.hypot(...f) > 0) step = FIRST_LOOK*Math.hypot(...f)/Math.hypot(...df);
  for (let round = 0; round < LOOK_ROUNDS; round++) {
    const z = Float64Array.from(z0);
    let pulled = 0, moved = 0;
    kinetic = 0; failed = false; low = z.slice(); high = z.slice();
    for (let k = 0; k <= FIRST_LOOKS && !failed; k++) {
      if (k) flow.advance(z, step);
      system.rates(z, P, f); system.tangentRates(z, f, P, df);
      if (canonical) {
        let T = 0;
        for (let i = 0; i < n; i++) { T += z[n + i]*f[i]; pulled += (f[n + i]*df[i] - f[i]*df[n + i])/2; }
        moved += T; kinetic = Math.max(kinetic, Math.abs(T)/2);
      } else {
        const speed = f.reduce((sum, x) => sum + x*x, 0);
        pulled += df.reduce((sum, x) => sum + x*x, 0); moved += speed;
      }
      for (let r = 0; r < rows; r++) { low[r] = Math.min(low[r], z[r]); high[r] = Math.max(high[r], z[r]); }
      failed = !Number.isFinite(pulled + moved) || !(system.margin(z, P) > 0);
    }
    const now = Math.sqrt(Math.abs(pulled/moved));
    if (Number.isFinite(now) && now > 0) rate = now;
    const phase = rate*step;
    if (!failed && phase >= LOOK_BETWEEN[0] && phase <= LOOK_BETWEEN[1]) break;
    step *= failed ? 1/LOOK_LEAP : Math.min(Math.max(FIRST_LOOK/phase, 1/LOOK_LEAP), LOOK_LEAP);
  }
  const seen = Float64Array.from(low, (x, r) => (high[r] - x)/2 || Math.abs(x) || 1), spans = system.periods(P);
  for (let i = 0; canonical && i < n; i++) if (spans[i]) rate = Math.max(rate, Math.PI/8*(high[i] - low[i])/(FIRST_LOOKS*step*spans[i]));
  const size = canonical ? [...W.map((w) => Math.sqrt(2*kinetic*w)/rate || 1), ...W.map((w) => Math.sqrt(2*kinetic/w) || 1)] : seen;
  const reach = Math.hypot(...low.map((x, r) => (spans[r] || (canonical && r >= n) ? 0 : Math.max(Math.abs(x), Math.abs(high[r]))))) || Math.max(...spans, 1);
  return { rate, kinetic, size: Float64Array.from(size), W, radius: AWAY*reach, scale: canonical ? null : seen };
}
