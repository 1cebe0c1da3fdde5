"""The shape of the code (ARCHITECTURE.md): arrows between modules point down, imports are light, names are
documented.
"""

import ast
import functools
import inspect
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from pathlib import Path

import battery
import pytest
from deep import DEEP

import fastaff
from fastaff.exchange.files import ANALYSES
from fastaff.results.calls import is_recorded

ROOT = Path(fastaff.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
PARTS = (
    "core",
    "engine",
    "results",
    "systems",
    "runs",
    "frequencies",
    "sections",
    "chaos",
    "periodic",
    "tori",
    "quantum",
    "plot",
    "exchange",
    "jobs",
    "explorer",
    "cli",
    "__main__",
)
"""Parts of the package from the ground up: each imports only from those before it, or of its own."""
LISTED = (fastaff.runs, fastaff.frequencies, fastaff.sections, fastaff.chaos, fastaff.periodic, fastaff.tori)
"""Parts with lists of results."""
ROOMS = {
    "systems": ("charts", "models", "formulas", "kinematics", "invariant_metrics", "molecules"),
    "quantum": ("kernels", "states", "exact", "solvers", "spectra", "packets", "chaos", "reference", "groups"),
}
"""Folders and modules within a part, in the same order."""
HEAVY = {"zarr", "xarray", "distributed", "scipy", "matplotlib", "sympy", "pandas", "cyclopts", "rich", "IPython"}


@cache
def tree_of(path):
    """The syntax of a file of the package."""
    return ast.parse(path.read_text())


@cache
def nodes_of(path):
    """All nodes of it: a dozen tests read the same."""
    return tuple(ast.walk(tree_of(path)))


@cache
def calls_of(path):
    """Those that are calls of a plain name, each with the name."""
    return tuple(
        (node.func.id, node)
        for node in nodes_of(path)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    )


def module_of(path):
    """Dotted name below the package of a file: engine.kernels.drive."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path):
    """Dotted names below the package that a file imports, anywhere in its text."""
    package = module_of(path).split(".") if path.name == "__init__.py" else module_of(path).split(".")[:-1]
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            for name in node.names:
                if name.name.split(".")[0] == "fastaff":
                    yield name.name.removeprefix("fastaff").lstrip(".")
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                base = package[: len(package) - node.level + 1]
            elif (node.module or "").split(".")[0] == "fastaff":
                base = []
            else:
                continue
            module = (node.module or "").removeprefix("fastaff").lstrip(".") if not node.level else (node.module or "")
            parts = [*base, *filter(None, module.split("."))]
            for name in node.names:
                whole = ".".join([*parts, name.name])
                yield whole if is_module(whole) else ".".join(parts)


@cache
def is_module(name):
    path = ROOT.joinpath(*name.split("."))
    return path.with_suffix(".py").is_file() or path.is_dir()


@cache
def arrows():
    """Modules, each with one that it imports: read when a test asks, not by every process that collects tests."""
    return [(module_of(path), target) for path in FILES for target in imports(path)]


def place(module):
    return PARTS.index(module.split(".")[0])


def test_text_becomes_code_in_two_folders():
    """Loops over lanes around scalar methods, and models of formulas."""
    calls = {module_of(path) for path in FILES for name, _ in calls_of(path) if name in ("exec", "eval", "compile")}
    assert {".".join(name.split(".")[:-1]) for name in calls} == {"engine", "systems.formulas"}


def test_every_part_has_a_place():
    assert {module_of(path).split(".")[0] for path in FILES} - {""} == {*PARTS}
    for part, rooms in ROOMS.items():
        assert {module_of(path).split(".")[1] for path in FILES if module_of(path).startswith(f"{part}.")} == {*rooms}
    entries = [path for path in ROOT.iterdir() if path.name != "__pycache__"]
    assert len(entries) <= ENTRIES, sorted(path.name for path in entries)
    assert len(arrows()) > 30


def test_a_term_of_the_equations_is_at_home_in_four_files():
    """Friction, by its names in code: its value, its row, and its option of texts and of commands. Beside these: the
    field of requests in files of older versions (a new option is one of `others`), and the words of bodies' refusals.
    """
    home = {"engine.damping", "engine.kinds", "systems.formulas.formula", "jobs.system"}
    said = {
        module_of(path)
        for path in FILES
        for node in nodes_of(path)
        if {"friction", "damping_rate", "FRICTION"}
        & {
            getattr(node, name, None)
            for name in ("id", "arg", "attr", "name", "value")
            if name != "value" or is_text(node)
        }
    }
    assert said == home | {"systems.formulas.library", "systems.models.body"}


def is_text(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def test_no_module_is_hidden_by_a_function_of_its_name():
    for package in FILES:
        if package.name == "__init__.py":
            names = {
                a.asname or a.name for n in tree_of(package).body if isinstance(n, ast.ImportFrom) for a in n.names
            }
            modules = {path.stem for path in package.parent.iterdir() if path.suffix == ".py" or path.is_dir()}
            assert not names & modules, package


def test_no_arrow_points_up():
    for source, target in arrows():
        if source and target:
            assert place(target) <= place(source), f"{source} imports {target}"
        assert target or not source or place(source) >= place("exchange"), f"{source} imports the whole package"
        folder, *inside = source.split(".")
        if folder in ROOMS and len(inside) > 1 and target.startswith(f"{folder}."):
            order = ROOMS[folder].index
            assert order(target.split(".")[1]) <= order(inside[0]), f"{source} imports {target}"


def is_kernel(module):
    return "kernels" in module.split(".")


def test_kernels_see_no_models_and_no_python():
    for source, target in arrows():
        if is_kernel(source):
            assert is_kernel(target) or target in (
                *("engine.jit", "engine.lane_flags", "engine.lane_sums", "engine.pointers", "engine.plane_loops"),
                *("engine.elementary", "engine.fused", "core.status"),
            ), f"{source} imports {target}"


def test_modules_import_one_another_without_circles():
    seen = {}

    def visit(module, path):
        assert module not in path, f"circle: {' -> '.join([*path, module])}"
        if module not in seen:
            seen[module] = True
            for source, target in arrows():
                if source == module and target and target != module:
                    visit(target, [*path, module])

    for path in FILES:
        if path.name != "__init__.py":
            visit(module_of(path), [])


def test_only_jit_configures_numba():
    for path in FILES:
        if module_of(path) in ("engine.jit", "engine.blocks", "engine.threads"):
            continue
        names = {
            node.attr
            for node in nodes_of(path)
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "numba"
        }
        assert not names & {"njit", "jit", "cfunc", "vectorize", "guvectorize", "config"}, module_of(path)
    assert "fastmath" not in "".join(p.read_text() for p in FILES)


FENCED = ("numba.core", "numba.extending", "numba.np", "numba.typed", "numba.experimental", "llvmlite")
"""Parts of Numba that are no public interface, or close to none."""


def foreign(path):
    """The dotted names of other packages that a file imports, or reads as attributes of `numba`."""
    for node in nodes_of(path):
        if isinstance(node, ast.Import):
            yield from (entry.name for entry in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield from (f"{node.module}.{entry.name}" for entry in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "numba":
            yield f"numba.{node.attr}"


def test_one_module_imports_the_private_parts_of_numba():
    """docs/developers/numba.md names them, test_numba_private_parts.py tries them."""
    beyond = [
        f"{module_of(path)}: {name}"
        for path in FILES
        if module_of(path) != "engine.numba_private"
        for name in foreign(path)
        if f"{name}.".startswith(tuple(f"{part}." for part in FENCED))
    ]
    assert not beyond


LOOKED_UP = 20
"""Calls of `system_of` in the package: systems are made where models enter or are made, and handed on."""


def test_systems_are_handed_on():
    calls = [module_of(path) for path in FILES for name, _ in calls_of(path) if name == "system_of"]
    assert len(calls) <= LOOKED_UP, calls


def test_analyses_that_files_name_are_all_known():
    """Those public functions that keep their call with their result."""
    public = {
        name: f"{found.__module__}".removeprefix("fastaff.")
        for home in (fastaff, *LISTED, fastaff.quantum)
        for name in home.__all__
        if is_recorded(found := getattr(home, name))
    }
    assert public == ANALYSES


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_the_package_is_light():
    """None of others before a name is used; then what Numba loads by itself (it looks for SciPy) and nothing heavy
    more; no kernel compiled.
    """
    before = set(run("import sys, fastaff; print(*sys.modules)").split())
    assert not {m.split(".")[0] for m in before} & {*HEAVY, "numba", "numpy"}
    assert {m for m in before if m.startswith("fastaff")} == {"fastaff"}
    using, numba = "import sys, fastaff; fastaff.Body; print(*sys.modules)", "import sys, numba; print(*sys.modules)"
    ours, numbas = (set(run(code).split()) for code in (using, numba))
    assert not {m.split(".")[0] for m in ours - numbas} & HEAVY
    assert "numba" in ours
    compiled = run(
        "import fastaff, sys, numba\n"
        "fastaff.Body\n"
        "from numba.core.registry import CPUDispatcher\n"
        "sys.modules['nameless'] = object()\n"  # as others leave there
        "print(sum(bool(v.signatures) for name, m in list(sys.modules.items()) if name.startswith('fastaff')"
        " for v in vars(m).values() if isinstance(v, CPUDispatcher)))"
    )
    assert int(compiled) == 0


MISSING = """
import sys
sys.modules["{package}"] = None
import fastaff, numpy as np
from fastaff import plot
from fastaff.jobs import Job, IntegrateOptions, Store
results = fastaff.integrate(fastaff.HenonHeiles(), [0.1, 0.0, 0.0, 0.1], time=1.0, step=0.1)
asked = {asked}
for act in asked:
    try:
        act()
    except ImportError as problem:
        assert "pip install 'fastaff[{extra}]'" in str(problem) and "{package}" in str(problem), problem
    else:
        raise SystemExit(f"nothing was needed by {{act}}")
print(len(asked))
"""


@pytest.mark.parametrize(
    ("package", "extra", "asked"),
    [
        (
            "matplotlib",
            "plot",
            "[results.plot, plot.styled] + "
            "[lambda n=n: getattr(plot, n)(None, None) for n in plot.__all__ if n.startswith('plot_')]",
        ),
        ("xarray", "io", "[results.to_xarray]"),
        ("h5netcdf", "io", "[lambda: results.save(STORE + '.nc')]"),
        ("pyarrow", "tools", "[lambda: results.save(STORE + '.parquet')]"),
        ("zarr", "io", "[lambda: fastaff.run(Job(initial_conditions=[0.1, 0, 0, 0.1], model=fastaff.HenonHeiles(), "
            "integrate=IntegrateOptions(time=1.0)), STORE)]"),
        ("sympy", "symbolic", "[lambda: fastaff.hamiltonian('x**2*0.7312', coordinates='x'), lambda: "
            "fastaff.iterated_map('p1 = p + 0.7312*sin(x); x1 = x + p1')]"),
    ],
)  # fmt: skip
def test_what_needs_a_package_that_is_missing_says_which_extra(package, extra, asked, tmp_path):
    asked = asked.replace("STORE", repr(str(tmp_path / "store")))
    assert int(run(MISSING.format(package=package, extra=extra, asked=asked))) > 0


def subclasses(*roots):
    """Names of the classes of the package that stand on one of these, themselves on others or not."""
    bases = {
        node.name: {ast.unparse(base).split(".")[-1] for base in node.bases}
        for path in FILES
        for node in nodes_of(path)
        if isinstance(node, ast.ClassDef)
    }
    found = set(roots)
    while more := {name for name, above in bases.items() if above & found} - found:
        found |= more
    return found - set(roots)


def by_position(path):
    """Calls of names that begin as classes do: line, name, values by position, whether one is unpacked; `cls` counts as
    the class around it.
    """
    owners = {n: c.name for c in nodes_of(path) if isinstance(c, ast.ClassDef) for n in ast.walk(c)}
    for node in nodes_of(path):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            unpacked = any(isinstance(value, ast.Starred) for value in node.args)
            yield node.lineno, owners.get(node) if name == "cls" else name, len(node.args), unpacked


def test_results_are_made_by_keyword():
    """At most three values of a result by position and none unpacked, eight of any other value: of arrays of one shape
    nothing else tells that two are swapped. Kernels, whose tuples are compiled, are left out.
    """
    results, values = subclasses("Result"), subclasses("NamedTuple")
    for path in FILES:
        for node in nodes_of(path):
            if isinstance(node, ast.ClassDef) and any("dataclass" in ast.unparse(d) for d in node.decorator_list):
                values.add(node.name)
    assert {"SectionMap", "FrequencyMap", "ChaosMap", "Branch", "LevelTable"} <= results
    assert {"Options", "Series", "Problem"} <= values
    for path in FILES:
        for line, name, count, unpacked in by_position(path):
            where = f"{module_of(path)}:{line} {name}"
            assert name not in results or (count <= 3 and not unpacked), where
            assert name not in values or count <= 8 or is_kernel(module_of(path)), where


PUBLIC = list(battery.PUBLIC.items())
FUNCTIONS = [(name, value) for name, value in PUBLIC if inspect.isfunction(value)]


def by_number(name):
    """The name with the numbers in it as numbers: 8 is before 10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


@pytest.mark.parametrize("folder", [fastaff, *LISTED, fastaff.charts, fastaff.models, fastaff.quantum, fastaff.schemes])
def test_the_list_of_names_is_sorted_and_true(folder):
    names = folder.__all__
    assert len(set(names)) == len(names)
    assert names == sorted(names, key=lambda n: (not n.isupper(), not n[0].isupper(), by_number(n)))
    tree = ast.parse(Path(folder.__file__).read_text())
    logic = [n for n in tree.body if not isinstance(n, (ast.Expr, ast.ImportFrom, ast.Assign, ast.FunctionDef))]
    assert not logic or folder is fastaff
    assert all(hasattr(folder, name) for name in names)


def test_type_checkers_see_the_names_that_are_loaded():
    (block,) = [node for node in tree_of(ROOT / "__init__.py").body if isinstance(node, ast.If) and node.body][:1]
    seen = {(node.module or "", entry.name) for node in block.body for entry in node.names}
    places = {(module, name) for module, names in fastaff._PLACES.items() for name in names}
    assert {name for _, name in places} == {*fastaff.__all__}
    assert places < seen
    assert {name for _, name in seen - places} == {*fastaff._FOLDERS}


def test_public_names_are_there_however_they_are_asked_for():
    """First of all names by attribute, by import, all at once, in two threads; unknown ones load nothing."""
    both = "from concurrent.futures import ThreadPoolExecutor as P\np = P(2)\n"
    asked = {
        "import fastaff as fa; print(fa.Body.__module__)",
        "from fastaff import Body; print(Body.__module__)",
        "from fastaff import *; print(Body.__module__, poincare_map and len(__import__('fastaff').__all__) and '')",
        "import fastaff as fa; from fastaff.systems.models import Body; assert Body is fa.Body; print(Body.__module__)",
        both + "import fastaff as fa\nprint({f.__module__ for f in p.map(lambda k: fa.Body, range(2))}.pop())",
        "import fastaff as fa, pickle; print(pickle.loads(pickle.dumps(fa.Body)).__module__)",
        "import fastaff as fa; print(getattr(fa, dir(fa)[dir(fa).index('Body')]).__module__)",
        "import fastaff as fa; fa.Body = fa.Body; print(fa.Body.__module__)",
    }
    for code in asked:
        assert run(code).split() == ["fastaff.systems.models.body"], code
    assert (
        run("import fastaff as fa, sys; print(hasattr(fa, '_none'), 'numba' in sys.modules)").split() == ["False"] * 2
    )


def test_a_name_of_a_part_is_found_from_the_top():
    """The message names the part that has it, for an attribute and in an import."""
    for name in ("spectrum", "SectionMap", "ALPHA_BETA", "Splitting", "StackelBody"):
        with pytest.raises(ImportError, match=f"^fastaff has no {name!r}. Use fastaff.") as caught:
            exec(f"from fastaff import {name}", {})
        inside = str(caught.value).split()[-1].split(".")[1:]
        assert inside[-1] == name
        assert functools.reduce(getattr, inside, fastaff) is not None
        assert not hasattr(fastaff, name)
        with pytest.raises(AttributeError, match=f"^{re.escape(str(caught.value))}$"):
            getattr(fastaff, name)
    assert not hasattr(fastaff, "nothing")
    assert set(fastaff.__all__) <= set(dir(fastaff))
    assert len(fastaff.__all__) <= TOP_NAMES, "a new name is public in its own part"


@pytest.mark.parametrize(("name", "value"), PUBLIC, ids=[name for name, _ in PUBLIC])
def test_every_public_name_is_documented(name, value):
    """A docstring of its own; a source for what has one: functions, models, charts, schemes."""
    if isinstance(value, (fastaff.schemes.Splitting, fastaff.schemes.RungeKutta)):
        assert any(c.isdigit() for c in value.source)  # name and year
        return
    doc = value.__doc__ if inspect.isfunction(value) or inspect.isclass(value) else type(value).__doc__
    assert doc
    assert not doc.startswith(f"{name}("), "the docstring that NamedTuple or dataclass writes"
    models = (
        *("Anharmonic", "Body", "Harmonic", "HeavyTop", "HenonHeiles", "Hyperelastic", "NeoHookean", "AlphaTurning"),
        *("BetaTurning", "AreaEquals"),
    )
    if (inspect.isfunction(value) and name != "scheme_named") or name in models:
        assert "Source:" in doc or "References\n----------\n" in inspect.getdoc(value)


@pytest.mark.parametrize(("name", "function"), FUNCTIONS, ids=[name for name, _ in FUNCTIONS])
def test_public_functions_say_what_they_raise_and_take(name, function):
    assert "Raises" in function.__doc__ or "raises" in function.__doc__
    said = " ".join(function.__doc__.split())
    shared = set(inspect.signature(fastaff.integrate).parameters) if "as in `integrate`" in said else set()
    for parameter in inspect.signature(function).parameters:
        assert parameter in function.__doc__ or parameter in shared, parameter
    kinds = {p.kind for p in inspect.signature(function).parameters.values()}
    of_text = (
        "affine_body",
        "hamiltonian",
        "iterated_map",
        "ode",
        "AffineBody",
        "TwoPolarBody",
        "UnitaryBody",
        "formula3",
    )
    own = (*of_text, "load", "save")  # parameters of a formula, of a file
    assert inspect.Parameter.VAR_KEYWORD not in kinds or name in own


PARAMETERS = 10
"""Most parameters of a function beside keywords."""
KERNEL_PARAMETERS = 12
"""Most parameters of a kernel."""
TOP_NAMES = 80
"""Most names of `fastaff`."""
ENTRIES = 19
"""Most entries of its folder."""


def test_a_class_has_one_meaning():
    names = Counter(node.name for path in FILES for node in nodes_of(path) if isinstance(node, ast.ClassDef))
    assert not [name for name, count in names.items() if count > 1]


def test_modules_have_a_docstring():
    assert not [module_of(path) for path in FILES if not ast.get_docstring(tree_of(path))]


def test_a_module_gives_a_name_once():
    """A constant in the place of another of its name would change what was computed with that."""
    for path in FILES:
        told = (node for node in tree_of(path).body if isinstance(node, (ast.Assign, ast.AnnAssign)))
        targets = (target for node in told for target in getattr(node, "targets", [getattr(node, "target", None)]))
        parts = (part for target in targets for part in ast.walk(target))
        names = Counter(part.id for part in parts if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store))
        assert not {name for name, count in names.items() if count > 1}, path


