"""Classes of users with an `if`, in modules of any name: compared with differences like others, and run like others."""

import importlib
import itertools
import linecache
import sys
from typing import NamedTuple

import numpy as np
import pytest

import fastaff as fa

Z = np.array([[0.0, 0.1], [-0.15, 0.2], [0.45, 0.1], [0.1, -0.2]])

PARTS = {
    "velocity": ("p, q", "p, q", 2),
    "force": ("x, y", "-x - 2*x*y, -y - x*x + y*y", 2),
    "kinetic_energy": ("p, q", "0.5*(p*p + q*q)", 1),
    "potential_energy": ("x, y", "0.5*(x*x + y*y) + x*x*y - y*y*y/3", 1),
    "margin": ("x, y", "1.0 + 0.0*x", 1),
    "tangent_force": ("x, y, dx, dy", "-dx - 2*(x*dy + y*dx), -dy - 2*x*dx + 2*y*dy", 2),
}
"""Methods of the system of Henon and Heiles: their arguments, values and the number of these."""


def written(branches=(), **instead):
    """Return the text of a class, with an `if` in some methods, and other formulas in some."""
    lines = ["from typing import NamedTuple", "", "", "class Mine(NamedTuple):", "    unused: float = 1.0"]
    lines += ["    degrees_of_freedom = 2", "    coordinates = ('x', 'y')"]
    for name, (arguments, values, count) in PARTS.items():
        lines.append(f"    def {name}(self, {arguments}):")
        if name in branches:
            zero = ", ".join(["0.0*" + arguments[0]] * count)
            lines += [f"        if {arguments[0]} > 1e9:", f"            return {zero}"]
        lines.append(f"        return {instead.get(name, values)}")
    return "\n".join(lines) + "\n"


NUMBER = itertools.count()


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A function that writes a module of a name and returns the model in it."""
    monkeypatch.syspath_prepend(str(tmp_path))
    names = []

    def make(name="mine", *branches, **instead):
        name = f"{name}_{next(NUMBER)}"
        (tmp_path / f"{name}.py").write_text(written(branches, **instead))
        importlib.invalidate_caches()
        names.append(name)
        return importlib.import_module(name).Mine()

    yield make
    for name in names:
        sys.modules.pop(name, None)
    linecache.clearcache()


@pytest.mark.parametrize(
    "branches", [("velocity", "kinetic_energy", "margin"), ("force", "potential_energy", "tangent_force")]
)
def test_methods_with_a_branch_run_like_those_without(made, branches):
    """Each method of the model, beside three without a branch."""
    right = fa.HenonHeiles()
    model = made("mine", *branches)
    np.testing.assert_allclose(
        fa.integrate(model, Z, time=3.0).z, fa.integrate(right, Z, time=3.0).z, rtol=1e-11, atol=1e-12
    )


def test_a_tangent_force_with_a_branch_gives_the_classification_of_one_without(made):
    z = [0.0, -0.15, 0.45, 0.1]
    assert fa.chaos_map(made("mine", "tangent_force", "force"), z, time=1500.0).chaotic.all()


WRONG = {
    "tangent_force": ("-dx, -dy", "a tangent_force that is the change of its rates"),
    "force": ("-1.001*x - 2*x*y, -y - x*x + y*y", r"rates dH/dp and -dH/dq of its energy H: .* of p_x is .* \(force\)"),
    "velocity": ("p, 0.999*q", r"rates dH/dp and -dH/dq of its energy H: .* of y is .* \(velocity\)"),
}


@pytest.mark.parametrize("name", ["mine", "fastaff_wrong", "fastaff_formula_wrong", "fastaff"])
@pytest.mark.parametrize("method", WRONG)
def test_wrong_derivatives_are_refused_with_branches_and_in_modules_of_any_name(made, name, method):
    """A chaotic orbit was regular by a wrong tangent force with an `if`."""
    formula, match = WRONG[method]
    for branches in ((), (method,), tuple(PARTS)):
        with pytest.raises(ValueError, match=f"model Mine must have {match}") as error:
            fa.integrate(made(name, *branches, **{method: formula}), Z, time=1.0)
        assert len(str(error.value)) <= 200


def test_a_subclass_of_a_generated_model_is_compared():
    base = type(fa.hamiltonian("(x**2 + y**2)/2 + x**2*y - y**3/3"))

    class Patched(base):
        def force(self, x, y):
            return -1.5 * x, -y

    with pytest.raises(ValueError, match="model Patched must have"):
        fa.integrate(Patched(), Z, time=1.0)


def test_methods_without_numbers_are_refused_by_class_and_method(made):
    calls = {
        "force": ("x + y*1j, y", "model Mine.* does not give numbers .* some are complex"),
        "kinetic_energy": ("p*(1 + 0j)", "model Mine.* does not give numbers .* some are complex"),
        "potential_energy": ("None", "model Mine.* does not give numbers .* others are given"),
    }
    for method, (formula, match) in calls.items():
        with pytest.raises(TypeError, match=match):
            fa.integrate(made("mine", **{method: formula}), Z, time=1.0)
    with pytest.raises(TypeError, match=r"model Mine\.tangent_force must give real numbers, some are complex"):
        fa.chaos_map(made("mine", tangent_force="dx*1j, dy"), Z, time=10.0)
    with pytest.raises(TypeError, match=r"Broken.force does not give numbers \(TypeError"):
        fa.models.mechanics.system_of(Broken()).forces(np.ones((4, 3)))


class Broken(NamedTuple):
    """A class whose force gives a number at no point."""

    unused: float = 1.0
    degrees_of_freedom = 2

    def force(self, x, y):
        return x + "text", y


def test_points_outside_of_a_domain_are_nan_and_the_others_are_not():
    from math import sqrt

    from fastaff.engine.values import at_points

    class Root(NamedTuple):
        k: float = 2.0

        def value(self, x, y):
            return (self.k * sqrt(x), y) if x < 5 else (1 / (x - 7), 0.0)

    x = np.array([[4.0, -1.0], [7.0, 8.0]])
    first, second = at_points(Root(), "value", x, 3.0)
    np.testing.assert_array_equal(first, [[4.0, np.nan], [np.nan, 1.0]])
    np.testing.assert_array_equal(second, [[3.0, np.nan], [np.nan, 0.0]])
