// The panel of controls: it shows the state and tells what people change in it.

import { schemesFor, startsBeside } from "./state.js";
import { fillList, makeSlider, rangeSlider, saysWrong, schemeTitle, sectionTitle } from "./controls.js";

const WAIT = 140; // milliseconds after the last sign of a formula before it is read

// act: {system(name), formula({formula, coordinates, ...}), parameter(name, value), surface(), section(name), integration()}
export function makePanel(part, setup, act) {
  const panel = { part, setup, act, sliders: {}, parameters: {}, constant: null, energyRange: "", typing: false };
  const choices = setup.systems.map((system) => [system.name, system.title]);
  fillList(part("system"), [...choices, ["your-body", "Your formula: a body"], ["your-plane", "Your formula: H(q, p)"], ["your-map", "Your formula: a map"], ["your-ode", "Your formula: equations"]], "");
  part("system").addEventListener("change", () => act.system(part("system").value));
  let timer = null;
  for (const name of WRITTEN) {
    part(name).addEventListener("input", () => {
      clearTimeout(timer);
      panel.typing = true; // what is in the boxes is newer than any answer
      timer = setTimeout(() => {
        panel.typing = false;
        act.formula(Object.fromEntries(WRITTEN.map((each) => [each, part(each).value.trim()])));
      }, WAIT);
    });
  }
  part("section").addEventListener("change", () => act.section(part("section").value));
  part("direction").addEventListener("change", () => act.set("direction", Number(part("direction").value)));
  part("scheme").addEventListener("change", () => act.integration("scheme", part("scheme").value));
  part("accuracy").addEventListener("change", () => act.integration("accuracy", Number(part("accuracy").value)));
  part("crossings").addEventListener("change", () => {
    const value = Number(part("crossings").value);
    if (Number.isInteger(value) && value >= 1 && value <= 1e6) act.quiet("crossings", value);
    else part("crossings").value = act.state().crossings;
  });
  return panel;
}

const HINTS = {
  body: "Use D1, D2, alpha, beta, r, vartheta and parameters.",
  plane: "Use coordinates, momenta, t and parameters. Without momenta the text is V and H = p²/2 + V. With a drive period use one coordinate and t.",
  map: "x1 or x' is the image of x; x1 = r*x*(1 - x) is a map of one variable. Other letters are parameters. Periodic coordinates are drawn around 0.",
  ode: "Use x' = ... for three variables or more, or x' and p' with t and a drive period.",
};

const FORMULA_NAMES = { body: "Potential energy V", plane: "Energy H(q, p), or V(q)", map: "Map", ode: "Equations" };
export const WRITTEN = ["formula", "coordinates", "momenta", "periodic", "drive_period"];
const ROWS = { body: [], plane: ["coordinates", "momenta", "periodic", "drive_period"], map: ["periodic"], ode: ["periodic", "drive_period"] };

// Show a state; the controls of its system are made anew.
export function showState(panel, state, system) {
  const { part, act } = panel;
  part("system").value = state.system;
  part("own").hidden = !system.own;
  const kind = system.typed ?? system.kind;
  for (const name of ROWS.plane) part(name + "-row").hidden = !(ROWS[kind] ?? []).includes(name);
  for (const name of WRITTEN) if (system.own && part(name).value.trim() !== state[name]) part(name).value = state[name];
  part("formula-hint").textContent = HINTS[kind];
  part("formula-name").textContent = FORMULA_NAMES[kind];
  showParameters(panel, state, system);
  const names = { body: ["energy", "p_eta", "p_gamma"], plane: ["energy"], map: [], ode: [] }[system.kind];
  panel.sliders = Object.fromEntries(names.map((name) => [name, makeSlider({ name: name === "energy" ? "E" : name, value: state[name], ...rangeAbout(state[name], name === "energy" ? 0 : -1.5) }, (value, final) => act.set(name, value, final))]));
  part("surface").replaceChildren(...names.map((name) => panel.sliders[name].row));
  panel.energyRange = "";
  fillList(part("section"), system.sections.map((section) => [section.name, sectionTitle(section.name)]), state.section);
  part("section-row").hidden = system.sections.length < 2;
  showOthers(panel, state, system);
  fillList(part("scheme"), schemesFor(panel.setup, system).map((scheme) => [scheme.name, schemeTitle(scheme.name)]), state.scheme);
  part("direction").value = String(state.direction);
  const accuracies = part("accuracy");
  if (![...accuracies.options].some((option) => Number(option.value) === state.accuracy)) accuracies.add(new Option(String(state.accuracy), String(state.accuracy)));
  accuracies.value = [...accuracies.options].find((option) => Number(option.value) === state.accuracy).value;
  part("crossings").value = state.crossings;
  showConstant(panel, state);
}

