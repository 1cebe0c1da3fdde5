"""Checks of numbers: each raises at once and names the argument, the value given and the values allowed."""

from __future__ import annotations

import contextlib
import math
import operator
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .foreign import without_unit

MOST = 2**53
"""Whole numbers up to here are floats too; no run ends that has more steps."""

SMALL = 8 * 2**20
"""Bytes up to which free memory is not asked for: asking the system takes longer than a short call."""

DEEPEST = 24
"""Dimensions that an array may have: NumPy makes more, and fails with them later."""

SINGLE = (int, float, complex, np.generic, str, bytes)
"""Classes of single entries that carry neither a unit nor a mask."""

StrPath = str | os.PathLike[str]
"""A path."""

Callback = Callable[[float], None]
"""Called about ten times a second with the fraction of the work that is done."""


def positive(name: str, value: Any) -> float:
    """Return `value` as a finite float above 0."""
    number = real(name, value)
    if not number > 0.0:
        raise ValueError(f"{name} must be positive, got {shown(value)}")
    return number


def nonnegative(name: str, value: Any) -> float:
    """Return `value` as a finite float of at least 0."""
    number = real(name, value)
    if number < 0.0:
        raise ValueError(f"{name} must be at least 0, got {shown(value)}")
    return number


def real(name: str, value: Any) -> float:
    """Return `value` as a finite float."""
    try:
        if not _is_single(value) or np.iscomplexobj(value):
            raise TypeError
        number = float(value)
    except OverflowError:
        raise ValueError(f"{name} must be within the range of floats") from None
    except (TypeError, ValueError):
        refuse_unit(name, value)
        raise TypeError(f"{name} must be a real number, got {shown(value)} ({type(value).__name__})") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} must be finite, got {shown(value)}")
    return number


def whole(name: str, value: Any, least: int, most: int = MOST) -> int:
    """Return `value` as an int from `least` to `most`."""
    try:
        if not _is_single(value):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        refuse_unit(name, value)
        raise TypeError(f"{name} must be a whole number, got {shown(value)} ({type(value).__name__})") from None
    if number < least:
        raise ValueError(f"{name} must be at least {least}, got {number}")
    if number > most:
        raise ValueError(f"{name} must be at most {'2**53' if most == MOST else most}, got {shown(number)}")
    return number


def number_of_steps(time: Any, step: Any) -> np.ndarray:
    """Return the number of steps in `time`, as floats; ValueError for more than 2**53."""
    wanted = np.ceil(time / np.asarray(step) * (1 - 1e-12))
    if not np.all(wanted < MOST):
        raise ValueError(
            f"time (or max_time) needs {np.max(wanted):.3g} steps of {np.min(step):.3g}: no run comes to its end"
        )
    return wanted


def whole_numbers(name: str, value: ArrayLike) -> np.ndarray:
    """Return whole numbers as an array of integers; whole floats are converted, all else and an empty array refused."""
    numbers = an_array(name, value)
    if numbers.dtype.kind not in "iuf" or numbers.size == 0:
        raise TypeError(f"{name} must be whole numbers, got {shown(value)}")
    if numbers.dtype.kind == "f":
        numbers = numbers.astype(np.float64)
    if not np.all(np.abs(numbers) < MOST) or np.any(numbers != np.round(numbers)):
        raise ValueError(f"{name} must be whole numbers below 2**53, got {shown(value)}")
    return numbers.astype(np.int64)


def an_array(name: str, value: Any) -> np.ndarray:
    """Return `value` as an array of entries of any type; ValueError for masked ones, rows of different lengths or too
    many dimensions; TypeError for units, and for True or False among numbers.
    """
    if len(_kinds(name, value)) == 2:
        raise TypeError(f"{name} must not mix numbers with True or False, got {shown(value)}")
    try:
        array = np.asarray(value)
    except (ValueError, OverflowError):
        raise ValueError(f"{name} must be an array of numbers, with rows of one length, got {shown(value)}") from None
    except (TypeError, RuntimeError) as problem:  # on another device, or with a record of gradients
        raise TypeError(
            f"{name} must be an array of numbers, got a {type(value).__name__} ({reason(problem)})"
        ) from None
    if array.ndim > DEEPEST:
        raise ValueError(f"{name} must have at most {DEEPEST} dimensions, got {array.ndim}")
    return array


