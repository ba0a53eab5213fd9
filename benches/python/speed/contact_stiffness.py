"""What the stiffness of contacts costs and what it changes: docs/contact_law.md, "How stiff".

python benches/python/speed/contact_stiffness.py  # all scenes: default, 1e5 N/m^2, "material"
python benches/python/speed/contact_stiffness.py --young 2e11 --radius 5e-4 --limit 20
python benches/python/speed/contact_stiffness.py --grid  # statics over moduli and radii
python benches/python/speed/contact_stiffness.py --grid --motions

Each row: tangents of `statics`; Newton iterations of one second in steps of 5 ms; the deepest overlap over
the radius; how far the resting shape is from that of "material", over the length. Runs that take longer than
`--limit` seconds are cut off.

With `--grid`, one row for each modulus and radius: of all scenes of `GRID`, how many come to rest with
the default and with 1e5 N/m^2, their tangents (median and largest), and how far shapes are from those of
"material" at most. With `--motions`, Newton iterations of motions with the default stiffness, and how
they end.
"""

from __future__ import annotations

import argparse
import signal
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np

import lissom

NU, DENSITY, G = 0.4, 1500.0, 9.81
LAWS: dict[str, Any] = {"default": None, "1e5": 1e5, "material": "material"}


@dataclass
class Scene:
    """A rod seven times as long as the length over which it bends under its weight, and what it falls on."""

    young: float
    radius: float
    stiffness: Any
    links: list[lissom.Link] = field(default_factory=list)
    loops: list[lissom.Loop] = field(default_factory=list)
    obstacles: list[Any] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        weight = DENSITY * G * np.pi * self.radius**2
        self.bending = self.young * np.pi * self.radius**4 / 4
        self.length = 7 * (self.bending / weight) ** (1 / 3)

    def rod(
        self, name: str = "rod", number: int = 4, bend: int = 4, length: float | None = None, **place: Any
    ) -> None:
        """Adds a clamped rod."""
        length = length or self.length
        modes = {"torsion": 2, "bend_y": bend, "bend_z": bend}
        segment = lissom.Segment(
            length / number,
            radius=self.radius,
            young_modulus=self.young,
            poisson_ratio=NU,
            density=DENSITY,
            modes=modes,
            retardation_time=0.01,
        )
        self.links.append(lissom.Link(name, rod=[segment] * number, **place))

    def clamp(self, x: float) -> None:
        """Clamps the tip, too."""
        self.loops.append(lissom.Loop(("rod",), (None, None, (x, 0, 0)), lissom.Weld()))

    def robot(self, *, contacts: bool = True, **options: Any) -> lissom.Robot:
        """The robot, with or without its contacts."""
        law = {"friction": 0.3, "stiffness": self.stiffness}
        pairs = [lissom.Contact("rod", shape, name=f"o{i}", **law) for i, shape in enumerate(self.obstacles)]
        if len(self.links) > 1:
            pairs.append(lissom.Contact("rod", "other", **law))
        options = self.options | options
        return lissom.Robot(self.links, loops=self.loops, contacts=pairs if contacts else [], **options)


def block(x0: float, x1: float, top: float, thickness: float, width: float) -> lissom.Box:
    """A box from x0 to x1 with its upper face at a height."""
    return lissom.Box(((x0 + x1) / 2, 0, top - thickness / 2), ((x1 - x0) / 2, width, thickness / 2))


def edge(s: Scene, height: float = 0.1) -> None:
    """A cable over one edge."""
    s.rod()
    L = s.length
    s.obstacles = [block(0.25 * L, 3 * L, -height * L, 0.3 * L, 2 * L)]


def box(s: Scene) -> None:
    """A cable between two clamps over a box."""
    s.rod()
    L = s.length
    s.clamp(0.85 * L)
    s.obstacles = [block(0.35 * L, 0.65 * L, -0.15 * L, 0.15 * L, 0.25 * L)]


def boxes(s: Scene) -> None:
    """The same over two boxes of different heights."""
    s.rod()
    L = s.length
    s.clamp(0.85 * L)
    s.obstacles = [
        block(0.15 * L, 0.3 * L, -0.1 * L, 0.2 * L, L),
        block(0.5 * L, 0.65 * L, -0.15 * L, 0.2 * L, L),
    ]


def edges(s: Scene) -> None:
    """A line over three edges."""
    s.rod()
    L = s.length
    heights = ((0.15, 0.05), (0.4, 0.1), (0.65, 0.2))
    s.obstacles = [block(x * L, (x + 0.05) * L, -h * L, 0.2 * L, L) for x, h in heights]


def groove(s: Scene) -> None:
    """A hose in a V of two half-spaces."""
    L = s.length
    s.rod(position=(0, 0.05 * L, 0))
    s.obstacles = [lissom.HalfSpace((0, 0, -0.2 * L), (0, y, 1)) for y in (-1, 1)]


