"""Equilibria against closed forms, and balances of forces computed here from poses.

Far starts, sizes and units that must not matter, bodies on cords and pins, slack lines.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import lissom

GRAVITY = 9.81


def rotation(v):
    """The rotation matrix of a rotation vector (Rodrigues)."""
    t = np.linalg.norm(v)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if t < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(t) / t * k + (1 - np.cos(t)) / t**2 * k @ k


def on_ball_joint(rng, kind):
    """A body on a ball joint with a dead force at a point; and what moment is left about the joint."""
    centre, force, point = rng.normal(size=3) * 0.3, rng.normal(size=3) * 10, rng.normal(size=3)
    stiffness, anchor = rng.uniform(5, 50), rng.normal(size=3)
    body = lissom.Body(1.0, centre=centre, inertia=np.diag(rng.uniform(0.3, 0.4, 3)))
    links = [
        lissom.Link("b", joint=lissom.Spherical(), body=body),
        lissom.Link("tip", parent="b", position=point, body=lissom.Body(1e-9)),
    ]
    more = {}
    if kind == "contact":
        floor = lissom.HalfSpace((0, 0, -50.0))
        more["contacts"] = [lissom.Contact(lissom.Ball("b", 0.01), floor, stiffness=1e4)]
    if kind == "support":
        more["supports"] = [lissom.Support(stiffness=stiffness, position=anchor, link="tip")]
    robot = lissom.Robot(links, loads=[lissom.Load(force=force, link="tip")], **more)

    def moment(q):
        turned = rotation(q)
        x = turned @ point
        at_point = force + (stiffness * (anchor - x) if kind == "support" else 0)
        return np.cross(turned @ centre, (0, 0, -GRAVITY)) + np.cross(x, at_point)

    return robot, moment


@pytest.mark.parametrize("kind", ["contact", "support", "free"])
@pytest.mark.parametrize("method", ["descent", "newton"])
def test_moments_balance_however_far_a_ball_joint_is_turned_at_the_start(kind, method):
    rng = np.random.default_rng(5)
    for _ in range(12):
        robot, moment = on_ball_joint(rng, kind)
        q0 = rng.normal(size=3)
        q0 *= rng.uniform(3, 7) / np.linalg.norm(q0)
        found = lissom.statics(robot, q0, method=method)
        assert found.success, found.message
        assert np.linalg.norm(moment(found.q)) < 1e-6
        assert np.linalg.norm(found.q) <= np.pi + 1e-12


def rail(centre=0.0, stiffness=1000.0, length=1.0, mass=1.0):
    body = lissom.Body(mass, centre=(0, 0, centre))
    link = lissom.Link("a", position=(0, 0, 3), joint=lissom.Prismatic((0, 0, 1)), body=body)
    cable = lissom.Tendon(
        "cable", [lissom.Via(None, (0, 0, 5)), lissom.Via("a", (0, 0, 0))], length=length, stiffness=stiffness
    )
    return lissom.Robot([link], actuators=[cable])


@pytest.mark.parametrize("centre", [0, 1e-6, 1e-4, 1e-3, 5e-3, 0.01, 0.1])
def test_body_on_a_rail_hangs_on_its_cable_wherever_its_centre_of_mass_is(centre):
    found = lissom.statics(rail(centre))
    assert found.success
    assert found.nit < 20
    assert abs(found.q[0] - (1 - GRAVITY / 1000)) < 1e-12


@pytest.mark.parametrize("slack", [0, 1e-8, 1e-6, 1e-4, 0.01, 0.1, 1, 10])
def test_body_on_a_rail_falls_into_its_rope_however_slack(slack):
    found = lissom.statics(rail(stiffness=None), [1.0 + slack])
    assert found.success
    assert found.nit < 30
    assert abs(found.q[0] - 1) < 1e-9


@pytest.mark.parametrize(("length", "mass"), [(1, 1), (1e3, 1), (1e-3, 1), (1, 1e-3), (1e3, 1e3)])
def test_a_rope_holds_in_all_units(length, mass):
    link = lissom.Link(
        "a", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(mass, inertia=np.eye(3) * mass * length**2)
    )
    rope = lissom.Tendon(
        "rope", [lissom.Via(None, (0, 0, 2 * length)), lissom.Via("a", (0, 0, 0))], length=length
    )
    robot = lissom.Robot([link], actuators=[rope], gravity=(0, 0, -GRAVITY * length))
    found = lissom.statics(robot, [1.3 * length])
    assert found.success, found.message
    assert abs(found.q[0] / length - 1) < 1e-9


def test_nothing_holds_a_free_rail():
    link = lissom.Link("a", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(1.0))
    found = lissom.statics(lissom.Robot([link]))
    assert not found.success
    assert found.status == "unheld"
    assert "Nothing holds the model" in found.message


CORNERS = [(0.5, 0.5), (-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5)]


def box(centre=(0, 0, 0), inertia=0.1):
    return lissom.Link(
        "box", joint=lissom.Free(), body=lissom.Body(1.0, centre=centre, inertia=np.eye(3) * inertia)
    )


def cords(ends, length, stiffness=None):
    return [
        lissom.Tendon(
            f"t{i}", [lissom.Via(None, a), lissom.Via("box", b)], length=length, stiffness=stiffness
        )
        for i, (a, b) in enumerate(ends)
    ]


@pytest.mark.parametrize("number", [1, 2, 3, 4])
@pytest.mark.parametrize("height", [1, 1.001, 1.3])
@pytest.mark.parametrize("depth", [0, 1e-6, 0.1])
def test_weight_hangs_on_ropes(number, height, depth):
    ends = [((x, y, 2), (x, y, 0)) for x, y in CORNERS[:number]]
    robot = lissom.Robot([box((0, 0, -depth), 1.0)], actuators=cords(ends, 1.0))
    found = lissom.statics(robot, [0, 0, height, 0, 0, 0])
    assert found.success, found.message
    x, turned = found.q[:3], rotation(found.q[3:])
    taut = []
    for a, b in ends:
        line = np.array(a) - (x + turned @ b)
        assert np.linalg.norm(line) < 1 + 1e-9
        if np.linalg.norm(line) > 1 - 1e-8:
            taut.append(np.r_[line, np.cross(turned @ b, line)])
    weight = np.r_[0, 0, -GRAVITY, np.cross(turned @ (0, 0, -depth), (0, 0, -GRAVITY))]
    tensions = np.linalg.lstsq(np.array(taut).T, -weight, rcond=1e-7)[0]
    assert np.abs(np.array(taut).T @ tensions + weight).max() < 1e-6


@pytest.mark.parametrize("stiffness", [1e2, 1e4, 1e6, 1e8, 1e10, 1e12])
def test_platform_on_four_cables_of_any_stiffness(stiffness):
    ends = [((2 * x, 2 * y, 3), (x, y, 0)) for x, y in CORNERS]
    robot = lissom.Robot([box((0, 0, -0.1))], actuators=cords(ends, 2.0, stiffness))
    found = lissom.statics(robot, [0.1, 0, 1.0, 0.1, 0.2, 0.3])

    def lift(h):
        length = np.sqrt(0.5 + h * h)
        return 4 * stiffness * (length - 2) * h / length - GRAVITY

    assert found.success, found.message
    assert abs(found.q[2] - (3 - brentq(lift, np.sqrt(3.5), 3, xtol=1e-14))) < 1e-9
    assert np.abs(np.delete(found.q, 2)).max() < 1e-6


@pytest.mark.parametrize("distance", [0.1, 1, 10])
@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.1])
def test_body_hangs_on_a_pin(distance, depth):
    closed = lissom.Loop("box", (None, None, (0, 0, distance)), lissom.Spherical())
    robot = lissom.Robot([box((0, 0, depth), 0.01)], loops=[closed])
    found = lissom.statics(robot)
    assert found.success, found.message
    assert np.abs(found.q[:3] - (0, 0, distance)).max() < 1e-9 * distance
    assert np.linalg.norm(np.cross(rotation(found.q[3:])[:, 2], (0, 0, 1))) < 1e-6


@pytest.mark.parametrize("beside", [0.3, 1, 3, 100])
def test_another_rod_beside_it_is_nothing_to_a_pinned_finger(beside):
    def robot(*others):
        finger = lissom.Link("finger", rod=[lissom.Segment(0.1, 5e-3, 1e6, 4e5, 1000, modes={"bend_y": 4})])
        return lissom.Robot(
            [finger, *others],
            loops=[lissom.Loop("finger", (None, None, (0.05, 0, 0.06)), lissom.Spherical())],
        )

    alone = lissom.statics(robot())
    rod = [lissom.Segment(beside, 5e-3 * beside, 1e6, 4e5, 1e-9, modes={"bend_y": 2})]
    found = lissom.statics(robot(lissom.Link("other", position=(0, 1, 0), rod=rod)))
    assert alone.success
    assert found.success, found.message
    assert found.njev <= alone.njev + 5
    np.testing.assert_allclose(found.q[:4], alone.q, rtol=1e-5)


def line(length, stiffness, weight, ratio, end, segments):
    """A heavy line of this axial stiffness with `E I = E A L^2 / ratio`, hinged at both ends."""
    bending = stiffness * length**2 / ratio
    section = lissom.Section.given(
        np.diag([bending] * 3 + [stiffness] * 3),
        mass=weight / GRAVITY,
        inertia=np.array([2, 1, 1]) * 1e-4 * weight / GRAVITY,
    )
    hinge = lissom.Revolute((0, 1, 0))
    segment = lissom.Segment(length / segments, section=section, modes={"bend_y": 2, "stretch": 1})
    links = [lissom.Link("line", joint=hinge, rod=[segment] * segments)]
    return lissom.Robot(links, loops=[lissom.Loop("line", (None, None, end), hinge)])


def pull(robot, q):
    rest = np.zeros(robot.n)
    return robot.loop_forces(q, rest, rest)[3:]


@pytest.mark.parametrize("ratio", [1e10, 1e12])
@pytest.mark.parametrize("chord", [0.5, 0.8, 0.97])
def test_a_slack_line_from_straight_is_the_elastic_catenary(ratio, chord):
    length, weight, stiffness = 10.0, 1.0, 1e4
    robot = line(length, stiffness, weight, ratio, (chord * length, 0, 0), 10)
    found = lissom.statics(robot)
    assert found.success, found.message

    def miss(h):
        return 2 * h / weight * np.arcsinh(weight * length / 2 / h) + h / stiffness * length - chord * length

    horizontal = brentq(miss, 1e-9, 1e3)
    assert abs(abs(pull(robot, found.q)[0]) / horizontal - 1) < 2e-3


@pytest.mark.parametrize("size", [1e-2, 100.0])
@pytest.mark.parametrize("angle", [-70, -60, -40, -15, 15, 40, 60, 70])
def test_a_slack_line_hangs_without_a_curl_wherever_its_other_end_is(angle, size):
    """Laid out straight along x, at first: its other end is above, or below. What does not stretch hangs in a
    catenary of parameter a, sqrt(l^2 - z^2) = 2 a sinh(x / 2 a)."""
    x, z = 0.7 * size * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    robot = line(size, 1e5, 1.0 / size, 1e12, (x, 0, z), 20)
    found = lissom.statics(robot)
    assert found.success, found.message
    span = np.sqrt(size**2 - z**2)
    a = brentq(lambda a: 2 * a * np.sinh(x / 2 / a) - span, x / 1000, 1000 * x)
    assert abs(pull(robot, found.q)[0]) == pytest.approx(a / size, rel=2e-3)
    turned = robot.pose(found.q, np.linspace(0, size, 401), link="line")[:, :3, 0]
    heading = np.unwrap(np.arctan2(turned[:, 2], turned[:, 0]))
    assert abs(heading[-1] - heading[0]) < np.pi


def test_published_line_of_moorpy():
    robot = line(130.0, 7.51e8, 881.05, 1e12, (89.9, 0, 59.2), 20)
    found = lissom.statics(robot)
    assert found.success, found.message
    np.testing.assert_allclose(np.abs(pull(robot, found.q)[[0, 2]]), [31373.229006, 87886.158730], rtol=1e-5)


@pytest.mark.parametrize("stiffness", [1e-14, 1e-10, 1e-6, 1e-4, 1e-2, 1.0, 100.0])
def test_a_soft_spring_does_not_wind(stiffness):
    """A body that falls against a spring comes to rest below its hinge, without winding the spring up."""
    body = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=np.eye(3) * 0.01)
    joint = lissom.Revolute((0, 1, 0), stiffness=stiffness)
    found = lissom.statics(lissom.Robot([lissom.Link("a", joint=joint, body=body)]))
    assert found.success, found.message
    wanted = brentq(lambda q: stiffness * q - 0.5 * GRAVITY * np.cos(q), 0, np.pi / 2, xtol=1e-14)
    np.testing.assert_allclose(found.q, wanted, rtol=1e-9)


def two_bars(*end):
    """Two equal bars in a row whose end is hinged to a place of the world."""
    hinge, body = lissom.Revolute((0, 1, 0)), lissom.Body(1.0, centre=(0.5, 0, 0), inertia=np.eye(3) * 0.01)
    links = [
        lissom.Link("a", joint=hinge, body=body),
        lissom.Link("b", parent="a", position=(1, 0, 0), joint=hinge, body=body),
    ]
    return lissom.Robot(links, loops=[lissom.Loop(("b", None, (1, 0, 0)), (None, None, end), hinge)])


@pytest.mark.parametrize("q0", [None, [0.0, 0.0], [0.4, 0.3], [0.3, np.pi]])
def test_arms_that_just_reach_stay_closed(q0):
    """Stretched arms are closed in one shape alone, in which rows of the loop depend on each other."""
    robot = two_bars(2, 0, 0)
    found = lissom.statics(robot, q0)
    assert found.status != "loop_open"
    assert np.abs(robot.loop_gaps(found.q)).max() < 1e-7
    assert abs(np.sin(found.q)).max() < 1e-3


def straight_rope(unit, slack):
    """Without stretch and across its weight, between pins nearer than its length by this part of it."""
    segment = lissom.Segment(
        unit, 2e-3 * unit, 1e8, 4e7, 1000, modes={"torsion": 1, "bend_y": 4, "bend_z": 3}
    )
    end = (unit * (1 - slack), 0, 0)
    return lissom.Robot(
        [lissom.Link("rope", joint=lissom.Spherical(), rod=[segment])],
        loops=[lissom.Loop(("rope",), (None, None, end), lissom.Spherical())],
    )


def body_between_ropes(unit, slack):
    """On two ropes in a row, shorter than the distance of their pins from it by this part of it."""
    body = lissom.Body(1.0, inertia=np.eye(3) * 0.01 * unit**2)
    ropes = [
        lissom.Tendon(
            name, [lissom.Via(None, (x * unit, 0, 0)), lissom.Via("b", (0, 0, 0))], length=(1 + slack) * unit
        )
        for name, x in (("left", -1), ("right", 1))
    ]
    return lissom.Robot([lissom.Link("b", joint=lissom.Free(), body=body)], actuators=ropes)


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("make", [straight_rope, body_between_ropes, lambda *_: two_bars(2, 0, 0)])
def test_nothing_straight_carries_a_weight_across(make, unit):
    """Its tension would be infinite: what hangs through by a little is open by the square of that."""
    robot = make(unit, 0.0)
    for start in (None, np.zeros(robot.n)):
        found = lissom.statics(robot, start)
        assert not found.success
        assert found.stability is None


@pytest.mark.parametrize("make", [straight_rope, body_between_ropes])
@pytest.mark.parametrize("slack", [1e-4, 1e-6, 1e-8])
def test_what_hangs_through_a_little_carries_it(make, slack):
    robot = make(1.0, slack)
    found = lissom.statics(robot, np.zeros(robot.n))
    assert found.success, found.message
    # A parabola of this length, or the two sides of a triangle.
    sag = np.sqrt(3 / 8 * slack) if make is straight_rope else np.sqrt(2 * slack)
    place = robot.pose(found.q, 0.5)[2, 3] if make is straight_rope else found.q[2]
    assert place == pytest.approx(-sag, rel=0.02)


@pytest.mark.parametrize("q0", [[0.0, 0.0], [0.3, 0.0], [1e-6, 0.0], [0.85, 0.53], [-0.85, -0.53]])
def test_bars_that_fold_back_onto_each_other_are_closed(q0):
    """On the way there no motion closes both components of the gap at once."""
    robot = two_bars(0, 0, 0)
    found = lissom.simulate(robot, 1e-6, q0=q0, dt=1e-6)
    assert np.abs(robot.loop_gaps(found.q[0])).max() < 1e-9
    assert abs(np.cos(found.q[0][1]) + 1) < 1e-9


@pytest.mark.parametrize("normals", [[(0, 0, 1)], [(0, -1, 1), (0, 1, 1)]], ids=["floor", "groove"])
@pytest.mark.parametrize(("radius", "young"), [(5e-4, 2e11), (2e-4, 2e11), (5e-3, 5e7)])
def test_wires_come_to_rest_on_the_ground_however_thin(radius, young, normals):
    density = 1500.0
    weight = density * 9.81 * np.pi * radius**2
    length = 7 * (young * np.pi * radius**4 / 4 / weight) ** (1 / 3)
    modes = {"torsion": 2, "bend_y": 4, "bend_z": 4}
    segment = lissom.Segment(length / 4, radius, young, young / 2.8, density, modes)

    def wire(stiffness=None):
        grounds = [lissom.HalfSpace((0, 0, -0.15 * length), normal) for normal in normals]
        return lissom.Robot(
            [lissom.Link("wire", rod=[segment] * 4, position=(0, 0.05 * length * (len(normals) - 1), 0))],
            contacts=[
                lissom.Contact("wire", ground, stiffness=stiffness, name=f"ground {i}")
                for i, ground in enumerate(grounds)
            ],
        )

    robot = wire()
    found = lissom.statics(robot, space_error=False)
    assert found.success, found.message
    assert found.njev < 200
    # By another way: surfaces as soft as the wire is light, then stiffer ones.
    q = None
    for stiffness in (weight / radius, 30 * weight / radius, 1e3 * weight / radius, None):
        q = lissom.statics(wire(stiffness), q, space_error=False).q
    energies = [robot.energy(q, 0 * q) for q in (q, found.q)]
    totals = [energy.elastic + energy.gravitational for energy in energies]
    np.testing.assert_allclose(totals[1], totals[0], rtol=1e-5)
