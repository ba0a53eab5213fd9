"""Where searches and paths begin and end: beside stiff parts that nothing couples, along orbits, at kinks.

Beside closed forms, the same case turned, or the same case without the part that nothing couples.
"""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import lissom
from lissom import Link, Revolute

GRAVITY = 9.81
HINGE = lissom.Revolute((0, 1, 0))


def four_bars():
    spring = lissom.Revolute((0, 1, 0), stiffness=0.5, rest=0.3)
    body = lissom.Body(0.1, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 4e-4, 4e-4]))
    links = [
        lissom.Link("crank", joint=spring, body=body),
        lissom.Link("rod", parent="crank", position=(0.2, 0, 0), joint=HINGE, body=body),
        lissom.Link("rocker", parent="rod", position=(0.2, 0, 0), joint=HINGE, body=body),
    ]
    return links, {"loops": [lissom.Loop(("rocker", None, (0.2, 0, 0)), (None, None, (0.25, 0, 0)), HINGE)]}


def pinned(joint, modes, end, radius=0.01, segments=1, young_modulus=1e7, density=1000.0):
    segment = lissom.Segment(1 / segments, radius, young_modulus, 0.4 * young_modulus, density, modes)
    link = lissom.Link("arch", joint=joint, rod=[segment] * segments)
    return [link], {"loops": [lissom.Loop(("arch",), (None, None, end), lissom.Spherical())]}


def on_tendons():
    segment = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {"bend_y": 4, "bend_z": 4, "stretch": 1})
    tendons = [
        lissom.Tendon("along", [lissom.Along("rod", (0, 0.008))], length=0.28),
        lissom.Tendon(
            "aside", [lissom.Via("rod", (0, 0, 0)), lissom.Via(None, (0.3, 0.3, 0.1))], length=0.25
        ),
    ]
    return [lissom.Link("rod", rod=[segment])], {"actuators": tendons}


def apart(part):
    place = {"position": (50, 0, 0)}
    if part == "heavy":
        body = lissom.Body(1e6, centre=(0, 0, -0.1), inertia=np.eye(3) * 1e4)
        return lissom.Link("apart", joint=lissom.Revolute((0, 1, 0), stiffness=10.0), body=body, **place)
    return lissom.Link(
        "apart", joint=lissom.Prismatic((0, 0, 1), stiffness=part), body=lissom.Body(1.0), **place
    )


@pytest.mark.parametrize("part", ["heavy", 1e2, 1e6, 1e8, 1e10, 1e12])
@pytest.mark.parametrize("case", ["four bars", "arch", "rope", "tendons"])
def test_paths_do_not_depend_on_parts_that_nothing_couples(case, part):
    links, more = {
        "four bars": four_bars,
        "arch": lambda: pinned(HINGE, {"bend_y": 8}, (0.7, 0, 0)),
        "rope": lambda: pinned(
            lissom.Spherical(), {"bend_y": 3, "bend_z": 3, "stretch": 2}, (0.8, 0, 0.1), 1e-3, 4
        ),
        "tendons": on_tendons,
    }[case]()
    alone = lissom.continuation(lissom.Robot(links, **more))
    beside = lissom.continuation(lissom.Robot([*links, apart(part)], **more))
    assert alone.success, alone.message
    assert beside.success, beside.message
    n = alone.path.q.shape[1]
    sizes = np.maximum(1.0, np.abs(alone.path.q[-1]))
    np.testing.assert_allclose(beside.path.q[-1, :n] / sizes, alone.path.q[-1] / sizes, atol=1e-6)
    assert beside.path.stability[-1] == alone.path.stability[-1]


