// The edge of what is allowed in a rectangle, from a mask of its cells: a polygon that follows the edge between the cells.

const EDGE_HALVINGS = 14;

/** The ends of polygons u, v, u, v, ..., each followed by NaN, NaN, that together cover what is allowed. `inside(u, v)` finds
 * the edge between the middles of two cells; without it that is half way. What is allowed at an end of the rectangle goes on
 * for the part `beyond` of it, where that is not 0. */
export function outlineOf(allowed, [u0, u1, v0, v1], width, height, inside = null, beyond = 0) {
  const du = (u1 - u0)/width, dv = (v1 - v0)/height, found = [], inner = (i, count) => Math.min(count - 1, Math.max(0, i));
  const is = (i, j) => (beyond > 0 || (i >= 0 && j >= 0 && i < width && j < height)) && allowed[inner(j, height)*width + inner(i, width)] !== 0;
  const place = (i, count) => (i < 0 ? -Math.max(0.5, beyond*count) : i >= count ? count + Math.max(0.5, beyond*count) : i + 0.5);
  const at = (i, j) => [u0 + place(i, width)*du, v0 + place(j, height)*dv];
  const between = (kept, gone) => {
    let [a, b] = [kept, gone];
    for (let k = 0; k < (inside ? EDGE_HALVINGS : 1); k++) {
      const middle = [(a[0] + b[0])/2, (a[1] + b[1])/2];
      if (inside?.(...middle)) a = middle; else b = middle;
    }
    return inside ? a : b;
  };
  const polygon = (points) => {
    for (const point of points) found.push(...point);
    found.push(NaN, NaN);
  };
  for (let j = -1; j < height; j++) {
    let whole = null; // where a run of cells that are allowed at all corners began
    for (let i = -1; i < width; i++) {
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]], are = corners.map(([k, l]) => is(k, l));
      if (are.every(Boolean)) { whole ??= i; continue; }
      if (whole !== null) { polygon([at(whole, j), at(i, j), at(i, j + 1), at(whole, j + 1)]); whole = null; }
      if (!are.some(Boolean)) continue;
      polygon(corners.flatMap((corner, k) => {
        const next = (k + 1) % 4, own = are[k] ? [at(...corner)] : [];
        if (are[k] === are[next]) return own;
        return [...own, are[k] ? between(at(...corner), at(...corners[next])) : between(at(...corners[next]), at(...corner))];
      }));
    }
    if (whole !== null) polygon([at(whole, j), at(width, j), at(width, j + 1), at(whole, j + 1)]);
  }
  return Float64Array.from(found);
}

/** A function of a path's places that is linear between the middles of columns, where it is finite; itself elsewhere. */
export function betweenColumns(f, [u0, u1], width) {
  const du = (u1 - u0)/width, values = Float64Array.from({ length: width + 2 }, (_, k) => f(u0 + (k - 0.5)*du));
  return (u) => {
    const place = (u - u0)/du + 0.5, k = Math.min(width, Math.max(0, Math.floor(place)));
    const value = values[k] + (place - k)*(values[k + 1] - values[k]);
    return Number.isFinite(value) ? value : f(u);
  };
}
