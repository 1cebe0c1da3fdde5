"""A canary: the parts of Numba and llvmlite that are no public interface are there as the package uses them.

docs/developers/numba.md says why each is used. A new Numba breaks these tests first, in a second, before kernels become
slow or wrong.
"""

import inspect

import numba
import pytest

from fastaff.engine import numba_private as private

SIGNATURES = {
    "CFunc.__init__": "pyfunc sig locals options pipeline_class",
    "CFunc.compile": "",
    "CPUDispatcher.__init__": "py_func locals targetoptions pipeline_class",
    "CPUDispatcher.add_overload": "cres",
    "CPUDispatcher.get_call_template": "args kws",
    "CPUDispatcher.get_overload": "sig",
    "CompileResult._rebuild": "target_context libdata fndesc env signature objectmode lifted typeann reload_init "
    "referenced_envs",
    "CompileResult._reduce": "",
    "JITCodeLibrary.__init__": "codegen name",
    "JITCodeLibrary.add_ir_module": "ir_module",
    "JITCodeLibrary.add_llvm_module": "ll_module",
    "JITCodeLibrary.enable_object_caching": "",
    "JITCodeLibrary._optimize_final_module": "",
    "JITCodeLibrary._finalize_final_module": "",
    "JITCodeLibrary._finalize_dynamic_globals": "",
    "JITCodeLibrary._verify_declare_only_symbols": "",
    "NullCache.load_overload": "sig target_context",
    "NullCache.save_overload": "sig cres",
    "cgutils.alloca_once_value": "builder value name zfill",
    "cgutils.create_struct_proxy": "fe_type kind",
    "cgutils.for_range": "builder count start intp",
    "cgutils.for_range_slice": "builder start stop step intp inc",
    "cgutils.get_item_pointer": "context builder aryty ary inds wraparound boundscheck",
    "cgutils.get_or_insert_function": "module fnty name",
    "cgutils.unpack_tuple": "builder tup count",
    "compiler.Compiler.__init__": "typingctx targetctx library args return_type flags locals",
    "compiler.Compiler.compile_extra": "func",
    "compiler.Compiler.define_pipelines": "",
    "compiler.DefaultPassBuilder.define_nopython_pipeline": "state name",
    "dumps": "obj",
    "events.install_listener": "kind listener",
    "get_cython_function_address": "module_name function_name",
    "get_host_cpu_features": "",
    "models.PrimitiveModel.__init__": "dmm fe_type be_type",
    "normalize_signature": "sig",
    "register_pass": "mutates_CFG analysis_only",
}
"""Functions, by their names in `numba_private`, with the parameters that they have beside `self` and `cls`."""

ATTRIBUTES = [
    "AbstractTemplate",
    "AnalysisPass.run_pass",
    "AttributeTemplate.generic_resolve",
    "AnnotateTypes.run_pass",
    "binding.Linkage.external",
    "binding.get_host_cpu_name",
    "binding.get_host_cpu_features",
    "cgutils.gep",
    "cgutils.get_null_value",
    "cgutils.int32_t",
    "cgutils.true_bit",
    "cgutils.voidptr_t",
    "config.BOUNDSCHECK",
    "config.CPU_FEATURES",
    "config.CPU_NAME",
    "config.DISABLE_JIT",
    "config.OPT",
    "events.Listener.on_start",
    "events.Listener.on_end",
    "infer_getattr",
    "intrinsic",
    "lower_builtin",
    "overload",
    "register_jitable",
    "register_model",
    "llvm_ir.Constant",
    "llvm_ir.DoubleType",
    "llvm_ir.FunctionType",
    "llvm_ir.IntType",
    "llvm_ir.Undefined",
    "llvm_ir.VectorType",
    "llvmlite.__version__",
    "numba_ir.Assign",
    "numba_ir.Expr",
    "numba_ir.SetItem",
    "numba_ir.StaticSetItem",
    "parallel._is_initialized",
]
"""Other parts that must exist."""

FIELDS = ("type_annotation", "library", "lifted", "signature", "fndesc", "entry_point")
"""Fields of a result of the compiler that the cache and callees read or replace."""


def found(name):
    """A part, by its name in `numba_private` and the attributes below it."""
    value = private
    for part in name.split("."):
        value = getattr(value, part)
    return value


@pytest.mark.parametrize("name", SIGNATURES)
def test_functions_take_what_is_given(name):
    names = [entry for entry in inspect.signature(found(name)).parameters if entry not in ("self", "cls")]
    used = SIGNATURES[name].split()
    assert names[: len(used)] == used, f"{name}({', '.join(names)})"


@pytest.mark.parametrize("name", ATTRIBUTES)
def test_parts_exist(name):
    assert found(name) is not None or name.startswith("config.")


def test_all_parts_are_named_here():
    """A part that is imported has a row in one of the tables."""
    rows = {name.partition(".")[0] for name in (*SIGNATURES, *ATTRIBUTES)}
    assert rows == {*private.__all__}


def test_results_of_the_compiler_have_their_fields():
    assert {*FIELDS} <= {*private.CompileResult._fields}


def test_what_is_replaced_exists():
    """The cache and the compilation of a dispatcher and of a function that is called by address."""
    kernel = numba.njit(lambda x: x)
    assert all(hasattr(kernel, name) for name in ("_cache", "compile", "get_call_template", "get_overload"))
    assert all(hasattr(kernel, name) for name in ("overloads", "targetoptions", "py_func"))
    made = private.CFunc(lambda x: x, private.normalize_signature(numba.float64(numba.float64)), {}, {})
    assert isinstance(made._cache, private.NullCache)
