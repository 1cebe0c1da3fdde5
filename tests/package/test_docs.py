"""The site and README: links lead to files, code runs, every public name has its place, docstrings are in numpydoc form
with examples that run.
"""

import ast
import dataclasses
import doctest
import inspect
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import fastaff

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    path
    for path in [*ROOT.glob("*.md"), *DOCS.rglob("*.md"), *(ROOT / "bench").rglob("*.md")]
    if not {"_build", "_generated", "jupyter_execute"} & set(path.relative_to(ROOT).parts)
)


@pytest.fixture(scope="module", autouse=True)
def extensions():
    """Make the site's extensions importable."""
    sys.path.insert(0, str(DOCS / "_ext"))
    yield
    sys.path.remove(str(DOCS / "_ext"))


def text_of(page):
    """Return a page without its code."""
    return re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.DOTALL)


def slugs(page):
    """Return the anchors of a page's headings."""
    headings = re.findall(r"^#+ +(.*)$", text_of(page), re.MULTILINE)
    named = re.findall(r"^\((\S+)\)=$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-") for heading in headings} | {*named}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_between_files_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", text_of(page)):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if file.is_relative_to(DOCS / "api") and file.suffix == ".rst":
            assert file.stem in {"index", *import_module("reference").PAGES}, target
            continue
        assert file.exists(), target
        if anchor and file.suffix == ".md":
            assert anchor in slugs(file), target


def test_every_page_is_in_the_table_of_contents():
    """The home page lists the pages, and a page its own parts; an entry may have a title of its own."""
    pages = [page for page in DOCS.rglob("*.md") if not page.relative_to(DOCS).parts[0].startswith("_")]
    listed = set()
    for page in pages:
        for block in re.findall(r"```{toctree}(.*?)```", page.read_text(), re.DOTALL):
            names = [re.sub(r"^.*<(.*)>$", r"\1", line) for line in block.split("\n")]
            listed |= {(page.parent / name).with_suffix(".md") for name in names}
    assert {*pages} - listed == {DOCS / "index.md"}


def test_code_of_pages_is_code_that_runs():
    """Blocks of code are cells of notebooks; others are text, and directives of the page."""
    for page in DOCS.rglob("*.md"):
        if "_build" in page.parts or "_generated" in page.parts:
            continue
        kinds = set(re.findall(r"^```(\S+)$", page.read_text(), re.MULTILINE))
        assert kinds <= {"{code-cell}", "{toctree}", "{gallery}", "text"}, page
        if "{code-cell}" in kinds:
            assert page.read_text().startswith("---\nfile_format: mystnb\n"), page
            assert f"notebook <{page.stem}.ipynb>" in page.read_text(), page


def test_python_of_readme_runs(capsys, tmp_path, monkeypatch):
    """What it prints is what its comments say."""
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    names = {}
    exec(compile(block, "README.md", "exec"), names)
    assert (names["section"].status == fastaff.Status.OK).all()
    assert (names["freq"]["error_x"][:2] < 1e-6).all()
    (said,) = re.findall(r"print\(chaos.summary\(\)\)\n# (.*)", block)
    assert said in capsys.readouterr().out
    assert np.array_equal(fastaff.load("section.npz").points, names["section"].points, equal_nan=True)
    sys.modules["matplotlib.pyplot"].close("all")


def test_readme_has_pictures_for_dark_pages():
    """Each has both versions, the dark one made of the other; the site has the first, which its style sheet inverts."""
    from matplotlib.image import imread

    text = (ROOT / "README.md").read_text()
    pictures = re.findall(r'<picture><source media="[^"]*dark\)" srcset="([^"]*)"><img alt="[^"]+" src="([^"]*)"', text)
    assert len(pictures) == text.count("<picture>") == 2
    sys.path.insert(0, str(DOCS / "figures"))
    darkened = import_module("dark").darkened
    for dark, light in pictures:
        np.testing.assert_allclose(imread(ROOT / dark)[..., :3], darkened(imread(ROOT / light))[..., :3], atol=1 / 255)
    pages = {ROOT / "README.md": DOCS / "index.md"}
    found = import_module("included").relinked(text, ROOT / "README.md", DOCS / "index.md", pages)
    assert "<picture>" not in found
    for _, light in pictures:
        assert re.search(rf"!\[[^]]+\]\([^)]*{Path(light).name}\)", found)


