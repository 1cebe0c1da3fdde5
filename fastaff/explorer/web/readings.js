// What signals and points of an orbit say: rotation numbers, and the dominant frequency of each angle's loop.

const SHARPNESS = 30, GOLDEN = (Math.sqrt(5) - 1)/2, ROTATION_SAFETY = 5, LEAST_POINTS = 32, HARMONICS = 16;
const SPANS = [[0, 1], [0, 0.5], [0.5, 1], [0, GOLDEN], [1 - GOLDEN, 1], [0.2, 0.2 + Math.sqrt(0.4)]];
const LEAST_SAMPLES = 64, FRAMES = 2, LINES = 6, EXACT_EVERY = 64;

function bump(x) { return Math.abs(x) < 1 ? Math.exp(SHARPNESS*(Math.sqrt(1 - x*x) - 1)) : 0; }

/** Weighted averages of values over the windows of SPANS. */
export function averages(values, count) {
  return SPANS.map(([begin, end]) => {
    const first = Math.round(begin*count), last = Math.round(end*count);
    let total = 0, weight = 0;
    for (let k = first; k < last; k++) {
      const w = bump((2*k + 1 - first - last)/(last - first));
      weight += w; total += w*values[k];
    }
    return total/weight;
  });
}

/**
 * The rotation number of points u, v, u, v, ... about their weighted mean, in turns per crossing in (-1/2, 1/2], with an
 * error; null of fewer than 32 points. As rotation_number of the package. Das, Saiki, Sander & Yorke 2017.
 */
export function rotationNumber(points) {
  const count = points.length/2;
  if (count < LEAST_POINTS) return null;
  const u = Float64Array.from({ length: count }, (_, k) => points[2*k]);
  const v = Float64Array.from({ length: count }, (_, k) => points[2*k + 1]);
  const [cu] = averages(u, count), [cv] = averages(v, count);
  const theta = angles(u.map((x) => x - cu), v.map((y) => y - cv), count);
  const { value, error } = meanTurn(displacements(theta).map((x) => x/(2*Math.PI)));
  return { value: value - Math.ceil(value - 0.5), error };
}

/** The weighted mean of what points turn by in each iterate, with an error. */
export function meanTurn(turns) {
  const count = turns.length, means = averages(turns, count), [value] = means, uneven = Math.max(...means.slice(1).map((x) => Math.abs(x - value)));
  return { value, error: ROTATION_SAFETY*uneven + unresolved(value, count) + 1e-14*Math.max(1, Math.abs(value)) };
}

/**
 * Angles of points after a linear map that makes their weighted second moments those of a circle: on an ellipse, in
 * whatever units, all steps are equal then.
 */
function angles(x, y, count) {
  for (let frame = 0; frame < FRAMES; frame++) {
    const [xx] = averages(x.map((a) => a*a), count);
    if (xx > 0) x = x.map((a) => a/Math.sqrt(xx));
    const [xy] = averages(y.map((b, k) => x[k]*b), count);
    const across = y.map((b, k) => b - xy*x[k]), [yy] = averages(across.map((b) => b*b), count);
    if (yy > 0) y = across.map((b) => b/Math.sqrt(yy));
  }
  return y.map((b, k) => Math.atan2(b, x[k]));
}

/** The weighted mean of what an angle winds in each iterate, in turns, with an error; null of fewer than 32. */
export function windingNumber(turns) {
  return turns.length < LEAST_POINTS ? null : meanTurn(turns);
}

/** Displacements of angles from one point to the next, lifted by continuity along the curve from behind the widest gap. */
export function displacements(theta) {
  const count = theta.length - 1, start = theta.slice(0, count), ring = start.slice().sort();
  let widest = ring[0] + 2*Math.PI - ring[count - 1], edge = -Infinity;
  for (let k = 0; k + 1 < count; k++) {
    const gap = ring[k + 1] - ring[k];
    if (gap >= widest) { widest = gap; edge = ring[k]; }
  }
  for (let k = 0; k < count; k++) if (start[k] <= edge) start[k] += 2*Math.PI;
  const order = Uint32Array.from(start.keys()).sort((i, j) => start[i] - start[j]), out = new Float64Array(count);
  let walk = theta[order[0] + 1], before = walk;
  order.forEach((k, place) => {
    const image = theta[k + 1];
    if (place) walk += wrapped(image - before);
    before = image;
    out[k] = walk - start[k];
  });
  return out;
}

