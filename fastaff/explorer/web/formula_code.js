// A typed formula as a system: its methods with exact derivatives, what makes it a body's, where it lives.

import { Expressions } from "./derivatives.js";
import { GRAMMAR_CONSTANTS, RESERVED_NAMES, checkedName, parametersOf, parseFormula, valueOf } from "./grammar.js";
import { equationsCode, isEquations, readEquations, refuseTime } from "./equations_code.js";
import { mapCode, readMap } from "./map_formula.js";
import { least, wallsOf } from "./walls.js";

export const BODY_VARIABLES = ["D1", "D2", "alpha", "beta", "r", "vartheta", "rho", "x", "y", "z", "u", "a1", "a2", "b1", "b2"];
const TURNED = ["x", "y", "z", "u", "a1", "a2", "b1", "b2"], TRIALS = 24, SAME_VALUE = 1e-9, ON_AXIS = 2**-34;
const GAUSS = [[0.2386191860831969, 0.467913934572691], [0.6612093864662645, 0.3607615730481386], [0.9324695142031521, 0.1713244923791704]];

function refused(message) { return Object.assign(new Error(message), { what: "formula" }); }

/** What a formula is: {names: its parameters}; throws the sentence that says why it is none. */
export function readFormula(given) {
  const { formula, kind, coordinates = "x y", periodic = "" } = given;
  if (kind === "map") return readMap({ formula, periodic });
  if (isEquations(given)) return readEquations(given);
  const variables = kind === "body" ? BODY_VARIABLES : planeCoordinates(coordinates);
  const names = parametersOf(formula, variables, new Set([...RESERVED_NAMES, ...variables]));
  refuseTime(names);
  return { variables, names };
}

function planeCoordinates(coordinates) {
  const names = typeof coordinates === "string" ? coordinates.replaceAll(",", " ").split(/\s+/).filter(Boolean) : coordinates;
  if (names.length !== 2) throw refused(`coordinates must be 2 names in the page, got ${names.length}; fastaff.hamiltonian in Python takes others`);
  const taken = new Set(["self", "np"]);
  for (const name of names) taken.add(checkedName(name, "coordinate", taken));
  return names;
}

/** The record of a system, as Python's model_code, of a formula with values of its parameters (1 where there is none). */
export function formulaCode(given) {
  const { formula, kind, coordinates, periodic = "", parameters = {} } = given;
  if (kind === "map") return mapCode({ formula, periodic, parameters });
  if (isEquations(given)) return equationsCode(given);
  const { variables, names } = readFormula({ formula, kind, coordinates });
  const program = parseFormula(formula, variables, names);
  const values = new Map(names.map((name) => [name, Object.hasOwn(parameters, name) ? parameters[name] : 1]));
  const trial = new FormulaTrial(program, values);
  return { ...(kind === "body" ? bodyCode : planeCode)(program, names, trial, variables), coordinates: kind === "body" ? ["a1", "a2", "b1", "b2"] : variables };
}

function planeCode(program, names, trial, variables) {
  const graph = new Expressions(), q = variables.map((name) => graph.name(`.${name}`));
  const outside = new Map(names.map((name) => [name, graph.name(name)]));
  variables.forEach((name, i) => outside.set(name, q[i]));
  const texts = new Map([...names.map((name) => [name, `$${name}`]), ...variables.map((name, i) => [`.${name}`, `q${i}`])]);
  texts.set(" d0", "d0").set(" d1", "d1");
  const V = graph.of(program, outside, GRAMMAR_CONSTANTS);
  trial.realSomewhere(() => new Map(variables.map((name) => [name, 3*trial.random() - 1.5])), "|q| < 1.5");
  const slopes = variables.map((name) => graph.slope(V, `.${name}`)), d = [graph.name(" d0"), graph.name(" d1")];
  const changes = slopes.map((part) => variables.map((name, j) => graph.product(graph.slope(part, `.${name}`), d[j])).reduce((a, b) => graph.sum(a, b)));
  const points = Array.from({ length: 200 }, () => new Map(variables.map((name) => [`.${name}`, 1.5*trial.normal()])));
  const walls = wallsOf(graph, V, points, trial.values);
  const print = (roots) => graph.printed(roots, texts, "k$");
  const methods = {
    velocity: { lines: [], results: ["p0", "p1"] }, kinetic: { lines: [], results: ["((p0*p0 + p1*p1)/2)"] },
    force: print(slopes.map((part) => graph.negative(part))), tangent: print(changes.map((part) => graph.negative(part))),
    potential: print([V]), margin: least(print(walls)),
    signals: { lines: [], results: ["q0", "0", "p0", "0", "q1", "0", "p1", "0"] },
  };
  return { kind: "plane", n: 2, parameters: names, angles: variables, methods };
}