def _kinds(name: str, value: Any, depth: int = 2 * DEEPEST) -> set[bool]:
    """Return the kinds of entries: True for True or False, False for others; refuse masks and units, in lists too."""
    if isinstance(value, (list, tuple)) and depth > 0:
        found = set()
        for kind in set(map(type, value)):
            if issubclass(kind, SINGLE):
                found.add(issubclass(kind, (bool, np.bool_)))
            else:
                found.update(*(_kinds(name, entry, depth - 1) for entry in value if type(entry) is kind))
        return found
    if np.ma.is_masked(value):
        raise ValueError(f"{name} must have no masked entries, whose values mean nothing; got {shown(value)}")
    refuse_unit(name, value)
    return {value.dtype.kind == "b"} if isinstance(value, np.ndarray) and value.size else set()


def refuse_unit(name: str, value: Any) -> None:
    """Raise TypeError for an array that carries a unit."""
    if unit := _unit(value):
        plain = without_unit(value)
        known = "" if plain is value else f" ({shown(plain.tolist(), 24)} in kpc, Myr, solar masses)"
        raise TypeError(
            f"{name} must be plain numbers, got {shown(value)} in {unit}. Use .to_value(unit), in the unit of the "
            f"system{known}."
        )


def _unit(value: Any) -> str:
    """Return the unit that a number or an array carries (Astropy's `unit`; `units` of Pint and unyt), "" for none. A
    text in `units` is a label, as of xarray.
    """
    unit = getattr(value, "unit", None)
    units = getattr(value, "units", None)
    said = str(unit if unit is not None else "" if units is None or isinstance(units, str) else units)
    return "" if said == "dimensionless" else said


def _is_single(value: Any) -> bool:
    """Tell whether a value may be one number: no True or False, text, date, mask, or quantity with a unit."""
    kind = getattr(getattr(value, "dtype", None), "kind", "O")
    other = kind not in "iufcO" or isinstance(value, (bool, str, bytes, list, tuple, np.ma.MaskedArray))
    return not other and not _unit(value) and np.ndim(value) == 0


def numbers(name: str, value: Any) -> np.ndarray:
    """Return `value` as an array of floats, finite or not."""
    array = an_array(name, value)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be an array of real numbers, got {shown(value)} ({type(value).__name__})")
    return array.astype(np.float64, copy=False)


def entries(name: str, value: Any, takes: str, *counts: int) -> list[Any]:
    """Return the entries of a tuple, list or array; TypeError with the text `takes` for anything else, or for another
    count.
    """
    listed = isinstance(value, (tuple, list)) or (
        isinstance(value, np.ndarray) and value.ndim > 0 and not np.ma.is_masked(value)
    )
    if not listed or (counts and len(value) not in counts):
        raise TypeError(f"{name} must be {takes}, got {shown(value)} ({type(value).__name__})")
    return list(value)


def reals(name: str, value: Any) -> tuple[float, ...]:
    """Return a sequence of finite numbers as a tuple of floats."""
    return tuple(real(f"{name}[{k}]", entry) for k, entry in enumerate(entries(name, value, "a tuple of numbers")))


def span(name: str, value: Any) -> tuple[float, float]:
    """Return a range (low, high) with low < high."""
    ends = [real(f"{name}[{k}]", end) for k, end in enumerate(entries(name, value, "a range (low, high)", 2))]
    if not ends[0] < ends[1]:
        raise ValueError(f"{name} must be a range (low, high) with low < high, got {shown(value)}")
    return ends[0], ends[1]


def texts(name: str, value: Any) -> tuple[str, ...]:
    """Return a sequence of texts as a tuple."""
    if not isinstance(value, (tuple, list)) or not all(isinstance(entry, str) for entry in value):
        raise TypeError(f"{name} must be a tuple of texts, got {shown(value)} ({type(value).__name__})")
    return tuple(value)


def flag(name: str, value: Any) -> bool:
    """Return `value` if it is True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, got {shown(value)} ({type(value).__name__})")
    return bool(value)


def text(name: str, value: Any) -> str:
    """Return `value` if it is a text."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a text, got {shown(value)} ({type(value).__name__})")
    return value


def function(name: str, value: Any) -> Any:
    """Return `value` if it can be called."""
    if not callable(value):
        raise TypeError(f"{name} must be a function, got {shown(value)} ({type(value).__name__})")
    return value


def checked_callback(value: Any) -> Any:
    """Return `value` if it is None or can be called with the fraction that is done."""
    if value is not None and not callable(value):
        raise TypeError(
            f"callback must be a function of the fraction done, or None, got {shown(value)} ({type(value).__name__})"
        )
    return value


