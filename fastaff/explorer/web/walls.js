// Where a formula lives: what must be positive in it, found on its graph at random points.

/** The margin of walls: the least of them, 1 where there is none. */
export function least({ lines, results }) {
  return { lines, results: [results.length ? `Math.min(${results.join(", ")})` : "1"] };
}

/** What must be positive: what stands in logarithms and roots, and poles that have one sign at the points. */
export function wallsOf(graph, V, points, values) {
  const walls = [];
  for (const part of graph.below([V])) {
    const [a, b] = part.entries;
    if (part.kind === "call" && a === "log") walls.push(b);
    if (part.kind !== "power" || b.kind !== "number") continue;
    if (!Number.isInteger(b.entries[0])) walls.push(a);
    else if (b.entries[0] < 0) {
      const signs = points.map((point) => Math.sign(graphValue(a, point, values))).filter((sign) => sign === sign);
      if (signs.length && signs.every((sign) => sign > 0)) walls.push(a);
      if (signs.length && signs.every((sign) => sign < 0)) walls.push(graph.negative(a));
    }
  }
  return [...new Set(walls)].filter((wall) => graph.below([wall]).some((part) => part.kind === "name" && /^[. ]/.test(part.entries[0])));
}

export function graphValue(part, point, values, done = new Map()) {
  if (done.has(part)) return done.get(part);
  const [a, b] = part.entries, at = (e) => graphValue(e, point, values, done);
  const value = part.kind === "number" ? a : part.kind === "name" ? point.get(a) ?? values.get(a)
    : part.kind === "sum" ? at(a) + at(b) : part.kind === "product" ? at(a)*at(b)
      : part.kind === "call" ? Math[a](at(b)) : at(a)**at(b);
  done.set(part, value);
  return value;
}
