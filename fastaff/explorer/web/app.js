// The explorer: its state, what people do with it, what the backend answers.

import { plotColours } from "./colours.js";
import { followKeys, listKeys } from "./keys.js";
import { makeActions } from "./actions.js";
import { makeBackground } from "./background.js";
import { makeDrawing, askFrame } from "./drawing.js";
import { followOverflow, followWidth } from "./layout.js";
import { receive } from "./messages.js";
import { makeMotion } from "./motion.js";
import { makeOrbits } from "./orbits.js";
import { PAINTS } from "./paint.js";
import { makePanel } from "./panel.js";
import { followPointers } from "./pointer.js";
import { fillList } from "./controls.js";
import { firstState, readHash } from "./state.js";
import { makeTable } from "./table.js";
import { makeBifurcations, valueAt } from "./view_bifurcations.js";
import { makeBodyView } from "./view_body.js";
import { makeConfiguration } from "./view_configuration.js";
import { makeFrequency, orbitAt } from "./view_frequency.js";
import { makeSection } from "./view_section.js";
import { makeSeries } from "./view_series.js";

// Start the explorer in an element that holds the markup of page.html. backend: {send(message, transfer), onmessage};
// options: standalone (the page is its own: address, keys of the whole page).
export function startExplorer(root, setup, backend, options = {}) {
  const part = (name) => root.querySelector('[data-part="' + name + '"]');
  const hash = options.standalone ? readHash(setup, location.hash) : { state: firstState(setup, setup.start?.system), wrong: [] };
  const app = {
    root, setup, part, options, backend, state: hash.state, orbits: makeOrbits(), background: makeBackground(setup.background), section: makeSection({ back: part("back"), points: part("points"), front: part("front") }),
    configuration: makeConfiguration(part("configuration")), body: makeBodyView(part("body")), frequency: makeFrequency(part("frequency")), series: makeSeries(part("series")), bifurcations: makeBifurcations(part("bifurcations")),
    theme: "light", themeChoice: "system", colours: null, pending: null, asked: 0, surfaceFor: null, launchedAt: new Map(), firstPoints: [], speed: null, step: null, dirty: new Set(), pointer: null, boxMode: false,
  };
  app.send = (message, transfer) => backend.send(message, transfer);
  app.motion = makeMotion(app.send);
  makeDrawing(app);
  const actions = makeActions(app);
  app.actions = actions;
  app.panel = makePanel(part, setup, actions.panel);
  app.table = makeTable(part("table"), part("rows"), { choose: actions.choose, more: actions.more, hide: actions.hide, forget: actions.forget, step: actions.step });
  app.table.redraw = () => askFrame(app, "table");
  backend.onmessage = (event) => receive(app, event.data);
  followTheme(app);
  followWidth(root, part);
  followOverflow(part("table"));
  followHands(app);
  app.motion.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  actions.showPlaying();
  listKeys(part("keys"));
  new ResizeObserver(() => askFrame(app, "section", "configuration", "body", "frequency", "table")).observe(root);
  if (hash.wrong.length) actions.notice("Parts of the address are not valid and were ignored: " + [...new Set(hash.wrong)].join(", ") + ".", true);
  actions.useState(app.state);
  if (options.standalone) {
    addEventListener("hashchange", () => {
      if (location.hash === app.lastHash) return;
      app.lastHash = location.hash;
      const read = readHash(setup, location.hash);
      app.state = read.state;
      actions.useState(app.state);
      if (read.wrong.length) actions.notice("Parts of the address are not valid and were ignored: " + [...new Set(read.wrong)].join(", ") + ".", true);
    });
  }
  app.lastHash = options.standalone ? location.hash : null;
  root.explorer = app;
  return app;
}

function followTheme(app) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  app.applyTheme = () => {
    app.theme = app.themeChoice === "system" ? (dark.matches ? "dark" : "light") : app.themeChoice;
    app.root.dataset.theme = app.theme;
    app.root.querySelector('[data-do="theme"]').textContent = "Theme: " + app.themeChoice;
    app.colours = plotColours(app.root);
    app.paintStale = true; // the scale has other colours
    askFrame(app, "section", "configuration", "body", "frequency", "table");
  };
  dark.addEventListener("change", app.applyTheme);
  app.applyTheme();
}

// Buttons, keys, pointers.
function followHands(app) {
  const { root, part, actions, section } = app;
  root.addEventListener("click", (event) => {
    const button = event.target.closest("[data-do]");
    if (button) actions.do(button.dataset.do);
    const menu = part("save");
    if (menu.open && !(event.target.closest("summary") && menu.contains(event.target))) menu.open = false;
  });
  part("save").addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !part("save").open) return;
    event.stopPropagation(); // the orbit stays chosen
    part("save").open = false;
    part("save").querySelector("summary").focus();
  });
  part("save").addEventListener("focusout", (event) => {
    if (event.relatedTarget && !part("save").contains(event.relatedTarget)) part("save").open = false;
  });
  followKeys(app.options.standalone ? document : root, { do: actions.do, move: actions.moveCursor, pan: actions.pan, step: actions.step });
  followPointers(section.canvases.front, section.frame, actions.pointer);
  part("frequency").addEventListener("click", (event) => {
    const box = event.target.getBoundingClientRect();
    const orbit = orbitAt(app.frequency, event.clientX - box.left, event.clientY - box.top);
    if (orbit) actions.choose(orbit.number);
  });
  part("bifurcations").addEventListener("click", (event) => {
    const box = event.target.getBoundingClientRect(), value = valueAt(app.bifurcations, event.clientX - box.left, event.clientY - box.top);
    if (value !== null) actions.setParameter(app.bifurcations.parameter, value);
  });
  part("bifurcation-parameter").addEventListener("change", () => {
    app.bifurcations.parameter = part("bifurcation-parameter").value;
    askFrame(app, "frequency");
  });
  part("frequency-axes").addEventListener("change", () => {
    app.frequency.axes = part("frequency-axes").value;
    askFrame(app, "frequency");
  });
  fillList(part("paint"), PAINTS, app.orbits.paintedBy);
  part("paint").addEventListener("change", () => {
    app.orbits.paintedBy = part("paint").value;
    if (!part("paint").matches(":focus-visible")) part("paint").blur(); // after a click keys are those of the page again
    Object.assign(app, { paintStale: true, paintedAt: -Infinity });
    askFrame(app, "section", "configuration", "body", "frequency", "table");
  });
  part("series-row").addEventListener("change", () => {
    app.series.row = Number(part("series-row").value);
    askFrame(app, "table");
  });
  const speed = part("speed");
  const changed = () => (app.motion.speed = 10 ** Number(speed.value));
  speed.addEventListener("input", changed);
  changed();
}