def test_what_belongs_together_is_one_argument():
    """At most so many parameters of a kernel, and of other functions beside those that are keywords."""
    many = []
    for path in FILES:
        most = KERNEL_PARAMETERS if is_kernel(module_of(path)) else PARAMETERS
        for node in nodes_of(path):
            if isinstance(node, ast.FunctionDef) and len(node.args.posonlyargs + node.args.args) > most:
                many.append(f"{module_of(path)}.{node.name}")
    assert not many


def test_every_function_has_a_docstring():
    """Public ones everywhere; kernels too."""
    missing = []
    for path in FILES:
        for node in tree_of(path).body:
            if (
                isinstance(node, (ast.FunctionDef, ast.ClassDef))
                and not node.name.startswith("_")
                and not ast.get_docstring(node)
            ):
                missing.append(f"{module_of(path)}.{node.name}")
    assert not missing


def test_the_deep_tier_names_tests_that_exist():
    for module, tests in DEEP.items():
        (path,) = Path(__file__).parents[1].rglob(f"{module}.py")
        assert tests.keys() <= set(re.findall(r"^def (test_\w+)\(", path.read_text(), re.MULTILINE))


RACES = re.compile(
    r"\btime\.(sleep|perf_counter|monotonic|process_time)\(|\bsetitimer\(|\bTimer\(|\bgetrusage\(|\bSIGKILL\b"
    r"|\bos\.(kill|killpg)\(|\.send_signal\(|\.terminate\("
)
"""What makes a test depend on a moment."""


