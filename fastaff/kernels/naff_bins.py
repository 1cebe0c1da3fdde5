"""The fit of lines to the bins around them: by the windowed FFT of a signal, without its samples.

Conventions as in `naff_lines`. A line has 2p + 10 bins of its own, floor(u) - p - 4 to floor(u) + p + 5. Lines that
share bins, or nearly so, are a group: the fit minimises the sum of |residual|^2 over its bins, with the lines of other
groups subtracted as they were fitted last. For a signal of these lines alone the minimum is 0 at the lines themselves,
as for a fit to the samples, at a cost that does not grow with the number of samples.
"""

import math

from ..compile.jit import jit
from .naff_spectrum import subtract_line, tail_reach

EPS = 2.220446049250313e-16

MARGIN = 5
"""Bins of a line on each side beyond its main lobe, less one."""

AWAY = 1.0
"""Largest distance, in bins, of a line from the place for which its bins were taken."""

LINKED = 4
"""Distance in bins, beyond twice the order, up to which neighbours are in one group."""

SWEEPS = 5
"""Most fits of all groups in turn: each reduces the effect of groups on one another to 1e-5 or less."""


@jit
def bins_of(order):
    """Return the number of bins of a line: W at their ends weighs the pull of lines that are left out."""
    return 2 * order + 2 * MARGIN


@jit(apart=True)
def update_spectrum(window, work, who, count):
    """Bring the residual spectrum up to date with the first `count` lines of `who`, to the window's floor of the
    largest line so far.
    """
    for i in range(count):
        work.top[0] = max(work.top[0], abs(work.a[0, who[i]]))
    lowest = window.floor * work.top[0]
    for i in range(count):
        k = who[i]
        old, new = work.a[2, k], work.a[0, k]
        change = abs(new - old) + abs(new) * min(abs(work.u[0, k] - work.u[2, k]), 1.0) * 2 * math.pi
        if change > lowest:
            reach = tail_reach(change / lowest, window.order)
            if old != 0.0:
                subtract_line(work.spectrum, window, work.u[2, k], -old, reach, work.lanes)
            subtract_line(work.spectrum, window, work.u[0, k], new, reach, work.lanes)
            work.u[2, k], work.a[2, k] = work.u[0, k], new


@jit
def apart(first, second, samples):
    """Return the number of bins from the second of two places to the first, -N/2 to N/2."""
    bins = (first - second) % samples
    return bins - samples if 2 * bins > samples else bins


@jit(apart=True)
def take_bins(window, work, m):
    """Load the bins of the m lines of a group: the residual spectrum with these lines added back (row 2 of u, a).

    work.kept is 0 for a bin that an earlier line has too; work.near (lines, lines) tells which lines share bins.
    """
    samples, order, each = window.weight.size, window.order, bins_of(window.order)
    odd, whole = (-1.0 if samples % 2 == 0 else 1.0), work.whole  # odd: sign of exp(i N tau)
    for k in range(m):
        work.place[k] = math.floor(work.gu[0, k])
        for b in range(each):
            i, bin = k * each + b, work.place[k] - order - MARGIN + 1 + b
            wrapped = bin % samples
            sign = 1.0 if (bin - wrapped) // samples % 2 == 0 else odd
            whole[0, i], whole[1, i] = sign * work.spectrum[0, wrapped], sign * work.spectrum[1, wrapped]
            work.kept[i] = 1.0
        work.near[k, k] = 1
        for j in range(k):
            shift = apart(work.place[k], work.place[j], samples)
            work.near[k, j] = work.near[j, k] = 1 if abs(shift) < each else 0
            for b in range(max(0, -shift), min(each, each - shift)):
                work.kept[k * each + b] = 0.0
    shapes(window, work, m, 2)
    for l in range(m):
        ar, ai, shape = work.ga[2, l].real, work.ga[2, l].imag, work.shape[l]
        for i in range(m * each):
            whole[0, i] += ar * shape[i]
            whole[1, i] += ai * shape[i]


