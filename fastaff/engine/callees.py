"""Functions that only compiled code calls: they are compiled as parts of their callers, not by themselves as well.

Numba optimises and translates every function with all its callees, and again as a part of each of its callers: the last
function in a chain of ten calls gets machine code ten times, with two wrappers for Python each. A callee of kernels
gets none: its code is linked into that of the function that Python or a pointer calls.
"""

from __future__ import annotations

import importlib
import operator
from collections.abc import Callable
from typing import Any

from numba import types

from .numba_private import AnalysisPass, AnnotateTypes, CPUDispatcher, JITCodeLibrary, binding, compiler, register_pass
from .numba_private import numba_ir as ir

LINE = 64
"""Bytes of a cache line, and of the longest vectors."""

LONG_VECTORS = f'"prefer-vector-width"="{8 * LINE}"'
"""Attribute of functions whose loops take the longest vectors of the processor: for Intel's and for levels of x86-64
LLVM would take half of them, with which a step of a splitting takes a third more time.
"""


class _Library(JITCodeLibrary):
    """Code whose loops take long vectors, unless `long` is False: a module of kernels has LONG_VECTORS = False."""

    long = True

    def add_ir_module(self, ir_module):
        """Add a module with that attribute of its functions, which llvmlite knows no name of."""
        for function in ir_module.functions:
            if self.long and not function.is_declaration:
                set.add(function.attributes, LONG_VECTORS)
        super().add_ir_module(ir_module)


class _Part(_Library):
    """Unoptimised code, to be linked into that of callers."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True


class _NotInlined(_Part):
    """Code to which callers jump: none has a copy of its own."""

    def add_llvm_module(self, ll_module):
        """Add a module; LLVM inlines none of its functions into others."""
        for function in ll_module.functions:
            if not function.is_declaration and function.name.startswith("_ZN"):
                function.add_function_attribute("noinline")
        super().add_llvm_module(ll_module)


MAKES = ("call", "binop", "inplace_binop", "unary")
"""Expressions that may create an array, or get a temporary one; copying an array into another may, too."""


@register_pass(mutates_CFG=False, analysis_only=True)
class _NoRefcounts(AnalysisPass):
    """Leave out the counting of references if all arrays belong to callers: its atomic operations take a fourth of the
    time of some kernels.
    """

    _name = "on_loan"

    def __init__(self):
        super().__init__()  # the base class requires this method

    def run_pass(self, state):
        """Switch the counting off if no statement creates, copies or returns an array."""
        context = state.targetctx
        made = [state.return_type]
        for block in state.func_ir.blocks.values():
            made += [state.typemap[a.target.name] for a in block.find_insts(ir.Assign) if _makes(a.value)]
            made += [state.typemap[a.value.name] for a in block.find_insts((ir.SetItem, ir.StaticSetItem))]
        if not any(context.data_model_manager[kind].contains_nrt_meminfo() for kind in made):
            state.targetctx = context.subtarget(enable_nrt=False)
        return False


def _makes(value: Any) -> bool:
    return isinstance(value, ir.Expr) and value.op in MAKES


class _PartPipeline(compiler.Compiler):
    """Numba's compiler of a part: it makes no entry for Python, which would need machine code."""

    part = _Part

    def compile_extra(self, func):
        """Compile a function with the vectors of its module."""
        self.state.library.long = func.__globals__.get("LONG_VECTORS", True)
        return super().compile_extra(func)

    def define_pipelines(self):
        """Return Numba's own passes and the one that may switch off the counting of references."""
        passes = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(_NoRefcounts, AnnotateTypes)
        passes.finalize()
        return [passes]

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        flags.no_compile = True
        library = self.part(targetctx.codegen(), "part")
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)


class _ApartPipeline(_PartPipeline):
    part = _NotInlined


class _Aligned(_Library):
    """Code whose vectors on the stack lie within cache lines. LLVM would put them where the caller's stack happens to
    end: three times of four across two lines, which takes up to a fourth more time.
    """

    def add_ir_module(self, ir_module):
        """Add a module whose functions begin with a stack that ends at a cache line."""
        for function in ir_module.functions:
            if not function.is_declaration:
                function.attributes.alignstack = LINE
            if function.name.startswith("cfunc."):
                for call in filter(_is_call, function.entry_basic_block.instructions):
                    call.attributes.discard("noinline")
        super().add_ir_module(ir_module)

    def _optimize_final_module(self):
        """Optimise; the function becomes a part of its entry, to which alone it is known: to hand all arguments on
        takes as long as some vectors of a step.
        """
        for function in self._final_module.functions:
            if function.linkage == binding.Linkage.external and function.name.startswith("_ZN"):
                function.linkage = "internal"
        super()._optimize_final_module()


def _is_call(instruction: Any) -> bool:
    return instruction.opname == "call"


class EntryPipeline(compiler.Compiler):
    """Numba's compiler of functions that are called by address."""

    def __init__(self, typingctx, targetctx, library, args, return_type, flags, locals):
        library = _Aligned(targetctx.codegen(), "entry")
        library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, args, return_type, flags, locals)


OPTIONS = {"nopython": True, "boundscheck": None, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Callee(CPUDispatcher):
    """A function for compiled code alone; one code for all numbers, or with `constants` one for each constant argument.
    LLVM always inlines it into the caller's loops with `forceinline`, and never with `apart`: all callers then share
    one code.
    """

    def __init__(self, function: Callable, *, constants: bool = False, forceinline: bool = False, apart: bool = False):
        self._constants = constants
        options = {**OPTIONS, "error_model": "numpy", "forceinline": forceinline}
        super().__init__(function, targetoptions=options, pipeline_class=_ApartPipeline if apart else _PartPipeline)

    def add_overload(self, cres):
        """Keep a signature's code under a separate key, instead of the entry for Python of other functions."""
        key = object()
        self.targetctx.insert_user_function(key, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres._replace(entry_point=key)

    def get_call_template(self, args, kws):
        """Return Numba's template for the type of a call."""
        if not self._constants:
            args = tuple(map(types.unliteral, args))
            kws = {name: types.unliteral(kind) for name, kind in kws.items()}
        return super().get_call_template(args, kws)

    def __reduce__(self):
        return _named, (self.py_func.__module__, self.py_func.__qualname__)


def _named(module: str, name: str) -> Any:
    """Return a function of a module; in keys of the cache it stands for a callee, the same in every process."""
    return operator.attrgetter(name)(importlib.import_module(module))
