// The text of the functions of dz/dt = f(z), written out of its methods in q0, q1, ... for all rows, and d0, d1, ...

/** Return the text that defines `compiledSystem`; constants: the line that reads its parameters from P. */
export function equationsText(code, constants) {
  const { rows, methods } = code, all = Array.from({ length: rows }, (_, r) => r);
  const load = (stem, array) => all.map((r) => `const ${stem}${r} = ${array}[${r}];`).join(" ");
  const body = (key) => methods[key].lines.join("\n    ");
  const into = (name, args, lets, key) => `${name}(${args}, P, out) {
    ${constants} ${lets}
    ${body(key)}
    ${methods[key].results.map((result, r) => `out[${r}] = ${result};`).join(" ")}
  }`;
  const one = (name, key) => `${name}(z, P) {
    ${constants} ${key === "period" ? "" : load("q", "z")}
    ${body(key)}
    return ${methods[key].results[0]};
  }`;
  const facts = { n: code.n, rows, kind: code.kind, canonical: code.canonical, driven: code.driven, parameters: code.parameters, angles: code.angles, winds: code.winds };
  const parts = [
    ...Object.entries({ ...facts, hasTangent: true }).map(([key, value]) => `${key}: ${JSON.stringify(value)}`),
    into("rates", "z", load("q", "z"), "rates"), into("tangentRates", "z, w", `${load("q", "z")} ${load("d", "w")}`, "tangent"), one("margin", "margin"),
    `periods(P) { ${constants} ${body("periods")} return [${methods.periods.results.join(", ")}]; }`,
    ...["energy", "period"].filter((key) => methods[key]).map((key) => one(key, key)),
  ];
  return `const compiledSystem = {${parts.join(",\n")}\n};\n`;
}
