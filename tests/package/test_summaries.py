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


def counts(summary):
    """Total of a summary, its counts of classes or OK ones, and those of other statuses."""
    total, _, parts = re.sub(r" \([^()]*\)", "", summary).partition(": ")
    first, *rest = parts.split("; ")
    kinds = [int(found) for found in re.findall(r"(?:^|, )(\d+) (?![A-Z_]{3})", first)]
    failed = [int(found) for part in (first, *rest) for found in re.findall(r"^(\d+) [A-Z_]{3,}$", part)]
    return int(total.split()[0]), kinds, failed


def random_status(n):
    return RNG.choice([int(kind) for kind in KINDS], n, p=[0.6, 0.2, 0.1, 0.1])


def adds_up(result):
    total, kinds, failed = counts(result.summary())
    fine = int((result.status == Status.OK).sum())
    assert (total, sum(kinds), sum(failed)) == (result.status.size, fine, total - fine), result.summary()


def test_the_reader_of_this_test():
    text = "7 orbits: 2 regular, 3 undecided; 2 ESCAPED (1 of; 9); chaotic fraction 0 to 0.6 (3 of 5 undecided)"
    assert counts(text) == (7, [2, 3], [2])
    dull = np.array([False, False, True])
    assert counts(describe(np.array([3, 0, 3]), {"dull": ~dull})) == (3, [1], [2])


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
    said = found.summary()
    total, parts, failed = counts(said)
    assert (total, sum(parts), sum(failed)) == (kinds.sum(), kinds[:3].sum(), kinds[3].sum())
    assert " orbits in 12 cases: " in said
    assert f"; {found.recomputed.sum()} recomputed with the fallback scheme" in said
    assert said.endswith("; 3 cases not done")
    assert re.search(r"; \d+ cases? without accessible points; ", said)


def test_levels():
    """What is said of some is said of all levels."""
    found = battery.result("levels").take(np.zeros(5, np.int64))
    E, status = found.E.copy(), np.zeros(5, np.int64)
    E[3:], status[2:] = np.nan, Status.NOT_CONVERGED
    assert re.match(
        r"5 levels from .*; 2 without an energy; 3 not converged",
        replace(found, E=E, status=status).summary(),
    )


def test_islands():
    found = fa.islands(np.repeat(battery.POINTS[:, :, None], 5, axis=2), max_islands=4)
    total, parts, _ = counts(found.summary())
    assert total == sum(parts) == 5


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
    """The numbers of the sentence: bounds, fraction and interval, least and largest of each."""
    for _ in range(30):
        found = random_shares(sets)
        said, decided = found.fraction_text(), found.chaotic + found.regular
        total, open_ = found.completed.sum(), found.undecided.sum()
        if not total:
            assert said == "chaotic fraction unknown: no orbits"
            continue
        first, places = found.bounds, ["chaotic fraction "]
        parts = [first]
        if open_:
            assert f"({open_} of {total} undecided)" in said
        if not decided.any():
            assert said.endswith("undecided)")
            continue
        with np.errstate(all="ignore"):
            estimates = [found.fraction, found.interval()]
        if open_:
            parts, places = [first, *estimates], ["chaotic fraction ", "undecided\\), ", "95 %: "]
        else:
            parts, places = estimates, ["chaotic fraction ", "95 %: "]
        for part, head in zip(parts, places, strict=True):
            low, high = re.search(head + r"([\d.e-]+)(?: to ([\d.e-]+))?(?: |$|\))", said).groups()
            np.testing.assert_allclose(float(low), np.nanmin(part), atol=0.000501)
            np.testing.assert_allclose(float(high or low), np.nanmax(part), atol=0.000501)
    assert Shares(*np.array([114, 517, 620])).fraction_text() == (
        "chaotic fraction 0.091 to 0.587 (620 of 1251 undecided), 0.181 of the decided orbits (95 %: 0.153 to 0.213)"
    )


def test_no_share_is_printed_bare():
    """Only `Shares` writes a chaotic fraction."""
    for path in Path(fa.__file__).parent.rglob("*.py"):
        if path.name != "shares.py":
            assert not re.search(r"[Cc]haotic (fraction|share) {", path.read_text()), path