def plane(s: Scene) -> None:
    """A cable on a floor."""
    s.rod()
    s.obstacles = [lissom.HalfSpace((0, 0, -0.15 * s.length))]


def corner(s: Scene) -> None:
    """A finger that its load presses into a corner, without gravity."""
    s.length = L = 40 * s.radius
    s.rod(number=2, bend=3)
    force = 6 * s.bending / L**2
    s.options = {
        "gravity": (0, 0, 0),
        "loads": [lissom.Load(link="rod", force=(0, 0.6 * force, -force))],
    }
    s.obstacles = [lissom.HalfSpace((0, 0, -0.1 * L)), lissom.HalfSpace((0, 0.06 * L, 0), (0, -1, 0))]


def capsules(s: Scene) -> None:
    """A line over two bars, of 2 percent of its length."""
    s.rod()
    L = s.length
    for x, z in ((0.3, -0.08), (0.55, -0.12)):
        s.obstacles.append(lissom.Capsule((x * L, -L, z * L), (x * L, L, z * L), 0.02 * L))


def cylinder(s: Scene) -> None:
    """A line over a drum."""
    s.rod()
    L = s.length
    s.obstacles = [lissom.Capsule((0.4 * L, -L, -0.25 * L), (0.4 * L, L, -0.25 * L), 0.2 * L)]


def spheres(s: Scene) -> None:
    """A line over two balls beside it, from which it slides off."""
    s.rod()
    L = s.length
    for x, y, z in ((0.3, 0.005, -0.1), (0.6, -0.005, -0.15)):
        s.obstacles.append(lissom.Sphere((x * L, y * L, z * L), 0.04 * L))


def tube(s: Scene) -> None:
    """A catheter in a bent channel of rails."""
    s.rod()
    L, r = s.length, s.radius
    path = np.array([[-0.05, 0], [0.3, 0], [0.55, -0.12], [1.2, -0.2]]) * L
    for y, z in ((-2.2, -2.2), (2.2, -2.2), (-5, 0), (5, 0)):
        for (x0, z0), (x1, z1) in pairwise(path[1:]):
            ends = (x0, y * r, z0 + z * r), (x1, y * r, z1 + z * r)
            s.obstacles.append(lissom.Capsule(*ends, 2 * r))


def crossing(s: Scene) -> None:
    """A rod that falls across another one."""
    L = s.length
    a, c, d = np.sqrt(0.5), np.cos(0.1), np.sin(0.1)
    s.rod(length=L / 2, number=2)
    across = {"position": (0.1 * L, -L / 16, -0.02 * L), "orientation": (a * c, a * d, -a * d, a * c)}
    s.rod("other", length=L / 8, number=1, **across)


SCENES: dict[str, Callable[[Scene], None]] = {
    "edge": edge,
    "box": box,
    "boxes": boxes,
    "edges": edges,
    "groove": groove,
    "plane": plane,
    "corner": corner,
    "tube": tube,
    "crossing": crossing,
    "capsules": capsules,
    "cylinder": cylinder,
    "spheres": spheres,
} | {f"edge {i}": partial(edge, height=0.03 * i) for i in range(1, 11)}

#: Scenes, moduli (Pa) and radii (m) of `--grid`, and scenes and steps (s) of its motions.
GRID = [*(f"edge {i}" for i in range(1, 11)), "box", "boxes", "capsules", "cylinder", "spheres"]
MODULI = (1e5, 1e7, 1e9, 2e11)
RADII = (5e-4, 5e-3, 5e-2)
MOTIONS = ("edge", "box", "boxes", "plane")
STEPS = (5e-3, 1e-3)


