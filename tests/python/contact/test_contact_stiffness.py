"""The stiffness of contacts: the default from the loads, that of the material, and a number."""

from __future__ import annotations

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

G = 9.81
FLOOR = lissom.HalfSpace((0, 0, -0.1))
E, NU, DENSITY, RADIUS, LENGTH = 2e9, 0.3, 1500.0, 2e-3, 2.0
AREA, INERTIA = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4
#: What is let go presses twice as much as at rest.
WEIGHT = 2 * DENSITY * AREA * LENGTH * G

#: That of the material: pi/4 E / (1 - nu^2) (Popov 2010, eq. 5.33).
OF_MATERIAL = np.pi / 4 * E / (1 - NU**2)

#: A force that bends a clamped rod by some 75 degrees.
BENDING = 7 * E * INERTIA / LENGTH**2


def needed(force, radius=RADIUS, length=LENGTH):
    """The stiffness at which a force on an edge sinks a rod by 15 % of its radius, or by 5e-4 of its length.

    A straight rod across an edge, sunk by d: the depth is d - x^2 / (2 r), integrated here by its own.
    """
    d = min(0.15 * radius, 5e-4 * length)
    x = np.linspace(-1, 1, 200_001) * np.sqrt(2 * radius * d)
    return force / np.trapezoid(d - x**2 / (2 * radius), x)


def segment(length=LENGTH, radius=RADIUS, E=E, density=DENSITY, **options):
    modes = options.pop("modes", {"bend_y": 3})
    return lissom.Segment(
        length, radius, E, poisson_ratio=NU, density=density, modes=modes, retardation_time=0.01, **options
    )


def cable(*segments, contacts=None, **options):
    rod = list(segments) or [segment()]
    return lissom.Robot(
        [lissom.Link("rod", rod=rod)], contacts=contacts or [lissom.Contact("rod", FLOOR)], **options
    )


def stiffness(robot, contact=0):
    """As `explain` prints it."""
    printed = re.findall(r"([\d.e+-]+) N/m\^2", robot.explain())
    exact = robot._contact_stiffness()
    assert_allclose(float(printed[contact]), exact[contact], rtol=1e-3)
    return exact[contact]


def test_the_default_is_what_weight_and_bending_need():
    assert_allclose(stiffness(cable()), needed(WEIGHT + BENDING), rtol=1e-6)
    assert needed(WEIGHT + BENDING) < OF_MATERIAL / 100
    assert_allclose(stiffness(cable(gravity=(0, 0, 0))), needed(BENDING), rtol=1e-6)
    assert_allclose(stiffness(cable(gravity=(0, 3.0, -4.0))), needed(WEIGHT * 5 / G + BENDING), rtol=1e-6)
    assert "N/m^2 for its loads" in cable().explain()


def test_short_rods_keep_their_shape():
    # 15 % of the radius is more than 5e-4 of the length.
    length = 0.1
    force = WEIGHT * length / LENGTH + 7 * E * INERTIA / length**2
    expected = needed(force, length=length)
    assert expected > 1.5 * needed(force)
    assert_allclose(stiffness(cable(segment(length))), min(expected, OF_MATERIAL), rtol=1e-6)


def test_soft_robots_keep_the_stiffness_of_their_material():
    soft = cable(segment(0.3, 0.05, 1e5))
    assert_allclose(stiffness(soft), np.pi / 4 * 1e5 / (1 - NU**2), rtol=1e-12)
    assert "N/m^2 of the material" in soft.explain()


def test_a_number_and_the_material_are_as_they_say():
    given = cable(contacts=[lissom.Contact("rod", FLOOR, stiffness=1e5)])
    assert stiffness(given) == 1e5
    assert given.contacts[0].stiffness == 1e5
    material = cable(contacts=[lissom.Contact("rod", FLOOR, stiffness="material")])
    assert_allclose(stiffness(material), OF_MATERIAL, rtol=1e-12)
    assert material.contacts[0].stiffness == "material"
    assert "N/m^2 of the material" in material.explain()
    assert cable().contacts[0].stiffness is None


