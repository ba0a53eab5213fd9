"""Scenes in contact in other units of length, mass and time: numbers change, shapes and motions do not.

Units are powers of two, so that rounding is the same: shapes agree bit for bit.
"""

import numpy as np
import pytest

import lissom
from lissom import Box, Capsule, Contact, Free, HalfSpace, Link, Robot, Segment, Sphere

STEPS = lissom.methods.Newmark(atol=0.0)

UNITS = [
    *[(unit, 1.0, 1.0) for unit in (2.0**-12, 2.0**10, 2.0**20)],
    *[(1.0, unit, 1.0) for unit in (2.0**-10, 2.0**10)],
    *[(1.0, 1.0, unit) for unit in (2.0**-10, 2.0**10)],
    (2.0**10, 2.0**10, 2.0**10),
]


class Units:
    """How many units are in a metre, a kilogram and a second."""

    def __init__(self, length=1.0, mass=1.0, time=1.0):
        self.length, self.mass, self.time = length, mass, time
        self.speed, self.gravity = length / time, (0, 0, -9.81 * length / time**2)

    def at(self, *place):
        return tuple(x * self.length for x in place)

    def segment(self, length, radius, young, density=1200.0, retardation_time=0.0, **modes):
        return Segment(
            length * self.length,
            radius * self.length,
            young * self.mass / (self.length * self.time**2),
            poisson_ratio=0.3,
            density=density * self.mass / self.length**3,
            modes=modes,
            retardation_time=retardation_time * self.time,
        )

    def rough(self, stiffness):
        """A law with friction and dissipation."""
        return {
            "stiffness": stiffness * self.mass / (self.time**2 * self.length),
            "dissipation": 1.0 / self.speed,
            "friction": 0.4,
            "slip_velocity": 1e-3 * self.speed,
        }


def bar(units):
    """A wire over a bar that it hides."""
    capsule = Capsule(units.at(0.62, -0.3, -0.1), units.at(0.62, 0.3, -0.1), 4e-4 * units.length)
    segment = units.segment(1.0, 7e-4, 1.4e9, bend_y=4)
    return Robot([Link("rod", rod=[segment])], gravity=units.gravity, contacts=[Contact("rod", capsule)])


def table(units, **law):
    box = Box(units.at(0.7, 0, -0.2), units.at(0.3, 0.5, 0.1))
    segments = [units.segment(0.5, 1e-3, 1e9, retardation_time=0.01, bend_y=4, bend_z=2, torsion=1)] * 2
    return Robot([Link("rod", rod=segments)], gravity=units.gravity, contacts=[Contact("rod", box, **law)])


def ball(units):
    """A rod over a ball, from which it slides off."""
    sphere = Sphere(units.at(0.4, 0.002, -0.15), 0.05 * units.length)
    segments = [units.segment(0.5, 4e-3, 1e7, bend_y=3, bend_z=3, torsion=1)] * 2
    return Robot([Link("rod", rod=segments)], gravity=units.gravity, contacts=[Contact("rod", sphere)])


def floor(units):
    contact = Contact("rod", HalfSpace(units.at(0, 0, -0.1)))
    segment = units.segment(1.0, 5e-3, 1e6, bend_y=5)
    return Robot([Link("rod", rod=[segment])], gravity=units.gravity, contacts=[contact])


def crossing(units, **law):
    """A rod on another one."""
    across = {"position": units.at(0.25, -0.1, -0.02), "orientation": (np.sqrt(0.5), 0, 0, np.sqrt(0.5))}
    links = [
        Link("rod", rod=[units.segment(0.5, 2e-3, 1e8, retardation_time=0.01, bend_y=4, bend_z=3)]),
        Link("other", rod=[units.segment(0.3, 2e-3, 1e9, bend_y=3, bend_z=3)], **across),
    ]
    return Robot(links, gravity=units.gravity, contacts=[Contact("rod", "other", **law)])


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("scene", [bar, table, ball, floor, crossing])
def test_rest(scene):
    expected = lissom.statics(scene(Units()))
    assert expected.success
    for unit in UNITS:
        found = lissom.statics(scene(Units(*unit)))
        assert (found.status, found.nit) == (expected.status, expected.nit), unit
        # Coordinates are curvatures.
        np.testing.assert_array_equal(found.q * unit[0], expected.q, err_msg=str(unit))


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("scene", [bar, table, floor, crossing])
def test_rest_in_thousands_of_units(scene):
    """Numbers that rounding changes: the shape agrees to what is left of forces."""
    expected = lissom.statics(scene(Units()))
    found = lissom.statics(scene(Units(1e3, 1e3, 1e3)))
    assert found.status == expected.status
    np.testing.assert_allclose(found.q * 1e3, expected.q, rtol=1e-6, atol=1e-8 * np.abs(expected.q).max())


def laid(units):
    return table(units, **units.rough(1e4)), {}


def crossed(units):
    return crossing(units, **units.rough(1e6)), {}


def thrown(units):
    orientation = np.array([0.9, 0.1, 0.3, 0.2])
    segment = units.segment(0.3, 8e-3, 1e6, retardation_time=1e-3, bend_y=3, bend_z=3, torsion=1)
    place = {"position": units.at(0, 0, 0.2), "orientation": orientation / np.linalg.norm(orientation)}
    link = Link("rod", joint=Free(), rod=[segment], **place)
    contact = Contact("rod", HalfSpace((0, 0, 0)), **units.rough(1e5))
    v = np.zeros(13)
    v[:3], v[3:6] = [0.3 * units.speed, 0, -0.5 * units.speed], np.array([3.0, 1.0, -2.0]) / units.time
    return Robot([link], gravity=units.gravity, contacts=[contact]), {"v0": v}


def run(scene, *unit):
    units = Units(*unit)
    robot, start = scene(units)
    return lissom.simulate(robot, 0.3 * units.time, dt=2e-3 * units.time, method=STEPS, **start)


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("scene", [laid, crossed, thrown])
def test_motion(scene):
    expected = run(scene)
    assert expected.success
    assert expected.deepest is not None
    for unit in UNITS:
        found = run(scene, *unit)
        assert found.success
        # Coordinates are curvatures; of what is thrown also places and angles, and which of its equations is
        # eliminated first depends on the unit of length.
        of = np.full(expected.q.shape[1], 1 / unit[0])
        if scene is thrown:
            of[:3], of[3:6] = unit[0], 1.0
        if scene is thrown and unit[0] != 1.0:
            scale = np.abs(expected.q).max(axis=0)
            np.testing.assert_allclose(found.q / of / scale, expected.q / scale, atol=1e-6, err_msg=str(unit))
            continue
        assert found.stats.nfev == expected.stats.nfev, unit
        np.testing.assert_array_equal(found.q / of, expected.q, err_msg=str(unit))
