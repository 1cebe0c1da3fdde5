"""Counts in summaries add up: parts separated by semicolons and commas to their total, or to what they are "of"."""

import re
from dataclasses import replace
from pathlib import Path

import battery
import numpy as np
import pytest
from scipy.stats import binomtest

import fastaff as fa
from fastaff.chaos import Shares
from fastaff.core.classification import is_regular
from fastaff.core.status import Status, describe

RNG = np.random.default_rng(7)
KINDS = [Status.OK, Status.ESCAPED, Status.ENERGY_DRIFT, Status.INTERRUPTED]


def counts(text):
    """Numbers that begin the parts of a list."""
    return [
        int(found) for found in re.findall(r"(?:^|[;,:] |of which )(\d+) [A-Za-z]", re.sub(r"\([^()]*\)", "", text))
    ]


def split(summary):
    """Counts of statuses, and those of the OK ones."""
    head, found, inner = summary.partition(", of which ")
    if not found:
        return counts(summary), None
    inner, _, rest = inner.partition("; ")
    return counts(head) + counts(rest), counts(inner)


def random_status(n):
    return RNG.choice([int(kind) for kind in KINDS], n, p=[0.6, 0.2, 0.1, 0.1])


def adds_up(result):
    outer, inner = split(result.summary())
    assert sum(outer) == result.status.size, result.summary()
    fine = int((result.status == Status.OK).sum())
    assert (inner is None and not fine) or sum(inner) == fine, result.summary()


def test_the_reader_of_this_test():
    text = "5 OK (finished, 3 times), of which 2 regular, 3 undecided (time 80 may decide); 2 ESCAPED (1 of, 9)"
    assert split(text) == ([5, 2], [2, 3])
    assert split(describe(np.array([0, 3, 3]))) == ([2, 1], None)
    assert split(describe(np.array([3, 0, 3]), "1 dull")) == ([2, 1], [1])


@pytest.mark.parametrize("seed", range(4))
def test_chaos_maps(seed):
    found = fa.chaos_map(battery.HH, battery.Z4, **battery.REAL_TIME).take(RNG.integers(2, size=50))
    adds_up(replace(found, status=random_status(50), classification=RNG.integers(3, size=50)))
    adds_up(replace(found, status=np.zeros(50, np.int64), classification=RNG.integers(3, size=50)))
    adds_up(replace(found, status=np.full(50, 3), classification=RNG.integers(3, size=50)))


@pytest.mark.parametrize("seed", range(4))
def test_frequency_maps(seed):
    """All OK orbits are of one class: by the own lines, by another basis, irregular or undecided."""
    call, options = battery.CALLS["frequency_map"]
    found = call(**options).take(np.zeros(50, np.int64))
    n = len(found.nu)
    basis = np.where(RNG.uniform(size=50) < 0.5, np.eye(n, dtype=np.int64)[:, :, None], RNG.integers(-2, 3, (n, n, 50)))
    found = replace(found, status=random_status(50), classification=RNG.choice([0, 2, 3, 4], size=50), basis=basis)
    adds_up(found)
    rows = [[row for row in matrix.T if row.any()] for matrix in basis.T]
    other = [any(np.abs(row).sum() != 1 or row.min() < 0 for row in each) for each in rows]
    places = [any(row[k] != 1 for k, row in enumerate(matrix.T) if row.any()) for matrix in basis.T]
    fine = (found.status == Status.OK) & is_regular(found.classification)
    np.testing.assert_array_equal(found.other_basis, fine & (np.array(other) | places))
    adds_up(replace(found, status=np.full(50, 3)))


def test_resonances_and_periodic_orbits():
    found = battery.result("resonances")
    n = found.status.size
    adds_up(replace(found, status=random_status(n).reshape(found.status.shape)))
    orbits = battery.result("orbits").take(np.zeros(40, np.int64))
    adds_up(replace(orbits, status=random_status(40)))


