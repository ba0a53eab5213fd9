"""Motions in other units of length, mass and time: numbers change, motions do not.

In units that are powers of two rounding is the same, so that motions agree bit for bit; in others they agree
to what Newton's iterations may leave. Every robot is compared with itself in metres, kilograms and
seconds.
"""

import numpy as np
import pytest

import lissom
from reference.units import COORDINATES, FORCE, ONE, L, T, converted, scaled

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


def long_cantilever():
    """Of a hundred metres: 1e5 in millimetres."""
    segment = lissom.Segment(100.0, 1.0, 1e9, 4e8, 1000, modes={"bend_y": 3}, retardation_time=0.05)
    return lissom.Robot([lissom.Link("rod", rod=[segment])])


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
    "long": (long_cantilever, None, None, 5e-2),
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

quiet = pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")


def dimensions(robot):
    """Dimensions of the robot's coordinates."""
    kinds = [COORDINATES.get(name.split(".")[-1].split("[")[0], ONE) for name in robot.coordinates]
    return np.array(kinds)


def factors(robot, units, per_time=0):
    """Factors of the numbers of coordinates, or of their derivatives."""
    return np.array([scaled(1.0, kind - per_time * T, units) for kind in dimensions(robot)])


def run(robot, start, velocity, dt, units=(1.0, 1.0, 1.0), steps=STEPS, **options):
    """A run of the robot in these units, and its motion in metres, kilograms and seconds."""
    given = {"q0": start, "v0": velocity}
    begin = {
        name: np.asarray(value, float) * factors(robot, units, power)
        for power, (name, value) in enumerate(given.items())
        if value is not None
    }
    dt *= units[2]
    found = lissom.simulate(converted(robot, units), steps * dt, dt=dt, **begin, **options)
    return found, found.q / factors(robot, units)


def agree(robot, path, expected, units):
    """Motions are the same, beside the largest coordinate of each dimension, but for what steps may leave."""
    kinds = dimensions(robot)
    for kind in np.unique(kinds, axis=0):
        own = (kinds == kind).all(axis=1)
        size = np.abs(expected[:, own]).max()
        left = {"rtol": 0, "atol": LEFT * size, "err_msg": str(units)}
        np.testing.assert_allclose(path[:, own], expected[:, own], **left)


#: Errors of accelerations that Newton's method may leave, 0.1 of `rtol`.
LEFT = 1e-7

#: Robots whose coordinates have one unit, so that elimination takes them in one order in all units. With
#: tendons that do not stretch, that order depends on the unit of mass as well.
OF_ONE_UNIT = ("cantilever", "long", "pulled", "laid")
IN_NO_ORDER = ("hung",)


def cases():
    for name in ROBOTS:
        for method in METHODS:
            # Without inertia what flies is not determined, tendons that do not stretch are refused, and loops
            # have exact Jacobians alone.
            if method == "quasi-static" and name in ("hung", "ball", "floating"):
                continue
            if method == "differences" and name in ("hung", "linkage"):
                continue
            yield name, method


@quiet
@pytest.mark.parametrize(("name", "method"), list(cases()))
def test_motions_in_powers_of_two_are_the_same(name, method):
    make, start, velocity, dt = ROBOTS[name]
    robot = make()
    expected, path = run(robot, start, velocity, dt, **METHODS[method])
    assert expected.status == "finished"
    for units in POWERS_OF_TWO.values():
        found, same = run(robot, start, velocity, dt, units, **METHODS[method])
        assert found.status == "finished", units
        if name in OF_ONE_UNIT or (units[0] == 1.0 and name not in IN_NO_ORDER):
            assert found.stats.nfev == expected.stats.nfev, units
            np.testing.assert_array_equal(same, path, err_msg=str(units))
        else:
            agree(robot, same, path, units)


@quiet
@pytest.mark.parametrize(("name", "method"), list(cases()))
def test_motions_in_other_units_are_the_same(name, method):
    make, start, velocity, dt = ROBOTS[name]
    robot = make()
    _, path = run(robot, start, velocity, dt, **METHODS[method])
    for units in UNITS.values():
        found, same = run(robot, start, velocity, dt, units, **METHODS[method])
        assert found.status == "finished", units
        agree(robot, same, path, units)


@quiet
@pytest.mark.parametrize("units", [*POWERS_OF_TWO.values(), *UNITS.values()], ids=[*POWERS_OF_TWO, *UNITS])
@pytest.mark.parametrize("length", [1.0, 10.0, 100.0, 1000.0])
def test_long_rods_are_as_right_as_short_ones_in_all_units(length, units):
    """Beside Radau's method, similar rods have the same errors, those of steps of a part of a period."""

    def error(length, units):
        segment = lissom.Segment(
            length, 0.01 * length, 1e7 * length, poisson_ratio=0.3, density=1000.0, modes={"bend_y": 3}
        )
        robot, dt = lissom.Robot([lissom.Link("rod", rod=[segment])]), 2e-3 * np.sqrt(length)
        _, path = run(robot, None, None, dt, method="radau", rtol=1e-9, atol=0.0)
        _, found = run(robot, None, None, dt, units)
        return (found - path) * length

    expected = error(1.0, (1.0, 1.0, 1.0))
    assert 1e-4 < np.abs(expected).max() < 0.1
    np.testing.assert_allclose(error(length, units), expected, rtol=0, atol=1e-6)