LOADS = {
    "force": (lissom.Load(force=(0, 3.0, 4.0)), 5.0),
    "spread": (lissom.Load(force=(0, 0, 2.0), along=(0.5, 1.5)), 2.0),
    "moment": (lissom.Load(moment=(0, 3.0, 0)), 3.0 / LENGTH),
    "table": (lissom.Load(force=([0.0, 1.0, 2.0], [[0, 0, 0], [0, 0, -6.0], [0, 0, 0]])), 6.0),
    "harmonic": (lissom.Load(force=lissom.Harmonic((0, 0, 3.0), 2.0, mean=(0, 0, -1.0))), 4.0),
    "input": (lissom.Load(force=lissom.Input("push", (0, 0, -2.5))), 2.5),
}


@pytest.mark.parametrize(("load", "force"), LOADS.values(), ids=list(LOADS))
def test_loads_press_with_their_largest_magnitude(load, force):
    robot = cable(loads=[load])
    assert_allclose(stiffness(robot), needed(WEIGHT + BENDING + force), rtol=1e-6)


def spun(t):
    return 2.0 * t


UNKNOWN = {
    "a load": {"loads": [lissom.Load(force=lambda t: (0, 0, -9.0))]},
    "a growing load": {"loads": [lissom.Load(force=lissom.Harmonic(rate=(0, 0, 1)))]},
    "a joint": {"joint": lissom.Revolute((0, 1, 0), motion=spun)},
    "a base": {"base_motion": lissom.BaseMotion(translation=lissom.Harmonic((0.1, 0, 0), 1.0))},
    "a length": {"actuators": [lissom.Tendon("pull", [lissom.Along("rod", (0, 1e-3))], length=1.9)]},
    "what is thrown": {"joint": lissom.Free(), "gravity": (0, 0, 0)},
}


@pytest.mark.parametrize("options", UNKNOWN.values(), ids=list(UNKNOWN))
def test_where_something_unknown_presses_the_material_decides(options):
    options = dict(options)
    joint = options.pop("joint", lissom.Weld())
    link = lissom.Link("rod", joint=joint, rod=[segment()])
    robot = lissom.Robot([link], contacts=[lissom.Contact("rod", FLOOR)], **options)
    assert_allclose(stiffness(robot), OF_MATERIAL, rtol=1e-12)


def test_what_may_fall_counts_four_times():
    link = lissom.Link("rod", joint=lissom.Free(), rod=[segment()])
    robot = lissom.Robot([link], contacts=[lissom.Contact("rod", FLOOR)])
    assert_allclose(stiffness(robot), needed(2 * WEIGHT + BENDING), rtol=1e-6)
    # From twice its length, across an edge, it does not sink.
    block = lissom.Box((LENGTH / 2, 0, -2 * LENGTH - 0.1), (0.1, 0.1, 0.1))
    robot = lissom.Robot([link], contacts=[lissom.Contact("rod", block)])
    fallen = lissom.simulate(robot, 1.0, dt=5e-4)
    assert fallen.success
    assert 0.05 < fallen.deepest.share < 0.35


def test_bodies_and_actuators_press():
    tendon = lissom.Tendon("pull", [lissom.Along("rod", (0, 1e-3))], tension=lissom.Input("T", 8.0))
    body = lissom.Body(0.2, link="rod")
    robot = cable(bodies=[body], actuators=[tendon])
    assert_allclose(stiffness(robot), needed(WEIGHT + BENDING + 2 * 0.2 * G + 8.0), rtol=1e-6)


def test_where_rods_are_cut_does_not_matter():
    whole = stiffness(cable())
    modes = {"bend_y": 1}
    pieces = [segment(part * LENGTH, modes=modes) for part in (0.2, 0.5, 0.3)]
    assert_allclose(stiffness(cable(*pieces)), whole, rtol=1e-12)
    links = [
        lissom.Link(name, parent=parent, rod=[piece])
        for name, parent, piece in zip("abc", (None, "a", "b"), pieces, strict=True)
    ]
    welded = lissom.Robot(links, contacts=[lissom.Contact(name, FLOOR, name=name) for name in "abc"])
    assert_allclose(welded._contact_stiffness(), whole, rtol=1e-12)


def test_space_and_plane_agree():
    everywhere = {"bend_y": 3, "bend_z": 3, "torsion": 1}
    assert_allclose(stiffness(cable(segment(modes=everywhere))), stiffness(cable()), rtol=1e-12)


