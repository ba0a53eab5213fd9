"""lissom in the benchmark `cosseratbench` (Apache-2.0): ``cosseratbench run --solver lissom``.

Needs the extra `cosseratbench`: ``pip install 'lissom[cosseratbench]'``. All experiments have the same
settings, the defaults of lissom where there are any; ``docs/peers.md`` has the results. What a scenario asks
for and lissom cannot express is a ``NotImplementedError``, which the benchmark reports as unsupported.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..._lissom import (
    BaseMotion,
    Capsule,
    Contact,
    Fluid,
    Free,
    HalfSpace,
    Link,
    Load,
    Loop,
    LoopEnd,
    MotionResult,
    Prismatic,
    Robot,
    Segment,
    Spherical,
    Weld,
    __version__,
    simulate,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cosseratbench.scenario import Motion, Obstacle, Rod, Scenario
    from cosseratbench.trajectory import Trajectory

Array = NDArray[np.float64]

#: Elements of the benchmark for one segment.
ELEMENTS_OF_A_SEGMENT = 10

#: Modes of a segment.
MODES = {"torsion": 2, "bend_y": 4, "bend_z": 4, "stretch": 2}

#: Longest time step, seconds.
LONGEST_STEP = 2e-3

#: Velocity below which friction creeps, m/s: what should stick is to move by micrometres.
SLIP_VELOCITY = 1e-6

#: Density of the fluid whose viscous drag damps runs to an equilibrium, relative to that of the rods.
OF_NO_FLUID = 1e-9

#: Rotation vectors are about one axis if they deviate from it by less than this, radians.
ONE_AXIS = 1e-9


@dataclass(frozen=True)
class Laid:
    """A rod of the benchmark laid along its centreline: a link with the coordinates of its start."""

    link: Link
    q: Array
    #: Pose of the tip.
    tip: Array


class LissomSolver:
    """What the entry point of the benchmark names.

    Parameters
    ----------
    time_step_scale : float
        Factor of the time step.
    max_seconds : float, optional
        Limit of the wall-clock time of a run, seconds; by default none. A run that takes longer counts as
        diverged.
    """

    name = "lissom"
    backend_version = __version__

    def __init__(self, time_step_scale: float = 1.0, max_seconds: float | None = None) -> None:
        self.time_step_scale = time_step_scale
        self.max_seconds = max_seconds

    @property
    def capabilities(self) -> frozenset[Any]:
        """What rods of these modes do: all but shear."""
        from cosseratbench.solver import Capability

        return frozenset(Capability) - {Capability.SHEAR}

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """The numerical choices for a scenario."""
        return {
            "integrator": "Newmark's method: average acceleration, generalised alpha with loops or contacts",
            "time_step": self._step(scenario, n_frames),
            "segments": segments_of(n_elements),
            "modes": MODES,
            "damping_rate": damping_rate(scenario),
            "slip_velocity": SLIP_VELOCITY,
        }

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """Simulate a scenario."""
        from cosseratbench.solver import Diverged
        from cosseratbench.trajectory import Trajectory

        robot, q0 = robot_of(scenario, segments_of(n_elements))
        times = np.linspace(0.0, scenario.duration, n_frames)
        result = simulate(
            robot,
            scenario.duration,
            q0=q0,
            dt=self._step(scenario, n_frames),
            t_eval=times,
            max_seconds=self.max_seconds,
        )
        if not result.success:
            raise Diverged(result.message, time=float(result.t[-1]) if len(result.t) else 0.0)
        seen = [
            seen_of(robot, result, name_of(i), rod.length, n_elements) for i, rod in enumerate(scenario.rods)
        ]
        return Trajectory(times, tuple(nodes for nodes, _ in seen), tuple(across for _, across in seen))

    def _step(self, scenario: Scenario, n_frames: int) -> float:
        """A part of the interval of the frames."""
        frame = scenario.duration / (n_frames - 1)
        return float(frame / math.ceil(frame / (LONGEST_STEP * self.time_step_scale)))


def segments_of(n_elements: int) -> int:
    """Number of segments for a number of elements."""
    return max(1, round(n_elements / ELEMENTS_OF_A_SEGMENT))


def damping_rate(scenario: Scenario) -> float:
    """Rate of damping in proportion to mass, 1/s: critical for the slowest mode, as in other solvers."""
    return 2.0 * scenario.slowest_frequency() if scenario.quasi_static else 0.0


def name_of(i: int) -> str:
    """The link of a rod."""
    return f"rod{i}"


def robot_of(scenario: Scenario, segments: int) -> tuple[Robot, Array]:
    """The robot of a scenario and the coordinates of its start."""
    links: list[Link] = []
    loops: list[Loop] = []
    loads: list[Load] = []
    laid = [lay(rod, name_of(i), segments) for i, rod in enumerate(scenario.rods)]
    for i, (rod, one) in enumerate(zip(scenario.rods, laid, strict=True)):
        holder, loop = held_end(rod, one, f"end{i}")
        links += [one.link] if holder is None else [holder, one.link]
        loops += [] if loop is None else [loop]
        for load in rod.loads:
            at = 0.0 if load.at.value == "start" else rod.length
            loads.append(Load(force=load.force, link=one.link.name, at=at))
    robot = Robot(
        links,
        gravity=scenario.gravity,
        loads=loads,
        loops=loops,
        contacts=contacts_of(scenario),
        fluid=damping_of(scenario),
    )
    q0 = np.zeros(robot.n)
    for one in laid:
        q0[robot.slice(one.link.name)] = one.q
    return robot, q0


def lay(rod: Rod, name: str, segments: int) -> Laid:
    """The link of a rod, laid along its centreline without twist."""
    points = np.asarray(rod.centerline, dtype=float)
    if rod.rest_arc_length is None:
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        arcs = np.concatenate([[0.0], np.cumsum(chords)])
    else:
        arcs = np.asarray(rod.rest_arc_length, dtype=float)
    # The last sum may exceed the length by rounding.
    arcs = np.minimum(arcs, rod.length)
    axes = base_axes(points, np.asarray(rod.normal, dtype=float))
    material = rod.material
    segment = Segment(
        rod.length / segments,
        rod.radius,
        material.youngs_modulus,
        material.shear_modulus,
        material.density,
        MODES,
    )
    link = Link(
        name,
        joint=base_joint(rod),
        rod=[segment] * segments,
        position=points[0],
        orientation=quaternion_of(axes),
    )
    alone = Robot([link])
    start = alone.coordinates_of((points - points[0]) @ axes, X=arcs)
    return Laid(link, start.q, alone.pose(start.q, t=0.0))


def base_axes(points: Array, normal: Array) -> Array:
    """The axes of the first section as columns: along the rod, along the normal, across both."""
    along = points[1] - points[0]
    along = along / np.linalg.norm(along)
    across = normal - (normal @ along) * along
    across = across / np.linalg.norm(across)
    return np.column_stack([along, across, np.cross(along, across)])


def quaternion_of(axes: Array) -> Array:
    """The quaternion (w, x, y, z) of axes given as columns (Shepperd 1978)."""
    r = axes
    four = np.array(
        [
            1.0 + r[0, 0] + r[1, 1] + r[2, 2],
            1.0 + r[0, 0] - r[1, 1] - r[2, 2],
            1.0 - r[0, 0] + r[1, 1] - r[2, 2],
            1.0 - r[0, 0] - r[1, 1] + r[2, 2],
        ]
    )
    largest = int(np.argmax(four))
    products = [
        [four[0], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
        [r[2, 1] - r[1, 2], four[1], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
        [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], four[2], r[1, 2] + r[2, 1]],
        [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], four[3]],
    ]
    quaternion = np.array(products[largest])
    return np.asarray(quaternion / np.linalg.norm(quaternion))


def base_joint(rod: Rod) -> Weld | Spherical | Free:
    """The joint of the start of a rod."""
    if rod.start.value == "pinned":
        return Spherical()
    if rod.start.value == "free":
        return Free()
    motion = rod.start_motion
    if motion is None:
        return Weld()
    if motion.slides_along is not None:
        raise NotImplementedError("a start that slides along an axis")
    points = np.asarray(rod.centerline, dtype=float)
    axes = base_axes(points, np.asarray(rod.normal, dtype=float))
    return Free(motion=motion_of(motion, axes))


def motion_of(motion: Motion, axes: Array) -> BaseMotion:
    """The motion of a clamp whose frame has these axes, in which the motion of its joint is described."""
    times = np.asarray(motion.times, dtype=float)
    moved = np.asarray(motion.displacement, dtype=float) @ axes
    turned = np.asarray(motion.rotation, dtype=float) @ axes
    given: dict[str, Any] = {}
    if moved.any():
        given["translation"] = (times, moved, "linear")
    if turned.any():
        axis = turned[np.argmax(np.linalg.norm(turned, axis=1))]
        axis = axis / np.linalg.norm(axis)
        angles = turned @ axis
        if np.abs(turned - np.outer(angles, axis)).max() > ONE_AXIS:
            raise NotImplementedError("an end that turns about several axes")
        given |= {"axis": axis, "angle": (times, angles, "linear")}
    return BaseMotion(**given)


def held_end(rod: Rod, laid: Laid, name: str) -> tuple[Link | None, Loop | None]:
    """What holds the end of a rod: a link that moves as prescribed, if it is driven, and a loop."""
    if rod.end.value == "free":
        return None, None
    tip = LoopEnd(laid.link.name, rod.length)
    place, axes = laid.tip[:3, 3], laid.tip[:3, :3]
    if rod.end.value == "pinned":
        point = np.asarray(rod.centerline[-1], dtype=float)
        return None, Loop(tip, LoopEnd(position=point), Spherical(), name=name)
    orientation = quaternion_of(axes)
    motion = rod.end_motion
    if motion is None:
        return None, Loop(tip, LoopEnd(position=place, orientation=orientation), Weld(), name=name)
    holder = Link(name, joint=Free(motion=motion_of(motion, axes)), position=place, orientation=orientation)
    kind = Weld() if motion.slides_along is None else Prismatic(motion.axis @ axes)
    return holder, Loop(tip, LoopEnd(name), kind, name=f"{name} held")


def contacts_of(scenario: Scenario) -> list[Contact]:
    """All pairs that can touch."""
    rods = scenario.rods
    contacts = [
        Contact(
            name_of(i),
            shape_of(obstacle),
            friction=max(rod.friction, obstacle.friction),
            slip_velocity=SLIP_VELOCITY,
            name=f"{name_of(i)} on obstacle {k}",
        )
        for i, rod in enumerate(rods)
        for k, obstacle in enumerate(scenario.obstacles)
    ]
    pairs = [(i, j) for i in range(len(rods)) for j in range(i, len(rods)) if i < j or scenario.self_contact]
    return contacts + [
        Contact(
            name_of(i),
            name_of(j),
            friction=max(rods[i].friction, rods[j].friction),
            slip_velocity=SLIP_VELOCITY,
            name=f"{name_of(i)} on {name_of(j)}",
        )
        for i, j in pairs
    ]


def shape_of(obstacle: Obstacle) -> Capsule | HalfSpace:
    """The shape of an obstacle. The ends of cylinders are round: nothing touches them in the experiments."""
    if obstacle.kind == "plane":
        return HalfSpace(obstacle.point, obstacle.unit_normal)
    half = obstacle.unit_axis * obstacle.length / 2.0
    centre = np.asarray(obstacle.center, dtype=float)
    return Capsule(centre - half, centre + half, obstacle.radius)


def damping_of(scenario: Scenario) -> Fluid | None:
    """Damping in proportion to mass: the viscous drag of a fluid without weight."""
    rate = damping_rate(scenario)
    if rate == 0.0:
        return None
    masses = {rod.material.density * rod.area for rod in scenario.rods}
    if len(masses) > 1:
        raise NotImplementedError("damping in proportion to mass of rods with different masses per length")
    drag = rate * masses.pop()
    density = OF_NO_FLUID * scenario.rods[0].material.density
    return Fluid(density, viscous_drag=(drag, drag), buoyancy=False, added_mass_coefficient=0.0)


def seen_of(
    robot: Robot, result: MotionResult, link: str, length: float, n_elements: int
) -> tuple[Array, Array]:
    """Nodes of a rod at the times of a result, and a material direction of each element, across it."""
    places = np.linspace(0.0, length, n_elements + 1)
    nodes = robot.pose(result.q, places, link=link, t=result.t)[..., :3, 3]
    middles = robot.pose(result.q, (places[1:] + places[:-1]) / 2.0, link=link, t=result.t)
    along = np.diff(nodes, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    across = middles[..., :3, 1]
    across = across - (across * along).sum(axis=2, keepdims=True) * along
    return nodes, across / np.linalg.norm(across, axis=2, keepdims=True)


__all__: Sequence[str] = ["LissomSolver"]
