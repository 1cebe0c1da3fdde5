"""Indicators of chaos by name: those of the command line, of jobs and of functions."""

from __future__ import annotations

from typing import Any

from ...base.names import named
from .indicators import (
    FLI,
    GALI,
    MEGNO,
    OFLI,
    SALI,
    BirkhoffDigits,
    FrequencyDiffusion,
    Indicator,
    Lyapunov,
    LyapunovSpectrum,
    ReversibilityError,
    ZeroOne,
)

_KNOWN: tuple[Any, ...] = (
    MEGNO(),
    SALI(),
    *(GALI(k) for k in range(2, 9)),
    FLI(),
    OFLI(),
    Lyapunov(),
    BirkhoffDigits(),
    FrequencyDiffusion(),
    ZeroOne(),
    ReversibilityError(),
)
INDICATORS: dict[str, Any] = {**{entry.name: entry for entry in _KNOWN}, "spectrum": LyapunovSpectrum()}
"""Indicators with their default limits, by name."""


def indicator_names(text: str, option: str = "indicators") -> tuple[str, ...]:
    """Return the names in a text, with commas between them, as they are in INDICATORS."""
    return tuple(named(option, name.strip(), INDICATORS) for name in text.split(","))


def indicators_of(value: Any, _: Any = None) -> Any:
    """Return the tuple of indicators that one of them, a name, or names with commas stand for; anything else as it
    is.
    """
    if isinstance(value, Indicator):
        return (value,)
    if isinstance(value, str):
        return tuple(INDICATORS[name] for name in indicator_names(value))
    if isinstance(value, (tuple, list)):
        return tuple(entry for one in value for entry in (indicators_of(one) if isinstance(one, str) else (one,)))
    return value
