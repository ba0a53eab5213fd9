"""A column under a growing load: straight, then buckled to one side; how its lowest frequency goes to zero.

The load factor scales 1.5 times Euler's buckling load.
"""

import numpy as np

import lissom

length, radius, young_modulus = 1.0, 0.01, 1e9
euler = np.pi**2 / 4 * young_modulus * np.pi / 4 * radius**4 / length**2
column = lissom.Segment(length, radius, young_modulus, 4e8, 1000, modes={"bend_y": 6})


def loaded(ratio):
    """The column under a part of Euler's load."""
    return lissom.Rod([column], gravity=(0, 0, 0), tip_force=(-ratio * euler, 0, 0))


print("load / Euler's load   lowest frequency (Hz)")
for ratio in (0.0, 0.5, 0.9, 0.99):
    print(f"{ratio:19.2f}   {lissom.modes(loaded(ratio), np.zeros(6)).frequency[0]:21.4f}")

rod = loaded(1.5)
straight = lissom.continuation(rod)
(point,) = straight.path.critical_points
print(f"\n{point.kind} at {1.5 * point.load_factor:.6f} times Euler's load")

for side in (1, -1):
    branch = lissom.continuation(
        rod, point.q, load_factor=point.load_factor, direction=side * point.directions[0]
    )
    x, _, z = rod.pose(branch.path.q[-1], length)[:3, 3]
    print(f"buckled, {branch.path.stability[-1]}: tip at x = {x:.4f} m, z = {z:+.4f} m")
