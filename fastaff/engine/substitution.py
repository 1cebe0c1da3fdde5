"""Branch-free functions in the place of NumPy's and Python's, where methods of models are compiled."""

from __future__ import annotations

import math
import types
from typing import Any

import numpy as np

from . import elementary as free

_NAMES = ("exp", "expm1", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "hypot")
_OURS = {
    **{name: getattr(free, name) for name in (*_NAMES, "arcsin", "arccos", "arctan", "arctan2", "power")},
    **{"asin": free.arcsin, "acos": free.arccos, "atan": free.arctan, "atan2": free.arctan2, "pow": free.power},
}
_INSTEAD: dict[int, Any] = {}
"""The substitutes of functions and modules, by the identity of these."""

for _module in (np, math):
    _INSTEAD.update({id(getattr(_module, name)): entry for name, entry in _OURS.items() if hasattr(_module, name)})
    _twin: Any = types.ModuleType(_module.__name__)
    _twin.__dict__.update({name: _INSTEAD.get(id(entry), entry) for name, entry in vars(_module).items()})
    _INSTEAD[id(_module)] = _twin


def replaced(function: types.FunctionType) -> types.FunctionType:
    """Return the function with branch-free ones in place of NumPy's and Python's, whether it reads them by their module
    or by name.
    """
    names = {name: _INSTEAD.get(id(entry), entry) for name, entry in function.__globals__.items()}
    contents = (cell.cell_contents for cell in function.__closure__ or ())
    cells = tuple(types.CellType(_INSTEAD.get(id(entry), entry)) for entry in contents)
    twin = types.FunctionType(function.__code__, names, function.__name__, function.__defaults__, cells or None)
    twin.__kwdefaults__ = function.__kwdefaults__
    twin.__qualname__ = function.__qualname__
    return twin
