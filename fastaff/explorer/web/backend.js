// The page's side of the workers: one for each system's text, made from a blob; formulas are read here.

import { formulaCode, readFormula } from "./formula_code.js";
import { systemText } from "./system.js";

/** Return a backend {send, onmessage} for the page; `setup.worker` is the text of the worker. */
export function workerBackend(setup) {
  const backend = { onmessage: null, send };
  let worker = null;
  const answer = (data) => backend.onmessage?.({ data });

  const later = (call) => setTimeout(call, 0);

  function start(message) {
    const { system } = message, code = system.code ?? formulaCode(system);
    const parameters = { ...Object.fromEntries(code.parameters.map((name) => [name, 1])), ...system.parameters };
    worker?.terminate();
    const url = URL.createObjectURL(new Blob([setup.worker, "\n", systemText(code), "\nserve(compiledSystem);\n"],
      { type: "text/javascript" }));
    worker = new Worker(url);
    worker.onmessage = (event) => {
      URL.revokeObjectURL(url);
      answer(event.data);
    };
    worker.onerror = (event) => answer({ type: "wrong", what: "system", message: event.message || "the worker failed" });
    worker.postMessage({
      type: "system", system: { parameters, coordinates: code.coordinates ?? system.coordinates, momenta: code.momenta ?? system.momenta },
      accuracy: message.accuracy ?? setup.start.accuracy,
      scheme: schemeNamed(setup, message.scheme, code), frame: setup.frames[code.kind === "driven" ? code.n - 1 : code.n],
    });
  }

  function send(message, transfer = []) {
    try {
      if (message.type === "system") start(message);
      else if (message.type === "parse") parse(message);
      else worker?.postMessage(message, transfer);
    } catch (problem) {
      later(() => answer({ type: "wrong", what: problem.what ?? "system", message: problem.message }));
    }
  }

  /** Say whether a text is a formula, and which parameters it has. */
  function parse(message) {
    let names = [], sentence = null, what = null;
    try {
      names = readFormula(message).names;
      formulaCode(message);
    } catch (problem) {
      sentence = problem.message;
      what = problem.what ?? "formula";
    }
    later(() => answer({ ...message, type: "parsed", names, what, message: sentence }));
  }

  return backend;
}

function schemeNamed(setup, name, code) {
  const wanted = typeof name === "string" ? name : name?.name ?? setup.start.scheme;
  return setup.schemes.find((scheme) => scheme.name === wanted) ?? setup.schemes[0];
}
