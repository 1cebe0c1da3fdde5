"""Backbone curves, scars, names along lines, animations: values on the artists, properties of the files."""

from __future__ import annotations

import base64
import dataclasses
import inspect
import itertools
import shutil
from types import SimpleNamespace

import numpy as np
import pytest

import fastaff as fa
from fastaff import plot
from fastaff.periodic import Stability
from fastaff.plot import labels as plot_labels
from fastaff.plot import periodic, scars
from fastaff.systems.models.maps import StandardMap

matplotlib = pytest.importorskip("matplotlib")
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

HH, X = fa.HenonHeiles(), fa.Hyperplane((1.0, 0.0, 0.0, 0.0))
NEO = fa.Body(fa.NeoHookean())


@pytest.fixture(scope="module")
def orbits():
    guesses = np.array([[0.0, 0.0, 0.3, 0.31], [0.0, 0.0, 0.34, -0.29]]).T
    return fa.periodic_orbits(HH, guesses, section=X, energy=0.1, max_time=20.0, step=0.1)


@pytest.fixture(scope="module")
def branch(orbits):
    return fa.continuation(HH, orbits.z[:, 0], section=X, max_steps=6, max_time=20.0, step=0.1, ds_max=0.05)


# --- backbone curves -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angular", [False, True])
def test_backbone_is_frequency_against_energy(ax, branch, angular):
    drawn = plot.plot_backbone(branch, ax=ax, angular=angular)
    at = np.isin(drawn.points[0].get_xdata(), branch.parameter)  # between are those that smooth the curve
    solid, dashed = (line.get_ydata()[at] for line in drawn.points)
    turn = 2 * np.pi if angular else 1.0
    np.testing.assert_array_equal(drawn.points[0].get_xdata()[at], branch.parameter)
    found = np.where(np.isfinite(solid), solid, dashed)
    np.testing.assert_allclose(found, turn / branch.orbits.period, rtol=1e-15)
    stable = branch.orbits.stability == Stability.ELLIPTIC
    assert np.isfinite(solid[stable]).all()
    assert np.isfinite(dashed[~stable]).all()
    assert "frequency" in ax.get_ylabel()