@pytest.mark.parametrize("axial", [1e4, 1e6, 1e7, 1e8, 1e10])
def test_paths_of_arches_that_hardly_stretch(axial):
    # E I is the same in all: the radius follows from E A.
    bending = 0.0785
    radius = np.sqrt(4 * bending / axial)
    area = np.pi * radius**2
    links, more = pinned(
        HINGE, {"bend_y": 8, "stretch": 2}, (0.8, 0, 0.1), radius, 1, axial / area, 0.3 / area
    )
    robot = lissom.Robot(links, **more)
    path, found = lissom.continuation(robot), lissom.statics(robot)
    assert path.success, path.message
    assert found.success, found.message
    middle = [robot.pose(q, 0.5, link="arch")[:3, 3] for q in (path.path.q[-1], found.q)]
    # The other side of the chord is as much in equilibrium as this one.
    np.testing.assert_allclose(np.linalg.norm(middle[0]), np.linalg.norm(middle[1]), atol=0.06)
    again = lissom.statics(robot, path.path.q[-1], method="newton")
    assert again.success
    np.testing.assert_allclose(again.q, path.path.q[-1], rtol=0, atol=1e-11)


def line(chord, slope, azimuth, stretching, weight):
    """A line of 1 m and 1 N between pins, with E A / w L and w L^3 / E I."""
    radius = 2 / np.sqrt(stretching * weight)
    area = np.pi * radius**2
    segment = lissom.Segment(
        0.25,
        radius,
        stretching / area,
        0.4 * stretching / area,
        1 / (area * GRAVITY),
        {"bend_y": 4, "bend_z": 4, "stretch": 2},
    )
    along = np.array([np.cos(azimuth), np.sin(azimuth), 0]) * np.cos(slope) + (0, 0, np.sin(slope))
    return lissom.Robot(
        [lissom.Link("line", joint=lissom.Spherical(), rod=[segment] * 4)],
        loops=[lissom.Loop(("line",), (None, None, chord * along), lissom.Spherical())],
    )


@pytest.mark.parametrize("azimuth", [1.0, 2.0, 3.0])
@pytest.mark.parametrize(
    ("chord", "slope", "stretching", "weight"),
    [(0.6, 0.3, 1e3, 1e6), (0.6, 0.3, 1e5, 1e8), (0.6, 0.8, 1e3, 1e6), (0.6, 0.8, 1e5, 1e8)],
)
def test_lines_hang_in_every_direction_as_in_one(chord, slope, stretching, weight, azimuth):
    force = []
    for turned in (0.0, azimuth):
        robot = line(chord, slope, turned, stretching, weight)
        found = lissom.statics(robot)
        assert found.success, found.message
        rest = np.zeros(robot.n)
        force.append(np.linalg.norm(np.atleast_2d(robot.loop_forces(found.q, rest, rest))[0][3:]))
    assert abs(force[1] / force[0] - 1) < 1e-6


@pytest.mark.parametrize("stiffness", [(1e8, 1e6), (1e9, 1e7), (1e11, 1e9), (1e9, 1e12)])
def test_a_body_on_elastic_cords_and_one_that_does_not_stretch(stiffness):
    points = np.array([(0.03, 0, 0), (-0.015, 0.026, 0), (-0.015, -0.026, 0)])
    centre = np.array((-0.0008, 0.0054, -0.0047))
    tensions = np.linalg.solve(np.vstack([np.ones(3), points.T[:2]]), GRAVITY * np.r_[1, centre[:2]])
    cords = [
        lissom.Tendon(
            f"{i}",
            [lissom.Via("b", point), lissom.Via(None, point)],
            length=0.4004,
            **({} if k is None else {"stiffness": k}),
        )
        for i, (point, k) in enumerate(zip(points, (stiffness[0], None, stiffness[1]), strict=True))
    ]
    body = lissom.Body(1.0, centre=centre, inertia=np.eye(3) * 5e-4)
    robot = lissom.Robot([lissom.Link("b", joint=lissom.Free(), body=body)], actuators=cords)
    rng = np.random.default_rng(0)
    for _ in range(20):
        start = np.r_[rng.normal(size=2) * 1e-4, -0.4, rng.normal(size=3) * 1e-3]
        found = lissom.statics(robot, start)
        assert (found.status, found.stability) == ("converged", "stable"), found.message
        # Vertical cords stretch by tension over stiffness: their differences tilt the body.
        tilt = max(tensions[0] / stiffness[0], tensions[2] / stiffness[1]) / 0.03
        np.testing.assert_allclose(found.q[:3], (0, 0, -0.4004), atol=0.03 * tilt + 1e-9)
        assert np.linalg.norm(found.q[3:]) < 3 * tilt + 1e-9