def portion(callback: Any, part: int, parts: int) -> Any:
    """Return a function that reports the fraction done of one of several parts as that of all; None without one."""
    if callback is None:
        return None
    return lambda fraction: callback((part + min(fraction, 1.0)) / parts)


class Passes:
    """One count over the passes of a call, some of which depend on the results of earlier ones: the fraction that is
    reported never falls, and is 1 at the end.
    """

    def __init__(self, callback: Any):
        self.callback = callback
        self.done = 0.0
        self.end = 0.0

    def take(self, work: float, rest: float = 0.0) -> Any:
        """Return the callback of the next pass: it gets the share work / (work + rest) of the fraction that is left,
        with `rest` the work expected after it; None where nothing is reported.
        """
        if self.callback is None:
            return None
        begin = self.end
        end = self.end = 1.0 if rest <= 0 else begin + (1.0 - begin) * work / (work + rest)
        return lambda fraction: self._tell(begin + (end - begin) * min(fraction, 1.0))

    def _tell(self, fraction: float) -> None:
        self.done = max(self.done, fraction)
        self.callback(self.done)

    def __enter__(self) -> Passes:
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        if kind is None and self.callback is not None:
            self._tell(1.0)


def fits(name: str, *shape: int, itemsize: int = 8) -> None:
    """Raise ValueError, with the bytes, where memory has no room for an array of that shape; `name` is the argument to
    make smaller.
    """
    size = itemsize * math.prod(map(int, shape))
    if size > SMALL and size > (free := free_memory()):
        raise ValueError(
            f"{name} asks for {_bytes(size)} of memory (an array of {' x '.join(shown(side, 20) for side in shape)}), "
            f"{_bytes(free)} are free"
        )


def free_memory() -> int:
    """Return the bytes that this process may still take, as far as the system tells: of the machine and of its control
    group.
    """
    known = []
    with contextlib.suppress(OSError, ValueError, IndexError):
        rows = Path("/proc/meminfo").read_text().splitlines()
        known += [1024 * int(row.split()[1]) for row in rows if row.startswith("MemAvailable:")]
    for limit, used in (
        ("memory.max", "memory.current"),
        ("memory/memory.limit_in_bytes", "memory/memory.usage_in_bytes"),
    ):
        with contextlib.suppress(OSError, ValueError):
            group = Path("/sys/fs/cgroup")
            taken = int((group / used).read_text())
            with contextlib.suppress(OSError, ValueError, StopIteration):  # files in memory give way
                rows = (group / used).with_name("memory.stat").read_text().splitlines()
                taken -= next(
                    int(row.split()[1]) for row in rows if row.startswith(("inactive_file", "total_inactive_file"))
                )
            known.append(max(0, int((group / limit).read_text()) - taken))
    if not known:
        with contextlib.suppress(OSError, ValueError, AttributeError):
            known.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(known, default=2**47)


LONGEST = 60
"""Characters of a value in a message."""

MOST_NAMES = 8
"""Names in a message."""


def shown(value: Any, length: int = LONGEST) -> str:
    """Return the repr of a value in one line, shortened; its class where repr fails."""
    try:
        said = " ".join(repr(value).split())
    except Exception:
        said = f"<{type(value).__name__}>"
    return said if len(said) <= length else said[: length - 4] + " ..."


def listed(names: Any) -> str:
    """Return names with commas between them, the first of many."""
    known = [str(name) for name in names]
    return ", ".join(known[:MOST_NAMES]) + (", ..." if len(known) > MOST_NAMES else "")


def kind_of(model: Any) -> str:
    """Return the name of a model's class in a message, "the system" for a class that was made of a formula."""
    return "the system" if "_request" in vars(type(model)) else type(model).__name__


def titled(name: str, model: Any) -> str:
    """Return the name of an argument with that of the class of the model it has; alone if a formula made the class."""
    return name if "_request" in vars(type(model)) else f"{name} {type(model).__name__}"


def reason(problem: BaseException) -> str:
    """Return the kind and the text of an error of a user's function, shortened."""
    said = " ".join(f"{type(problem).__name__}: {problem}".split())
    return said if len(said) <= LONGEST else said[: LONGEST - 4] + " ..."


def _bytes(size: float) -> str:
    size = float(min(size, 10**300))
    for unit in ("bytes", "KiB", "MiB", "GiB", "TiB", "PiB"):
        if size < 1024:
            return f"{size:.4g} {unit}"
        size /= 1024
    return f"{size:.4g} EiB"
