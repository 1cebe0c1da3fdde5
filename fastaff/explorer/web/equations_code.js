// Typed H(q, p), driven systems and equations of motion as systems of rates, with exact derivatives.

import { Expressions } from "./derivatives.js";
import { GRAMMAR_CONSTANTS, RESERVED_NAMES, checkedName, parametersOf, parseFormula } from "./grammar.js";
import { checkTried, noMap, periodsOf } from "./map_formula.js";
import { graphValue, least, wallsOf } from "./walls.js";

const TIME = "t", MOST_EQUATIONS = 16, TRIED_PLACES = 200, TURN_PLACES = 24, SAME_AROUND = 1e-9;

const split = (text) => (text ?? "").split(/[\s,]+/).filter(Boolean);

/** Whether a typed system is one of rates: with momenta in its text, driven, or equations of motion. */
export function isEquations({ kind, momenta = "", drive_period = "" }) { return kind === "ode" || (kind === "plane" && Boolean(split(momenta).length || drive_period.trim())); }

/** Throw the sentence for letters of a text without a period that are the time. */
export function refuseTime(names) {
  if (names.includes(TIME)) throw noMap("formula: it depends on t: give the period of the drive, or make it a variable");
}

/** What is typed: {rows: its variables, names: its parameters, texts, periods, drive}; throws the sentence that says why it is none. */
export function readEquations({ formula, kind, coordinates = "x y", momenta = "", periodic = "", drive_period = "" }) {
  const driven = Boolean(drive_period.trim()), flow = kind === "ode", sides = flow ? sidesOf(formula) : null;
  const q = flow ? sides.map(([name]) => name) : split(coordinates), own = split(momenta), wanted = driven ? 1 : 2;
  const p = flow ? [] : own.length || !driven ? own : [`p_${q[0]}`], rows = [...q, ...p];
  if (!flow && q.length !== wanted) throw noMap(`formula: coordinates must be ${wanted} name${driven ? " for a driven system" : "s"} in the page, got ${q.length}; fastaff.hamiltonian in Python takes others`);
  if (!flow && p.length !== q.length) throw noMap(`formula: momenta must be ${q.length} name${driven ? "" : "s"}, one for each of ${q.join(", ")}; got ${p.length}`);
  if (flow && driven && q.length !== 2) throw noMap(`formula: driven equations must be 2 in the page, x' and p', got those of ${q.join(", ")}`);
  if (flow && !driven && (q.length < 3 || q.length > MOST_EQUATIONS)) throw noMap(`formula: equations without a period must be 3 to ${MOST_EQUATIONS} in the page, to have a section; got those of ${q.join(", ")}`);
  const taken = new Set(["self", "np", ...(driven ? [TIME] : [])]);
  for (const name of rows) taken.add(checkedName(name, flow ? "variable" : "coordinate or momentum", taken));
  const texts = flow ? sides.map(([, side]) => side) : [formula], variables = [...rows, ...(driven ? [TIME] : [])], names = [];
  const join = (found) => { for (const name of found) if (!names.includes(name)) names.push(name); };
  for (const text of texts) join(parametersOf(text, variables, new Set([...RESERVED_NAMES, ...variables])));
  if (!driven) refuseTime(names);
  const periods = periodsOf(periodic, q, names);
  if (driven) join(parametersOf(drive_period, []));
  const programs = texts.map((text) => parseFormula(text, variables, names));
  return { rows, coordinates: q, momenta: p, names, programs, periods, drive: driven ? parseFormula(drive_period, [], names, "drive_period") : null, flow, whole: own.length > 0 };
}

