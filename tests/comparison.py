"""When two results are the same."""

import dataclasses

import numpy as np


def same(one, other, what="result"):
    """Assert that two values are the same, arrays and numbers to the bit."""
    assert type(one) is type(other), what
    if isinstance(one, (np.ndarray, np.generic)):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), what
        if one.tobytes() != other.tobytes():
            np.testing.assert_array_equal(one, other, err_msg=what)
            raise AssertionError(f"{what}: signs of zero, or NaN of other bits")
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            same(getattr(one, field.name), getattr(other, field.name), f"{what}.{field.name}")
    elif isinstance(one, (tuple, list)):
        assert len(one) == len(other), what
        for k, pair in enumerate(zip(one, other, strict=True)):
            same(*pair, f"{what}[{k}]")
    elif hasattr(one, "keys"):
        assert list(one) == list(other), what
        for key in one:
            same(one[key], other[key], f"{what}[{key!r}]")
    elif isinstance(one, float):
        assert np.float64(one).tobytes() == np.float64(other).tobytes(), what
    else:
        assert one == other, what
