// The worker of one system: messages in, orbits followed in turns of a few milliseconds, messages out.

import { Orbit } from "./engine.js";
import { Strobed } from "./driven.js";
import { EnergySurface, FlowSection } from "./energy_surface.js";
import { withSteps } from "./equations.js";
import { landscape } from "./landscape.js";
import { MapOrbit } from "./map_orbit.js";
import { bifurcations } from "./bifurcations.js";
import { LinePlane } from "./line_plane.js";
import { MapPlane } from "./map_plane.js";
import { betweenColumns, outlineOf } from "./outline.js";
import { regionOf } from "./region.js";
import { Surface, wrong } from "./sections.js";
import { trialSection } from "./trial_section.js";

const SLICE = 8, BATCH = 64, TOGETHER = 16, EVERY = 16, READ_EVERY = 300, SPEED_EVERY = 500, SPEED_LEAST = 20, WIDTHS = 100;
const BESIDE = 0.2; // of a view, on each side, in which an outline goes on

/** Answer messages of a page for one system; post(message, transfer) answers. */
export class Explorer {
  constructor(system, post) {
    Object.assign(this, { system: withSteps(system), post, orbits: new Map(), queue: [], surface: null, next: 0, steps: 0, spent: 0 });
    this.waiting = false;
  }

  receive(message) {
    try {
      const answer = this[`on_${message.type}`];
      if (answer) answer.call(this, message);
    } catch (problem) {
      this.post({ type: "wrong", what: problem.what ?? "system", message: problem.message, orbit: message.orbit });
    }
  }

  on_system({ system, coordinates, scheme, accuracy, frame }) {
    Object.assign(this, { coordinates: coordinates ?? system.coordinates, momenta: system.momenta, scheme, accuracy, frame });
    this.on_parameters({ parameters: system.parameters });
    this.post({ type: "ready", names: this.coordinates, angles: this.system.angles, parameters: system.parameters });
  }

  on_parameters({ parameters }) {
    this.P = Float64Array.from(this.system.parameters, (name) => {
      const value = parameters?.[name];
      if (!Number.isFinite(value)) throw wrong("parameter", `${name} must be a finite number, got ${value}`);
      if (name === "mu" && this.system.kind === "body" && !(value > 0)) throw wrong("parameter", `mu must be positive, got ${value}`);
      return value;
    });
    this.orbits.clear();
    this.queue = [];
    this.surface = null;
  }

  /** Take a surface that its energy reaches: all orbits go. */
  begin(surface, extent) {
    this.orbits.clear();
    this.queue = [];
    Object.assign(this, { surface, extent });
  }

  on_surface(message) {
    const map = this.mapAt(message.phase ?? 0);
    if (map) return this.showPlane(new (map.line ? LinePlane : MapPlane)(map, this.P, this, message), message);
    if (this.system.kind === "equations" && !this.system.canonical) {
      const found = message.tried ? trialSection(this.system, this.P, this, message) : null;
      return this.showPlane(new FlowSection(this.system, this.P, this, { ...message, ...found }), message, found?.others);
    }
    const general = this.system.kind === "equations", surface = general ? new EnergySurface(this.system, this.P, this, message) : new Surface(this.system, this.P, this.coordinates, message);
    const { width, height } = { width: 200, height: 160, ...message, ...(general && surface.cells < message.width ? { width: surface.cells, height: surface.cells } : {}) };
    const extent = surface.extent(), { minimum, escape } = this.landscapeOf(surface);
    if (!extent) {
      const lowest = minimum === null ? "" : `; the minimum there is ${Number(minimum.toPrecision(8))}`;
      throw wrong("energy", `energy ${surface.energy} reaches no point of the section${lowest}`);
    }
    // An orbit whose energy lets it go has left where it is so many widths of the view away.
    surface.far = minimum === null || (escape !== null && surface.energy > escape) ? WIDTHS*(extent[1] - extent[0]) : Infinity;
    this.begin(surface, extent);
    const allowed = surface.mask(extent, width, height), outline = general ? outlineOf(allowed, extent, width, height, (u, v) => surface.allows(u, v)) : widerOutline(surface, extent, width, height);
    this.post({
      type: "surface", labels: surface.labels, axes: surface.axes, extent, width, height, allowed, outline, minimum, escape, spans: surface.seenSpans ?? [0, 0],
      section: surface.section, constant: surface.constant, energy: surface.energy, asked: message.asked,
    }, [allowed.buffer, outline.buffer]);
    return undefined;
  }