/** A formula at random points, its parameters as given. */
class FormulaTrial {
  constructor(program, values) { this.program = program; this.values = values; this.seed = 12345; }

  /** A number from 0 to 1, the same ones each time. Park & Miller 1988. */
  random() { this.seed = this.seed*48271 % 2147483647; return this.seed/2147483647; }

  normal() { return Math.sqrt(-2*Math.log(this.random()))*Math.cos(2*Math.PI*this.random()); }

  value(point) { return valueOf(this.program, (name) => point.get(name) ?? this.values.get(name)); }

  at(alpha, beta, eta = 0, gamma = 0) {
    const w = Math.SQRT1_2, r = alpha*alpha + beta*beta;
    const [a1, a2] = [Math.abs(alpha)*Math.cos(eta), Math.abs(alpha)*Math.sin(eta)];
    const [b1, b2] = [Math.abs(beta)*Math.cos(gamma), Math.abs(beta)*Math.sin(gamma)];
    return this.value(new Map(Object.entries({
      D1: w*(alpha + beta), D2: w*(alpha - beta), alpha, beta, r, rho: Math.sqrt(r), vartheta: 2*Math.atan(beta/alpha),
      x: w*(a1 + b1), u: w*(a1 - b1), z: w*(a2 + b2), y: w*(b2 - a2), a1, a2, b1, b2,
    })));
  }

  realSomewhere(point, where) {
    for (let k = 0; k < 20*TRIALS; k++) if (Number.isFinite(this.value(point()))) return;
    throw refused(`formula: it has no finite real value at any of ${20*TRIALS} points with ${where}`);
  }

  /** Whether two functions of a random alpha, beta have the same value wherever both are finite. */
  same(one, other) {
    let tried = 0;
    for (let k = 0; k < 20*TRIALS && tried < TRIALS; k++) {
      const alpha = 0.9 + 1.2*this.random(), beta = 0.05 + 0.8*this.random(), a = one(alpha, beta), b = other(alpha, beta);
      if (!Number.isFinite(a) && !Number.isFinite(b)) continue;
      if (!(Math.abs(a - b) <= SAME_VALUE*(1 + Math.abs(a) + Math.abs(b)))) return { same: false, tried, alpha, beta, a, b };
      tried++;
    }
    return { same: true, tried };
  }

  /** Refuse what is no function of alpha and beta that D1 <-> D2 leaves as it is. */
  checkBody() {
    const angles = () => 6*this.random(), turn = [angles(), angles()];
    const mirrored = this.same((a, b) => this.at(a, b, ...turn), (a, b) => this.at(a, -b, ...turn));
    if (!mirrored.tried && mirrored.same) throw refused(`formula: it has no finite real value at any of ${20*TRIALS} points with D1 > D2 > 0`);
    if (!mirrored.same) {
      throw refused("formula: it is not symmetric under D1 <-> D2 (beta -> -beta, vartheta -> -vartheta), which name the same matrix");
    }
    if (!this.program.names.some((name) => TURNED.includes(name))) return;
    if (!this.same((a, b) => this.at(a, b, angles(), angles()), (a, b) => this.at(a, b, angles(), angles())).same) {
      throw refused("formula: turning a and b separately changes it, so there are no sections of a body with conserved p_eta and p_gamma; "
        + "fastaff.affine_body in Python integrates it");
    }
  }
}

