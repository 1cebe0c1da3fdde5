// Sliders with number boxes, lists, and sentences beside what they are about.

import { greek, plainNumber, writeLabel } from "./text.js";

// A number as people type it: 0.125, 1e-3, 1/8; NaN where it is none.
export function typedNumber(text) {
  const match = /^\s*([+\-\u2212]?[\d.]+(?:e[+-]?\d+)?)(?:\s*\/\s*([\d.]+(?:e[+-]?\d+)?))?\s*$/i.exec(text);
  if (!match) return NaN;
  const value = Number(match[1].replace("\u2212", "-")) / (match[2] === undefined ? 1 : Number(match[2]));
  return Number.isFinite(value) ? value : NaN;
}

// A row with a name, a slider and a box; `changed(value, final)` is called as it moves.
export function makeSlider({ name, value, from, to }, changed) {
  const row = document.createElement("div");
  row.className = name.length > 4 ? "slider wide" : "slider";
  const label = document.createElement("span");
  writeLabel(label, greek(name));
  const range = document.createElement("input");
  Object.assign(range, { type: "range", min: 0, max: 1000, step: 1 });
  range.setAttribute("aria-label", name + ", slider");
  const box = document.createElement("input");
  Object.assign(box, { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false });
  box.setAttribute("aria-label", name);
  box.dataset.number = range.dataset.slider = name;
  const slider = { row, range, box, from, to, value };
  setSlider(slider, value);
  range.addEventListener("input", () => {
    slider.value = roundedIn(slider, slider.from + (range.value / 1000) * (slider.to - slider.from));
    box.value = plainNumber(slider.value);
    box.removeAttribute("aria-invalid");
    changed(slider.value, false);
  });
  range.addEventListener("change", () => changed(slider.value, true));
  const typed = () => {
    const number = typedNumber(box.value);
    if (Number.isNaN(number)) return box.setAttribute("aria-invalid", "true");
    box.removeAttribute("aria-invalid");
    if (number === slider.value) return undefined;
    slider.value = number;
    place(slider);
    return changed(number, true);
  };
  box.addEventListener("change", typed);
  box.addEventListener("keydown", (event) => event.key === "Enter" && typed());
  row.append(label, range, box);
  return slider;
}

// A round number near a slider's place: a thousandth of its range.
function roundedIn(slider, value) {
  const places = Math.max(0, Math.ceil(-Math.log10((slider.to - slider.from) / 1000)));
  return Number(value.toFixed(Math.min(places, 12)));
}

function place(slider) {
  slider.range.value = Math.round((1000 * (slider.value - slider.from)) / (slider.to - slider.from));
}

export function setSlider(slider, value) {
  slider.value = value;
  slider.box.value = plainNumber(value);
  slider.box.removeAttribute("aria-invalid");
  place(slider);
}

export function rangeSlider(slider, from, to) {
  if (!(to > from)) return;
  Object.assign(slider, { from, to });
  place(slider);
}

// The choices of a list: [[value, text], ...].
export function fillList(select, choices, value) {
  select.replaceChildren(
    ...choices.map(([key, text]) => {
      const option = document.createElement("option");
      option.value = key;
      option.textContent = text;
      return option;
    }),
  );
  select.value = value;
}

// Show a sentence of what is wrong beside its control, or nothing.
export function saysWrong(element, sentence) {
  element.hidden = !sentence;
  element.textContent = sentence ?? "";
}

const SECTION_NAMES = { "alpha-turning": "α turning, pα = 0", "beta-turning": "β turning, pβ = 0", "alpha=c": "α = constant", "beta=c": "β = constant", "area=c": "D₁D₂ = constant" };

export function sectionTitle(name) {
  if (name.includes(",")) return name.split(",").map(greek).join(", ");
  return SECTION_NAMES[name] ?? (name.endsWith("=c") ? greek(name.slice(0, -2)) + " = constant" : name);
}

// KAHAN_LI8 as Kahan Li 8.
export function schemeTitle(name) {
  return name.replace(/_/g, " ").replace(/([A-Z])([A-Z]+)/g, (_, first, rest) => first + rest.toLowerCase()).replace(/([a-z])(\d)/g, "$1 $2");
}
