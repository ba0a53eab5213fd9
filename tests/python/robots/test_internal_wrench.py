"""`Robot.strain` and `Robot.internal_wrench`, by balance and by the material, and their agreement."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from numpy.testing import assert_allclose
from scipy.special import eval_legendre
from test_robot import assert_close, fine

import lissom
from reference.random_robots import random_states, robots, seeds
from reference.robot import build

few = settings(max_examples=10)
LENGTH, RADIUS, DENSITY = 0.5, 0.02, 1000.0
MASS = DENSITY * np.pi * RADIUS**2


def segment(modes, **changes):
    arguments = {"young_modulus": 1e6, "poisson_ratio": 0.4, "density": DENSITY} | changes
    return lissom.Segment(LENGTH, RADIUS, modes=modes, **arguments)


def skew(R):
    return np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2


@few
@given(robots(), seeds)
def test_strains_are_how_poses_change_along_the_rod(description, seed):
    robot = fine(description)
    q = random_states(build(description), seed)[0]
    h = 1e-5
    for link in robot.links:
        if link.rod is None:
            continue
        X = 0.41 * sum(part.length for part in link.rod)
        below, here, beyond = robot.pose(q, [X - h, X, X + h], link=link.name)
        change = here[:3, :3].T @ (beyond - below)[:3] / (2 * h)
        expected = np.append(skew(change[:, :3]), change[:, 3])
        assert_allclose(
            robot.strain(q, X, link=link.name), expected, rtol=0, atol=1e-7 * (1 + np.abs(q).max())
        )


@few
@given(robots(), seeds)
def test_wrenches_are_those_of_the_reference(description, seed):
    reference, robot = build(description), fine(description)
    q, v, a = random_states(reference, seed)
    rods = [link.name for link in reference.links if link.rod]
    assume(rods)
    for name in rods:
        # Not where other links are attached: 0.37 and 0.5. At a free tip only rounding errors remain.
        places = np.array([0.42, 1.0]) * reference.length(name)
        expected = np.array([reference.internal_wrench(q, v, a, X, link=name) for X in places])
        assert_close(np.array([robot.internal_wrench(q, v, a, X, link=name) for X in places]), expected)


@few
@given(robots(), seeds)
def test_at_a_base_it_is_what_the_joint_passes_on(description, seed):
    reference, robot = build(description), build(description, lissom)
    q, v, a = random_states(reference, seed)
    for link in robot.links:
        if link.rod is None or not isinstance(link.joint, (lissom.Revolute, lissom.Spherical, lissom.Weld)):
            continue
        R = robot.pose(q, 0.0, link=link.name)[:3, :3]
        moment, force = robot.internal_wrench(q, v, a, 0.0, link=link.name).reshape(2, 3)
        wrench = robot.joint_wrench(q, v, a, link=link.name)
        assert_close(np.append(R @ moment, R @ force), wrench, 1e-10)


def test_loads_of_a_beam_are_summed_exactly():
    """A straight beam with weight and distributed loads on any parts, by textbook statics."""
    load, begin, end, point, at, weight = -3.0, 0.13, 0.37, -2.0, 0.29, MASS * 9.81
    rod = lissom.Rod(
        [segment({"bend_y": 1})],
        loads=[
            lissom.Load(force=(0, 0, load), along=(begin, end)),
            lissom.Load(force=(0, 0, point), at=at),
        ],
    )
    X = np.array([0.0, 0.05, begin, 0.2, at, 0.3, end, 0.45, LENGTH])
    wrench = rod.internal_wrench([0], [0], [0], X)
    # The part of the distributed load beyond X; a load exactly at X counts as beyond.
    rest, from_ = LENGTH - X, np.clip(X, begin, end)
    force = weight * rest - load * (end - from_) - point * (at >= X)
    about = -weight * rest**2 / 2 + load * (end - from_) * ((end + from_) / 2 - X)
    assert_allclose(wrench[:, 5], force, rtol=0, atol=1e-12)
    assert_allclose(wrench[:, 1], about + point * np.clip(at - X, 0, None), rtol=0, atol=1e-12)
    assert_allclose(np.delete(wrench, [1, 5], axis=1), 0, rtol=0, atol=1e-13)


def difference(rod, q, X, v=None, a=None):
    zeros = np.zeros(rod.n)
    v, a = zeros if v is None else v, zeros if a is None else a
    by = [rod.internal_wrench(q, v, a, X, by=by) for by in ("balance", "material")]
    return by[0] - by[1]


def test_both_laws_agree_as_modes_become_many():
    X = np.linspace(0, LENGTH, 21)
    errors = []
    for modes in (1, 2, 4, 8):
        # Its weight bends it by two radians.
        rod = lissom.Rod([segment({"bend_y": modes})])
        q = lissom.statics(rod, space_error=False).q
        size = np.abs(rod.internal_wrench(q, np.zeros(modes), np.zeros(modes), X)[:, 1]).max()
        errors.append(np.abs(difference(rod, q, X)[:, 1]).max() / size)
    assert errors[0] > 0.5
    assert all(after < before / 2 for before, after in pairwise(errors))
    assert errors[-1] < 1e-3


def test_modes_see_no_difference_between_the_laws():
    """In free motion the difference vanishes along all modes: both satisfy the same equations."""
    parts = {"bend_y": 3, "bend_z": 2, "torsion": 2, "stretch": 2}
    rod = lissom.Rod([segment(parts, retardation_time=0.02)], tip_force=(0.1, 0.3, -0.2), tip_mass=0.05)
    rng = np.random.default_rng(1)
    q, v = rng.normal(size=(2, rod.n)) * np.repeat([1, 1, 1, 0.05], [2, 3, 2, 2])
    a = rod.forward_dynamics(q, v)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    apart = difference(rod, q, LENGTH * (nodes + 1) / 2, v, a)
    size = np.abs(rod.internal_wrench(q, v, a, np.linspace(0, LENGTH, 9))).max(axis=0)
    assert np.abs(apart).max() > 1e-2 * size.max()
    for strain, modes in ((0, 2), (1, 3), (2, 2), (3, 2)):
        for k in range(modes):
            part = weights @ (eval_legendre(k, nodes) * apart[:, strain])
            assert abs(part) < 1e-10 * max(size[strain], 1e-3), (strain, k)


def test_the_material_knows_stiffness_damping_and_nothing_else():
    mu = 0.03
    section = lissom.Section.given(np.diag([1.0, 2.0, 3.0, 400.0, 50.0, 60.0]) + np.eye(6)[::-1] * 0.1, 0.2)
    part = lissom.Segment(LENGTH, modes={"bend_y": 2, "stretch": 1}, section=section, retardation_time=mu)
    rod = lissom.Rod([part], tip_force=(3.0, 2.0, 1.0))
    q, v = np.array([0.4, -0.2, 0.05]), np.array([1.0, 2.0, -0.3])
    X = 0.2
    here = 2 * X / LENGTH - 1
    strain = np.array([0, q[0] + here * q[1], 0, q[2], 0, 0])
    rate = np.array([0, v[0] + here * v[1], 0, v[2], 0, 0])
    expected = -part.stiffness(X) @ (strain + mu * rate)
    found = rod.internal_wrench(q, v, np.zeros(3), X, by="material")
    assert_allclose(found, expected, rtol=0, atol=1e-15 * 1e3)
    strain[3] += 1
    assert_allclose(rod.strain(q, X), strain, rtol=0, atol=1e-15)
    # Strains without modes are included by the balance only.
    assert found[5] == 0
    assert abs(rod.internal_wrench(q, v, np.zeros(3), X)[5]) > 0.5


def test_what_holds_a_rod_in_its_plane_passes_through_it():
    rod = lissom.Rod([segment({"bend_y": 2})], tip_force=(0, 2.0, 0), gravity=(0, 0, 0))
    assert rod.kernel == "planar"
    wrench = rod.internal_wrench(np.zeros(2), np.zeros(2), np.zeros(2), [0.0, 0.2])
    assert_allclose(wrench, [[0, 0, -2.0 * LENGTH, 0, -2, 0], [0, 0, -0.6, 0, -2, 0]], rtol=0, atol=1e-14)


def test_a_base_that_moves_is_felt_in_the_axes_of_the_section():
    """A rod that rotates about its own base is pulled inwards."""
    speed = 20.0
    turn = lissom.BaseMotion(axis=(0, 0, 1), angle=lambda t: speed * t)
    rod = lissom.Rod([segment({"bend_z": 2})], base_motion=turn, gravity=(0, 0, 0))
    zeros = np.zeros((2, 2))
    X = np.array([0.0, 0.3])
    wrench = rod.internal_wrench(zeros, zeros, zeros, X, t=[0.1, 0.4])
    assert wrench.shape == (2, 2, 6)
    expected = np.zeros((2, 6))
    expected[:, 3] = -MASS * speed**2 * (LENGTH**2 - X**2) / 2
    for at_time in wrench:
        assert_allclose(at_time, expected, rtol=0, atol=1e-6)


def test_joints_that_are_driven_are_felt():
    """The same rod, rotated by its joint."""
    speed = 20.0
    motion = lissom.Revolute((0, 0, 1), motion=lambda t: speed * t)
    link = lissom.Link("rod", rod=[segment({"bend_z": 2})], joint=motion)
    robot = lissom.Robot([link], gravity=(0, 0, 0))
    zeros = np.zeros(2)
    wrench = robot.internal_wrench(zeros, zeros, zeros, 0.3, t=0.4)
    assert_allclose(wrench[3], -MASS * speed**2 * (LENGTH**2 - 0.3**2) / 2, rtol=1e-8)
    assert_allclose(robot.strain([1.0, 0.0], 0.3)[2], 1.0, rtol=1e-15)


def test_many_states_and_places_at_once():
    rod = lissom.Rod([segment({"bend_y": 2, "stretch": 1}), segment({"bend_z": 2})])
    rng = np.random.default_rng(2)
    q, v, a = 0.1 * rng.normal(size=(3, 4, rod.n))
    X = [0.0, 0.5, 0.7]
    strains, wrenches = rod.strain(q, X), rod.internal_wrench(q, v, a, X)
    assert strains.shape == wrenches.shape == (4, 3, 6)
    assert_allclose(rod.strain(q, 0.7), strains[:, 2], rtol=0, atol=0)
    assert_allclose(rod.strain(q[1]), rod.strain(q[1], 1.0), rtol=0, atol=0)
    assert_allclose(rod.internal_wrench(q[3], v[3], a[3], 0.5), wrenches[3, 1], rtol=0, atol=1e-15)
    # Between segments, the strain is that of the first one.
    assert strains[0, 1, 2] == 0
    assert rod.strain(q[0], np.nextafter(0.5, 1))[2] != 0
    assert rod.strain(np.zeros((0, rod.n)), X).shape == (0, 3, 6)


RIGID = lissom.Robot(
    [
        lissom.Link("arm", body=lissom.Body(1.0, centre=(1, 0, 0)), joint=lissom.Revolute((0, 1, 0))),
        lissom.Link("soft", rod=[segment({"bend_y": 1})], parent="arm"),
    ]
)
REFUSED = {
    "link: got none, expected one of the links": {"link": None},
    "link: got 'sof', expected one of the links: 'arm', 'soft'; did you mean 'soft'": {"link": "sof"},
    "link: 'arm' has no rod, expected a link with a rod: 'soft'": {"link": "arm"},
    r"X: got 0.6, expected an arc length in \[0, 0.5\]": {"link": "soft", "X": 0.6},
    r"X: got NaN|X: got nan": {"link": "soft", "X": np.nan},
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_no_section_is_refused(message):
    with pytest.raises(ValueError, match=message):
        RIGID.strain([0, 0], **REFUSED[message])
    with pytest.raises(ValueError, match=message):
        RIGID.internal_wrench([0, 0], [0, 0], [0, 0], **REFUSED[message])


def test_other_arguments_are_checked():
    states = [[0, 0]] * 3
    with pytest.raises(ValueError, match='by: got "stress", expected "balance" or "material"'):
        RIGID.internal_wrench(*states, link="soft", by="stress")
    with pytest.raises(ValueError, match="qd"):
        RIGID.internal_wrench([0, 0], [[0, 0]], [0, 0], link="soft")
    with pytest.raises(ValueError, match=r"q\[0\]"):
        RIGID.strain([np.nan, 0], link="soft")
    only_rigid = lissom.Robot([lissom.Link("arm", body=lissom.Body(1.0), joint=lissom.Prismatic((0, 1, 0)))])
    with pytest.raises(ValueError, match="but no link has one"):
        only_rigid.strain([0.0])


def muscle(strain, shape, amount=1.0, modes=None):
    part = segment(modes or {"bend_y": 4, "stretch": 3})
    active = lissom.ActiveStrain(None, strain, shape, amount)
    return lissom.Rod([part, part], gravity=(0, 0, 0), actuators=[active])


@pytest.mark.parametrize(("strain", "entry"), [("bend_y", 1), ("stretch", 3)])
@pytest.mark.parametrize("shape", [0.4, (0.1, 0.3)])
def test_a_muscle_that_nothing_resists_leaves_the_material_free(strain, entry, shape):
    rod = muscle(strain, shape)
    found = lissom.statics(rod)
    rest = np.zeros(rod.n)
    X = np.linspace(0.0, 2 * LENGTH, 9)
    assert np.abs(rod.strain(found.q, X)[:, entry]).max() > 0.09
    for by in ("balance", "material"):
        assert_allclose(rod.internal_wrench(found.q, rest, rest, X, by=by), 0.0, rtol=0, atol=1e-9)


def test_a_muscle_that_may_not_move_presses_by_its_stiffness():
    amount = lissom.Input("amount", 0.5)
    rod = muscle("bend_y", (0.0, 2.0), amount)
    rest = np.zeros(rod.n)
    bending = 1e6 * np.pi / 4 * RADIUS**4
    X = np.array([0.0, 0.3, LENGTH, 0.9])
    for u in (0.5, -2.0):
        found = rod.internal_wrench(rest, rest, rest, X, by="material", u=[u])
        assert_allclose(found[:, 1], bending * u * 2.0 * X / (2 * LENGTH), rtol=1e-10, atol=1e-15)
        assert_allclose(np.delete(found, 1, axis=1), 0.0, atol=1e-12)


def test_what_a_tendon_and_a_chamber_pass_on_is_in_the_balance_alone():
    offset, tension, pressure, area = 0.01, 3.0, 2e4, 1e-4
    path = [lissom.Along(offset=(0, offset))]
    for actuator, force in (
        (lissom.Tendon("it", path, tension=tension), -tension),
        (lissom.Chamber("it", path, area, pressure), pressure * area),
    ):
        rod = lissom.Rod([segment({"bend_y": 1, "stretch": 1})], gravity=(0, 0, 0), actuators=[actuator])
        q = lissom.statics(rod).q
        rest = np.zeros(rod.n)
        balance, material = (rod.internal_wrench(q, rest, rest, 0.2, by=by) for by in ("balance", "material"))
        passed = balance - material
        assert_allclose(balance, 0.0, atol=1e-9)
        # A parallel actuator with one strain: its force at its offset.
        assert_allclose(passed[[1, 3]], [offset * force, force], rtol=1e-9)


# Contact


def hose(name="rod", length=LENGTH, **place):
    modes = {"torsion": 2, "bend_y": 3, "bend_z": 3, "stretch": 1, "shear_y": 1, "shear_z": 1}
    part = lissom.Segment(
        length, 8e-3, modes=modes, young_modulus=2e6, poisson_ratio=0.4, density=DENSITY, nodes=24
    )
    return lissom.Link(name, rod=[part], **place)


LAW = {"stiffness": 2e4, "dissipation": 0.3, "friction": 0.4}
BASE = lissom.BaseMotion(translation=lambda t: (0.1 * np.sin(5 * t), 0.0, 0.2 * np.cos(3 * t)))
TOUCHED = {
    "floor": {"contacts": [lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.03), (0.1, 0, 1)), **LAW)]},
    "box": {"contacts": [lissom.Contact("rod", lissom.Box((0.3, 0, -0.05), (0.1, 0.2, 0.05)), **LAW)]},
    "other rod": {
        "links": [
            hose(),
            hose("other", position=(0.25, -0.2, 0.0), orientation=(np.sqrt(0.5), 0, 0, np.sqrt(0.5))),
        ],
        "contacts": [lissom.Contact("other", "rod", **LAW)],
    },
    "ball": {
        "links": [hose(), lissom.Link("ball", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(0.1))],
        "contacts": [lissom.Contact(lissom.Ball("ball", 0.3, position=(0.2, 0, 0)), "rod", **LAW)],
    },
    "moving base": {
        "contacts": [lissom.Contact("rod", lissom.HalfSpace((0, 0, 0.15)), **LAW)],
        "base_motion": BASE,
    },
}


def panels(kinks, points=16):
    """Places and weights that integrate along the rod, between places where the integrand is not smooth."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    kinks = np.array(sorted(kinks))
    half = 0.5 * np.diff(kinks)[:, None]
    return (kinks[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


#: What is spread by contact is smooth between places that are not told: fine enough for the tolerances.
FINE = np.linspace(0.0, LENGTH, 401)


@pytest.mark.parametrize("case", TOUCHED)
def test_pressure_and_friction_along_a_rod_are_part_of_the_balance(case):
    """With and without contact the wrench of a motion differs by what presses on everything beyond."""
    parts = {"links": [hose()]} | TOUCHED[case]
    links, contacts = parts.pop("links"), parts.pop("contacts")
    robot, bare = lissom.Robot(links, contacts=contacts, **parts), lissom.Robot(links, **parts)
    is_first, t = contacts[0].a == "rod", 0.3
    number = 0
    for seed in range(5):
        random = np.random.default_rng(seed)
        q, v, a = 0.3 * random.normal(size=(3, robot.n))
        touches = robot.touches(q, v, t=t)
        touched = [touch.along[0 if is_first else 1] for touch in touches]
        number += len(touches)
        scale = sum(np.linalg.norm(touch.force) for touch in touches)
        moment = np.zeros(3)
        for X in (0.0, LENGTH):
            pose = robot.pose(q, X, link="rod", t=t)
            R, place = pose[:3, :3], pose[:3, 3]
            expected = np.zeros(6)
            for touch, at in zip(touches, touched, strict=True):
                if at >= X:
                    # Each surface is pressed on at its own place.
                    force, on = touch.force, touch.position
                    if not is_first:
                        force, on = -force, on + touch.overlap * touch.normal
                    expected -= np.append(R.T @ np.cross(on - place, force), R.T @ force)
                    moment -= at * force
            change = np.subtract(
                *(model.internal_wrench(q, v, a, X, link="rod", t=t) for model in (robot, bare))
            )
            assert_allclose(change, expected, rtol=0, atol=1e-9 * (1 + scale))
        # Forces beyond cuts have the moment of what touches: int_0^L F(X) dX = sum_i s_i f_i.
        # Along the second rod they lie in the shadow of the first one, which is straight between two places.
        X, weights = panels(FINE, 4)
        change = np.subtract(*(model.internal_wrench(q, v, a, X, link="rod", t=t) for model in (robot, bare)))
        turned = robot.pose(q, X, link="rod", t=t)[:, :3, :3]
        integral = weights @ np.einsum("kij,kj->ki", turned, change[:, 3:])
        assert_allclose(integral, moment, rtol=0, atol=(1e-6 if is_first else 1e-5) * LENGTH * scale)
    assert number > 0


def rod_in(**parts):
    return lissom.Robot([hose()], **parts)


LOADS = [
    lissom.Load(link="rod", force=(0.1, 0.2, -0.3), moment=(0.01, 0.02, 0.03), at=0.23),
    lissom.Load(link="rod", force=(0.1, 0.2, -0.3), moment=(0.01, 0.02, 0.03), at=0.11, frame="body"),
    lissom.Load(link="rod", force=(0.5, 0.2, -0.3), along=(0.1, 0.3)),
    lissom.Load(link="rod", force=lambda t: (0.0, np.sin(9 * t), 0.2)),
]
OUTSIDE = [lissom.Via(None, (0, 0.1, 0.05)), lissom.Via("rod", (0, 0, 0.01), at=0.31)]
EFFECTS = {
    "nothing": rod_in(),
    "loads": rod_in(loads=LOADS),
    "supports": rod_in(supports=[lissom.Support(link="rod", at=0.2, stiffness=30.0, rotational_damping=0.1)]),
    "fluid": rod_in(fluid=lissom.Fluid(1000.0, velocity=(0.1, 0.2, 0.3))),
    "body": rod_in(bodies=[lissom.Body(0.05, link="rod", at=0.17, inertia=np.eye(3) * 1e-5)]),
    "base motion": rod_in(base_motion=BASE),
    "tendon outside": rod_in(actuators=[lissom.Tendon("t", OUTSIDE, tension=2.0, friction=0.0)]),
} | {f"contact with {case}": lissom.Robot(**({"links": [hose()]} | parts)) for case, parts in TOUCHED.items()}


@pytest.mark.parametrize("case", EFFECTS)
def test_balance_and_material_differ_by_what_drives_the_modes(case):
    """Principle of virtual work: weighted with the modes, balance minus material is the residual of the
    equations of motion. No cut of the rod may leave out anything."""
    robot, t = EFFECTS[case], 0.3
    is_touched = case.startswith("contact")
    for seed in range(2):
        random = np.random.default_rng(seed)
        q, v, a = 0.3 * random.normal(size=(3, robot.n))
        kinks = {0.0, 0.1, 0.11, 0.17, 0.2, 0.23, 0.3, 0.31, LENGTH}
        for touch in robot.touches(q, v, t=t):
            kinks |= {at for at in touch.along if at is not None}
        X, weights = panels(kinks | set(FINE), 4) if is_touched else panels(kinks)
        balance, material = (
            robot.internal_wrench(q, v, a, X, link="rod", t=t, by=by) for by in ("balance", "material")
        )
        found = [
            weights * eval_legendre(degree, 2 * X / LENGTH - 1) @ (balance - material)[:, strain]
            for strain, modes in enumerate([2, 3, 3, 1, 1, 1])
            for degree in range(modes)
        ]
        first = robot.coordinates.index("rod.torsion_0") if "rod.torsion_0" in robot.coordinates else 0
        expected = robot.inverse_dynamics(q, v, a, t=t)[first : first + len(found)]
        # Forces of contact are integrated with the modes by the rule that presses, to its order.
        tolerance = 3e-7 if is_touched else 1e-9
        assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max())
