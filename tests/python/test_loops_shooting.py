"""Closed loops of rods against shooting: Cosserat's equations solved by SciPy, which share no code with lissom."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation

import lissom
from lissom import Body, Free, Link, Load, Loop, Revolute, Robot, Segment, Weld

#: The parallel robot of Till and others (2015): wires, holes, the mass of the plate.
YOUNG, SHEAR, RADIUS, DENSITY, LENGTH = 200e9, 80e9, 1e-3, 8000.0, 0.4
HOLES, MASS, GRAVITY = 0.087, 0.1, 9.81
BELOW = np.radians([-10, 10, 110, 130, 230, 250])
ABOVE = np.radians([-50, 50, 70, 170, 190, 290])

#: How far the wires are pushed up, and a force on the plate that is not in line with anything.
PUSHED = np.array([0.01, -0.005, 0.015, 0.0, -0.01, 0.02])
FORCE = np.array([0.7, -0.4, -1.5])

AREA, SECOND = np.pi * RADIUS**2, np.pi * RADIUS**4 / 4


def ring(angles, heights=0.0):
    return np.stack([HOLES * np.cos(angles), HOLES * np.sin(angles), np.broadcast_to(heights, 6)], axis=1)


def shot_wires(guess):
    """The plate's pose and what all wires pass at their bases: 6 wires of 6 unknowns, and 6 of the plate.

    Sections have d3 along the wire. The state of a wire: position, rotation matrix, force and moment in world axes.
    """
    stiff_linear = np.array([SHEAR * AREA, SHEAR * AREA, YOUNG * AREA])
    stiff_angular = np.array([YOUNG * SECOND, YOUNG * SECOND, SHEAR * 2 * SECOND])
    weight = np.array([0, 0, -DENSITY * AREA * GRAVITY])

    def rates(_, state):
        y = state.reshape(6, 18)
        turn, n, m = y[:, 3:12].reshape(6, 3, 3), y[:, 12:15], y[:, 15:18]
        v = np.einsum("wji,wj->wi", turn, n) / stiff_linear + [0, 0, 1]
        u = np.einsum("wji,wj->wi", turn, m) / stiff_angular
        along = np.einsum("wij,wj->wi", turn, v)
        # The columns of R hat(u).
        columns = np.cross(u[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)
        turned = turn @ columns
        flat = [along, turned.reshape(6, 9), np.broadcast_to(-weight, (6, 3)), -np.cross(along, n)]
        return np.concatenate(flat, axis=1).ravel()

    bases = ring(BELOW, PUSHED)

    def tips(reactions):
        start = np.concatenate([bases, np.tile(np.eye(3).ravel(), (6, 1)), reactions], axis=1)
        options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12}
        return solve_ivp(rates, (0, LENGTH), start.ravel(), **options).y[:, -1].reshape(6, 18)

    def misses(unknowns):
        reactions, place, vector = unknowns[:36].reshape(6, 6), unknowns[36:39], unknowns[39:]
        plate = Rotation.from_rotvec(vector).as_matrix()
        end = tips(reactions)
        axes, n, m = end[:, 3:12].reshape(6, 3, 3), end[:, 12:15], end[:, 15:18]
        arms = ring(ABOVE) @ plate.T
        positions = end[:, :3] - (place + arms)
        # Wires leave across the plate, and may turn about themselves: no torsion there.
        across = np.einsum("i,wij->wj", plate[:, 2], axes)[:, :2]
        torsion = np.einsum("wi,wi->w", m, axes[:, :, 2])
        force = FORCE + [0, 0, -MASS * GRAVITY] - n.sum(axis=0)
        moment = -(m + np.cross(arms, n)).sum(axis=0)
        return np.concatenate([positions.ravel(), across.ravel(), torsion, force, moment])

    found = root(misses, guess, method="hybr", options={"xtol": 1e-11})
    assert np.abs(misses(found.x)).max() < 1e-8, found.message
    reactions, place, vector = found.x[:36].reshape(6, 6), found.x[36:39], found.x[39:]
    return place, vector, tips(reactions)


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


def test_six_wires_hold_a_plate():
    """The tolerance is the change from 8 modes of bending to 10, of 4e-9 m, and what is left of shooting, 1e-8."""
    modes = {"torsion": 3, "bend_y": 8, "bend_z": 8, "stretch": 2, "shear_y": 2, "shear_z": 2}
    robot = six_wires(modes)
    q0 = np.zeros(robot.n)
    q0[2] = 0.395
    # Bent like an S, as the holes of the plate are beside those of the base.
    ways = -6 * (ring(ABOVE) - ring(BELOW)) / LENGTH**2
    for i in range(6):
        q0[robot.coordinates.index(f"wire {i}.bend_y[1]")] = ways[i, 0]
        q0[robot.coordinates.index(f"wire {i}.bend_z[1]")] = ways[i, 1]
    rest = lissom.statics(robot, q0)
    assert rest.success, rest.message
    assert rest.stability == "stable"
    assert np.abs(robot.loop_gaps(rest.q)).max() < 1e-10
    pose = robot.pose(rest.q, link="plate")
    # From a rough guess, not from what is to be checked.
    guess = np.concatenate([np.zeros(36), [0, 0, 0.4], np.zeros(3)])
    place, vector, tips = shot_wires(guess)
    np.testing.assert_allclose(pose[:3, 3], place, rtol=0, atol=2e-8)
    np.testing.assert_allclose(pose[:3, :3], Rotation.from_rotvec(vector).as_matrix(), rtol=0, atol=2e-7)
    zeros = np.zeros(robot.n)
    for i in range(6):
        held = robot.loop_forces(rest.q, zeros, zeros, name=f"hole {i}")
        # What the wire has left at its tip is what the plate gives to it: the plate is the second end.
        np.testing.assert_allclose(held[3:], -tips[i, 12:15], rtol=0, atol=2e-5)
        np.testing.assert_allclose(held[:3], -tips[i, 15:18], rtol=0, atol=2e-6)


def shot_half_arch(height, span, stiffness, guess):
    """The symmetric arch of an inextensible rod of a metre between clamps, at a height of its middle: its load.

    Half of it, from the clamp to the middle, by Euler's elastica: level at both ends.
    """
    def misses(unknowns):
        moment, thrust, push = unknowns

        def rates(_, y):
            x, z, angle, m = y
            # The clamp gives the force (thrust, push); the moment falls along the rod by its arm.
            return [np.cos(angle), np.sin(angle), m / stiffness, push * np.cos(angle) * -1 + thrust * np.sin(angle)]

        end = solve_ivp(rates, (0, 0.5), [0, 0, 0, moment], method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        return [end[0] - span / 2, end[1] - height, end[2]]

    found = root(misses, guess, tol=1e-12)
    assert np.abs(misses(found.x)).max() < 1e-9, found.message
    return 2 * found.x[2], found.x