JOINTS = {
    "hinge": (lissom.Revolute((0, 0, 1)), 1),
    "slider": (lissom.Prismatic((1, 0, 0)), 1),
    "ball joint": (lissom.Spherical(), 3),
    "universal": (lissom.Universal((1, 0, 0), (0, 1, 0)), 2),
    "free": (lissom.Free(), 6),
}


def curvatures_of_energy(robot, length, stiffness, q, step=1e-4):
    """The smallest and the largest eigenvalue of second differences of the energy of a taut cord."""

    def energy(q):
        return 0.5 * stiffness * max(0.0, robot.actuator_length("cord", q) - length) ** 2

    n, steps = len(q), np.eye(len(q)) * step
    second = np.empty((n, n))
    for i, j in np.ndindex(n, n):
        a, b = steps[i], steps[j]
        second[i, j] = energy(q + a + b) - energy(q + a - b) - energy(q - a + b) + energy(q - a - b)
    values = np.linalg.eigvalsh(second) / (4.0 * step**2)
    return values[0], values[-1]


@pytest.mark.parametrize("joint", JOINTS)
def test_balanced_bodies_come_to_rest_where_their_cord_is_just_slack(joint):
    kind, n = JOINTS[joint]
    rng = np.random.default_rng(1)
    for _ in range(60):
        point, anchor, stiffness = rng.normal(size=3) * 0.3, rng.normal(size=3), 10 ** rng.uniform(1, 6)
        length = 0.9 * np.linalg.norm(anchor)
        cord = lissom.Tendon(
            "cord", [lissom.Via("b", point), lissom.Via(None, anchor)], length=length, stiffness=stiffness
        )
        body = lissom.Body(1.0, inertia=np.eye(3) * 0.01)
        # Nothing but the cord has a force along any coordinate.
        gravity = (0, 0, -GRAVITY) if n in (2, 3) else (0, 0, 0)
        robot = lissom.Robot([lissom.Link("b", joint=kind, body=body)], gravity=gravity, actuators=[cord])
        found = lissom.statics(robot, rng.normal(size=n))
        assert found.success, found.message
        elongation = robot.actuator_length("cord", found.q) - length
        if abs(elongation) <= 1e-9:
            # Motions to one side meet no resistance.
            assert found.stability == "neutral"
        if elongation > 1e-9:
            # A force that is left can only be one that the joint bears, such as along the axis of a hinge.
            assert abs(lissom.statics(robot, found.q, method="newton").residual_norm) < 1e-9
            softest, stiffest = curvatures_of_energy(robot, length, stiffness, found.q)
            assert found.stability == ("stable" if softest > 1e-3 * stiffest else "neutral")


def on_slider(*sides):
    cords = [
        lissom.Tendon(
            f"{i}",
            [lissom.Via("b", (0, 0, 0)), lissom.Via(None, (side, 0, 0))],
            length=abs(side),
            stiffness=1e3,
        )
        for i, side in enumerate(sides)
    ]
    return lissom.Robot(
        [lissom.Link("b", joint=lissom.Prismatic((1, 0, 0)), body=lissom.Body(1.0))],
        gravity=(0, 0, 0),
        actuators=cords,
    )


@pytest.mark.parametrize("start", [1e-17, -1e-17, 0.0])
def test_a_cord_just_taut_holds_to_one_side_and_two_of_them_to_both(start):
    found = lissom.statics(on_slider(1.0), [start])
    assert (found.status, found.stability) == ("converged", "neutral")
    found = lissom.statics(on_slider(1.0, -1.0), [start])
    assert (found.status, found.stability) == ("converged", "stable")


