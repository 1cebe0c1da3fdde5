// What the page shows, as one record of numbers, names and formulas; and the same as the part of an address after "#".

import { isEquations, sidesOf } from "./equations_code.js";
import { readMap } from "./map_formula.js";
import { periodicPieces, shownFormula } from "./text.js";

const NUMBER = /^[+-]?(\d{1,17}\.?\d{0,20}|\.\d{1,20})([eE][+-]?\d{1,3})?$/;
const NAME = /^[A-Za-z][A-Za-z0-9_]{0,31}$/;
const FORMULA = /^[\w\s+\-*/().,^]{1,600}$/;
const MAP_TEXT = /^[\w\s+\-*/().,^=;']{1,600}$/;
const PERIODIC = /^[\w\s+\-*/().,=;]{0,200}$/;
const COORDINATES = /^[A-Za-z]\w{0,15}([ ,]+[A-Za-z]\w{0,15})?$/;
const TYPED = ["coordinates", "momenta", "periodic", "drive_period"]; // what is typed beside a formula
const MOST_POINTS = 400;
const USUAL_CROSSINGS = 500; // of an orbit in time
const MAP_ITERATES = 2000; // of an orbit of a map: regular is said after 200 natural periods, each of 2 pi iterates

export const OWN = { "your-body": "body", "your-plane": "plane", "your-map": "map", "your-ode": "ode" };

const OWN_SECTIONS = {
  body: [{ name: "alpha-turning", constant: null }, { name: "beta-turning", constant: null }, { name: "alpha=c", constant: 1.5 }, { name: "beta=c", constant: 0.3 }, { name: "area=c", constant: 1 }],
};

export const OWN_FORMULAS = { body: "G/2*(D1**2 + D2**2 - 2) - G*log(D1*D2) + K/2*(D1*D2 - 1)**2", plane: "(x**2 + y**2)/2 + lam*(x**2*y - y**3/3)", map: "p1 = p + K*sin(x); x1 = x + p1", ode: "x' = s*(y - x); y' = x*(r - z) - y; z' = x*y - b*z" };

// Coordinates and momenta of a typed map; x and p of what is none.
const lastRead = { text: null, found: null };
function rowsOf(formula) {
  if (lastRead.text !== formula) {
    lastRead.text = formula;
    try {
      lastRead.found = readMap({ formula });
    } catch {
      lastRead.found = { coordinates: ["x"], momenta: ["p"] };
    }
  }
  return lastRead.found;
}

// Where the rows of a map or flow start that are beside the plane: [[name, value], ...].
export function startsBeside(system, state) {
  const own = state.section.replace("=c", ""), seen = system.kind === "map" ? state.section.split(",") : [own, ...system.coordinates.filter((name) => name !== own).slice(0, 2)];
  return Object.entries(state.others ?? {}).filter(([name]) => !seen.includes(name));
}

// Where rows start beside what is seen: all rows of a flow, of a map those of more than one plane.
export function othersOf({ kind, coordinates, momenta = [] }) {
  const rows = kind === "ode" ? coordinates : kind === "map" && coordinates.length > 1 ? [...coordinates, ...momenta] : [];
  return Object.fromEntries(rows.map((row) => [row, 0]));
}

// The system of a state: that of the set-up, or one made of the user's formula.
export function systemOf(setup, state) {
  const kind = OWN[state.system];
  if (!kind) return setup.systems.find((system) => system.name === state.system);
  if (kind === "map") {
    const { coordinates, momenta } = rowsOf(state.formula), line = !momenta.length;
    const sections = coordinates.map((name, i) => ({ name: line ? name : name + "," + momenta[i], constant: null }));
    const periodic = periodicPieces(state.periodic);
    const job = { map: state.formula, ...(periodic.length ? { periodic } : {}) };
    return { name: state.system, title: "Your map", formula: shownFormula(state.formula), kind, line, own: true, coordinates, momenta, parameters: [], sections, job };
  }
  const job = jobOf(kind, state), common = { name: state.system, own: true, parameters: [], job };
  if (kind === "body") return { ...common, title: "Your formula", formula: "V = " + shownFormula(state.formula), kind, coordinates: [], sections: OWN_SECTIONS.body };
  const names = kind === "ode" ? variablesOf(state.formula) : namesIn(state.coordinates), written = namesIn(state.momenta), driven = state.drive_period !== "";
  const momenta = kind === "ode" ? names.slice(1, 2) : written.length ? written : names.map((name) => "p_" + name);
  const symbol = kind === "ode" ? "" : written.length ? "H = " : "V = ", title = kind === "ode" ? "Your equations" : "Your formula";
  const said = { ...common, title, formula: symbol + shownFormula(state.formula) + (driven ? ", period " + shownFormula(state.drive_period) : ""), rates: isEquations({ ...state, kind }) };
  if (driven) return { ...said, kind: "map", typed: kind, driven: true, coordinates: names.slice(0, 1), momenta: momenta.slice(0, 1), sections: [{ name: names[0] + "," + momenta[0], constant: null }] };
  return { ...said, kind, typed: kind, coordinates: names, momenta: kind === "ode" ? [] : momenta, sections: names.map((name) => ({ name: name + "=c", constant: 0 })) };
}

const namesIn = (text) => text.split(/[ ,]+/).filter(Boolean);

// What a typed system is in a job file; null where a job has no such.
function jobOf(kind, { formula, coordinates, momenta, periodic, drive_period }) {
  if (kind === "body") return { formula };
  if (kind === "ode") return drive_period ? null : { ode: formula };
  const beside = { ...(namesIn(momenta).length ? { momenta: namesIn(momenta).join(" ") } : {}), ...(periodic ? { periodic: periodicPieces(periodic) } : {}) };
  return { hamiltonian: formula, coordinates: namesIn(coordinates).join(" "), ...beside, ...(drive_period ? { drive_period } : {}) };
}

// The variables of typed equations, x y z of what is none.
function variablesOf(formula) {
  try {
    return sidesOf(formula).map(([name]) => name);
  } catch {
    return ["x", "y", "z"];
  }
}

// The schemes that run a system: collocations those of rates, splittings others.
export function schemesFor(setup, system) {
  const rates = system.rates ?? system.code?.kind === "equations";
  return setup.schemes.filter((scheme) => Boolean(scheme.collocation) === rates);
}

// The state that a system begins with.
export function firstState(setup, name) {
  const start = setup.start ?? {};
  const common = { scheme: setup.schemes[0].name, accuracy: 1e-10, crossings: USUAL_CROSSINGS, direction: 1, formula: "", coordinates: "x y", momenta: "", periodic: "", drive_period: "", ...picked(start, ["scheme", "accuracy", "crossings", "direction"]) };
  const kind = OWN[name];
  if (kind === "map") {
    const own = { energy: null, p_eta: 0, p_gamma: 0, section: "x,p", constant: null, others: {}, view: null, points: null };
    return { ...common, ...own, crossings: start.crossings ?? MAP_ITERATES, system: name, formula: OWN_FORMULAS.map, periodic: "x=2*pi", parameters: { K: 0.9 } };
  }
  if (kind === "ode") {
    const own = { energy: null, p_eta: 0, p_gamma: 0, section: "z=c", constant: 27, others: {}, view: null, points: null };
    return { ...common, ...own, scheme: "GAUSS16", system: name, formula: OWN_FORMULAS.ode, parameters: { s: 10, r: 28, b: 2.667 } };
  }
  if (kind) {
    const values = kind === "body" ? { G: 1, K: 2 } : { lam: 1 };
    const surface = kind === "body" ? { energy: 1.5, p_eta: 0.3, p_gamma: 0.2, section: "alpha-turning", constant: null } : { energy: 0.125, p_eta: 0, p_gamma: 0, section: "x=c", constant: 0 };
    return { ...common, ...surface, system: name, formula: OWN_FORMULAS[kind], parameters: values, view: null, points: null };
  }
  const system = setup.systems.find((entry) => entry.name === name) ?? setup.systems[0];
  const parameters = Object.fromEntries(system.parameters.map((entry) => [entry.name, entry.value]));
  const isMap = system.kind === "map";
  if (isMap) common.crossings = start.crossings ?? MAP_ITERATES;
  const others = othersOf(system);
  if (!schemesFor(setup, system).some((scheme) => scheme.name === common.scheme)) common.scheme = usualScheme(setup, system);
  const own = { others, phase: system.phase ?? null, energy: system.energy, p_eta: system.p_eta ?? 0, p_gamma: system.p_gamma ?? 0, section: system.sections[0].name, constant: system.sections[0].constant, parameters, view: null, points: null };
  const given = start.system === system.name ? { ...start, parameters: { ...parameters, ...start.parameters } } : {};
  return { ...common, ...own, ...picked(given, Object.keys(own)), system: system.name };
}

// The scheme that a system begins with.
export function usualScheme(setup, system) {
  const suited = schemesFor(setup, system), wanted = setup.start?.scheme;
  return (suited.find((scheme) => scheme.name === wanted) ?? suited.find((scheme) => scheme.name === "GAUSS16" || scheme.name === "KAHAN_LI8") ?? suited[0]).name;
}

function picked(record, names) {
  return Object.fromEntries(names.filter((name) => record[name] !== undefined).map((name) => [name, record[name]]));
}

const isNumeric = (value) => typeof value === "number";

// The state as text after "#".
export function hashOf(state, startPoints, view) {
  const parts = [["system", state.system]], isMap = state.energy === null;
  if (OWN[state.system]) parts.push(["formula", state.formula]);
  const typed = { plane: TYPED, map: ["periodic"], ode: ["periodic", "drive_period"] }[OWN[state.system]] ?? [];
  for (const name of typed) if (state[name]) parts.push([name, state[name]]);
  for (const [name, value] of Object.entries(state.parameters)) parts.push(["parameter." + name, value]);
  const isFlow = isMap && state.constant !== null;
  if (isMap) for (const [name, value] of Object.entries(state.others)) if (isFlow ? value !== 0 : !state.section.split(",").includes(name)) parts.push(["start." + name, value]);
  for (const name of isFlow ? ["section", "constant", "direction", "scheme", "accuracy", "crossings"] : isMap ? ["section", ...(isNumeric(state.phase) ? ["phase", "scheme", "accuracy"] : []), "crossings"] : ["energy", "section", "constant", "direction", "p_eta", "p_gamma", "scheme", "accuracy", "crossings"]) {
    if (state[name] !== null && state[name] !== undefined) parts.push([name, state[name]]);
  }
  if (view) parts.push(["view", view.join(":")]);
  if (startPoints.length) parts.push(["points", startPoints.slice(0, MOST_POINTS).map((point) => point.join(":")).join(",")]);
  return parts.map(([name, value]) => name + "=" + encodeURIComponent(value).replaceAll("%3A", ":").replaceAll("%2C", ",").replaceAll("%20", "+")).join("&");
}

// Make the rest of a typed state that of its system: section, scheme, what rows start at.
export function settle(setup, state, system) {
  const rows = othersOf(system);
  const known = system.sections.some((section) => section.name === state.section), same = Object.keys(rows).join() === Object.keys(state.others ?? {}).join();
  if (!known) Object.assign(state, { section: system.sections[0].name, constant: system.sections[0].constant });
  if (!same || !state.others) state.others = rows;
  if (!schemesFor(setup, system).some((scheme) => scheme.name === state.scheme)) state.scheme = usualScheme(setup, system);
  if (system.driven && state.phase === null) Object.assign(state, { phase: 0, crossings: state.crossings === USUAL_CROSSINGS ? MAP_ITERATES : state.crossings });
  else if (system.driven) state.phase ??= 0;
  else if (system.own) state.phase = null;
  const timeless = system.kind === "map" || system.kind === "ode";
  if (timeless) state.energy = null;
  else state.energy ??= 1;
  return known && same;
}

// Read such a text strictly: {state, wrong} with a sentence for each part that is no number, name or formula and is left out.
export function readHash(setup, text) {
  const wrong = [];
  const given = new Map();
  for (const part of text.replace(/^#/, "").slice(0, 40000).split("&").filter(Boolean)) {
    const at = part.indexOf("=");
    try {
      given.set(part.slice(0, at), decodeURIComponent(part.slice(at + 1).replaceAll("+", "%20")));
    } catch {
      wrong.push(part.slice(0, Math.max(0, at)));
    }
  }
  // A plus sign of a formula is written %2B, so that + can stand for a space.
  const name = given.get("system");
  const known = name !== undefined && (Object.hasOwn(OWN, name) || setup.systems.some((system) => system.name === name));
  if (name !== undefined && !known) wrong.push("system");
  const state = firstState(setup, known ? name : setup.start?.system);
  if (given.size) state.points = [];
  const read = (key, accepts, take) => {
    if (!given.has(key)) return;
    const value = given.get(key);
    if (accepts(value)) state[key] = take(value);
    else wrong.push(key);
    given.delete(key);
  };
  given.delete("system");
  const isNumber = (value) => NUMBER.test(value) && Number.isFinite(Number(value));
  if (OWN[state.system]) {
    const isMap = OWN[state.system] === "map";
    const equations = isMap || OWN[state.system] === "ode";
    if (given.has("formula")) Object.assign(state, { periodic: "", momenta: "", drive_period: "" });
    read("periodic", (value) => PERIODIC.test(value), String);
    read("formula", (value) => (equations ? MAP_TEXT : FORMULA).test(value), String);
    for (const name of ["coordinates", "momenta"]) read(name, (value) => COORDINATES.test(value), String);
    read("drive_period", (value) => FORMULA.test(value), String);
    if (given.size && [...given.keys()].some((key) => key.startsWith("parameter."))) state.parameters = {};
  }
  const system = systemOf(setup, state);
  const hadConstant = given.has("constant") || !given.has("section");
  if (OWN[state.system]) settle(setup, state, system);
  for (const key of { map: system.driven ? ["phase"] : [], ode: ["constant"] }[system.kind] ?? ["energy", "constant", "p_eta", "p_gamma"]) read(key, isNumber, Number);
  for (const row of Object.keys(state.others ?? {})) {
    const key = "start." + row;
    if (given.has(key) && isNumber(given.get(key))) state.others[row] = Number(given.get(key));
    else if (given.has(key)) wrong.push(key);
    given.delete(key);
  }
  read("accuracy", (value) => isNumber(value) && Number(value) >= 1e-14 && Number(value) <= 0.1, Number);
  read("crossings", (value) => /^\d{1,7}$/.test(value) && Number(value) >= 1, Number);
  read("direction", (value) => ["1", "-1", "0"].includes(value), Number);
  const section = (value) => system.sections.find((entry) => entry.name === value);
  read("section", section, String);
  if (!hadConstant) state.constant = section(state.section)?.constant ?? null;
  read("scheme", (value) => schemesFor(setup, system).some((scheme) => scheme.name === value), String);
  for (const key of [...given.keys()].filter((entry) => entry.startsWith("parameter."))) {
    const parameter = key.slice(10), value = given.get(key);
    const has = OWN[state.system] ? NAME.test(parameter) && Object.keys(state.parameters).length < 24 : Object.hasOwn(state.parameters, parameter);
    if (has && isNumber(value)) state.parameters[parameter] = Number(value);
    else wrong.push(NAME.test(parameter) ? key : "parameter");
    given.delete(key);
  }
  const isView = (ends) => ends.length === 4 && ends.every(isNumber) && Number(ends[0]) < Number(ends[1]) && Number(ends[2]) < Number(ends[3]);
  read("view", (value) => isView(value.split(":")), (value) => value.split(":").map(Number));
  const pairs = (value) => value.split(",").map((pair) => pair.split(":"));
  read("points", (value) => pairs(value).length <= MOST_POINTS && pairs(value).every((pair) => pair.length === 2 && pair.every(isNumber)), (value) => pairs(value).map((pair) => pair.map(Number)));
  for (const key of given.keys()) wrong.push(/^[a-z_.]{1,24}$/i.test(key) ? key : "a part without a name");
  return { state, wrong };
}