/** Names and right-hand sides of equations x' = ... or dx/dt = .... */
export function sidesOf(text) {
  return text.split(/[;\n]/).map((piece) => piece.trim()).filter(Boolean).map((piece) => {
    const found = /^(?:([A-Za-z]\w*)\s*'|d([A-Za-z]\w*)\s*\/\s*dt)\s*=\s*(.+)$/.exec(piece);
    if (!found) throw noMap(`formula: equations must be x' = ..., separated by semicolons, such as "x' = p; p' = -sin(x) - g*p"; got '${piece}'`);
    return [found[1] ?? found[2], found[3]];
  });
}

/** The record of such a system, as Python's records.py; of a driven one the rows are x, t, p, p_t. */
export function equationsCode(given) {
  const read = readEquations(given), { rows, names, programs, flow, drive } = read, graph = new Expressions();
  const order = drive ? [rows[0], TIME, rows[1], " work"] : rows, zero = graph.number(0);
  const outside = new Map([...names, ...(drive ? [TIME] : []), ...rows].map((name) => [name, graph.name(names.includes(name) ? name : `.${name}`)]));
  const own = programs.map((program) => graph.of(program, outside, GRAMMAR_CONSTANTS));
  const values = new Map(names.map((name) => [name, Object.hasOwn(given.parameters ?? {}, name) ? given.parameters[name] : 1]));
  checkTried(graph, own, [...rows, TIME], values, flow ? "the right-hand sides are finite and real" : "H is finite and real");
  const plain = (part) => (read.whole || flow ? part : graph.sum(part, graph.product(graph.number(0.5), graph.power(outside.get(rows[1]), graph.number(2)))));
  const H = flow ? null : plain(own[0]), slope = (name) => graph.slope(H, `.${name}`), half = rows.length/2;
  const moving = flow ? own : rows.map((_, r) => (r < half ? slope(rows[r + half]) : graph.negative(slope(rows[r - half]))));
  const spans = read.periods.map((program) => (program ? graph.of(program, outside, GRAMMAR_CONSTANTS) : zero));
  if (drive && !read.periods[0] && turnsAround(moving, rows, values)) spans[0] = graph.number(2*Math.PI);
  const rates = drive ? [moving[0], graph.number(1), moving[1], zero] : moving;
  const along = (part) => rows.map((name) => graph.product(graph.slope(part, `.${name}`), graph.name(` d${order.indexOf(name)}`))).reduce((a, b) => graph.sum(a, b));
  const texts = new Map([...names.map((name) => [name, `$${name}`]), ...order.flatMap((name, r) => [[`.${name}`, `q${r}`], [` d${r}`, `d${r}`]])]);
  const print = (roots) => graph.printed(roots, texts, "k$");
  const methods = {
    rates: print(rates), tangent: print(rates.map(along)), margin: least(print(wallsOn(graph, flow ? own : [H], order, values))),
    periods: print([...spans, ...Array.from({ length: order.length - spans.length }, () => zero)]),
    ...(drive ? { period: print([graph.of(drive, outside, GRAMMAR_CONSTANTS)]) } : {}), ...(flow || drive ? {} : { energy: print([H]) }),
  };
  const winds = order.map((_, r) => r < spans.length && spans[r] !== zero), angles = flow && !drive ? [] : read.coordinates.slice(0, drive ? 1 : 2);
  const placed = drive ? { coordinates: [rows[0]], momenta: [rows[1]] } : { coordinates: read.coordinates, momenta: read.momenta };
  return { kind: "equations", n: flow && !drive ? rows.length : 2, rows: order.length, canonical: !flow && !drive, driven: Boolean(drive), parameters: names, angles, winds, ...placed, methods };
}

/** Whether the rates are the same 2 pi farther on in the first row, and not everywhere. */
function turnsAround(rates, rows, values) {
  let seed = 12345, changes = false;
  const random = () => { seed = seed*48271 % 2147483647; return 6*seed/2147483647 - 3; };
  for (let k = 0; k < TURN_PLACES; k++) {
    const point = new Map([...rows, TIME].map((name) => [`.${name}`, random()])), first = `.${rows[0]}`, x = point.get(first);
    const at = (place) => rates.map((part) => graphValue(part, new Map(point).set(first, place), values)), [here, beside, around] = [x, x + 1, x + 2*Math.PI].map(at);
    if (here.some((value, r) => !(Math.abs(value - around[r]) <= SAME_AROUND*(1 + Math.abs(value))))) return false;
    changes ||= here.some((value, r) => Math.abs(value - beside[r]) > SAME_AROUND*(1 + Math.abs(value)));
  }
  return changes;
}

/** What must be positive in the parts, at random points. */
function wallsOn(graph, parts, order, values) {
  let seed = 4711;
  const random = () => { seed = seed*48271 % 2147483647; return seed/2147483647; };
  const points = Array.from({ length: TRIED_PLACES }, () => new Map(order.map((name) => [`.${name}`, 4*random() - 2])));
  return [...new Set(parts.flatMap((part) => wallsOf(graph, part, points, values)))];
}
