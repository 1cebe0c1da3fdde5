"""The only place that configures Numba: decorators, lane width, compile cache."""

from __future__ import annotations

import contextlib
import functools
import gc
import hashlib
import os
import platform
import stat
import sys
import sysconfig
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba import types
from numba.core import cgutils
from numba.core import config as _config
from numba.core import event as events
from numba.core.ccallback import CFunc
from numba.core.codegen import get_host_cpu_features
from numba.core.sigutils import normalize_signature
from numba.extending import intrinsic

from ..base.interruption import unbroken
from ..base.progress import Compiling
from .cache import CodeCache, others_write
from .callees import Callee, EntryPipeline
from .fingerprint import COMPILED
from .packs import FOLDER, Pack, best

config: Any = _config  # its options are set at run time, unknown to type checkers

LANES = 128
"""Orbits in a lane block. A constant of the compiled code: a state block is a flat array whose row r
starts at r*LANES, so that LLVM sees constant distances between rows and needs no aliasing checks."""

POINTS = 32 * LANES
"""Points of a function of many points that a thread takes at once."""

GENERATED = ("blocks", "formulas")
"""Folders of generated source text in the cache."""

JIT_DISABLED = bool(config.DISABLE_JIT)


def package_hash(*folders: str) -> str:
    """Hash of every source file of the package, or of some of its folders, and of the compiler and its options."""
    return _hash(sys.version, folders)


@functools.cache
def _hash(python: str, folders: tuple[str, ...]) -> str:
    flags = f"{config.OPT} {config.BOUNDSCHECK}"  # of the environment, NUMBA_OPT and NUMBA_BOUNDSCHECK
    compilers = f"{numba.__version__} {llvmlite.__version__} {python}"
    digest = hashlib.sha256(f"{compilers} {platform.machine()} {flags}".encode())
    root = Path(__file__).parents[1]
    for path in sorted(path for top in folders or ("",) for path in (root / top).rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:20]


def code_hash() -> str:
    """Hash of the sources of machine code and of the compiler: the key of the compile cache."""
    return package_hash(*COMPILED)


def pack_key() -> str:
    """The same hash with EXT_SUFFIX for Python's version: the key of packs, which another build of this version of
    Python has compiled elsewhere.
    """
    return _hash(f"{sysconfig.get_config_var('EXT_SUFFIX')}", COMPILED)


@functools.cache
def prebuilt() -> Pack | None:
    """Return the pack that came with the package for these sources and this processor; None where there is none, and
    where the environment names a target processor (NUMBA_CPU_NAME, NUMBA_CPU_FEATURES).
    """
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        return None
    known = [entry[1:] for entry in get_host_cpu_features().split(",") if entry.startswith("+")]
    return best(FOLDER, pack_key(), known)


def cache_root() -> Path:
    """Folder of all compile caches: $FASTAFF_CACHE_DIR, else fastaff/ in the user's cache folder."""
    named = os.environ.get("FASTAFF_CACHE_DIR")
    if named:
        return _absolute(named)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData/Local")) / "fastaff"
    home = os.environ.get("XDG_CACHE_HOME", "")
    # By its specification one that is not absolute is none.
    return (Path(home) if os.path.isabs(home) else Path.home() / ".cache") / "fastaff"


@functools.cache
def _absolute(named: str) -> Path:
    """Return the path of a folder that was named before the process went elsewhere: the first time tells."""
    return Path(named).absolute()


@functools.cache
def cache_directory() -> Path | None:
    """Private cache folder of exactly these sources; None, after one warning, where there is none and none can be made.

    Its files are executed, so it must belong to the user or to root, and neither it nor its parts may be writable by
    others. A folder that this process can only read is enough.
    """
    folder = cache_root() / code_hash()
    parts = [cache_root(), folder, *(folder / name for name in GENERATED)]
    try:
        cache_root().parent.mkdir(parents=True, exist_ok=True)
        for part in parts:
            part.mkdir(mode=0o700, exist_ok=True)
        refused = next(filter(None, (who_else_writes(part, parent=part is parts[0]) for part in parts)), None)
    except OSError as problem:
        refused = f"fastaff cannot write its compile cache ({problem})", "Set FASTAFF_CACHE_DIR to a writable folder."
    if refused is not None:
        warnings.warn(
            f"{refused[0]}; kernels are compiled anew in every process. {refused[1]}", RuntimeWarning, stacklevel=2
        )
        return None
    return folder