def test_readme_is_one_screenful_of_facts():
    """A reader sees all of it in five minutes: at most 120 lines, and at most 8 measured rows beside other programs."""
    lines = (ROOT / "README.md").read_text().splitlines()
    assert len(lines) <= 120
    comparison = lines[lines.index("## Comparison") : lines.index("## Documentation")]
    assert len([line for line in comparison if " × " in line and line.startswith("|")]) <= 8


def test_commands_of_readme_run(tmp_path, monkeypatch):
    from fastaff.cli.main import main

    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"## Two commands\n.*?```console\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    commands = block.strip().splitlines()
    assert len(commands) == 2
    assert commands[0] == "fastaff explore"  # nothing to compile, something to see
    for command in commands:
        program, *words = command.split()
        assert program == "fastaff"
        assert main(words) == 0, command
    assert (tmp_path / "fastaff-explorer.html").exists()
    assert (tmp_path / "fastaff-poincare.png").exists()
    assert fastaff.files.contents(tmp_path / "fastaff-poincare.npz")


def printed():
    """Command lines of README, pages and the help, in blocks of text and within lines; cells run in the build."""
    from fastaff.cli.options import HELP

    found = re.findall(r"`(fastaff [^`]*)`", HELP)
    for page in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]:
        if "_generated" in page.parts or "_build" in page.parts:
            continue
        blocks = re.findall(r"^```([^\n]*)\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)
        texts = "".join(block for kind, block in blocks if kind in ("", "text", "console"))
        found += [line for line in texts.replace("\\\n", " ").splitlines() if line.startswith("fastaff ")]
        found += re.findall(r"`(fastaff [^`]*)`", re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL))
    return list(dict.fromkeys(found))


SMALLER = [
    (r"(--(?:axes|scan) \S+=\S+:\S+):\d+", r"\1:2"),
    (r"--grid \S+", "--grid 3x3"),
    (r"--time \d+", "--time 100"),
    (r"--orbits \d+", "--orbits 4"),
    (r"--levels \d+", "--levels 3"),
    (r"-8:8", "-1:1"),
    (r"K=0.2:10", "K=2:4"),
    (r"job\.(toml|zarr)", r"map.\1"),
]
"""What makes a command short: its numbers of things, never its options."""


def shortened(line):
    """Return a command that does the same with less."""
    for pattern, instead in SMALLER:
        line = re.sub(pattern, instead, line)
    command = line.split()[1]
    if command in ("poincare", "frequency-map", "chaos-map"):
        if not re.search("--(grid|axes|file|orbits|scan)", line):
            line += " --grid 3x3"
        line += " --orbits 4" * ("--scan" in line)
        line += " --crossings 5" * (command == "poincare" and "--crossings" not in line)
    return line


COMPUTES = [line for line in printed() if len(line.split()) > 2 and "..." not in line and "cache --clear" not in line]
COMPUTES = list(dict.fromkeys(map(shortened, COMPUTES)))
"""Those that are whole: of the others the names are looked at. The cache of compiled kernels is the user's."""

