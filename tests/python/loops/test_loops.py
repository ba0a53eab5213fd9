"""Closed loops: mechanisms with published and exact solutions, closed rods, and errors."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import lissom
from lissom import (
    Body,
    Distance,
    Free,
    Gear,
    Link,
    Loop,
    Prismatic,
    Revolute,
    Robot,
    Segment,
    Spherical,
    Universal,
    Weld,
)

TIGHT = {"rtol": 1e-10, "atol": 1e-12}


def quaternion(matrix):
    """Quaternion of a rotation matrix with an angle below a half turn."""
    w = 0.5 * np.sqrt(1 + np.trace(matrix))
    x, y, z = (matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1])
    return (w, x / (4 * w), y / (4 * w), z / (4 * w))


def about_z(angle):
    return (np.cos(angle / 2), 0, 0, np.sin(angle / 2))


def windows(number):
    """The four-bar windows of the IFToMM library: uniform bars of a kilogram and a metre."""
    body = Body(1.0, centre=(0.5, 0, 0), inertia=np.diag([1e-3, 1 / 12, 1 / 12]))
    hinge = Revolute((0, 0, 1))
    up, down = about_z(np.pi / 2), about_z(-np.pi / 2)
    links, loops = [Link("v0", orientation=up, joint=hinge, body=body)], []
    for k in range(1, number + 1):
        parent = "v0" if k == 1 else f"h{k - 1}"
        turn = down if k == 1 else (1, 0, 0, 0)
        links += [
            Link(f"h{k}", parent=parent, position=(1, 0, 0), orientation=turn, joint=hinge, body=body),
            Link(f"v{k}", position=(float(k), 0, 0), orientation=up, joint=hinge, body=body),
        ]
        loops.append(Loop((f"v{k}", None, (1, 0, 0)), (f"h{k}", None, (1, 0, 0)), hinge, name=f"pin {k}"))
    robot = Robot(links, gravity=(0, -9.81, 0), loops=loops)
    v0 = [-1.0 if name[0] == "v" else float(name == "h1.angle") for name in robot.coordinates]
    return robot, v0


def exact_windows(number):
    """Exact angle of the first bar: there is one degree of freedom."""

    def rates(_, y):
        return [y[1], -((number + 1) / 2 + number) * 9.81 * np.cos(y[0]) / ((number + 1) / 3 + number)]

    solution = solve_ivp(rates, (0, 10), [np.pi / 2, -1], rtol=1e-12, atol=1e-12, dense_output=True)
    return lambda t: solution.sol(t)[0] - np.pi / 2


def bricard():
    """Bricard's mechanism of the IFToMM library: six hinges, one of them redundant."""
    points = np.array([(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], float)
    axes = [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0)]
    links = []
    for i in range(5):
        way = points[i + 1] - points[i]
        inertia = np.diag([0.02 / 12 if way[k] else 1.01 / 12 for k in range(3)])
        links.append(
            Link(
                f"rod{i}",
                parent=f"rod{i - 1}" if i else None,
                position=points[i] - points[max(i - 1, 0)],
                joint=Revolute(axes[i]),
                body=Body(1.0, centre=way / 2, inertia=inertia),
            )
        )
    last = Loop(("rod4", None, points[5] - points[4]), (None, None, points[5]), Revolute(axes[5]), name="P5")
    return Robot(links, gravity=(0, -9.81, 0), loops=[last])


def slider_crank():
    """The spatial slider-crank of the IFToMM library, and its initial velocity."""
    crank = Link(
        "crank",
        position=(0, 0.1, 0.12),
        joint=Revolute((1, 0, 0)),
        body=Body(0.12, centre=(0, 0, 0.04), inertia=np.diag([1e-4, 1e-4, 1e-5])),
    )
    start, end = np.array([0, 0.1, 0.2]), np.array([0.2, 0, 0])
    along = (end - start) / 0.3
    cross = np.array([0, 2, -1]) / np.sqrt(5)
    axes = np.column_stack([along, cross, np.cross(along, cross)])
    turn = quaternion(axes)
    rod = Link(
        "rod",
        parent="crank",
        position=(0, 0, 0.08),
        orientation=turn,
        joint=Spherical(),
        body=Body(0.5, centre=(0.15, 0, 0), inertia=np.diag([4e-4, 4e-3, 4e-3])),
    )
    slider = Link(
        "slider",
        position=(0.2, 0, 0),
        joint=Prismatic((1, 0, 0)),
        body=Body(2.0, inertia=np.diag([1e-4] * 3)),
    )
    back = (turn[0], -turn[1], -turn[2], -turn[3])
    joint = Loop("slider", ("rod", None, (0.3, 0, 0), back), Universal((1, 0, 0), cross), name="cross")
    robot = Robot([crank, rod, slider], gravity=(0, 0, -9.81), loops=[joint])
    turning = axes.T @ (np.array([1.92, -0.96, 0.48]) - [6, 0, 0])
    return robot, [6, *turning, 0.24]


