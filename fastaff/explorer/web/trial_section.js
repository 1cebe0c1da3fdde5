// The section of a typed flow: one that a trial orbit crosses where it stays.

import { Flow } from "./engine.js";

const TRIAL_STEPS = 3000, TRIAL_PACE = 0.1, FIRST_ROWS = [0.3, 0.7], LEAST_CROSSINGS = 8, BESIDE_ZERO = 0.1, DIGITS = 2;

/**
 * {section, constant, others} of a flow dz/dt = f(z): of its variables from the last one on, the first whose middle, or 0
 * where that is nearly 0, a trial orbit crosses; others: where it does. null where the orbit ends or crosses none.
 */
export function trialSection(system, P, { coordinates, scheme }, { direction = 1 }) {
  const states = trialOrbit(system, P, scheme);
  for (let row = coordinates.length - 1; row >= 0 && states.length; row--) {
    const values = states.map((z) => z[row]), sorted = Float64Array.from(values).sort(), middle = sorted[sorted.length >> 1];
    const isOff = Math.abs(middle) > BESIDE_ZERO*(sorted.at(-1) - sorted[0]), constant = isOff ? Number(middle.toPrecision(DIGITS)) : 0;
    const side = (k) => (values[k] - constant)*(direction || 1), crossed = [];
    for (let k = 1; k < values.length; k++) if (side(k - 1) <= 0 && side(k) > 0) crossed.push(k);
    if (crossed.length < LEAST_CROSSINGS) continue;
    const own = states[crossed.at(-1)], beside = coordinates.map((name, r) => [name, r]).filter(([, r]) => r !== row).slice(2);
    return { section: coordinates[row] + "=c", constant, others: Object.fromEntries(beside.map(([name, r]) => [name, Number(own[r].toPrecision(DIGITS))])) };
  }
  return null;
}

/** States of the second half of a trial orbit, in steps of a tenth of the time in which the velocity turns; [] where it ends. */
function trialOrbit(system, P, scheme) {
  const { rows } = system, z = Float64Array.from({ length: rows }, (_, r) => FIRST_ROWS[0] + (FIRST_ROWS[1] - FIRST_ROWS[0])*r/(rows - 1));
  const flow = new Flow(system, P, scheme, 1), f = new Float64Array(rows), turned = new Float64Array(rows), found = [];
  for (let k = 0; k < TRIAL_STEPS; k++) {
    system.rates(z, P, f);
    system.tangentRates(z, f, P, turned);
    flow.advance(z, TRIAL_PACE*Math.hypot(...f)/Math.hypot(...turned));
    if (!z.every(Number.isFinite) || !(system.margin(z, P) > 0)) return [];
    if (2*k >= TRIAL_STEPS) found.push(Float64Array.from(z));
  }
  return found;
}
