"""Functions that only compiled code calls: compiled once they are part of their callers, not by themselves as well.

Numba optimises and translates every function with all that it calls, and again as a part of each of its callers: a leaf
of a tree of ten calls is optimised ten times and has machine code ten times, with two wrappers for Python each. What
kernels call gets none of that: its code is linked into that of the function that Python or a pointer enters by.
"""

from __future__ import annotations

import importlib
import operator
from collections.abc import Callable
from typing import Any

from numba import types
from numba.core import compiler
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import CPUDispatcher


class _Part(JITCodeLibrary):
    """Code as it was written, to be linked into that of callers."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class _PartPipeline(compiler.Compiler):
    """Numba's compiler of a part: it has no entry for Python, whose machine code would have to be made for it."""

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        flags.no_compile = True
        library = _Part(targetctx.codegen(), "part")
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)


OPTIONS = {"nopython": True, "boundscheck": None, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Callee(CPUDispatcher):
    """A function for compiled code alone; one code for all numbers, or with `constants` one for each that it is called
    with. With `forceinline` LLVM always makes it part of the caller's loops.
    """

    def __init__(self, function: Callable, *, constants: bool = False, forceinline: bool = False):
        self._constants = constants
        options = {**OPTIONS, "error_model": "numpy", "forceinline": forceinline}
        super().__init__(function, targetoptions=options, pipeline_class=_PartPipeline)

    def add_overload(self, cres):
        """Keep a signature's code under a key of its own, where others have their entry for Python."""
        key = object()
        self.targetctx.insert_user_function(key, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres._replace(entry_point=key)

    def get_call_template(self, args, kws):
        """Return what Numba finds a call's type by."""
        if not self._constants:
            args, kws = tuple(map(types.unliteral, args)), {name: types.unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template(args, kws)

    def __reduce__(self):
        return _named, (self.py_func.__module__, self.py_func.__qualname__)


def _named(module: str, name: str) -> Any:
    """Return a function of a module: what a callee stands for in keys of the cache, the same in every process."""
    return operator.attrgetter(name)(importlib.import_module(module))
