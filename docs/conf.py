"""How Sphinx builds the site: `make docs`. The code of its pages runs in the build; an error or a warning ends it."""

import logging
import os
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(HERE / "_ext"), str(ROOT)]

# Pages run in processes of their own: with this package, the program beside this Python, and figures of one style.
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(ROOT), str(HERE / "_ext"), os.environ.get("PYTHONPATH")]))
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
os.environ["MATPLOTLIBRC"] = str(HERE / "_ext" / "matplotlibrc")
os.environ["COLUMNS"] = "88"
os.environ["FASTAFF_PROGRESS"] = "0"  # kernels of notebooks look as if somebody looked
os.environ["FASTAFF_SITE_PAGES"] = str(HERE / "_build" / "pages")  # what pages make to be opened beside them
os.environ["IPYTHONDIR"] = str(HERE / "_build" / "ipython")
settings = HERE / "_build" / "ipython" / "profile_default" / "ipython_kernel_config.py"
settings.parent.mkdir(parents=True, exist_ok=True)
settings.write_text(
    """c = get_config()
c.Application.log_level = "ERROR"
c.HistoryManager.enabled = False
c.InteractiveShellApp.extensions = ["shell_cells"]
"""
)

from sphinx.util.parallel import make_chunks  # noqa: E402

import fastaff  # noqa: E402

logging.getLogger("traitlets").setLevel(logging.WARNING)  # a style for Pygments prints everything otherwise

project = "fastaff"
author = "the fastaff developers"
project_copyright = "the fastaff developers, MIT licence"
version = release = fastaff.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "included",
    "reference",
    "gallery",
]
exclude_patterns = ["_build", "_generated", "_ext"]
nitpicky = True
suppress_warnings = ["mystnb.unknown_mime_type"]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
nb_execution_mode = "force"  # a cache of outputs would not see that the package has changed
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_ipywidgets_js = {}  # by default two scripts of other sites, on pages whose code makes a widget

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # shapes and units are in the docstrings
napoleon_google_docstring = False
napoleon_use_param = napoleon_use_rtype = False
napoleon_custom_sections = [("Attributes", "params_style")]  # a list, as of parameters: types are no references
default_role = "py:obj"  # names in single quotes
autosummary_generate = False
add_module_names = False
python_display_short_literal_types = True
toc_object_entries = False
maximum_signature_line_length = 240

pages_of_files = {
    "../ARCHITECTURE.md": "developers/architecture.md",
    "../CONTRIBUTING.md": "developers/contributing.md",
    "../CHANGELOG.md": "developers/changelog.md",
    "../README.md": "index.md",
    "../bench/results/race.md": "benchmarks/comparison.md",
}

html_theme = "furo"
html_title = f"fastaff {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"sidebar_hide_name": False, "navigation_with_keys": True}
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
mathjax_path = "mathjax/tex-chtml.js"


def share_notebooks(app, env, docnames):
    """Order pages so that two processes, which take them in large chunks, have half of the code each."""
    code = [name for name in docnames if "{code-cell}" in Path(env.doc2path(name)).read_text()]
    rest = [name for name in docnames if name not in code]
    chunk = max(len(make_chunks(docnames, max(app.parallel, 1))[0]), len(code) // 2 + 1)
    first = code[::2] + rest[: chunk - len(code[::2])]
    docnames[:] = [*first, *code[1::2], *(name for name in rest if name not in first)]


def copy_mathjax(app, exception):
    """Put MathJax, as its package has it, beside the pages: the formulas need no network."""
    if exception is None and app.builder.format == "html":
        package = Path(find_spec("sphinx-mathjax-offline").submodule_search_locations[0]) / "static" / "mathjax"
        there = Path(app.outdir) / "_static" / "mathjax"
        for part in ("output/chtml/fonts", "input/tex/extensions"):
            shutil.copytree(package / part, there / part, dirs_exist_ok=True)
        shutil.copy(package / "tex-chtml.js", there)


def copy_pages(app, exception):
    """Put what pages have made to be opened, such as an explorer, beside the site's own files."""
    made = Path(os.environ["FASTAFF_SITE_PAGES"])
    if exception is None and app.builder.format == "html" and made.is_dir():
        shutil.copytree(made, Path(app.outdir) / "_static", dirs_exist_ok=True)


def setup(app):
    """Connect to Sphinx."""
    app.connect("env-before-read-docs", share_notebooks)
    app.connect("build-finished", copy_mathjax)
    app.connect("build-finished", copy_pages)