@pytest.mark.parametrize("stiffness", 10.0 ** np.arange(3, 18, 2))
@pytest.mark.parametrize("arm", [0.0, 0.05])
def test_swings_on_cords_of_any_stiffness(arm, stiffness):
    length, inertia = 0.4, 0.01
    body = lissom.Body(1.0, inertia=np.eye(3) * inertia)
    path = [lissom.Via("b", (0, 0, arm)), lissom.Via(None, (0.1, 0.2, 0.3))]
    cord = lissom.Tendon("cord", path, length=length, stiffness=stiffness)
    robot = lissom.Robot([lissom.Link("b", joint=lissom.Free(), body=body)], actuators=[cord])
    found = lissom.statics(robot, [0.1, 0.2, -0.3 - arm, 0.02, 0.01, 0.0])
    assert (found.status, found.stability) == ("converged", "neutral")
    # A double pendulum: M x'' + K x = 0 with the angles of cord and body.
    reach = length + GRAVITY / stiffness
    mass = np.array([[reach**2, reach * arm], [reach * arm, arm**2 + inertia]])
    weight = GRAVITY * np.diag([reach, arm])
    swings = np.sqrt(np.abs(np.sort(np.linalg.eigvals(np.linalg.solve(mass, weight)).real)))
    right = np.sort(np.r_[0.0, swings, swings, np.sqrt(stiffness)])
    modes = lissom.modes(robot, found.q)
    assert modes.stability == "neutral"
    np.testing.assert_allclose(modes.angular_frequency, right, rtol=1e-6, atol=1e-6)


def test_shapes_in_contact_leave_a_saddle_by_symmetry():
    def mooring(modes, joint):
        segment = lissom.Segment(0.25, 3e-3, 1e6, 4e5, 1000.0, modes)
        return lissom.Robot(
            [lissom.Link("line", joint=joint, rod=[segment] * 4, position=(0, 0, 3e-3))],
            loops=[lissom.Loop(("line",), (None, None, (0.7, 0, 0.3)), lissom.Spherical())],
            contacts=[lissom.Contact("line", lissom.HalfSpace())],
        )

    planar = lissom.statics(mooring({"bend_y": 4}, HINGE))
    robot = mooring({"bend_y": 4, "bend_z": 4}, lissom.Spherical())
    saddle = np.zeros(robot.n)
    saddle[1] = planar.q[0]
    for i in range(4):
        saddle[3 + 8 * i : 7 + 8 * i] = planar.q[1 + 4 * i : 5 + 4 * i]
    at_saddle = lissom.statics(robot, saddle, method="newton")
    assert (at_saddle.status, at_saddle.stability) == ("converged", "divergence")
    # The line may move over the floor without resistance, which makes the estimate six times too large.
    found = lissom.statics(robot, saddle, space_error=False)

    def energy(q):
        of_shape = robot.energy(q, 0 * q)
        return of_shape.elastic + of_shape.gravitational

    assert found.success, found.message
    assert found.stability in ("stable", "neutral")
    assert energy(found.q) < energy(saddle) - 1e-6


@pytest.mark.parametrize("angle", [0.3, 0.5])
@pytest.mark.parametrize("force", [3.0, 4.5, 6.0, 10.0, 30.0])
def test_arms_on_a_pin_do_not_pass_through_what_is_in_their_way(force, angle):
    """A force that follows the arm has no potential; a loop is its pin."""
    length, centre, radius, stiffness = 1.0, 0.5, 0.02, 1e5
    place, across = length * np.array([np.sin(angle), 0, -np.cos(angle)]), np.array([0, 1, 0])
    bar = lissom.Capsule(place - across, place + across, radius)
    body = lissom.Body(1.0, centre=(0, 0, length - centre), inertia=np.eye(3) * 0.02)
    robot = lissom.Robot(
        [lissom.Link("arm", joint=lissom.Planar((0, 1, 0)), position=(0, 0, -length), body=body)],
        loads=[lissom.Load(force=(force, 0, 0), link="arm", frame="body")],
        contacts=[lissom.Contact(lissom.Ball("arm", radius), bar, stiffness=stiffness)],
        loops=[lissom.Loop(("arm", None, (0, 0, length)), (None, None, (0, 0, 0)), HINGE)],
    )
    found = lissom.statics(robot, np.zeros(robot.n))
    assert found.success, found.message
    end = robot.pose(found.q, link="arm")[:3, 3]
    turned = np.arctan2(end[0], -end[2])
    gap = np.linalg.norm(end - place)
    # Moments about the pin: of the force, of the weight, and of the contact along the line of centres.
    pressed = stiffness * (2 * radius - gap)
    arm_of_contact = np.cross((place - end) / gap, end)[1]
    assert turned < angle
    assert pressed > 0
    moment = force * length - GRAVITY * centre * np.sin(turned) - pressed * abs(arm_of_contact)
    assert abs(moment) < 1e-5 * force


