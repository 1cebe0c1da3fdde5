// What people do: launch, fill, undo, choose, change the system, save.

import { askFrame, sceneOf } from "./drawing.js";
import { backgroundDiffers } from "./background.js";
import { innerOf } from "./frame.js";
import { followOrbit } from "./motion.js";
import { hasLeft, newOrbit, remember, removeOrbit, showOrbit } from "./orbits.js";
import { schemeTitle, setSlider } from "./controls.js";
import { rangeEnergy, showConstant, showOthers, showParameters, showState, showWrong } from "./panel.js";
import { makeSaving } from "./offers.js";
import { OWN, firstState, hashOf, settle, systemOf } from "./state.js";
import { homeOf, placedIn } from "./scaling.js";
import { showRow } from "./table.js";
import { shownFormula, shownNumber, writeLabel } from "./text.js";
import { takeRegion } from "./view_configuration.js";
import { changeView, isAllowed, wholeView, zoomView } from "./view_section.js";

const REGION_CELLS = 256; // cells of the accessible region, each way
const FIRST = 12, EVENLY = [0.7548776662466927, 0.5698402909980532]; // orbits at the beginning, spread evenly (Roberts 2018)
const CHANGE = 1000; // milliseconds within which changes are one
const LIVE = 60; // milliseconds between two surfaces while a slider moves