function bodyCode(program, names, trial) {
  trial.checkBody();
  const graph = new Expressions(), alpha = graph.name(".alpha"), beta = graph.name(".beta");
  const g = graph.of(program, bodyNames(graph, alpha, beta, names), GRAMMAR_CONSTANTS);
  const even = trial.same((a, b) => trial.at(a, b), (a, b) => trial.at(-a, b)).same;
  const smooth = smoothOnAxis(trial);
  const points = Array.from({ length: 200 }, () => {
    const size = 0.2 + 2.8*trial.random();
    return new Map([[".alpha", size], [".beta", size*trial.random()]]);
  });
  const walls = wallsOf(graph, g, points, trial.values);
  if (!even) walls.push(alpha);
  const texts = new Map([...names.map((name) => [name, `$${name}`]), [".alpha", "alpha"], [".beta", "beta"]]);
  const squares = "const A = q0*q0 + q1*q1, B = q2*q2 + q3*q3;", roots = "const alpha = Math.sqrt(A), beta = Math.sqrt(B);";
  const kept = even ? `const alpha = Math.sqrt(Math.max(A, ${ON_AXIS})), beta = Math.sqrt(B);` : roots;
  const value = graph.printed([g], texts, "k$"), inside = least(graph.printed(walls, texts, "k$"));
  const slopes = slopeLines(graph, g, texts, smooth, even, false), bends = slopeLines(graph, g, texts, smooth, even, true);
  const along = "const dA = 2*(q0*d0 + q1*d1), dB = 2*(q2*d2 + q3*d3), c$0 = VAA*dA + VAB*dB, c$1 = VAB*dA + VBB*dB;";
  const methods = {
    velocity: { lines: ["const w$0 = 1/$mu;"], results: ["(w$0*p0)", "(w$0*p1)", "(w$0*p2)", "(w$0*p3)"] },
    kinetic: { lines: [], results: ["((p0*p0 + p1*p1 + p2*p2 + p3*p3)/(2*$mu))"] },
    force: { lines: [squares, kept, ...slopes], results: ["(-2*VA*q0)", "(-2*VA*q1)", "(-2*VB*q2)", "(-2*VB*q3)"] },
    tangent: {
      lines: [squares, kept, ...bends, along],
      results: ["(-2*(c$0*q0 + VA*d0))", "(-2*(c$0*q1 + VA*d1))", "(-2*(c$1*q2 + VB*d2))", "(-2*(c$1*q3 + VB*d3))"],
    },
    potential: { lines: [squares, roots, ...value.lines], results: value.results },
    margin: { lines: [squares, roots, ...inside.lines], results: inside.results },
    V: { lines: [roots, ...value.lines], results: value.results }, inside: { lines: [roots, ...inside.lines], results: inside.results },
    signals: {
      lines: [squares, "const s$0 = q0*p0 + q1*p1, s$1 = q2*p2 + q3*p3;"],
      results: ["(A - B)", "0", "(s$0 - s$1)", "0", "(A + B)", "0", "(s$0 + s$1)", "0", "q0", "q1", "p0", "p1", "q2", "q3", "p2", "p3"],
    },
  };
  return { kind: "body", n: 4, parameters: [...names, "mu"], angles: ["area", "r", "eta", "gamma"], methods };
}