@pytest.mark.parametrize(("length", "mass", "time"), [(1e3, 1e3, 1e3), (1e3, 1.0, 1.0), (1.0, 7.0, 0.3)])
def test_units_do_not_matter(length, mass, time):
    # Lengths in mm, masses in g, times in ms, ...: a stiffness per length is a pressure.
    pressure, force = mass / (length * time**2), mass * length / time**2
    floor = lissom.HalfSpace((0, 0, -0.1 * length))
    part = segment(LENGTH * length, RADIUS * length, E * pressure, DENSITY * mass / length**3)
    other = cable(
        part,
        contacts=[lissom.Contact("rod", floor)],
        gravity=(0, 0, -G * length / time**2),
        loads=[lissom.Load(force=(0, 2.0 * force, 0))],
    )
    one = cable(loads=[lissom.Load(force=(0, 2.0, 0))])
    assert_allclose(stiffness(other), stiffness(one) * pressure, rtol=1e-12)


def crossed(*, thin=RADIUS, apart=False):
    links = [
        lissom.Link("rod", rod=[segment()]),
        lissom.Link("other", position=(0, 0, -0.1), rod=[segment(1.0, thin)]),
    ]
    if apart:
        links.append(lissom.Link("far", position=(0, 9, 0), rod=[segment(5.0, 0.02)]))
    contacts = [lissom.Contact("rod", "other")]
    if apart:
        contacts.append(lissom.Contact("far", FLOOR))
    return lissom.Robot(links, contacts=contacts)


def test_two_rods_take_the_larger_force_and_the_smaller_radius():
    thin = 1e-3
    weight = WEIGHT + 2 * DENSITY * np.pi * thin**2 * 1.0 * G
    bending = max(BENDING, 7 * E * np.pi * thin**4 / 4)
    expected = needed(weight + bending, radius=thin)
    assert_allclose(stiffness(crossed(thin=thin)), expected, rtol=1e-6)
    # What hangs together with neither of them does not matter.
    assert_allclose(stiffness(crossed(thin=thin, apart=True)), expected, rtol=1e-6)
    both = [lissom.Contact("rod", "other", stiffness="material")]
    series = lissom.Robot(crossed().links, contacts=both)
    assert_allclose(stiffness(series), OF_MATERIAL / 2, rtol=1e-12)


def test_thin_obstacles_are_not_sunk_into():
    rail = lissom.Capsule((1, -1, -0.1), (1, 1, -0.1), RADIUS / 4)
    force = WEIGHT + BENDING
    d = 0.15 * RADIUS / 4
    expected = force / (4 / 3 * np.sqrt(2) * d**1.5 * np.sqrt(RADIUS))
    assert_allclose(stiffness(cable(contacts=[lissom.Contact("rod", rail)])), expected, rtol=1e-12)


def test_a_section_of_given_stiffness_needs_no_material():
    diagonal = [1e-1, E * INERTIA, E * INERTIA, 1e4, 1e4, 1e4]
    per_length = DENSITY * AREA
    section = lissom.Section.given(
        stiffness=diagonal, mass=per_length, inertia=np.array([2, 1, 1]) * DENSITY * INERTIA
    )
    given = lissom.Segment(LENGTH, section=section, modes={"bend_y": 3})
    # Its half extents are those of the ellipse with the same radii of gyration.
    assert_allclose(stiffness(cable(given)), needed(WEIGHT + BENDING), rtol=1e-6)
    with pytest.raises(ValueError, match=r"contacts\[0\]\.stiffness.*material"):
        cable(given, contacts=[lissom.Contact("rod", FLOOR, stiffness="material")])


@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_numbers_are_checked(value):
    with pytest.raises(ValueError, match="stiffness"):
        lissom.Contact("rod", FLOOR, stiffness=value)


def test_words_are_checked():
    with pytest.raises((TypeError, ValueError), match=r'stiffness: .*"?steel.*a number or .*material'):
        lissom.Contact("rod", FLOOR, stiffness="steel")
    with pytest.raises(TypeError, match="stiffness: expected a number or 'material'"):
        lissom.Contact("rod", FLOOR, stiffness=[1.0, 2.0])
    # Only rods have a material.
    with pytest.raises(ValueError, match="stiffness"):
        lissom.Contact(lissom.Ball("rod", 0.01), FLOOR, stiffness="material")


