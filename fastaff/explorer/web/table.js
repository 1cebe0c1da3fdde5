// The table of orbits. Only the rows in sight are elements of the page, so that thousands of orbits cost nothing.

import { shownNumber, shownRotation } from "./text.js";
import { colourOf, hasRotation } from "./orbits.js";

const ROW = 27; // height of a row in pixels

// act: {choose(number), more(number), hide(number), forget(number)}
export function makeTable(box, body, act) {
  const table = { box, body, act, pool: [], spaces: [spaceRow(), spaceRow()], order: [] };
  body.replaceChildren(...table.spaces);
  box.addEventListener("scroll", () => table.redraw?.());
  body.addEventListener("click", (event) => {
    const row = event.target.closest("tr[data-orbit]");
    if (!row) return;
    const number = Number(row.dataset.orbit), name = event.target.closest("button")?.dataset.act;
    if (name) act[name](number);
    else act.choose(number);
  });
  box.addEventListener("keydown", (event) => {
    if (event.target.closest("button") || !["ArrowDown", "ArrowUp"].includes(event.key)) return;
    event.preventDefault();
    event.stopPropagation();
    act.step(event.key === "ArrowDown" ? 1 : -1);
  });
  return table;
}

function spaceRow() {
  const row = document.createElement("tr");
  row.className = "space";
  row.setAttribute("aria-hidden", "true");
  const cell = document.createElement("td");
  cell.colSpan = 10;
  row.append(cell);
  return row;
}

function newRow() {
  const row = document.createElement("tr");
  for (let i = 0; i < 10; i++) row.append(document.createElement("td"));
  row.cells[3].className = "in-time";
  row.cells[7].className = "in-time of-energy";
  const mark = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  mark.setAttribute("class", "swatch");
  mark.setAttribute("viewBox", "0 0 14 11");
  const patch = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  for (const [name, value] of Object.entries({ width: 14, height: 11, rx: 2 })) patch.setAttribute(name, value);
  mark.append(patch);
  row.cells[0].append(mark, document.createElement("span"));
  for (const [name, text] of [["more", "More"], ["hide", "Hide"], ["forget", "✕"]]) {
    const button = document.createElement("button");
    button.type = "button";
    button.dataset.act = name;
    button.textContent = text;
    row.cells[9].append(button, "\u2009");
  }
  return row;
}

const SAYS = { more: "More crossings of", hide: "Hide or show", forget: "Remove" };

const put = (element, text) => {
  if (element.textContent !== text) element.textContent = text;
};

function fillRow(row, orbit, isChosen, theme) {
  const { reading } = orbit;
  row.dataset.orbit = orbit.number;
  row.className = (isChosen ? "is-chosen" : "") + (orbit.hidden ? " is-hidden" : "");
  row.setAttribute("aria-current", String(isChosen));
  for (const button of row.cells[9].querySelectorAll("button")) button.setAttribute("aria-label", SAYS[button.dataset.act] + " orbit " + orbit.mark);
  row.querySelector("rect").setAttribute("fill", colourOf(orbit, theme));
  put(row.cells[0].lastChild, String(orbit.mark));
  put(row.cells[2], String(Math.max(reading.crossings, orbit.count)));
  put(row.cells[3], shownNumber(reading.time, 5));
  put(row.cells[4], hasRotation(orbit) ? shownRotation(reading.rotation) : "–");
  put(row.cells[5], shownNumber(reading.lyapunov, 3));
  put(row.cells[6], shownNumber(reading.megno, 3));
  put(row.cells[1], reading.classification ?? "–");
  put(row.cells[7], shownNumber(reading.energy_error, 2));
  put(row.cells[8], (reading.status ?? "").toLowerCase().replaceAll("_", " ").replace("no more crossings", "ended"));
  const [more, hide, forget] = row.cells[9].querySelectorAll("button");
  put(hide, orbit.hidden ? "Show" : "Hide");
  [[more, "More crossings of"], [hide, hide.textContent], [forget, "Remove"]].forEach(([button, text]) => {
    button.setAttribute("aria-label", text + " orbit " + orbit.mark);
    button.title = text + " orbit " + orbit.mark;
  });
}

// Write the rows in sight. A button that has the focus keeps it, as its orbit's row is another one or gone: then the next
// orbit's has it.
export function drawTable(table, orbits, theme) {
  const held = table.body.getRootNode().activeElement, { act } = (table.body.contains(held) && held.dataset) || {};
  const number = act && Number(held.closest("tr").dataset.orbit), place = act && table.pool.indexOf(held.closest("tr"));
  writeRows(table, orbits, theme);
  if (!act) return;
  const shown = table.pool.filter((row) => row.isConnected), own = shown.find((row) => Number(row.dataset.orbit) === number);
  const next = own ?? (orbits.shown.has(number) ? null : shown[Math.min(place, shown.length - 1)]);
  (next?.querySelector(`[data-act=${act}]`) ?? table.box).focus({ preventScroll: true });
}

function writeRows(table, orbits, theme) {
  table.order = [...orbits.shown.values()].reverse();
  const { box, body, pool, order, spaces } = table;
  const seen = Math.ceil((box.clientHeight || 200) / ROW) + 4;
  const first = Math.max(0, Math.min(order.length - seen, Math.floor(box.scrollTop / ROW) - 2));
  const rows = order.slice(first, first + seen);
  while (pool.length < rows.length) pool.push(newRow());
  rows.forEach((orbit, i) => fillRow(pool[i], orbit, orbit.number === orbits.chosen, theme));
  const wanted = [spaces[0], ...pool.slice(0, rows.length), spaces[1]];
  if (body.children.length !== wanted.length) body.replaceChildren(...wanted);
  spaces[0].firstChild.style.height = first * ROW + "px";
  spaces[1].firstChild.style.height = (order.length - first - rows.length) * ROW + "px";
  spaces[0].hidden = first === 0;
  spaces[1].hidden = order.length === first + rows.length;
}

// Bring an orbit's row into sight.
export function showRow(table, number) {
  const at = table.order.findIndex((orbit) => orbit.number === number);
  if (at < 0) return;
  const { box } = table, top = at * ROW, height = box.clientHeight - 2 * ROW;
  if (top < box.scrollTop) box.scrollTop = top;
  else if (top > box.scrollTop + height) box.scrollTop = top - height;
}