export function makeActions(app) {
  const { orbits, section, part, setup } = app;
  const redraw = (...names) => askFrame(app, ...names);
  const everything = () => redraw("section", "configuration", "body", "frequency", "table");
  let timer = null, hashTimer = null;

  function notice(text, isWrong = false) {
    writeLabel(part("notice"), text);
    part("notice").classList.toggle("is-wrong", isWrong);
  }

  // The address follows the state a little later.
  function remembered() {
    if (!app.options.standalone) return;
    clearTimeout(hashTimer);
    hashTimer = setTimeout(() => {
      if (location.hash !== app.lastHash) return; // another address has just been given
      app.lastHash = "#" + addressOf();
      location.replace(app.lastHash);
      app.lastHash = location.hash;
    }, 250);
  }

  function addressOf() {
    const starts = [...orbits.shown.values()].map((orbit) => orbit.point);
    return hashOf(app.refused ? app.accepted : app.state, starts.length ? starts : (app.pending ?? []).map((start) => start.point).filter(Boolean), section.past.length ? section.frame.view : null);
  }

  // ---- orbits

  function launch(start, crossings, mark) {
    const orbit = newOrbit(orbits.next++, mark ?? orbits.nextMark++, start.point ?? null);
    orbit.home = start.home ?? null;
    showOrbit(orbits, orbit);
    app.launchedAt.set(orbit.number, performance.now());
    const where = start.z0 ? { z0: start.z0 } : { point: start.point };
    app.send({ type: "launch", orbit: orbit.number, ...where, crossings });
    return orbit;
  }

  // Numbers no longer than a hundredth of a pixel needs, which make a short address.
  function shortPoint(u, v) {
    const [u0, u1, v0, v1] = section.frame.view;
    const short = (value, width) => Number(value.toFixed(Math.min(15, Math.max(0, Math.ceil(-Math.log10(width / 1e5))))));
    return [short(u, u1 - u0), short(v, v1 - v0)];
  }

  function click(u, v) {
    if (!section.surface) return;
    notice("");
    part("hello").hidden = true;
    app.own = true;
    app.changedAt = -Infinity; // what comes next is a change of its own
    const orbit = launch({ point: shortPoint(u, v) }, app.state.crossings);
    forget(remember(orbits, { launched: [orbit.number] }));
    choose(orbit.number, true);
    redraw("section", "table");
  }

  function fill() {
    if (!section.surface) return;
    part("hello").hidden = true;
    app.own = true;
    const cells = Number(part("grid").value), rows = app.root.hasAttribute("data-line") ? 1 : cells;
    const entry = { first: orbits.next, end: orbits.next + cells * rows, numbers: [] };
    orbits.next = entry.end;
    app.fills = [...(app.fills ?? []), entry].slice(-40);
    forget(remember(orbits, { launched: entry.numbers, fill: entry }));
    app.send({ type: "fill", columns: cells, rows, view: [...section.frame.view], crossings: app.state.crossings, first: entry.first });
    notice((rows === 1 ? cells : cells + " × " + cells) + " orbits over the view" + (app.state.energy === null ? "." : ", where accessible."));
  }

  function forget(gone) {
    for (const orbit of gone) app.send({ type: "forget", orbit: orbit.number });
  }

  // Take an orbit away from the page; undo can bring it back.
  function take(number) {
    const orbit = removeOrbit(orbits, number);
    if (!orbit) return null;
    if (section.layer) section.layer.stale = true;
    if (orbit.reading.status === "running") {
      app.send({ type: "stop", orbit: number });
      orbit.unfinished = true;
    }
    section.revision++;
    app.full = false;
    return orbit;
  }

  function takeAll(numbers) {
    const removed = numbers.map(take).filter(Boolean);
    if (!orbits.shown.has(orbits.chosen)) choose([...orbits.shown.keys()].at(-1) ?? null, true);
    section.hover = null;
    everything();
    remembered();
    return removed;
  }

  function clear() {
    const fills = (app.fills ?? []).filter((entry) => !entry.gone);
    for (const entry of fills) entry.gone = true;
    if (fills.length) app.send({ type: "stop", orbit: null });
    const removed = takeAll([...orbits.shown.keys()]);
    if (removed.length) forget(remember(orbits, { removed }));
    orbits.nextMark = 1;
    app.own = true;
    notice(removed.length ? "Orbits removed. U restores them." : "");
  }

  // After a surface that was refused the controls are those of the orbits again.
  function takeBack() {
    Object.assign(app, { refused: false, state: { ...structuredClone(app.accepted), crossings: app.state.crossings } });
    showState(app.panel, app.state, systemOf(setup, app.state));
    rangeEnergy(app.panel, app.state, section.surface);
    for (const what of ["energy", "section"]) showWrong(app.panel, what, null);
    remembered();
    notice("Previous state restored.");
  }

  function undo() {
    if (app.refused && section.surface && !app.surfaceLost) return takeBack();
    const action = orbits.actions.pop();
    if (!action) return notice("Nothing to undo.");
    if (action.fill) action.fill.gone = true;
    if (action.launched) {
      if (action.fill) app.send({ type: "stop", orbit: null });
      forget(takeAll([...action.launched]));
      orbits.nextMark = Math.max(0, ...[...orbits.shown.values()].map((orbit) => orbit.mark)) + 1;
      if (!action.before) return notice("The launch is undone.");
      useState(action.before);
      return notice("Previous state restored.");
    }
    for (const orbit of action.removed) {
      showOrbit(orbits, orbit);
      if (orbit.unfinished) app.send({ type: "more", orbit: orbit.number, crossings: Math.max(1, app.state.crossings - orbit.count) });
      orbit.unfinished = false;
    }
    orbits.nextMark = Math.max(0, ...[...orbits.shown.values()].map((orbit) => orbit.mark)) + 1;
    if (section.layer) section.layer.stale = true;
    section.revision++;
    choose(action.removed.at(-1)?.number ?? null, true);
    everything();
    return notice("Restored.");
  }

  function dropRefused(number) {
    if (!removeOrbit(orbits, number)) return;
    for (const action of orbits.actions) if (action.launched) action.launched = action.launched.filter((entry) => entry !== number);
    orbits.nextMark = Math.max(0, ...[...orbits.shown.values()].map((orbit) => orbit.mark)) + 1;
    orbits.actions = orbits.actions.filter((action) => action.fill || action.removed || action.before || action.launched.length);
    if (orbits.chosen === null) choose([...orbits.shown.keys()].at(-1) ?? null, true);
    everything();
  }

  function choose(number, quietly = false) {
    orbits.chosen = number !== null && number === orbits.chosen && !quietly ? null : number;
    followOrbit(app.motion, orbits.shown.get(orbits.chosen) ?? null);
    if (section.layer) section.layer.chosenStale = true;
    everything();
    if (orbits.chosen !== null) requestAnimationFrame(() => showRow(app.table, orbits.chosen));
  }

  function step(by) {
    const order = [...orbits.shown.keys()].reverse();
    if (!order.length) return;
    const at = order.indexOf(orbits.chosen);
    choose(order[Math.max(0, Math.min(order.length - 1, at < 0 ? 0 : at + by))], true);
  }

  function more(number) {
    const numbers = number === null || number === undefined ? [...orbits.shown.keys()] : [number];
    for (const orbit of numbers) app.send({ type: "more", orbit, crossings: app.state.crossings });
  }

  function hide(number) {
    const orbit = orbits.shown.get(number);
    if (!orbit) return;
    orbit.hidden = !orbit.hidden;
    section.revision++;
    if (section.layer) section.layer.stale = true;
    everything();
  }

  function forgetOne(number) {
    const removed = takeAll([number]);
    if (removed.length) forget(remember(orbits, { removed }));
  }

  // ---- system, surface

  // Show a whole state: another system, or that of an address.
  function useState(state, before = null) {
    app.typedBefore = null;
    Object.assign(app, { state, before, changedAt: -Infinity });
    const system = systemOf(setup, state);
    app.alive = state.points === null;
    app.pending = (state.points ?? []).map((point) => ({ point }));
    showState(app.panel, state, system);
    for (const what of ["formula", "periodic", "energy", "section"]) showWrong(app.panel, what, null);
    app.root.removeAttribute("data-unread");
    part("unread").hidden = true;
    part("title").textContent = system.title;
    if (app.options.standalone) document.title = system.title + " – fastaff explorer";
    writeLabel(part("formula-shown"), system.name === "own" ? shownFormula(system.formula) : system.formula ?? "");
    part("body-figure").hidden = system.kind !== "body";
    showKind(system);
    dropOrbits();
    app.keepView = false;
    section.past = state.view ? [[...state.view]] : [];
    closeSurface();
    sendSystem();
    everything();
  }

  function showKind(system) {
    app.root.dataset.kind = system.kind;
    app.root.toggleAttribute("data-driven", Boolean(system.driven));
    app.root.toggleAttribute("data-line", Boolean(system.line));
  }

  function sendSystem() {
    const { state } = app;
    const system = systemOf(setup, state);
    app.ready = false;
    takeRegion(app.configuration, null);
    if (system.own) return app.send({ type: "parse", ...written(system) });
    app.send({ type: "system", system: { name: system.name, kind: system.kind, coordinates: system.coordinates, momenta: system.momenta, parameters: { ...state.parameters }, code: system.code }, scheme: state.scheme, accuracy: state.accuracy });
    return showFoot();
  }

  // What is typed, as the backend takes it.
  function written(system) {
    const { formula, coordinates, momenta, periodic, drive_period } = app.state;
    return { formula, kind: system.typed ?? system.kind, coordinates, momenta, periodic, drive_period };
  }

  // A formula is one: give its letters values and hand it over.
  function takeParsed(names) {
    const { state } = app;
    showWrong(app.panel, "formula", null);
    const letters = OWN[state.system] === "body" ? [...names.filter((name) => name !== "mu"), "mu"] : names;
    const isOther = app.typedBefore !== null && isOtherSystem(Object.keys(state.parameters), letters);
    const parameters = Object.fromEntries(letters.map((name) => [name, isOther ? 1 : state.parameters[name] ?? 1]));
    const same = Object.keys(state.parameters).join() === letters.join();
    state.parameters = parameters;
    const system = systemOf(setup, state);
    if (!same) showParameters(app.panel, state, system);
    const isFlow = system.kind === "ode", isFirst = app.typedBefore === null;
    const settled = settle(setup, state, system) && app.root.dataset.kind === system.kind;
    if (!isFirst && isFlow && (isOther || !settled)) state.tried = true;
    if (!isFirst && (isOther || !settled)) Object.assign(app, { pending: [], alive: true, keepView: false });
    app.typedBefore = state.formula;
    if (!settled) {
      app.pending ??= [];
      app.keepView = false;
      showKind(system);
      showState(app.panel, state, system);
    }
    writeLabel(part("formula-shown"), system.formula);
    app.send({ type: "system", system: { ...written(system), parameters: { ...parameters } }, scheme: state.scheme, accuracy: state.accuracy });
    showFoot();
  }

  // Whether a typed text is another system than the one before: most of the letters of that are gone.
  const isOtherSystem = (before, letters) => 2 * before.filter((name) => letters.includes(name)).length < before.length;

  // All orbits go, for another surface.
  function dropOrbits() {
    orbits.shown.clear();
    Object.assign(orbits, { total: 0, actions: [], chosen: null });
    app.fills = [];
    orbits.nextMark = 1;
    section.revision++;
    if (section.layer) section.layer.stale = true;
    followOrbit(app.motion, null);
  }

  function closeSurface() {
    section.surface = null;
    takeRegion(app.configuration, null);
    everything();
  }

  // Say what to do where no orbit stays.
  function adviseEnergy() {
    const { surface } = section, shown = [...orbits.shown.values()];
    if (!surface || surface.periods || !shown.length || surface.advised === orbits.next) return;
    const { minimum, escape, energy } = surface, opens = escape !== null && energy > escape;
    if (!shown.every((orbit) => hasLeft(orbit, opens))) return;
    surface.advised = orbits.next;
    const lower = minimum === null ? escape - (energy - escape) : minimum + 0.75 * (escape - minimum);
    if (opens) notice("Orbits can escape above E = " + shownNumber(escape, 5) + ". Try E = " + shownNumber(lower, 2) + ".");
    else notice(minimum === null ? "All orbits escape: the potential has no minimum." : "All orbits escape.");
  }

  // What an answer without a surface leaves: the orbits of the surface before, named, if the backend still has them.
  function keepSurface() {
    if (app.surfaceLost || !section.surface || !app.accepted) return void closeSurface();
    Object.assign(app, { pending: null, refused: true, before: null, changedAt: -Infinity });
    return "E = " + shownNumber(app.accepted.energy, 8);
  }

  // The state before a change that takes the orbits away, for undo; a slider that moves is one change.
  function aboutToChange() {
    const now = performance.now();
    if (now - (app.changedAt ?? -Infinity) > CHANGE && app.accepted && section.surface) {
      const points = [...orbits.shown.values()].map((orbit) => orbit.point).filter(Boolean);
      app.before = { ...structuredClone(app.accepted), points, view: section.past.length ? [...section.frame.view] : null };
    }
    app.changedAt = now;
  }

  function askSurface() {
    const { state } = app;
    if (!app.ready) return;
    const system = systemOf(setup, state), asked = ++app.asked;
    if (system.kind === "map") app.send({ type: "surface", asked, energy: null, section: state.section, others: { ...state.others }, phase: state.phase ?? 0, width: REGION_CELLS, height: REGION_CELLS });
    else app.send({ type: "surface", asked, tried: Boolean(state.tried), energy: state.energy, others: { ...state.others }, section: state.section, constant: state.constant, direction: state.direction, p_eta: system.kind === "body" ? state.p_eta : 0, p_gamma: system.kind === "body" ? state.p_gamma : 0, width: REGION_CELLS, height: REGION_CELLS });
    remembered();
    showBackgroundState();
  }

  // Another surface of the same system: orbits start anew from the same points of phase space, or from the same places of the
  // region, which is another one at each energy.
  function surfaceChanged(byState, first) {
    aboutToChange();
    if (app.state.tried && !app.own) Object.assign(app, { pending: [], alive: true }); // the first orbits go with their section
    if (!app.pending) {
      app.pending = [...orbits.shown.values()].filter((orbit) => orbit.point).map((orbit) => (byState && orbit.z0 ? { z0: orbit.z0, mark: orbit.mark } : { ...startOf(orbit), mark: orbit.mark }));
    }
    if (first) { // the backend forgets its orbits
      dropOrbits();
      app.surfaceLost = true;
    }
    app.scaled = "";
    app.asked++; // an answer that is on its way is of the state before
    notice("");
    clearTimeout(timer);
    timer = setTimeout(first ?? askSurface, LIVE);
  }

  // The point of an orbit with its place in the region, which is kept however often the energy changes.
  const startOf = ({ point, home }) => ({ point, home: home ?? (section.surface ? homeOf(section.surface, point) : null) });

  // A start of another surface on this one: an energy scales all of them, anything else those that would lie outside.
  function placed(start, byEnergy) {
    const { surface } = section;
    if (!start.home || surface.energy === null || (!byEnergy && isAllowed(surface, ...start.point))) return start;
    return { ...start, point: shortPoint(...placedIn(surface, start.home)) };
  }

  function launchPending() {
    dropOrbits();
    const { accepted } = app, byEnergy = accepted && ["system", "energy", "section"].map((name) => accepted[name] === app.state[name]).join() === "true,false,true";
    if (app.alive) app.own = false;
    const asked = app.pending?.length ? app.pending : app.alive ? firstStarts() : [], starts = asked.map((start) => placed(start, byEnergy));
    const moved = starts.filter((start, k) => start !== asked[k] && start.point.some((x, i) => x !== asked[k].point[i])).length;
    app.scaled = moved ? (moved === 1 ? "1 initial condition" : moved + " initial conditions") + " scaled to the accessible region" + (byEnergy ? " at E = " + shownNumber(app.state.energy, 5) : "") + "." : "";
    if (moved) notice(app.scaled);
    Object.assign(app, { pending: null, alive: false, refused: false, accepted: structuredClone({ ...app.state, points: [] }) });
    for (const start of starts) launch(start, app.state.crossings, start.mark);
    if (starts.length) orbits.nextMark = Math.max(...[...orbits.shown.values()].map((orbit) => orbit.mark)) + 1;
    if (orbits.shown.size) {
      choose([...orbits.shown.keys()].at(-1), true);
      forget(remember(orbits, { launched: [...orbits.shown.keys()], before: app.before }));
    }
  }

  // Points that fill the region evenly, the first ones too; of one variable one, whose cobweb can be followed.
  function firstStarts() {
    const { surface } = section, most = surface.graph ? 1 : FIRST, [u0, u1, v0, v1] = surface.extent, found = [];
    for (let k = 1; k < 40 * FIRST && found.length < most; k++) {
      const [u, v] = shortPoint(u0 + (u1 - u0) * ((0.5 + k * EVENLY[0]) % 1), v0 + (v1 - v0) * ((0.5 + k * EVENLY[1]) % 1));
      if (isAllowed(surface, u, v)) found.push({ point: [u, v] });
    }
    return found;
  }

  const panel = {
    state: () => app.state,
    system(name) {
      aboutToChange();
      useState(firstState(setup, name), app.before);
    },
    formula(typed) {
      Object.assign(app.state, typed, { coordinates: typed.coordinates || (typed.drive_period ? "x" : "x y") });
      for (const name of ["coordinates", "momenta"]) {
        if (app.state[name] && !/^[A-Za-z]\w*([ ,]+[A-Za-z]\w*)?$/.test(app.state[name])) return showWrong(app.panel, "formula", name[0].toUpperCase() + name.slice(1) + " must be one or two names, such as x y.");
      }
      surfaceChanged(false, sendSystem);
      return undefined;
    },
    parameter(name, value) {
      app.state.parameters[name] = value;
      surfaceChanged(false, () => {
        app.send({ type: "parameters", parameters: { ...app.state.parameters } });
        askSurface();
      });
    },
    other(name, value) {
      app.state.others[name] = value;
      surfaceChanged(false);
    },
    set(name, value) {
      app.state[name] = value;
      if (name === "constant") app.state.tried = false;
      surfaceChanged(name === "direction" || name === "constant");
    },
    quiet(name, value) {
      app.state[name] = value;
      remembered();
    },
    section(name) {
      const found = systemOf(setup, app.state).sections.find((entry) => entry.name === name);
      Object.assign(app.state, { section: name, constant: found.constant, tried: false });
      showConstant(app.panel, app.state);
      const isMap = app.root.dataset.kind === "map";
      showOthers(app.panel, app.state, systemOf(setup, app.state));
      app.keepView = false;
      if (isMap) app.pending = []; // a point of one plane is none of another
      surfaceChanged(true);
    },
    integration(name, value) {
      app.state[name] = value;
      surfaceChanged(false, sendSystem);
    },
  };

  // A value of a parameter that is chosen in a figure, shown at its slider.
  function setParameter(name, value) {
    const slider = app.panel.parameters[name];
    if (!slider || value === app.state.parameters[name]) return;
    setSlider(slider, value);
    panel.parameter(name, value);
  }

  // ---- view

  const viewChanged = () => {
    redraw("section", "hover");
    remembered();
  };

  const pointer = {
    click,
    boxMode: () => app.boxMode,
    hover(place) {
      part("readout").setAttribute("aria-live", "off");
      app.pointer = place;
      redraw("hover");
    },
    grab: () => section.past.push(section.frame.view),
    drag(view) {
      changeView(section, view, false);
      viewChanged();
    },
    box(box) {
      section.box = box;
      redraw("section");
    },
    boxed(view) {
      changeView(section, view);
      if (app.boxMode) act("box");
      viewChanged();
    },
    zoom(u, v, factor, begins) {
      zoomView(section, u, v, factor, begins);
      viewChanged();
    },
  };

  function zoomBy(factor) {
    const [u0, u1, v0, v1] = section.frame.view;
    const [u, v] = section.cursor ?? [(u0 + u1) / 2, (v0 + v1) / 2];
    zoomView(section, u, v, factor, true);
    viewChanged();
  }

  function pan(dx, dy) {
    const [u0, u1, v0, v1] = section.frame.view;
    const du = 0.15 * dx * (u1 - u0), dv = 0.15 * dy * (v1 - v0);
    changeView(section, [u0 + du, u1 + du, v0 + dv, v1 + dv]);
    viewChanged();
  }

  function moveCursor(dx, dy) {
    const [u0, u1, v0, v1] = section.frame.view;
    const [u, v] = section.cursor ?? [(u0 + u1) / 2, (v0 + v1) / 2];
    section.cursor = [Math.min(u1, Math.max(u0, u + (dx * (u1 - u0)) / 60)), Math.min(v1, Math.max(v0, v + (dy * (v1 - v0)) / 60))];
    app.pointer = pixelOfCursor();
    part("readout").setAttribute("aria-live", "polite"); // what the keyboard moves is read out
    redraw("section", "hover");
  }

  function pixelOfCursor() {
    const inner = innerOf(section.frame);
    const [u0, u1, v0, v1] = section.frame.view;
    return [inner.x + ((section.cursor[0] - u0) / (u1 - u0)) * inner.width, inner.y + ((v1 - section.cursor[1]) / (v1 - v0)) * inner.height];
  }

  // The sentence for a map that is not of this state, and its button.
  function showBackgroundState() {
    const button = app.root.querySelector('[data-do="background"]');
    button.hidden = !app.background;
    if (!app.background) return;
    button.textContent = "Map: " + app.background.label;
    const differs = backgroundDiffers(app.background, app.state);
    button.setAttribute("aria-pressed", String(section.wantsBackground && !differs));
    button.disabled = Boolean(differs);
    if (!differs || !section.wantsBackground || part("notice").classList.contains("is-wrong")) return;
    const said = "The background map belongs to " + differs + "; it is not shown.", scaled = app.scaled && !app.scaled.includes(said) ? app.scaled + " " : "";
    notice(scaled + said);
  }

  function showFoot() {
    const { state, speed, step: length } = app;
    const isMap = systemOf(setup, state).kind === "map", version = "fastaff " + setup.version;
    const said = isMap
      ? ["Regular orbits agree with fastaff in Python to 1e-9, chaotic orbits until round-off has grown.", version,
          ...(state.phase === null || state.phase === undefined ? [] : ["one iterate per drive period, " + schemeTitle(state.scheme) + ", accuracy " + state.accuracy])]
      : [
          "First crossings agree with fastaff in Python to 1e-9. Late crossings of chaotic orbits depend on the browser.",
          version,
          schemeTitle(state.scheme) + ", accuracy " + state.accuracy + (length ? ", step " + shownNumber(length, 3) : ""),
        ];
    if (speed) said.push(shownNumber(Math.round(speed), 2) + (isMap ? " iterates/s" : " steps/s"));
    part("foot").textContent = said.join(" · ");
    part("exact").textContent = said[0];
  }

  const saving = makeSaving(app, { notice, sceneOf, redraw, addressOf });

  const named = {
    undo, clear, fill, launch: () => section.cursor && click(...section.cursor),
    more: () => more(orbits.chosen), stop: () => app.send({ type: "stop", orbit: null }),
    hide: () => hide(orbits.chosen), forget: () => forgetOne(orbits.chosen), none: () => choose(null, true),
    "zoom-in": () => zoomBy(1 / 1.6), "zoom-out": () => zoomBy(1.6),
    whole() {
      wholeView(section);
      section.past = [];
      viewChanged();
    },
    back() {
      const view = section.past.pop();
      if (view) section.frame.view = view;
      viewChanged();
    },
    box() {
      app.boxMode = !app.boxMode;
      app.root.querySelector('[data-do="box"]').setAttribute("aria-pressed", String(app.boxMode));
    },
    density() {
      section.wantsDensity = !section.wantsDensity;
      app.root.querySelector('[data-do="density"]').setAttribute("aria-pressed", String(section.wantsDensity));
      redraw("section", "table", "hover");
    },
    background() {
      section.wantsBackground = !section.wantsBackground;
      showBackgroundState();
      redraw("section", "hover");
    },
    play() {
      app.motion.playing = !app.motion.playing;
      showPlaying();
      redraw("configuration", "body", "moving");
    },
    theme() {
      app.themeChoice = { system: "light", light: "dark", dark: "system" }[app.themeChoice];
      app.applyTheme();
    },
    help() {
      const dialog = part("help-dialog");
      if (dialog.open) dialog.close();
      else dialog.showModal();
    },
    ...saving,
  };

  function showPlaying() {
    const button = app.root.querySelector('[data-do="play"]');
    button.textContent = app.motion.playing ? "Pause" : "Play";
  }

  function act(name) {
    if (Object.hasOwn(named, name)) named[name]();
  }

  return {
    setParameter, do: act, choose, more, hide, forget: forgetOne, step, moveCursor, pan, pointer, panel, notice, remembered, useState, askSurface, launchPending, takeParsed, dropRefused, closeSurface, keepSurface, adviseEnergy, showBackgroundState, showFoot, showPlaying, click,
  };
}
