// Angles, shown from -T/2 to T/2.

/** A number in [-T/2, T/2), itself where there is no period T. */
export function reduced(x, period) {
  if (!(period > 0)) return x;
  const rest = x - period*Math.floor(x/period + 0.5), half = period/2;
  return rest < -half || rest >= half ? -half : rest;
}
