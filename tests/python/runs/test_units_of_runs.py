"""Motions in other units of length, mass and time: numbers change, motions do not.

In units that are powers of two rounding is the same, so that motions agree bit for bit; in others they agree
to a part of what Newton's iterations may leave. Every robot is compared with itself in metres, kilograms and
seconds.
"""

import numpy as np
import pytest

import lissom
from reference.units import COORDINATES, L, ONE, T, converted, scaled

#: Factors of the numbers of lengths, masses and times. In the last one a robot of a metre is one of a
#: kilometre in metres and seconds, beside the same gravity.
POWERS_OF_TWO = {
    "lengths": (2.0**-12, 1.0, 1.0),
    "longer": (2.0**10, 1.0, 1.0),
    "masses": (1.0, 2.0**-10, 1.0),
    "microseconds": (1.0, 1.0, 2.0**20),
    "hours": (1.0, 1.0, 2.0**-12),
    "all": (2.0**10, 2.0**10, 2.0**10),
    "a kilometre": (2.0**10, 1.0, 2.0**5),
}
UNITS = {
    "mm, g, ms": (1e3, 1e3, 1e3),
    "m, kg, us": (1.0, 1.0, 1e6),
    "km, t, h": (1e-3, 1e-3, 1 / 3600),
}

HINGE = lissom.Revolute((0, 1, 0))


def bar(length, mass=0.05):
    inertia = mass * length**2 / 12
    return lissom.Body(mass, centre=(length / 2, 0, 0), inertia=(1e-3 * inertia, inertia, inertia))


def segment(length=0.3, radius=5e-3, **modes):
    return lissom.Segment(length, radius, 1e6, 4e5, 1000, modes=modes, retardation_time=0.01)


def cantilever():
    return lissom.Robot([lissom.Link("rod", rod=[segment(bend_y=3)])])


def rod_in_space():
    modes = {"torsion": 2, "bend_y": 2, "bend_z": 2, "stretch": 1}
    load = lissom.Load(force=(0.0, 0.05, 0.0), at=0.4, link="rod")
    return lissom.Robot([lissom.Link("rod", rod=[segment(**modes)] * 2)], loads=[load])


def double_pendulum():
    """With friction, a slider and stops."""
    first = lissom.Revolute((0, 1, 0), friction=2e-3, friction_velocity=1e-2)
    second = lissom.Revolute((0, 1, 0), damping=1e-4, limits=(-0.5, 0.5), limit_stiffness=1.0)
    third = lissom.Prismatic((1, 0, 0), stiffness=30.0, limits=(-0.01, 0.02), limit_stiffness=500.0)
    links = [
        lissom.Link("first", joint=first, body=bar(0.3)),
        lissom.Link("second", parent="first", position=(0.3, 0, 0), joint=second, body=bar(0.4)),
        lissom.Link("third", parent="second", position=(0.4, 0, 0), joint=third, body=bar(0.1)),
    ]
    return lissom.Robot(links)


def linkage():
    """A four-bar linkage with a soft coupler."""
    links = [
        lissom.Link("crank", joint=lissom.Revolute((0, 1, 0), stiffness=0.3, damping=0.01), body=bar(0.1)),
        lissom.Link(
            "coupler", parent="crank", position=(0.1, 0, 0), joint=HINGE, rod=[segment(0.2, bend_y=3)]
        ),
        lissom.Link("rocker", parent="coupler", joint=HINGE, body=bar(0.15)),
    ]
    pin = lissom.Loop(("rocker", None, (0.15, 0, 0)), (None, None, (0.2, 0, -0.05)), HINGE)
    return lissom.Robot(links, loops=[pin])


def pulled():
    """A rod with a tendon along it, and one of a given length and stiffness."""
    modes = {"bend_y": 3, "bend_z": 2}
    path = [lissom.Along("rod", (0.0, 0.004), (0.0, 0.3))]
    to_the_world = [lissom.Via(None, (0.1, 0, 0.2)), lissom.Via("rod", (0, 0, 0), at=0.3)]
    tendons = [
        lissom.Tendon("tension", path, tension=0.2),
        lissom.Tendon("cable", to_the_world, length=0.25, stiffness=50.0, damping=0.05),
    ]
    return lissom.Robot([lissom.Link("rod", rod=[segment(**modes)])], actuators=tendons)


def hung():
    """A plate on cords that do not stretch and are slack at the start."""
    body = lissom.Body(0.2, centre=(0, 0, -0.02), inertia=(3e-4, 3e-4, 5e-4))
    corners = [(0.05, 0.05), (-0.05, -0.05), (-0.05, 0.05), (0.05, -0.05)]
    cords = [
        lissom.Tendon(
            f"cord {i}", [lissom.Via(None, (2 * x, 2 * y, 0.4)), lissom.Via("plate", (x, y, 0))], length=0.25
        )
        for i, (x, y) in enumerate(corners)
    ]
    return lissom.Robot([lissom.Link("plate", joint=lissom.Free(), body=body)], actuators=cords)


