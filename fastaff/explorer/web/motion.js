// The motion of the chosen orbit in time: windows of states asked of the backend, and a clock that plays them.

const SAMPLES = 2400; // states of a window
const CROSSINGS = 30; // crossings that a window lasts, about

export function makeMotion(send) {
  return { send, orbit: null, windows: [], asked: null, time: 0, playing: false, speed: 1, last: null, span: null };
}

// Follow another orbit, from its beginning; null for none.
export function followOrbit(motion, orbit) {
  Object.assign(motion, { orbit: orbit?.number ?? null, windows: [], asked: null, time: 0, span: null });
}

// Ask for the window after those there are, once the orbit's pace is known.
export function askMotion(motion, orbit) {
  if (!orbit || motion.asked !== null || motion.orbit !== orbit.number) return;
  const { crossings, time } = orbit.reading;
  if (motion.span === null) {
    if (!(crossings >= 5) && orbit.reading.status === "running") return;
    if (!(time > 0)) return;
    motion.span = Math.min(time, (time / Math.max(1, crossings)) * CROSSINGS);
  }
  const from = motion.windows.length ? motion.windows.at(-1).to : 0;
  if (motion.windows.length && motion.time < from - 0.5 * motion.span) return;
  motion.asked = from;
  motion.send({ type: "motion", orbit: orbit.number, from, to: from + motion.span, samples: SAMPLES });
}

// Take a window; true if it was wanted.
export function takeMotion(motion, message) {
  if (message.orbit !== motion.orbit || motion.asked === null || message.from !== motion.asked) return false;
  const samples = message.rows, rows = message.states.length / samples;
  motion.asked = null;
  if (samples < 2) return false;
  motion.windows.push({ from: message.from, to: message.to, rows, states: message.states, samples });
  if (motion.windows.length > 2) motion.windows.shift();
  motion.time = Math.max(motion.time, motion.windows[0].from);
  return true;
}

// Move the clock; true while it runs.
export function tickMotion(motion, now) {
  const past = motion.last === null ? 0 : Math.min(0.1, (now - motion.last) / 1000);
  motion.last = motion.playing ? now : null;
  if (!motion.playing || !motion.windows.length) return motion.playing;
  motion.time = Math.min(motion.time + past * motion.speed, motion.windows.at(-1).to);
  return true;
}

// The state at the clock's time, linear between samples; null where there is none.
export function stateNow(motion) {
  const part = motion.windows.find((entry) => motion.time <= entry.to) ?? motion.windows.at(-1);
  if (!part) return null;
  const place = Math.max(0, Math.min(part.samples - 1.000001, ((motion.time - part.from) / (part.to - part.from)) * (part.samples - 1)));
  const i = Math.floor(place), share = place - i;
  return Array.from({ length: part.rows }, (_, k) => part.states[i * part.rows + k] * (1 - share) + part.states[(i + 1) * part.rows + k] * share);
}

// alpha and beta of a configuration phi = [[x, y], [z, u]]: (D1 + D2)/sqrt 2 and (D1 - D2)/sqrt 2 of its singular values.
export function alphaBeta(x, y, z, u) {
  return [Math.hypot(x + u, z - y) / Math.SQRT2, Math.hypot(x - u, y + z) / Math.SQRT2];
}