def squeezer():
    """Andrews' squeezer, data of the IVP test set. Its spring is a telescope with little mass."""
    hinge = Revolute((0, 0, 1))

    def link(name, mass, inertia, centre, **options):
        body = Body(mass, centre=(*centre, 0), inertia=np.diag([inertia, inertia, inertia]))
        return Link(name, joint=hinge, body=body, **options)

    a, b, c = (-0.06934, -0.00227, 0), (-0.03635, 0.03273, 0), (0.014, 0.072, 0)
    telescope = Prismatic((1, 0, 0), stiffness=4530.0, rest=0.07785)
    links = [
        link("K1", 0.04325, 2.194e-6, (0.00092, 0)),
        link("K2", 0.00365, 4.410e-7, (-0.0115, 0), parent="K1", position=(0.007, 0, 0)),
        link("K3", 0.02373, 5.255e-6, (0.01043, -0.01874), position=b),
        link("K5", 0.07050, 1.169e-5, (0.02308, 0.00916), position=a),
        link("K4", 0.00706, 5.667e-7, (0, -(0.02 - 0.01421)), parent="K5", position=(0.04, 0, 0)),
        link("K7", 0.05498, 1.912e-5, (0.00449, -0.01228), position=a),
        link("K6", 0.00706, 5.667e-7, (0.02 - 0.01421, 0), parent="K7", position=(0, -0.04, 0)),
        link("tube", 1e-9, 1e-12, (0, 0), position=c),
        Link("piston", parent="tube", joint=telescope, body=Body(1e-9)),
    ]
    knot = ("K2", None, (-0.028, 0, 0))
    loops = [
        Loop(knot, ("K3", None, (0, -0.035, 0)), Spherical()),
        Loop(knot, ("K4", None, (0, -0.02, 0)), Spherical()),
        Loop(knot, ("K6", None, (0.02, 0, 0)), Spherical()),
        Loop("piston", ("K3", None, (0.02, -0.018, 0)), Spherical()),
    ]
    robot = Robot(links, gravity=(0, 0, 0), loads=[lissom.Load(moment=(0, 0, 0.033), link="K1")], loops=loops)
    beta, theta, gamma, phi = -0.0617138900142764496, 0.0, 0.455279819163070380, 0.222668390165885885
    delta, omega, epsilon = 0.487364979543842550, -0.222668390165885885, 1.23054744454982120
    turn = np.array([[np.cos(gamma), -np.sin(gamma)], [np.sin(gamma), np.cos(gamma)]])
    way = np.array(b[:2]) + turn @ [0.02, -0.018] - c[:2]
    spring = [np.arctan2(way[1], way[0]), np.hypot(*way)]
    return robot, [beta, theta, gamma, delta, phi, epsilon, omega, *spring]


def wire(length=1.0, **modes):
    return Segment(length, 1e-3, 2e11, 8e10, 7800, modes)


@pytest.mark.parametrize(("method", "dt", "error"), [("newmark", 0.01, 8e-5), ("hht", 0.01, 8e-5)])
def test_windows_pass_their_singular_positions(method, dt, error):
    robot, v0 = windows(2)
    assert robot.constraints == 10
    assert robot.redundant_constraints(np.zeros(robot.n)) == {"pin 1": 3, "pin 2": 3}
    motion = lissom.simulate(robot, 4.0, v0=v0, method=method, dt=dt, **TIGHT)
    assert motion.success, motion.message
    exact = exact_windows(2)(motion.t)
    assert np.abs(motion.q[:, 0] - exact).max() < 10 * error
    angle = motion.q[-1][0] + np.pi / 2
    assert np.hypot(np.cos(angle) - 0.117616102376, np.sin(angle) - 0.993059138451) < error
    assert np.abs(robot.loop_gaps(motion.q)).max() < 1e-12


def test_states_and_forces_are_of_second_order():
    robot, v0 = windows(1)
    exact = exact_windows(1)
    errors, forces = [], []
    for dt in (0.01, 0.005, 0.0025):
        motion = lissom.simulate(robot, 1.0, v0=v0, dt=dt, **TIGHT)
        errors.append(abs(motion.q[-1][0] - exact(1.0)))
        forces.append(robot.loop_forces(motion.q[-1], motion.v[-1], motion.a[-1]))
    assert 3.7 < errors[0] / errors[1] < 4.3
    assert 3.7 < errors[1] / errors[2] < 4.3
    ratio = np.linalg.norm(forces[0] - forces[1]) / np.linalg.norm(forces[1] - forces[2])
    assert 3.5 < ratio < 4.5


def test_forty_windows():
    robot, v0 = windows(40)
    motion = lissom.simulate(robot, 1.0, v0=v0, **TIGHT)
    angle = motion.q[-1][0] + np.pi / 2
    assert np.hypot(np.cos(angle) + 0.115356880632, np.sin(angle) + 0.993324111300) < 1e-4


@pytest.mark.parametrize("method", ["rk45", "dop853"])
def test_explicit_methods_follow_regular_motions_and_say_where_they_cannot_go_on(method):
    robot, v0 = windows(2)
    exact = exact_windows(2)
    regular = lissom.simulate(robot, 0.25, v0=v0, method=method, **TIGHT)
    assert regular.success
    assert abs(regular.q[-1][0] - exact(0.25)) < 1e-8
    assert np.abs(robot.loop_gaps(regular.q)).max() < 1e-10
    singular = lissom.simulate(robot, 4.0, v0=v0, method=method, **TIGHT)
    right = abs(singular.q[-1][0] - exact(singular.t[-1])) < 1e-4
    assert right or singular.status == "singular_position"


def test_bricard():
    robot = bricard()
    assert robot.redundant_constraints(np.zeros(5)) == {"P5": 1}
    answers = {
        0.5: (0.9682836791, -1.2246251594, 0.7501466094),
        1.0: (0.5105014612, -1.6491675994, 0.1401231146),
        2.0: (-0.9693403448, -1.2212468950, 0.7542780108),
        5.0: (0.9999999977, -1.0000672577, 0.9999327400),
        10.0: (0.999999964, -1.000269013, 0.999730951),
    }
    accurate = lissom.simulate(robot, 10.0, method="dop853", t_eval=list(answers), **TIGHT)
    steps = lissom.simulate(robot, 10.0, dt=0.005, t_eval=list(answers), **TIGHT)
    for motion, tolerance in ((accurate, 2e-9), (steps, 1e-5)):
        assert motion.success
        points = robot.pose(motion.q, link="rod3")[:, :3, 3]
        np.testing.assert_allclose(points, list(answers.values()), rtol=0, atol=tolerance)
    np.testing.assert_allclose(accurate.balance.total, accurate.balance.total[0], rtol=0, atol=1e-8)