Compiling.root = staticmethod(cache_root)
Compiling.sources = staticmethod(lambda: code_hash() if prebuilt() is None else "")


def who_else_writes(folder: Path, *, parent: bool = False) -> tuple[str, str] | None:
    """Return the fault of a folder of code that somebody else could write to, and its remedy; None where only this user
    and root can write.

    parent: it holds no code itself, but the folders of code. Such a one may be shared like /tmp, where only owners may
    rename (sticky). A link is followed: the folder that it leads to counts. Windows keeps a user's folders private by
    itself.
    """
    if not hasattr(os, "geteuid"):
        return None
    status = folder.stat()
    own = status.st_uid in (0, os.geteuid())
    if not others_write(status) or (parent and own and status.st_mode & stat.S_ISVTX):
        return None
    said = f"fastaff does not use its compile cache, whose code it would run: the folder {folder}"
    if not own:
        return f"{said} belongs to another user (uid {status.st_uid})", "Set FASTAFF_CACHE_DIR to a folder of your own."
    mode = stat.S_IMODE(status.st_mode)
    return f"{said} can be written by others (mode {mode:o})", f"Empty it and run: chmod -R go-w '{folder}'"


class _Between(events.Listener):
    """Handle signals at the start of a pass of the compiler: elsewhere they may be lost, or leave it half done, locked
    for other threads or with unfinished calls on its own record.
    """

    def __init__(self, take: Callable[[], None]):
        self._take = take

    def on_start(self, event):
        """Handle the signals that have come."""
        self._take()

    def on_end(self, event):
        """Do nothing: the output of the pass is not stored yet."""


@contextlib.contextmanager
def compiling() -> Iterator[None]:
    """Run the block, which compiles or loads. Signals wait for the next pass: LLVM asks Python for code, and goes on
    without it after an error. Garbage collection waits: it takes a fifth of the time, and there is little garbage.
    """
    with Compiling.under_way(), unbroken() as take, events.install_listener("numba:run_pass", _Between(take)):
        before = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if before:
                gc.enable()


def jit(
    function: Callable | None = None, *, constants: bool = False, inline: bool = False, apart: bool = False
) -> Callable:
    """Compile a kernel at its first call: strict floating point, no GIL, cached by package content.

    With `constants`, calls with constants get separate code for these: for loops over rows of lanes, which become up to
    a third faster. Else one code serves all numbers. With `inline` the code becomes part of the caller, which alone is
    compiled: for a function with a single caller. With `apart` its callers jump to it: for a long function called in
    several places, whose copies would take long to compile.
    """
    if function is None:
        return functools.partial(jit, constants=constants, inline=inline, apart=apart)
    if JIT_DISABLED:
        return function
    how: Any = "always" if inline else "never"
    kernel: Any = numba.njit(function, nogil=True, error_model="numpy", inline=how)
    if (folder := cache_directory()) is not None:
        kernel._cache = CodeCache(function, folder, prebuilt)
    kernel.compile = compiling()(kernel.compile)
    if not inline:
        kernel.part = Callee(function, constants=constants, apart=apart)
        kernel.get_call_template = kernel.part.get_call_template
        kernel.get_overload = kernel.part.get_overload
    return kernel


def _element(context, builder, array_type, array, index):
    """Address of array[index]."""
    view = context.make_array(array_type)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, array_type, view, [index], wraparound=False)


@intrinsic
def _atomic_read(typingcontext, array, index):
    def generate(context, builder, signature, arguments):
        address = _element(context, builder, signature.args[0], *arguments)
        return builder.load_atomic(address, "monotonic", 8)

    return array.dtype(array, index), generate


@intrinsic
def _atomic_write(typingcontext, array, index, value):
    def generate(context, builder, signature, arguments):
        address = _element(context, builder, signature.args[0], *arguments[:2])
        builder.store_atomic(arguments[2], address, "monotonic", 8)
        return context.get_dummy_value()

    return types.void(array, index, array.dtype), generate


