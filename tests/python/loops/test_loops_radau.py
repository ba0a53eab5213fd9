"""Closed loops with Radau IIA and `auto`: published and exact solutions, orders, stiff rods, moving bases."""

import copy

import numpy as np
import pytest
from test_loops import (
    about_z,
    bricard,
    exact_windows,
    slider_crank,
    squeezer,
    windows,
    wire,
)

import lissom
from lissom import BaseMotion, Body, Free, Harmonic, Link, Loop, Revolute, Robot, Segment, Spherical, Weld


def radau(robot, t_end, tolerance, **options):
    motion = lissom.simulate(robot, t_end, method="radau", rtol=tolerance, atol=1e-2 * tolerance, **options)
    assert motion.success, motion.message
    return motion


def test_errors_fall_with_the_tolerance_and_forces_with_them():
    robot, v0 = windows(1)
    exact = exact_windows(1)
    wanted = radau(robot, 0.6, 1e-11, v0=v0, t_eval=[0.6])
    force = robot.loop_forces(wanted.q[-1], wanted.v[-1], wanted.a[-1])
    errors, of_forces = [], []
    for tolerance in (1e-4, 1e-6, 1e-8):
        motion = radau(robot, 0.6, tolerance, v0=v0, t_eval="steps")
        errors.append(np.abs(motion.q[:, 0] - exact(motion.t)).max())
        found = robot.loop_forces(motion.q[-1], motion.v[-1], motion.a[-1])
        of_forces.append(np.abs(found - force).max() / np.abs(force).max())
        assert np.abs(robot.loop_gaps(motion.q)).max() < 1e-13
        rates = np.gradient(robot.loop_gaps(motion.q), motion.t, axis=0)
        assert np.abs(rates).max() < 1e-8
        np.testing.assert_allclose(
            motion.balance.total, motion.balance.total[0], rtol=0, atol=300 * tolerance
        )
    for found in (errors, of_forces):
        assert found[0] < 1e-2
        assert found[1] < 0.05 * found[0]
        assert found[2] < 0.05 * found[1]


def test_singular_positions_are_passed_or_said():
    """All bars of the windows are horizontal about every 0.7 s."""
    robot, v0 = windows(2)
    exact = exact_windows(2)
    for tolerance in (1e-5, 1e-6, 1e-7, 1e-8):
        motion = lissom.simulate(
            robot, 4.0, v0=v0, method="radau", rtol=tolerance, atol=1e-2 * tolerance, t_eval="steps"
        )
        assert motion.success or motion.status in ("singular_position", "step_too_small")
        assert motion.t[-1] > 0.7
        assert np.abs(motion.q[:, 0] - exact(motion.t)).max() < 100 * tolerance


def test_forty_windows():
    robot, v0 = windows(40)
    motion = radau(robot, 1.0, 1e-6, v0=v0)
    angle = motion.q[-1][0] + np.pi / 2
    assert np.hypot(np.cos(angle) + 0.115356880632, np.sin(angle) + 0.993324111300) < 1e-6


@pytest.mark.parametrize(("tolerance", "error"), [(1e-6, 3e-6), (1e-7, 3e-7), (1e-9, 2e-7)])
def test_andrews_squeezer(tolerance, error):
    """Compared with PSIDE at 1e-14 (IVP test set). The telescope in place of its spring has a mass: 1e-7."""
    robot, q0 = squeezer()
    motion = radau(robot, 0.03, tolerance, q0=q0, t_eval=[0.03])
    wanted = [
        15.81077119629904,
        -15.75637105984298,
        0.04082224013073101,
        0.5244099658805304,
        -0.5347301163226948,
        1.048080741042263,
        0.5347301163226948,
    ]
    np.testing.assert_allclose(motion.q[-1][:7], wanted, rtol=0, atol=error)
    speeds = [1139.920302151208, -1424.379294994111, 11.03291221937134]
    np.testing.assert_allclose(motion.v[-1][:3], speeds, rtol=20 * error)
    np.testing.assert_allclose(motion.a[-1][0], -24631.76316945196, rtol=30 * error)


@pytest.mark.parametrize(("tolerance", "error"), [(1e-6, 5e-8), (1e-8, 2e-9)])
def test_bricard(tolerance, error):
    robot = bricard()
    answers = {
        0.5: (0.9682836791, -1.2246251594, 0.7501466094),
        1.0: (0.5105014612, -1.6491675994, 0.1401231146),
        2.0: (-0.9693403448, -1.2212468950, 0.7542780108),
        5.0: (0.9999999977, -1.0000672577, 0.9999327400),
        10.0: (0.999999964, -1.000269013, 0.999730951),
    }
    motion = radau(robot, 10.0, tolerance, t_eval=list(answers))
    points = robot.pose(motion.q, link="rod3")[:, :3, 3]
    np.testing.assert_allclose(points, list(answers.values()), rtol=0, atol=error)
    np.testing.assert_allclose(motion.balance.total, motion.balance.total[0], rtol=0, atol=30 * error)