def test_stability_changes_the_line_and_bifurcations_are_marked(ax, branch):
    n = len(branch)
    reduced = branch.orbits.reduced_monodromy.copy()
    reduced[..., : n // 2] = np.array([[0.0, 1.0], [-1.0, 0.0]])[..., None]  # residue 1/2
    reduced[..., n // 2 :] = np.array([[2.0, 0.0], [0.0, 0.5]])[..., None]  # multipliers 2 and 1/2
    event = fa.periodic.Bifurcation(fa.periodic.Event.FOLD, 0.5, 0.11, branch.orbits.z[:, 0], 6.4, 1e-9)
    half = dataclasses.replace(
        branch, orbits=dataclasses.replace(branch.orbits, reduced_monodromy=reduced), bifurcations=(event,)
    )
    drawn = plot.plot_backbone([half, half], ax=ax, names=["a", "a"])
    at = np.isin(drawn.points[0].get_xdata(), half.parameter)
    solid, dashed = (np.isfinite(line.get_ydata()[at]) for line in drawn.points[:2])
    assert solid.tolist() == [k < n // 2 for k in range(n)]
    assert dashed.tolist() == [k >= n // 2 - 1 for k in range(n)], "the curves meet"
    (mark,) = drawn.lines
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (0.11, 1 / 6.4)
    assert [text.get_text() for text in drawn.labels] == ["a", "stable", "unstable", "fold"]
    with pytest.raises(ValueError, match="names must have 1 entries"):
        plot.plot_backbone(half, ax=ax, names=["a", "b"])


@pytest.mark.parametrize(
    ("model", "z0", "names"),
    [
        (StandardMap(0.9), [3.0, 0.1], ("$x$", "$p$")),
        (fa.iterated_map("v1 = v + K*sin(u); u1 = u + v1", periodic={"u": "2*pi"}, K=0.9), [0.1, 3.0], ("$u$", "$v$")),
    ],
)
def test_periodic_orbits_are_marked_in_the_coordinates_that_a_system_has(ax, model, z0, names):
    """Their names are its own: the momentum of x need not be p_x."""
    drawn = plot.plot_periodic(fa.periodic_orbits(model, z0), ax=ax)
    found = dict(zip((ax.get_xlabel(), ax.get_ylabel()), (drawn.points[0].get_xdata(), drawn.points[0].get_ydata())))
    assert {*found} == {*names}
    np.testing.assert_allclose([found[name][0] for name in names], [np.pi, 0.0], atol=1e-9)


# --- scars -----------------------------------------------------------------------------------------------------------


def test_periodic_orbits_close_over_what_is_drawn(ax, orbits):
    ax.plot([-0.2, 0.4], [-0.1, 0.3])
    limits = ax.get_xlim(), ax.get_ylim()
    drawn = plot.plot_scars(orbits, HH, ax=ax, points=60)
    assert (ax.get_xlim(), ax.get_ylim()) == limits
    fine = np.flatnonzero(orbits.status == 0)
    assert len(drawn.points) == fine.size
    assert drawn.missing == len(orbits) - fine.size
    for k, curve in zip(fine, drawn.points):
        x, y = curve.get_data()
        assert (x[0], y[0]) == (orbits.z[0, k], orbits.z[1, k])
        assert np.hypot(x[-1] - x[0], y[-1] - y[0]) < 1e-6
        z = scars.traced(HH, orbits, 60)[:, :, k]
        H = HH.kinetic_energy(z[2], z[3]) + HH.potential_energy(z[0], z[1])
        np.testing.assert_allclose(H, 0.1, atol=1e-8)
        assert curve.get_linestyle() == ("-" if orbits.stability[k] == Stability.ELLIPTIC else "--")
    with pytest.raises(ValueError, match="chart must be one of"):
        plot.plot_scars(orbits, HH, ax=ax, chart=fa.charts.ELLIPTIC)
    ax.set_xlabel("$r$")
    with pytest.raises(ValueError, match="chart must be that of the axes"):
        plot.plot_scars(orbits, HH, ax=ax)


def test_reduced_orbits_are_on_the_sheet_of_the_charts():
    points = np.array([[1.0, 1.2], [-0.3, 0.4], [0.1, 0.2], [0.5, -0.6]])
    names = ("alpha", "beta", "p_alpha", "p_beta")
    found = periodic.on_one_sheet(points, names)
    assert found.tolist() == [[1.0, 1.2], [0.3, 0.4], [0.1, 0.2], [-0.5, -0.6]]
    assert periodic.on_one_sheet(points, ("x", "y", "p_x", "p_y")) is points


def test_invariants_of_charts_are_those_of_the_charts():
    alpha, beta = np.array([1.3, 0.9]), np.array([0.4, 0.2])
    z = np.zeros((8, 2))
    z[0], z[2] = alpha, beta
    for chart in scars.PLANES:
        np.testing.assert_allclose(scars.in_plane(alpha, beta, chart), chart.from_planes(z)[:2], rtol=1e-14)


# --- names along lines -----------------------------------------------------------------------------------------------


def drawn_box(text):
    """The rectangle of a rotated text as it is drawn, in pixels."""
    renderer = text.figure.canvas.get_renderer()
    angle = np.radians(text.get_rotation())
    text.set_rotation_mode("anchor")
    turned = text.get_transform_rotates_text()
    text.set_transform_rotates_text(False)
    text.set_rotation(0)
    box = text.get_window_extent(renderer)
    text.set_rotation(np.degrees(angle))
    text.set_transform_rotates_text(turned)
    x, y = text.axes.transData.transform(text.get_position())
    if turned:
        angle = np.radians(text.axes.transData.transform_angles([np.degrees(angle)], [text.get_position()])[0])
    return plot_labels.LabelBox(np.array([x, y]), np.array([box.width, box.height]) / 2, float(angle))


def test_boxes_overlap_where_they_do():
    rng = np.random.default_rng(5)
    for _ in range(200):
        one, two = (
            plot_labels.LabelBox(rng.uniform(0, 10, 2), rng.uniform(0.5, 4, 2), rng.uniform(0, np.pi)) for _ in range(2)
        )
        grid = np.array(np.meshgrid(*[np.linspace(-1, 1, 41)] * 2)).reshape(2, -1)
        inside = []
        for a, b in ((one, two), (two, one)):
            c, s = np.cos(a.angle), np.sin(a.angle)
            points = a.centre[:, None] + np.array([[c, -s], [s, c]]) @ (grid * a.half[:, None])
            c, s = np.cos(b.angle), np.sin(b.angle)
            local = np.array([[c, s], [-s, c]]) @ (points - b.centre[:, None])
            inside.append((np.abs(local) <= b.half[:, None]).all(axis=0).any())
        if any(inside):
            assert one.overlaps(two)
        elif one.overlaps(two):  # only by less than the grid sees
            smaller = plot_labels.LabelBox(one.centre, one.half * 0.9, one.angle)
            assert not smaller.overlaps(plot_labels.LabelBox(two.centre, two.half * 0.9, two.angle))


def test_the_title_on_the_left_stands_above_the_legend_of_a_web(ax):
    ax.set_title("grey: 2827 orbits without a value", fontsize=9, loc="left")
    part = np.array([[0.5, 0.5], [0.51, 0.5]])
    lines = [fa.frequencies.ResonanceLine((k, -1, 0), k + 1, (part,), np.eye(3, dtype=bool)) for k in (1, 2)]
    plot.plot_web(lines, ax=ax, names=("alpha", "beta", "gamma"), axes=[np.linspace(0, 1, 3)] * 2)
    ax.figure.canvas.draw()
    legend, title = ax.get_legend().get_window_extent(), ax._left_title.get_window_extent()
    assert legend.width > ax.bbox.width - title.width  # side by side they would not fit
    assert title.y0 >= legend.y1 - 2


def test_a_web_is_drawn_over_the_grid_that_it_is_of():
    model = fa.HenonHeiles()
    grid = fa.energy_grid(model, energy=0.1, section="x=0", axes={"y": np.linspace(-0.3, 0.4, 4), "p_y": [-0.1, 0.2]})
    nu = np.stack([np.ones(grid.inaccessible.shape), np.where(np.arange(4)[:, None] < 3, 1.0, 0.7 + np.arange(2))])
    web = fa.resonance_web(nu, axes=grid, max_order=2)
    line = np.array([[-0.1, -0.1], [0.0, 0.2]])
    drawn = [dataclasses.replace(each, lines=(line,)) for each in web]  # one that holds on six of eight points
    points = np.array([[y, p] for y in grid.axes[0][:3] for p in grid.axes[1]])
    for lines, axes in (
        (drawn, None),
        (drawn, grid),
        (drawn, grid.axes),
        ([dataclasses.replace(drawn[0], axes=())], grid),
    ):
        figure = Figure()
        found = fa.plot.plot_web(lines, ax=figure.subplots(), axes=axes)
        np.testing.assert_array_equal(found.points.get_offsets(), points)
    ax = Figure().subplots()
    fa.plot.plot_web(drawn, ax=ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$y$", "$p_{y}$")
    assert found.points.axes.get_xlabel() == "$y$"


def test_names_of_a_web_do_not_overlap_and_the_longest_lines_have_them(ax):
    ax.set(xlim=(0, 1), ylim=(0, 1))
    rng = np.random.default_rng(2)
    lines = []
    for k in range(1, 15):
        t = np.linspace(0, 1, 80)
        u0, v0, slope = rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.9), rng.uniform(-1, 1)
        length = rng.uniform(0.1, 0.5)
        part = np.column_stack([u0 + length * t, v0 + slope * length * t + 0.03 * np.sin(3 * t)])
        lines.append(fa.frequencies.ResonanceLine((k, -k - 1, 0), 2 * k + 1, (part,), None))
    drawn = plot.plot_web(lines, ax=ax, names=("alpha", "beta", "gamma"), labels=8)
    ax.figure.canvas.draw()
    boxes = [drawn_box(text) for text in drawn.labels]
    assert 4 <= len(boxes) <= 8
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])
        assert (box.corners() >= ax.bbox.min - 1).all()
        assert (box.corners() <= ax.bbox.max + 1).all()
    lengths = {
        plot.resonances.formula(line.vector, ("alpha", "beta", "gamma")): plot_labels.pixel_length(ax, line.lines[0])
        for line in lines
    }
    written = [lengths[text.get_text()] for text in drawn.labels]
    assert written == sorted(written, reverse=True), "the longest first"
    assert written[0] == max(lengths.values())


# --- animations ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def body_motion():
    z0 = fa.energy_sample(NEO, section=fa.AlphaTurning(), energy=1.5, p_eta=0.3, p_gamma=0.2, orbits=2, seed=3).z0
    return z0, plot.animate(NEO, z0, time=3.0, frames=5, titles=("a", "b"))


def test_material_lines_follow_the_motion(body_motion):
    z0, made = body_motion
    run = fa.integrate(NEO, z0, time=3.0, samples=4, accuracy=1e-8)
    above, below = made.figure.axes[:2], made.figure.axes[2:]
    for k in (0, 3, 4):
        made.draw(k)
        z = z0 if k == 0 else run.samples[k - 1]
        for motion, ax in enumerate(above):
            # a = (x + u, z - y)/sqrt2, b = (x - u, y + z)/sqrt2 of phi = [[x, y], [z, u]]
            a1, a2, b1, b2 = z[:4, motion] / np.sqrt(2)
            phi = np.array([[a1 + b1, b2 - a2], [a2 + b2, a1 - b1]])
            edge = np.column_stack(ax.lines[0].get_data())
            stretches = np.linalg.svd(phi, compute_uv=False)
            radii = np.hypot(*edge.T)
            assert radii.max() == pytest.approx(stretches[0], rel=2e-3)
            assert radii.min() == pytest.approx(stretches[1], rel=2e-2)
            np.testing.assert_allclose(edge[0], phi[:, 0], rtol=1e-12)
            D1, D2 = (line.get_ydata()[k] for line in below[motion].lines[:2])
            np.testing.assert_allclose([D1, abs(D2)], stretches, rtol=1e-10)
    assert [ax.get_title() for ax in above] == ["a", "b"]


def test_gif_is_whole_and_has_all_frames(body_motion, tmp_path):
    from PIL import Image

    _, made = body_motion
    done = []
    path = plot.save_animation(made, tmp_path / "a.gif", dpi=40, callback=done.append)
    assert done[-1] == 1.0
    with Image.open(path) as image:
        assert (image.n_frames, image.info["duration"], image.info["loop"]) == (5, 40, 0)
        frames = []
        for k in range(5):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB")))
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    assert plot.save_animation(made, tmp_path / "a.gif", dpi=40).name == "a-2.gif"
    assert plot.save_animation(made, tmp_path / "a.gif", dpi=40, overwrite=True).name == "a.gif"
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a-2.gif", "a.gif"]


def test_an_animation_that_fails_leaves_nothing(body_motion, tmp_path):
    def stop(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        plot.save_animation(body_motion[1], tmp_path / "a.gif", dpi=40, callback=stop)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ValueError, match=r"path must end with \.gif or \.mp4"):
        plot.save_animation(body_motion[1], tmp_path / "a.avi")
    with pytest.raises(FileNotFoundError, match="does not exist"):
        plot.save_animation(body_motion[1], tmp_path / "no" / "a.gif")


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_mp4(body_motion, tmp_path):
    path = plot.save_animation(body_motion[1], tmp_path / "a.mp4", dpi=40)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_points_in_their_potential_and_orbits_that_escape(tmp_path):
    z0 = np.array([[0.0, 0.1, 0.3, 0.1], [0.0, 0.9, 0.3, 0.9]]).T
    made = plot.animate(HH, z0, time=30.0, frames=6, titles=("stays", "goes"))
    left, right = made.figure.axes
    made.draw(5)
    run = fa.integrate(HH, z0, time=30.0, samples=40, accuracy=1e-8)
    point = left.lines[2].get_data()
    np.testing.assert_allclose(np.ravel(point), run.samples[-1, :2, 0], rtol=1e-12)
    assert left.get_title() == "stays"
    assert right.get_title().startswith("goes  (")
    assert np.isfinite(np.ravel(right.lines[2].get_data())).all()
    assert base64.b64decode(made._repr_mimebundle_()["image/gif"]).startswith(b"GIF89a")


def test_animations_refuse(body_motion):
    z0, _ = body_motion
    with pytest.raises(ValueError, match="titles must have 2 entries"):
        plot.animate(NEO, z0, time=1.0, frames=3, titles=("a",))
    with pytest.raises(ValueError, match="frames must be"):
        plot.animate(NEO, z0, time=1.0, frames=1)


# --- dynamic aperture ------------------------------------------------------------------------------------------------


def test_the_aperture_is_where_orbits_begin_to_be_lost(ax):
    """Orbits are lost beyond a curve r(angle), drawn at random, or nowhere at an angle."""
    rng = np.random.default_rng(3)
    angles, radii = np.radians(np.arange(0.0, 91.0, 6.0)), np.linspace(0.0, 1.0, 51)
    edge = 0.5 + 0.3 * rng.uniform(-1, 1, angles.size)
    edge[4] = 2.0
    a, r = (each.ravel() for each in np.meshgrid(angles, radii))
    lost = r > np.repeat(edge[None], radii.size, axis=0).ravel()
    turns = np.where(lost, rng.uniform(1, 900, a.size), 1000.0)
    result = SimpleNamespace(t=turns, status=np.where(lost, int(fa.Status.LOST), 0), scheme=None)
    z0 = np.array([0 * a, r * np.cos(a), 0 * a, r * np.sin(a)])
    shuffled = rng.permutation(a.size)
    mixed = SimpleNamespace(t=turns[shuffled], status=result.status[shuffled], scheme=None)
    drawn = plot.plot_aperture(mixed, z0[:, shuffled], ax=ax, x=1, y=3)
    across, up = drawn.lines[0].get_data()
    aperture = np.hypot(across, up)
    np.testing.assert_allclose(np.arctan2(up, across), angles, atol=1e-7)
    np.testing.assert_array_equal(drawn.points.get_offsets(), z0[[1, 3]][:, shuffled].T)
    kept = np.minimum(edge, 1.0)
    assert (aperture <= kept + 1e-12).all()
    assert (aperture > kept - 0.02 - 1e-12).all()
    lowest = np.where(np.arange(angles.size) == 4, 1.0, aperture).argmin()
    np.testing.assert_allclose(np.ravel(drawn.lines[1].get_data()), [across[lowest], up[lowest]], atol=1e-12)
    np.testing.assert_allclose(
        np.ravel(drawn.lines[2].get_data()), [np.cos(np.radians(24)), np.sin(np.radians(24))], atol=1e-7
    )
    assert (ax.get_xscale(), ax.get_yscale()) == ("linear", "linear")
    said = drawn.labels[0].get_text()
    assert said.endswith(", largest 1 (at least)")
    assert abs(float(said.split("mean ")[1].split(",")[0]) - aperture.mean()) < 6e-4
    assert drawn.colorbar.ax.get_ylabel() == "turns survived"
    np.testing.assert_allclose(np.asarray(drawn.points.get_array()), np.clip(mixed.t, 1.0, 1000.0))
    binned = np.hypot(*plot.plot_aperture(result, z0, ax=ax, x=1, y=3, bins=4).lines[0].get_data())
    for k in range(4):  # 16 angles, four in each
        least = edge[4 * k : 4 * k + 4].min()
        assert least - 0.02 - 1e-12 < binned[k] <= min(least, 1.0)
    for wrong, said in ((z0[:, 1:], "z0 must be the starts"), (z0[0], "z0 must be the starts")):
        with pytest.raises(ValueError, match=said):
            plot.plot_aperture(result, wrong, ax=ax)
    with pytest.raises(ValueError, match="x must be"):
        plot.plot_aperture(result, z0, ax=ax, x=4)


def test_the_outline_of_rays_around_the_centre_is_closed(ax):
    angles = np.radians(np.arange(-180.0, 180.0, 10.0))
    a, r = (each.ravel() for each in np.meshgrid(angles, np.linspace(0.1, 1.0, 10)))
    lost = r > 0.55
    result = SimpleNamespace(t=np.where(lost, 5.0, 99.0), status=1 * lost, scheme=None)
    drawn = plot.plot_aperture(result, np.array([r * np.cos(a), r * np.sin(a)]), ax=ax)
    edge = np.column_stack(drawn.lines[0].get_data())
    np.testing.assert_array_equal(edge[0], edge[-1])
    np.testing.assert_allclose(np.hypot(*edge.T), 0.5, atol=1e-12)
    assert drawn.labels[0].get_text() == "dynamic aperture: least 0.5, mean 0.5, largest 0.5"
    assert not drawn.lines[2].get_xdata().size


def test_an_aperture_of_a_grid_of_x_and_y_is_drawn_over_them(ax):
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1, 1, 21), np.linspace(0.0, 1.0, 15)))
    lost = np.hypot(x, y) > 0.7
    result = SimpleNamespace(t=np.where(lost, 10.0, 1000.0), status=np.where(lost, int(fa.Status.LOST), 0), scheme=None)
    drawn = plot.plot_aperture(result, np.array([x, y, 0 * x, 0 * y]), ax=ax)
    np.testing.assert_array_equal(drawn.points.get_offsets(), np.column_stack([x, y]))
    edge = np.column_stack(drawn.lines[0].get_data())
    radius = np.hypot(*edge[np.isfinite(edge).all(axis=1)].T)
    assert ((radius > 0.6) & (radius < 0.8)).all()  # within a cell of 0.7
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("initial row 0", "initial row 1")
    result = SimpleNamespace(t=0 * x + 9.0, status=0 * x, scheme=None)
    whole = plot.plot_aperture(result, np.array([x, y]), ax=Figure().subplots())
    assert whole.labels[0].get_text().endswith("(at least)")
    assert not whole.lines[1].get_xdata().size


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_outline_is_that_of_the_set_connected_with_the_centre(ax, seed):
    """A star-shaped set drawn at random, and an island of survivors that does not count."""
    rng = np.random.default_rng(seed)
    c = rng.uniform(-0.1, 0.1, (2, 3))

    def r(angle):
        return 0.5 + sum(c[0, k] * np.cos((k + 1) * angle) + c[1, k] * np.sin((k + 1) * angle) for k in range(3))

    step = 0.02
    x, y = (each.ravel() for each in np.meshgrid(np.arange(-60, 61) * step, np.arange(-60, 61) * step))
    lost = np.hypot(x, y) > r(np.arctan2(y, x))
    lost &= np.hypot(x - 1.0, y - 1.0) > 0.1
    result = SimpleNamespace(t=np.where(lost, 5.0, 99.0), status=np.where(lost, int(fa.Status.LOST), 0), scheme=None)
    drawn = plot.plot_aperture(result, np.array([x, y]), ax=ax)
    u, v = drawn.lines[0].get_data()
    assert np.nanmax(np.abs(np.hypot(u, v) - r(np.arctan2(v, u)))) < 4 * step
    angles = np.linspace(-np.pi, np.pi, 2001)
    said = drawn.labels[0].get_text().replace(",", "").split()
    least, mean, largest = (float(said[said.index(name) + 1]) for name in ("least", "mean", "largest"))
    np.testing.assert_allclose([least, largest], [r(angles).min(), r(angles).max()], atol=1.5 * step)
    np.testing.assert_allclose(mean, r(angles).mean(), atol=0.3 * step)
    mark = np.ravel(drawn.lines[1].get_data())
    np.testing.assert_allclose(np.hypot(*mark), least, atol=1e-3)
    assert ax.get_xlim()[1] < 1.6 * largest * 1.06