LONG = "fastaff spectrum --m 0 --l 0 --levels 3 --scan"


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A folder with a job, its store and starting points, as pages name them."""
    folder = tmp_path_factory.mktemp("stored")
    job = fastaff.Job(
        model=fastaff.HenonHeiles(),
        energy_surface=fastaff.jobs.EnergySurface(energy=0.1),
        initial_conditions=fastaff.jobs.InitialConditions(grid="3x3"),
        frequency_map=fastaff.jobs.FrequencyOptions(time=200.0),
    )
    (folder / "map.toml").write_text(job.text())
    fastaff.run(job, folder / "map.zarr")
    np.save(folder / "starts.npy", [[0.1, 0.5], [0.0, 0.2]])
    return folder


@pytest.mark.parametrize(
    "line", [pytest.param(line, marks=[pytest.mark.slow] * line.startswith(LONG)) for line in COMPUTES]
)
def test_printed_commands_run(line, stored, tmp_path, monkeypatch):
    """All of them, with less to compute, figures included."""
    from fastaff.cli.main import main

    there = shutil.copytree(stored, tmp_path / "there")
    monkeypatch.chdir(there)
    before = set(there.iterdir())
    if "--write-job map.toml" in line:
        (there / "map.toml").unlink()
    words = shlex.split(line)[1:]
    assert main(words) == 0
    assert set(there.iterdir()) > before or words[0] in ("run", "resume", "rerun", "status") or "--write-job" in line


def test_what_printed_commands_name_exists():
    """Commands, targets of make, files that Python runs, and extras of the package."""
    from fastaff.cli.application import COMMANDS

    assert len(COMPUTES) > 20
    assert {line.split()[1] for line in printed()} - {"--help", "--version", "--install-completion"} <= {*COMMANDS}
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    extras = re.findall(r"^(\w+) = \[", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    for page in PAGES:
        text = page.read_text()
        assert {*re.findall(r"(?:^|`)make ([a-z][\w-]*)", text, re.MULTILINE)} <= {*targets}, page
        for name in re.findall(r"(?:^|`)python ([\w/]+\.py)", text, re.MULTILINE):
            assert (ROOT / name).exists(), (page, name)
        for names in re.findall(r"pip install \S*\[([\w,]+)\]", text):
            assert {*names.split(",")} <= {*extras}, (page, names)


def test_every_public_name_is_on_one_page():
    reference = import_module("reference")
    entries = [entry for page in reference.PAGES.values() for entry in reference.members(page)]
    assert len(entries) == len(set(entries))
    listed = (DOCS / "api" / "index.rst").read_text().split()
    assert set(reference.PAGES) <= set(listed)
    folders = "runs frequencies sections chaos periodic tori engine jobs plot quantum"
    folders += " systems.charts systems.models systems.molecules runs.schemes"
    for folder in ("", *folders.split()):
        module = f"fastaff.{folder}".rstrip(".")
        own = {name for owner, name in entries if owner == module}
        values = {id(getattr(import_module(owner), name)) for owner, name in entries}
        for name in import_module(module).__all__:
            assert name in own or id(getattr(import_module(module), name)) in values, f"{module}.{name}"


def test_every_field_of_every_result_has_a_meaning():
    """Docstrings of results explain all fields in their order, which the page of result classes shows."""
    reference, fields = import_module("reference"), import_module("result_fields")
    found = {}
    for page in reference.PAGES.values():
        for module, name in reference.members(page):
            value = getattr(import_module(module), name)
            if fields.is_result(value):
                found[name] = value
    for name, cls in found.items():
        assert [*fields.meanings(cls)] == fields.fields(cls), name
        assert all(fields.meanings(cls).values()), name
    assert "| `nu` | angle, orbit | cycles/time |" in fields.table(found["FrequencyMap"])


def test_every_status_and_class_is_explained():
    text = (DOCS / "reference" / "statuses-and-classes.md").read_text()
    kinds = (fastaff.Status, fastaff.Classification, fastaff.periodic.Stability, fastaff.periodic.Event)
    for kind in kinds:
        for member in kind:
            assert f"| {member.value} | `{member.name}` |" in text, member


OUTCOMES = ("Classification", "Interrupted", "OrbitError", "Status")
VERBS = {name: getattr(fastaff, name) for name in fastaff.__all__ if name not in OUTCOMES}
VERBS = {name: value for name, value in VERBS.items() if callable(value)}
VERBS |= fastaff.formulas.systems.SYSTEMS
VERBS |= {"spectrum": fastaff.quantum.spectrum, "Stroboscopic": fastaff.models.sections.Stroboscopic}
"""Functions and classes that are called, by name: those of `fastaff`, and a few of its folders."""


def with_examples():
    """All functions of the API pages, and the classes there that have an example, by their dotted names."""
    reference = import_module("reference")
    entries = [entry for page in reference.PAGES.values() for entry in reference.members(page)]
    for module, name in entries:
        value = getattr(import_module(module), name)
        function = inspect.isroutine(value) or hasattr(value, "py_func")
        if function or (inspect.isclass(value) and "Examples\n" in (value.__doc__ or "")):
            yield f"{module}.{name}".removeprefix("fastaff."), value


sys.path.insert(0, str(DOCS / "_ext"))
EXAMPLES = dict(with_examples())
API = [*import_module("reference").PAGES]
sys.path.remove(str(DOCS / "_ext"))

UNUSED = {
    "GL01": "the summary begins beside the quotes",
    "GL02": "one-line docstrings end beside the quotes",
    "ES01": "an extended summary is optional",
    "SA01": "the site has pages by task in place of See Also",
    "EX01": "another test says which names need an example",
    "GL08": "fields of named tuples are described by their class",
}
"""Codes of numpydoc's validator for which the package has another rule, with that rule."""


