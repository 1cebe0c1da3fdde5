// The text of a map's functions, written out of its methods in q0, ..., p0, ..., d0, ... and the parameters $name.

const HALF_EVEN = 6755399441055744; // 1.5*2^52: adding and taking it away rounds to the nearest whole number, as rint

/** Return the text that defines `compiledSystem` of a map; constants: the line that reads its parameters from P. */
export function mapText(code, constants) {
  const { n, methods, winds } = code, rows = Array.from({ length: 2*n }, (_, r) => r);
  const name = (r) => (r < n ? `q${r}` : `p${r - n}`), wound = rows.filter((r) => winds[r]);
  const load = (array, stem = name) => rows.map((r) => `let ${stem(r)} = ${array}[${r}];`).join(" ");
  const body = (key) => methods[key].lines.join("\n      ");
  const vector = (r) => `d${r}`;
  const written = (key) => `${body(key)} ${rows.map((r) => `out[${r}] = ${methods[key].results[r]};`).join(" ")}`;
  const winding = wound.filter((r) => r < n).map((r) => `out[at++] = (n${r} - ${name(r)})*turns${r};`).join(" ");
  const taken = rows.map((r) => `${name(r)} = ${winds[r] ? `n${r} - period${r}*((n${r}*turns${r} + ${HALF_EVEN}) - ${HALF_EVEN})` : `n${r}`};`);
  const periods = `const periods = this.periods(P); ${wound.map((r) => `const period${r} = periods[${r}], turns${r} = 1/period${r};`).join(" ")}`;
  const image = hoisted(methods.iterate), slope = hoisted(renamed(methods.tangent));
  const set = (part, stem) => `${part.lines.join(" ")} ${rows.map((r) => `const ${stem}${r} = ${part.results[r]};`).join(" ")}`;
  return `const compiledSystem = {
  n: ${n}, kind: "map", parameters: ${JSON.stringify(code.parameters)}, angles: ${JSON.stringify(code.angles)},
  winds: ${JSON.stringify(winds)}, hasTangent: true, line: ${Boolean(code.line)},
  periods(P) {
    ${constants}
    ${body("periods")}
    return [${methods.periods.results.join(", ")}];
  },
  margin(z, P) {
    ${constants} ${load("z")}
    ${body("margin")}
    return ${methods.margin.results[0]};
  },
  iterate(z, P, out) {
    ${constants} ${load("z")}
    ${written("iterate")}
  },
  tangent(z, w, P, out) {
    ${constants} ${load("z")} ${load("w", vector)}
    ${written("tangent")}
  },
  iterates(z, w, P, count, out) {
    ${constants} ${load("z")} ${load("w", vector)} ${periods}
    ${[...image.once, ...slope.once].join("\n    ")}
    let taken = 0, at = 0, inside = true;
    while (taken < count && inside) {
      { ${set(slope, "n")} ${rows.map((r) => `d${r} = n${r};`).join(" ")} }
      { ${set(image, "n")} ${winding} ${taken.join(" ")} }
      ${rows.map((r) => `out[at++] = ${name(r)};`).join(" ")}
      taken++;
      { ${body("margin")} inside = ${methods.margin.results[0]} > 0; }
    }
    ${rows.map((r) => `z[${r}] = ${name(r)}; w[${r}] = d${r};`).join(" ")}
    return taken;
  }
};
`;
}

/** A method whose own names are others than those of a second one beside it. */
function renamed({ lines, results }) {
  const other = (text) => text.replace(/([A-Za-z_]\w*)\$(\d+)/g, "$1$$t$2");
  return { lines: lines.map(other), results: results.map(other) };
}

/** A method without the lines that know nothing of the state, which stand in `once`. */
function hoisted({ lines, results }) {
  const moving = new Set(), once = [], kept = [];
  for (const line of lines) {
    const [, name, value] = /^const ([\w$]+) = (.*);$/.exec(line) ?? [];
    const names = (value ?? line).match(/[A-Za-z_$][\w$]*/g) ?? [];
    if (name !== undefined && !names.some((one) => /^[qpd]\d+$/.test(one) || moving.has(one))) { once.push(line); continue; }
    for (const one of name === undefined ? names : [name]) moving.add(one);
    kept.push(line);
  }
  return { lines: kept, results, once };
}
