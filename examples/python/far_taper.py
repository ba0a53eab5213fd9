"""The shape of a soft arm that reaches farthest: as much rubber as a cylinder, spread along it by gradients.

A heavy arm, clamped horizontally, droops; more of the same makes it heavier, not stiffer. Length and radii at
equal distances are chosen for the largest horizontal distance of the tip, with the volume given. The gradient
takes no other equilibria: `lissom.equilibrium_sensitivity` differentiates this one.

    python examples/python/far_taper.py [--segments number] [--payload kilograms] [--plot FILE]
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize

import lissom

LENGTH, RADIUS = 0.4, 0.01  # of the cylinder that the rubber would make, metres
VOLUME = np.pi * RADIUS**2 * LENGTH
SMALLEST, LARGEST = 0.003, 0.03  # radii, metres


def arm(lengths, payload: float) -> lissom.Rod:
    """An arm of silicone rubber; `lengths` are its length and its radii from the base to the tip, metres."""
    length, *radii = lengths
    segments = [
        lissom.Segment(
            length / (len(radii) - 1),
            radius=ends,
            young_modulus=3e5,
            poisson_ratio=0.5,
            density=1100.0,
            modes={"bend_y": 3},
        )
        for ends in pairwise(radii)
    ]
    return lissom.Rod(segments, loads=[lissom.Load(force=(0, 0, -9.81 * payload))])


def volume(lengths) -> float:
    """Of frustums, cubic metres."""
    length, radii = lengths[0], np.asarray(lengths[1:])
    base, tip = radii[:-1], radii[1:]
    return np.pi / 3 * length / len(base) * (base**2 + base * tip + tip**2).sum()


def slopes_of_volume(lengths):
    length, radii = lengths[0], np.asarray(lengths[1:])
    base, tip = radii[:-1], radii[1:]
    slopes = np.zeros(len(lengths))
    slopes[0] = volume(lengths) / length
    slopes[1:-1] += 2 * base + tip
    slopes[2:] += 2 * tip + base
    slopes[1:] *= np.pi / 3 * length / len(base)
    return slopes


@dataclass
class Reach:
    """The horizontal distance of the tip, and its gradient with respect to length and radii."""

    payload: float
    equilibria: int = field(default=0, init=False)

    def shape(self, lengths) -> tuple[lissom.Rod, np.ndarray]:
        rod = arm(lengths, self.payload)
        found = lissom.statics(rod)
        if not found.success:
            raise SystemExit(found.message)
        self.equilibria += 1
        return rod, found.q

    def __call__(self, lengths) -> tuple[float, np.ndarray]:
        rod, q = self.shape(lengths)
        names, spread = parameters(len(lengths) - 2)
        position, derivative = lissom.equilibrium_sensitivity(rod, names, q).position()
        return position[0], derivative[0] @ spread


def parameters(segments: int) -> tuple[list[str], np.ndarray]:
    """Names of all lengths and radii, and how they change with `lengths`: neighbours share a radius."""
    names, rows = [], []
    by = np.eye(segments + 2)
    for i in range(segments):
        names += [f"segments[{i}].length", f"segments[{i}].radius[0]", f"segments[{i}].radius[1]"]
        rows += [by[0] / segments, by[1 + i], by[2 + i]]
    return names, np.array(rows)


def farthest(reach: Reach, segments: int, uniform: bool = False):
    """The length and the radii of the arm that reaches farthest; of a cylinder if `uniform`."""
    start = np.array([LENGTH, *[RADIUS] * (segments + 1)])
    # In units of the start; a cylinder has one radius for all.
    spread = np.diag(start)
    if uniform:
        spread = np.column_stack([spread[:, 0], spread[:, 1:].sum(axis=1)])

    def loss(x):
        value, gradient = reach(spread @ x)
        return -value / LENGTH, -(spread.T @ gradient) / LENGTH

    found = minimize(
        loss,
        np.ones(spread.shape[1]),
        jac=True,
        method="SLSQP",
        bounds=[(0.25, 4.0)] + [(SMALLEST / RADIUS, LARGEST / RADIUS)] * (spread.shape[1] - 1),
        constraints={
            "type": "eq",
            "fun": lambda x: volume(spread @ x) / VOLUME - 1,
            "jac": lambda x: spread.T @ slopes_of_volume(spread @ x) / VOLUME,
        },
        options={"ftol": 1e-8, "maxiter": 200},
    )
    if not found.success:
        raise SystemExit(found.message)
    return spread @ found.x


def main(argv=None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--segments", type=int, default=4)
    parser.add_argument("--payload", type=float, default=0.01)
    parser.add_argument("--plot", metavar="FILE")
    options = parser.parse_args(argv)
    designs = {"cylinder": np.array([LENGTH, *[RADIUS] * (options.segments + 1)])}
    effort = {"cylinder": 1}
    for name, uniform in (("best cylinder", True), ("best taper", False)):
        reach = Reach(options.payload)
        designs[name] = farthest(reach, options.segments, uniform)
        effort[name] = reach.equilibria
    shapes = {name: Reach(options.payload).shape(lengths) for name, lengths in designs.items()}
    print("               reach [mm]  length [mm]  volume [cm³]  equilibria  radii [mm]")
    for name, lengths in designs.items():
        rod, q = shapes[name]
        radii = " ".join(f"{1e3 * radius:.1f}" for radius in lengths[1:])
        print(
            f"{name:13}  {1e3 * rod.pose(q)[0, 3]:10.1f}  {1e3 * lengths[0]:11.1f}  "
            f"{1e6 * volume(lengths):12.2f}  {effort[name]:10}  {radii}"
        )
    reached = [rod.pose(q)[0, 3] for rod, q in shapes.values()]
    print(f"The taper reaches {reached[2] / reached[1]:.2f} times as far as the best cylinder.")
    if options.plot:
        draw(designs, shapes, options.plot)


def draw(designs, shapes, path: str) -> None:
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for i, (name, (rod, q)) in enumerate(shapes.items()):
        places = np.linspace(0, rod.length, 200)
        frames = np.array([rod.pose(q, X) for X in places])
        stations = np.linspace(0, rod.length, len(designs[name]) - 1)
        thick = np.interp(places, stations, designs[name][1:])
        upper, lower = (
            frames[:, [0, 2], 3] + side * thick[:, None] * frames[:, [0, 2], 2] for side in (1, -1)
        )
        outline = 1e3 * np.concatenate([upper, lower[::-1]])
        axes.fill(*outline.T, color=f"C{i}", alpha=0.7, label=name)
    axes.set(xlabel="x [mm]", ylabel="z [mm]", aspect="equal")
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(path)


if __name__ == "__main__":
    main()
