// Numbers and mathematical names as people read them, on the page and on canvases.

const MINUS = "\u2212";
const RAISED = { "-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3", 4: "\u2074", 5: "\u2075", 6: "\u2076", 7: "\u2077", 8: "\u2078", 9: "\u2079" };
const lowered = (letter, digit) => letter + String.fromCharCode(0x2080 + Number(digit));
const GREEK = { pi: "π", alpha: "α", beta: "β", gamma: "γ", eta: "η", lam: "λ", lambda: "λ", mu: "μ", nu: "ν", vartheta: "ϑ", theta: "θ", rho: "ρ", kappa: "κ", varphi: "φ", psi: "ψ", delta: "δ", omega: "ω", epsilon: "ε" };

// A number with so many significant digits, as 0.1234, -1.2·10⁻⁷ with real minus and powers.
export function shownNumber(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : MINUS + "∞";
  if (value === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size >= -4 && size < 6) {
    const text = value.toPrecision(Math.max(digits, Math.min(size + 1, 15)));
    const short = text.includes(".") && !text.includes("e") ? text.replace(/\.?0+$/, "") : text;
    return short.replace("-", MINUS);
  }
  const [head, power] = value.toExponential(Math.max(0, digits - 1)).split("e");
  const raised = [...String(Number(power))].map((sign) => RAISED[sign]).join("");
  const factor = head.includes(".") ? head.replace(/\.?0+$/, "") : head;
  return (factor + "·10" + raised).replace("-", MINUS);
}

// The pieces NAME=PERIOD of a text, separated by commas, semicolons, lines or blanks.
export function periodicPieces(text) {
  return text.split(/[,;\n]|\s+(?=[A-Za-z]\w*\s*=)/).map((piece) => piece.trim()).filter(Boolean);
}

// Two ends of a scale with three decimals, or with as many as tell them apart.
export function shownEnds(low, high) {
  const places = Math.min(12, Math.max(3, 2 - Math.floor(Math.log10(high - low || 1))));
  return [low, high].map((value) => value.toFixed(places).replace(/^-(?=[0.]*$)/, "").replace("-", MINUS));
}

// A value with its error in units of the last digit, 0.61803(2); plain where the error is not known.
export function shownWithError(value, error) {
  if (!(error > 0) || !Number.isFinite(value)) return shownNumber(value, 8);
  const place = Math.min(12, Math.max(0, -Math.floor(Math.log10(error))));
  const last = Math.ceil(error * 10 ** place);
  if (last > 99) return shownNumber(value, 4) + " ± " + shownNumber(error, 2);
  return value.toFixed(place).replace("-", MINUS) + "(" + last + ")";
}

// A rotation number; of a chain of islands as the fraction that it is, with the turns about its own island.
export function shownRotation({ value, error, q, secondary }) {
  if (!q) return shownWithError(value, error);
  const p = Math.round(q * value), fraction = (p < 0 ? MINUS : "") + Math.abs(p) + "/" + q;
  return secondary?.error < 0.05 ? fraction + " · " + shownWithError(Math.abs(secondary.value), secondary.error) : fraction;
}

// A number as it is typed and stored: the shortest text that reads back the same.
export function plainNumber(value) {
  return String(value);
}

// A formula as it is typed, in signs that people read: powers raised, products by juxtaposition.
export function shownFormula(text) {
  return text
    .replace(/(?:\*\*|\^)\s*(\d+)/g, (_, power) => [...power].map((digit) => RAISED[digit]).join(""))
    .replaceAll("**", "^")
    .replace(/\s*\*\s*/g, "\u2009")
    .replace(/\b([A-Za-z])(\d)\b/g, (_, letter, digit) => lowered(letter, digit))
    .replace(/[A-Za-z]+/g, (word) => (word === "log" ? "ln" : (GREEK[word] ?? word)))
    .replaceAll("-", MINUS);
}