export function wrapped(angle) { return angle - 2*Math.PI*Math.floor((angle + Math.PI)/(2*Math.PI)); }

function unresolved(rotation, steps) {
  let total = 0;
  for (let m = 1; m <= HARMONICS; m++) {
    const beat = Math.abs(m*rotation - Math.round(m*rotation));
    total += 4*0.5**m*beat/m*Math.exp(Math.sqrt(Math.max(SHARPNESS**2 - (Math.PI*beat*steps)**2, 0)) - SHARPNESS);
  }
  return total;
}

/**
 * The strongest line of each angle's loop Q - c - i kappa P, in cycles per unit time, with the change between the halves
 * as error; null of fewer than 64 samples. Rows of `samples` are Re Q, Im Q, Re P, Im P of each angle. Laskar 1990.
 */
export function fundamentalFrequencies(samples, width, interval, names) {
  const rows = 2**Math.floor(Math.log2(samples.length/width));
  if (rows < LEAST_SAMPLES) return null;
  const values = [], errors = [];
  for (let k = 0; 4*k < width; k++) {
    const loop = (first, count) => loopOf(samples, width, 4*k, first, count);
    const whole = dominant(loop(0, rows)), one = dominant(loop(0, rows/2)), other = dominant(loop(rows/2, rows/2));
    values.push(whole === null ? null : whole/interval);
    const parts = [one, other].map((part) => (part === null ? Infinity : Math.abs(part - whole)));
    errors.push(whole === null ? null : (Math.max(...parts) + 1e-15)/interval);
  }
  return { names, values, errors };
}

/** One loop as real and imaginary parts, centred; a plane's has the sense of its turning. */
function loopOf(samples, width, column, first, count) {
  const re = new Float64Array(count), im = new Float64Array(count), part = [0, 1, 2, 3].map(() => new Float64Array(count));
  for (let s = 0; s < count; s++) for (let c = 0; c < 4; c++) part[c][s] = samples[(first + s)*width + column + c];
  const plane = part[1].some((x) => x !== 0) || part[3].some((x) => x !== 0);
  const weight = hann(count), sums = [0, 0, 0];
  const mean = plane ? 0 : part[0].reduce((total, x, s) => total + weight[s]*x, 0);
  for (let s = 0; s < count; s++) {
    sums[0] += (part[0][s] - mean)**2 + part[1][s]**2;
    sums[1] += part[2][s]**2 + part[3][s]**2;
    sums[2] += part[0][s]*part[3][s] - part[1][s]*part[2][s];
  }
  const kappa = sums[1] > 0 ? Math.sqrt(sums[0]/sums[1])*(plane && sums[2] < 0 ? -1 : 1) : 0;
  for (let s = 0; s < count; s++) {
    re[s] = part[0][s] - mean + kappa*part[3][s];
    im[s] = part[1][s] - kappa*part[2][s];
  }
  return { re, im };
}

const WINDOWS = new Map();

/** The window (1 + cos)^3 of sum 1. */
function hann(count) {
  if (!WINDOWS.has(count)) {
    const w = Float64Array.from({ length: count }, (_, k) => (1 + Math.cos(2*Math.PI*(k - (count - 1)/2)/count))**3);
    const total = w.reduce((a, b) => a + b, 0);
    WINDOWS.set(count, w.map((x) => x/total));
  }
  return WINDOWS.get(count);
}

/** The frequency of the strongest line, in cycles per sample; null where nothing moves. */
function dominant({ re, im }) { return fittedLines(re, im)[0]?.nu ?? null; }

/** The strongest lines {nu, re, im} of samples, each fitted with the others; [] where nothing moves. */
export function fittedLines(re, im) {
  const count = re.length, restRe = re.slice(), restIm = im.slice(), lines = [];
  const size = Math.max(...[re, im].map((x) => x.reduce((most, y) => Math.max(most, Math.abs(y)), 0)));
  if (!(size > 0)) return [];
  for (let k = 0; k < LINES; k++) {
    const line = strongest(restRe, restIm);
    if (!line || Math.hypot(line.re, line.im) < 1e-13*size) break;
    lines.push(line);
    subtract(restRe, restIm, line, 1);
  }
  for (let round = 0; round < 3; round++) {
    for (const line of lines) {
      subtract(restRe, restIm, line, -1);
      refine(restRe, restIm, line, 1/count);
      subtract(restRe, restIm, line, 1);
    }
  }
  return lines;
}

