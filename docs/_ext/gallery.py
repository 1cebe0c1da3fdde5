"""The gallery: figures of code cells tagged `gallery`, on whatever page, as thumbnails that lead there.

The cell's first comment line is the caption. Thumbnails are the figures that the build has just made, scaled down.
With the names of pages in its folder, the directive shows one thumbnail for each: the first of the page, with the
page's title as the caption.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.util import logging

logger = logging.getLogger(__name__)


class gallery(nodes.General, nodes.Element):
    """Where the thumbnails go."""


class Gallery(Directive):
    """The directive `{gallery}`, for all pages or, `{gallery} page other-page`, for those of its folder."""

    optional_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Return the place."""
        return [gallery(pages=self.arguments[0].split() if self.arguments else [])]


def _caption(cell: nodes.Node) -> str:
    code = next(iter(cell.findall(nodes.literal_block)), None)
    first = code.astext().lstrip().splitlines()[0] if code else ""
    return first.lstrip("# ").rstrip(".")


def _section(cell: nodes.Node) -> nodes.section:
    found = cell
    while not isinstance(found, nodes.section):
        found = found.parent
    return found


def _reading_order(app: Any) -> list[str]:
    """Return the pages as the table of contents has them."""
    order, waiting = [], [app.config.root_doc]
    while waiting:
        name = waiting.pop(0)
        order.append(name)
        waiting = [child for child in app.env.toctree_includes.get(name, ()) if child not in order] + waiting
    return order


def _page_card(app: Any, docname: str, name: str) -> nodes.Node:
    """Return the first thumbnail of a page, which leads to the page, with its title."""
    found = cards(app, docname, [name])
    if not found:
        logger.warning("%s must have a figure tagged gallery", name, location=docname)
        return nodes.container("")
    image = next(iter(found[0].findall(nodes.image))).deepcopy()
    if name == docname:
        return nodes.container("", nodes.paragraph("", "", image), classes=["picture"])
    title = app.env.titles[name].astext()
    uri = app.builder.get_relative_uri(docname, name)
    link = nodes.reference("", "", image, nodes.inline("", title), refuri=uri, internal=True)
    return nodes.container("", nodes.paragraph("", "", link), classes=["card"])


def cards(app: Any, docname: str, names: list[str]) -> list[nodes.Node]:
    """Return a thumbnail for each figure of the tagged cells of the pages."""
    found: list[nodes.Node] = []
    for name in names:
        for cell in app.env.get_doctree(name).findall(nodes.container):
            images = list(cell.findall(nodes.image)) if "tag_gallery" in cell.get("classes", ()) else []
            if not images:
                continue
            image = images[-1].deepcopy()
            image["classes"], caption = ["thumbnail"], _caption(cell)
            image["alt"] = caption
            uri = app.builder.get_relative_uri(docname, name) + "#" + _section(cell)["ids"][0]
            link = nodes.reference("", "", image, nodes.inline("", caption), refuri=uri, internal=True)
            found.append(nodes.container("", nodes.paragraph("", "", link), classes=["card"]))
    return found


def fill(app: Any, doctree: nodes.document, docname: str) -> None:
    """Put the thumbnails in their place, when all pages have been read."""
    folder = docname.rpartition("/")[0]
    for place in list(doctree.findall(gallery)):
        names = ["/".join(filter(None, (folder, name))) for name in place["pages"]]
        shown = [_page_card(app, docname, name) for name in names] or cards(app, docname, _reading_order(app))
        alone = names == [docname]
        place.replace_self(shown[0] if alone else nodes.container("", *shown, classes=["gallery"]))


def setup(app: Any) -> dict[str, Any]:
    """Connect to Sphinx."""
    app.add_node(gallery)
    app.add_directive("gallery", Gallery)
    app.connect("doctree-resolved", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
