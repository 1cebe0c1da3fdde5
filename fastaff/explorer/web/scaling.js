// Initial conditions on another energy surface: at the place in its region that they had in the region before.

const INWARD = 40, TOWARDS = 0.93; // steps towards the middle of a region that has dents, each of this share of the way left

/** Where an orbit belongs: its point and the box of its region, kept while surfaces change. */
export function homeOf(surface, point) { return { point: [...point], box: boxOfRegion(surface) }; }

/** The point of a region at the place of a home; the point itself where the region goes on without an edge. */
export function placedIn(surface, { point, box }) {
  const now = boxOfRegion(surface);
  if (!box || !now) return [...point];
  const [u0, u1, v0, v1] = box, [a0, a1, b0, b1] = now;
  const place = [a0 + ((point[0] - u0)/(u1 - u0))*(a1 - a0), b0 + ((point[1] - v0)/(v1 - v0))*(b1 - b0)];
  const same = box.every((end, k) => end === now[k]);
  return same ? [...point] : inward(surface, place);
}

/** The place, or the first one on its way to the middle of the region that has all its neighbours in the region. */
function inward(surface, [u, v]) {
  const middle = middleOf(surface);
  for (let step = 0, share = 1; step < INWARD; step++, share *= TOWARDS) {
    const place = [middle[0] + share*(u - middle[0]), middle[1] + share*(v - middle[1])];
    if (isInside(surface, ...place)) return place;
  }
  return middle;
}

/** The cell of the region farthest from its edge along both axes. */
function middleOf(surface) {
  const { allowed, width, height, extent: [u0, u1, v0, v1] } = surface, run = new Int32Array(width*height).fill(1 << 20);
  const sweep = (first, last, by, lines, at) => {
    for (let line = 0; line < lines; line++) {
      for (let k = first, length = 0; k !== last; k += by) {
        const cell = at(line, k);
        length = allowed[cell] ? length + 1 : 0;
        run[cell] = Math.min(run[cell], length);
      }
    }
  };
  const row = (line, k) => line*width + k, column = (line, k) => k*width + line;
  sweep(0, width, 1, height, row); sweep(width - 1, -1, -1, height, row);
  sweep(0, height, 1, width, column); sweep(height - 1, -1, -1, width, column);
  let best = 0;
  for (let cell = 0; cell < run.length; cell++) if (run[cell] > run[best]) best = cell;
  return [u0 + ((best % width) + 0.5)/width*(u1 - u0), v0 + (Math.floor(best/width) + 0.5)/height*(v1 - v0)];
}

/** Whether the cell of a point and those beside it are in the region. */
function isInside({ allowed, width, height, extent: [u0, u1, v0, v1] }, u, v) {
  const column = Math.floor(((u - u0)/(u1 - u0))*width), row = Math.floor(((v - v0)/(v1 - v0))*height);
  return [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]].every(([i, j]) => {
    const c = column + i, r = row + j;
    return c >= 0 && r >= 0 && c < width && r < height && allowed[r*width + c] !== 0;
  });
}

/** The box [u0, u1, v0, v1] around the region, null where it has no edge. */
function boxOfRegion(surface) {
  if (surface.open) return null;
  const { allowed, width, height, extent: [u0, u1, v0, v1] } = surface;
  let [c0, c1, r0, r1] = [width, -1, height, -1];
  allowed.forEach((is, cell) => {
    if (!is) return;
    const column = cell % width, row = Math.floor(cell/width);
    c0 = Math.min(c0, column); c1 = Math.max(c1, column); r0 = Math.min(r0, row); r1 = Math.max(r1, row);
  });
  if (c1 < 0) return null;
  return [u0 + c0/width*(u1 - u0), u0 + (c1 + 1)/width*(u1 - u0), v0 + r0/height*(v1 - v0), v0 + (r1 + 1)/height*(v1 - v0)];
}