def test_spatial_slider_crank():
    robot, v0 = slider_crank()
    assert robot.redundant_constraints(np.zeros(robot.n)) == {}
    answers = {
        0.1: (0.226787188553, 0.305277006936, 5.828888134673),
        0.5: (0.184952629778, -0.004560290643, 14.408160810197),
        1.0: (0.211721661397, -0.503491864937, 10.427593000314),
        2.0: (0.289085197052, 0.216539424793, 22.584240011467),
        5.0: (0.240719573872, -0.595984412325, 11.494996275644),
    }
    motion = lissom.simulate(robot, 5.0, v0=v0, method="dop853", t_eval=list(answers), **TIGHT)
    found = np.column_stack([motion.q[:, 4] + 0.2, motion.v[:, 4], motion.v[:, 0]])
    np.testing.assert_allclose(found, list(answers.values()), rtol=0, atol=1e-7)
    coarse = lissom.simulate(robot, 0.5, v0=v0, dt=1e-3, t_eval=[0.1, 0.5], **TIGHT)
    np.testing.assert_allclose(coarse.q[:, 4] + 0.2, [answers[0.1][0], answers[0.5][0]], rtol=0, atol=1e-6)


def test_andrews_squeezer():
    robot, q0 = squeezer()
    assert np.abs(robot.loop_gaps(q0)).max() < 1e-14
    start = robot.forward_dynamics(q0, np.zeros(robot.n))
    np.testing.assert_allclose(start[:2], [14222.44391995, -10666.83293997], rtol=1e-6)
    wanted = [
        15.810771195148,
        -15.756371058405,
        0.04082224012,
        0.52440996588,
        -0.534730116342,
        1.048080741042,
        0.534730116342,
    ]
    # The telescope has little mass, so that its accelerations are accurate to few digits. Much tighter
    # tolerances mistake rounding errors for local errors.
    accurate = lissom.simulate(robot, 0.03, q0=q0, method="dop853", t_eval=[0.03], rtol=5e-7, atol=5e-9)
    assert accurate.success
    np.testing.assert_allclose(accurate.q[-1][:7], wanted, rtol=0, atol=5e-6)
    speeds = [1139.920302151208, -1424.379294994111, 11.03291221937134]
    np.testing.assert_allclose(accurate.v[-1][:3], speeds, rtol=1e-4)
    coarse = lissom.simulate(robot, 0.03, q0=q0, dt=2e-5, t_eval=[0.03])
    assert coarse.success
    np.testing.assert_allclose(coarse.q[-1][:7], wanted, rtol=0, atol=1e-3)


def random_loops(rng):
    """A robot with rods and joints, and loops of every kind."""
    modes = {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 1, "shear_y": 1, "shear_z": 1}
    body = Body(0.3, centre=(0.05, 0.01, -0.02), inertia=np.diag([2e-3, 3e-3, 2.5e-3]))
    links = [
        Link("arm", rod=[Segment(0.5, 0.01, 1e6, 4e5, 1000, modes)], joint=Spherical()),
        Link(
            "leg",
            rod=[Segment(0.4, 0.01, 1e6, 4e5, 1000, modes)],
            parent="arm",
            at=0.2,
            joint=Revolute((1, 2, 3)),
        ),
        Link("block", body=body, position=(0.2, 0.1, 0), joint=Free()),
    ]
    joints = [
        Weld(),
        Revolute((1, 2, -1)),
        Prismatic((0.3, 1, 0.5)),
        lissom.Cylindrical((1, 0, 2)),
        Universal((1, 0, 0.2), (0, 1, 1)),
        lissom.Planar((1, 1, 0.5)),
        Spherical(),
        Distance(0.3),
    ]

    def place(link, at):
        turn = rng.normal(size=4)
        return (link, at, rng.normal(size=3) * 0.1, turn / np.linalg.norm(turn))

    def ends():
        places = [place("arm", 0.35), place("leg", None), place("block", None), place(None, None)]
        first, second = rng.choice(4, 2, replace=False)
        return places[first], places[second]

    loops = [Loop(*ends(), joint, name=str(i)) for i, joint in enumerate(joints)]
    loops.append(Loop("arm.bend_y[0]", "leg.angle", Gear(0.7, offset=0.1), name="gear"))
    return Robot(links, loops=loops)


def test_a_weld_cut_and_closed_again_changes_nothing():
    body = Body(0.2, centre=(0.1, 0.02, 0), inertia=np.diag([1e-3, 2e-3, 2e-3]))
    rod = [wire(0.5, bend_y=3, bend_z=3, torsion=2)]

    def robot(is_cut):
        links = [Link("arm", rod=rod, joint=Revolute((0, 1, 0)))]
        if not is_cut:
            return Robot([*links, Link("hand", parent="arm", joint=Weld(), body=body)])
        links.append(Link("hand", position=(0.5, 0, 0), joint=Free(), body=body))
        return Robot(links, loops=[Loop("arm", "hand", Weld())])

    tree, loop = robot(False), robot(True)
    assert loop.constraints == 6
    options = {"method": "generalised_alpha", "dt": 1e-3, **TIGHT}
    moved, tied = (lissom.simulate(each, 0.3, **options) for each in (tree, loop))
    assert tied.success
    np.testing.assert_allclose(tied.q[:, : tree.n], moved.q, rtol=0, atol=2e-5)
    i = len(tied.t) // 2
    held = loop.loop_forces(tied.q[i], tied.v[i], tied.a[i])
    passed = tree.joint_wrench(moved.q[i], moved.v[i], moved.a[i], link="hand")
    np.testing.assert_allclose(held, passed, rtol=0, atol=2e-3 * np.abs(passed).max())
    shape, tied_shape = lissom.statics(tree, q0=tree_start(tree)), lissom.statics(loop, q0=tree_start(loop))
    assert tied_shape.success
    np.testing.assert_allclose(tied_shape.q[: tree.n], shape.q, rtol=0, atol=1e-7)
    slow = lissom.modes(tree, shape.q).frequency
    np.testing.assert_allclose(lissom.modes(loop, tied_shape.q).frequency, slow, rtol=1e-5)