export function greek(name) {
  const [base, ...rest] = name.split("_");
  return [GREEK[base] ?? base.replace(/^([A-Za-z])(\d)$/, (_, letter, digit) => lowered(letter, digit)), ...rest.map((part) => GREEK[part] ?? part)].join("_");
}

// Pieces of a label: {text, italic, low} for p_β, "rotation number ν", E = 1.5.
function piecesOf(label) {
  const found = [];
  for (const [, name, low, other] of label.matchAll(/([\p{L}]+)(?:_([\p{L}\d]+))?|([^\p{L}]+)/gu)) {
    if (other !== undefined) found.push({ text: other, italic: false, low: false });
    else {
      found.push({ text: name, italic: name.length === 1 || low !== undefined, low: false });
      if (low !== undefined) found.push({ text: low, italic: low.length === 1, low: true });
    }
  }
  return found;
}

const SERIF = '"STIX Two Text", "Cambria Math", Cambria, Georgia, serif';

function fontOf(piece, size) {
  const points = piece.low ? size * 0.72 : piece.italic ? size * 1.12 : size;
  return (piece.italic ? "italic " : "") + points.toFixed(1) + "px " + (piece.italic || piece.low ? SERIF : "system-ui, sans-serif");
}

// Draw a label with italic letters and subscripts; align is "left", "center" or "right".
export function drawLabel(ctx, label, x, y, size, align = "left") {
  const pieces = piecesOf(label);
  const widths = pieces.map((piece) => {
    ctx.font = fontOf(piece, size);
    return ctx.measureText(piece.text).width;
  });
  const total = widths.reduce((sum, width) => sum + width, 0);
  let left = align === "center" ? x - total / 2 : align === "right" ? x - total : x;
  ctx.textAlign = "left";
  pieces.forEach((piece, i) => {
    ctx.font = fontOf(piece, size);
    ctx.fillText(piece.text, left, piece.low ? y + size * 0.26 : y);
    left += widths[i];
  });
  return total;
}

// The same as nodes of the page, put into an element; texts only, whatever they hold.
export function writeLabel(element, label) {
  element.replaceChildren(
    ...piecesOf(label).map((piece) => {
      if (!piece.italic && !piece.low) return document.createTextNode(piece.text);
      const inner = document.createElement("i");
      inner.textContent = piece.text;
      if (!piece.low) return inner;
      const low = document.createElement("sub");
      low.append(piece.italic ? inner : document.createTextNode(piece.text));
      return low;
    }),
  );
}

// Multiples of a share of pi, as -π/2.
function anglesBetween(low, high, share) {
  const step = share * Math.PI, found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    const parts = 1 / share, whole = Math.abs(k) % parts === 0 ? [Math.abs(k) / parts, 1] : Math.abs(k) % (parts / 2) === 0 ? [(2 * Math.abs(k)) / parts, 2] : [Math.abs(k), parts];
    const text = k === 0 ? "0" : (k < 0 ? MINUS : "") + (whole[0] === 1 ? "" : whole[0]) + "π" + (whole[1] === 1 ? "" : "/" + whole[1]);
    found.push({ value: k * step, text });
  }
  return found;
}

// Round values between two ends, about `wanted` of them, and the digits that tell them apart; parts of pi for an angle.
export function ticksBetween(low, high, wanted, span = 0) {
  const width = high - low;
  if (!(width > 0) || !Number.isFinite(width)) return [];
  const share = Math.abs(span - 2 * Math.PI) < 1e-9 ? [1 / 4, 1 / 2, 1].find((part) => width / (part * Math.PI) <= wanted) : undefined;
  if (share && width > share * Math.PI) return anglesBetween(low, high, share);
  const rough = width / Math.max(1, wanted);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; k++) {
    const value = k * step;
    const large = Math.abs(value) >= 1e6 || (places > 9 && value !== 0);
    const text = large ? value.toPrecision(15).replace(/\.?0+$/, "") : (k === 0 ? 0 : value).toFixed(Math.min(places, 15));
    found.push({ value, text: text.replace("-", MINUS) });
    if (found.length > 60) break;
  }
  return found;
}