def test_spatial_slider_crank():
    robot, v0 = slider_crank()
    answers = {
        0.1: (0.226787188553, 0.305277006936, 5.828888134673),
        0.5: (0.184952629778, -0.004560290643, 14.408160810197),
        1.0: (0.211721661397, -0.503491864937, 10.427593000314),
        2.0: (0.289085197052, 0.216539424793, 22.584240011467),
        5.0: (0.240719573872, -0.595984412325, 11.494996275644),
    }
    motion = radau(robot, 5.0, 1e-6, v0=v0, t_eval=list(answers))
    found = np.column_stack([motion.q[:, 4] + 0.2, motion.v[:, 4], motion.v[:, 0]])
    errors = np.abs(found - list(answers.values())).max(axis=0)
    assert errors[0] < 2e-6
    assert errors[1] < 1e-5
    assert errors[2] < 1e-4


def cut(modes, is_cut, retardation_time=0.0):
    """A wire with a body at its tip, welded as a link, or floating and welded by a loop."""
    body = Body(0.2, centre=(0.1, 0.02, 0), inertia=np.diag([1e-3, 2e-3, 2e-3]))
    rod = Segment(0.5, 1e-3, 2e11, 8e10, 7800, modes, retardation_time=retardation_time)
    links = [Link("arm", rod=[rod], joint=Revolute((0, 1, 0)))]
    if not is_cut:
        return Robot([*links, Link("hand", parent="arm", joint=Weld(), body=body)])
    links.append(Link("hand", position=(0.5, 0, 0), joint=Free(), body=body))
    return Robot(links, loops=[Loop("arm", "hand", Weld())])


STIFF = {"bend_y": 3, "bend_z": 3, "torsion": 2, "shear_y": 2, "shear_z": 2, "stretch": 2}


@pytest.mark.parametrize("modes", [{"bend_y": 3, "bend_z": 3, "torsion": 2}, STIFF])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_a_weld_cut_and_closed_again_costs_no_steps(modes, tolerance):
    """Stiff strains of a thin wire do not reduce the steps: the tree takes as many."""
    tree, loop = (cut(modes, is_cut, 1e-5) for is_cut in (False, True))
    right = radau(tree, 0.1, 1e-8)
    moved, tied = (radau(robot, 0.1, tolerance) for robot in (tree, loop))
    assert tied.stats.steps < 1.3 * moved.stats.steps + 10
    errors = [np.abs(motion.q[:, : tree.n] - right.q).max() for motion in (moved, tied)]
    assert errors[1] < 3 * errors[0] + 1e-9
    i = len(tied.t) // 2
    held = loop.loop_forces(tied.q[i], tied.v[i], tied.a[i])
    passed = tree.joint_wrench(right.q[i], right.v[i], right.a[i], link="hand")
    np.testing.assert_allclose(held, passed, rtol=0, atol=10 * tolerance * np.abs(passed).max())


def test_a_released_arch_keeps_its_energy():
    """An elastica between pins, released from any shape, compared with another method's small steps."""
    arm = Link("rod", rod=[wire(bend_y=6)], joint=Revolute((0, 1, 0)))
    arch = Robot([arm], gravity=(0, 0, 0), loops=[Loop("rod", (None, None, (0.9, 0, 0)), Spherical())])
    q0 = np.zeros(arch.n)
    q0[2], q0[1] = 1.0, 0.5
    right = radau(arch, 0.05, 1e-7, q0=q0)
    drift = np.abs(right.balance.total - right.balance.total[0]).max()
    assert drift < 1e-6 * right.balance.total[0]
    errors = []
    for dt in (2e-5, 1e-5):
        steps = lissom.simulate(arch, 0.05, q0=q0, dt=dt, t_eval=right.t, rtol=1e-8, atol=1e-6)
        errors.append(np.abs(steps.q - right.q).max())
    assert errors[1] < 1e-2
    assert 3.0 < errors[0] / errors[1] < 5.0


