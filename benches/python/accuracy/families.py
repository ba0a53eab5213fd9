"""Random robots of thirteen families in motion, for `cost.py` and `independent.py`."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import lissom

# Number of compared times.
TIMES = 100
# Radau's method of lissom, with tolerances far below every request.
REFERENCE = {"method": "radau", "rtol": 1e-9, "atol": 1e-11}


@dataclass(frozen=True)
class Case:
    """A robot in motion; the reference may be of another description of the same robot."""

    make: Callable[[], lissom.Robot]
    duration: float
    q0: np.ndarray | None = None
    v0: np.ndarray | None = None
    exact: Callable[[], lissom.Robot] | None = None
    # Times at which loads jump.
    jumps: tuple[float, ...] = ()

    @property
    def times(self):
        return np.linspace(0.0, self.duration, TIMES + 1)

    def run(self, model=None, **options):
        model = model or self.make()
        return lissom.simulate(
            model, self.duration, q0=self.q0, v0=self.v0, t_eval=self.times, max_steps=200_000, **options
        )

    def truth(self):
        return self.run((self.exact or self.make)(), **REFERENCE)


def places(model, motion):
    """Tips of rods, and four points of every body, relative to the length, shape (times, places, 3)."""
    found = []
    for link in model.links:
        pose = model.pose(motion.q, link=link.name, t=motion.t)
        if link.body is None:
            found.append(pose[:, :3, 3])
            continue
        inertia = np.asarray(link.body.inertia)
        radius = np.sqrt(0.5 * np.trace(inertia) / link.body.mass)
        for offset in np.vstack([np.zeros(3), radius * np.eye(3)]):
            found.append(pose[:, :3, :3] @ (np.asarray(link.body.centre) + offset) + pose[:, :3, 3])
    return np.stack(found, axis=1) / reach(model)


def reach(robot):
    """The length that requests are relative to: of links stretched out, or of a ball that reaches nowhere."""
    ends = {None: 0.0}
    for link in robot.links:
        size = sum(segment.length for segment in link.rod or ())
        if link.body is not None:
            size = max(size, np.linalg.norm(link.body.centre))
        ends[link.name] = ends[link.parent] + np.linalg.norm(link.position) + size
    return max(ends.values()) or robot.contacts[0].a.radius


def error(model, motion, right):
    return float(np.linalg.norm(places(model, motion) - right, axis=2).max())


def soft(rng, modes, segments=1, **options):
    """Segments of one slender rod, of a few periods a second."""
    length = 10 ** rng.uniform(-1.0, 0.0)
    radius = length * 10 ** rng.uniform(-2.0, -1.3)
    density = 1100.0
    sag = 10 ** rng.uniform(-2.5, -0.7)
    young = 9.81 * density * length**3 / (2.0 * sag * radius**2)
    rate = 3.516 * radius / 2.0 * np.sqrt(young / density) / length**2
    damping = 2.0 * 10 ** rng.uniform(-2.0, -0.5) / rate
    segment = lissom.Segment(
        length / segments, radius, young, young / 3.0, density, modes, retardation_time=damping, **options
    )
    return [segment] * segments, 2.0 * np.pi / rate, 3.0 * young * np.pi * radius**4 / 4.0 / length**2


def rod(segments, **options):
    return lissom.Robot([lissom.Link("rod", rod=segments)], **options)


def planar(rng):
    """A rod of one to three segments released under its weight."""
    modes = {"bend_y": int(rng.integers(2, 4))} | ({"stretch": 1} if rng.random() < 0.5 else {})
    segments, period, _ = soft(rng, modes, int(rng.integers(1, 4)))
    return Case(lambda: rod(segments), rng.uniform(2.0, 10.0) * period)


def spatial(rng):
    """The same in space, with a force at the tip."""
    segments, period, strength = soft(rng, {"torsion": 1, "bend_y": 2, "bend_z": 2}, int(rng.integers(1, 4)))
    force = strength * 10 ** rng.uniform(-1.5, -0.5) * np.array([0.0, 1.0, 0.0])
    return Case(
        lambda: rod(segments, loads=[lissom.Load(force=force, link="rod")]), rng.uniform(1.0, 6.0) * period
    )


def falling(rng):
    """A free rod that is thrown."""
    segments, period, _ = soft(rng, {"torsion": 1, "bend_y": 2, "bend_z": 2}, int(rng.integers(1, 3)))
    link = lissom.Link("rod", joint=lissom.Free(), rod=segments)
    robot = lissom.Robot([link])
    v0 = np.zeros(robot.n)
    v0[3:6] = rng.uniform(-2.0, 2.0, 3) / period
    return Case(lambda: lissom.Robot([link]), rng.uniform(0.5, 3.0) * period, v0=v0)


def chain_links(rng, number, **joint):
    """Rigid links on hinges; planar or not."""
    links = []
    for i in range(number):
        axis = (0, 1, 0) if i == 0 or rng.random() < 0.5 else (0, 0, 1)
        body = lissom.Body(1.0, centre=(0.15, 0, 0), inertia=np.diag([1e-3, 8e-3, 8e-3]))
        hinge = lissom.Revolute(axis, **joint)
        links.append(
            lissom.Link(
                f"link{i}",
                parent=f"link{i - 1}" if i else None,
                position=(0.3 if i else 0.0, 0, 0),
                joint=hinge,
                body=body,
            )
        )
    return links


def chain(rng):
    links = chain_links(rng, int(rng.integers(2, 5)), damping=0.05, stiffness=float(rng.choice([0.0, 3.0])))
    q0 = rng.uniform(-0.5, 0.5, len(links))
    return Case(lambda: lissom.Robot(links), rng.uniform(1.0, 5.0), q0=q0)


def tendons(rng):
    """A rod in space with three tendons under tensions that vary."""
    segments, period, strength = soft(rng, {"bend_y": 3, "bend_z": 3}, int(rng.integers(1, 3)))
    radius = segments[0].radius[0]
    length = sum(segment.length for segment in segments)
    pull = strength * length / radius * 10 ** rng.uniform(-2.0, -1.0)
    rate = rng.uniform(0.2, 1.0) / period
    actuators = []
    for k in range(3):
        offset = 0.7 * radius * np.array([np.cos(2 * np.pi * k / 3), np.sin(2 * np.pi * k / 3)])
        size = pull * rng.uniform(0.0, 1.0)
        tension = lissom.Harmonic(0.5 * size, rate, mean=0.5 * size) if k == 0 else size
        actuators.append(lissom.Tendon(f"t{k}", [lissom.Along("rod", tuple(offset))], tension=tension))
    return Case(lambda: rod(segments, actuators=actuators), rng.uniform(1.0, 6.0) * period)


def step(rng):
    """A load that jumps once or twice, as a function of time."""
    segments, period, strength = soft(rng, {"bend_y": int(rng.integers(2, 4))})
    duration = rng.uniform(2.0, 8.0) * period
    first = duration * rng.uniform(0.1, 0.6)
    second = duration * rng.uniform(0.6, 0.9) if rng.random() < 0.4 else 2.0 * duration
    force = strength * 10 ** rng.uniform(-1.5, -0.5) * np.array([0.0, 0.0, 1.0])

    def jumps(t):
        return force if first <= t < second else np.zeros(3)

    edges = [first, np.nextafter(first, 1e9), second, np.nextafter(second, 1e9)]
    table = (edges, np.outer([0.0, 1.0, 1.0, 0.0], force))
    make = [
        lambda load=load: rod(segments, loads=[lissom.Load(force=load, link="rod")])
        for load in (jumps, table)
    ]
    return Case(make[0], duration, exact=make[1], jumps=(first, second))


def landing(rng):
    """A ball that falls on a floor and rolls."""
    radius = 10 ** rng.uniform(-1.5, -0.7)
    mass = 10 ** rng.uniform(-1.0, 0.5)
    height = radius * rng.uniform(1.5, 6.0)
    body = lissom.Body(mass, inertia=0.4 * mass * radius**2 * np.eye(3))
    link = lissom.Link("ball", joint=lissom.Free(), body=body)
    floor = lissom.Contact(
        lissom.Ball("ball", radius),
        lissom.HalfSpace(),
        stiffness=mass * 9.81 / (0.02 * radius) ** 1.0 * 10 ** rng.uniform(0.0, 2.0),
        dissipation=rng.uniform(0.1, 1.0),
        friction=float(rng.choice([0.0, 0.3])),
        slip_velocity=1e-3,
    )
    q0 = np.array([0.0, 0.0, height, 0.0, 0.0, 0.0])
    v0 = np.array([rng.uniform(-1.0, 1.0), 0.0, 0.0, 0.0, 0.0, 0.0])
    fall = np.sqrt(2.0 * (height - radius) / 9.81)
    robot = lambda: lissom.Robot([link], contacts=[floor])  # noqa: E731
    return Case(robot, rng.uniform(1.5, 6.0) * fall, q0=q0, v0=v0)


def rubbing(rng):
    """Dry friction in the hinges of a chain that comes to rest."""
    links = chain_links(
        rng, int(rng.integers(1, 4)), friction=10 ** rng.uniform(-1.0, 0.3), friction_velocity=1e-3
    )
    q0 = rng.uniform(0.0, 1.2, len(links))
    return Case(lambda: lissom.Robot(links), rng.uniform(0.5, 1.5), q0=q0)


def loop(rng):
    """A hanging four-bar linkage whose bars bend, damped."""
    radius = 10 ** rng.uniform(-2.3, -1.8)
    young = 10 ** rng.uniform(6.5, 8.0)
    hinge = lissom.Revolute((0, 0, 1))
    quarter = np.sqrt(0.5)

    def bar(length):
        return [lissom.Segment(length, radius, young, None, 1100.0, {"bend_z": 2}, 0.02, poisson_ratio=0.45)]

    down, ahead = (quarter, 0, 0, -quarter), (quarter, 0, 0, quarter)
    links = [
        lissom.Link("crank", joint=hinge, rod=bar(0.2), orientation=down),
        lissom.Link("coupler", parent="crank", joint=hinge, rod=bar(0.4), orientation=ahead),
        lissom.Link("rocker", position=(0.4, 0, 0), joint=hinge, rod=bar(0.2), orientation=down),
    ]
    loops = [lissom.Loop(("rocker", 0.2), ("coupler", 0.4), hinge, name="pin")]
    v0 = np.zeros(lissom.Robot(links, loops=loops).n)
    v0[0] = rng.uniform(-3.0, 3.0)
    make = lambda: lissom.Robot(links, gravity=(0, -9.81, 0), loops=loops)  # noqa: E731
    return Case(make, rng.uniform(0.3, 1.0), v0=v0)


def limits(rng):
    """A chain that swings against the stops of its hinges."""
    angle = rng.uniform(0.2, 1.0)
    links = chain_links(
        rng,
        int(rng.integers(1, 4)),
        damping=0.02,
        limits=(-angle, angle),
        limit_stiffness=10 ** rng.uniform(1.5, 4.0),
        limit_dissipation=rng.uniform(0.0, 1.0),
    )
    q0 = rng.uniform(-0.9, 0.5, len(links)) * angle
    return Case(lambda: lissom.Robot(links), rng.uniform(0.5, 2.0), q0=q0)


def tapered(rng):
    """A rod of one to three segments, two to ten times as thin at its tip, with or without a body there."""
    segments, period, _ = soft(rng, {"bend_y": 4})
    base = segments[0].radius[0]
    number = int(rng.integers(1, 4))
    ends = np.linspace(1.0, rng.uniform(0.1, 0.5), number + 1) * base
    parts = [
        lissom.Segment(
            segments[0].length / number,
            (ends[i], ends[i + 1]),
            segments[0].young_modulus,
            segments[0].young_modulus / 3.0,
            segments[0].density,
            {"bend_y": 4},
            retardation_time=segments[0].retardation_time,
        )
        for i in range(number)
    ]
    return Case(lambda: rod(parts), rng.uniform(1.0, 5.0) * period)


def obstacles(rng):
    """A clamped rod that falls on a floor, a bar or a box."""
    segments, period, _ = soft(rng, {"bend_y": 3}, int(rng.integers(1, 3)))
    length = sum(segment.length for segment in segments)
    radius = segments[0].radius[0]
    depth = length * 10 ** rng.uniform(-2.0, -1.0) + radius
    place = length * rng.uniform(0.3, 0.9)
    shape = (
        lissom.HalfSpace((0, 0, -depth)),
        lissom.Capsule((place, -length, -depth - radius), (place, length, -depth - radius), radius),
        lissom.Box((place, 0, -depth - 0.1 * length), (0.05 * length, length, 0.1 * length)),
    )[int(rng.integers(3))]
    contact = lissom.Contact("rod", shape, friction=float(rng.choice([0.0, 0.3])), slip_velocity=1e-3)
    return Case(lambda: rod(segments, contacts=[contact]), rng.uniform(0.5, 3.0) * period)


def moving_base(rng):
    """A rod on a base that turns and shifts to and fro."""
    segments, period, _ = soft(rng, {"torsion": 1, "bend_y": 2, "bend_z": 2}, int(rng.integers(1, 3)))
    length = sum(segment.length for segment in segments)
    rate = rng.uniform(0.2, 1.5) / period
    shift = length * 10 ** rng.uniform(-2.0, -0.7) * rng.normal(size=3)
    base = lissom.BaseMotion(
        translation=lissom.Harmonic(list(shift), rate),
        axis=(0, 0, 1),
        angle=lissom.Harmonic(rng.uniform(0.05, 0.5), rate),
    )
    return Case(lambda: rod(segments, base_motion=base), rng.uniform(1.0, 5.0) * period)


FAMILIES: dict[str, Callable[[np.random.Generator], Case]] = {
    "planar rods": planar,
    "rods in space": spatial,
    "chains": chain,
    "tendons": tendons,
    "jumps as functions": step,
    "falling rods": falling,
    "landing balls": landing,
    "dry friction": rubbing,
    "closed loops": loop,
    "joint limits": limits,
    "tapered rods": tapered,
    "rods on obstacles": obstacles,
    "moving bases": moving_base,
}