def tree_start(robot):
    """The hanging shape of the tree."""
    q = np.zeros(robot.n)
    q[0] = np.pi / 2
    return q


def test_a_ring_from_one_rod():
    radius = 0.1
    length = 2 * np.pi * radius
    straight = Robot(
        [Link("ring", rod=[wire(length, bend_y=8)])], gravity=(0, 0, 0), loops=[Loop("ring", None, Weld())]
    )
    q0 = np.zeros(8)
    q0[:3] = -1 / radius, 0.3, 0.5
    ring = lissom.statics(straight, q0=q0)
    assert ring.success
    np.testing.assert_allclose(ring.q, [-1 / radius, 0, 0, 0, 0, 0, 0, 0], atol=1e-9)


def test_frequencies_of_a_free_ring():
    radius, thickness, young, shear, density = 0.1, 1e-3, 2e11, 8e10, 7800.0
    modes = {"bend_y": 14, "bend_z": 14, "torsion": 14}
    curved = (0, -1 / radius, 0, 1, 0, 0)
    rod = Segment(2 * np.pi * radius, thickness, young, shear, density, modes, reference_strain=curved)
    ring = Robot(
        [Link("ring", rod=[rod], joint=Free())],
        gravity=(0, 0, 0),
        loops=[Loop(("ring", 0.0), "ring", Weld())],
    )
    found = lissom.modes(ring, np.zeros(ring.n)).frequency
    assert len(found) == ring.n - 6
    area, inertia = np.pi * thickness**2, np.pi * thickness**4 / 4
    n = np.arange(2, 4)
    unit = young * inertia / (density * area * radius**4)
    within = np.sqrt(unit * n**2 * (n**2 - 1) ** 2 / (n**2 + 1))
    across = np.sqrt(unit * n**2 * (n**2 - 1) ** 2 / (n**2 + young / (2 * shear)))
    wanted = np.sort(np.repeat(np.concatenate([within, across]), 2)) / (2 * np.pi)
    np.testing.assert_allclose(found[:6], 0, atol=1e-3)
    np.testing.assert_allclose(found[6:14], wanted, rtol=2e-3)


@pytest.mark.parametrize("distance", [0.9, 0.5])
def test_elastica_between_pins(distance):
    robot = Robot(
        [Link("rod", rod=[wire(bend_y=12)], joint=Revolute((0, 1, 0)))],
        gravity=(0, 0, 0),
        loops=[Loop("rod", (None, None, (distance, 0, 0)), Spherical())],
    )
    q0 = np.zeros(robot.n)
    q0[2] = 1.0
    arch = lissom.statics(robot, q0=q0)
    assert arch.success
    assert arch.stability == "stable"
    modulus = brentq(lambda m: 2 * ellipe(m) / ellipk(m) - 1 - distance, 1e-9, 0.99)
    load = 4 * ellipk(modulus) ** 2 * 2e11 * np.pi * 1e-12 / 4
    zeros = np.zeros(robot.n)
    # The world is the second end: the rod pushes it away.
    np.testing.assert_allclose(robot.loop_forces(arch.q, zeros, zeros)[3:], [load, 0, 0], atol=1e-6 * load)


def test_gears_and_bars():
    body = Body(1.0, centre=(0, 0, 0), inertia=np.diag([0.1, 0.2, 0.3]))
    wheel, pinion = (Link(name, joint=Revolute((0, 0, 1)), body=body) for name in ("wheel", "pinion"))
    robot = Robot(
        [wheel, pinion],
        loads=[lissom.Load(moment=(0, 0, 1.0), link="wheel")],
        loops=[Loop("pinion.angle", "wheel.angle", Gear(-2.0), name="gear")],
    )
    motion = lissom.simulate(robot, 1.0, **TIGHT)
    # (I1 + 4 I2) a = M.
    np.testing.assert_allclose(motion.a[-1], [1 / 1.5, -2 / 1.5], rtol=1e-9)
    np.testing.assert_allclose(motion.q[-1], [1 / 3, -2 / 3], rtol=1e-9)
    force = robot.loop_forces(motion.q, motion.v, motion.a, name="gear")
    np.testing.assert_allclose(force, -2 / 1.5 * 0.3, rtol=1e-9)
    # A spherical pendulum held by a bar, and one held by a joint.
    ball = Body(0.5, centre=(0, 0, 0), inertia=np.diag([1e-6] * 3))
    free = Robot(
        [Link("ball", position=(0.8, 0, -0.6), joint=Free(), body=ball)],
        loops=[Loop("ball", None, Distance(1.0))],
    )
    swing = lissom.simulate(free, 1.0, v0=[0, 0.5, 0, 0, 0, 0], method="dop853", **TIGHT)
    position = np.array([0.8, 0, -0.6]) + swing.q[:, :3]
    np.testing.assert_allclose(np.linalg.norm(position, axis=1), 1, atol=1e-9)
    tension = -free.loop_forces(swing.q[0], swing.v[0], swing.a[0])[3:] @ [0.8, 0, -0.6]
    assert tension == pytest.approx(-0.5 * (0.25 + 9.81 * 0.6), rel=1e-9)


def test_starts_are_projected_and_it_is_said():
    robot, v0 = windows(1)
    off = np.array([0.0, 0.02, -0.01])
    motion = lissom.simulate(robot, 0.1, q0=off, v0=v0)
    assert motion.success
    assert "start was moved by" in motion.message
    assert np.abs(robot.loop_gaps(motion.q[0])).max() < 1e-12
    exactly = lissom.simulate(robot, 0.1, v0=v0)
    assert "moved" not in exactly.message