@jit(apart=True)
def shapes(window, work, m, trial):
    """Fill work.shape and work.slope (lines, bins) with W and W' of the m lines of a group at all their bins.

    W to rounding, by W(d) = -(-1)^p sin(pi delta)/pi prod S_i^2/prod_{i=-p..p} X_(j+i), with X_j = (-1)^j S(j - delta)
    and d = j - delta; W', which only sets the direction of steps, up to O(N^-2) and, far from its line, roughly.
    """
    samples, order, each, zero = window.weight.size, window.order, bins_of(window.order), window.zero
    odd = -1.0 if samples % 2 == 0 else 1.0
    rise = 1.0 if order % 2 == 0 else -1.0
    for i in range(1, order + 1):
        rise *= window.sine[zero + i] ** 2
    around, inverse = work.around[0], work.around[1]
    for l in range(m):
        middle = math.floor(work.gu[trial, l] + 0.5)
        delta = work.gu[trial, l] - middle
        sp, cp = math.sin(math.pi * delta), math.cos(math.pi * delta)
        sd, cd = math.sin(math.pi / samples * delta), math.cos(math.pi / samples * delta)
        shape, slope = work.shape[l], work.slope[l]
        for i in range(-2 * order, 2 * order + 1):
            around[i + 2 * order] = window.sine[zero + i] * cd - window.cosine[zero + i] * sd
            inverse[i + 2 * order] = 1.0 / (i - delta) if i != 0 else 0.0
        around[2 * order] = 1.0  # its zero goes into `top`, its pole into `centre`
        top = rise * (1.0 if delta == 0.0 else sp / (samples * sd))
        square = delta * delta  # 1/delta - pi cot(pi delta)
        centre = delta * (3.28986813369645 + square * (2.16464646742228 + square * (2.03468612396890 + square * 2.0)))
        for k in range(m):
            first = work.place[k] - order - MARGIN + 1 - middle
            turns = math.floor((first + order + MARGIN) / samples + 0.5)
            sign = 1.0 if turns % 2 == 0 else odd
            first -= turns * samples
            fall = (2 * order + 1) / max(abs(first + order + MARGIN - delta), order + 1.0)
            fall = sp * fall if first + order + MARGIN > 0 else -sp * fall
            for b in range(each):
                x = window.sine[zero + first + b] * cd - window.cosine[zero + first + b] * sd
                below = x
                for i in range(1, order + 1):
                    below *= x * x - window.sine[zero + i] ** 2
                height = -sign * rise / (math.pi * (below if abs(first + b) > order else 1.0))
                shape[k * each + b] = sp * height
                slope[k * each + b] = -height * (math.pi * cp + fall)
            for j in range(max(-order, first), min(order, first + each - 1) + 1):
                product, change = 1.0, centre
                for i in range(j + order, j + 3 * order + 1):
                    product *= around[i]
                    change -= inverse[i]
                value = sign * top / product
                shape[k * each + j - first], slope[k * each + j - first] = value, value * change


@jit
def rest_of_bins(work, count, m, trial):
    """Fill work.rest with the residual of the trial lines in their bins; return the sum of its squares."""
    re, im = work.rest[0], work.rest[1]
    for i in range(count):
        re[i], im[i] = work.whole[0, i], work.whole[1, i]
    for l in range(m):
        ar, ai, shape = work.ga[trial, l].real, work.ga[trial, l].imag, work.shape[l]
        for i in range(count):
            re[i] -= ar * shape[i]
            im[i] -= ai * shape[i]
    total = 0.0
    for i in range(count):
        re[i] *= work.kept[i]
        im[i] *= work.kept[i]
        total += re[i] * re[i] + im[i] * im[i]
    return total


