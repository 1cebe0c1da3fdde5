"""Published periodic orbits of three bodies close after their periods."""

import numpy as np
import pytest

import fastaff as fa
from fastaff.exchange.three_bodies import read_three_bodies, three_bodies

# Suvakov & Dmitrasinovic 2013, table I: butterfly I, bumblebee, moth I, goggles, dragonfly; and the figure eight.
SUVAKOV = [
    (0.30689, 0.12551, 6.2356),
    (0.18428, 0.58719, 63.5345),
    (0.46444, 0.39606, 14.8939),
    (0.08330, 0.12789, 10.4668),
    (0.08058, 0.58884, 21.2710),
    (0.347111, 0.532728, 6.324449),
]
# Li & Liao 2017: I.A 1, 2, 3, 4, 17 and I.B 156 with T |E|^(3/2).
EQUAL = [
    (0.3471168881, 0.5327249454, 6.3259139829, 9.238),
    (0.3068934205, 0.1255065670, 6.2346748391, 19.932),
    (0.6150407229, 0.5226158545, 37.3205235945, 15.048),
    (0.5379557207, 0.3414578545, 26.9186696160, 39.075),
    (0.1842784887, 0.5871881740, 63.5343529785, 101.184),
    (0.3980393062, 0.5038904789, 82.2493251383, 116.742),
]
# Li, Jing & Liao 2018, m3 = 0.5: I.A 1, 2, 6.
HALF = [
    (0.2869236336, 0.0791847624, 4.1761292190, 4.538),
    (0.3420307307, 0.1809369236, 13.9153339459, 9.063),
    (0.1908428490, 0.1150772110, 15.9682350284, 22.361),
]


def _page(path, rows, label):
    """Write a table as the pages have it."""
    cells = ['<table><tbody><tr>\n<th width="180">v<sub>1</sub></th>\n']
    for number, row in enumerate(rows):
        entries = "".join(f"<th>    {entry}</th>\n" for entry in row)
        cells.append(
            f'<tr>\n<th>I.A<sub style="margin-left:-15px">{number + 1}</sub>{label}</th>\n{entries}<th>8</th>\n'
        )
    path.write_text("".join(cells))
    return path


def _miss(table):
    found = [
        fa.integrate(table.model, z, time=period, scheme="verner9").z[:, 0] - z
        for z, period in zip(table.z0.T, table.period, strict=True)
    ]
    return np.abs(found).max(axis=1)


@pytest.mark.slow
def test_published_orbits_close(tmp_path):
    """To the digits that are printed, as these orbits amplify them."""
    assert _miss(read_three_bodies(_page(tmp_path / "equal.md", EQUAL, ""))).max() < 1e-6
    both = _page(tmp_path / "half.md", HALF, " &nbsp;(0.5)")
    both.write_text(both.read_text() + _page(tmp_path / "two.md", EQUAL[:1], " &nbsp;(2)").read_text())
    half = read_three_bodies(both, m3=0.5)
    assert half.z0.shape == (12, 3)
    assert _miss(half).max() < 1e-7
    old = three_bodies(*np.array(SUVAKOV).T)
    assert _miss(old).max() < 5e-3


def test_rows_of_text(tmp_path):
    path = tmp_path / "table.txt"
    path.write_text("# v1 v2 T\nbutterfly, 0.3068934205, 0.1255065670, 6.2346748391\nI.B.1 0.46444 0.39606 14.8939\n")
    table = read_three_bodies(path)
    np.testing.assert_array_equal(table.period, [6.2346748391, 14.8939])
    np.testing.assert_array_equal(
        table.z0[:, 1], [-1, 0, 1, 0, 0, 0, 0.46444, 0.39606, 0.46444, 0.39606, -0.92888, -0.79212]
    )
    for rows, m3, word in (
        (EQUAL, 0.5, "must be a table with v1, v2 and a period in a row for m3 = 0.5"),
        ([(0.15, *EQUAL[0][1:])], 1.0, "must have scaled periods .* row 0"),
    ):
        with pytest.raises(ValueError, match=word):
            read_three_bodies(_page(path, rows, " (1)"), m3=m3)
    with pytest.raises(ValueError, match="m3 must be"):
        three_bodies(0.1, 0.2, 3.0, m3=-1.0)
