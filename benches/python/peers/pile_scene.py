"""Rods dropped into a box: what every code simulates, and how motions are compared.

Needs nothing but NumPy: it is imported by scripts that run in an environment of their own. Where the rods
start comes from lissom's robot, in a file that the driver writes.
"""

import json
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

GRAVITY = 9.81
LENGTH, RADIUS = 0.3, 0.01
YOUNG_MODULUS, POISSON_RATIO, DENSITY, RETARDATION_TIME = 1e6, 0.45, 1000.0, 0.01
SHEAR_MODULUS = 0.5 * YOUNG_MODULUS / (1.0 + POISSON_RATIO)
AREA, SECOND_MOMENT = np.pi * RADIUS**2, 0.25 * np.pi * RADIUS**4
HALF_WIDTH = 0.2
# Places and inward normals of the walls; the first is the floor.
WALLS = (
    ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    ((HALF_WIDTH, 0.0, 0.0), (-1.0, 0.0, 0.0)),
    ((-HALF_WIDTH, 0.0, 0.0), (1.0, 0.0, 0.0)),
    ((0.0, HALF_WIDTH, 0.0), (0.0, -1.0, 0.0)),
    ((0.0, -HALF_WIDTH, 0.0), (0.0, 1.0, 0.0)),
)
# lissom's defaults: of a rod on a wall; two rods are two such springs in series.
STIFFNESS = 0.25 * np.pi * YOUNG_MODULUS / (1.0 - POISSON_RATIO**2)
DISSIPATION, FRICTION, SLIP_VELOCITY = 1.0, 0.3, 1e-4

# Motions are compared at these times, seconds, and settled piles at the last one.
TIMES = (0.08, 0.1, 0.12, 0.15)
SETTLED = 0.3
# A run is repeated so often if it is shorter than that, and the median counts.
REPEATS, SHORT = 3, 1.5


@dataclass(frozen=True)
class Pile:
    """Where the rods begin and where they point to, both of shape (rods, 3)."""

    starts: np.ndarray
    directions: np.ndarray

    @property
    def rods(self) -> int:
        return len(self.starts)


@dataclass(frozen=True)
class Motion:
    """Ends and middles at times, of shape (times, rods, 3, 3), and what it cost."""

    points: np.ndarray
    seconds: float


@dataclass(frozen=True)
class State:
    """Centre lines, of shape (rods, vertices, 3), and the kinetic energy in joules."""

    lines: np.ndarray
    kinetic: float


def write(piles: dict[int, Pile], file: Path) -> None:
    content = {
        number: {"starts": pile.starts.tolist(), "directions": pile.directions.tolist()}
        for number, pile in piles.items()
    }
    file.write_text(json.dumps(content))


def read(file: Path) -> dict[int, Pile]:
    content = json.loads(file.read_text())
    return {
        int(number): Pile(np.array(pile["starts"]), np.array(pile["directions"]))
        for number, pile in content.items()
    }


def repeated(run: Callable[[], Motion]) -> Motion:
    """The motion, with the median time of a few runs if they are short."""
    motions = [run()]
    while len(motions) < REPEATS and motions[0].seconds < SHORT:
        motions.append(run())
    return Motion(motions[0].points, statistics.median(each.seconds for each in motions))


class Clock:
    """Processor time of this process while it runs."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __enter__(self) -> None:
        self._start = time.process_time()

    def __exit__(self, *_: object) -> None:
        self.seconds += time.process_time() - self._start


def segment_distances(a: np.ndarray, u: np.ndarray, b: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Distances of the segments from a along u to those from b along v; arrays of shape (..., 3)."""

    def dot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return (x * y).sum(axis=-1)

    between = a - b
    uu, uv, vv, ud, vd = dot(u, u), dot(u, v), dot(v, v), dot(u, between), dot(v, between)
    # Where both are parallel the places along them do not matter; the clamped ones below are exact.
    determinant = np.maximum(uu * vv - uv**2, 1e-12 * uu * vv)
    s = np.clip((uv * vd - vv * ud) / determinant, 0.0, 1.0)
    t = np.clip((uv * s + vd) / vv, 0.0, 1.0)
    s = np.clip((uv * t - ud) / uu, 0.0, 1.0)
    return np.linalg.norm(between + s[..., None] * u - t[..., None] * v, axis=-1)


def largest_overlap(lines: np.ndarray) -> float:
    """Of the rods with walls and with each other, metres; negative if nothing touches."""
    deepest = max(RADIUS - float(((lines - point) @ np.array(normal)).min()) for point, normal in WALLS)
    low, high = lines.min(axis=1) - RADIUS, lines.max(axis=1) + RADIUS
    edges = np.diff(lines, axis=1)
    for i in range(len(lines)):
        for j in range(i):
            if (low[i] > high[j]).any() or (low[j] > high[i]).any():
                continue
            distances = segment_distances(
                lines[i, :-1, None], edges[i, :, None], lines[None, j, :-1], edges[None, j]
            )
            deepest = max(deepest, 2.0 * RADIUS - float(distances.min()))
    return deepest


def settled(state: State) -> dict[str, float]:
    """Quantities of the pile that do not depend on how each rod came to lie."""
    z = state.lines[..., 2]
    lengths = np.linalg.norm(np.diff(state.lines, axis=1), axis=-1)
    height = float((0.5 * (z[:, 1:] + z[:, :-1]) * lengths).sum() / lengths.sum())
    return {"height": height, "overlap": largest_overlap(state.lines), "kinetic": state.kinetic}


def record(code: str, rods: int, size: int, discretisation: str, step: float, motion: Motion) -> dict:
    """One run; `seconds` are those of the processor for 0.1 s of motion."""
    finite = np.isfinite(motion.points).all()
    return {
        "code": code,
        "rods": rods,
        "size": size,
        "discretisation": discretisation,
        "step": step,
        "seconds": motion.seconds * 0.1 / TIMES[-1],
        "points": motion.points.tolist() if finite else None,
    }