def test_loops_that_cannot_be_closed_are_refused():
    arm = Link("rod", rod=[wire(bend_y=5)])
    far = Robot([arm], loops=[Loop("rod", (None, None, (1.5, 0, 0)), Spherical(), name="far")])
    for attempt in (lambda: lissom.simulate(far, 1.0), lambda: lissom.statics(far)):
        with pytest.raises(
            ValueError, match=r'q0: .*open loop: loops\[0\] misses by 0\.5 m between "rod" and the world '
        ):
            attempt()


def test_methods_that_cannot_hold_loops_are_refused():
    robot, _ = windows(1)
    for options in (
        {"beta": 0.25, "gamma": 0.5},
        {"method": "average_acceleration"},
        {"method": "hht", "alpha": 0.0},
    ):
        with pytest.raises(ValueError, match=r"damps what is infinitely fast"):
            lissom.simulate(robot, 1.0, **options)
    with pytest.raises(ValueError, match="jac"):
        lissom.simulate(robot, 1.0, jac="forward")


@pytest.mark.parametrize(
    ("loop", "message"),
    [
        (lambda: Loop("a", "a", Spherical()), "one and the same section"),
        (lambda: Loop(None, (None, None, (1, 0, 0)), Weld()), "two points of the world"),
        (lambda: Loop("a", None, Free()), "Distance or Gear, got Free"),
        (lambda: Loop("a", None, Revolute((0, 1, 0), stiffness=1.0)), "springs, dampers or stops"),
        (lambda: Loop("a", None, Revolute((0, 1, 0), motion=1.0)), r"kind\.motion"),
        (lambda: Loop("a", None, Revolute((0, 0, 0))), "axis"),
        (lambda: Loop("a", None, Distance(0.0)), r"length: got 0"),
        (lambda: Loop("a", (None, 0.1), Weld()), r"b\.at"),
        (lambda: Loop("a", (None, None, (np.nan, 0, 0)), Weld()), r"b\.position"),
        (lambda: Loop("a", (None, None, (0, 0, 0), (2, 0, 0, 0)), Weld()), r"b\.orientation"),
        (lambda: Loop("a", 3.0, Weld()), "b: expected a name, lissom.LoopEnd, got float"),
        (lambda: Loop("a", None, "weld"), "kind: expected lissom.Weld, Revolute"),
        (lambda: Loop("a.angle", "a.angle", Gear(0.0)), r"ratio: got 0"),
        (
            lambda: Loop("a.angle", "a.angle", Gear()),
            "b: got one coordinate twice, expected two different ones",
        ),
        (lambda: Loop("a", None, Gear(1.0)), "b: got a place, expected the name of a coordinate"),
    ],
)
def test_loops_without_sense_are_refused(loop, message):
    with pytest.raises((ValueError, TypeError), match=message):
        loop()


def test_loops_that_do_not_fit_a_robot_are_refused():
    arm = Link("arm", rod=[wire(bend_y=2)], joint=Revolute((0, 1, 0)))
    cases = [
        (Loop("arn", None, Weld()), r"loops\[0\]\.a\.link: got 'arn', .*did you mean 'arm'"),
        (Loop(("arm", 2.0), None, Weld()), r"loops\[0\]\.a\.at: got 2"),
        (Loop("arm.angel", "arm.bend_y[0]", Gear()), r"did you mean 'arm\.angle'"),
    ]
    for loop, message in cases:
        with pytest.raises(ValueError, match=message):
            Robot([arm], loops=[loop])
    with pytest.raises(TypeError, match=r"loops\[0\]: expected lissom\.Loop, got"):
        Robot([arm], loops=["arm"])
    twice = Loop("arm", None, Spherical(), name="pin")
    with pytest.raises(ValueError, match="the name of another loop"):
        Robot([arm], loops=[twice, twice])


def test_robots_with_loops_copy_and_pickle():
    robot = random_loops(np.random.default_rng(0))
    for other in (copy.copy(robot), pickle.loads(pickle.dumps(robot))):
        assert other.loops == robot.loops
        q = np.full(robot.n, 0.1)
        np.testing.assert_array_equal(other.loop_gaps(q), robot.loop_gaps(q))


def test_simulations_of_loops_step_copy_and_pickle_to_the_bit():
    robot, v0 = windows(2)
    run = lissom.Simulation(robot, dt=0.01, v0=v0)
    for _ in range(20):
        assert run.step() == "finished"
    other = pickle.loads(pickle.dumps(run))
    for _ in range(20):
        run.step()
        other.step()
    np.testing.assert_array_equal(run.q, other.q)
    np.testing.assert_array_equal(run.q, lissom.simulate(robot, 0.4, v0=v0).q[-1])


def test_linear_models_keep_loops_closed():
    body = Body(0.2, centre=(0.1, 0.02, 0), inertia=np.diag([1e-3, 2e-3, 2e-3]))
    links = [Link("arm", rod=[wire(0.5, bend_y=3)], joint=Revolute((0, 1, 0)))]
    tree = Robot([*links, Link("hand", parent="arm", joint=Weld(), body=body)])
    free = Link("hand", position=(0.5, 0, 0), joint=Free(), body=body)
    loop = Robot([*links, free], loops=[Loop("arm", "hand", Weld())])
    shape = lissom.statics(tree, q0=tree_start(tree)).q
    tied = lissom.statics(loop, q0=tree_start(loop)).q
    of_tree = lissom.linearise(tree, shape, inputs="forces", outputs="coordinates")
    of_loop = lissom.linearise(loop, tied, inputs="forces", outputs="coordinates")
    assert len(of_loop.states) == 2 * tree.n
    wanted = np.sort_complex(np.linalg.eigvals(of_tree.A))
    np.testing.assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(of_loop.A).imag)), np.sort(np.abs(wanted.imag)), rtol=1e-6, atol=1e-3
    )
    # Gain from a force on the arm to the angle of the arm.
    gain = [-linear.C[:1] @ np.linalg.solve(linear.A, linear.B[:, :1]) for linear in (of_tree, of_loop)]
    np.testing.assert_allclose(gain[1], gain[0], rtol=1e-6)