def called_upon(function, tree, lines):
    """The lines of a test and of all functions, classes and constants of its module that it uses."""
    known = {}
    for node in tree.body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            known[node.name] = node
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            known[node.targets[0].id] = node
    texts, open_names, seen = [], [function.name], set()
    while open_names:
        name = open_names.pop()
        if name in known and name not in seen:
            seen.add(name)
            texts += lines[known[name].lineno - 1 : known[name].end_lineno]
            open_names += [node.id for node in ast.walk(known[name]) if isinstance(node, ast.Name)]
    return "\n".join(texts)


def marks_of(holder, tree):
    """The marks of a test and of its module, as text."""
    own = [node for node in tree.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "pytestmark"]
    return " ".join(ast.unparse(node) for node in [*holder.decorator_list, *(entry.value for entry in own)])


def test_what_depends_on_a_moment_is_a_race():
    """Tests of signals, kills and clocks have failed without a change of code: they are run by `make races` alone."""
    unmarked = []
    for path in sorted(Path(__file__).parents[1].rglob("test_*.py")):
        if path.parent.name == "explorer":
            continue  # a browser says when it is done: their clocks only end a wait
        text = path.read_text()
        if not RACES.search(text):
            continue
        tree, lines = tree_of(path), text.splitlines()
        for node in tree.body:
            test = isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
            if test and RACES.search(called_upon(node, tree, lines)) and "pytest.mark.race" not in marks_of(node, tree):
                unmarked.append(f"{path.stem}.{node.name}")
    assert not unmarked
