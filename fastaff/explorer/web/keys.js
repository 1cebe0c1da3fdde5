// The keyboard: which key does what, the list of them, and the cursor by which orbits are launched without a mouse.

const KEYS = [
  [["Enter"], "launch an orbit at the cursor", "launch"],
  [["←", "→", "↑", "↓"], "move the cursor; with Shift the view", null],
  [["+"], "zoom in", "zoom-in"],
  [["−"], "zoom out", "zoom-out"],
  [["0"], "the whole accessible region", "whole"],
  [["Backspace"], "previous view", "back"],
  [["Z"], "draw a box to zoom into", "box"],
  [["G"], "launch a grid of orbits over the view", "fill"],
  [["M"], "compute more crossings of the selected orbit, or of all", "more"],
  [["X"], "stop all orbits", "stop"],
  [["N", "P"], "choose the next, the orbit before", null],
  [["H"], "hide or show the selected orbit", "hide"],
  [["Del"], "remove the selected orbit", "forget"],
  [["U"], "undo", "undo"],
  [["C"], "clear", "clear"],
  [["D"], "density of the points", "density"],
  [["B"], "background map", "background"],
  [["Space"], "play or pause the motion", "play"],
  [["S"], "save the picture", "save-picture"],
  [["J"], "save the job", "save-job"],
  [["T"], "light, dark or as the system", "theme"],
  [["?"], "this help", "help"],
  [["Esc"], "deselect the orbit", "none"],
];

const NAMES = { "−": "-", Space: " ", Del: "delete", Esc: "escape" };
const ACTS = new Map(KEYS.filter(([, , act]) => act).flatMap(([keys, , act]) => keys.map((key) => [(NAMES[key] ?? key).toLowerCase(), act])));

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

// act: {do(name), move(dx, dy, far), pan(dx, dy), step(by)}
export function followKeys(target, act) {
  target.addEventListener("keydown", (event) => {
    const at = event.composedPath()[0];
    const typing = at.closest?.("input:not([type=range]), textarea, select, dialog[open]");
    if (typing || event.altKey || event.metaKey) return;
    if (event.ctrlKey) {
      if (event.key.toLowerCase() === "z") act.do("undo", event);
      return;
    }
    if (Object.hasOwn(ARROWS, event.key)) {
      if (at.matches?.("input, summary, [data-part=table]")) return;
      event.preventDefault();
      const [dx, dy] = ARROWS[event.key];
      if (event.shiftKey) act.pan(dx, dy);
      else act.move(dx, dy);
      return;
    }
    const pressed = event.key === "=" ? "+" : event.key.toLowerCase();
    if ((pressed === " " || pressed === "enter") && at.closest?.("button, summary, a")) return;
    if (pressed === "n" || pressed === "p") act.step(pressed === "n" ? -1 : 1);
    else if (ACTS.has(pressed)) act.do(ACTS.get(pressed), event);
    else return;
    event.preventDefault();
  });
}

export function listKeys(table) {
  const rows = KEYS.map(([keys, text]) => {
    const row = document.createElement("tr");
    const left = document.createElement("td"), right = document.createElement("td");
    keys.forEach((key, i) => {
      const cap = document.createElement("kbd");
      cap.textContent = key;
      left.append(...(i ? [" ", cap] : [cap]));
    });
    right.textContent = text;
    row.append(left, right);
    return row;
  });
  const mouse = document.createElement("tr");
  const left = document.createElement("td"), right = document.createElement("td");
  left.textContent = "Mouse, fingers";
  right.textContent = "click launches, drag moves the view, wheel or pinch zooms, Shift and drag draws a box; hovering reads values";
  mouse.append(left, right);
  table.replaceChildren(mouse, ...rows);
}
