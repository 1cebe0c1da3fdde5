"""The parts of Numba and llvmlite beyond `njit` and `types`: this module alone imports them.

docs/developers/numba.md gives the reason for each. tests/engine/test_numba_private_parts.py checks that each exists.
"""

import llvmlite
from llvmlite import binding
from llvmlite import ir as llvm_ir
from numba.core import cgutils, compiler, config
from numba.core import event as events
from numba.core import ir as numba_ir
from numba.core.caching import NullCache
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary, get_host_cpu_features
from numba.core.compiler import CompileResult
from numba.core.compiler_machinery import AnalysisPass, register_pass
from numba.core.datamodel import models
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import AnnotateTypes
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr
from numba.extending import (
    get_cython_function_address,
    intrinsic,
    lower_builtin,
    overload,
    register_jitable,
    register_model,
)
from numba.np.ufunc import parallel

__all__ = [
    "AbstractTemplate",
    "AnalysisPass",
    "AnnotateTypes",
    "AttributeTemplate",
    "CFunc",
    "CPUDispatcher",
    "CompileResult",
    "JITCodeLibrary",
    "NullCache",
    "binding",
    "cgutils",
    "compiler",
    "config",
    "dumps",
    "events",
    "get_cython_function_address",
    "get_host_cpu_features",
    "infer_getattr",
    "intrinsic",
    "llvm_ir",
    "llvmlite",
    "lower_builtin",
    "models",
    "normalize_signature",
    "numba_ir",
    "overload",
    "parallel",
    "register_jitable",
    "register_model",
    "register_pass",
]