def test_angles_that_wind_are_drawn_within_a_period():
    """A pendulum's portrait: swings as they are, turns between -pi and pi, with gaps where they are brought back."""
    pendulum = fa.hamiltonian("-cos(x)", coordinates="x", periodic={"x": "2*pi"})
    orbits = fa.integrate(pendulum, [[0.0, 0.0, 3.0], [1.0, -2.5, 2.1]], time=20.0, samples=200)
    swing, *turns = plot.plot_orbits(orbits).points
    np.testing.assert_array_equal(swing.get_xdata()[::8], orbits.samples[:, 0, 0])
    for k, curve in enumerate(turns, 1):
        x, p = curve.get_data()
        wound = int(np.rint(np.ptp(np.rint(orbits.samples[:, 0, k] / (2 * np.pi)))))
        assert np.isnan(x).sum() == np.isnan(p).sum()
        assert abs(np.isnan(x).sum() - wound) <= 1  # between the samples an orbit may cross the edge once more
        assert wound > 3
        assert np.nanmax(np.abs(x)) <= np.pi
        at, x_end, p_end = ~np.isnan(x), *orbits.z[:, k]
        np.testing.assert_allclose(p[at] ** 2 / 2 - np.cos(x[at]), p_end**2 / 2 - np.cos(x_end), rtol=1e-5)
    time = plot.plot_orbits(orbits, x="time", y="x", orbits=[1]).points[0]
    assert np.nanmax(np.abs(time.get_ydata())) <= np.pi