@jit(apart=True)
def bin_equations(work, each, m):
    """Fill matrix and gradient of the fit in (Re a, Im a, |a| u) of m lines over their bins.

    The matrix leaves out the overlap of two lines at the bins of others if both are far from these.
    """
    matrix, gradient, kept, re, im = work.matrix, work.gradient, work.kept, work.rest[0], work.rest[1]
    for k in range(m):
        a, v, d, r = work.ga[0, k], work.shape[k], work.slope[k], 3 * k
        pk = a / abs(a) if abs(a) > 0.0 else 1.0 + 0j
        g0, g1, g2, g3 = 0.0, 0.0, 0.0, 0.0
        for i in range(m * each):
            g0 += v[i] * re[i]
            g1 += v[i] * im[i]
            g2 += d[i] * re[i]
            g3 += d[i] * im[i]
        gradient[r], gradient[r + 1], gradient[r + 2] = g0, g1, -(pk.real * g2 + pk.imag * g3)
        for j in range(k + 1):
            a, w, e, c = work.ga[0, j], work.shape[j], work.slope[j], 3 * j
            pj = a / abs(a) if abs(a) > 0.0 else 1.0 + 0j
            vw, ve, dw, de = 0.0, 0.0, 0.0, 0.0
            for l in range(m):
                if work.near[l, k] + work.near[l, j] > 0:
                    for i in range(l * each, (l + 1) * each):
                        x, y = kept[i] * v[i], kept[i] * d[i]
                        vw += x * w[i]
                        ve += x * e[i]
                        dw += y * w[i]
                        de += y * e[i]
            matrix[r, c], matrix[r, c + 1], matrix[r, c + 2] = vw, 0.0, -pj.real * ve
            matrix[r + 1, c], matrix[r + 1, c + 1], matrix[r + 1, c + 2] = 0.0, vw, -pj.imag * ve
            matrix[r + 2, c], matrix[r + 2, c + 1] = -pk.real * dw, -pk.imag * dw
            matrix[r + 2, c + 2] = (pj.conjugate() * pk).real * de


@jit(apart=True)
def cholesky(matrix, factor, n, damping):
    """Factor the lower triangle of matrix + damping*diag(matrix); tiny pivots are kept positive."""
    for i in range(n):
        for j in range(i + 1):
            x = matrix[i, j] * (1.0 + damping if i == j else 1.0)
            for k in range(j):
                x -= factor[i, k] * factor[j, k]
            factor[i, j] = math.sqrt(max(x, 1e-15 * matrix[i, i])) if i == j else x / factor[j, j]