def shaken_bars():
    """Bars pinned to the world on a shaken base; and the same with a prescribed joint."""
    hinge = Revolute((0, 0, 1))
    body = Body(1.0, centre=(0.5, 0, 0), inertia=np.diag([1e-3, 1 / 12, 1 / 12]))
    motion = BaseMotion(translation=Harmonic(amplitude=(0.1, 0.05, 0), frequency=1.0))

    def bars(parent=None):
        turn = about_z(-np.pi / 2)
        return [
            Link("crank", parent=parent, orientation=about_z(np.pi / 2), joint=hinge, body=body),
            Link("coupler", parent="crank", position=(1, 0, 0), orientation=turn, joint=hinge, body=body),
            Link("rocker", parent="coupler", position=(1, 0, 0), orientation=turn, joint=hinge, body=body),
        ]

    def pin():
        return Loop(("rocker", None, (0.8, 0, 0)), (None, None, (1.2, 0.1, 0)), Spherical(), name="pin")

    base = Robot(bars(), gravity=(0, -9.81, 0), loops=[pin()], base_motion=motion)
    cart = Link("cart", joint=Free(motion=motion), body=Body(1.0))
    return base, Robot([cart, *bars("cart")], gravity=(0, -9.81, 0), loops=[pin()])


def test_a_base_that_moves_is_a_joint_that_does():
    base, cart = shaken_bars()
    times = np.linspace(0, 1, 11)
    right = lissom.simulate(cart, 1.0, method="dop853", t_eval=times, rtol=1e-10, atol=1e-12)
    for method, options, error in (
        ("dop853", {"rtol": 1e-10, "atol": 1e-12}, 1e-12),
        ("radau", {"rtol": 1e-9, "atol": 1e-11}, 1e-9),
        ("generalised_alpha", {"dt": 4e-4, "rtol": 1e-10, "atol": 1e-12}, 2e-4),
    ):
        motion = lissom.simulate(base, 1.0, method=method, t_eval=times, **options)
        assert motion.success, motion.message
        np.testing.assert_allclose(motion.q, right.q, rtol=0, atol=error)
        # Methods with adaptive steps interpolate in between.
        assert np.abs(base.loop_gaps(motion.q, t=motion.t)).max() < 1e-9
        forces = [
            [
                robot.loop_forces(q, v, robot.forward_dynamics(q, v, t=t), t=t)
                for q, v, t in zip(run.q, run.v, times, strict=True)
            ]
            for robot, run in ((base, motion), (cart, right))
        ]
        np.testing.assert_allclose(forces[0], forces[1], rtol=0, atol=1e3 * error)


@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_a_moving_base_works_against_its_loops(method):
    base, _ = shaken_bars()
    motion = lissom.simulate(base, 1.0, method=method, rtol=1e-8, atol=1e-10, max_step=2e-3)
    assert motion.success, motion.message
    assert np.ptp(motion.balance.work) > 1.0
    assert motion.balance.drift < 1e-6


def test_a_base_that_turns_about_its_loop():
    """A pin in the world stays while the base rotates: the bars fold as in the rotating frame."""
    hinge = Revolute((0, 0, 1))
    body = Body(0.5, centre=(0.1, 0, 0), inertia=np.diag([1e-4, 2e-3, 2e-3]))
    spin = BaseMotion(axis=(0, 0, 1), angle=lambda t: 2.0 * t)
    links = [
        Link("a", position=(0.05, 0, 0), joint=hinge, body=body),
        Link("b", parent="a", position=(0.2, 0, 0), joint=hinge, body=body),
    ]
    robot = Robot(
        links,
        gravity=(0, 0, 0),
        loops=[Loop(("b", None, (0.2, 0, 0)), (None, None, (0.25, 0.1, 0)), Spherical())],
        base_motion=spin,
    )
    q0 = [0.9, -1.5]
    for method in ("newmark", "radau", "dop853"):
        motion = lissom.simulate(robot, 0.3, q0=q0, method=method)
        assert motion.success, motion.message
        tips = [
            robot.pose(q, link="b", t=t)[:3, :3] @ [0.2, 0, 0] + robot.pose(q, link="b", t=t)[:3, 3]
            for q, t in zip(motion.q, motion.t, strict=True)
        ]
        np.testing.assert_allclose(tips, np.broadcast_to([0.25, 0.1, 0], (len(tips), 3)), atol=1e-6)


def test_runs_to_an_accuracy_hold_loops():
    robot, v0 = windows(1)
    for accuracy in (1e-3, 1e-5):
        motion = lissom.simulate(robot, 0.6, v0=v0, method="auto", rtol=accuracy)
        assert motion.success, motion.message
        assert "radau" in motion.message
        assert "not estimated" in motion.message
        assert np.abs(motion.q[:, 0] - exact_windows(1)(motion.t)).max() < accuracy
    rod = Segment(1.0, 0.01, 1e7, 4e6, 1100, {"bend_y": 4}, retardation_time=0.01)
    arch = Robot(
        [Link("rod", rod=[rod], joint=Revolute((0, 1, 0)))],
        loops=[Loop("rod", (None, None, (0.95, 0, 0)), Spherical())],
    )
    q0 = [0.0, 0.2, 0.6, 0.0, 0.0]
    motion = lissom.simulate(arch, 0.3, q0=q0, method="auto", rtol=1e-3)
    assert motion.stats.time_error <= 1e-3
    assert motion.stats.space_error is not None, motion.message
    assert "moved by" in motion.message
    right = lissom.simulate(arch, 0.3, q0=q0, method="radau", rtol=1e-7, atol=1e-9, t_eval=motion.t)
    middles = [arch.pose(run.q, X=0.5, link="rod")[:, :3, 3] for run in (motion, right)]
    assert np.abs(middles[0] - middles[1]).max() < 1e-3