def test_the_section_of_a_driven_flow_is_drawn_in_its_own_coordinates():
    """Not over the cosine of the drive, which is 1 on it."""
    for text, names in (("x**4/4 - x**2/2", "x p_x"), ("x**2/2 + y**2/2 + x**2*y", "x p_x")):
        coordinates = "x y" if "y" in text else "x"
        model = fa.hamiltonian(text, coordinates=coordinates)
        driven = fa.ode(model, forces={"x": "f*cos(w*t) - g*p_x"}, f=0.1, w=1.2, g=0.1)
        start = [0.1] * (len(driven.coordinates) - 2) + [1.0, 0.0]
        cut = fa.poincare_map(driven, start, section="sine=0", crossings=5, max_time=100.0)
        drawn = plot.plot_section(cut).points.get_offsets()
        expected = np.array([cut[name][:, 0] for name in names.split()])
        np.testing.assert_array_equal(np.sort(drawn.T), np.sort(expected))


# --- printed ----------------------------------------------------------------------------------------------------------


def grey_looks(lines):
    """What is left of curves in grey: their marks and dashes."""
    return {(line.get_marker(), str(line._unscaled_dash_pattern)) for line in lines}


def test_curves_are_told_apart_in_grey(ax):
    z = np.array([[0.0, 0.1, 0.3, 0.2], [0.0, -0.1, 0.2, 0.1], [0.1, 0.0, 0.0, 0.2]]).T
    orbits = fa.integrate(fa.HenonHeiles(), z, time=20.0, samples=50, step=0.1)
    assert len(grey_looks(plot.plot_orbits(orbits, ax=ax).points)) == 3
    said = {"section": "x=0", "energy": 0.1, "max_time": 20.0, "step": 0.1, "max_steps": 3}
    branches = [fa.continuation(fa.HenonHeiles(), z, **said) for z in ([0.0, 0.0, 0.3, 0.31], [0.0, 0.3, 0.4, 0.0])]
    drawn = plot.plot_backbone(branches, names=("one", "two")).points[0].axes
    assert len({line.get_marker() for line in drawn.get_legend().get_lines()[:2]}) == 2
    assert len({line.get_marker() for line in drawn.lines if line.get_marker() != "None"}) >= 2