def documented():
    """All functions and classes of the API pages and the own methods of these classes, by page and dotted name."""
    reference = import_module("reference")
    for page, content in reference.PAGES.items():
        for module, name in reference.members(content):
            value = getattr(import_module(module), name)
            if inspect.isclass(value) or inspect.isroutine(value) or hasattr(value, "py_func"):
                yield page, f"{module}.{name}", value
            for method, entry in vars(value).items() if inspect.isclass(value) else ():
                kinds = (property, classmethod, staticmethod)
                if not method.startswith("_") and (inspect.isfunction(entry) or isinstance(entry, kinds)):
                    yield page, f"{module}.{name}.{method}", entry


def fields_of(cls):
    """Return the names of the public fields of a dataclass or named tuple, or the members of an enumeration."""
    if dataclasses.is_dataclass(cls):
        return [field.name for field in dataclasses.fields(cls) if not field.name.startswith("_")]
    return [*getattr(cls, "_fields", getattr(cls, "__members__", ()))]


def described_fields(cls):
    """Whether each field of a dataclass is followed by a docstring of its own, which commands show as help."""
    if not dataclasses.is_dataclass(cls):
        return False
    (tree,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    after = dict(zip(tree.body, tree.body[1:]))
    fields = [node for node in tree.body if isinstance(node, ast.AnnAssign) and "ClassVar" not in ast.unparse(node)]
    return all(isinstance(after.get(node), ast.Expr) and isinstance(after[node].value, ast.Constant) for node in fields)


def sections(value):
    """Return the sections of a docstring in numpydoc form, by title."""
    parts = re.split(r"^(\w+)\n-+$", inspect.getdoc(value), flags=re.MULTILINE)
    assert len(set(parts[1::2])) == len(parts) // 2
    return dict(zip(parts[1::2], parts[2::2]))


def test_no_summary_is_cut_at_the_sign_of_a_product():
    """Tables of the API show a docstring up to its first full stop: products are written k·nu, not with a full stop."""
    docstrings = {name: inspect.getdoc(value) or "" for _, name, value in documented()}
    assert len(docstrings) > 300
    assert [name for name, text in docstrings.items() if re.search(r"\s\.(\s|$)", text.split("\n\n")[0])] == []


@pytest.mark.parametrize("name", VERBS)
def test_public_docstrings_name_parameters_results_and_errors(name):
    """The parameters are those of the signature in their order; sections follow one another as in numpydoc."""
    value = VERBS[name]
    found = sections(value)
    order = ("Parameters", "Returns", "Raises", "Notes", "References", "Examples")
    assert [*found] == [title for title in order if title in found]
    entries = re.findall(r"^(\*{0,2}\w.*?) : \S", found["Parameters"], re.MULTILINE)
    named = [one.strip().lstrip("*") for entry in entries for one in entry.split(",")]
    assert named == [*inspect.signature(value).parameters]
    assert "Examples" in found
    if inspect.isfunction(value):
        assert found["Returns"].strip()
        assert found["Raises"].strip()


@pytest.mark.parametrize("page", API)
def test_numpydoc_finds_no_fault_in_public_docstrings(page):
    """A class that the package makes lists its fields, in their order, as attributes in place of parameters."""
    validate = pytest.importorskip("numpydoc.validate").validate
    faults = []
    for own, name, value in documented():
        if own != page or not inspect.getdoc(value):
            continue
        unused = {*UNUSED}
        if inspect.isclass(value) and "Attributes" in sections(value) and fields_of(value):
            entries = re.findall(r"^(\w.*?) : \S", sections(value)["Attributes"], re.MULTILINE)
            if [one for entry in entries for one in entry.split(", ")] != fields_of(value):
                faults.append(f"{name}: its attributes must be {', '.join(fields_of(value))}")
            unused.add("PR01")
        if inspect.isclass(value) and described_fields(value):
            unused.add("PR01")
        found = [(code, text) for code, text in validate(name)["errors"] if code not in unused]
        faults += [f"{name}: {code} {text}" for code, text in found]
        if re.search(r"^ *\{\w+\}$", inspect.getdoc(value), re.MULTILINE):
            faults.append(f"{name}: an entry of fastaff.core.docstrings is not inserted")
    assert not faults, "\n".join(faults)


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_of_public_docstrings_run(name, here):
    """Each ends its docstring and prints what it shows, with `fa` and `np` at hand."""
    title, text = list(sections(EXAMPLES[name]).items())[-1]
    assert title == "Examples"
    example = doctest.DocTestParser().get_doctest(text, {"fa": fastaff, "np": np}, name, None, None)
    assert example.examples
    report = []
    doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example, out=report.append)
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
    assert not report, "".join(report)


