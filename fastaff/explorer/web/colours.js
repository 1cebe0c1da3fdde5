// Colours of orbits, of maps and of the two themes.

// Okabe and Ito, Color Universal Design (2008), told apart by colour-blind readers; the dark set is the same, lightened.
const ORBIT_COLOURS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b97f00", "#2f9bd8", "#5a4fa2", "#4d4d4d"],
  dark: ["#56b4e9", "#ff8a3d", "#2fc79c", "#eb9ec8", "#f0c33c", "#8fb8ff", "#b9a6ff", "#d0d0d0"],
};

export function orbitColour(number, theme) {
  const cycle = ORBIT_COLOURS[theme];
  return cycle[number % cycle.length];
}

export function rgbOf(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

// Nine colours of viridis (Smith and van der Walt 2015, public domain), between which maps are linear.
const MAP_COLOURS = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"].map(rgbOf);

// 256 colours as bytes red, green, blue.
export const MAP_TABLE = (() => {
  const table = new Uint8Array(768);
  for (let i = 0; i < 256; i++) {
    const place = (i / 255) * (MAP_COLOURS.length - 1);
    const k = Math.min(MAP_COLOURS.length - 2, Math.floor(place));
    for (let c = 0; c < 3; c++) table[3 * i + c] = Math.round(MAP_COLOURS[k][c] + (place - k) * (MAP_COLOURS[k + 1][c] - MAP_COLOURS[k][c]));
  }
  return table;
})();

// Shades of a value of orbits, from 0 to SHADES, that can be told from the ground; beside them a colour of each classification.
export const SHADES = 48;

const CLASSIFIED = { light: { chaotic: "#a3a9b2", undecided: "#5b626c", regular: "#0072b2" }, dark: { chaotic: "#6f7883", undecided: "#b9c0c9", regular: "#56b4e9" } };

export function shadeColour(paint, theme) {
  if (typeof paint === "string") return CLASSIFIED[theme][paint];
  const place = (theme === "dark" ? 75 : 0) + Math.round((paint / SHADES) * (theme === "dark" ? 180 : 190));
  return "#" + [...MAP_TABLE.subarray(3 * place, 3 * place + 3)].map((part) => part.toString(16).padStart(2, "0")).join("");
}

// Colours that canvases use, read from the style sheet once for each theme.
export function plotColours(root) {
  const style = getComputedStyle(root);
  const named = (name) => style.getPropertyValue("--" + name).trim();
  return { text: named("text"), quiet: named("quiet"), line: named("line"), plot: named("plot"), inaccessible: named("inaccessible"), accent: named("accent") };
}
