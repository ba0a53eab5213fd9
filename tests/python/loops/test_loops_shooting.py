"""Closed loops of rods compared with shooting: Cosserat's equations in SciPy, independent of lissom."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve
from scipy.spatial.transform import Rotation

import lissom
from lissom import Body, Distance, Free, Link, Load, Loop, Revolute, Robot, Segment, Weld

#: The parallel robot of Till and others (2015): wires, holes, mass of the plate.
YOUNG, SHEAR, RADIUS, DENSITY, LENGTH = 200e9, 80e9, 1e-3, 8000.0, 0.4
HOLES, MASS, GRAVITY = 0.087, 0.1, 9.81
BELOW = np.radians([-10, 10, 110, 130, 230, 250])
ABOVE = np.radians([-50, 50, 70, 170, 190, 290])

#: Displacements of the wires, and a force on the plate in a general direction.
PUSHED = np.array([0.01, -0.005, 0.015, 0.0, -0.01, 0.02])
FORCE = np.array([0.7, -0.4, -1.5])

#: Weight of the plate, and properties of the sections.
PLATE = np.array([0, 0, MASS * GRAVITY])
AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4


def ring(angles, heights=0.0):
    return np.stack([HOLES * np.cos(angles), HOLES * np.sin(angles), np.broadcast_to(heights, 6)], axis=1)


def shot_wires():
    """Pose of the plate and tips of inextensible wires: 6 unknowns for each of 6 wires, and 6 for the plate.

    Sections have d3 along the wire. The state of a wire: position, rotation matrix, force and moment in world
    axes.
    """
    soft = 1 / np.array([SHEAR * AREA, SHEAR * AREA, YOUNG * AREA])
    stiff_angular = np.array([YOUNG * SECOND, YOUNG * SECOND, SHEAR * 2 * SECOND])
    weight = np.array([0, 0, -DENSITY * AREA * GRAVITY])

    def rates(_, state, compliance):
        y = state.reshape(6, 18)
        turn, n, m = y[:, 3:12].reshape(6, 3, 3), y[:, 12:15], y[:, 15:18]
        u = np.einsum("wji,wj->wi", turn, m) / stiff_angular
        stretched = np.einsum("wji,wj->wi", turn, n) * compliance + [0, 0, 1]
        along = np.einsum("wij,wj->wi", turn, stretched)
        # The columns of R hat(u).
        columns = np.cross(u[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)
        turned = turn @ columns
        flat = [along, turned.reshape(6, 9), np.broadcast_to(-weight, (6, 3)), -np.cross(along, n)]
        return np.concatenate(flat, axis=1).ravel()

    bases = ring(BELOW, PUSHED)

    def tips(reactions, compliance, tolerance):
        start = np.concatenate([bases, np.tile(np.eye(3).ravel(), (6, 1)), reactions], axis=1)
        options = {"method": "DOP853", "rtol": tolerance, "atol": 1e-2 * tolerance, "args": (compliance,)}
        return solve_ivp(rates, (0, LENGTH), start.ravel(), **options).y[:, -1].reshape(6, 18)

    def misses(unknowns, *options):
        reactions, place, vector = unknowns[:36].reshape(6, 6), unknowns[36:39], unknowns[39:]
        plate = Rotation.from_rotvec(vector).as_matrix()
        end = tips(reactions, *options)
        axes, n, m = end[:, 3:12].reshape(6, 3, 3), end[:, 12:15], end[:, 15:18]
        arms = ring(ABOVE) @ plate.T
        positions = end[:, :3] - (place + arms)
        # Wires leave perpendicular to the plate, and may twist freely: no torsion there.
        across = np.einsum("i,wij->wj", plate[:, 2], axes)[:, :2]
        torsion = np.einsum("wi,wi->w", m, axes[:, :, 2])
        force = FORCE - PLATE - n.sum(axis=0)
        moment = -(m + np.cross(arms, n)).sum(axis=0)
        return np.concatenate([positions.ravel(), across.ravel(), torsion, force, moment])

    # Initial guess: S-shaped wires by linear beam theory, which carry a horizontal plate.
    ways = ring(ABOVE) - ring(BELOW)
    forces = 12 * YOUNG * SECOND / LENGTH**3 * ways + (FORCE - PLATE) / 6
    moments = 6 * YOUNG * SECOND / LENGTH**2 * np.cross([0, 0, 1], ways)
    guess = np.concatenate([np.concatenate([forces, moments], axis=1).ravel(), [0, 0, 0.395], np.zeros(3)])
    near = newton(lambda x: misses(x, soft, 1e-6), guess, 1e-5)
    exact = (np.zeros(3), 1e-10)
    found = newton(lambda x: misses(x, *exact), near, 1e-9)
    reactions, place, vector = found[:36].reshape(6, 6), found[36:39], found[39:]
    return place, vector, tips(reactions, *exact)


def newton(misses, x, tolerance):
    """A root by Newton's method with forward differences, damped until the residual decreases."""
    for _ in range(40):
        residual = misses(x)
        size = np.linalg.norm(residual)
        if size < tolerance:
            return x
        jacobian = np.stack([(misses(x + step) - residual) / 1e-7 for step in 1e-7 * np.eye(len(x))], axis=1)
        change, part = np.linalg.solve(jacobian, residual), 1.0
        while np.linalg.norm(misses(x - part * change)) > size and part > 1e-3:
            part /= 2
        x = x - part * change
    raise AssertionError(f"shooting did not converge: {size}")