@jit
def read_now(array, index):
    """Read array[index] (int64) from memory at this very moment.

    Kernels promise LLVM that nobody else writes to their arrays, so a plain read of a flag that another thread sets is
    moved out of the loop that polls it.
    """
    return _atomic_read(array, index)


@jit
def write_now(array, index, value):
    """Write array[index] (int64) to memory at this very moment, for another thread to see."""
    _atomic_write(array, index, value)


if JIT_DISABLED:

    def read_now(array, index):
        """Read array[index]."""
        return array[index]

    def write_now(array, index, value):
        """Write array[index]."""
        array[index] = value


class BlockFunction(types.WrapperAddressProtocol):
    """A compiled function that kernels receive as a typed pointer: they need no recompilation for it."""

    def __init__(self, function: Callable, signature: Any, *, cache: bool, keyed: bool = False):
        compiled: Any = CFunc(function, normalize_signature(signature), {}, {"error_model": "numpy"}, EntryPipeline)
        if cache and (folder := cache_directory()) is not None:
            compiled._cache = CodeCache(function, folder, prebuilt, keyed=keyed)
        with compiling():
            compiled.compile()
        self._compiled = compiled
        # the hash of a text is quick
        self._signature = signature
        self.shown = str(signature)
        self._address: Any = compiled.address

    def __wrapper_address__(self) -> int:
        return self._address

    def signature(self) -> Any:
        return self._signature


def block_function(function: Callable, signature: Any, *, cache: bool) -> Callable | BlockFunction:
    """Compile `function` for use as a kernel argument (the function itself where the JIT is disabled). The name of its
    module is a key of all that it reads.
    """
    return function if JIT_DISABLED else BlockFunction(function, signature, cache=cache, keyed=True)


_f8 = types.float64
_i8 = types.int64
_vector, _matrix = (types.Array(_f8, axes, "C") for axes in (1, 2))
SIGNATURES = {
    # (params, lanes, drifts, kicks, step, steps, z) -> steps taken: until a lane leaves the domain
    "splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    "precise_splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # drifts and kicks are the tableau of `nystrom`
    "nystrom_splitting": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # For maps drifts are the weights of iterates, see `map_sums`
    "moments": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    "angles": _i8(_vector, _i8, _vector, _vector, _vector, _i8, _vector),
    # (params, drifts, kicks, step, steps, z, trace) -> steps taken: whole steps of lane 0, until it leaves the domain;
    # or all of them, and the state after the k-th in lane k of a trace that is not empty
    "march": _i8(_vector, _vector, _vector, _f8, _i8, _vector, _vector),
    "nystrom_march": _i8(_vector, _vector, _vector, _f8, _i8, _vector, _vector),
    # (address of the derivative, params, lanes, rows, a, b, dense, sweeps, step, z, k, work) -> steps taken: one
    "step": _i8(_i8, _vector, _i8, _i8, _matrix, _vector, _matrix, _i8, _vector, _vector, _vector, _vector),
    # (params, lanes, z, result)
    "derivative": types.void(_vector, _i8, _vector, _vector),
    "inside": types.void(_vector, _i8, _vector, _vector),
    "value": types.void(_vector, _i8, _vector, _vector),
    "kinetic": types.void(_vector, _i8, _vector, _vector),
    "potential": types.void(_vector, _i8, _vector, _vector),
    "along": types.void(_vector, _i8, _vector, _vector),
    # (params, lanes, states before, z, status)
    "leapt": types.void(_vector, _i8, _vector, _vector, _vector),
    # (params, lanes, escape radii, z, status, largest kinetic energy so far)
    "check": types.void(_vector, _i8, _vector, _vector, _vector, _vector),
    # (params, lanes, n, k, m, due, memory, result)
    "reading": types.void(_vector, _i8, _i8, _i8, _i8, _vector, _vector, _vector),
    # (params, calls, lanes, orbit, fresh, t, z, memory, out, done) -> lanes that became done
    "observe": _i8(
        _vector,
        types.Array(_i8, 2, "C"),
        _i8,
        types.Array(_i8, 1, "C"),
        _vector,
        _vector,
        _vector,
        _vector,
        types.Array(_f8, 2, "A"),  # each of two observers has some of the columns
        _vector,
    ),
}