def test_what_does_not_hold_loops_says_so():
    robot, _ = windows(1)
    with pytest.raises(ValueError, match="does not hold them yet"):
        robot.reach({"v1": np.eye(4)})


def test_a_rhombus_that_floats_keeps_its_momentum():
    """Constraints across its plane are rounding errors in any motion, and must not count."""
    hinge = Revolute((0, 0, 1))
    body = Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-4, 8e-4, 8e-4]))
    side = {"position": (0.2, 0, 0), "joint": hinge, "body": body}
    links = [Link("a", joint=Free(), body=body)]
    links += [Link(name, parent=parent, **side) for name, parent in ("ba", "cb", "dc")]
    closing = Loop(("d", None, (0.2, 0, 0)), "a", hinge, name="close")
    robot = Robot(links, gravity=(0, 0, 0), loops=[closing])
    q0 = [0, 0, 0, 0, 0, 0, 1.2, np.pi - 1.2, 1.2]
    v0 = [0.3, -0.1, 0.2, 0.5, 0.2, 1.0, 1.0, -1.0, 1.0]
    assert robot.redundant_constraints(q0) == {"close": 3}
    motion = lissom.simulate(robot, 1.0, q0=q0, v0=v0, method="dop853", **TIGHT)
    assert motion.success, motion.message
    momentum = robot.momentum(motion.q, motion.v)
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), rtol=0, atol=1e-8)
    steps = lissom.simulate(robot, 1.0, q0=q0, v0=v0, dt=1e-3, **TIGHT)
    assert steps.success, steps.message
    np.testing.assert_allclose(steps.q[-1], motion.q[-1], rtol=0, atol=1e-5)


def test_a_driven_crank_moves_its_slider():
    hinge = Revolute((0, 0, 1))
    body = Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-4, 8e-4, 8e-4]))
    crank = Link("crank", joint=Revolute((0, 0, 1), motion=lambda t: 3 * t + 0.3), body=body)
    rod = Link("rod", parent="crank", position=(0.2, 0, 0), joint=hinge, body=body)
    slider = Link("slider", joint=Prismatic((1, 0, 0)), body=Body(0.5))
    loop = Loop(("rod", None, (0.5, 0, 0)), "slider", hinge)
    robot = Robot([crank, rod, slider], gravity=(0, -9.81, 0), loops=[loop])

    def slide(t):
        return 0.2 * np.cos(3 * t + 0.3) + np.sqrt(0.25 - (0.2 * np.sin(3 * t + 0.3)) ** 2)

    q0 = [-0.3 - np.arcsin(0.2 * np.sin(0.3) / 0.5), slide(0)]
    # Radau's states at the ends of steps are accurate; states in between are interpolated.
    for method, tolerance, t_eval in (
        ("newmark", 1e-12, None),
        ("dop853", 1e-5, None),
        ("radau", 1e-12, "steps"),
    ):
        motion = lissom.simulate(robot, 1.5, q0=q0, method=method, dt=1e-3, t_eval=t_eval)
        assert motion.success, motion.message
        np.testing.assert_allclose(motion.q[:, 1], slide(motion.t), rtol=0, atol=tolerance)


def test_ends_of_loops_act_on_each_other():
    hinge = Revolute((0, 0, 1))
    body = Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-4, 8e-4, 8e-4]))
    links = [
        Link("a", joint=hinge, body=body),
        Link("b", parent="a", position=(0.2, 0, 0), joint=hinge, body=body),
    ]
    ends = (("b", None, (0.2, 0, 0)), (None, None, (0.25, 0.1, 0)))
    forces = []
    for first, second in (ends, ends[::-1]):
        robot = Robot(links, gravity=(0, -9.81, 0), loops=[Loop(first, second, Spherical())])
        motion = lissom.simulate(robot, 0.1, q0=[0.9, -1.5])
        forces.append(robot.loop_forces(motion.q[-1], motion.v[-1], motion.a[-1]))
    np.testing.assert_allclose(forces[0], -forces[1], rtol=0, atol=1e-9)
    # The forces of both hinges balance the weight.
    zeros = np.zeros(2)
    rest = lissom.statics(robot, q0=[0.9, -1.5])
    held = robot.joint_wrench(rest.q, zeros, zeros, link="a")[3:]
    pinned = robot.loop_forces(rest.q, zeros, zeros)[3:]
    np.testing.assert_allclose(held + pinned, [0, 0.4 * 9.81, 0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", ["newmark", "dop853", "rk45", "radau"])
def test_a_truss_stands(method):
    """Two bars that lean on each other at 60 degrees: the thrust is half a weight over tan 60 degrees."""
    hinge = Revolute((0, 0, 1))
    bar = Body(1.0, centre=(0.5, 0, 0), inertia=np.diag([1e-3, 1 / 12, 1 / 12]))
    links = [
        Link("left", orientation=about_z(np.pi / 3), joint=hinge, body=bar),
        Link("right", position=(1, 0, 0), orientation=about_z(2 * np.pi / 3), joint=hinge, body=bar),
    ]
    apex = Loop(("left", None, (1, 0, 0)), ("right", None, (1, 0, 0)), Spherical(), name="apex")
    truss = Robot(links, gravity=(0, -9.81, 0), loops=[apex])
    motion = lissom.simulate(truss, 0.5, method=method)
    assert motion.success, motion.message
    np.testing.assert_allclose(motion.q, 0, atol=1e-12)
    zeros = np.zeros(2)
    thrust = truss.loop_forces(zeros, zeros, zeros)[3:]
    np.testing.assert_allclose(thrust, [9.81 / (2 * np.sqrt(3)), 0, 0], atol=1e-9)
    assert lissom.modes(truss, zeros).frequency.size == 0


def two_bars(reach, kind=None):
    """Two bars of 0.2 m, with their end tied to a point at the distance `reach`."""
    hinge = Revolute((0, 1, 0))
    body = Body(0.1, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 4e-4, 4e-4]))
    links = [
        Link("a", joint=hinge, body=body),
        Link("b", parent="a", position=(0.2, 0, 0), joint=hinge, body=body),
    ]
    return Robot(
        links, loops=[Loop(("b", None, (0.2, 0, 0)), (None, None, (reach, 0, 0)), kind or Spherical())]
    )


