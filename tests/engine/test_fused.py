"""Fused multiply-add: exact arithmetic rounded once, in vectors, in lanes left over, and for one orbit alone."""

from __future__ import annotations

import os
import subprocess
import sys

import numba
import numpy as np
import pytest
from exact_steps import fma_exact, run_block, run_single

from fastaff import Body, HenonHeiles, Hyperelastic, NeoHookean, integrate
from fastaff.engine import source
from fastaff.engine.blocks import model_block
from fastaff.engine.fused import FUSED, fma, has_instructions
from fastaff.engine.jit import JIT_DISABLED, LANES, SIGNATURES, BlockFunction
from fastaff.engine.values import parameters
from fastaff.runs.schemes import BLANES_MOAN6, KAHAN_LI8

fused = pytest.mark.skipif(not FUSED or JIT_DISABLED, reason="no such instruction")


@numba.njit
def _in_a_loop(a, b, c, result):
    for i in range(result.size):
        result[i] = fma(a[i], b[i], c[i])


@fused
@pytest.mark.parametrize("size", [1, 2, 3, 7, 8, 9, 15, 31, 64, 1001])
def test_rounds_once_in_loops_of_any_length(size):
    rng = np.random.default_rng(size)
    a, b = rng.standard_normal((2, size))
    c = -a * b * (1 + rng.integers(0, 2, size) * rng.standard_normal(size))  # often nearly nothing is left
    result = np.empty(size)
    _in_a_loop(a, b, c, result)
    assert (result == [fma_exact(*numbers) for numbers in zip(a, b, c, strict=True)]).all()
    assert size < 8 or (result != a * b + c).any()


@pytest.mark.skipif(JIT_DISABLED or not has_instructions("avx512f", other=False), reason="no such vectors")
def test_loops_over_lanes_take_the_longest_vectors():
    def scaled(params, lanes, z, result):
        for i in range(lanes):
            result[i] = params[0] * z[i]

    block = BlockFunction(scaled, SIGNATURES["value"], cache=False)
    assert "fmul <8 x double>" in block._compiled._library.get_llvm_str()


@fused
@pytest.mark.parametrize("kind", ["splitting", "precise_splitting"])
@pytest.mark.parametrize("lanes", [1, 2, 5, 8, 13, 128])
@pytest.mark.parametrize("model", [HenonHeiles(0.7), Body(Hyperelastic(1.3), 0.8), Body(NeoHookean(1.1, 2.2), 1.7)])
def test_a_block_has_the_bits_of_its_text(model, lanes, kind):
    """The text run by Python with exact sums and products, lane by lane, and what is compiled of it: the same bits, in
    vectors and in the lanes left over; so has the loop for a single orbit.
    """
    rows, rng = 2 * model.degrees_of_freedom, np.random.default_rng(lanes)
    z = np.zeros((1 if kind == "splitting" else 3) * rows * LANES)
    for r in range(rows):
        z[r * LANES : r * LANES + lanes] = (1.0 if r == 0 else 0.0) + 0.2 * rng.standard_normal(lanes)
    step = rng.uniform(0.01, 0.1, LANES)
    tables = BLANES_MOAN6.drift_array, BLANES_MOAN6.kick_array
    compiled, single, strict = z.copy(), z.copy(), z.copy()

    taken = run_block(model_block(kind, model, rows // 2), parameters(model), lanes, *tables, step, 3, compiled)
    names = {"fma": fma_exact, "value": model}
    head, _, body = source(model, kind).partition("    value = ")
    exec(head + body.partition("\n")[2], names)
    assert names[kind](parameters(model), lanes, *tables, step, 3, strict) == taken == 3
    np.testing.assert_array_equal(compiled, strict)

    if kind == "splitting":
        assert run_single(model_block("march", model, rows // 2), parameters(model), *tables, step[0], 3, single) == 3
        np.testing.assert_array_equal(single[::LANES], strict[::LANES])


def test_steps_end_with_the_one_that_leaves_the_domain():
    """A lane whose determinant becomes negative ends the run of its block, at its own step."""
    model, lanes, step = Body(Hyperelastic()), 5, np.full(LANES, 0.3)
    z = np.zeros((8, LANES))
    z[0], z[2] = 1.5, 0.3
    z[4, 3], z[6, 3] = -40.0, 40.0
    block, taken = model_block("splitting", model, 4), 0
    tables = KAHAN_LI8.drift_array, KAHAN_LI8.kick_array
    flat = z.ravel()
    call = block if JIT_DISABLED else lambda *arguments: run_block(block, *arguments)
    for steps in (1, 50):
        taken += call(parameters(model), lanes, *tables, step, steps, flat)
    assert taken < 51
    margins = model.margin(*flat.reshape(8, LANES)[:4, :lanes])
    assert not margins[3] > 0
    assert (np.delete(margins, 3) > 0).all()


OTHER = """
import numpy as np
from fastaff import HenonHeiles, integrate
from fastaff.engine.fused import FUSED
assert not FUSED
z = integrate(HenonHeiles(), np.array([[0.0, 0.0], [0.1, 0.1], [0.4, 0.3], [0.2, 0.2]]), time=5.0, step=0.1).z
print(*map(float.hex, z.ravel()))
"""


@pytest.mark.skipif(JIT_DISABLED, reason="needs compiled code")
def test_a_processor_without_the_instruction_multiplies_and_adds(tmp_path):
    """Other last digits, the same orbits."""
    environment = {**os.environ, "NUMBA_CPU_NAME": "generic", "FASTAFF_CACHE_DIR": str(tmp_path / "cache")}
    for name in ("NUMBA_CPU_FEATURES",):
        environment.pop(name, None)
    ran = subprocess.run([sys.executable, "-c", OTHER], env=environment, capture_output=True, text=True, check=True)
    there = np.array([float.fromhex(number) for number in ran.stdout.split()]).reshape(4, 2)
    z0 = np.array([[0.0, 0.0], [0.1, 0.1], [0.4, 0.3], [0.2, 0.2]])
    here = integrate(HenonHeiles(), z0, time=5.0, step=0.1).z
    np.testing.assert_allclose(there, here, rtol=1e-12, atol=1e-13)