  /** The system as a map, of a driven one that of its states once a period; null where it is none. */
  mapAt(phase) {
    if (!this.system.driven) return this.system.kind === "map" ? this.system : null;
    if (!Number.isFinite(phase)) throw wrong("section", `the phase must be a finite number, got ${phase}`);
    const map = new Strobed(this.system, this.P, this.scheme, this.accuracy, phase);
    if (!(Number.isFinite(map.period) && map.period > 0)) throw wrong("parameter", `the period must be positive, got ${map.period}`);
    return map;
  }

  /** Tell of a plane of a map; open: its domain has no edge in the rectangle, and goes on beside it. */
  showPlane(surface, { width = 200, height = 160, asked }, trial = null) {
    const extent = surface.extent(), allowed = surface.mask(extent, width, height), open = allowed.every((is) => is);
    if (!allowed.some((is) => is)) throw wrong("section", "the plane must contain points of the domain");
    this.begin(surface, extent);
    const outline = open ? null : outlineOf(allowed, extent, width, height, (u, v) => surface.allows(u, v));
    const { labels, axes, section, energy, constant, periods } = surface;
    this.post({
      type: "surface", labels, axes, extent, width, height, allowed, outline, minimum: null, escape: null, section, constant, energy,
      periods, spans: surface.seenSpans ?? periods, open, trial, asked, graph: surface.graph?.(extent) ?? null,
    }, [allowed.buffer]);
  }

  /** The landscape, which is the same for all energies and sections. */
  landscapeOf(surface) {
    const key = [...this.P, surface.p_eta, surface.p_gamma].join();
    if (this.seen?.key !== key) this.seen = { key, ...landscape(surface) };
    return this.seen;
  }

  on_region({ width = 120, height = 120 }) {
    const region = this.surface && this.surface.energy !== null && regionOf(this.surface, this.extent, width, height);
    if (region) this.post({ type: "region", ...region });
  }

  on_bifurcations(message) {
    const found = bifurcations(this.system, this.P, message);
    this.post({ type: "bifurcations", key: message.key, ...(found ?? { from: null, to: null, values: [], points: [] }) });
  }

  on_launch({ orbit, point, z0, crossings = 1000 }) { this.launch(orbit, point, z0, crossings); }

  launch(id, point, z0, crossings) {
    if (!this.surface) throw wrong("point", "there is no section yet");
    const z = z0 ? Float64Array.from(z0) : this.surface.lift(point[0], point[1]);
    if (!z || z.length !== (this.surface.system.rows ?? 2*this.surface.system.n) || !z.every(Number.isFinite)) {
      this.post({ type: "refused", orbit: id, point, message: point ? this.surface.refusal(...point) : "the state is not on the energy surface" });
      return;
    }
    const at = new Float64Array(2), { isMap } = this.surface;
    this.surface.project(z, at, 0);
    const place = point && !isMap ? point : [at[0], at[1]];
    this.orbits.set(id, new (isMap ? MapOrbit : Orbit)(id, place, z, this.surface, { ...this, crossings }));
    this.post({ type: "launched", orbit: id, point: place, z0: z.slice() });
    this.turn();
  }

  on_fill({ columns, rows, view, crossings = 300, first = 0 }) {
    const [u0, u1, v0, v1] = view;
    let id = first;
    for (let j = 0; j < rows; j++) {
      for (let i = 0; i < columns; i++) {
        const u = u0 + (u1 - u0)*(i + 0.5)/columns, v = v0 + (v1 - v0)*(j + 0.5)/rows;
        if (this.surface?.allows(u, v)) this.queue.push({ id: id++, point: [u, v], crossings });
      }
    }
    this.turn();
  }

  on_more({ orbit, crossings }) {
    const known = this.known(orbit);
    known.wanted = known.count + crossings;
    if (known.status === "done" || known.status === "stopped") known.status = "running";
    known.finished = false;
    this.turn();
  }

  on_stop({ orbit = null }) {
    if (orbit === null) this.queue = [];
    for (const one of this.chosen(orbit)) one.end("stopped");
    this.turn();
  }

  on_forget({ orbit = null }) {
    if (orbit === null) { this.orbits.clear(); this.queue = []; } else this.orbits.delete(orbit);
  }

  on_motion({ orbit, from, to, samples }) {
    const states = this.known(orbit).motionBetween(from, to, Math.max(2, Math.min(samples, 20000)));
    const rows = states.length/(this.system.rows ?? 2*this.system.n);
    this.post({ type: "motion", orbit, from, to, rows, states: this.system.kind === "body" ? withPhi(states) : states });
  }