def six_wires(modes):
    """The same in lissom: wires along their x axis, plate with a free joint."""
    up = (0.5**0.5, 0, -(0.5**0.5), 0)
    rod = [Segment(LENGTH, RADIUS, YOUNG, SHEAR, DENSITY, modes)]
    body = Body(MASS, inertia=np.diag([2e-4, 2e-4, 4e-4]))
    links = [Link("plate", joint=Free(), body=body)]
    loops = []
    bases, holes = ring(BELOW, PUSHED), ring(ABOVE)
    for i in range(6):
        links.append(Link(f"wire {i}", position=bases[i], orientation=up, rod=rod))
        hole = ("plate", None, holes[i], up)
        loops.append(Loop(f"wire {i}", hole, Revolute((1, 0, 0)), name=f"hole {i}"))
    loads = [Load(force=FORCE, link="plate")]
    return Robot(links, loops=loops, loads=loads, gravity=(0, 0, -GRAVITY))


def bent_like_an_s(robot):
    """An initial shape: the holes of the plate are beside those of the base."""
    q0 = np.zeros(robot.n)
    q0[2] = 0.395
    ways = -6 * (ring(ABOVE) - ring(BELOW)) / LENGTH**2
    for i in range(6):
        q0[robot.coordinates.index(f"wire {i}.bend_y[1]")] = ways[i, 0]
        q0[robot.coordinates.index(f"wire {i}.bend_z[1]")] = ways[i, 1]
    return q0


@pytest.mark.slow
@pytest.mark.parametrize("method", ["descent", "newton"])
def test_six_wires_hold_a_plate(method):
    """Remaining errors: 2e-9 m and 1e-6 N with 8 modes of bending, 6e-9 m and 2e-6 N with 6."""
    modes = {"torsion": 3, "bend_y": 8, "bend_z": 8}
    robot = six_wires(modes)
    rest = lissom.statics(robot, bent_like_an_s(robot), method=method)
    assert rest.success, rest.message
    assert rest.stability == "stable"
    assert np.abs(robot.loop_gaps(rest.q)).max() < 1e-9
    pose = robot.pose(rest.q, link="plate")
    place, vector, tips = shot_wires()
    np.testing.assert_allclose(pose[:3, 3], place, rtol=0, atol=1e-8)
    np.testing.assert_allclose(pose[:3, :3], Rotation.from_rotvec(vector).as_matrix(), rtol=0, atol=1e-7)
    zeros = np.zeros(robot.n)
    for i in range(6):
        held = robot.loop_forces(rest.q, zeros, zeros, name=f"hole {i}")
        # The wrench at the wire's tip is transmitted to the plate, the second end.
        np.testing.assert_allclose(held[3:], -tips[i, 12:15], rtol=0, atol=5e-6)
        np.testing.assert_allclose(held[:3], -tips[i, 15:18], rtol=0, atol=5e-7)


def test_six_wires_move_a_plate_alike_by_radau_and_in_many_runs():
    """30 constraints on 36 coordinates, from an inconsistent shape: fixed steps converge to Radau IIA."""
    robot = six_wires({"torsion": 1, "bend_y": 2, "bend_z": 2})
    given = {"t_end": 0.02, "q0": bent_like_an_s(robot)}

    def place(**options):
        run = lissom.simulate(robot, **given, **options)
        assert run.success, run.message
        return robot.pose(run.q[-1], link="plate")[:3, 3]

    exact = place(method="radau", rtol=1e-6)
    np.testing.assert_allclose(place(method="radau", rtol=1e-5), exact, rtol=0, atol=1e-8)
    errors = [np.abs(place(method="generalised_alpha", dt=dt) - exact).max() for dt in (2e-4, 5e-5)]
    assert errors[0] < 5e-5
    assert errors[1] < 1e-6
    fixed = {"method": "generalised_alpha", "dt": 2e-4}
    alone = lissom.simulate(robot, **given, **fixed)
    starts = np.stack([given["q0"], 0.99 * given["q0"]])
    for workers in (1, 2):
        many = lissom.simulate_many(robot, 0.02, q0=starts, workers=workers, **fixed)
        assert list(many.status) == ["finished"] * 2
        np.testing.assert_array_equal(many.q[0], alone.q)


