"""Maps and tracks of MAD-X and MAD-NG, in the text of their files: against maps composed in NumPy, PyAT and MAD-NG."""

import ctypes
import itertools

import numpy as np
import pytest
from scipy.linalg import expm

import fastaff as fa
from fastaff.systems.models.maps import symplectic_defect

J = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))
NAMES = ("x", "px", "y", "py", "t", "pt")
SWAP = [0, 2, 1, 3]
"""x, y, px, py among x, px, y, py, and back."""


def _product(a, b, order):
    """Product of two series {exponents: value}, cut at an order."""
    found = {}
    for (p, u), (q, v) in itertools.product(a.items(), b.items()):
        power = tuple(np.add(p, q))
        if sum(power) <= order:
            found[power] = found.get(power, 0.0) + u * v
    return found


def _sum(*terms):
    """Sum of factors times series."""
    found = {}
    for factor, series in terms:
        for power, value in series.items():
            found[power] = found.get(power, 0.0) + factor * value
    return found


def _ring(rng, kicks):
    """Linear parts (rows x, y, px, py), each with a thin sextupole behind it; the last has none."""
    parts = []
    for k in range(kicks + 1):
        focus = np.diag([1.3, 0.8, 1.1, 0.9]) + 0.05 * rng.normal(size=(4, 4))
        parts.append((expm(0.9 * J @ (focus + focus.T) / 2), rng.normal() * 3 if k < kicks else 0.0))
    return parts


def _image(parts, z):
    for matrix, strength in parts:
        x, y, px, py = matrix @ z
        z = np.array([x, y, px - strength / 2 * (x**2 - y**2), py + strength * x * y])
    return z


def _turns(parts, z, turns):
    """States (turns + 1, 4, particles)."""
    found = [z]
    for _ in range(turns):
        found.append(_image(parts, found[-1]))
    return np.array(found)


def _series(parts, order):
    """The Taylor series of x, px, y, py of `_image`."""
    z = [{tuple(np.eye(4, dtype=int)[SWAP[k]]): 1.0} for k in range(4)]  # x, y, px, py in powers of x, px, y, py
    for matrix, strength in parts:
        x, y, px, py = (_sum(*zip(row, z, strict=True)) for row in matrix)
        px = _sum((1.0, px), (-strength / 2, _product(x, x, order)), (strength / 2, _product(y, y, order)))
        z = [x, y, px, _sum((1.0, py), (strength, _product(x, y, order)))]
    return [{power: value for power, value in z[k].items() if value} for k in SWAP]


def _map_table(path, series, extra=()):
    """Write MAD-X's map_table: a closed orbit, a dispersion and the momentum beside the series."""
    lines = ['@ NAME             %09s "MAP_TABLE"', '@ TYPE             %07s "MAP_TAB"']
    lines.append("* NAME COEF N_VECTOR NV ORDER NX NXP NY NYP NDELTAP NT ")
    lines.append("$ %s %le %d %d %d %d %d %d %d %d %d ")
    rows = [(1, (0,) * 6, 1.5e-3), (1, (0, 0, 0, 0, 1, 0), 2.2), (2, (1, 0, 0, 0, 1, 0), 4.0), *extra]
    rows += [(k + 1, (*power, 0, 0), value) for k, row in enumerate(series) for power, value in row.items()]
    for k, power, value in [*rows, (5, (0, 0, 0, 0, 1, 0), 1.0)]:
        name = f'"C{k}_{"".join(map(str, power))}"'
        lines.append(f" {name}  {value:.17g}  {k}  5  {sum(power)}  {'  '.join(map(str, power))}")
    path.write_text("\n".join(lines) + "\n")
    return path