  chosen(orbit) { return orbit === null ? [...this.orbits.values()] : [this.known(orbit)]; }

  known(orbit) {
    const found = this.orbits.get(orbit);
    if (!found) throw wrong("orbit", `there is no orbit ${orbit}`);
    return found;
  }

  /** See to it that a slice comes. */
  turn() {
    if (this.waiting) return;
    this.waiting = true;
    later(() => { this.waiting = false; this.slice(); });
  }

  running() { return [...this.orbits.values()].filter((orbit) => orbit.status === "running"); }

  /** Follow the running orbits for some milliseconds, each a batch of steps in turn, and tell what there is. */
  slice() {
    const end = now() + SLICE;
    let running = this.running();
    while (this.queue.length && running.length < TOGETHER && now() < end) {
      const { id, point, crossings } = this.queue.shift();
      this.receive({ type: "launch", orbit: id, point, crossings });
      running = this.running();
    }
    while (running.some((orbit) => orbit.status === "running") && now() < end) {
      for (let k = 0; k < running.length && now() < end; k++) {
        const orbit = running[this.next++ % running.length], before = orbit.steps, begun = now();
        orbit.run(orbit.batch ?? BATCH);
        this.spent += now() - begun;
        this.steps += orbit.steps - before;
        this.tell(orbit);
      }
    }
    for (const orbit of this.orbits.values()) this.tell(orbit);
    const busy = this.queue.length || this.running().length;
    if (this.spent > (busy ? SPEED_EVERY : SPEED_LEAST)) this.speed();
    if (busy) this.turn();
  }

  /** Tell the steps in a second of following orbits: not of waiting for somebody to click. */
  speed() {
    this.post({ type: "speed", steps_per_second: 1000*this.steps/this.spent });
    this.steps = this.spent = 0;
  }

  /** Send new points of an orbit, at most every 16 ms, and its reading a few times a second and at its end. */
  tell(orbit) {
    if (orbit.finished) return;
    const time = now(), ended = orbit.status !== "running";
    if (orbit.count > orbit.sent && (ended || !(time - orbit.told < EVERY))) {
      const first = orbit.sent, points = orbit.points.array.slice(2*first, 2*orbit.count);
      const times = orbit.times.array.slice(first, orbit.count);
      this.post({ type: "points", orbit: orbit.id, first, points, times }, [points.buffer, times.buffer]);
      orbit.sent = orbit.count;
      orbit.told = time;
    }
    if (ended || !(time - orbit.readAt < READ_EVERY)) {
      this.post({ type: "reading", orbit: orbit.id, ...orbit.reading() });
      orbit.readAt = now();
      orbit.finished = ended;
    }
  }
}

const HALF = Math.SQRT1_2;

/** Rows x, y, z, u of phi in front of the states of a body. */
function withPhi(states) {
  const rows = states.length/8, out = new Float64Array(12*rows);
  for (let k = 0; k < rows; k++) {
    const [a1, a2, b1, b2] = states.subarray(8*k, 8*k + 4);
    out.set([HALF*(a1 + b1), HALF*(b2 - a2), HALF*(a2 + b2), HALF*(a1 - b1)], 12*k);
    out.set(states.subarray(8*k, 8*k + 8), 12*k + 4);
  }
  return out;
}

function now() { return performance.now(); }

const CHANNEL = new MessageChannel(), CALLS = [];
CHANNEL.port1.onmessage = () => CALLS.shift()?.();
CHANNEL.port1.unref?.();

/** Call back after the messages that wait; without the delay of timers. */
function later(call) { CALLS.push(call); CHANNEL.port2.postMessage(0); }

/** Serve messages of the page in a worker. */
export function serve(system) {
  const explorer = new Explorer(system, (message, transfer = []) => self.postMessage(message, transfer));
  self.onmessage = (event) => explorer.receive(event.data);
}

/** The outline of what is allowed in a rectangle and for a part of its size beside it, where an open region goes on. */
function widerOutline(surface, [u0, u1, v0, v1], width, height) {
  const du = (u1 - u0)/width, dv = (v1 - v0)/height, across = Math.ceil(BESIDE*width), along = Math.ceil(BESIDE*height);
  const wide = [u0 - across*du, u1 + across*du, v0 - along*dv, v1 + along*dv], columns = width + 2*across, rows = height + 2*along;
  const top = betweenColumns((u) => surface.top(u), wide, columns);
  return outlineOf(surface.mask(wide, columns, rows), wide, columns, rows, (u, v) => surface.allows(u, v, top(u)));
}