#: An arch from a wire of a metre between clamps at a smaller distance.
STIFFNESS, SPAN = YOUNG * SECOND, 0.95


def arch_from_its_clamp(push, moment, thrust, lift):
    """The inextensible arch with a downward force on its middle, from the wrench of its first clamp: an
    elastica.

    Returns position (2,), angle and moment at the middle and at the second clamp.
    """

    def rates(_, y, thrust, lift):
        angle, moment = y[2:]
        return [
            np.cos(angle),
            np.sin(angle),
            moment / STIFFNESS,
            lift * np.cos(angle) - thrust * np.sin(angle),
        ]

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
    middle = solve_ivp(rates, (0, 0.5), [0, 0, 0, moment], args=(thrust, lift), **options).y[:, -1]
    return middle, solve_ivp(rates, (0, 0.5), middle, args=(thrust, lift - push), **options).y[:, -1]


def missed_clamp(push, unknowns):
    return arch_from_its_clamp(push, *unknowns)[1][:3] - [SPAN, 0, 0]


def shot_arch(push, guess):
    """Wrench of the first clamp, and height of the middle."""
    found = newton(lambda x: missed_clamp(push, x), np.asarray(guess, float), 1e-10)
    return found, arch_from_its_clamp(push, *found)[0][1]


def sways(push, guess):
    """A determinant that vanishes where the symmetric arch can sway with its second clamp fixed."""

    def misses(unknowns):
        middle = arch_from_its_clamp(push, *unknowns, push / 2)[0]
        return middle[[0, 2]] - [SPAN / 2, 0]

    unknowns = np.array([*newton(misses, np.asarray(guess, float), 1e-11), push / 2])
    steps = 1e-5 * np.eye(3)
    columns = [missed_clamp(push, unknowns + step) - missed_clamp(push, unknowns - step) for step in steps]
    return np.linalg.det(np.stack(columns, axis=1) / 2e-5)


def arch(push, modes=10):
    half = Segment(0.5, RADIUS, YOUNG, SHEAR, DENSITY, {"bend_y": modes})
    return Robot(
        [Link("arch", rod=[half, half])],
        gravity=(0, 0, 0),
        loads=[Load(force=(0, 0, -push), link="arch", at=0.5)],
        loops=[Loop("arch", (None, None, (SPAN, 0, 0)), Weld(), name="clamp")],
    )


def test_an_arch_between_clamps_is_pushed_through():
    """Compared with the elastica. Remaining errors with 10 modes per half: 3e-9 m and 3e-7 N."""
    robot = arch(1.0)
    q0 = np.zeros(robot.n)
    q0[[1, 11]] = 2.8, -2.8
    rest = lissom.statics(arch(1e-12), q0)
    assert rest.success
    path = lissom.continuation(robot, rest.q, bounds=(-1.0, 8.0), max_step=0.1).path
    place = robot.pose(path.q, 0.5, link="arch")[:, :3, 3]
    # It stays symmetric, unstable from where it would sway.
    np.testing.assert_allclose(place[:, 0], SPAN / 2, rtol=0, atol=1e-6)
    (critical,) = path.critical_points
    assert critical.kind == "bifurcation"
    assert place[critical.index, 2] > 0.13
    assert path.stability[critical.index - 1] == "stable"
    assert path.stability[critical.index + 1] == "divergence"
    # It sways, until it hangs in the mirrored shape.
    along = {"load_factor": critical.load_factor, "direction": critical.directions[0]}
    path = lissom.continuation(robot, critical.q, bounds=(-4.5, 8.0), max_step=0.1, **along).path
    height = robot.pose(path.q, 0.5, link="arch")[:, 2, 3]
    assert height[-1] < -0.13
    zeros = np.zeros(robot.n)
    for i in np.linspace(1, len(height) - 1, 7).astype(int):
        push = path.load_factor[i]
        held = arch(push).loop_forces(path.q[i], zeros, zeros)
        moment = -STIFFNESS * robot.strain(path.q[i], 0.0, link="arch")[1]
        (_, thrust, lift), middle = shot_arch(push, [moment, held[3], push + held[5]])
        np.testing.assert_allclose(height[i], middle, rtol=0, atol=1e-8)
        np.testing.assert_allclose(held[[3, 5]], [thrust, lift - push], rtol=0, atol=1e-6)
    wanted = brentq(sways, 4.6, 4.8, args=([0.31, 12.8],), xtol=1e-9)
    assert critical.load_factor == pytest.approx(wanted, rel=1e-7)


