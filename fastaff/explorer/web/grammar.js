// The grammar of formulas, as formulas/grammar.py: a whitelist, turned into a postfix program. Nothing is ever executed.

import { GRAMMAR } from "./tables.js";

export const GRAMMAR_FUNCTIONS = GRAMMAR.functions;
export const GRAMMAR_CONSTANTS = new Map(Object.entries(GRAMMAR.constants));
export const RESERVED_NAMES = new Set(GRAMMAR.reserved);
const ALPHABET = new Set(GRAMMAR.letters), PYTHON_WORDS = new Set(GRAMMAR.keywords);
const [SIGNS, SPELLINGS, ADVICE] = [GRAMMAR.signs, GRAMMAR.spellings, GRAMMAR.advice].map((table) => new Map(Object.entries(table)));
const WORDS_FOUND = new Map([
  ["if", "a condition"], ["else", "a condition"], ["and", "a logical operator"], ["or", "a logical operator"], ["not", "a logical operator"],
  ["in", "a comparison"], ["is", "a comparison"], ["await", "await"], ["yield", "yield"], ["for", "a comprehension"],
]);
const CALLS_OF_NUMBERS = new Map(GRAMMAR_FUNCTIONS.map((name) => [name, Math[name]]));

/** The error of a formula: what was found, where, and what is allowed. */
function formulaError(message) { return Object.assign(new Error(message), { what: "formula" }); }

/** Whether a name can be a parameter's or a coordinate's; throws the sentence that says why not. */
export function checkedName(name, what, taken) {
  if (!/^[A-Za-z][A-Za-z0-9_]{0,39}$/.test(name) || PYTHON_WORDS.has(name)) {
    throw formulaError(`${what} must be an identifier of at most 40 ASCII letters, digits and _, starting with a letter, got '${name}'`);
  }
  if (GRAMMAR_FUNCTIONS.includes(name) || GRAMMAR_CONSTANTS.has(name) || ADVICE.has(name)) {
    throw formulaError(`${what} '${name}' is the name of a function or constant of the grammar. Use another name.`);
  }
  if (taken.has(name)) {
    throw formulaError(`${what} '${name}' is taken by a variable or a part of the model. Use another name.`);
  }
  return name;
}

/** The names in a text that are neither variables nor functions nor constants: its parameters, in order. */
export function parametersOf(text, variables, taken = RESERVED_NAMES) {
  const reader = new FormulaReader(text, variables, null, "formula");
  const names = reader.program().names.filter((name) => !variables.includes(name) && !GRAMMAR_CONSTANTS.has(name));
  for (const name of names) checkedName(name, "parameter", taken);
  return names;
}

/** The program of a text whose names are variables and parameters: {operations: [[kind, operand], ...], names}. */
export function parseFormula(text, variables, parameters, argument = "formula") {
  return new FormulaReader(text, variables, parameters, argument).program();
}

class FormulaReader {
  constructor(text, variables, parameters, argument) {
    Object.assign(this, { text, variables, parameters, argument, at: 0, tokens: [] });
    if (typeof text !== "string") throw formulaError(`${argument} must be a text such as 'C/2*(x**2 + y**2)'`);
  }

  refuse(found, column, hint = "") {
    return formulaError(`${this.argument}: ${found} at column ${column}. ${hint || GRAMMAR.allowed}`);
  }

  program() {
    this.checkLetters();
    this.tokens = this.scanned();
    const root = this.sum();
    if (this.kind() !== "end") throw this.unexpected();
    const operations = this.postfix(root);
    this.checkSizes(operations);
    const names = [...new Set(operations.filter(([kind]) => kind === "name").map(([, operand]) => operand))];
    return { operations: operations.map(([kind, operand]) => [kind, operand]), names };
  }

  checkLetters() {
    const letters = [...this.text];
    if (letters.length > GRAMMAR.limits.length) throw formulaError(`${this.argument} must have at most ${GRAMMAR.limits.length} characters, got ${letters.length}`);
    if (!this.text.trim()) throw formulaError(`${this.argument} must be a formula, got an empty text. ${GRAMMAR.allowed}`);
    let depth = 0;
    letters.forEach((letter, index) => {
      const column = index + 1;
      if (!ALPHABET.has(letter)) {
        const found = SIGNS.get(letter) ?? `the character '${letter}'`;
        throw this.refuse(found, column, SPELLINGS.has(letter) ? `Use ${SPELLINGS.get(letter)}.` : "");
      }
      depth += (letter === "(") - (letter === ")");
      if (depth < 0) throw this.refuse("a closing parenthesis without an opening one", column);
      if (depth > GRAMMAR.limits.depth) throw this.refuse(`parentheses nested deeper than ${GRAMMAR.limits.depth}`, column);
    });
    if (depth > 0) throw this.refuse("not one expression, '(' was never closed", this.text.lastIndexOf("(") + 1);
  }