def test_many_points_are_an_image_in_a_pdf(ax, tmp_path):
    z = np.array([[0.0, 0.1, 0.3, 0.2], [0.0, -0.1, 0.2, 0.1]]).T
    sizes = {}
    for samples in (400, 60_000):
        orbits = fa.integrate(fa.HenonHeiles(), z, time=600.0, samples=samples, step=0.01)
        drawn = orbits.plot()
        figure = drawn.points[0].figure
        with plot.styled():
            figure.savefig(tmp_path / f"{samples}.pdf")
        text = (tmp_path / f"{samples}.pdf").read_bytes()
        assert (b"/Subtype /Image" in text) == (samples > 400)
        assert b"/FontFile2" in text
        assert b"/Type3" not in text
        sizes[samples] = len(text)
        assert not drawn.points[0].axes.xaxis.get_rasterized()
    assert sizes[60_000] < 1e6


def test_colour_bars_of_two_panels_cover_none():
    """Panels of a figure with no layout of their own: neither bar nor label is drawn over the other panel."""
    values = np.random.default_rng(31).uniform(-9, -1, 4)
    grid = fa.energy_grid(fa.HenonHeiles(), energy=0.1, section="x=0", axes=([-0.2, 0.0, 0.6], [0.0, 0.1]))
    fig = Figure()
    FigureCanvasAgg(fig)
    left, right = fig.subplots(1, 2)
    bars = [plot.plot_diffusion_grid(grid, values, ax=ax, label="a long label").colorbar for ax in (left, right)]
    fig.canvas.draw()
    first, second = (ax.get_tightbbox() for ax in (bars[0].ax, right))
    assert first.x1 < second.x0
    assert bars[1].ax.get_tightbbox().x1 <= fig.bbox.x1
    own = Figure()
    ax = own.subplots()
    own.subplots_adjust(right=0.7)
    plot.plot_diffusion_grid(grid, values, ax=ax)
    assert own.get_layout_engine() is None  # laid out by hand