def test_newtons_method_judges_stability_as_descent_does():
    """A strut between pins, straight beyond Euler's load and buckled; and a plate on six wires."""
    strut = Robot(
        [
            Link(
                "strut",
                joint=Revolute((0, 1, 0)),
                rod=[Segment(1.0, RADIUS, YOUNG, SHEAR, DENSITY, {"bend_y": 6})],
            )
        ],
        gravity=(0, 0, 0),
        loops=[Loop("strut", (None, None, (0.9, 0, 0)), Revolute((0, 1, 0)))],
    )
    start = np.zeros(strut.n)
    start[:3] = -0.6, 1.2, 0.1
    bent = lissom.statics(strut, start, method="descent")
    again = lissom.statics(strut, bent.q, method="newton")
    assert bent.success
    assert again.success
    assert bent.stability == again.stability == "stable"
    np.testing.assert_allclose(again.q, bent.q, rtol=0, atol=1e-7)
    assert again.lowest_eigenvalue == pytest.approx(bent.lowest_eigenvalue, rel=1e-5)
    # The second buckled shape, an S, is unstable and goes to the first.
    start[:5] = 0.63, 0.0, 3.8, 0.0, -4.6
    second = lissom.statics(strut, start, method="newton")
    assert second.success, second.message
    assert second.stability == "divergence"
    assert np.abs(second.q[2]) > 1.0
    robot = six_wires({"torsion": 2, "bend_y": 3, "bend_z": 3})
    rest = lissom.statics(robot, bent_like_an_s(robot), method="descent", space_error=False)
    near = lissom.statics(robot, 1.01 * rest.q, method="newton", space_error=False)
    assert near.success
    assert near.lowest_eigenvalue == pytest.approx(rest.lowest_eigenvalue, rel=1e-5)
    assert np.abs(robot.loop_gaps(near.q)).max() < 1e-13


def held_by_a_bar(seed):
    """A clamped rod with loads that follow its tip, which a bar holds; and where shooting finds its tip."""
    rng = np.random.default_rng(seed)
    length, radius, young, shear = 0.5, 0.01, 1e7, 0.4e7
    bending = young * np.pi / 4 * radius**4
    stiffness = np.array([shear * np.pi / 2 * radius**4, bending, bending])
    force, moment = rng.normal(size=(2, 3)) * 1.5 * bending / np.array([[length**2], [length]])
    bar, way = rng.uniform(0.3, 0.7), rng.normal(size=3)
    anchor = np.array([length, 0, 0]) + way / np.linalg.norm(way) * bar * rng.uniform(0.7, 1.3)
    rod = [Segment(length, radius, young, shear, 800.0, {"torsion": 6, "bend_y": 9, "bend_z": 9})]
    loads = [Load(force=force, moment=moment, frame="body", link="rod")]
    loops = [Loop("rod", (None, None, anchor), Distance(bar))]
    robot = Robot([Link("rod", rod=rod)], gravity=(0, 0, 0), loads=loads, loops=loops)

    def rates(_, y):
        turn = y[3:12].reshape(3, 3)
        u = turn.T @ y[15:18] / stiffness
        turned = turn @ np.cross(u, np.eye(3)).T
        return np.concatenate([turn[:, 0], turned.ravel(), np.zeros(3), -np.cross(turn[:, 0], y[12:15])])

    def end(reactions):
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), reactions])
        return solve_ivp(rates, (0, length), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]

    def misses(reactions):
        y = end(reactions)
        turn, to = y[3:12].reshape(3, 3), anchor - y[:3]
        across = np.linalg.svd(to[None])[2][1:]
        left = across @ (y[12:15] - turn @ force) * length**2
        apart = (np.linalg.norm(to) - bar) * bending / length
        return np.concatenate([(y[15:18] - turn @ moment) * length, left, [apart]]) / bending

    def shot(q):
        pose = robot.pose(q)
        turn, tip = pose[:3, :3], pose[:3, 3]
        to = (anchor - tip) / bar
        start = stiffness * robot.strain(q, 0.0)[:3]
        lever = np.cross(tip, to)
        pull = (start - turn @ moment - np.cross(tip, turn @ force)) @ lever / (lever @ lever)
        found = fsolve(misses, np.concatenate([turn @ force + pull * to, start]), xtol=1e-12)
        assert np.abs(misses(found)).max() < 1e-8
        return end(found)[:3]

    return robot, shot


@pytest.mark.parametrize("seed", [3, 6, 12, 30, 64, 115, 133, 187])
def test_a_rod_under_loads_that_follow_it_is_held_by_a_bar(seed):
    """Loads without a potential: the descent ends beside the equilibrium, where the springs are stiff."""
    robot, shot = held_by_a_bar(seed)
    rest = lissom.statics(robot)
    assert rest.success, rest.message
    assert np.abs(robot.loop_gaps(rest.q)).max() < 1e-12
    np.testing.assert_allclose(robot.pose(rest.q)[:3, 3], shot(rest.q), rtol=0, atol=1e-6)