  /** Tokens {kind, text, column, end}: number, name, a sign, end. */
  scanned() {
    const found = [], pattern = /[ \t\n\r]+|(0[xX](?:_?[0-9a-fA-F])+|0[oO](?:_?[0-7])+|0[bB](?:_?[01])+|(?:\d(?:_?\d)*\.?(?:\d(?:_?\d)*)?|\.\d(?:_?\d)*)(?:[eE][+-]?\d(?:_?\d)*)?)|([A-Za-z_]\w*)|(\*\*|\/\/|[-+*/(),.^])/y;
    while (pattern.lastIndex < this.text.length) {
      const column = pattern.lastIndex + 1, match = pattern.exec(this.text);
      if (!match) throw this.refuse("not one expression, invalid syntax", column);
      const [text, number, name, sign] = match;
      if (number !== undefined) this.checkLiteral(number, column);
      if (number ?? name ?? sign) {
        const kind = number !== undefined ? "number" : name !== undefined ? "name" : sign === "^" ? "**" : sign;
        found.push({ kind, text, column, end: column + text.length });
      }
    }
    found.push({ kind: "end", text: "", column: this.text.length, end: this.text.length });
    return found;
  }

  /** Refuse a number that runs into a word, an imaginary one, or one that begins with 0. */
  checkLiteral(number, column) {
    const next = this.text[column - 1 + number.length] ?? "";
    if (/[jJ]/.test(next) && !/\w/.test(this.text[column + number.length] ?? "")) throw this.refuse("an imaginary number", column);
    if (/\w/.test(next)) throw this.refuse("not one expression, invalid decimal literal", column, "Use * for a product.");
    if (/^0[0-9_]*[1-9]/.test(number) && /^[0-9_]+$/.test(number)) {
      throw this.refuse("not one expression, leading zeros in decimal integer literals are not permitted", column);
    }
  }

  kind() { return this.tokens[this.at].kind; }

  take() { return this.tokens[this.at++]; }

  unexpected() {
    const token = this.tokens[this.at];
    if (token.kind === "name" && WORDS_FOUND.has(token.text)) return this.refuse(WORDS_FOUND.get(token.text), token.column);
    if (token.kind === ",") return this.refuse("a comma", token.column);
    if (token.kind === ".") return this.refuse("attribute access", token.column);
    const product = token.kind === "name" || token.kind === "number" ? "Use * for a product." : "";
    return this.refuse("not one expression, invalid syntax", token.column, product);
  }

  /** Sums and products are chains, read without recursion. */
  chain(signs, next) {
    let left = next.call(this);
    while (signs.includes(this.kind())) {
      const sign = this.take();
      if (sign.kind === "//") throw this.refuse("the operator //", sign.column);
      const right = next.call(this);
      left = { type: "binary", kind: sign.kind, left, right, column: left.column, between: sign.column };
    }
    return left;
  }

  sum() { return this.chain(["+", "-"], this.product); }

  product() { return this.chain(["*", "/", "//"], this.signed); }

  signed() {
    const signs = [];
    while (this.kind() === "+" || this.kind() === "-") signs.push(this.take());
    let node = this.power();
    for (const sign of signs.reverse()) node = { type: "sign", kind: sign.kind, operand: node, column: sign.column };
    return node;
  }

  power() {
    const base = this.called();
    if (this.kind() !== "**") return base;
    const sign = this.take(), exponent = this.signed();
    let tower = exponent;
    while (tower.type === "sign" && !tower.inParentheses) tower = tower.operand;
    if (tower.kind === "**" && !tower.inParentheses && this.text.includes("^")) {
      throw this.refuse("a power of a power", sign.column, "Use parentheses with ^: x^(y^z).");
    }
    return { type: "binary", kind: "**", left: base, right: exponent, column: base.column, between: sign.column };
  }

