// Expressions as a graph in which equal parts are one: built from a program, differentiated exactly, printed as JavaScript.

const MOST_PARTS = 30000;

/** Expressions of one formula. A part is {id, kind, ...}: number, name, sum, product, power, call. */
export class Expressions {
  constructor() { this.known = new Map(); this.slopes = new Map(); }

  part(kind, ...entries) {
    const key = `${kind} ${entries.map((e) => (typeof e === "object" ? `#${e.id}` : e)).join(" ")}`;
    let found = this.known.get(key);
    if (!found) {
      if (this.known.size >= MOST_PARTS) {
        throw Object.assign(new Error("formula: its derivatives are too long for the page; fastaff.affine_body in Python takes it"), { what: "formula" });
      }
      found = { id: this.known.size, kind, entries };
      this.known.set(key, found);
    }
    return found;
  }

  number(value) { return this.part("number", Object.is(value, -0) ? 0 : value); }

  name(name) { return this.part("name", name); }

  sum(a, b) {
    if (a.kind === "number" && b.kind === "number") return this.number(a.entries[0] + b.entries[0]);
    if (isNumber(a, 0)) return b;
    if (isNumber(b, 0)) return a;
    if (a === b) return this.product(this.number(2), a);
    return a.id < b.id ? this.part("sum", a, b) : this.part("sum", b, a);
  }

  product(a, b) {
    if (a.kind === "number" && b.kind === "number") return this.number(a.entries[0]*b.entries[0]);
    if (isNumber(a, 0) || isNumber(b, 0)) return this.number(0);
    if (isNumber(a, 1)) return b;
    if (isNumber(b, 1)) return a;
    if (b.kind === "number") return this.product(b, a);
    // Numbers go in front, so that they meet.
    if (a.kind === "number" && b.kind === "product" && b.entries[0].kind === "number") {
      return this.product(this.number(a.entries[0]*b.entries[0].entries[0]), b.entries[1]);
    }
    if (a.kind !== "number" && b.kind === "product" && b.entries[0].kind === "number") return this.product(b.entries[0], this.product(a, b.entries[1]));
    if (a.kind === "product" && a.entries[0].kind === "number") return this.product(a.entries[0], this.product(a.entries[1], b));
    if (a === b) return this.power(a, this.number(2));
    return a.kind === "number" || a.id < b.id ? this.part("product", a, b) : this.part("product", b, a);
  }

  negative(a) { return this.product(this.number(-1), a); }

  difference(a, b) { return this.sum(a, this.negative(b)); }

  quotient(a, b) {
    if (b.kind === "number") return this.product(a, this.number(1/b.entries[0]));
    return this.product(a, this.power(b, this.number(-1)));
  }

  power(a, b) {
    if (isNumber(b, 0)) return this.number(1);
    if (isNumber(b, 1)) return a;
    if (a.kind === "number" && b.kind === "number") return this.number(a.entries[0]**b.entries[0]);
    const whole = (e) => e.kind === "number" && Number.isInteger(e.entries[0]);
    if (a.kind === "power" && whole(b) && whole(a.entries[1])) {
      return this.power(a.entries[0], this.number(a.entries[1].entries[0]*b.entries[0]));
    }
    return this.part("power", a, b);
  }

  call(name, a) { return this.part("call", name, a); }

  /** The expression of a program; names by a map. */
  of(program, names, constants) {
    const stack = [];
    for (const [kind, operand] of program.operations) {
      if (kind === "number") stack.push(this.number(operand));
      else if (kind === "name") stack.push(names.get(operand) ?? this.number(constants.get(operand)));
      else if (kind === "call") {
        const a = stack.pop();
        stack.push(operand === "sqrt" ? this.power(a, this.number(0.5)) : this.call(operand, a));
      } else if (kind === "negate") stack.push(this.negative(stack.pop()));
      else {
        const right = stack.pop(), left = stack.pop();
        const make = { "+": this.sum, "-": this.difference, "*": this.product, "/": this.quotient, "**": this.power }[kind];
        stack.push(make.call(this, left, right));
      }
    }
    return stack.pop();
  }

  /** The derivative of a part by a name. */
  slope(part, name) {
    const key = `${part.id} ${name}`;
    if (!this.slopes.has(key)) this.slopes.set(key, this.derived(part, name));
    return this.slopes.get(key);
  }