def test_scenes_say_it_as_python_does():
    text = """version = 1
[simulation]
t_end = 1.0
[[link]]
name = "rod"
[[link.rod.segment]]
length = 2.0
radius = 2e-3
young_modulus = 2e9
poisson_ratio = 0.3
density = 1500
modes = { bend_y = 3 }
retardation_time = 0.01
[[contact]]
a = "rod"
b = { kind = "half_space", point = [0, 0, -0.1] }
"""
    assert_allclose(stiffness(lissom.Scene.loads(text).model), stiffness(cable()), rtol=1e-12)
    material = lissom.Scene.loads(text + 'stiffness = "material"\n')
    assert_allclose(stiffness(material.model), OF_MATERIAL, rtol=1e-12)
    assert 'stiffness = "material"' in material.model.contacts[0].to_toml()
    with pytest.raises(lissom.SceneError, match="material"):
        lissom.Scene.loads(text + 'stiffness = "steel"\n')


UNKNOWN = {
    "support": {"supports": [lissom.Support(stiffness=100.0, position=(1.0, 0, -1.0), link="rod")]},
    "current": {"fluid": lissom.Fluid(1000.0, velocity=(0, 0, -1.0))},
    "magnet": {"magnets": [lissom.Magnet(link="rod", at=1.0, moment=(10.0, 0, 0))], "field": (0, 0, 3.0)},
}


@pytest.mark.parametrize("what", UNKNOWN)
def test_what_presses_as_hard_as_the_shape_makes_it_asks_for_the_material(what):
    assert_allclose(stiffness(cable(**UNKNOWN[what])), OF_MATERIAL, rtol=1e-12)


def test_springs_of_joints_ask_for_the_material():
    rail = lissom.Prismatic((0, 0, 1), stiffness=2e3)
    robot = lissom.Robot(
        [lissom.Link("rod", joint=rail, rod=[segment()])], contacts=[lissom.Contact("rod", FLOOR)]
    )
    assert_allclose(stiffness(robot), OF_MATERIAL, rtol=1e-12)


def test_where_a_rod_is_welded_on_at_its_tip_does_not_matter():
    half = segment(LENGTH / 2)
    found = [
        stiffness(
            lissom.Robot(
                [lissom.Link("rod", rod=[half]), lissom.Link("tip", parent="rod", at=at, rod=[half])],
                contacts=[lissom.Contact("rod", FLOOR)],
            )
        )
        for at in (None, LENGTH / 2)
    ]
    assert_allclose(found, stiffness(cable()), rtol=1e-9)


STIFF = np.diag([0.1, 0.1, 0.1, 1e4, 1e4, 1e4])


@pytest.mark.parametrize(
    ("inertia", "modes", "is_flat"),
    [
        ((0, 0, 0), {"bend_y": 2}, True),
        ((0, 0, 0), {"bend_y": 2, "bend_z": 2}, True),
        ((1e-5, 1e-5, 0), {"bend_y": 2}, False),
        ((1e-5, 0, 1e-5), {"bend_y": 2}, True),
        ((1e-5, 1e-5, 0), {"bend_y": 2, "bend_z": 2}, True),
        ((2e-5, 1e-5, 1e-5), {"bend_y": 2, "bend_z": 2}, False),
    ],
)
def test_sections_without_inertia_have_no_radius_to_touch_with(inertia, modes, is_flat):
    """In the plane, only the extent within it counts."""
    section = lissom.Section.given(STIFF, 0.1, inertia)
    thick = lissom.Section.given(STIFF, 0.1, (2e-5, 1e-5, 1e-5))
    rod = [
        lissom.Segment(0.25, section=thick, modes=modes),
        lissom.Segment(0.25, section=section, modes=modes),
    ]
    floor = lissom.Contact("finger", lissom.HalfSpace((0, 0, -0.05)), stiffness=1e4)
    links = [lissom.Link("finger", rod=rod)]
    if not is_flat:
        assert lissom.simulate(lissom.Robot(links, contacts=[floor]), 0.3, dt=1e-3).status == "finished"
        return
    message = r'contacts\[0\]\.a: got the rod of "finger", of which segments\[1\] has no radius.*`inertia`'
    with pytest.raises(ValueError, match=message):
        lissom.Robot(links, contacts=[floor])
    # A ball on it has a radius of its own, and what touches nothing needs none.
    tip = lissom.Contact(lissom.Ball("finger", 0.01), lissom.HalfSpace((0, 0, -0.05)), stiffness=1e3)
    assert lissom.Robot(links, contacts=[tip]).n > 0
    assert lissom.Robot(links).n > 0