/** The variables of a body at eta = gamma = 0, where an isotropic formula has all its values. */
function bodyNames(graph, alpha, beta, names) {
  const w = graph.number(Math.SQRT1_2), two = graph.number(2), zero = graph.number(0);
  const r = graph.sum(graph.power(alpha, two), graph.power(beta, two));
  const D1 = graph.product(w, graph.sum(alpha, beta)), D2 = graph.product(w, graph.difference(alpha, beta));
  const vartheta = graph.product(two, graph.call("atan", graph.quotient(beta, alpha)));
  return new Map([
    ...names.map((name) => [name, graph.name(name)]), ["alpha", alpha], ["beta", beta], ["r", r], ["D1", D1], ["D2", D2], ["x", D1], ["u", D2],
    ["y", zero], ["z", zero], ["a1", alpha], ["a2", zero], ["b1", beta], ["b2", zero],
    ["rho", graph.power(r, graph.number(0.5))], ["vartheta", vartheta],
  ]);
}

/** Whether the formula is finite on the axis beta = 0; refuses one that is 0/0 there. */
function smoothOnAxis(trial) {
  let finite = 0, removable = 0;
  for (let k = 0; k < TRIALS; k++) {
    const alpha = 0.9 + 1.2*trial.random(), on = trial.at(alpha, 0), near = trial.at(alpha, 1e-5), off = trial.at(alpha, 1e-3);
    if (Number.isFinite(on)) finite++;
    else if (Math.abs(near - off) <= 1e-3*(Math.abs(near) + Math.abs(off))) removable++;
  }
  if (!finite && removable) throw refused("formula: it is 0/0 at beta = 0, though it has a limit there; fastaff.affine_body in Python takes it");
  return finite > 0;
}

/**
 * Lines that set VA, VB, and VAA, VAB, VBB where `second`. For beta below alpha/64 the derivatives by B are integrals over
 * t from 0 to 1 of g''(t beta)/2 and (1 - t^2) g''''(t beta)/8, by Gauss's rule, as in formulas/potential_source.py.
 */
function slopeLines(graph, g, texts, smooth, even, second) {
  const ga = graph.slope(g, ".alpha"), gb = graph.slope(g, ".beta"), gaa = graph.slope(ga, ".alpha");
  const gab = graph.slope(ga, ".beta"), gbb = graph.slope(gb, ".beta");
  const set = second ? "let VA, VB, VAA, VAB, VBB;" : "let VA, VB;";
  const far = graph.printed(second ? [ga, gb, gaa, gab, gbb] : [ga, gb], texts, "k$");
  const [a, b, aa, ab, bb] = far.results;
  const beyond = [...far.lines, `VA = ${a}/(2*alpha); VB = ${b}/(2*beta);`];
  if (second) {
    beyond.push(`VAA = (${aa} - ${a}/alpha)/(4*alpha*alpha); VAB = ${ab}/(4*alpha*beta); VBB = (${bb} - ${b}/beta)/(4*beta*beta);`);
  }
  if (!smooth) return [set, ...beyond];
  const own = graph.printed(second ? [ga, gaa] : [ga], texts, "k$");
  const near = [...own.lines, `VA = ${own.results[0]}/(2*alpha); VB = 0;`];
  if (second) near.push(`VAA = (${own.results[1]} - ${own.results[0]}/alpha)/(4*alpha*alpha); VAB = 0; VBB = 0;`);
  const inner = new Map(texts).set(".beta", "b$0");
  const roots = second ? [gbb, graph.slope(gbb, ".alpha"), graph.slope(graph.slope(gbb, ".beta"), ".beta")] : [gbb];
  const node = graph.printed(roots, inner, "n$");
  for (const [t, w] of GAUSS) {
    const terms = [`VB += ${w/2}*${node.results[0]};`];
    if (second) terms.push(`VAB += ${w/4}*${node.results[1]}/alpha; VBB += ${w*(1 - t*t)/8}*${node.results[2]};`);
    near.push(`{ const b$0 = ${t}*beta; ${node.lines.join(" ")} ${terms.join(" ")} }`);
  }
  return [set, `if (beta >= ${even ? "(alpha + 0.25)/64" : "alpha/64"}) {`, ...beyond, "} else {", ...near, "}"];
}