  derived(part, name) {
    const { kind, entries } = part, [a, b] = entries;
    if (kind === "number") return this.number(0);
    if (kind === "name") return this.number(a === name ? 1 : 0);
    if (kind === "sum") return this.sum(this.slope(a, name), this.slope(b, name));
    if (kind === "product") return this.sum(this.product(this.slope(a, name), b), this.product(a, this.slope(b, name)));
    if (kind === "call") {
      const inner = this.slope(b, name);
      return isNumber(inner, 0) ? inner : this.product(this.outer(a, b), inner);
    }
    const da = this.slope(a, name), db = this.slope(b, name);
    const base = isNumber(da, 0) ? da : this.product(this.product(b, this.power(a, this.sum(b, this.number(-1)))), da);
    return isNumber(db, 0) ? base : this.sum(base, this.product(this.product(part, this.call("log", a)), db));
  }

  /** The derivative of a function by its argument. */
  outer(name, a) {
    const one = this.number(1), square = (e) => this.power(e, this.number(2));
    switch (name) {
      case "exp": return this.call("exp", a);
      case "log": return this.power(a, this.number(-1));
      case "sin": return this.call("cos", a);
      case "cos": return this.negative(this.call("sin", a));
      case "tan": return this.sum(one, square(this.call("tan", a)));
      case "sinh": return this.call("cosh", a);
      case "cosh": return this.call("sinh", a);
      case "tanh": return this.difference(one, square(this.call("tanh", a)));
      case "asin": return this.power(this.difference(one, square(a)), this.number(-0.5));
      case "acos": return this.negative(this.outer("asin", a));
      default: return this.power(this.sum(one, square(a)), this.number(-1));
    }
  }

  /** All parts of some roots. */
  below(roots) {
    const seen = new Set(), pending = [...roots];
    while (pending.length) {
      const part = pending.pop();
      if (seen.has(part)) continue;
      seen.add(part);
      pending.push(...part.entries.filter((e) => typeof e === "object"));
    }
    return [...seen].sort((a, b) => a.id - b.id);
  }

  /** Lines that name the parts of roots, and the texts of these; names by a map, temporaries begin with `stem`. */
  printed(roots, names, stem) {
    const lines = [], texts = new Map(), uses = new Map(), parts = this.below(roots);
    for (const part of parts) for (const e of part.entries) if (typeof e === "object") uses.set(e, (uses.get(e) ?? 0) + 1);
    for (const root of roots) uses.set(root, (uses.get(root) ?? 0) + 1);
    const text = (part) => texts.get(part);
    const keep = (value) => {
      lines.push(`const ${stem}${lines.length} = ${value};`);
      return `${stem}${lines.length - 1}`;
    };
    for (const part of parts) {
      const [a, b] = part.entries;
      let value;
      if (part.kind === "number") value = a < 0 ? `(${a})` : String(a);
      else if (part.kind === "name") value = names.get(a);
      else if (part.kind === "sum") value = `(${text(a)} + ${text(b)})`;
      else if (part.kind === "product") value = isNumber(a, -1) ? `(-${text(b)})` : `(${text(a)}*${text(b)})`;
      else if (part.kind === "call") value = `Math.${a}(${text(b)})`;
      else value = printedPower(text(a), b.kind === "number" ? b.entries[0] : null, text(b), keep);
      const named = part.kind !== "number" && part.kind !== "name" && (uses.get(part) > 1 || value.length > 200);
      texts.set(part, named ? keep(value) : value);
    }
    return { lines, results: roots.map(text) };
  }
}

function isNumber(part, value) { return part.kind === "number" && part.entries[0] === value; }

/** A power: products of squares for whole exponents, roots for halves. */
function printedPower(base, exponent, text, keep) {
  if (exponent === null || !Number.isInteger(2*exponent)) return `Math.pow(${base}, ${text})`;
  const size = Math.abs(exponent), whole = Math.floor(size), factors = [];
  let square = whole > 1 || size !== whole ? keep(base) : base;
  const root = size === whole ? null : `Math.sqrt(${square})`;
  for (let left = whole, first = true; left > 0; left >>= 1, first = false) {
    if (!first) square = keep(`${square}*${square}`);
    if (left & 1) factors.push(square);
  }
  if (root) factors.push(root);
  const product = factors.join("*");
  return exponent < 0 ? `(1/(${product}))` : `(${product})`;
}