@pytest.mark.parametrize("reach", [0.40001, 0.4001, 0.401, 0.5])
@pytest.mark.parametrize("start", [None, [0.0, 0.0], [0.3, -0.5]])
def test_bars_that_do_not_reach_are_no_equilibrium(reach, start):
    robot = two_bars(reach)
    for attempt in (
        lambda: lissom.statics(robot, q0=start),
        lambda: lissom.statics(robot, q0=start if start is not None else [0, 0], method="newton"),
        lambda: lissom.simulate(robot, 0.1, q0=start),
        lambda: lissom.simulate(robot, 0.1, q0=start, method="dop853"),
    ):
        with pytest.raises(ValueError, match="open loop"):
            attempt()


def test_singular_starts_are_left():
    """Straight arms and coincident ends: no motion closes the loop to first order."""
    for robot in (two_bars(0.39999), two_bars(0.38), two_bars(0.4, Distance(0.1))):
        for found in (lissom.statics(robot), lissom.simulate(robot, 0.01)):
            assert found.success, found.message
            q = np.atleast_2d(found.q)[-1]
            assert np.abs(robot.loop_gaps(q)).max() < 1e-9


@pytest.mark.parametrize("other", [None, "arm", "hand", "tip"])
def test_ends_on_links_that_are_welded_together(other):
    """Each link is displaced from their common place."""
    body = Body(0.1, inertia=1e-4 * np.eye(3))
    turned = (0.8, 0.0, 0.6, 0.0)
    links = [
        Link("arm", joint=Revolute((0, 1, 0)), body=body),
        Link("hand", parent="arm", position=(0.3, 0.1, -0.2), orientation=turned, body=body),
        Link("tip", parent="hand", position=(0.0, 0.2, 0.1), body=body),
    ]
    free = Robot(links)
    for name in ("arm", "hand", "tip"):
        offset = (0.05, -0.02, 0.03)
        place = (free.pose([0.4], link=name) @ [*offset, 1.0])[:3]
        loops = [Loop((name, None, offset), (None, None, place), Spherical(), name="pin")]
        if other is not None:
            loops.insert(0, Loop(other, (None, None), lissom.Planar((0, 1, 0))))
        gaps = Robot(links, loops=loops).loop_gaps([0.4])
        np.testing.assert_allclose(gaps[-3:], 0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.3, 1.5, 1.7, 2.5, 3.1])
@pytest.mark.parametrize(
    "joint", [Weld(), Revolute((0, 0, 1)), Prismatic((0, 0, 1)), lissom.Cylindrical((0, 1, 1))]
)
def test_ends_that_are_turned_away_are_turned_back(angle, joint):
    """Gaps of angles vanish at half a turn, too. An equilibrium there would be one of another joint."""
    rng = np.random.default_rng(3)
    body = Body(1.0, centre=(0.1, 0.02, 0), inertia=np.diag([1e-3, 2e-3, 2e-3]))
    for _ in range(5):
        axis = rng.normal(size=3)
        links = [Link("hand", joint=Free(), body=body)]
        robot = Robot(links, loops=[Loop("hand", (None, None, (0.1, 0, 0.2)), joint)], gravity=(0, 0, 0))
        start = np.concatenate([rng.normal(size=3) * 0.1, angle * axis / np.linalg.norm(axis)])
        found = lissom.statics(robot, start)
        assert found.success, found.message
        pose = robot.pose(found.q, link="hand")
        shared = {"Weld": np.eye(3), "Prismatic": np.eye(3)}.get(type(joint).__name__)
        if shared is None:
            shared = np.array([joint.axis]) / np.linalg.norm(joint.axis)
        np.testing.assert_allclose(pose[:3, :3] @ shared.T, shared.T, atol=1e-9)


def test_loops_between_links_that_are_welded_together_are_refused():
    """They hold what a weld holds already."""
    body = Body(0.1, inertia=1e-4 * np.eye(3))
    soft = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 1})
    stiff = lissom.Segment(0.1, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={})
    links = [
        Link("arm", joint=Revolute((0, 1, 0)), body=body),
        Link("hand", parent="arm", position=(0.3, 0, 0), body=body),
        Link("rod", parent="hand", rod=[stiff, soft, stiff, stiff]),
        Link("tip", parent="rod", body=body),
        Link("post", body=body),
    ]
    welded = [
        ("arm", "hand"),
        ("hand", ("rod", 0.1)),
        (("rod", 0.0), "arm"),
        (("rod", 0.2), "tip"),
        (("rod", 0.3), ("rod", 0.4)),
        ("post", None),
    ]
    for kind in (Spherical(), lissom.Weld(), Distance(0.2)):
        for a, b in welded:
            with pytest.raises(ValueError, match=r"loops\[0\].b: got ends on .* which are welded together"):
                Robot(links, loops=[Loop(a, b, kind)])
    for a, b in [("hand", "tip"), ("hand", ("rod", 0.15)), (("rod", 0.1), ("rod", 0.2)), ("arm", "post")]:
        Robot(links, loops=[Loop(a, b, Spherical())])
    moving = lissom.BaseMotion(angle=lambda t: 0.1 * t, axis=(0, 0, 1))
    Robot(links, loops=[Loop("post", None, Spherical())], base_motion=moving)


