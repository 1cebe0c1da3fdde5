"""Integer relations k . nu = 0 of many frequency vectors, and a basis of the lattice that they span.

Vectors k have four entries, zero past the number of frequencies. Their exterior products decide: with a primitive set
b1..br (one that extends to a basis of Z^4) and a further k, the minors of (b1..br, k) all vanish where k lies in the
span, and have the greatest common divisor 1 where the set with k is primitive too. Visiting k from the shortest to the
longest and keeping those that leave the set primitive is Minkowski's reduction in the norm of that order.
"""

from __future__ import annotations

import numpy as np

from ...engine.jit import LANES, jit, read_now

FORM = 6


@jit
def _divisor(a, b):
    """Return the greatest common divisor of |a| and |b|."""
    a = abs(a)
    b = abs(b)
    while b:
        a, b = b, a % b
    return a


@jit
def extend(rank, form, k, product):
    """Write the exterior product of form (6,) of degree `rank` with k (4,); return the greatest common divisor of its
    entries.
    """
    for j in range(FORM):
        product[j] = 0
    if rank == 0:
        for j in range(4):
            product[j] = k[j]
    elif rank == 1:
        entry = 0
        for i in range(3):
            for j in range(i + 1, 4):
                product[entry] = form[i] * k[j] - form[j] * k[i]
                entry += 1
    elif rank == 2:  # entries 01 02 03 12 13 23 of the form
        product[0] = form[0] * k[2] - form[1] * k[1] + form[3] * k[0]
        product[1] = form[0] * k[3] - form[2] * k[1] + form[4] * k[0]
        product[2] = form[1] * k[3] - form[2] * k[2] + form[5] * k[0]
        product[3] = form[3] * k[3] - form[4] * k[2] + form[5] * k[1]
    else:  # entries 012 013 023 123
        product[0] = form[0] * k[3] - form[1] * k[2] + form[2] * k[1] - form[3] * k[0]
    divisor = 0
    for j in range(FORM):
        if product[j]:
            divisor = _divisor(product[j], divisor)
    return divisor


@jit
def inside(rank, forms, i, k0, k1, k2, k3):
    """Return whether k lies in the span of the set of lane i: the exterior product vanishes (never for one primitive
    vector).
    """
    if rank == 3:
        return forms[i, 0] * k3 - forms[i, 1] * k2 + forms[i, 2] * k1 - forms[i, 3] * k0 == 0
    if rank == 2:
        return (
            forms[i, 0] * k2 - forms[i, 1] * k1 + forms[i, 3] * k0 == 0
            and forms[i, 0] * k3 - forms[i, 2] * k1 + forms[i, 4] * k0 == 0
            and forms[i, 1] * k3 - forms[i, 2] * k2 + forms[i, 5] * k0 == 0
            and forms[i, 3] * k3 - forms[i, 4] * k2 + forms[i, 5] * k1 == 0
        )
    return False


@jit
def divide(rank, basis, k, g, best):
    """Write to best (4,) the shortest integer vector (k + sum of c_j b_j)/g with |c_j| <= 2 g over basis (4, 4) of
    `rank` rows.
    """
    reach = 4 * g + 1
    shortest = 1 << 40
    for code in range(reach**rank):
        rest = code
        length = 0
        whole = True
        for j in range(4):
            entry = k[j]
            rest = code
            for row in range(rank):
                entry += (rest % reach - 2 * g) * basis[row, j]
                rest //= reach
            whole = whole and entry % g == 0
            length += abs(entry)
        if whole and length < shortest:
            shortest = length
            rest = code
            for j in range(4):
                best[j] = k[j]
            for row in range(rank):
                for j in range(4):
                    best[j] += (rest % reach - 2 * g) * basis[row, j]
                rest //= reach
            for j in range(4):
                best[j] //= g
    sign = 0
    for j in range(4):
        if sign == 0:
            sign = (best[j] > 0) - (best[j] < 0)
    for j in range(4):
        best[j] *= sign


@jit
def adopt(n, rank, k, form, basis, work):
    """Extend a primitive set, basis (4, 4) of `rank` rows with its form (6,), by k (4,) if that is new; return the new
    rank.
    """
    product = work[:FORM]
    better = work[FORM : FORM + 4]
    g = extend(rank, form, k, product)
    if g == 0:
        return rank
    for j in range(4):
        better[j] = k[j]
    if rank + 1 == n:  # every frequency is zero within its width: the whole of Z^n
        for row in range(n):
            for j in range(4):
                basis[row, j] = 1 if row == j else 0
        return n
    if g > 1:
        divide(rank, basis, k, g, better)
        extend(rank, form, better, product)
    for j in range(4):
        basis[rank, j] = better[j]
    for j in range(FORM):
        form[j] = product[j]
    return rank + 1


@jit
def search_block(n, vectors, begin, lanes, nu, width, rank, basis):
    """Fill rank (orbits,) and basis (orbits, 4, 4) of `lanes` orbits from `begin`: relations among vectors (m, 4), by
    length.

    nu, width (4, orbits): a relation is |k . nu| <= sum of |k_i| width_i; an orbit with a NaN has none.
    """
    x = np.full(8 * LANES, np.nan)
    excess = np.empty(LANES)
    forms = np.zeros((LANES, FORM), np.int64)
    work = np.empty(FORM + 4, np.int64)
    for r in range(4):
        for i in range(lanes):
            x[r * LANES + i] = nu[r, begin + i]
            x[(4 + r) * LANES + i] = width[r, begin + i]
    for v in range(vectors.shape[0]):
        k = vectors[v]
        k0 = float(k[0])
        k1 = float(k[1])
        k2 = float(k[2])
        k3 = float(k[3])
        a0 = abs(k0)
        a1 = abs(k1)
        a2 = abs(k2)
        a3 = abs(k3)
        found = 0
        for i in range(LANES):
            distance = abs(k0 * x[i] + k1 * x[LANES + i] + k2 * x[2 * LANES + i] + k3 * x[3 * LANES + i])
            allowed = a0 * x[4 * LANES + i] + a1 * x[5 * LANES + i] + a2 * x[6 * LANES + i] + a3 * x[7 * LANES + i]
            excess[i] = distance - allowed
            found += 1 if distance - allowed <= 0.0 else 0
        if found == 0:
            continue
        for i in range(lanes):
            o = begin + i
            if excess[i] <= 0.0 and not inside(rank[o], forms, i, k[0], k[1], k[2], k[3]):
                rank[o] = adopt(n, rank[o], k, forms[i], basis[o], work)
                if rank[o] == n:
                    x[i] = np.nan  # all relations are found


def relations(block, stop, progress, n, vectors, nu, width, rank, basis):
    """Run `search_block` on the orbits of a block of LANES; progress (blocks,), stop[0] = 1 leaves it out."""
    orbits = nu.shape[1]
    if read_now(stop, 0) == 0:
        begin = block * LANES
        search_block(n, vectors, begin, min(LANES, orbits - begin), nu, width, rank, basis)
        progress[block] = 1.0