def _damap(path, series, last="         1   1.0000000000000000E+00    1     0 0  0 0  0 1"):
    """Write a damap of MAD-NG: six series, a knob as seventh variable, a closed orbit beside the series."""
    lines = ["[6R] -UNNAMED- ="]
    for k, name in enumerate(NAMES):
        lines += [f"\n {name.upper():8}:  R, NV =   6, MO =  3, NP =   1, PO =  1", " " + "*" * 55]
        lines.append("     I   COEFFICIENT             ORDER   EXPONENTS")
        if k < 4:
            rows = [((0,) * 4, 2e-4), *series[k].items()]
            text = [f"{v:23.16E}   {sum(p):2d}     {p[0]} {p[1]}  {p[2]} {p[3]}  0 0" for p, v in rows]
            text += [f"{0.7:23.16E}    2     1 0  0 0  0 0  7^1", f"{2.0:23.16E}    1     0 0  0 0  0 1"]
            lines += [f"{n + 1:6d}  {entry}" for n, entry in enumerate(text)]
        elif k == 4:
            lines.append("     1   3.0000000000000000E+00    1     1 0  0 0  0 0")
            lines.append("     2   1.0000000000000000E+00    1     0 0  0 0  1 0")
        else:
            lines.append(last)
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("write", [_map_table, _damap])
def test_a_map_with_one_sextupole_is_its_series(tmp_path, write):
    """Its series ends at second order: the map is the ring's, and symplectic."""
    rng = np.random.default_rng(5)
    parts = _ring(rng, 1)
    model = fa.iterated_map(write(tmp_path / "map.dat", _series(parts, 2)))
    z = 0.3 * rng.normal(size=(4, 20))
    np.testing.assert_allclose(np.array(model.iterate(*z)), _image(parts, z), rtol=1e-12, atol=1e-13)
    assert (model.coordinates, model.momenta) == (("x", "y"), ("px", "py"))
    assert model.symplectic
    found = fa.integrate(model, 1e-3 * z, time=50)
    np.testing.assert_allclose(found.z, _turns(parts, 1e-3 * z, 50)[-1], atol=1e-14)


def test_what_is_cut_is_of_the_next_order(tmp_path):
    """Third order of two sextupoles: the image is off by amplitude^4, the symplectic form by amplitude^3."""
    rng = np.random.default_rng(8)
    parts = _ring(rng, 2)
    model = fa.iterated_map(_map_table(tmp_path / "map.tfs", _series(parts, 3)))
    unit = rng.normal(size=(4, 6))
    size = np.array([1e-1, 1e-2])
    off = [np.abs(np.array(model.iterate(*(a * unit))) - _image(parts, a * unit)).max() for a in size]
    form = [symplectic_defect(model, a * unit).max() for a in size]
    assert np.log10(off[0] / off[1]) == pytest.approx(4, abs=0.3)
    assert np.log10(form[0] / form[1]) == pytest.approx(3, abs=0.3)
    assert not model.symplectic
    truth = np.sort(np.abs(np.angle(np.linalg.eigvals(np.linalg.multi_dot([p[0] for p in parts][::-1])))))[::2]
    nu = fa.frequency_map(model, 1e-5 * unit, time=2000).dominant
    assert np.abs(np.sort(np.minimum(nu, 1 - nu), axis=0) - truth[:, None] / (2 * np.pi)).max() < 1e-8


def test_a_table_of_pandas_is_the_same_map(tmp_path):
    pd = pytest.importorskip("pandas")
    path = _map_table(tmp_path / "map.tfs", _series(_ring(np.random.default_rng(1), 1), 2))
    rows = [line.split() for line in path.read_text().splitlines()[2:]]
    frame = pd.DataFrame([entry[:1] + list(map(float, entry[1:])) for entry in rows[2:]], columns=rows[0][1:])
    assert fa.iterated_map(frame) == fa.iterated_map(path)


def test_maps_with_cavities_are_refused(tmp_path):
    series = _series(_ring(np.random.default_rng(1), 1), 2)
    for path in (
        _map_table(tmp_path / "map.tfs", series, [(5, (1, 0, 0, 0, 0, 0), 0.1)]),
        _damap(tmp_path / "map.dat", series, "     1   1.0000000000000000E+00    1     0 1  0 0  0 0"),
    ):
        with pytest.raises(ValueError, match="a map must leave the momentum as it is: switch cavities off"):
            fa.iterated_map(path)