function rangeAbout(value, least) {
  const reach = Math.max(1.5, 2 * Math.abs(value));
  return { from: least < 0 || value < 0 ? -reach : 0, to: reach };
}

export function showParameters(panel, state, system) {
  const { part, act } = panel;
  panel.parameters = Object.fromEntries(
    Object.entries(state.parameters).map(([name, value]) => {
      const known = system.parameters.find((entry) => entry.name === name);
      const range = known && known.from < known.to ? { from: Math.min(known.from, value), to: Math.max(known.to, value) } : rangeAbout(value, value < 0 ? -1 : 0);
      return [name, makeSlider({ name, value, ...range }, (number, final) => act.parameter(name, number, final))];
    }),
  );
  part("parameters").replaceChildren(...Object.values(panel.parameters).map((slider) => slider.row));
}

// Sliders of the rows of a map outside of the plane, at which its orbits start.
export function showOthers(panel, state, system) {
  const { part, act } = panel, timeless = system.kind === "map" || system.kind === "ode", rows = timeless ? startsBeside(system, state) : [];
  const sliders = rows.map(([name, value]) => makeSlider({ name, value, ...rangeAbout(value, -1) }, (number) => act.other(name, number)));
  if (system.driven) sliders.push(makeSlider({ name: "t", value: state.phase, ...rangeAbout(state.phase, 0) }, (number, final) => act.set("phase", number, final)));
  if (timeless) part("surface").replaceChildren(...sliders.map((slider) => slider.row));
  part("others-hint").hidden = !rows.length;
}

export function showConstant(panel, state) {
  const { part, act } = panel;
  part("section").value = state.section;
  panel.constant = null;
  if (state.constant === null) return part("constant").replaceChildren();
  const name = state.section === "area=c" ? "c" : state.section.replace("=c", "");
  panel.constant = makeSlider({ name, value: state.constant, ...(state.constant > 0 ? { from: 0, to: 2 * Math.max(1, state.constant) } : rangeAbout(state.constant, -1)) }, (value, final) => act.set("constant", value, final));
  return part("constant").replaceChildren(panel.constant.row);
}

// Let the slider of the energy run from the minimum to the escape energy, once for each system.
export function rangeEnergy(panel, state, surface) {
  const key = state.system + Object.values(state.parameters).join();
  const slider = panel.sliders.energy;
  if (!slider || panel.energyRange === key || !Number.isFinite(surface.minimum)) return;
  panel.energyRange = key;
  const height = state.energy - surface.minimum;
  const top = Number.isFinite(surface.escape) && surface.escape !== null ? Math.max(surface.escape, surface.minimum + 1.1 * height) : surface.minimum + Math.max(1e-6, 3 * height);
  rangeSlider(slider, surface.minimum, top);
}

// Sentences beside the controls that they are about; null takes one away. Returns false where there is no such place.
export function showWrong(panel, what, sentence) {
  const places = { formula: "wrong-formula", periodic: "wrong-periodic", energy: "wrong-energy", section: "wrong-section" };
  if (!Object.hasOwn(places, what)) return false;
  saysWrong(panel.part(places[what]), sentence);
  const marked = { formula: panel.part("formula"), periodic: panel.part("periodic"), energy: panel.sliders.energy?.box, section: panel.constant?.box }[what];
  if (sentence) marked?.setAttribute("aria-invalid", "true");
  else marked?.removeAttribute("aria-invalid");
  if (sentence) marked?.setAttribute("aria-describedby", places[what]);
  else marked?.removeAttribute("aria-describedby");
  return true;
}