def driven():
    """A rod that a tendon pulls by a tension that is an input."""
    path = [lissom.Along("rod", (0.0, 0.004), (0.0, 0.3))]
    pull = lissom.Tendon("pull", path, tension=lissom.Input("pull", 0.1))
    return lissom.Robot([lissom.Link("rod", rod=[segment(bend_y=3, bend_z=2)])], actuators=[pull])


@pytest.mark.parametrize("units", POWERS_OF_TWO.values(), ids=POWERS_OF_TWO)
def test_controllers_simulations_and_ensembles_are_the_same_in_all_units(units):
    robot, dt, steps = driven(), 5e-3, 40
    bend = robot.coordinates.index("rod.bend_y[0]")

    def motions(units):
        other, of = converted(robot, units), factors(robot, units)
        h, force, curvature = dt * units[2], scaled(1.0, FORCE, units), scaled(1.0, -L, units)

        def control(_t, q, _v):
            return [force * (0.1 + 0.01 * q[bend] / curvature)]

        controlled = lissom.simulate(other, steps * h, dt=h, control=control, control_step=2 * h)
        simulation = lissom.Simulation(other, dt=h)
        for k in range(steps):
            simulation.step(u=[force * (0.1 + 0.05 * np.sin(0.3 * k))])
        many = lissom.simulate_many(other, steps * h, dt=h, u=force * np.array([[0.0], [0.1], [0.3]]))
        return controlled.q / of, simulation.q / of, many.q / of

    for found, expected in zip(motions(units), motions((1.0, 1.0, 1.0)), strict=True):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("options", [{}, {"alpha": -0.1}, {"rho_inf": 0.8}])
@pytest.mark.parametrize("units", POWERS_OF_TWO.values(), ids=POWERS_OF_TWO)
def test_spring_pendulums_are_the_same_in_all_units(units, options):
    def motion(length, mass, time):
        numbers = {"length": length, "mass": mass, "stiffness": 10 * mass / time**2}
        pendulum = lissom.SpringPendulum(**numbers, gravity=9.81 * length / time**2)
        q0 = [-0.8, 0.5 * length]
        found = lissom.simulate(pendulum, 2.0 * time, dt=0.01 * time, q0=q0, **options)
        return found.q / [1.0, length], found.stats.nfev

    (found, nfev), (expected, expected_nfev) = motion(*units), motion(1.0, 1.0, 1.0)
    # Which equation is eliminated first depends on the unit of length.
    if units[0] == 1.0:
        assert nfev == expected_nfev
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose(found, expected, rtol=0, atol=LEFT)


@pytest.mark.parametrize("jac", ["forward", "central", None])
@pytest.mark.parametrize("units", POWERS_OF_TWO.values(), ids=POWERS_OF_TWO)
def test_equations_of_which_nothing_is_known_are_the_same_in_all_units(units, jac):
    """A spring that hardens, through the ends of its swings, where accelerations of one of both vanish."""

    def motion(length, mass, time):
        m, d = np.diag([2.0, 1.0]) * mass, np.diag([0.1, 0.0]) * mass / time
        k = np.array([[50.0, -10.0], [-10.0, 20.0]]) * mass / time**2
        cubic = 30.0 * mass / (time * length) ** 2

        def residual(_t, q, v, a):
            return m @ a + d @ v + k @ q + cubic * q**3

        def exact(_t, q, _v, _a):
            return k + 3.0 * cubic * np.diag(q**2), d, m

        q0, v0 = [0.5 * length, 0.0], [0.0, 0.2 * length / time]
        span, given = (0.0, 2.0 * time), exact if jac is None else jac
        found = lissom.newmark(residual, span, q0, v0, dt=0.01 * time, jac=given)
        return found.q / length, found.stats.nfev

    (found, nfev), (expected, expected_nfev) = motion(*units), motion(1.0, 1.0, 1.0)
    # Where sizes are unknown, the rate of convergence is that of coordinates as they are.
    if jac is None and units[0] == 1.0:
        assert nfev == expected_nfev
        np.testing.assert_array_equal(found, expected)
    np.testing.assert_allclose(found, expected, rtol=0, atol=LEFT)


def test_a_given_tolerance_is_a_number_in_the_units_of_the_run():
    robot = rod_in_space()
    default = lissom.simulate(robot, 0.5, dt=5e-3)
    loose = lissom.simulate(robot, 0.5, dt=5e-3, atol=1.0)
    assert loose.stats.nfev < default.stats.nfev - 50
    tight = lissom.simulate(robot, 0.5, dt=5e-3, atol=1e-14)
    assert np.abs(tight.q - default.q).max() < 1e-6 * np.abs(default.q).max()
    assert lissom.methods.Newmark().atol is None
    assert lissom.methods.Newmark(atol=1e-9).atol == 1e-9