def test_default_names_of_loops_do_not_collide():
    bars = two_bars(0.3)
    (given,) = bars.loops
    more = [Loop(given.a, given.b, given.kind) for _ in range(2)]
    assert [
        each.name
        for each in Robot(bars.links, loops=[*more, Loop(given.a, given.b, given.kind, name="x")]).loops
    ] == [
        more[0].name,
        f"{more[0].name} 2",
        "x",
    ]
    with pytest.raises(ValueError, match='got "x", the name of another loop'):
        Robot(bars.links, loops=[Loop(given.a, given.b, given.kind, name="x")] * 2)


@pytest.mark.parametrize("method", ["newmark", "generalised_alpha"])
@pytest.mark.parametrize("dt", [1e-2, 1e-3])
def test_a_start_that_is_moved_to_fit_and_stays_is_not_doubted(method, dt):
    """Without weight and motion, what the loop's rounding moves is no energy that rises."""
    hinge = Revolute((0, 0, 1))
    body = Body(1.0, centre=(0.5, 0, 0), inertia=np.diag([1e-3, 1 / 12, 1 / 12]))
    links = [
        Link("crank", orientation=about_z(np.pi / 2), joint=hinge, body=body),
        Link(
            "coupler",
            parent="crank",
            position=(1, 0, 0),
            orientation=about_z(-np.pi / 2),
            joint=hinge,
            body=body,
        ),
        Link("rocker", position=(1, 0, 0), orientation=about_z(np.pi / 2), joint=hinge, body=body),
    ]
    pin = Loop(("rocker", None, (1, 0, 0)), ("coupler", None, (1, 0, 0)), hinge)
    robot = Robot(links, gravity=(0, 0, 0), loops=[pin])
    for start in ([0.3, -0.1, 0.2], [1e-3, 2e-3, -1e-3]):
        motion = lissom.simulate(robot, 0.5, q0=start, dt=dt, method=method)
        assert "start was moved by" in motion.message
        assert motion.doubt is None
        assert np.abs(motion.v).max() < 1e-9


def pinned(names, gravity=9.81, across=0.3):
    """Rods between two hinges, one beside the other, of different stiffness."""
    links, loops = [], []
    for i, name in enumerate(names):
        young = 1e6 * (2.0 + ord(name[-1]) % 3)
        wire = lissom.Segment(1.0, 0.01, young, 0.4 * young, 1000.0, {"bend_y": 4})
        hinge = lissom.Revolute((0, 1, 0))
        links.append(lissom.Link(name, rod=[wire], joint=hinge, position=(0, across * i, 0)))
        loops.append(lissom.Loop(name, (None, None, (0.9, across * i, 0)), hinge))
    return lissom.Robot(links, loops=loops, gravity=(0, 0, -gravity))


@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_rods_that_share_nothing_move_as_each_alone(method):
    names = ["rod a", "rod b", "rod c", "rod d"]
    row = pinned(names)
    q0 = lissom.statics(pinned(names, gravity=30.0)).q
    options = {"dt": 2e-3} if method == "newmark" else {"rtol": 1e-8, "atol": 1e-10}
    together = lissom.simulate(row, 0.2, q0=q0, method=method, **options)
    assert together.success
    assert np.abs(together.q - q0).max() > 0.1
    for name in names:
        own, rod = row.slice(name), pinned([name])
        alone = lissom.simulate(rod, 0.2, q0=q0[own], method=method, **options)
        assert_allclose(together.q[-1, own], alone.q[-1], atol=1e-6)
        for run, robot in ((together, row), (alone, rod)):
            assert np.abs(robot.loop_gaps(run.q[-1])).max() < 1e-9
        loop = f"{name} to the world"
        held, held_alone = (
            robot.loop_forces(run.q[-1], run.v[-1], run.a[-1], name=loop)
            for run, robot in ((together, row), (alone, rod))
        )
        assert_allclose(held, held_alone, rtol=1e-3, atol=1e-3)


def test_what_is_at_rest_does_not_keep_a_collision_from_converging():
    """Gaps of clamps are multiples of floating-point spacings: iterations that closed them opened them
    on the other side, and took four times the Jacobians."""
    rubber = lissom.Segment(
        0.2, 0.01, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 4, "bend_z": 4, "torsion": 4}
    )
    clamped = lissom.Link("clamped", rod=[rubber] * 6)
    clamp = lissom.Loop("clamped", (None, None, (1.1, 0, 0)), lissom.Weld())
    bar = lissom.Segment(0.1, 0.005, 1e8, poisson_ratio=0.5, density=1000, modes={"bend_y": 3, "bend_z": 3})
    whip = lissom.Link("whip", rod=[bar] * 4, joint=lissom.Revolute((0, 1, 0)), position=(0, 5, 0.2))
    floor = lissom.Contact("whip", lissom.HalfSpace((0, 0, 0), (0, 0, 1)), stiffness=3e8)
    alone = lissom.Robot([whip], contacts=[floor])
    both = lissom.Robot([whip, clamped], loops=[clamp], contacts=[floor])
    resting = lissom.statics(both, space_error=False)
    assert resting.success
    start = resting.q.copy()
    of_whip = both.slice("whip")
    start[of_whip] = 0.0
    start[of_whip.start] = 0.3
    speed = np.zeros(both.n)
    speed[of_whip.start] = 20.0
    steps = {"dt": 2.5e-5, "method": "generalised_alpha"}
    collision = lissom.simulate(alone, 0.02, q0=start[of_whip], v0=speed[of_whip], **steps)
    beside = lissom.simulate(both, 0.02, q0=start, v0=speed, **steps)
    assert collision.success
    assert beside.success
    assert collision.deepest.share > 0.01
    assert beside.stats.njev <= 2 * collision.stats.njev
    assert_allclose(beside.q[-1, of_whip], collision.q[-1], rtol=1e-6, atol=1e-9)