def test_irregular_orbits_do_not_set_the_frame_of_tunes(ax):
    """40 of 100 with tunes anywhere: the frame is that of the 60 others, and a note counts those beyond."""
    rng = np.random.default_rng(8)
    nu = np.concatenate([rng.uniform(0.2, 0.23, (2, 60)), rng.uniform(0, 1, (2, 40))], axis=1)
    found = fa.frequency_map(fa.models.HenonMap(), [0.1, 0.0], time=256)
    found = dataclasses.replace(
        found,
        names=("x", "y"),
        nu=nu,
        error=np.full(nu.shape, 1e-9),
        dominant=nu,
        dominant_error=np.full(nu.shape, 1e-9),
        basis=np.repeat(np.eye(2, dtype=int)[:, :, None], 100, axis=2),
        **{name: np.zeros(100) for name in ("diffusion", "status", "rank", "energy_error", "t")},
        classification=np.repeat([fa.Classification.REGULAR, fa.Classification.IRREGULAR], [60, 40]),
    )
    plot.plot_frequency_map(found, ax=ax)
    for low, high in (ax.get_xlim(), ax.get_ylim()):
        assert 0.15 < low < 0.2
        assert 0.23 < high < 0.3
    out = (nu < 0.197).any(axis=0) | (nu > 0.233).any(axis=0)
    (said,) = (text.get_text() for text in ax.texts if "beyond" in text.get_text())
    assert int(said.split()[0]) >= out.sum() - 3
    assert said.endswith("of 100 orbits beyond the axes")