  called() {
    let node = this.atom();
    while (this.kind() === "(" || this.kind() === ".") {
      if (this.kind() === ".") throw this.refuse("attribute access", node.column);
      this.take();
      const args = [];
      while (this.kind() !== ")") {
        if (this.kind() === "*" || this.kind() === "**") throw this.refuse("a star", this.tokens[this.at].column);
        args.push(this.sum());
        if (this.kind() === ",") this.take(); else break;
      }
      if (this.kind() !== ")") throw this.unexpected();
      this.take();
      node = { type: "call", called: node, args, column: node.column };
    }
    return node;
  }

  atom() {
    const token = this.tokens[this.at];
    if (token.kind === "number") { this.at++; return { type: "number", text: token.text, column: token.column }; }
    if (token.kind === "name" && !(PYTHON_WORDS.has(token.text) && !["True", "False", "None"].includes(token.text))) {
      this.at++;
      return { type: "name", name: token.text, column: token.column };
    }
    if (token.kind !== "(") throw this.unexpected();
    this.take();
    if (this.kind() === ")") throw this.refuse("a comma", token.column);
    const inner = this.sum();
    if (this.kind() !== ")") throw this.unexpected();
    this.take();
    return { ...inner, inParentheses: true };
  }

  /** Operations [kind, operand, column] in postfix order, without recursion; refuses what is outside of the grammar. */
  postfix(root) {
    const done = [], pending = [{ node: root, depth: 0 }], isChain = (node) => node.type === "binary" && node.kind !== "**";
    let count = 0;
    while (pending.length) {
      const { node, depth, ready } = pending.pop();
      if (ready) { done.push(ready); continue; }
      if (++count > GRAMMAR.limits.nodes) throw this.refuse(`a formula of more than ${GRAMMAR.limits.nodes} parts`, node.column);
      if (depth > GRAMMAR.limits.depth) throw this.refuse(`an expression nested deeper than ${GRAMMAR.limits.depth}`, node.column);
      if (node.type === "binary") {
        pending.push({ ready: [node.kind, null, node.between] }, { node: node.right, depth: depth + 1 },
          { node: node.left, depth: isChain(node) && isChain(node.left) ? depth : depth + 1 });
      } else if (node.type === "sign") {
        if (node.kind === "-") pending.push({ ready: ["negate", null, node.column] });
        pending.push({ node: node.operand, depth: depth + 1 });
      } else if (node.type === "call") {
        pending.push({ ready: ["call", this.calledName(node), node.column] }, { node: node.args[0], depth: depth + 1 });
      } else if (node.type === "number") {
        done.push(["number", this.number(node), node.column]);
      } else done.push(["name", this.name(node), node.column]);
    }
    return done;
  }

  isKnown(name) {
    return GRAMMAR_CONSTANTS.has(name) || this.variables.includes(name) || Boolean(this.parameters?.includes(name));
  }

  calledName({ called, args, column }) {
    if (called.type !== "name") {
      throw this.refuse(`a call of ${called.type === "call" ? "something that is no function" : "something that is no function"}`, column, "Use * for a product.");
    }
    const { name } = called;
    if (this.isKnown(name)) throw this.refuse(`a call of ${name}`, column, `Use ${name}*(...) for a product.`);
    if (!GRAMMAR_FUNCTIONS.includes(name)) throw this.refuse(`a call of '${name}'`, column, ADVICE.get(name) ?? similar(name, GRAMMAR_FUNCTIONS));
    if (args.length !== 1) throw this.refuse(`${name} with ${args.length} arguments`, column, "Functions have one argument.");
    return name;
  }

  number({ text, column }) {
    const value = Number(text.replaceAll("_", ""));
    const zero = value === 0 && /[1-9]/.test(text.toLowerCase().split("e")[0]);
    if (!Number.isFinite(value) || zero) {
      throw this.refuse(`the number ${text.slice(0, 30)}`, column, "Use numbers within the range of floats.");
    }
    return value;
  }

  name({ name, column }) {
    if (["True", "False", "None"].includes(name)) throw this.refuse(name, column);
    if (GRAMMAR_FUNCTIONS.includes(name)) throw this.refuse(`${name} without an argument`, column, `Use ${name}(...).`);
    if (this.isKnown(name)) return name;
    if (this.parameters === null) return name;
    const known = [...this.variables, ...this.parameters, ...GRAMMAR_CONSTANTS.keys()];
    const hint = similar(name, [...known, ...GRAMMAR_FUNCTIONS]) || `Give a parameter its value, ${name}=1.0.`;
    throw formulaError(`${this.argument}: unknown name '${name}' at column ${column}. ${hint} Known names: ${known.slice(0, 8).join(", ")}${known.length > 8 ? ", ..." : ""}.`);
  }

