"""Values of different classes, or of different texts, are not equal, nor are their hashes."""

import copy
import functools
import importlib
import itertools
import pickle
import pkgutil

import pytest

import fastaff as fa
from fastaff.engine.values import told_apart

ROOMS = ("systems.models", "systems.charts", "runs.schemes")


def classes():
    """All NamedTuples of the package's values that are made of numbers alone."""
    for room in ROOMS:
        package = importlib.import_module(f"fastaff.{room}")
        for entry in pkgutil.iter_modules(package.__path__):
            module = importlib.import_module(f"fastaff.{room}.{entry.name}")
            for cls in list(vars(module).values()):
                if isinstance(cls, type) and hasattr(cls, "_fields") and cls.__module__ == module.__name__:
                    yield cls


def test_every_class_of_values_asks_for_the_class():
    found = list(dict.fromkeys(classes()))
    assert len(found) > 50
    for cls in found:
        value, other = (tuple.__new__(cls, [1.0] * len(cls._fields)) for _ in range(2))
        assert value == other
        assert hash(value) == hash(other)
        assert value == other
        assert value != tuple(value)
        assert tuple(value) != value
        assert value != 1.0
        assert value is not None
    values = [tuple.__new__(cls, [1.0] * len(cls._fields)) for cls in found]
    assert len(set(values)) == len(found)
    for one, other in itertools.combinations(values, 2):
        assert (one == other, one != other) == (False, True)


def texts():
    """Systems of different texts with the same parameters, in groups of the same number of fields."""
    yield from (fa.hamiltonian(f"k*x**{n}", coordinates="x", k=1.0) for n in (2, 4, 6))
    yield fa.hamiltonian("k*x**2", coordinates="x", domain="1 - x", k=1.0)
    yield fa.hamiltonian("k*y**2", coordinates="y", k=1.0)
    yield from (fa.iterated_map(f"x1 = k - x**{n} - p; p1 = x", k=1.0) for n in (2, 4))
    yield from (fa.ode(f"x' = v; v' = -k*x**{n}", k=1.0) for n in (1, 3))
    yield from (fa.affine_body(f"k*(D1**{n} + D2**{n})", k=1.0) for n in (2, 4))
    yield fa.HenonHeiles(1.0)
    yield fa.models.StandardMap(1.0)


def test_texts_are_told_apart_and_pickles_are_not():
    made, again = list(texts()), list(texts())
    for k, one in enumerate(made):
        for j, other in enumerate(again):
            assert (one == other, one != other) == (k == j, k != j)
            assert k != j or hash(one) == hash(other)
        copies = pickle.loads(pickle.dumps(one)), copy.deepcopy(one), copy.copy(one)
        assert all(entry == one and hash(entry) == hash(one) for entry in copies)
        if one._fields:
            assert one._replace(**{one._fields[0]: 2.0}) != one
    assert len({*made, *again}) == len(made)


def test_a_cache_of_the_user_answers_for_the_system_that_is_asked():
    asked = []

    @functools.lru_cache
    def energy(model):
        asked.append(model)
        return float(model.potential_energy(2.0))

    two, four = (fa.hamiltonian(f"k*x**{n}", coordinates="x", k=1.0) for n in (2, 4))
    assert (energy(two), energy(four), energy(two), len(asked)) == (4.0, 16.0, 4.0, 2)


def test_one_text_in_two_classes_is_one_text():
    """A process may let a generated class go and make it again."""
    texts = ["k*x**2", "k*x**2", "k*x**4"]
    one, again, other = (told_apart(type("Same", (tuple,), {}), text) for text in texts)
    assert one([1.0]) == again([1.0])
    assert hash(one([1.0])) == hash(again([1.0]))
    assert one([1.0]) != other([1.0])
    assert one([1.0]) != again([2.0])


def test_parts_are_told_apart():
    bodies = fa.Body(fa.models.Harmonic(1.0), mu=1.0), fa.Body(fa.models.Hyperelastic(1.0), mu=1.0)
    assert bodies[0] != bodies[1]
    assert bodies[0] == fa.Body(fa.models.Harmonic(1.0), mu=1.0)

    def spring(x):
        return x * x / 2

    assert fa.univariate(spring) == fa.univariate(spring) != fa.univariate(lambda x: x**4)


@pytest.mark.parametrize(
    ("names", "options"), [("x p_x", {}), ("p_x x", {}), ("p_y x y", {}), ("p_t x", {"drive_period": "2*pi"})]
)
def test_a_coordinate_with_the_name_of_a_momentum_is_refused(names, options):
    with pytest.raises(ValueError, match=r"coordinate 'p_[xyt]' is taken by the momentum of [xyt]"):
        fa.hamiltonian("x**2", coordinates=names, **options)


def test_other_names_of_momenta_make_room_for_such_a_coordinate():
    model = fa.hamiltonian("a**2/2 + b**2/2 + x**2 + p_x**2", coordinates="x p_x", momenta="a b")
    assert fa.integrate(model, [0.1, 0.2, 0.0, 0.0], time=1.0).names == ("x", "p_x", "a", "b")


def test_a_class_with_two_rows_of_one_name_is_refused():
    twice = type("Twice", (type(fa.HenonHeiles()),), {"coordinates": ("x", "p_x")})
    with pytest.raises(ValueError, match="model Twice must have different names of its rows"):
        fa.integrate(twice(), [0.1, 0.2, 0.0, 0.0], time=1.0)


def test_times_whose_steps_have_no_inverse_are_refused():
    for time in (5e-324, 1e-310, 1e-291):
        with pytest.raises(ValueError, match="time must be at least 1e-290, got"):
            fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=time)
    assert fa.integrate(fa.HenonHeiles(), [0.1, 0.0, 0.0, 0.2], time=1e-290).z[0, 0] == 0.1
