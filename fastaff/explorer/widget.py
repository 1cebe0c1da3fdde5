"""The explorer as a widget of notebooks: the page's own modules, answered by the package."""

from __future__ import annotations

from typing import Any

import anywidget
import numpy as np
import traitlets

from ..runs.requirements import current_system
from .answers import Answers
from .explore import setup_of
from .page import script, web_text
from .setup import NAMED, named_body

ENTRY = "\nexport default { render: ({ model, el }) => mountExplorer(model, el) };\n"


class ExplorerWidget(anywidget.AnyWidget):
    """The explorer of a system in a notebook: clicks go to Python, where the package computes and answers.

    Parameters: as `fastaff.explore`, without `out`. Show it as the last value of a cell. Raises ValueError or TypeError
    for wrong input, as `explore` does.
    """

    _esm = script("widget.js") + ENTRY
    _css = web_text("style.css")
    setup = traitlets.Dict().tag(sync=True)
    markup = traitlets.Unicode().tag(sync=True)

    def __init__(self, model: Any = None, **options: Any):
        setup, chosen = setup_of(model, **options)
        if current_system(chosen).rows == 1:
            raise TypeError("model must have two variables or more in a notebook's explorer. Use fa.explore.")
        if current_system(chosen).driven:
            raise TypeError("model must have no drive in a notebook's explorer. Use fa.explore, which writes a page.")
        super().__init__(setup=setup, markup=web_text("page.html"))
        systems = {name: named_body(name) for name in NAMED} | {setup["start"]["system"]: chosen}
        self.answers = Answers(systems, self._post)
        self.on_msg(lambda _, message, __: self.answers.receive(message))

    def _post(self, message: dict[str, Any]) -> None:
        """Send a message, its arrays as buffers."""
        found = {name: value for name, value in message.items() if isinstance(value, np.ndarray)}
        arrays = [[name, "u1" if value.dtype == np.uint8 else "f8"] for name, value in found.items()]
        rest = {name: value for name, value in message.items() if name not in found}
        self.send({"message": rest, "arrays": arrays}, [np.ascontiguousarray(a).tobytes() for a in found.values()])