@pytest.mark.parametrize("azimuth", [0, 1e-9, 1e-3, 0.7, np.pi / 2, 3])
@pytest.mark.parametrize("pin", [Revolute((0, 1, 0)), lissom.Spherical()])
@pytest.mark.parametrize("beside", [False, True])
def test_planar_mechanisms_are_the_same_turned_about_the_vertical(azimuth, pin, beside):
    """A four-bar with a spring at its crank: rows of its loop out of its plane are zero or rounding."""
    first, coupler, rocker, ground, angle = 0.1, 0.25, 0.2, 0.3, 1.2

    def about(axis, angle):
        return np.r_[np.cos(angle / 2), np.sin(angle / 2) * np.array(axis)]

    def product(a, b):
        return np.r_[a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]

    def body(length, mass):
        across = mass * length**2 / 12
        return lissom.Body(mass, centre=(length / 2, 0, 0), inertia=(0, across, across))

    def angles(crank):
        """Those of coupler and rocker by their triangle with the ground, and where these meet."""
        end = first * np.array([np.cos(crank), np.sin(crank)])
        rest = np.array([ground, 0]) - end
        left = np.hypot(*rest)
        second = np.arctan2(rest[1], rest[0]) + np.arccos(
            (coupler**2 + left**2 - rocker**2) / (2 * coupler * left)
        )
        joint = end + coupler * np.array([np.cos(second), np.sin(second)])
        return second, np.arctan2(-joint[1], ground - joint[0]), joint

    def energy(turned):
        """Of the spring and of the weights at the middles of the bars."""
        second, third, joint = angles(angle - turned)
        heights = first / 2 * np.sin(angle - turned), joint[1] - coupler / 2 * np.sin(second)
        weights = 0.1 * heights[0] + 0.25 * heights[1] + 0.2 * (joint[1] + rocker / 2 * np.sin(third))
        return 0.15 * turned**2 + 9.81 * weights

    second, third, _ = angles(angle)
    wanted = minimize_scalar(energy, bounds=(0, 0.8), method="bounded", options={"xatol": 1e-10}).x
    turn = about((0, 0, 1), azimuth)
    hinge, y = (0, 1, 0), lambda angle: about((0, 1, 0), angle)
    links = [
        Link(
            "crank",
            orientation=product(turn, y(-angle)),
            joint=Revolute(hinge, stiffness=0.3),
            body=body(first, 0.1),
        ),
        Link(
            "coupler",
            parent="crank",
            position=(first, 0, 0),
            orientation=y(angle - second),
            joint=Revolute(hinge),
            body=body(coupler, 0.25),
        ),
        Link(
            "rocker",
            parent="coupler",
            position=(coupler, 0, 0),
            orientation=y(second - third),
            joint=Revolute(hinge),
            body=body(rocker, 0.2),
        ),
    ]
    if beside:
        slide = lissom.Prismatic((0, 0, 1), stiffness=100.0)
        links.insert(0, Link("aside", position=(5, 0, 0), joint=slide, body=lissom.Body(1.0)))
    foot = (ground * np.cos(azimuth), ground * np.sin(azimuth), 0)
    loop = lissom.Loop(("rocker", None, (rocker, 0, 0)), (None, None, foot, turn), pin)
    robot = lissom.Robot(links, loops=[loop])
    for found in (lissom.statics(robot), lissom.statics(robot, method="newton")):
        assert found.success, found.message
        assert found.stability == "stable"
        assert found.q[-3] == pytest.approx(wanted, abs=1e-6)
    path = lissom.continuation(robot)
    assert path.success, path.message
    np.testing.assert_allclose(path.path.q[-1], found.q, rtol=0, atol=1e-7)
