// What the backend answers, and what the page makes of it.

import { askFrame } from "./drawing.js";
import { takeMotion } from "./motion.js";
import { addPoints, hasLeft, knownOrbit, newOrbit, showOrbit } from "./orbits.js";
import { WRITTEN, rangeEnergy, showConstant, showOthers, showWrong } from "./panel.js";
import { takeBifurcations } from "./view_bifurcations.js";
import { queueDensity } from "./view_density.js";
import { takeRegion } from "./view_configuration.js";
import { frequencyAxes } from "./view_frequency.js";
import { appendPoints } from "./view_points.js";
import { showsDensity, takeSurface } from "./view_section.js";
import { fillList } from "./controls.js";
import { systemOf } from "./state.js";
import { greek } from "./text.js";

const MOST = 2e7; // points kept
const REGION_GRID = 160; // cells of the configuration region, each way

const ANSWERS = {
  ready: takeReadyMessage,
  parsed: takeParsedMessage,
  surface: takeSurfaceMessage,
  region: takeRegionMessage,
  launched: takeLaunchedMessage,
  refused: takeRefusedMessage,
  points: takePointsMessage,
  reading: takeReadingMessage,
  motion: takeMotionMessage,
  bifurcations: takeBifurcationsMessage,
  speed: takeSpeedMessage,
  wrong: takeWrongMessage,
};

export function receive(app, message) {
  if (message && Object.hasOwn(ANSWERS, message.type)) ANSWERS[message.type](app, message);
}

function takeReadyMessage(app) {
  app.ready = true;
  showUnread(app, false);
  for (const what of ["formula", "periodic"]) showWrong(app.panel, what, null);
  app.actions.askSurface();
}

function takeParsedMessage(app, message) {
  if (app.panel.typing || WRITTEN.some((name) => message[name] !== app.state[name])) return; // the answer to an older text
  if (message.message) {
    app.actions.closeSurface();
    showUnread(app, true);
    for (const what of ["formula", "periodic"]) showWrong(app.panel, what, what === (message.what ?? "formula") ? sentence(message.message) : null);
  } else app.actions.takeParsed(message.names);
}

// Whether what is typed is no formula: the plot is greyed out.
function showUnread(app, is) {
  app.root.toggleAttribute("data-unread", is);
  app.part("unread").hidden = !is;
}

function takeSurfaceMessage(app, message) {
  const { state, section } = app;
  if (message.asked !== undefined && message.asked !== app.asked) return; // of an older question
  app.surfaceLost = message.energy !== state.energy; // of an older question, whose orbits went with it
  if (app.surfaceLost) return;
  showWrong(app.panel, "energy", null);
  showWrong(app.panel, "section", null);
  if (state.tried && message.trial) { // the section that a trial orbit meets
    Object.assign(state, { section: message.section, constant: message.constant, others: { ...state.others, ...message.trial } });
    showConstant(app.panel, state);
    showOthers(app.panel, state, systemOf(app.setup, state));
  }
  const key = [state.system, message.axes].join(), isMap = systemOf(app.setup, state).kind === "map";
  message.labels = message.labels.map(greek);
  takeSurface(section, message, app.keepView && key === app.surfaceFor && section.past.length > 0);
  app.keepView = true;
  app.surfaceFor = key;
  if (state.view) {
    section.frame.view = [...state.view];
    state.view = null;
  }
  rangeEnergy(app.panel, state, message);
  const axes = frequencyAxes(message.labels, systemOf(app.setup, state));
  const chosen = axes.some(([name]) => name === app.frequency.axes) ? app.frequency.axes : "first";
  app.frequency.axes = chosen;
  fillList(app.part("frequency-axes"), axes, chosen);
  const letters = Object.keys(state.parameters);
  app.bifurcations.parameter = letters.includes(app.bifurcations.parameter) ? app.bifurcations.parameter : letters[0] ?? null;
  fillList(app.part("bifurcation-parameter"), letters.map((name) => [name, greek(name)]), app.bifurcations.parameter ?? "");
  if (isMap) fillList(app.part("series-row"), message.labels.map((label, k) => [String(k), label]), String(app.series.row));
  else app.send({ type: "region", width: REGION_GRID, height: REGION_GRID });
  app.actions.launchPending();
  app.actions.showBackgroundState();
  askFrame(app, "section", "configuration", "frequency", "body", "table");
}