def ball():
    """A ball that is thrown on a floor, with friction."""
    link = lissom.Link("ball", joint=lissom.Free(), body=lissom.Body(0.1, inertia=(1e-5, 1e-5, 1e-5)))
    law = {"stiffness": 1e4, "dissipation": 0.5, "friction": 0.3, "slip_velocity": 1e-3}
    contact = lissom.Contact(lissom.Ball("ball", 0.02), lissom.HalfSpace(), **law)
    return lissom.Robot([link], contacts=[contact])


def laid():
    """A rod that falls on a floor."""
    contact = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.05)), dissipation=1.0)
    return lissom.Robot([lissom.Link("rod", rod=[segment(bend_y=4, bend_z=1)])], contacts=[contact])


def floating():
    """A rod that flies and spins without loads; its bending decays to rounding."""
    link = lissom.Link("rod", joint=lissom.Free(), rod=[segment(torsion=1, bend_y=2, bend_z=2)])
    return lissom.Robot([link], gravity=(0, 0, 0))


FLIGHT = [0.3, 0.0, -0.5, 3.0, 1.0, -2.0]

#: Robots with their initial coordinates and velocities, and the step in seconds.
ROBOTS = {
    "cantilever": (cantilever, None, None, 5e-3),
    "rod in space": (rod_in_space, None, None, 5e-3),
    "double pendulum": (double_pendulum, [0.3, 0.2, 0.0], None, 2e-3),
    "linkage": (linkage, None, None, 5e-3),
    "pulled": (pulled, None, None, 5e-3),
    "hung": (hung, [0.01, 0.02, 0.2, 0.1, 0.2, 0.05], None, 2e-3),
    "ball": (ball, [0, 0, 0.1, 0.1, 0.2, 0.3], FLIGHT, 1e-3),
    "laid": (laid, None, None, 2e-3),
    "floating": (floating, None, [*FLIGHT, 0, 0, 0, 0, 0], 5e-3),
}

#: Fixed steps; the default of the robot first.
METHODS = {
    "default": {},
    "generalised alpha": {"rho_inf": 0.6},
    "hht": {"alpha": -0.2},
    "newmark": {"beta": 0.3025, "gamma": 0.6},
    "differences": {"jac": "forward"},
    "zero": {"predictor": "zero", "reuse_jacobian": False},
    "quasi-static": {"method": "quasi_static"},
}

STEPS = 100

units_of_powers = pytest.mark.parametrize("units", POWERS_OF_TWO.values(), ids=POWERS_OF_TWO)
units_of_others = pytest.mark.parametrize("units", UNITS.values(), ids=UNITS)
quiet = pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")


def of_coordinates(robot, units, per_time=0):
    """The factors of coordinates, or of their derivatives."""
    kinds = [COORDINATES.get(name.split(".")[-1].split("[")[0], ONE) for name in robot.coordinates]
    return np.array([scaled(1.0, kind - per_time * T, units) for kind in kinds])


def run(robot, start, velocity, dt, units=(1.0, 1.0, 1.0), steps=STEPS, **options):
    """The motion of the robot in these units, with coordinates in metres, kilograms and seconds."""
    factors = of_coordinates(robot, units)
    begin = {"q0": start, "v0": velocity}
    begin = {
        name: np.asarray(value, float) * of_coordinates(robot, units, power)
        for power, (name, value) in enumerate(begin.items())
        if value is not None
    }
    dt *= units[2]
    found = lissom.simulate(converted(robot, units), steps * dt, dt=dt, **begin, **options)
    return found, found.q / factors


def cases():
    for name in ROBOTS:
        for method in METHODS:
            # Without inertia what flies is not determined, and tendons that do not stretch are refused.
            if method == "quasi-static" and name in ("hung", "ball", "floating"):
                continue
            # Constraints have an exact Jacobian, and so have contacts and friction.
            yield name, method


@quiet
@pytest.mark.parametrize(("name", "method"), list(cases()))
def test_motions_in_powers_of_two_are_the_same_bit_for_bit(name, method):
    make, start, velocity, dt = ROBOTS[name]
    robot = make()
    expected, path = run(robot, start, velocity, dt, **METHODS[method])
    assert expected.status == "finished"
    for units in POWERS_OF_TWO.values():
        found, same = run(robot, start, velocity, dt, units, **METHODS[method])
        assert (found.status, found.stats.nfev) == (expected.status, expected.stats.nfev), units
        np.testing.assert_array_equal(same, path, err_msg=str(units))