def test_scans():
    scan = battery.result("scan")
    n, kinds = 12, RNG.integers(0, 9, (4, 12))
    statuses = np.zeros((len(Status), n), np.int64)
    done = np.arange(n) > 2
    kinds[:, ~done] = kinds[:, 5] = 0
    statuses[Status.OK], statuses[Status.ESCAPED] = kinds[:3].sum(axis=0), kinds[3]
    whole = {name: np.zeros(n) for name in ("time", "step", "energy_error")}
    found = replace(
        scan,
        axes=(np.arange(float(n)),),
        orbits=kinds.sum(axis=0),
        regular=kinds[0],
        chaotic=kinds[1],
        undecided=kinds[2],
        recomputed=np.minimum(kinds[0], 1),
        statuses=statuses,
        done=done,
        **whole,
    )
    cases, orbits, recomputed, *_ = found.summary().split("; ")
    assert re.match(r"12 cases: (\d+) of \d+ orbits, (\d+) empty, where the energy reaches nothing, 3 not done$", cases)
    assert sum(map(int, re.findall(r"[:,] (\d+) ", cases))) == 12
    total, *parts = counts(orbits)
    assert total == sum(parts) == kinds.sum()
    assert recomputed == f"{found.recomputed.sum()} of them done again with the fallback scheme"


def test_levels():
    """What is said of some is said of all levels."""
    found = battery.result("levels").take(np.zeros(5, np.int64))
    E, status = found.E.copy(), np.zeros(5, np.int64)
    E[3:], status[2:] = np.nan, Status.NOT_CONVERGED
    assert re.match(
        r"5 levels from .*, 2 of them without an energy, 3 of them not OK; ",
        replace(found, E=E, status=status).summary(),
    )


def test_islands():
    found = fa.islands(np.repeat(battery.POINTS[:, :, None], 5, axis=2), max_islands=4)
    assert sum(counts(found.summary())) == 5


# --- shares of chaotic orbits -----------------------------------------------------------------------------------------


def random_shares(sets):
    """Counts of chaotic, regular and undecided orbits, many and few of each, and none of some."""
    return Shares(*(np.rint(10 ** RNG.uniform(-1, 3, (3, sets))).astype(int) * (RNG.uniform(size=(3, sets)) > 0.15)))


def test_shares_are_those_of_wilson():
    found = random_shares(200)
    for k, (chaotic, regular, undecided) in enumerate(zip(*found)):
        one = found.of(k)
        if chaotic + regular == 0:
            assert np.isnan([one.fraction, *one.interval()]).all()
            continue
        exact = binomtest(int(chaotic), int(chaotic + regular)).proportion_ci(method="wilson")
        np.testing.assert_allclose(one.interval(), exact, atol=1e-9)
        np.testing.assert_allclose(one.fraction, chaotic / (chaotic + regular), atol=0)
        total = chaotic + regular + undecided
        np.testing.assert_allclose(one.bounds, [chaotic / total, (chaotic + undecided) / total], atol=1e-15)


@pytest.mark.parametrize("sets", [1, 7])
def test_a_fraction_is_said_with_what_is_open(sets):
    """The numbers of the sentence: fraction, interval, percent undecided and bounds, least and largest of each."""
    for _ in range(30):
        found = random_shares(sets)
        said, decided = found.said(), found.chaotic + found.regular
        if not decided.any():
            assert said == f"chaotic fraction unknown: none of {found.undecided.sum()} orbits is decided"
            continue
        with np.errstate(all="ignore"):
            share = 100 * found.undecided / found.completed
        parts, heads, places = [found.fraction, found.interval()], ["chaotic fraction ", "95 %: "], [3, 3]
        if found.undecided.any():
            parts = [found.bounds, share, found.fraction, found.interval()]
            heads, places = ["chaotic fraction ", "of all orbits, ", "undecided; ", "95 %: "], [3, 1, 3, 3]
        for part, head, digits in zip(parts, heads, places, strict=True):
            low, high = re.search(head + r"([\d.]+)(?: \.\.\. ([\d.]+))?(?: |$|\))", said).groups()
            np.testing.assert_allclose(float(low), np.nanmin(part), atol=0.501 * 10.0**-digits)
            np.testing.assert_allclose(float(high or low), np.nanmax(part), atol=0.501 * 10.0**-digits)
        assert ("of all orbits" in said) == bool(found.undecided.any())
    assert Shares(*np.array([114, 517, 620])).said() == (
        "chaotic fraction 0.091 ... 0.587 of all orbits, 49.6 % of them undecided; "
        "0.181 of the decided ones (95 %: 0.153 ... 0.213)"
    )


def test_no_share_is_printed_bare():
    """Only `Shares` writes a chaotic fraction."""
    for path in Path(fa.__file__).parent.rglob("*.py"):
        if path.name != "shares.py":
            assert not re.search(r"[Cc]haotic (fraction|share) {", path.read_text()), path
