"""Height fields: the cost of distances does not depend on where a rod is."""

import time

import numpy as np
import pytest

import lissom

#: Seconds that an evaluation may take anywhere: ten times the longest one seen, on a busy machine. It was 24
#: near the centre of curvature of a hill, where many places of the ground are almost equally near.
MOST = 0.5


def seconds(rod, q):
    """The median time of an evaluation in shapes that differ, each of which is searched anew."""
    rest = np.zeros(rod.n)
    rod.inverse_dynamics(q, rest, rest)
    times = []
    for k in range(7):
        shape = q * (1.0 + 0.1 * k)
        begin = time.perf_counter()
        rod.inverse_dynamics(shape, rest, rest)
        times.append(time.perf_counter() - begin)
    return float(np.median(times))


@pytest.mark.parametrize(
    "height",
    [
        lambda x, y: 0.05 * np.sin(7 * x) * np.cos(5 * y),
        lambda x, y: -0.2 * (x**2 + y**2),
        lambda x, y: 0.2 * (x**2 + y**2),
        lambda x, y: 0.02 * np.sin(1e4 * (x + np.pi * y)),
    ],
    ids=["waves", "hill", "bowl", "rough"],
)
@pytest.mark.parametrize("depth", [0.3, 1.0, 2.4, 2.6, 10.0])
def test_deep_places_are_found_in_time(height, depth):
    x = np.linspace(-1.0, 1.0, 41)
    heights = height(x[:, None], x[None, :])

    def at(z):
        """A rod in the middle of the ground, so high above it."""
        ground = lissom.HeightField(heights, x[1] - x[0], (-1.0, -1.0, -z))
        segment = lissom.Segment(0.3, 0.01, 1e7, 4e6, 1000, modes={"bend_y": 2})
        return lissom.Rod([segment], contacts=[lissom.Contact("rod", ground, stiffness=1e4)])

    q = np.array([0.1, -0.05])
    level = float(height(0.0, 0.0))
    assert seconds(at(level - depth), q) < MOST
