"""Hard contact with closed-form solutions: wedges, ends, mass ratios, grazing."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

G = 9.81
FLOOR = lissom.HalfSpace()


def segment(length=0.3, radius=0.01, **options):
    values = {"young_modulus": 1e6, "poisson_ratio": 0.45, "density": 1000, "modes": {"bend_y": 2}}
    return lissom.Segment(length, radius, **(values | options))


@pytest.mark.parametrize("angle", [10.0, 45.0, 85.0])
def test_a_rod_is_wedged_between_two_walls(angle):
    # Each wall presses with W / (2 cos a), which is 5.7 times the weight for steep walls.
    slope, radius = np.radians(angle), 0.01
    walls = [lissom.HalfSpace((0, 0, 0), (0, side * np.sin(slope), np.cos(slope))) for side in (1, -1)]
    contacts = [lissom.Contact("rod", wall, name=str(i)) for i, wall in enumerate(walls)]
    # Perpendicular to its axis only, from slightly above the bottom.
    link = lissom.Link(
        "rod", rod=[segment()], joint=lissom.Planar((1, 0, 0)), position=(0, 0, radius / np.cos(slope))
    )
    robot = lissom.Robot([link], contacts=contacts)
    found = lissom.statics(robot, np.r_[1e-5, 1e-5, np.zeros(robot.n - 2)])
    assert found.success, found.message
    weight = 1000 * np.pi * radius**2 * 0.3 * G
    for i, side in enumerate((1, -1)):
        force = robot.contact_forces(found.q, np.zeros(robot.n), name=str(i))[3:]
        # The rod bends under its weight along the groove, which distributes the weight evenly.
        assert_allclose(force, 0.5 * weight * np.array([0, side * np.tan(slope), 1]), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("taper", [0.0, 0.05])
def test_a_rod_stands_on_its_tip(taper):
    # The line force k (r - z) where the floor is nearer than the radius: W = k d^2 / (2 (1 - taper)).
    length, tip = 0.1, 0.004
    rod = segment(length, (tip + taper * length, tip), modes={"torsion": 1})
    down = (np.sqrt(0.5), 0, np.sqrt(0.5), 0)
    link = lissom.Link(
        "rod", rod=[rod], joint=lissom.Prismatic((1, 0, 0)), position=(0, 0, length), orientation=down
    )
    robot = lissom.Robot([link], contacts=[lissom.Contact("rod", FLOOR, stiffness=1e6)])
    found = lissom.statics(robot, np.array([-0.9 * tip, 0.0]))
    assert found.success, found.message
    radii = tip + taper * np.linspace(0, length, 100001)
    weight = 1000 * G * np.pi * np.trapezoid(radii**2, dx=length / 100000)
    overlap = np.sqrt(2 * weight * (1 - taper) / 1e6)
    assert_allclose(robot.pose(found.q)[2, 3], tip - overlap, atol=1e-6 * tip)


@pytest.mark.parametrize("ratio", [1e-3, 1e3])
@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_balls_of_a_thousandfold_mass_rest_on_each_other(ratio):
    radius, masses = 0.1, np.array([1.0, ratio])
    links = [
        lissom.Link(
            name,
            joint=lissom.Prismatic((0, 0, 1)),
            body=lissom.Body(mass, inertia=np.eye(3)),
            position=(0, 0, (2 * i + 1) * radius),
        )
        for i, (name, mass) in enumerate(zip(("lower", "upper"), masses, strict=True))
    ]
    balls = [lissom.Ball(link.name, radius) for link in links]
    k = 1e7
    contacts = [
        lissom.Contact(balls[0], FLOOR, stiffness=k, name="floor"),
        lissom.Contact(balls[1], balls[0], stiffness=k, name="between"),
    ]
    robot = lissom.Robot(links, contacts=contacts)
    sunk = np.array([masses.sum(), masses.sum() + masses[1]]) * G / k
    # From the first contact.
    found = lissom.statics(robot, [-1e-6, -1.5e-6])
    assert found.success, found.message
    assert_allclose(found.q, -sunk, rtol=1e-9)
    # Released a millimetre higher, with the default step: the energy never increases, and the rest state is
    # the same. After 3 s the exact motion still swings by 1.2e-3 of the rest (Radau's method, `rtol=1e-9`).
    motion = lissom.simulate(robot, 6.0, q0=[1e-3, 2e-3])
    assert motion.success, motion.message
    energy = np.array([robot.energy(q, v).total for q, v in zip(motion.q, motion.v, strict=True)])
    assert energy.max() < energy[0] + 1e-9 * np.ptp(energy)
    assert energy[-1] < energy[1:-1].min() + 1e-3 * np.ptp(energy)
    assert_allclose(motion.q[-1], -sunk, rtol=1e-3)


@pytest.mark.parametrize("friction", [0.1, 5.0])
def test_a_ball_that_grazes_a_floor_keeps_what_coulomb_leaves(friction):
    # The impulse along the floor is mu times the normal impulse until the ball rolls.
    radius, speed, sink = 0.1, 10.0, 0.1
    body = lissom.Body(1.0, inertia=0.4 * radius**2 * np.eye(3))
    link = lissom.Link("ball", joint=lissom.Free(), body=body)
    contact = lissom.Contact(
        lissom.Ball("ball", radius), FLOOR, stiffness=1e5, dissipation=0.0, friction=friction
    )
    robot = lissom.Robot([link], gravity=(0, 0, 0), contacts=[contact])
    start = np.array([0, 0, radius + 1e-4, 0, 0, 0])
    motion = lissom.simulate(robot, 0.02, dt=1e-5, q0=start, v0=[speed, 0, -sink, 0, 0, 0])
    assert motion.success, motion.message
    velocity = robot.velocity(motion.q[-1], motion.v[-1], link="ball")
    # It bounces without loss: the impulse is 2 m times the normal speed.
    assert_allclose(velocity[5], sink, rtol=1e-4)
    lost = min(2 * sink * friction, 2 / 7 * speed)
    assert_allclose(velocity[3], speed - lost, rtol=1e-4)
    assert_allclose(velocity[1] * radius, 2.5 * lost, rtol=1e-3)


def test_a_sunk_shape_is_no_equilibrium():
    """A floor that is far too soft carries a rod that is many radii below its surface."""
    segment = lissom.Segment(
        0.5, radius=0.01, young_modulus=1e4, poisson_ratio=0.45, density=1000, modes={"bend_y": 3}
    )
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.05)), stiffness=1.0)
    found = lissom.statics(lissom.Rod([segment], contacts=[floor]))
    assert found.status == "deep_penetration"
    assert not found.success


@pytest.mark.parametrize("height", [0.0099, 0.012, 0.1])
@pytest.mark.parametrize("modes", [{"bend_y": 1}, {"bend_y": 3}, {"bend_y": 4, "bend_z": 4, "torsion": 2}])
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_free_rod_comes_to_lie_on_a_floor(height, modes, friction):
    """The position and rotation on the floor are free: a neutral equilibrium with the indentation w/k."""
    segment = lissom.Segment(0.5, 0.01, 1e6, 4e5, 1000.0, modes=modes)
    rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment], position=(0, 0, height))
    floor = lissom.Contact("rod", lissom.HalfSpace((0, 0, 0), (0, 0, 1)), stiffness=1e6, friction=friction)
    robot = lissom.Robot([rod], contacts=[floor])
    found = lissom.statics(robot)
    assert found.success, found.message
    assert found.stability == "neutral"
    line_weight = 1000.0 * np.pi * 0.01**2 * 9.81
    forces = robot.contact_forces(found.q, 0 * found.q)
    np.testing.assert_allclose(forces[3:], [0, 0, 0.5 * line_weight], atol=1e-8)
    for X in (0.0, 0.2, 0.5):
        assert robot.pose(found.q, X)[2, 3] == pytest.approx(0.01 - line_weight / 1e6, abs=1e-7)
    again = lissom.statics(robot, found.q, method="newton")
    assert again.success, again.message
    assert again.stability == "neutral"


@pytest.mark.parametrize("height", [0.0, 1e-6, 1e-4, 5e-3, 0.5, 20.0])
@pytest.mark.parametrize("corners", [0, 4])
def test_a_body_in_the_air_comes_to_rest_on_a_floor(height, corners):
    """In the air nothing has a stiffness: rounding errors must not be taken for one."""
    inertia = np.diag([3e-4, 4e-4, 5e-4])
    link = lissom.Link(
        "body", joint=lissom.Free(), body=lissom.Body(0.5, inertia=inertia), position=(0, 0, 0.02 + height)
    )
    box = lissom.Box((0, 0, 0), (0.05, 0.04, 0.02), link="body")
    surface = box if corners else lissom.Ball("body", 0.02)
    floor = lissom.Contact(surface, lissom.HalfSpace(), stiffness=1e5, friction=0.5)
    found = lissom.statics(lissom.Robot([link], contacts=[floor]))
    assert found.success, found.message
    assert found.stability == "neutral"
    sunk = 0.5 * 9.81 / (1e5 * max(corners, 1))
    assert_allclose(found.q, [0, 0, -height - sunk, 0, 0, 0], atol=1e-9)


def test_a_rod_that_falls_far_is_neutral_on_the_floor():
    segment = lissom.Segment(
        0.5, 0.01, 1e6, poisson_ratio=0.45, density=1000, modes={"bend_y": 4, "bend_z": 4, "torsion": 2}
    )
    rod = lissom.Link("rod", joint=lissom.Free(), rod=[segment], position=(0, 0, 0.31))
    floor = lissom.Contact("rod", lissom.HalfSpace(), friction=0.5)
    found = lissom.statics(lissom.Robot([rod], contacts=[floor]))
    assert found.success, found.message
    assert found.stability == "neutral"


@pytest.mark.parametrize("method", ["radau", "rk45", "dop853", "auto"])
def test_adaptive_methods_go_on_where_a_ball_has_come_to_rest(method):
    """Velocities that errors of steps leave are no impact that gains energy."""
    link = lissom.Link("ball", joint=lissom.Prismatic((0, 0, 1)), body=lissom.Body(1.0), position=(0, 0, 0.2))
    floor = lissom.Contact(lissom.Ball("ball", 0.05), lissom.HalfSpace(), stiffness=1e4)
    limit = {} if method == "auto" else {"max_steps": 20000}
    motion = lissom.simulate(lissom.Robot([link], contacts=[floor]), 20.0, method=method, **limit)
    assert motion.success, motion.message
    assert motion.stats.steps < 5000
    assert_allclose(motion.q[-1], [-0.15 - 9.81 / 1e4], atol=1e-6)


@pytest.mark.parametrize(
    "obstacle",
    [
        lissom.Sphere((0.47, 0, -0.2), 0.02),
        lissom.Capsule((0.47, -0.2, -0.2), (0.47, 0.2, -0.2), 2e-3),
        lissom.Box((0.47, 0, -0.2), (0.05, 0.2, 2e-3)),
    ],
    ids=["sphere", "wire", "plate"],
)
def test_equilibria_lie_on_the_side_of_an_obstacle_where_they_were_released(obstacle):
    """A hinged bar comes to rest on what is below it, as its damped motion does."""

    def bar(damping):
        body = lissom.Body(1.0, centre=(0.3, 0, 0), inertia=np.eye(3) * 0.01)
        link = lissom.Link("bar", joint=lissom.Revolute((0, 1, 0), damping=damping), body=body)
        tip = lissom.Ball("bar", 0.02, position=(0.5, 0, 0))
        return lissom.Robot([link], contacts=[lissom.Contact(tip, obstacle, stiffness=1e5)])

    found = lissom.statics(bar(0.0), [0.2])
    motion = lissom.simulate(bar(1.0), 5.0, q0=[0.2], method="radau")
    assert found.success, found.message
    assert found.stability == "stable"
    assert_allclose(found.q, motion.q[-1], atol=1e-5)
    assert found.q[0] < 0.5


#: Steel wires of 0.5 mm radius, seven times as long as the length over which they bend under their weight.
#: They arrive with forty radii a step.
WIRE = {
    "radius": 5e-4,
    "young_modulus": 2e11,
    "poisson_ratio": 0.4,
    "density": 1500.0,
    "retardation_time": 0.01,
}
LENGTH = 7 * (2e11 * 5e-4**2 / (4 * 1500.0 * G)) ** (1 / 3)


def wire(*obstacles, stiffness=None):
    modes = {"torsion": 2, "bend_y": 4, "bend_z": 4}
    rod = [lissom.Segment(LENGTH / 4, modes=modes, **WIRE)] * 4
    contacts = [
        lissom.Contact("rod", obstacle, name=f"{i}", friction=0.3, stiffness=stiffness)
        for i, obstacle in enumerate(obstacles)
    ]
    return lissom.Robot([lissom.Link("rod", rod=rod)], contacts=contacts)


def block(x, height):
    """A block whose left upper edge is there, in parts of the length."""
    return lissom.Box(np.array((x + 0.025, 0, -height - 0.1)) * LENGTH, np.array((0.025, 1, 0.1)) * LENGTH)


def places(robot, motion, number):
    every = (len(motion.t) - 1) // number
    s = np.linspace(0, LENGTH, 11)
    return np.array([robot.pose(q, s, link="rod")[:, :3, 3] for q in motion.q[::every]])


def test_a_wire_falls_on_three_edges_in_long_steps():
    # It arrives with half a radius a millisecond, and its end swings below the last edge against the block.
    robot = wire(*(block(x, height) for x, height in ((0.15, 0.05), (0.4, 0.1), (0.65, 0.2))))
    motion = lissom.simulate(robot, 1.0, dt=5e-3)
    assert motion.success, motion.message
    assert motion.deepest.share < 0.35


def test_a_wire_falls_on_a_floor_in_long_steps():
    floor = lissom.HalfSpace((0, 0, -0.15 * LENGTH))
    robot = wire(floor)
    # Where it hits the floor such steps take a third of the energy, which its waves would have returned.
    with pytest.warns(lissom.AccuracyWarning, match="suppress rebounds"):
        motion = lissom.simulate(robot, 1.0, dt=5e-3)
    fine = lissom.simulate(robot, 1.0, dt=5e-4)
    assert motion.success
    assert fine.success
    # With a stiffness at which it sinks in by a seventh of its radius.
    with pytest.warns(lissom.AccuracyWarning, match="suppress rebounds"):
        soft = lissom.simulate(wire(floor, stiffness=1e5), 1.0, dt=5e-3)
    assert motion.stats.newton_iterations < 3 * soft.stats.newton_iterations
    # Steps of backward Euler, which stop what meets, are of the first order: 2.5e-2 of the length off at
    # most, 1.5e-3 at the end.
    off = np.linalg.norm(places(robot, motion, 20) - places(robot, fine, 20), axis=2) / LENGTH
    assert off.max() < 4e-2
    assert off[-1].max() < 4e-3
