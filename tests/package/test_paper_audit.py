"""The audit of the paper: every corrected formula holds, every known erratum is found, and none is lost without a
word.
"""

from __future__ import annotations

import csv
import sys
from collections import Counter
from pathlib import Path

import pytest
from mpmath import cos, cosh, mp, mpf, pi, sin, sinh, sqrt

sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))

import paper_audit
from audit import CHAPTERS, numerics
from audit.record import Chapter, Random, examine, residual

pytestmark = pytest.mark.slow  # 20 s: every formula at 50 digits

# Errata known before this audit, by the words of the paper's place, and the labels of the entries that find them again.
ERRATA = {
    "T_tr + T_int: one index i too many": ["sec. 2, T_tr + T_int"],
    "Hamilton-Jacobi equation: d^2 S/dvarphi dpsi": ["sec. 3, Hamilton-Jacobi"],
    "elliptic metric": ["sec. 3, ds^2 (elliptic)"],
    "h_kappa, h_lambda: V_kappa, V_lambda for V_eta, V_gamma": [
        "sec. 3, h_kappa",
        "sec. 3, h_lambda",
        "sec. 3, V_kappa, V_lambda constant",
    ],
    "K": ["sec. 3, K", "sec. 3, H = K + L", "sec. 3, elliptic involution"],
    "EQ2.2c, and r for rho": ["EQ2.2c", "sec. 3, spherical coordinates"],
    "EQ3.1a, E = omega (J_x + J_y)": ["EQ3.1a", "sec. 4, E = omega (J_x + J_y)"],
    "m, l independent": ["EQ3.2, m and l", "EQ3.6, m and l", "sec. 5, m and l", "EQ4.3, m and l", "EQ5.1, m and l"],
    "EQ3.21a-23a, EQ3.21, EQ3.22, EQ5.1: +-": [
        *("EQ3.21a", "EQ3.22a", "EQ3.23a", "EQ3.21", "EQ3.22", "EQ5.1, (i)", "EQ5.1, (ii)", "EQ5.1, (iii)"),
    ],
    "EQ3.23": ["EQ3.23"],
    "collapse to D1 D2 = 0": ["sec. 4, collapse"],
    "EQa, EQb as two models": ["EQb, a second model"],
    "C/alpha^2": ["EQa, C/alpha^2"],
    "EQa, E(J_eta, J_gamma)": ["EQa, E(J_eta, J_gamma)"],
    "EQa, nu_varphi, nu_psi": ["EQa, nu_varphi", "EQa, nu_psi"],
    "EQa, omega = dE/dJ": ["EQa, omega = dE/dJ"],
    "EQa, regions": ["EQa, second resonance"],
    "EQb, J_r = 2 J_rho and its resonances": ["EQb, E(J_rho)", "EQb, nu_rho - 2 nu_vartheta", "EQb, nu_rho -+ 4"],
    "H-hat": ["sec. 5, H operator"],
    "H_alpha, H_beta": ["sec. 5, H_alpha", "sec. 5, H_beta", "sec. 5, H = H_alpha + H_beta"],
    "Delta with rho": ["sec. 5, Delta (rho, Theta)"],
    "EQ2.2h cited for every V": ["sec. 5, V cited as EQ2.2h"],
    "below EQ4.9": ["EQ4.8, m and l"],
    "EQ4.10": ["EQ4.10"],
    "symmetric top": ["sec. 5, symmetric top", "sec. 5, symmetric top, degeneracy"],
    "prefactors": [
        *(f"sec. 6, f_{q} norm ({model})" for q in ("alpha", "beta") for model in ("harmonic", "EQa")),
        "sec. 6, f_r norm",
        "sec. 6, f_vartheta norm",
    ],
    "epsilon": ["sec. 6, epsilon"],
    "e_vartheta": ["sec. 6, e_vartheta of section 4"],
    "EQ5.2, text": ["sec. 6, effective quantum numbers"],
    "section 7, D1 and D2": ["sec. 7, D1 and D2"],
    "EQ6.4a": ["EQ6.4a"],
    "EQ6.10-6.12, EQ6.16": ["EQ6.10", "EQ6.11", "EQ6.12", "EQ6.16"],
    "EQ6.22": [
        "EQ6.22, delta form",
        "EQ6.22, lambda form",
        "EQ6.22, a form",
        "EQ6.22, any combination",
        "EQ6.22, a -> ia",
    ],
}
NEW = (
    *("EQ2.0", "sec. 3, pi/4-rotation", "EQ2.2h, no collapse", "EQb, level labels", "sec. 4, bounded r"),
    "sec. 3, Gram-Schmidt",
    *("sec. 5, nabla_i skew", "sec. 7, generators of GL(2,R)", "sec. 7, two-side invariant", "sec. 7, complex a"),
    "sec. 3, space, no separability",
)
"""What this audit added to the known errata."""


@pytest.fixture(scope="module")
def findings():
    """All findings by label."""
    found = paper_audit.audit()
    by_label = {finding.formula.label: finding for finding in found}
    assert len(by_label) == len(found), "labels are names: each once"
    return by_label


def test_every_formula_holds_as_printed_or_as_corrected(findings):
    failed = {label: (f.printed, f.corrected, f.verdict) for label, f in findings.items() if f.failed}
    assert not failed
    for finding in findings.values():
        if finding.formula.sides is not None:
            best = finding.printed if finding.corrected is None else finding.corrected
            assert best < finding.formula.threshold