def test_starts_far_beyond_the_aperture_do_not_set_its_frame(ax):
    """Survivors within 1 of starts up to 20."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.linspace(-20, 20, 81), np.linspace(0, 20, 41)))
    lost = np.hypot(x, y) > 1.1
    plot.plot_aperture(
        SimpleNamespace(t=np.where(lost, 3.0, 9.0), status=1 * lost, scheme=None), np.array([x, y]), ax=ax
    )
    assert -5 < ax.get_xlim()[0] < -1 < 1 < ax.get_xlim()[1] < 5
    assert -1.01 < ax.get_ylim()[0] < 0 < 1 < ax.get_ylim()[1] < 5
    (said,) = (text.get_text() for text in ax.texts)
    assert ax.get_ylim()[0] > -0.5
    assert said == f"{np.count_nonzero(np.maximum(np.abs(x), y) > 2)} of {x.size} initial conditions beyond the axes"


# --- wrong objects ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in plot.__all__ if name.startswith("plot_")])
def test_figures_name_the_argument_that_is_no_object_of_theirs(name):
    run, draw = fa.integrate(HH, [0.0, 0.1, 0.3, 0.1], time=1.0, samples=5), getattr(plot, name)
    first, *rest = inspect.signature(draw).parameters.values()
    needed = {each.name: each.annotation for each in rest if each.default is each.empty and each.name != "options"}
    needed = {each: "sali" if kind == "str" else np.ones(3) for each, kind in needed.items()}
    takes_runs = name in ("plot_orbits", "plot_aperture", "plot_spacings")  # the last: "is no array"
    for wrong in (3.0, None, "text", *([] if takes_runs else [run, [run]])):
        if name == "plot_spacings" and wrong == 3.0:
            continue  # one spacing
        with pytest.raises(TypeError, match=rf"(?s)^{first.name} (must be|takes) .*(got|;)"):
            draw(wrong, ax=Figure().subplots(), **needed)


def test_figures_draw_objects_like_those_of_their_kind():
    run = fa.integrate(HH, [0.0, 0.1, 0.3, 0.1], time=1.0, samples=5)

    class Alike:
        def __getattr__(self, name):
            return getattr(run, name)

    drawn, own = (plot.plot_orbits(each, ax=Figure().subplots()) for each in (Alike(), run))
    assert drawn.missing == own.missing
    assert len(drawn.points) == len(own.points) == 1
