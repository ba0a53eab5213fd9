"""What contact costs: docs/run_times.md, "Contact".

python benches/python/speed/contact.py                 # one rod
python benches/python/speed/contact.py --pile 5 10 50  # rods dropped into a box
python benches/python/speed/contact.py --itself        # a rod of 64 segments that may touch itself
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from statistics import median

import numpy as np

import lissom

sys.path.insert(0, str(Path(__file__).parents[1]))
import machine

ROUNDS = 15
ALL = {"torsion": 3, "bend_y": 3, "bend_z": 3, "stretch": 3, "shear_y": 3, "shear_z": 3}

#: A rod of the pile, and the box: four walls and a floor.
RADIUS, LENGTH = 0.01, 0.3
PILED = {"torsion": 1, "bend_y": 3, "bend_z": 3}
HALF_WIDTH = 0.2
WALLS = {
    "floor": lissom.HalfSpace(),
    "right": lissom.HalfSpace((HALF_WIDTH, 0, 0), (-1, 0, 0)),
    "left": lissom.HalfSpace((-HALF_WIDTH, 0, 0), (1, 0, 0)),
    "back": lissom.HalfSpace((0, HALF_WIDTH, 0), (0, -1, 0)),
    "front": lissom.HalfSpace((0, -HALF_WIDTH, 0), (0, 1, 0)),
}


def lying(height: float, contacts: list[lissom.Contact]) -> lissom.Robot:
    """A clamped rod of 36 coordinates, as high above the ground as told."""
    segments = [lissom.Segment(0.15, 0.01, 1e6, 4e5, 1000.0, ALL, retardation_time=0.01)] * 2
    return lissom.Robot([lissom.Link("rod", rod=segments, position=(0, 0, height))], contacts=contacts)


def single() -> dict[str, tuple[lissom.Robot, float]]:
    """Robots by what touches them, and for how long they move before they are timed."""
    floor = lissom.HalfSpace()
    peg = lissom.Capsule((0.15, -0.1, -0.02), (0.15, 0.1, -0.02), 0.01)
    ball = lissom.Ball("rod", 0.012)
    return {
        "none": (lying(0.0, []), 0.0),
        "with a floor that is far away": (lying(1.0, [lissom.Contact("rod", floor)]), 0.0),
        "a ball at the tip on the floor": (lying(0.02, [lissom.Contact(ball, floor, stiffness=1e4)]), 0.3),
        "the rod with itself": (lying(0.0, [lissom.Contact("rod", "rod")]), 0.0),
        "the rod over a peg": (lying(0.0, [lissom.Contact("rod", peg, friction=0.3)]), 0.3),
        "the whole rod on the floor": (lying(0.0099, [lissom.Contact("rod", floor, friction=0.3)]), 0.1),
    }


def one_rod(dt: float = 1e-4, steps: int = 400) -> None:
    print("| contact | touches | step, µs | relative | iterations a step | Jacobians a step |")
    print("|---|---|---|---|---|---|")
    cases = single()
    starts = {}
    for name, (robot, settled) in cases.items():
        moved = lissom.simulate(robot, settled, dt=1e-3) if settled else None
        starts[name] = {} if moved is None else {"q0": moved.q[-1], "v0": moved.v[-1]}
    times: dict[str, list[float]] = {name: [] for name in cases}
    runs = {}
    for _ in range(ROUNDS):
        for name, (robot, _) in cases.items():
            before = time.thread_time()
            runs[name] = lissom.simulate(
                robot, dt * steps, dt=dt, method="generalised_alpha", rho_inf=0.8, **starts[name]
            )
            times[name].append(time.thread_time() - before)
            assert runs[name].success, runs[name].message
    for name, (robot, _) in cases.items():
        end = runs[name]
        touches = len(robot.touches(end.q[-1], end.v[-1])) if name != "none" else 0
        each = 1e6 * median(times[name]) / steps
        counts = [getattr(end.stats, what) / steps for what in ("newton_iterations", "njev")]
        relative = median(times[name]) / median(times["none"])
        print(f"| {name} | {touches} | {each:.1f} | {relative:.2f} | {counts[0]:.2f} | {counts[1]:.2f} |")


def itself(dt: float = 1e-3, steps: int = 100, rounds: int = 15) -> None:
    """What the search for self-contact costs in a step of a chain, where nothing touches."""
    segment = lissom.Segment(
        1 / 64, 0.005, 1e6, 4e5, 1100, modes={"bend_y": 1, "bend_z": 1}, retardation_time=0.01
    )
    segments = [segment] * 64
    # A chain is solved as one; contact, as a cable, may couple all of its coordinates. The cable is slack.
    cable = lissom.Tendon("cable", [lissom.Along(offset=(0, 0.003))], length=1.5, stiffness=10.0)
    rods = {
        "none": lissom.Rod(segments),
        "a slack cable": lissom.Rod(segments, actuators=[cable]),
        "the rod with itself": lissom.Rod(segments, contacts=[lissom.Contact("rod", "rod")]),
    }
    times: dict[str, list[float]] = {name: [] for name in rods}
    for _ in range(rounds):
        for name, rod in rods.items():
            before = time.perf_counter()
            run = lissom.simulate(rod, dt * steps, dt=dt, method="generalised_alpha")
            times[name].append(time.perf_counter() - before)
            assert run.success, run.message
    print("| what may act | step, µs | relative to a slack cable |")
    print("|---|---|---|")
    for name, taken in times.items():
        relative = median(a / b for a, b in zip(taken, times["a slack cable"], strict=True))
        print(f"| {name} | {1e6 * median(taken) / steps:.0f} | {relative:.2f} |")


def pile(number: int, friction: float = 0.3, modes: dict[str, int] | None = None) -> lissom.Robot:
    """Rods over a box, in layers of five that lie across each other; every pair can touch."""
    segment = lissom.Segment(
        LENGTH, RADIUS, 1e6, poisson_ratio=0.45, density=1000, modes=modes or PILED, retardation_time=0.01
    )
    random = np.random.default_rng(1)
    links = []
    for i in range(number):
        layer, across = divmod(i, 5)
        turn = 0.5 * np.pi * (layer % 2) + random.uniform(-0.2, 0.2)
        middle = np.array([0.0, 0.0, 0.03 + 0.04 * layer])
        middle[1 - layer % 2] = 0.07 * (across - 2)
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        links.append(
            lissom.Link(
                f"rod {i}",
                joint=lissom.Free(),
                rod=[segment],
                position=middle - 0.5 * LENGTH * along,
                orientation=(np.cos(0.5 * turn), 0, 0, np.sin(0.5 * turn)),
            )
        )
    names = [link.name for link in links]
    pairs = [
        lissom.Contact(name, wall, friction=friction, name=f"{name} on {side}")
        for name in names
        for side, wall in WALLS.items()
    ]
    pairs += [lissom.Contact(a, b, friction=friction) for i, a in enumerate(names) for b in names[:i]]
    return lissom.Robot(links, contacts=pairs)


def piles(numbers: list[int], dt: float, t_end: float) -> None:
    """Times are those of the processor: a run of minutes is not the only one on a shared machine."""
    print(
        "| rods | coordinates | pairs | status | steps | touches at the end | whole run, s "
        "| in free fall, ms a step | whole run, ms a step | iterations a step | Jacobians a step |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for number in numbers:
        robot = pile(number)
        before = time.thread_time()
        fall = lissom.simulate(robot, 0.02, dt=dt)
        falling = (time.thread_time() - before) / 0.02 * dt
        before = time.thread_time()
        run = lissom.simulate(robot, t_end, dt=dt)
        taken = time.thread_time() - before
        steps = run.stats.steps
        touches = len(robot.touches(run.q[-1], run.v[-1]))
        each = taken / (run.t[-1] / dt)
        assert fall.success, fall.message
        print(
            f"| {number} | {robot.n} | {len(robot.contacts)} | {run.status} at {run.t[-1]:.3f} s | {steps} "
            f"| {touches} | {taken:.1f} | {1e3 * falling:.1f} | {1e3 * each:.1f} "
            f"| {run.stats.newton_iterations / steps:.2f} | {run.stats.njev / steps:.2f} |",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--pile", type=int, nargs="+", metavar="RODS", help="drop that many rods into a box instead"
    )
    parser.add_argument("--itself", action="store_true", help="move a rod of 64 segments instead")
    parser.add_argument("--dt", type=float, default=1e-3, help="steps of the pile, seconds")
    parser.add_argument("--time", type=float, default=0.3, help="how long the rods fall, seconds")
    arguments = parser.parse_args()
    print(machine.description(), end="\n\n")
    if arguments.pile:
        piles(arguments.pile, arguments.dt, arguments.time)
    elif arguments.itself:
        itself()
    else:
        one_rod()


if __name__ == "__main__":
    main()
