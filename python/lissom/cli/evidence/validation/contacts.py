"""Ropes and rods in contact: with friction on a drum and on the ground, wound up, and knotted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from ...._lissom import (
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
    Planar,
    Prismatic,
    Revolute,
    Robot,
    Section,
    Segment,
    Spherical,
    simulate,
    statics,
)
from ....model.contacts import Touch
from . import exact_contacts, lines
from .case import Answer, Array, Case, Curve, Plot
from .exact_contacts import Drum
from .exact_lines import Line
from .rods import GRAVITY, WEIGHTLESS

THEME = "Contact and friction"

# A rope over a drum

#: The rope of cosseratbench's experiment `capstan`, m, Pa, kg/m^3.
DRUM_RADIUS, ROPE_RADIUS, ROPE_YOUNG, ROPE_DENSITY, SHORT_SIDE = 0.05, 0.001, 3e5, 1000.0, 0.15
FRICTIONS = (0.1, 0.3, 0.6)
#: Long sides, in units of the longest that is held.
HELD, SLIDING = 0.95, 1.1
#: Part of its bending stiffness that the rope keeps: theory has none.
LIMP = 0.01
#: Segments on the short side, on the drum and on the long side, and modes of bending of each.
ROPE_SEGMENTS, ROPE_BENDS = (3, 10, 3), 3
#: Below this velocity friction creeps, m/s; time of motion and its steps, s.
CREEP, ROPE_TIME, ROPE_STEP = 1e-6, 0.2, 2e-3
ROPE_TIMES = np.array([0.1, 0.2])


def drum_of(friction: float) -> Drum:
    """The rope and its drum."""
    return Drum(DRUM_RADIUS + ROPE_RADIUS, ROPE_RADIUS, friction, SHORT_SIDE, GRAVITY)


def slid_exactly() -> Array:
    """How far ropes that are held and ropes that slide have moved."""
    moved = []
    for friction in FRICTIONS:
        drum = drum_of(friction)
        slides = exact_contacts.sliding(drum, SLIDING * exact_contacts.longest(drum), ROPE_TIMES)
        moved += [0.0, *slides]
    return np.array(moved)


def draped(friction: float, long: float) -> tuple[Robot, Array]:
    """The rope in the plane, its short side on the left, and its start around the drum."""
    around = DRUM_RADIUS + ROPE_RADIUS
    area = np.pi * ROPE_RADIUS**2
    turning = ROPE_DENSITY * area * ROPE_RADIUS**2 / 4.0
    bending = LIMP * ROPE_YOUNG * area * ROPE_RADIUS**2 / 4.0
    section = Section.given(
        (bending, bending, bending, ROPE_YOUNG * area, 1.0, 1.0),
        mass=ROPE_DENSITY * area,
        inertia=(2.0 * turning, turning, turning),
    )
    parts = zip((SHORT_SIDE, np.pi * around, long), ROPE_SEGMENTS, strict=True)
    rod = [
        Segment(length / count, section=section, modes={"bend_y": ROPE_BENDS}, retardation_time=1e-3)
        for length, count in parts
        for _ in range(count)
    ]
    half = float(np.sqrt(0.5))
    link = Link(
        lines.NAME,
        joint=Planar((0.0, 1.0, 0.0)),
        rod=rod,
        position=(-around, 0.0, -SHORT_SIDE),
        orientation=(half, 0.0, -half, 0.0),
    )
    drum = Contact(
        lines.NAME,
        Capsule((0.0, -1.0, 0.0), (0.0, 1.0, 0.0), DRUM_RADIUS),
        friction=friction,
        slip_velocity=CREEP,
        name="drum",
    )
    model = Robot([link], contacts=[drum], gravity=(0.0, 0.0, -GRAVITY))
    start = np.zeros(model.n)
    for i in range(ROPE_SEGMENTS[0], ROPE_SEGMENTS[0] + ROPE_SEGMENTS[1]):
        start[model.coordinates.index(f"{lines.NAME}.segment[{i}].bend_y[0]")] = 1.0 / around
    return model, start


def ropes_over_drums() -> Answer:
    """Motions of all ropes."""
    moved: list[float] = []
    curves, failures = [], []
    for friction in FRICTIONS:
        drum = drum_of(friction)
        longest = exact_contacts.longest(drum)
        for part, times in ((HELD, ROPE_TIMES[-1:]), (SLIDING, ROPE_TIMES)):
            model, start = draped(friction, part * longest)
            result = simulate(model, ROPE_TIME, dt=ROPE_STEP, q0=start)
            failures += [] if result.success else [result.message]
            height = model.pose(result.q, 0.0, link=lines.NAME, t=result.t)[:, 2, 3]
            moved += list(np.interp(times, result.t, height - height[0]))
            curves.append(Curve(f"lissom, μ = {friction:g}, {part:g}", result.t, 1e3 * (height - height[0])))
        t = np.linspace(0.0, ROPE_TIME, 11)
        exact = exact_contacts.sliding(drum, SLIDING * longest, t)
        curves.append(Curve(f"equation, μ = {friction:g}", t, 1e3 * exact, joined=False))
    return Answer(moved, lambda: Plot("t (s)", "way of the light end (mm)", curves), " ".join(failures))


# A chain that is drawn over the ground

#: The chain of MoorDyn in 50 m; coefficient of friction of the ground; the way on which its fairlead is moved
#: out, m; duration and steps, s.
DRAGGED, GROUND_FRICTION, WAY, DURATION, STEP = lines.CHAINS[0], 0.5, 8.0, 40.0, 0.2
#: Polynomial of fifth order, at rest at both ends, in so many points.
WAY_POINTS = 101


def dragged_exactly() -> tuple[float, float]:
    """Tension at the fairlead and at the anchor."""
    depth, distance, length, _, _ = DRAGGED
    return exact_contacts.dragged(lines.chain(depth, distance, length), GROUND_FRICTION)


def chain_on_ground(line: Line, start: Line) -> Robot:
    """A chain on ground with friction, whose fairlead moves slowly out, from its place in ``start``."""
    t = np.linspace(0.0, 1.0, WAY_POINTS)
    moved = np.zeros((WAY_POINTS, 3))
    moved[:, 0] = (line.x - start.x) * t**3 * (10.0 - 15.0 * t + 6.0 * t**2)
    section = lines.section_of(line, lines.BENDING * line.weight * line.length**3, lines.FLOOR_RADIUS)
    strains = {"bend_y": lines.FLOOR_BENDS, "stretch": lines.STRETCHES}
    rod = [Segment(line.length / lines.FLOOR_SEGMENTS, section=section, modes=strains)] * lines.FLOOR_SEGMENTS
    floor = Contact(
        lines.NAME,
        HalfSpace((0.0, 0.0, line.weight / lines.FLOOR_STIFFNESS - lines.FLOOR_RADIUS)),
        stiffness=lines.FLOOR_STIFFNESS,
        friction=GROUND_FRICTION,
        slip_velocity=CREEP,
        name="floor",
    )
    vessel = Free(motion=BaseMotion(translation=(DURATION * t, moved)))
    return Robot(
        [
            Link(lines.NAME, joint=Revolute((0.0, 1.0, 0.0)), rod=rod),
            Link("fairlead", joint=vessel, position=(start.x, 0.0, line.z)),
        ],
        gravity=(0.0, 0.0, -GRAVITY),
        loops=[Loop(LoopEnd(lines.NAME, line.length), LoopEnd("fairlead"), Spherical(), name="hook")],
        contacts=[floor],
    )


def dragged_chain() -> Answer:
    """From the equilibrium without friction of a slack chain."""
    depth, distance, length, _, _ = DRAGGED
    line = lines.chain(depth, distance, length)
    slack = replace(line, x=line.x - WAY)
    _, still, _ = lines.rested(slack)
    model = chain_on_ground(line, slack)
    result = simulate(model, DURATION, dt=STEP, q0=still.q)
    fairlead, anchor = [], []
    for t, q, v, a in zip(result.t, result.q, result.v, result.a, strict=True):
        fairlead.append(float(np.linalg.norm(np.ravel(model.loop_forces(q, v, a, t=t, name="hook"))[3:])))
        anchor.append(float(abs(model.joint_wrench(q, v, a, link=lines.NAME, t=t)[3])))
    moved = model.pose(result.q, link="fairlead", t=result.t)[:, 0, 3] - line.x

    def plot() -> Plot:
        x = np.linspace(-WAY, 0.0, 9)
        exact = [
            exact_contacts.dragged(replace(line, x=line.x + float(at)), GROUND_FRICTION)[0] / 1e6 for at in x
        ]
        return Plot(
            "way to the last place (m)",
            "tension (MN)",
            [
                Curve("lissom, fairlead", moved, np.array(fairlead) / 1e6),
                Curve("lissom, anchor", moved, np.array(anchor) / 1e6),
                Curve("catenary on a floor, fairlead", x, exact, joined=False),
            ],
        )

    return Answer([fairlead[-1], anchor[-1]], plot, "" if result.success else result.message)


# A ply

#: A rod of rubber, m and Pa, and its segments; modes of bending each way of a segment. Its shear modulus is
#: twice Young's, so that little twist is stored before the ply: nothing of the ply depends on it.
PLY_LENGTH, PLY_RADIUS, PLY_YOUNG, PLY_SEGMENTS, PLY_BENDS = 0.8, 0.01, 1e6, 15, 3
PLY_STIFFNESS = PLY_YOUNG * np.pi / 4.0 * PLY_RADIUS**4
#: Contact, N/m^2, in motion and at rest.
PLY_CONTACT, PLY_HARD = 1e6, 5e6
#: The ply is formed by a motion, at this winding angle in theory, with turns at the start and at the end, in
#: so many seconds, in which a syrup brakes it.
FORMED, START_TURNS, END_TURNS, FORMING, PLY_STEP = np.radians(28.0), 1.9, 2.75, 1.56, 5e-3
WINDING = 1.2
#: Winding angles in theory and turns of the ends: as many as leave both tails long.
PLIES = ((25.0, 2.75), (22.5, 2.5), (20.0, 2.5))
#: Where along the ply the winding angle is taken: away from the end loop and from the tails.
MIDDLE = (0.35, 0.65)


def ply_tension(angle: float) -> float:
    """The tension at which theory has this winding angle, N."""
    return exact_contacts.ply_tension(angle) * PLY_STIFFNESS / PLY_RADIUS**2


def plies_exactly() -> Array:
    """Winding angle, degrees, and torque, in units of B / R, of each."""
    values = [exact_contacts.ply(exact_contacts.ply_tension(np.radians(angle))) for angle, _ in PLIES]
    return np.ravel([(np.degrees(angle), 100.0 * torque) for angle, torque in values])


def wound(tension: float, base: Link, contact: float) -> Robot:
    """The rod, whose tip slides along its axis and does not turn."""
    length = PLY_LENGTH
    loads = [
        Load(link="rod", force=(tension, 0.0, 0.0)),
        # So that the loop is in the middle.
        Load(link="rod", along=(0.4 * length, 0.6 * length), force=(0.0, 0.0, 0.25 * tension / length)),
    ]
    return Robot(
        [base],
        loops=[Loop(LoopEnd(), LoopEnd("rod", length), Prismatic((1.0, 0.0, 0.0)), name="slide")],
        loads=loads,
        contacts=[Contact("rod", "rod", stiffness=contact)],
        fluid=Fluid(1e-9, viscous_drag=(40.0, 0.0)),
        gravity=WEIGHTLESS,
    )


def ply_rod() -> list[Segment]:
    """Its segments."""
    segment = Segment(
        PLY_LENGTH / PLY_SEGMENTS,
        PLY_RADIUS,
        PLY_YOUNG,
        2.0 * PLY_YOUNG,
        1000.0,
        {"torsion": 1, "bend_y": PLY_BENDS, "bend_z": PLY_BENDS},
        retardation_time=0.02,
    )
    return [segment] * PLY_SEGMENTS


def formed() -> tuple[Array, str]:
    """Coordinates of the rod after a motion in which a loop forms and winds up."""
    part = np.linspace(0.0, 1.0, 61)
    turns = START_TURNS + (END_TURNS - START_TURNS) * part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
    motion = (np.append(WINDING * part, 2.0 * WINDING), 2.0 * np.pi * np.append(turns, END_TURNS))
    base = Link("rod", joint=Revolute((1.0, 0.0, 0.0), motion=motion), rod=ply_rod())
    model = wound(ply_tension(float(FORMED)), base, PLY_CONTACT)
    start = np.zeros(model.n)
    twisted = [name.endswith("torsion[0]") for name in model.coordinates]
    start[twisted] = -2.0 * np.pi * START_TURNS / PLY_LENGTH
    result = simulate(model, FORMING, dt=PLY_STEP, q0=start)
    return result.q[-1][model.slice("rod")], "" if result.success else result.message


def touching(touches: Sequence[Touch]) -> Array:
    """Pairs of places of a rod that touches itself, the first one nearer to the base, in their order."""
    places = np.sort(np.array([touch.along for touch in touches], dtype=float), axis=1)
    return places[np.argsort(places[:, 0])]


def winding(model: Robot, q: Array) -> tuple[Array, Array]:
    """Places along the first strand and winding angles there, degrees, wherever the strands touch."""
    places = touching(model.touches(q))
    tangents = model.pose(q, places.ravel())[:, :3, 0].reshape(-1, 2, 3)
    between = -np.einsum("ki,ki->k", tangents[:, 0], tangents[:, 1])
    return places[:, 0], np.degrees(0.5 * np.arccos(np.clip(between, -1.0, 1.0)))


def plies() -> Answer:
    """Equilibria under smaller and smaller tensions."""
    q, failure = formed()
    values: list[float] = []
    curves, failures = [], [failure] if failure else []
    for angle, turns in PLIES:
        turned = 0.5 * 2.0 * np.pi * turns
        base = Link("rod", rod=ply_rod(), orientation=(np.cos(turned), np.sin(turned), 0.0, 0.0))
        model = wound(ply_tension(float(np.radians(angle))), base, PLY_HARD)
        found = statics(model, q, space_error=False)
        failures += [] if found.success else [found.message]
        q = found.q
        still = np.zeros(model.n)
        torque = abs(float(np.ravel(model.loop_forces(q, still, still, name="slide"))[0]))
        s, angles = winding(model, q)
        low, high = s[0] + np.array(MIDDLE) * (s[-1] - s[0])
        values += [
            float(np.mean(angles[(s > low) & (s < high)])),
            100.0 * torque * PLY_RADIUS / PLY_STIFFNESS,
        ]
        curves.append(Curve(f"lissom, {angle:g} degrees", s, angles))
        curves.append(
            Curve(f"theory, {angle:g} degrees", np.array([low, high]), np.full(2, angle), joined=False)
        )
    return Answer(values, lambda: Plot("s (m)", "winding angle (degrees)", curves), " ".join(failures))


# An overhand knot

#: Radius of the loop of a thin rope under the tension, m; radii of ropes, m; segments with their modes.
KNOT_LOOP, KNOT_ROPES = 0.07, (0.005, 0.0035, 0.0025, 0.0018, 0.0012)
KNOT_SEGMENTS, KNOT_BENDS, KNOT_YOUNG = 24, 5, 1e6
#: Contact of the thickest rope, N/m^2; it goes with the square of the radius.
KNOT_CONTACT = 2e5
#: Scale of the polynomial knot and length of its tails, m.
KNOT_SCALE, KNOT_TAIL = 0.008, 0.1
#: Relative error of sums of lengths.
ROUNDING = 1e-14
#: Sections of a loop at which its curvature is taken.
KNOT_POINTS = 1001
#: Audoly, Clauvelin and Neukirch 2007: F R^2 / B and P h^2 / (B eps^3) of loose trefoils.
LOOSE, CONTACT_FORCE = 0.5, 0.492


@cache
def tied() -> tuple[Array, Array, Array]:
    """Arc lengths, points from the origin, and axes of the first section of a polynomial knot with tails."""
    t = np.linspace(-2.15, 2.15, 801)
    shape = (t**5 - 10.0 * t, 6.0 * (t**3 - 3.0 * t), 4.0 * (t**4 - 4.0 * t**2))
    knot = KNOT_SCALE * np.stack(shape, axis=1)
    tails = np.linspace(0.0, KNOT_TAIL, 41)[1:, None]
    first, last = (way / np.linalg.norm(way) for way in (knot[0] - knot[1], knot[-1] - knot[-2]))
    points = np.concatenate([knot[0] + (first * tails)[::-1], knot, knot[-1] + last * tails])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    side = np.cross((0.0, 0.0, 1.0), -first)
    side /= np.linalg.norm(side)
    return arc, points - points[0], np.column_stack([-first, side, np.cross(-first, side)])


def knotted(radius: float) -> tuple[Robot, float, float]:
    """A rope on a ball joint, its bending stiffness, and the tension at its tip."""
    arc, _, axes = tied()
    bending = KNOT_YOUNG * np.pi / 4.0 * radius**4
    tension = bending / (2.0 * KNOT_LOOP**2)
    segment = Segment(
        arc[-1] / KNOT_SEGMENTS,
        radius,
        KNOT_YOUNG,
        KNOT_YOUNG / 3.0,
        1000.0,
        {"torsion": 1, "bend_y": KNOT_BENDS, "bend_z": KNOT_BENDS},
    )
    w = 0.5 * np.sqrt(1.0 + np.trace(axes))
    turned = [axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]]
    orientation = (w, *(np.array(turned) / (4.0 * w)))
    link = Link("rope", joint=Spherical(), rod=[segment] * KNOT_SEGMENTS, orientation=orientation)
    contact = Contact("rope", "rope", stiffness=KNOT_CONTACT * (radius / KNOT_ROPES[0]) ** 2)
    loads = [Load(link="rope", force=(tension, 0.0, 0.0))]
    return Robot([link], loads=loads, contacts=[contact], gravity=WEIGHTLESS), bending, tension


def knots() -> Answer:
    """Equilibria of thinner and thinner ropes, and what they tend to."""
    arc, points, _ = tied()
    rows, failures = [], []
    q = None
    for radius in KNOT_ROPES:
        model, bending, tension = knotted(radius)
        if q is None:
            # Segments add up to the length but for rounding.
            X = np.minimum(arc, KNOT_SEGMENTS * (arc[-1] / KNOT_SEGMENTS) * (1.0 - ROUNDING))
            q = model.coordinates_of(points, X=X, link="rope").q
        found = statics(model, q, space_error=False)
        failures += [] if found.success else [found.message]
        q = found.q
        touches = model.touches(q)
        along = touching(touches)
        X = np.linspace(along[:, 0].max(), along[:, 1].min(), KNOT_POINTS)
        loop = 1.0 / float(np.median(np.linalg.norm(model.strain(q, X)[:, 1:3], axis=1)))
        force = float(sum(np.linalg.norm(touch.force) for touch in touches))
        eps = np.sqrt(radius / loop)
        rows.append((eps, tension * loop**2 / bending, force * radius**2 / (bending * eps**3)))
    eps, tensions, forces = np.transpose(rows)
    limits = [float(np.polyfit(eps, values, 2)[-1]) for values in (tensions, forces)]

    def plot() -> Plot:
        at = np.linspace(0.0, eps.max(), 41)
        fitted = [np.polyval(np.polyfit(eps, values, 2), at) for values in (tensions, forces)]
        return Plot(
            "√(h / R)",
            "F R² / B, P h² / (B ε³)",
            [
                Curve("tension, parabola", at, fitted[0]),
                Curve("contact, parabola", at, fitted[1]),
                Curve("lissom, tension", eps, tensions, joined=False),
                Curve("lissom, contact", eps, forces, joined=False),
                Curve("theory", np.zeros(2), np.array([LOOSE, CONTACT_FORCE]), joined=False),
            ],
        )

    return Answer(limits, plot, " ".join(failures))


CASES = (
    Case(
        "Rope over a drum",
        THEME,
        "The rope of the benchmark cosseratbench, radius 1 mm, E = 0.3 MPa, 1000 kg/m³, over a drum of 50 "
        "mm with friction 0.1, 0.3 and 0.6, 0.15 m of it on one side and on the other 95 and 110 % of what "
        "friction holds, without stretch and with a hundredth of its bending stiffness. Friction acts at "
        "the surface of the rope, which shortens what it holds by 0.8, 2.3 and 5.2 % beside the capstan "
        "equation of a thin rope.",
        "Euler 1769, Eytelwein 1808, with weight, thickness and acceleration of the rope",
        "exact",
        "way of the end of the short side for each friction: held, after 0.2 s; sliding, after 0.1 and 0.2 "
        "s (m)",
        slid_exactly,
        ropes_over_drums,
        3e-2,
        others="in cosseratbench's own run for friction 0.3 and 2 s MuJoCo creeps by 1.8 mm at 80 % and "
        "slides at 110 %, PyElastica slides at 70 %",
    ),
    Case(
        "Chain drawn over the ground",
        THEME,
        "The chain in 50 m above on ground with friction 0.5: its fairlead moves out by 8 m within 40 s, "
        "until all of it has slid. Equilibria are without friction, so that this is a motion.",
        "Jonkman 2007, catenary on a floor with friction",
        "exact",
        "tension at the fairlead and at the anchor (N)",
        dragged_exactly,
        dragged_chain,
        1e-2,
        others="quasi-static codes as MoorDyn quotes them, with another friction or none: 991.6 and 826.2 kN",
    ),
    Case(
        "Ply of a twisted rod",
        THEME,
        "A pulled rod whose ends are turned forms a loop that winds up: two strands in contact without "
        "friction, tensions at which theory has winding angles of 25, 22.5 and 20 degrees. The ply is a bit "
        "more than one turn long, that of theory is endless.",
        "Clauvelin, Audoly and Neukirch 2009",
        "published",
        "winding angle (degrees) and torque × 100 R / B for each",
        plies_exactly,
        plies,
        3e-2,
        scale=25.0,
        others="DisMech-Newton accepts medians of 0.97 to 1.03 of the torque, 0.93 to 1.03 of the tension",
    ),
    Case(
        "Overhand knot, loose",
        THEME,
        "Ropes with radii h from 5 to 1.2 mm and an overhand knot without friction, whose loops have radii "
        "R of 76 to 73 mm; what their tension F and the sum P of the contact forces tend to for ε = √(h / "
        "R) → 0, by parabolas through five ropes of ε = 0.25 to 0.13, where they are 0.63 to 0.53 and 1.11 "
        "to 0.74. With ropes from 3.5 to 0.9 mm the parabolas end at 0.504 and 0.527. Where a knot slides, "
        "friction takes μ P.",
        "Audoly, Clauvelin and Neukirch 2007",
        "published",
        "F R² / B and P h² / (B ε³)",
        lambda: [LOOSE, CONTACT_FORCE],
        knots,
        1.5e-1,
        others="DisMech-Newton, with friction, accepts 0.75 to 1.33 of the tension",
    ),
)