def test_damaps_that_mad_ng_writes(tmp_path):
    """Its own library composes the series and prints them."""
    ng = pytest.importorskip("madng_tpsa")
    library, c = ctypes.CDLL(str(ng.core_library())), ctypes.CDLL(None)
    library.mad_tpsa_print.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_double, ctypes.c_int, ctypes.c_void_p]
    library.mad_tpsa_print.restype = None
    c.fopen.restype, c.fclose.argtypes = ctypes.c_void_p, [ctypes.c_void_p]
    six = ng.Descriptor(6, 5).vars()
    parts = _ring(np.random.default_rng(9), 3)
    z = [six[k] + 0.0 for k in SWAP]
    for matrix, strength in parts:
        x, y, px, py = (sum(float(entry) * old for entry, old in zip(row, z, strict=True)) for row in matrix)
        z = [x, y, px - strength / 2 * (x * x - y * y), py + strength * x * y]
    path = tmp_path / "map.dat"
    path.write_text("[6R] -UNNAMED- =\n")
    file = c.fopen(str(path).encode(), b"a")
    for name, value in zip(NAMES, [*(z[k] for k in SWAP), six[4] + 3 * six[5], six[5] + 0.0], strict=True):
        address = int(ng.ffi.cast("intptr_t", value.ptr))
        library.mad_tpsa_print(address, name.upper().encode(), -1.0, 0, file)
    c.fclose(file)
    model = fa.iterated_map(path)
    points = 0.02 * np.random.default_rng(1).normal(size=(4, 8))
    np.testing.assert_allclose(np.array(model.iterate(*points)), _image(parts, points), atol=2e-7)
    same = fa.iterated_map(_map_table(tmp_path / "map.tfs", _series(parts, 5)))
    np.testing.assert_allclose(np.array(same.iterate(*points)), np.array(model.iterate(*points)), atol=1e-15)


def _track(path, states, lost=None, names=("NUMBER", "TURN", "X", "PX", "Y", "PY", "S")):
    """Write MAD-X's trackone: segments, the end of each turn twice, a particle that is gone from a turn on."""
    lines = ['@ TYPE             %08s "TRACKONE"', "* " + " ".join(names), "$" + " %le" * len(names)]
    for turn, (x, y, px, py) in enumerate(states):
        for where in ("start",) if turn == 0 else ("ring$end", "end"):
            lines.append(f"#segment {2 * turn} 21 {x.size} 5 {where}")
            for k in range(x.size):
                if lost is None or k != lost[0] or turn < lost[1]:
                    lines.append(f" {k + 1} {turn} {x[k]:.17g} {px[k]:.17g} {y[k]:.17g} {py[k]:.17g} 26.5")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_tunes_of_tracks(tmp_path):
    rng = np.random.default_rng(6)
    states = _turns(_ring(rng, 1), 1e-3 * rng.normal(size=(4, 4)), 300)
    own = fa.tunes(states.transpose(1, 2, 0))
    for coordinates in (None, "X Y PX PY"):
        found = fa.tunes(_track(tmp_path / "trackone", states), coordinates=coordinates)
        np.testing.assert_array_equal(found.nu, own.nu)
    gone = fa.tunes(_track(tmp_path / "trackone", states, lost=(2, 150)))
    assert gone.turns.tolist() == [301, 301, 150, 301]
    names = ("id", "turn", "x", "px", "y", "py", "s")
    np.testing.assert_array_equal(fa.tunes(_track(tmp_path / "track.tfs", states, names=names)).nu, own.nu)
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame(
        [(k, turn, *z[:, k]) for turn, z in enumerate(states) for k in range(4)],
        columns=["NUMBER", "TURN", "X", "Y", "PX", "PY"],
    )
    np.testing.assert_array_equal(fa.tunes(frame, coordinates="X Y PX PY").nu, own.nu)


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "twiss.tfs"
    path.write_text('* NAME S BETX\n$ %s %le %le\n"A B" 1.0 nil\n')
    with pytest.raises(ValueError, match=r"samples must be a table of tracking with turn, .* it has name, s, betx"):
        fa.tunes(path)
    with pytest.raises(ValueError, match=r"must be a table of a map with coef, n_vector, .*: no coef"):
        fa.iterated_map(path)
    path.write_text("* NAME S BETX\n$ %s %le %le\nA B 1.0 nil\n")
    with pytest.raises(ValueError, match=r"must have 3 entries in each row, got 'A B 1\.0 nil'"):
        fa.iterated_map(path)
    path.write_text("p1 = p + x; x1 = x + p1")
    with pytest.raises(ValueError, match=r"must be a TFS table .* iterated_map\(path\.read_text\(\)\)"):
        fa.iterated_map(path)
    path.write_text("orbit,time,x,y\n1,0.0,1.0,2.0\n")
    with pytest.raises(ValueError, match=r"of a CSV table give pandas.read_csv\(path\), coordinates="):
        fa.tunes(path, coordinates="x y")
