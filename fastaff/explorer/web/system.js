// The text of a system's functions, written out of its methods (`explorer/javascript.py` and `grammar.js` print them).
// A method is lines and results in q0, q1, ..., p0, ..., d0, ... and the parameters $name.

import { equationsText } from "./equations_text.js";
import { mapText } from "./map_text.js";

const IDENTIFIER = /^[A-Za-z][A-Za-z0-9_]*$/;

/** Return the text that defines `compiledSystem` in a worker. */
export function systemText(code) {
  const n = code.n, all = Array.from({ length: n }, (_, i) => i), methods = code.methods;
  for (const name of code.parameters) if (!IDENTIFIER.test(name)) throw new Error(`no name of a parameter: ${name}`);
  const constants = code.parameters.map((name, i) => `const $${name} = P[${i}];`).join(" ");
  if (code.kind === "map") return mapText(code, constants);
  if (code.kind === "equations") return equationsText(code, constants);
  const load = (stem, array, first = 0) => all.map((i) => `let ${stem}${i} = ${array}[${first + i}];`).join(" ");
  const store = (stem, array, first = 0) => all.map((i) => `${array}[${first + i}] = ${stem}${i};`).join(" ");
  const bound = (stem, of) => `const ${all.map((i) => `${stem}${i} = ${of}${i}`).join(", ")};`;
  const body = (name) => methods[name].lines.join("\n      ");
  const added = (name, target) => methods[name].results.map((r, i) => `${target}${i} += c*${r};`).join(" ");
  const drift = (of, target) => `{ ${bound("p", of)} ${body("velocity")} ${added("velocity", target)} }`;
  // The time goes on alike beside a driven orbit: a tangent vector has none of it.
  const still = methods.velocity.results.map((r, i) => (code.kind === "driven" && i === n - 1 ? "0" : r));
  const slide = `{ ${bound("p", "w")} ${body("velocity")} ${still.map((r, i) => `v${i} += c*${r};`).join(" ")} }`;
  const kick = `{ ${bound("q", "x")} ${body("force")} ${added("force", "y")} }`;
  const pull = methods.tangent &&
    `{ ${bound("q", "x")} ${bound("d", "v")} ${body("tangent")} ${added("tangent", "w")} }`;

  const march = (name, args, before, drifts, kicks, after) => `
  ${name}(${args}, P, a, b, h, count) {
    ${constants}
    ${before}
    const stages = b.length;
    for (let step = 0; step < count; step++) {
      for (let s = 0; s < stages; s++) {
        let c = a[s]*h;
        ${drifts}
        c = b[s]*h;
        ${kicks}
      }
      const c = a[stages]*h;
      ${drifts}
    }
    ${after}
  }`;
  const number = (name, args, lets, key) => `
  ${name}(${args}, P) {
    ${constants} ${lets}
    ${body(key)}
    return ${methods[key].results[0]};
  }`;
  const numbers = (name, key, lets) => `
  ${name}(z, P, out) {
    ${constants} ${lets}
    ${body(key)}
    ${methods[key].results.map((r, i) => `out[${i}] = ${r};`).join(" ")}
  }`;
  const q = load("q", "z"), p = load("p", "z", n);
  const parts = [
    `n: ${n}`, `kind: ${JSON.stringify(code.kind)}`, `parameters: ${JSON.stringify(code.parameters)}`,
    `angles: ${JSON.stringify(code.angles)}`, `hasTangent: ${Boolean(pull)}`,
    march("march", "z", `${load("x", "z")} ${load("y", "z", n)}`, drift("y", "x"), kick,
      `${store("x", "z")} ${store("y", "z", n)}`),
    numbers("velocity", "velocity", p), numbers("force", "force", q),
    number("kinetic", "z", p, "kinetic"), number("potential", "z", q, "potential"),
    number("margin", "z", q, "margin"), numbers("signals", "signals", q + p),
  ];
  if (pull) {
    parts.push(march("marchTangent", "z, u",
      `${load("x", "z")} ${load("y", "z", n)} ${load("v", "u")} ${load("w", "u", n)}`,
      `${drift("y", "x")} ${slide}`, `${pull} ${kick}`,
      `${store("x", "z")} ${store("y", "z", n)} ${store("v", "u")} ${store("w", "u", n)}`));
    parts.push(numbers("tangent", "tangent", `${q} ${all.map((i) => `const d${i} = z[${n + i}];`).join(" ")}`));
  }
  if (code.kind === "driven") parts.push("driven: true", number("period", "z", "", "period"), `winds: ${JSON.stringify(code.winds)}`);
  if (code.kind === "body") parts.push(number("V", "A, B", "", "V"), number("inside", "A, B", "", "inside"));
  return `const compiledSystem = {${parts.join(",\n")}\n};\n`;
}
