"""An indicator of chaos and an observer of one's own: each is one value and one function, compiled at its first use.

The indicator reads the growth of the area of two tangent vectors of Henon-Heiles orbits, in the pass that MEGNO makes
anyway. The observer keeps each orbit's largest distance from the origin, and ends it beyond a
given one.
"""

import math
from typing import NamedTuple

import numpy as np

import fastaff
from fastaff.engine.jit import LANES
from fastaff.engine.kernels.readings import stretch
from fastaff.runs.observers import Observer
from fastaff.runs.options import Options, plan


def decades(growth, i, weight):
    """Return the decades by which the area of the first two vectors has grown, each with a weight, in lane i."""
    return weight * (stretch(growth, 0, i) + stretch(growth, 1, i)) / math.log(10.0)


AREA = fastaff.chaos.TangentIndicator("area", decades, threshold=8.0, count=2, parameters=(1.0,))


class Farthest(NamedTuple):
    """Where orbits end."""

    threshold: float = 1.0


def farthest(value, lanes, orbit, fresh, t, z, memory, out, done):
    """Keep the largest distance in row 0 of the memory and its time in column 0 of out; end orbits beyond the
    threshold.
    """
    ended = 0
    for i in range(lanes):
        distance = math.hypot(z[i], z[LANES + i])
        if fresh[i] > 0.0 and distance > memory[i]:
            memory[i], out[orbit[i], 0] = distance, t[i]
            if distance > value.threshold:
                done[i] = 1.0
                ended += 1
    return ended


def starts(count, seed=1):
    """Return starts of Henon-Heiles (4, count) on the plane x = 0 at E = 1/8."""
    random = np.random.default_rng(seed)
    y, p_y = random.uniform(-0.3, 0.5, count), random.uniform(-0.2, 0.2, count)
    return np.array([np.zeros(count), y, np.sqrt(0.25 - y * y + 2 / 3 * y**3 - p_y**2), p_y])


if __name__ == "__main__":
    model, z0 = fastaff.HenonHeiles(), starts(40)
    found = fastaff.chaos_map(model, z0, time=1000.0, step=0.1, indicators=(fastaff.MEGNO(), AREA))
    print(found.summary())
    for megno, area, classification in zip(found.megno[:5], found.area[:5], found.classification[:5]):
        said = fastaff.Classification(classification).name.lower()
        print(f"  MEGNO {megno:7.2f}, area grown by {area:6.2f} decades: {said}")
    flow, z, *_ = plan(model, z0, Options(step=0.05))
    orbits, memory, when = flow.observed(z, Observer(farthest, rows=1, value=Farthest(0.6)), time=100.0)
    ended = orbits.time < 100
    print(f"{ended.sum()} of {z.shape[1]} orbits come farther than 0.6, the first after {orbits.time.min():.2f}")