function takeRegionMessage(app, message) {
  takeRegion(app.configuration, message);
  askFrame(app, "configuration");
}

function takeLaunchedMessage(app, message) {
  const { orbits } = app;
  let orbit = orbits.shown.get(message.orbit);
  if (!orbit) {
    const fill = app.fills?.find((entry) => message.orbit >= entry.first && message.orbit < entry.end);
    if (!fill || fill.gone) return;
    orbit = newOrbit(message.orbit, orbits.nextMark++, message.point);
    fill.numbers.push(message.orbit);
    showOrbit(orbits, orbit);
  }
  orbit.point = Array.from(message.point);
  orbit.z0 = Array.from(message.z0);
  if (orbits.chosen === null) app.actions.choose(orbit.number, true);
  app.actions.remembered();
  askFrame(app, "section", "table");
}

function takeRefusedMessage(app, message) {
  app.actions.dropRefused(message.orbit);
  app.actions.notice(sentence(message.message), true);
}

function takePointsMessage(app, message) {
  const { orbits, section } = app;
  const orbit = knownOrbit(orbits, message.orbit);
  if (!orbit || !addPoints(orbits, orbit, message.first, message.points)) return;
  if (message.first === 0 && app.launchedAt.has(message.orbit)) noteFirst(app, message.orbit);
  if (orbits.shown.has(message.orbit)) {
    if (showsDensity(section, orbits)) {
      queueDensity(section.density, orbit, message.first);
      if (section.layer) section.layer.stale = true;
    } else if (section.layer) appendPoints(section.layer, orbit, message.first);
    askFrame(app, "section", "table");
  }
  if (orbits.total > MOST && !app.full) {
    app.full = true;
    app.send({ type: "stop", orbit: null });
    app.actions.notice("Limit of 20 million points reached: all orbits are stopped. Remove some orbits to continue.", true);
  }
}

// How long after a click its first points were drawn, for the benchmarks.
function noteFirst(app, number) {
  const began = app.launchedAt.get(number);
  app.launchedAt.delete(number);
  requestAnimationFrame(() => app.firstPoints.push(performance.now() - began));
}

function takeReadingMessage(app, message) {
  const orbit = knownOrbit(app.orbits, message.orbit);
  if (!orbit) return;
  const { type, orbit: number, ...values } = message;
  orbit.reading = values;
  if (orbit.number === app.orbits.chosen && values.step !== app.step) {
    app.step = values.step;
    app.actions.showFoot();
  }
  app.paintStale = true;
  if (hasLeft(orbit, true)) app.actions.adviseEnergy();
  askFrame(app, "table", "frequency");
}

function takeMotionMessage(app, message) {
  if (takeMotion(app.motion, message)) askFrame(app, "configuration", "body", "moving");
}

function takeBifurcationsMessage(app, message) {
  if (takeBifurcations(app.bifurcations, message)) askFrame(app, "frequency");
}

function takeSpeedMessage(app, message) {
  app.speed = message.steps_per_second;
  app.actions.showFoot();
}

function takeWrongMessage(app, message) {
  if (message.what === "formula" || message.what === "energy" || message.what === "section") {
    const kept = app.actions.keepSurface();
    showWrong(app.panel, message.what, sentence(message.message) + (kept ? " The orbits are those of " + kept + "." : ""));
  } else if (message.what === "orbit" && app.motion.asked !== null) app.motion.asked = null;
  else app.actions.notice(sentence(message.message), true);
  askFrame(app, "section");
}

// A message with its full stop; a name at the beginning stays as it is.
function sentence(text) {
  const said = String(text ?? ""), first = /^\S+ = /.test(said) ? said.charAt(0) : said.charAt(0).toUpperCase();
  return first + said.slice(1) + (/[.!?]$/.test(said) ? "" : ".");
}