def test_copies_go_on_bit_by_bit():
    robot, v0 = windows(1)
    simulation = lissom.Simulation(robot, dt=0.05, v0=v0, method="radau")
    for _ in range(5):
        simulation.step()
    other = copy.deepcopy(simulation)
    for _ in range(5):
        simulation.step()
        other.step()
    assert simulation.success, simulation.message
    for values in ("q", "v", "a"):
        np.testing.assert_array_equal(getattr(other, values), getattr(simulation, values))


@pytest.mark.parametrize("base", [None, BaseMotion(translation=Harmonic((0, 0, 0.03), 1.5))])
def test_auto_takes_loops_that_leave_no_stiffness(base):
    """Bars at rest where nothing but rounding restores them: that is no frequency to be followed."""
    hinge = Revolute((0, 1, 0))
    bar = Body(0.2, centre=(0.15, 0, 0), inertia=(1e-4, 2e-3, 2e-3))
    free = Link("outer", joint=Free(), position=(0.3, 0, 0), body=bar)
    inner = Link("inner", joint=hinge, body=bar)
    outer = Link("outer", parent="inner", joint=hinge, position=(0.3, 0, 0), body=bar)
    of_two = Robot(
        [inner, free], base_motion=base, loops=[Loop(("inner", None, (0.3, 0, 0)), "outer", hinge)]
    )
    # A hinge in the world does not move with the base: the bar leaves that with a jerk about the hinge.
    rate = 0.0 if base is None else -0.2 * (2 * np.pi * 1.5 * 0.03) * 0.15 / (2e-3 + 0.2 * 0.15**2)
    of_one = Robot([free], base_motion=base, loops=[Loop((None, None, (0.3, 0, 0)), "outer", hinge)])
    hung = Robot([Link("outer", joint=hinge, position=(0.3, 0, 0), body=bar)])
    for closed, tree, v0 in ((of_two, Robot([inner, outer], base_motion=base), None), (of_one, hung, [rate])):
        motion = lissom.simulate(closed, 0.4, method="auto", t_eval=[0.4])
        assert motion.success, motion.message
        exact = lissom.simulate(tree, 0.4, v0=v0, method="dop853", rtol=1e-10, atol=1e-10, t_eval=[0.4])
        pose = closed.pose(motion.q[-1], link="outer", t=0.4)
        np.testing.assert_allclose(pose, tree.pose(exact.q[-1], link="outer", t=0.4), atol=1e-4)


@pytest.mark.parametrize("rtol", [1e-8, 1e-9])
def test_damped_rods_in_loops_are_followed_to_tight_tolerances(rtol):
    """Rounding of gaps over the short steps of the first moment must not count as an error of these steps."""
    quarter = 0.5**0.5
    down, ahead = (quarter, 0, 0, -quarter), (quarter, 0, 0, quarter)
    hinge = lissom.Revolute((0, 0, 1))

    def bar(length):
        modes = {"bend_z": 2}
        return [lissom.Segment(length, 0.01, 1e7, None, 1100.0, modes, 0.02, poisson_ratio=0.45)]

    links = [
        lissom.Link("crank", joint=hinge, rod=bar(0.2), orientation=down),
        lissom.Link("coupler", parent="crank", joint=hinge, rod=bar(0.4), orientation=ahead),
        lissom.Link("rocker", position=(0.4, 0, 0), joint=hinge, rod=bar(0.2), orientation=down),
    ]
    pin = lissom.Loop(("rocker", 0.2), ("coupler", 0.4), hinge, name="pin")
    robot = lissom.Robot(links, gravity=(0, -9.81, 0), loops=[pin])
    v0 = np.zeros(robot.n)
    v0[0] = 2.0
    loose, tight = (
        lissom.simulate(robot, 0.1, v0=v0, method="radau", rtol=tolerance, atol=1e-2 * tolerance, dt=0.02)
        for tolerance in (1e-6, rtol)
    )
    assert tight.success, tight.message
    np.testing.assert_allclose(tight.q, loose.q, atol=1e-6)
    assert np.abs(robot.loop_gaps(tight.q[-1])).max() < 1e-12