@jit(apart=True)
def substitute(factor, n, x):
    """Solve factor factor^T x = x in place."""
    for i in range(n):
        for k in range(i):
            x[i] -= factor[i, k] * x[k]
        x[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= factor[k, i] * x[k]
        x[i] /= factor[i, i]


@jit
def trial_step(work, u, a, m, damping):
    """Solve for a damped step of at most half a bin per line and write the trial lines: row 1 of u, a."""
    cholesky(work.matrix, work.factor, 3 * m, damping)
    for k in range(3 * m):
        work.step[k] = work.gradient[k]
    substitute(work.factor, 3 * m, work.step)
    for k in range(m):
        size = abs(a[0, k])
        move = work.step[3 * k + 2] / size if size > 0.0 else 0.0
        u[1, k] = u[0, k] + min(max(move, -0.5), 0.5)
        a[1, k] = a[0, k] + complex(work.step[3 * k], work.step[3 * k + 1])


@jit
def accept(u, a, m):
    """Make the trial lines the current ones."""
    for k in range(m):
        u[0, k], a[0, k] = u[1, k], a[1, k]


@jit(apart=True)
def fit_group(window, work, who, m, strict):
    """Fit the m lines `who` jointly to their bins (Levenberg-Marquardt); return the largest last step in bins, 0 if
    converged.
    """
    u, a, each = work.gu, work.ga, bins_of(window.order)
    for k in range(m):
        u[0, k], a[0, k], u[2, k], a[2, k] = work.u[0, who[k]], work.a[0, who[k]], work.u[2, who[k]], work.a[2, who[k]]
    take_bins(window, work, m)
    for k in range(m):
        if u[0, k] != u[2, k]:  # else the shapes are known
            shapes(window, work, m, 0)
            break
    cost = rest_of_bins(work, m * each, m, 0)
    bin_equations(work, each, m)
    damping, last = 0.0, 0.0
    for _ in range(12 if strict else 8):
        trial_step(work, u, a, m, damping)
        top, small, away, sound, last = 0.0, True, False, True, 0.0
        for k in range(m):
            top = max(top, abs(a[0, k]))
        enough = max(EPS * top, (1e-3 if strict else 0.01) * math.sqrt(cost))
        for k in range(m):
            move = abs(u[1, k] - u[0, k])
            last = max(last, move)
            small = small and (move <= 1e-8 or move * abs(a[0, k]) <= enough)
            sound = sound and move <= 0.5 and abs(a[1, k]) < math.inf
            away = away or abs(u[1, k] - work.place[k] - 0.5) > 0.5 + AWAY
        if not sound:
            last = 1.0
            break
        if small and damping <= 1e-3:
            accept(u, a, m)
            last = 0.0
            break
        shapes(window, work, m, 1)
        trial = rest_of_bins(work, m * each, m, 1)
        if trial <= cost * (1.0 + 1e-6) + (EPS * top) ** 2:
            accept(u, a, m)
            if away:
                take_bins(window, work, m)
                shapes(window, work, m, 0)
                trial = rest_of_bins(work, m * each, m, 0)
            cost, damping = trial, (0.1 * damping if damping > 1e-4 else 0.0)
            bin_equations(work, each, m)
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e9:
                break
    for k in range(m):
        work.u[0, who[k]], work.a[0, who[k]] = u[0, k], a[0, k]
    return last


@jit(apart=True)
def couple(work, who, m):
    """Set work.coupling of the lines of the group that was fitted last: the factor of their errors due to others."""
    cholesky(work.matrix, work.factor, 3 * m, 0.0)
    for k in range(m):
        work.step[: 3 * m] = 0.0
        work.step[3 * k + 2] = 1.0
        substitute(work.factor, 3 * m, work.step)
        widened = work.step[3 * k + 2] * work.matrix[3 * k + 2, 3 * k + 2]
        work.coupling[who[k]] = math.sqrt(widened) if widened > 0.0 else math.inf  # lines that are not resolved


@jit
def group_of(start, work, m, samples, reach, who):
    """Write to `who` the lines linked to line `start` of m by a chain of distances of at most `reach` bins; return
    their number.
    """
    who[0], count, looked = start, 1, 0
    while looked < count:
        i = who[looked]
        looked += 1
        for j in range(m):
            if abs(apart(math.floor(work.u[0, i]), math.floor(work.u[0, j]), samples)) <= reach:
                known = False
                for q in range(count):
                    known = known or who[q] == j
                if not known:
                    who[count] = j
                    count += 1
    return count


@jit
def settle_lines(window, work, m):
    """Fit m lines, subtracted from the spectrum, group by group until none moves; return the last step in bins, 0 if
    converged.
    """
    samples, last = window.weight.size, 0.0
    for _ in range(SWEEPS):
        last, moved = 0.0, 0.0
        for k in range(m):
            work.done[k] = 0
        for k in range(m):
            if work.done[k] == 0:
                count = group_of(k, work, m, samples, 2 * window.order + LINKED, work.who)
                for i in range(count):
                    work.done[work.who[i]] = 1
                last = max(last, fit_group(window, work, work.who, count, True))
                couple(work, work.who, count)
                for i in range(count):
                    l = work.who[i]
                    moved = max(moved, abs(work.u[0, l] - work.u[2, l]))
                update_spectrum(window, work, work.who, count)
        if moved <= 1e-7 or last > 0.0:
            break
    return last