def test_every_name_that_is_called_has_an_example_that_runs():
    assert {id(value) for value in VERBS.values()} <= {id(value) for value in EXAMPLES.values()}


def test_names_in_docstrings_become_links():
    """Those that the site has; names of parameters and expressions stay code."""
    reference = import_module("reference")
    assert reference.index()["Orbits"] == reference.index()["runs.Orbits"] == "fastaff.runs.Orbits"
    node = {"refdomain": "py", "reftype": "obj", "reftarget": "z0", "refdoc": "api/orbits"}
    assert reference.resolve(None, None, node, "code") == "code"
    assert reference.resolve(None, None, {**node, "reftype": "exc"}, "code") is None
    assert reference.resolve(None, None, {**node, "refdomain": "std"}, "code") is None


def test_files_of_the_repository_become_pages(tmp_path):
    included = import_module("included")
    source, page = tmp_path / "A.md", tmp_path / "docs" / "a.md"
    pages = {tmp_path / "B.md": tmp_path / "docs" / "b.md"}
    text = "[b](B.md#x) [c](docs/c.md) ![d](figures/d.png) [e](https://e.org)"
    assert (
        included.relinked(text, source, page, pages)
        == "[b](b.md#x) [c](c.md) ![d](../figures/d.png) [e](https://e.org)"
    )


def test_a_part_of_a_file_becomes_part_of_a_page():
    """From a heading on, before a heading, or both; a heading that the file does not have is an error."""
    included = import_module("included")
    text = "# A\n\n## B\nb\n\n## C\nc\n"
    assert included.part(text, None, "## B") == "# A\n\n"
    assert included.part(text, "## B", "## C") == "## B\nb\n\n"
    assert included.part(text, "## C", None) == "## C\nc\n"
    with pytest.raises(ValueError, match="## D"):
        included.part(text, "## D", None)


def test_a_command_that_fails_ends_the_build(capsys):
    """What was printed until then is shown, and nothing after it runs."""
    cells = import_module("shell_cells")
    cells.sh("", "echo one; echo two >&2\n")
    assert capsys.readouterr().out == "one\ntwo\n"
    with pytest.raises(subprocess.CalledProcessError):
        cells.sh("", "echo one\nfalse\necho two\n")
    assert capsys.readouterr().out == "one\n"


def test_pages_load_no_script_from_other_sites():
    """MyST-NB loads two where code of a page makes a widget, unless it is told otherwise."""
    conf = (DOCS / "conf.py").read_text()
    told = [node.value for node in ast.parse(conf).body if ast.unparse(node).startswith("nb_ipywidgets_js = ")]
    assert [ast.literal_eval(value) for value in told] == [{}]
    assert "://" not in conf