  /** Refuse constants without a finite real value, and powers of a size that no formula has. */
  checkSizes(operations) {
    const stack = [];
    for (const [kind, operand, column] of operations) {
      let entry;
      if (kind === "number") entry = [operand, 1];
      else if (kind === "name") entry = [GRAMMAR_CONSTANTS.get(operand) ?? null, 1];
      else if (kind === "call" || kind === "negate") {
        const [value, power] = stack.pop();
        entry = [value === null ? null : kind === "negate" ? -value : CALLS_OF_NUMBERS.get(operand)(value), power];
      } else {
        const right = stack.pop(), left = stack.pop();
        entry = this.combined(kind, left, right, column);
      }
      if (entry[0] !== null && !Number.isFinite(entry[0])) {
        throw this.refuse(`a constant without a finite real value (${kind === "call" ? operand : kind})`, column);
      }
      stack.push(entry);
    }
  }

  combined(kind, [left, leftPower], [right, rightPower], column) {
    const both = left !== null && right !== null, most = Math.max(leftPower, rightPower);
    if (kind !== "**") {
      if (kind === "/" && right === 0) return [NaN, 1];
      return [both ? arithmetic(kind, left, right) : null, most];
    }
    if (right === null) {
      if (left !== null && left <= 0) throw this.refuse("a power of a number that is not positive", column, "Use a constant exponent.");
      return [null, most];
    }
    if (Math.abs(right) > GRAMMAR.limits.exponent) {
      throw this.refuse(`the exponent ${general(right)}`, column, `Use numeric exponents up to ${GRAMMAR.limits.exponent}.`);
    }
    if (both) {
      const value = left**right;
      return [value === 0 && left !== 0 ? NaN : value, 1];
    }
    const power = leftPower*Math.max(1, Math.abs(right));
    if (power > GRAMMAR.limits.exponent) throw this.refuse(`powers of powers up to ${general(power)}`, column, `Use products of exponents up to ${GRAMMAR.limits.exponent}.`);
    return [null, power];
  }
}

function arithmetic(kind, left, right) {
  if (kind === "+") return left + right;
  if (kind === "-") return left - right;
  return kind === "*" ? left*right : left/right;
}

/** A number with six digits, as Python's format g. */
function general(x) {
  const text = String(Number(x.toPrecision(6)));
  return /e[+-]\d$/.test(text) ? text.replace(/e([+-])/, "e$10") : text;
}

/** A "Did you mean" for a name, or nothing: the nearest of known names by Ratcliff and Obershelp's ratio. */
function similar(name, known) {
  let best = null, most = name.length < 3 ? 0.5 : 0.6;
  for (const other of known) {
    const ratio = 2*matches(other, name)/(name.length + other.length);
    if (ratio > most || (ratio === most && (best === null || other > best))) { best = other; most = ratio; }
  }
  best ??= known.find((other) => other.toLowerCase() === name.toLowerCase()) ?? null;
  return best === null ? "" : `Did you mean ${best}?`;
}

function matches(a, b) {
  let size = 0, i = 0, j = 0;
  for (let p = 0; p < a.length; p++) {
    for (let q = 0; q < b.length; q++) {
      let k = 0;
      while (p + k < a.length && q + k < b.length && a[p + k] === b[q + k]) k++;
      if (k > size) { size = k; i = p; j = q; }
    }
  }
  return size ? size + matches(a.slice(0, i), b.slice(0, j)) + matches(a.slice(i + size), b.slice(j + size)) : 0;
}

/** The value of a program, names by a function. */
export function valueOf({ operations }, valueOfName) {
  const stack = [];
  for (const [kind, operand] of operations) {
    if (kind === "number") stack.push(operand);
    else if (kind === "name") stack.push(GRAMMAR_CONSTANTS.get(operand) ?? valueOfName(operand));
    else if (kind === "call") stack.push(CALLS_OF_NUMBERS.get(operand)(stack.pop()));
    else if (kind === "negate") stack.push(-stack.pop());
    else {
      const right = stack.pop(), left = stack.pop();
      stack.push(kind === "**" ? left**right : arithmetic(kind, left, right));
    }
  }
  return stack.pop();
}