function subtract(re, im, line, sign) {
  const step = 2*Math.PI*line.nu, turnRe = Math.cos(step), turnIm = Math.sin(step);
  for (let s = 0, c = 1, d = 0; s < re.length; s++) {
    if (s % EXACT_EVERY === 0) { c = Math.cos(step*s); d = Math.sin(step*s); }
    re[s] -= sign*(line.re*c - line.im*d); im[s] -= sign*(line.re*d + line.im*c);
    const next = c*turnRe - d*turnIm;
    d = c*turnIm + d*turnRe; c = next;
  }
}

/** The largest bin of the windowed transform, of zeros up to a power of two, refined. */
function strongest(re, im) {
  const count = re.length, size = 2**Math.ceil(Math.log2(count)), w = hann(count), x = new Float64Array(size), y = new Float64Array(size);
  for (let s = 0; s < count; s++) { x[s] = re[s]*w[s]; y[s] = im[s]*w[s]; }
  transform(x, y);
  let best = 0;
  for (let k = 1; k < size; k++) if (x[k]**2 + y[k]**2 > x[best]**2 + y[best]**2) best = k;
  const line = { nu: (best <= size/2 ? best : best - size)/size, re: 0, im: 0 };
  refine(re, im, line, 1/count);
  return line;
}

/** The windowed amplitude at a frequency, with the first two derivatives of its square. */
function amplitude(re, im, nu) {
  const w = hann(re.length), step = 2*Math.PI*nu, middle = (re.length - 1)/2, turn = 2*Math.PI;
  const turnRe = Math.cos(step), turnIm = Math.sin(step);
  let a = 0, b = 0, a1 = 0, b1 = 0, a2 = 0, b2 = 0;
  for (let s = 0, c = 1, d = 0; s < re.length; s++) {
    if (s % EXACT_EVERY === 0) { c = Math.cos(step*s); d = Math.sin(step*s); }
    const t = turn*(s - middle);
    const p = w[s]*(re[s]*c + im[s]*d), q = w[s]*(im[s]*c - re[s]*d);
    a += p; b += q; a1 += t*q; b1 -= t*p; a2 -= t*t*p; b2 -= t*t*q;
    const next = c*turnRe - d*turnIm;
    d = c*turnIm + d*turnRe; c = next;
  }
  return { re: a, im: b, slope: 2*(a*a1 + b*b1), bend: 2*(a1*a1 + b1*b1 + a*a2 + b*b2) };
}

/** Move a line to the maximum of the windowed amplitude near it, by Newton's method. */
function refine(re, im, line, bin) {
  let { nu } = line, low = nu - bin, high = nu + bin;
  for (let k = 0; k < 12; k++) {
    const at = amplitude(re, im, nu);
    if (at.slope > 0) low = nu; else high = nu;
    const newton = at.bend < 0 ? nu - at.slope/at.bend : NaN;
    if (Math.abs(newton - nu) < 1e-11*bin) break;
    nu = newton > low && newton < high ? newton : (low + high)/2;
  }
  const at = amplitude(re, im, nu);
  Object.assign(line, { nu, re: at.re, im: at.im });
}

/** Fourier transform in place, of a power of two samples. */
function transform(re, im) {
  const count = re.length;
  for (let i = 1, j = 0; i < count; i++) {
    let bit = count >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) { [re[i], re[j]] = [re[j], re[i]]; [im[i], im[j]] = [im[j], im[i]]; }
  }
  for (let half = 1; half < count; half <<= 1) {
    for (let k = 0; k < half; k++) {
      const c = Math.cos(-Math.PI*k/half), d = Math.sin(-Math.PI*k/half);
      for (let i = k; i < count; i += 2*half) {
        const j = i + half, x = re[j]*c - im[j]*d, y = re[j]*d + im[j]*c;
        re[j] = re[i] - x; im[j] = im[i] - y; re[i] += x; im[i] += y;
      }
    }
  }
}