def at_rest(robot: lissom.Robot, limit: float) -> tuple[lissom.StaticsResult, str]:
    """An equilibrium and its status, or the last shape if it takes too long."""

    def stop(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        found = lissom.statics(robot)
    except TimeoutError as error:
        # Without a result if nothing was searched yet.
        found = getattr(error, "result", None) or lissom.statics(robot, max_iter=1)
        return found, "too slow"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    return found, found.status


def made(name: str, law: str, young: float, radius: float) -> Scene:
    """A scene with a law."""
    scene = Scene(young, radius, LAWS[law])
    SCENES[name](scene)
    return scene


def resting(scene: Scene, limit: float) -> dict[str, Any]:
    """Figures of a scene at rest."""
    robot = scene.robot()
    row: dict[str, Any] = {"k": max(robot._contact_stiffness())}
    found, row["rest"] = at_rest(robot, limit)
    row["tangents"] = found.njev
    row["q"], row["rest_overlap"] = found.q, found.deepest.share if found.deepest else 0.0
    places = np.linspace(0, sum(part.length for part in robot.links[0].rod), 101)
    row["shape"] = robot.pose(found.q, places, link="rod")[:, :3, 3]
    row["length"] = places[-1]
    return row


def moving(scene: Scene, limit: float, dt: float = 5e-3) -> dict[str, Any]:
    """Figures of one second of its motion."""
    robot = scene.robot()
    free = scene.robot(contacts=False, gravity=(0, G, 0))
    q0 = lissom.statics(free, np.zeros(free.n)).q if scene.loops else np.zeros(free.n)
    if robot.touches(q0, 0 * q0):
        # A short rod begins within the other one.
        return {"motion": "not begun", "newton": 0, "reached": 0.0, "moving_overlap": 0.0}
    begin = time.perf_counter()
    motion = lissom.simulate(robot, 1.0, q0=q0, dt=dt, progress=lambda _: time.perf_counter() - begin > limit)
    return {
        "motion": motion.status,
        "newton": motion.stats.newton_iterations,
        "reached": float(motion.t[-1]),
        "moving_overlap": motion.deepest.share if motion.deepest else 0.0,
    }


def grid(limit: float) -> None:
    """Prints the table of statics over moduli and radii."""
    titles = (
        "E, Pa",
        "radius, m",
        "r/L",
        "default: at rest",
        "tangents",
        "1e5: at rest",
        "tangents",
        "shape/L",
    )
    print(f"| {' | '.join(titles)} |")
    print(f"|{'---|' * len(titles)}")
    for young, radius in product(MODULI, RADII):
        rows = {law: [resting(made(name, law, young, radius), limit) for name in GRID] for law in LAWS}
        cells = [f"{young:.0e}", f"{radius:g}", f"{radius / Scene(young, radius, None).length:.0e}"]
        for law in ("default", "1e5"):
            tangents = [row["tangents"] for row in rows[law]]
            resting_ones = sum(row["rest"] == "converged" for row in rows[law])
            cells += [f"{resting_ones} of {len(GRID)}", f"{np.median(tangents):.0f}, {max(tangents)}"]
        off = [
            np.abs(soft["shape"] - stiff["shape"]).max() / soft["length"]
            for soft, stiff in zip(rows["default"], rows["material"], strict=True)
            if soft["rest"] == stiff["rest"] == "converged"
        ]
        cells.append(f"{max(off):.0e} ({len(off)})")
        print(f"| {' | '.join(cells)} |", flush=True)


def motions(limit: float) -> None:
    """Prints the table of motions over moduli and radii."""
    titles = ("E, Pa", "radius, m", "dt, ms", *MOTIONS)
    print(f"| {' | '.join(titles)} |")
    print(f"|{'---|' * len(titles)}")
    for young, radius, dt in product(MODULI, RADII, STEPS):
        cells = [f"{young:.0e}", f"{radius:g}", f"{1e3 * dt:g}"]
        for name in MOTIONS:
            row = moving(made(name, "default", young, radius), limit, dt)
            end = "" if row["motion"] == "finished" else f" {row['motion']} at {row['reached']:.2f} s"
            cells.append(f"{row['newton']}{end}")
        print(f"| {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, value in (("young", 5e7), ("radius", 5e-3), ("limit", 10.0)):
        parser.add_argument(f"--{name}", type=float, default=value)
    parser.add_argument("--only", nargs="*", default=[name for name in SCENES if " " not in name])
    parser.add_argument("--grid", action="store_true")
    parser.add_argument("--motions", action="store_true")
    chosen = parser.parse_args()
    warnings.simplefilter("ignore")
    if chosen.grid:
        (motions if chosen.motions else grid)(chosen.limit)
        return
    titles = ("scene", "stiffness", "N/m²", "statics", "tangents", "overlap/r", "shape/L")
    titles += ("motion", "iterations", "overlap/r")
    print(f"| {' | '.join(titles)} |")
    print(f"|{'---|' * len(titles)}")
    for name in chosen.only:
        scenes = {law: made(name, law, chosen.young, chosen.radius) for law in LAWS}
        rows = {law: resting(s, chosen.limit) | moving(s, chosen.limit) for law, s in scenes.items()}
        for law, row in rows.items():
            off = np.abs(row["shape"] - rows["material"]["shape"]).max() / row["length"]
            is_whole = row["motion"] == "finished"
            motion = row["motion"] if is_whole else f"{row['motion']} at {row['reached']:.2f}"
            stiffness = f"{row['k']:.1e}"
            at_end = (row["rest"], str(row["tangents"]), f"{row['rest_overlap']:.1e}", f"{off:.0e}")
            in_motion = (motion, str(row["newton"]), f"{row['moving_overlap']:.1e}")
            print(f"| {' | '.join((name, law, stiffness, *at_end, *in_motion))} |", flush=True)


if __name__ == "__main__":
    main()