def test_no_formula_is_lost(findings):
    count = Counter(finding.verdict for finding in findings.values())
    assert count == {"holds": 198, "holds with a reading": 17, "corrected": 62, "definition": 23}


@pytest.mark.parametrize("erratum", ERRATA)
def test_known_errata_are_found_again(findings, erratum):
    for label in ERRATA[erratum]:
        finding = findings[label]
        assert finding.printed > 1e-3, label
        assert finding.corrected < finding.formula.threshold, label
        assert finding.formula.correct, label


def test_all_corrections_are_known_or_new(findings):
    mended = {label for label, finding in findings.items() if finding.corrected is not None}
    known = {label for labels in ERRATA.values() for label in labels}
    assert not known & set(NEW)
    assert mended == known | set(NEW)


def test_a_wrong_or_needless_correction_fails(monkeypatch, capsys):
    chapter = Chapter("wrong")
    chapter.states("twice", "2x = x", "3x")(lambda rng: (mpf(1), 2, 3))
    chapter.states("once", "x = x", "x")(lambda rng: (mpf(1), 1, 1))
    chapter.states("fine", "2x = x", "x")(lambda rng: (mpf(1), 2, 1))
    chapter.states("not a number", "x = nan")(lambda rng: ([mpf(1), 1], [1, mp.nan]))
    assert [examine(f).verdict for f in chapter] == ["FAILS", "needless correction", "corrected", "FAILS"]
    monkeypatch.setattr(paper_audit, "CHAPTERS", (chapter,))
    assert paper_audit.main([]) == 1
    assert "4 formulas checked" in capsys.readouterr().out


def test_table_and_csv(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(paper_audit, "CHAPTERS", CHAPTERS[:1])
    assert paper_audit.main(["--csv", str(tmp_path / "audit.csv")]) == 0
    with (tmp_path / "audit.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert [row[0] for row in rows[1:]] == [formula.label for formula in CHAPTERS[0]]
    out = capsys.readouterr().out
    assert all(row[0] in out for row in rows)


# The instruments, against closed forms


def test_residual_is_relative_and_sees_every_entry():
    assert residual([mpf(2), mpf(100)], [mpf(2), mpf(101)]) == pytest.approx(1 / 101)
    assert residual(mpf("0.5"), 0) == 0.5
    assert residual([mpf(1), mp.nan, mpf(2)], [1, 1, 2]) == float("inf")
    with pytest.raises(ValueError, match="zip"):
        residual([1, 2], [1])


def test_loop_of_an_oscillator_and_of_a_free_rotor_well():
    with mp.workdps(50):
        E, C, mu, L = mpf(3), mpf(2), mpf("0.7"), mpf("0.9")
        w = sqrt(C / mu)
        radial = numerics.loop(lambda q: 2 * mu * E - mu * C * q * q - L * L / q**2, mpf("0.9"))
        assert abs(radial - (pi * E / w - pi * L)) < 1e-35
        angle = numerics.loop(lambda t: E**2 - L**2 / sin(t) ** 2, mpf(1), 0, pi)
        assert abs(angle - 2 * pi * (E - L)) < 1e-35


def test_levi_civita_tells_separable_from_non_separable():
    with mp.workdps(50):
        z = Random("separable", 0).reals(4, 0.4, 0.9)
        assert numerics.levi_civita(lambda r, t, p, l: p * p + l * l / r**2 + r, z) < 1e-20
        assert numerics.levi_civita(lambda r, t, p, l: p * p + l * l / r**2 + r * t, z) > 1e-3


def test_bracket_is_canonical():
    with mp.workdps(50):
        z = Random("canonical", 0).reals(4)
        assert abs(numerics.bracket(lambda *z: z[0], lambda *z: z[2], z) - 1) < 1e-20
        assert abs(numerics.bracket(lambda *z: z[0] * z[3] - z[1] * z[2], lambda *z: z[2] ** 2 + z[3] ** 2, z)) < 1e-20


def test_metric_is_the_pullback():
    with mp.workdps(50):
        k, l = Random("metric", 0).reals(2, 0.2, 0.8)
        G = numerics.metric(lambda k, l: [cosh(k) * cos(l), sinh(k) * sin(l)], [k, l])
        truth = sinh(k) ** 2 + sin(l) ** 2
        assert max(abs(G[0, 0] - truth), abs(G[1, 1] - truth), abs(G[0, 1])) < 1e-20


def test_levels_of_the_plane_oscillator():
    import numpy as np

    # -f'' + (p^2 + q^4) f = 2 E q^2 f with q = exp(t): hbar = mu = omega = 1, E = 2n + 1 + p
    found = numerics.levels(lambda t: 4 + np.exp(4 * t), lambda t: 2 * np.exp(2 * t), -12.0, 2.0, 4, 0.08)
    assert found == pytest.approx([3, 5, 7, 9], rel=1e-11)


def test_printed_form_of_the_linear_group_metric_is_minus_det_for_c_minus_2():
    # A remark on EQ6.22: the printed element is conformal to the corrected one, and flat for c = -2, where it is
    # -det(dphi).
    from audit.affine import LINEAR, linear_forms
    from audit.charts import determinant

    with mp.workdps(50):
        rng = Random("conformal", 0)
        q, v = rng.reals(4), rng.reals(4)
        truth = -determinant(numerics.along(LINEAR, q, v))
        assert abs(linear_forms(q, v, -2, 1)[2] / truth - 1) < 1e-20
        assert abs(linear_forms(q, v, -1, 1)[2] / truth - 1) > 1e-3
