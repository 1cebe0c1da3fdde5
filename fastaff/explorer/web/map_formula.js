// A typed map as a system: statements name = formula, as formulas/map_source.py reads them, with the exact derivative.

import { Expressions } from "./derivatives.js";
import { GRAMMAR_CONSTANTS, RESERVED_NAMES, checkedName, parametersOf, parseFormula } from "./grammar.js";
import { periodicPieces } from "./text.js";
import { graphValue } from "./walls.js";

const IMAGE = "_image", EXAMPLE = "'p1 = p + K*sin(x); x1 = x + p1'", MOST_ROWS = 16, MAP_TRIALS = 400;

export function noMap(message) { return Object.assign(new Error(message), { what: "formula" }); }

const shownName = (name) => name.replace(IMAGE, "'");

/** What a text says: {variables, coordinates, momenta, names: its parameters, lines, periods}; throws why it is no map. */
export function readMap({ formula, periodic = "" }) {
  if (formula.length > 4000) throw noMap(`formula must have at most 4000 characters, got ${formula.length}`);
  const suffix = formula.includes("'") ? IMAGE : "1";
  const pieces = formula.replace(/([A-Za-z]\w*)'/g, `$1${IMAGE}`).split(/[;\n]/).map((piece) => piece.trim()).filter(Boolean);
  const sides = pieces.map((piece) => {
    const at = piece.indexOf("="), left = piece.slice(0, at).trim(), right = piece.slice(at + 1).trim();
    if (at < 0 || !right || !/^[A-Za-z_]\w*$/.test(left)) throw noMap(`formula must be statements name = formula, such as ${EXAMPLE}; got '${shownName(piece)}'`);
    return [left, right];
  });
  const lefts = sides.map(([left]) => left), isImage = (left) => left.endsWith(suffix) && left.length > suffix.length;
  const variables = lefts.filter(isImage).map((left) => left.slice(0, -suffix.length));
  if (!variables.length) throw noMap(`formula must give the image of each variable, x1 = ... or x' = ..., such as ${EXAMPLE}`);
  if ((variables.length % 2 && variables.length > 1) || variables.length > MOST_ROWS) {
    throw noMap(`formula must give the images of 1, 2, 4, ... or ${MOST_ROWS} variables, got those of ${variables.join(", ")}`);
  }
  const known = new Set(), taken = new Set(["self", "np"]), names = [], texts = [];
  for (const name of variables) { checkedName(name, "variable", new Set([...taken, ...known])); known.add(name); }
  for (const [left, right] of sides) {
    if (known.has(left)) throw noMap(`formula: ${shownName(left)} = ... must give a value to a new name. Write the image of x as x1 or x'.`);
    if (!isImage(left)) checkedName(left, "name", new Set([...taken, ...known]));
    for (const name of parametersOf(right, [...known], new Set([...RESERVED_NAMES, ...taken]))) {
      if (lefts.includes(name)) throw noMap(`formula: ${shownName(name)} has no value yet where ${shownName(left)} takes it`);
      if (!names.includes(name)) names.push(name);
    }
    texts.push({ left, right, known: [...known] });
    known.add(left);
  }
  const { coordinates, momenta } = pairsOf(variables), periods = periodsOf(periodic, [...coordinates, ...momenta], names);
  const lines = texts.map((line) => ({ left: line.left, program: parseFormula(line.right, line.known, names) }));
  return { variables, coordinates, momenta, names, lines, suffix, periods };
}

/** The period of each row of a text such as x=2*pi, null where it has none; its letters join the parameters. */
export function periodsOf(text, rows, names) {
  try {
    return readPeriods(text, rows, names);
  } catch (problem) {
    throw Object.assign(problem, { what: "periodic" });
  }
}

function readPeriods(text, rows, names) {
  const found = new Map();
  for (const piece of periodicPieces(text)) {
    const at = piece.indexOf("="), name = piece.slice(0, at).trim(), value = piece.slice(at + 1).trim();
    if (at < 0 || !rows.includes(name) || !value) throw noMap(`periodic must be NAME=PERIOD of ${rows.join(", ")}, such as ${rows[0]}=2*pi; got '${piece}'`);
    for (const one of parametersOf(value, [])) {
      if (rows.includes(one)) throw noMap(`the period of ${name} must be one of letters and numbers, got ${one}`);
      if (!names.includes(one)) names.push(one);
    }
    found.set(name, value);
  }
  return rows.map((name) => (found.has(name) ? parseFormula(found.get(name), [], names) : null));
}

/** Coordinates and momenta, none of one variable: by names p_x or px beside x, q1 with p1, x with p; else the first half are coordinates. */
function pairsOf(variables) {
  if (variables.length === 1) return { coordinates: variables, momenta: [] };
  const known = new Set(variables), half = variables.length/2;
  if (variables.length === 2 && known.has("p")) return { coordinates: variables.filter((name) => name !== "p"), momenta: ["p"] };
  const partner = (name) => [`p_${name}`, `p${name}`].find((other) => known.has(other) && other !== name);
  const coordinates = variables.filter(partner), momenta = coordinates.map(partner);
  if (coordinates.length === half && new Set([...coordinates, ...momenta]).size === variables.length) return { coordinates, momenta };
  const numbered = new Map(variables.filter((name) => name[0] === "p" && name.length > 1).map((name) => [name.slice(1), name]));
  const others = variables.filter((name) => name[0] !== "p");
  if (numbered.size === others.length && others.length === half && others.every((name) => numbered.has(name.slice(1)))) {
    return { coordinates: others, momenta: others.map((name) => numbered.get(name.slice(1))) };
  }
  return { coordinates: variables.slice(0, half), momenta: variables.slice(half) };
}

/** The record of a typed map, as Python's model_code. */
export function mapCode({ formula, periodic = "", parameters = {} }) {
  const read = readMap({ formula, periodic }), { coordinates, momenta, names, lines, suffix, periods } = read;
  const graph = new Expressions(), rows = [...coordinates, ...momenta], n = coordinates.length;
  const values = new Map(names.map((name) => [name, graph.name(name)]));
  rows.forEach((name) => values.set(name, graph.name(`.${name}`)));
  for (const { left, program } of lines) values.set(left, graph.of(program, values, GRAMMAR_CONSTANTS));
  const images = rows.map((name) => values.get(name + suffix)), changes = rows.map((_, r) => graph.name(` d${r}`));
  const slopes = images.map((part) => rows.map((name, r) => graph.product(graph.slope(part, `.${name}`), changes[r])).reduce((a, b) => graph.sum(a, b)));
  const zero = graph.number(0), spans = periods.map((program) => (program ? graph.of(program, values, GRAMMAR_CONSTANTS) : zero));
  const texts = new Map(names.map((name) => [name, `$${name}`]));
  rows.forEach((name, r) => texts.set(`.${name}`, r < n ? `q${r}` : `p${r - n}`).set(` d${r}`, `d${r}`));
  checkTried(graph, images, rows, new Map(names.map((name) => [name, Object.hasOwn(parameters, name) ? parameters[name] : 1])));
  const isLine = momenta.length === 0; // beside its variable an idle row, always 0
  const print = (roots) => graph.printed(isLine ? [...roots, zero] : roots, texts, "k$");
  const methods = {
    iterate: print(images), tangent: print(slopes), periods: print(spans),
    margin: { lines: [], results: [`(1 + 0*(${coordinates.map((_, i) => `q${i}`).join(" + ")}))`] },
  };
  const winds = [...periods.map(Boolean), ...(isLine ? [false] : [])];
  return { kind: "map", n, line: isLine, parameters: names, angles: coordinates, winds, coordinates, momenta, methods };
}

/** Refuse a map that has a finite image nowhere around the origin. */
export function checkTried(graph, images, rows, values, what = "the map has a finite real image") {
  let seed = 12345;
  const random = () => { seed = seed*48271 % 2147483647; return seed/2147483647; };
  for (let k = 0; k < MAP_TRIALS; k++) {
    const point = new Map(rows.map((name) => [`.${name}`, 3*random() - 1.5])), done = new Map();
    if (images.every((part) => Number.isFinite(graphValue(part, point, values, done)))) return;
  }
  throw noMap(`formula: ${what} at none of ${MAP_TRIALS} points with |z| < 1.5`);
}