def over_a_bar(segment, **law):
    bar = lissom.Capsule((0.15, -0.1, -0.03), (0.15, 0.1, -0.03), 0.02)
    return lissom.Rod([segment] * 3, contacts=[lissom.Contact("rod", bar, **law)])


def soft_cases():
    rubber = lissom.Segment(0.1, 5e-3, 1e6, poisson_ratio=0.45, density=1100, modes={"bend_y": 4})
    section = lissom.Section.given((1e-3,) * 3 + (1e3,) * 3, 0.1, inertia=(2e-6, 1e-6, 1e-6))
    given = lissom.Segment(0.1, section=section, modes={"bend_y": 4})
    ball = lissom.Link("ball", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(0.1))
    floor = lissom.HalfSpace((0, 0, -0.03))
    return {
        "rubber over a bar": lambda k: over_a_bar(rubber, stiffness=k),
        "rubber on a floor": lambda k: lissom.Rod(
            [rubber] * 3, contacts=[lissom.Contact("rod", floor, stiffness=k)]
        ),
        "cable by its stiffness": lambda k: over_a_bar(given, stiffness=k),
        "ball": lambda k: lissom.Robot(
            [ball], contacts=[lissom.Contact(lissom.Ball("ball", 0.02), floor, stiffness=k)]
        ),
    }


RAISE = re.compile(r"is soft for its load, .*: raise `stiffness` from (\S+) to (\S+) N/m")


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("stiffness", [1.0, 30.0])
@pytest.mark.parametrize("case", soft_cases())
def test_following_the_advice_to_raise_the_stiffness_once_is_enough(case, stiffness):
    """The overlap at which a run ends says too little of the forces: four rounds before."""
    make = soft_cases()[case]
    run = lissom.simulate(make(stiffness), 0.5, dt=2e-3)
    advised = RAISE.search(run.message)
    assert advised, run.message
    again = lissom.simulate(make(float(advised[2])), 0.5, dt=2e-3)
    assert again.status == "finished"
    assert "is soft" not in again.message
    assert "is stiff" not in again.message
    rest = lissom.statics(make(float(advised[2])))
    assert rest.success
    assert "is soft" not in rest.message


def test_given_sections_say_at_once_what_contact_needs():
    """Stiffness follows from known loads, once a section has a size; with unknown ones both are asked for."""
    bare = lissom.Section.given((1e-3,) * 3 + (1e3,) * 3, 0.1)
    sized = lissom.Section.given((1e-3,) * 3 + (1e3,) * 3, 0.1, inertia=(2e-6, 1e-6, 1e-6))
    segment = {
        name: lissom.Segment(0.1, section=each, modes={"bend_y": 4})
        for name, each in (("bare", bare), ("sized", sized))
    }
    with pytest.raises(ValueError, match=r"^contacts\[0\]\.a: .*without inertia, .*$"):
        over_a_bar(segment["bare"])
    assert lissom.statics(over_a_bar(segment["sized"]), space_error=False).success
    bar = lissom.Contact("rod", lissom.Capsule((0.15, -0.1, -0.03), (0.15, 0.1, -0.03), 0.02))
    spring = [lissom.Support(stiffness=10.0, at=0.1)]
    with pytest.raises(
        ValueError, match=r"contacts\[0\]\.stiffness: .*\n?.*contacts\[0\]\.a: .*without inertia"
    ):
        lissom.Rod([segment["bare"]], contacts=[bar], supports=spring)
    with pytest.raises(
        ValueError, match=r"^contacts\[0\]\.stiffness: got none, expected a number in N/m\^2.*$"
    ):
        lissom.Rod([segment["sized"]], contacts=[bar], supports=spring)
