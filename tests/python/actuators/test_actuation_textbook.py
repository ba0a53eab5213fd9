"""Actuated rods compared with closed forms and published robots.

Sources: `reference.tendon_rod`; constant curvature and the capstan equation by hand (T' = -mu kappa T on a
planar rod with a parallel tendon gives kappa = k0 / (1 + mu k0 s), k0 = T0 d / EI).
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import simpson

import lissom
from reference.tendon_rod import (
    RUCKER_AND_WEBSTER,
    RUCKER_AND_WEBSTER_TIPS,
    TILL,
    TILL_VALUES,
    TendonRod,
    helical,
    helix,
)

#: Till's rod: tendons at D from the axis.
L, RADIUS, E, G, RHO, D = 0.5, 1e-3, 200e9, 80e9, 8000.0, 15.06e-3
EI, EA = E * np.pi * RADIUS**4 / 4, E * np.pi * RADIUS**2
NO_GRAVITY = {"gravity": (0, 0, 0)}
#: Base whose x axis points along the world's z.
UP = (0.5**0.5, 0.0, -(0.5**0.5), 0.0)
BASES = ("legendre", "chebyshev", "monomial", "piecewise_constant")


def till(modes, actuators, *, basis="legendre", loads=(), nodes=None, **options):
    segment = lissom.Segment(L, RADIUS, E, G, RHO, modes, basis=basis, nodes=nodes)
    return lissom.Robot(
        [lissom.Link("rod", rod=[segment], orientation=UP)], loads=loads, actuators=actuators, **options
    )


def with_tool(*actuators):
    """A rod that does more than bend, with a body at its tip that turns."""
    segment = lissom.Segment(L, RADIUS, E, G, RHO, {"bend_y": 3, "bend_z": 2, "stretch": 1, "torsion": 1})
    body, joint = lissom.Body(0.1, inertia=(1, 1, 1)), lissom.Revolute((0, 1, 0))
    tool = lissom.Link("tool", parent="rod", joint=joint, body=body)
    return lissom.Robot([lissom.Link("rod", rod=[segment]), tool], actuators=actuators, **NO_GRAVITY)


def settled(robot, q0=None):
    found = lissom.statics(robot, q0)
    assert found.success, found.message
    return found.q


def along(y, z):
    return [lissom.Along("rod", (y, z))]


# Constant curvature


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("tension", [1.0, 15.0, 60.0])
def test_parallel_tendon_bends_to_an_arc(tension, basis):
    """kappa = T d / EI, stretch 1 - T / EA, for any tension, in any basis that contains constants."""
    tendon = lissom.Tendon("t", along(0.0, -D), tension=tension)
    robot = till({"bend_y": 1, "stretch": 1}, [tendon], basis=basis, **NO_GRAVITY)
    q = settled(robot)
    kappa, stretch = tension * D / EI, 1 - tension / EA
    for X in (0.0, 0.3, L):
        assert_allclose(robot.strain(q, X, link="rod"), [0, kappa, 0, stretch, 0, 0], rtol=1e-9, atol=1e-12)
    tip = stretch / kappa * np.array([1 - np.cos(kappa * L), 0, np.sin(kappa * L)])
    assert_allclose(robot.pose(q, link="rod")[:3, 3], tip, rtol=0, atol=1e-10)
    assert_allclose(robot.actuator_length("t", q), L * (stretch - kappa * D), rtol=1e-10)
    assert_allclose(robot.actuator_force("t", q, 0 * q), tension, rtol=1e-14)


def test_numbers_of_a_parallel_tendon():
    """The same rod with 15 N, as numbers for comparison with other codes."""
    robot = till(
        {"bend_y": 4, "stretch": 2}, [lissom.Tendon("t", along(0.0, -D), tension=15.0)], **NO_GRAVITY
    )
    q = settled(robot)
    strain = [0, 1.4381240657783663, 0, 0.9999761267585362, 0, 0]
    assert_allclose(robot.strain(q, 0.2, link="rod"), strain, rtol=1e-10, atol=1e-10)
    tip = [0.17214801975257246, 0, 0.4580018538284889]
    assert_allclose(robot.pose(q, link="rod")[:3, 3], tip, rtol=0, atol=1e-11)
    assert_allclose(robot.actuator_length("t", q), 0.489158989163957, rtol=1e-11)


@pytest.mark.parametrize("angle", [0.3, 2.0, 4.5])
def test_rod_bends_towards_its_tendon(angle):
    """The moment of the tension about the axis is d x T, for any position of the tendon around it."""
    y, z = D * np.cos(angle), D * np.sin(angle)
    robot = till({"bend_y": 1, "bend_z": 1}, [lissom.Tendon("t", along(y, z), tension=9.0)], **NO_GRAVITY)
    assert_allclose(settled(robot), 9.0 / EI * np.array([-z, y]), rtol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_tendons_around_a_rod_only_compress_it(count):
    turns = 2 * np.pi * np.arange(count) / count
    tendons = [
        lissom.Tendon(f"t{i}", along(D * np.cos(turn), D * np.sin(turn)), tension=3.0)
        for i, turn in enumerate(turns)
    ]
    modes = {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 2}
    robot = till(modes, tendons, **NO_GRAVITY)
    strain = robot.strain(settled(robot), 0.2, link="rod")
    assert_allclose(strain, [0, 0, 0, 1 - count * 3.0 / EA, 0, 0], rtol=1e-12, atol=1e-12)


def test_a_rod_is_a_link_of_its_own():
    """The same result with `Rod`, where no link is named."""
    segment = lissom.Segment(L, RADIUS, E, G, RHO, {"bend_y": 1})
    tendon = lissom.Tendon("t", [lissom.Along(None, (0.0, -D))], tension=15.0)
    rod = lissom.Rod([segment], actuators=[tendon], **NO_GRAVITY)
    assert_allclose(settled(rod), [15.0 * D / EI], rtol=1e-10)


def test_converging_tendon_bends_less_towards_the_tip():
    """The transverse force acts only at the tendon's end: EI kappa = T d(X), for a small slope d'."""
    T, ends = 1e-3, (D, 0.2 * D)
    tendon = lissom.Tendon("t", [lissom.Along("rod", (0.0, (-ends[0], -ends[1])))], tension=T)
    robot = till({"bend_y": 2}, [tendon], **NO_GRAVITY)
    q = settled(robot)
    slope = (ends[1] - ends[0]) / L
    for X in (0.0, 0.2, L):
        d = ends[0] + slope * X
        assert_allclose(robot.strain(q, X, link="rod")[1], T * d / EI / np.hypot(1, slope), rtol=1e-6)


# Helices


@pytest.mark.parametrize("turns", [0.5, 1.0, 2.0])
def test_helical_tendon_makes_a_helix(turns):
    rate, tension = 2 * np.pi * turns / 0.3, 1.0
    exact = TendonRod(0.3, 1e-3, 5e9, 2e9, 1000.0, [helical(8e-3, 0.0, rate)])

    def tip_error(modes):
        number = dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), modes)
        segment = lissom.Segment(0.3, 1e-3, 5e9, 2e9, 1000.0, number)
        offset = (lambda X: 8e-3 * np.cos(rate * X), lambda X: 8e-3 * np.sin(rate * X))
        tendon = lissom.Tendon("t", [lissom.Along("rod", offset)], tension=tension)
        robot = lissom.Robot([lissom.Link("rod", rod=[segment])], actuators=[tendon], **NO_GRAVITY)
        return np.abs(robot.pose(settled(robot), link="rod") - helix(exact, rate, tension)).max()

    coarse, fine = tip_error(4 + int(4 * turns)), tip_error(10 + int(6 * turns))
    assert fine < 1e-8
    assert fine < 0.01 * coarse


# Chambers


def test_chamber_bends_and_stretches():
    """kappa = p A d / EI, stretch 1 + p A / EA; n equal chambers around the rod do not bend it."""
    A, p = 4e-5, 3e5
    robot = till({"bend_y": 2, "stretch": 2}, [lissom.Chamber("c", along(0.0, D), A, p)], **NO_GRAVITY)
    q = settled(robot)
    expected = [0, p * A * D / EI, 0, 1 + p * A / EA, 0, 0]
    assert_allclose(robot.strain(q, 0.1, link="rod"), expected, rtol=1e-10, atol=1e-12)
    volume = A * L * (expected[3] + expected[1] * D)
    assert_allclose(robot.actuator_length("c", q), volume, rtol=1e-10)
    turns = 2 * np.pi * np.arange(3) / 3
    chambers = [
        lissom.Chamber(f"c{i}", along(D * np.cos(turn), D * np.sin(turn)), A, p)
        for i, turn in enumerate(turns)
    ]
    robot = till({"bend_y": 2, "bend_z": 2, "stretch": 2}, chambers, **NO_GRAVITY)
    strain = robot.strain(settled(robot), 0.1, link="rod")
    assert_allclose(strain, [0, 0, 0, 1 + 3 * p * A / EA, 0, 0], rtol=1e-10, atol=1e-12)


def test_force_of_a_chamber_does_not_depend_on_the_shape():
    robot = till({"bend_y": 3, "stretch": 2}, [lissom.Chamber("c", along(0.0, D), 1e-5, 1e5)])
    shapes = np.random.default_rng(0).standard_normal((2, robot.n))
    gradients = [robot.actuator_gradient("c", q) for q in shapes]
    assert_allclose(gradients[0], gradients[1], rtol=1e-13, atol=1e-20)


# Friction


def tendon_with_friction(mu, sliding):
    tendon = lissom.Tendon("t", along(0.0, -D), tension=15.0, friction=mu, sliding=sliding)
    return till({"bend_y": 10}, [tendon], **NO_GRAVITY)


def total_angle(robot, q):
    R = robot.pose(q, link="rod")[:3, :3]
    return np.arctan2(R[0, 0], R[2, 0])


@pytest.mark.parametrize(
    ("mu", "angle", "ratio"),
    [
        (0.1, 0.6943856188855, 0.9329174483100),
        (0.3, 0.6511178346860, 0.8225587663823),
        (0.5, 0.6142795988542, 0.7355477645631),
    ],
)
def test_parallel_tendon_with_friction(mu, angle, ratio):
    """Pulled: the angle is ln(1 + mu k0 L) / mu; kappa decreases with the tension."""
    robot = tendon_with_friction(mu, 1.0)
    q = settled(robot)
    assert_allclose(total_angle(robot, q), angle, rtol=0, atol=1e-10)
    base, tip = robot.strain(q, [0.0, L], link="rod")[:, 1]
    assert_allclose(base, 15.0 * D / EI, rtol=1e-6)
    assert_allclose(tip / base, ratio, rtol=1e-6)


def test_tendon_let_out_keeps_its_tension_at_the_tip():
    """Released: friction holds the far end, -ln(1 - mu k0 L) / mu."""
    mu, k0 = 0.3, 15.0 * D / EI
    robot = tendon_with_friction(mu, -1.0)
    assert_allclose(total_angle(robot, settled(robot)), -np.log(1 - mu * k0 * L) / mu, rtol=0, atol=1e-9)


def test_statics_without_sliding_have_no_friction_and_say_so():
    robot = till(
        {"bend_y": 10}, [lissom.Tendon("t", along(0.0, -D), tension=15.0, friction=0.3)], **NO_GRAVITY
    )
    found = lissom.statics(robot)
    assert found.success
    assert_allclose(total_angle(robot, found.q), 0.7190620328892, rtol=0, atol=1e-10)
    assert "friction" in found.message
    assert "'t'" in found.message


@pytest.mark.parametrize("sliding", [1.0, -1.0, 0.4])
def test_capstan_on_an_arc(sliding):
    """Other tendons bend the rod; the generalised force of mode k is T d int e^(-mu sigma kappa X) P_k dX."""
    mu, kappa, T = 0.4, 3.0, 0.7
    others = [lissom.Tendon(f"t{i}", along(y, -D), tension=5.0) for i, y in enumerate((-0.01, 0.01))]
    with_friction = lissom.Tendon("f", along(0.0, D), tension=T, friction=mu, sliding=sliding)
    bent = till({"bend_y": 3, "bend_z": 1}, others, nodes=24, **NO_GRAVITY)
    robot = till({"bend_y": 3, "bend_z": 1}, [*others, with_friction], nodes=24, **NO_GRAVITY)
    q, rest = np.array([kappa, 0, 0, 0]), np.zeros(4)
    force = robot.inverse_dynamics(q, rest, rest) - bent.inverse_dynamics(q, rest, rest)
    x, weights = np.polynomial.legendre.leggauss(30)
    tension = T * np.exp(-mu * sliding * kappa * L * (x + 1) / 2)
    legendre = np.polynomial.legendre.legvander(x, 2)
    expected = L / 2 * D * (weights * tension) @ legendre
    assert_allclose(force, [*expected, 0], rtol=1e-10, atol=1e-16)


def test_friction_smoothed_at_rest():
    """Friction depends on the rate of the length: sliding = -l' / sqrt(l'^2 + v^2)."""
    speed = 2e-3
    arguments = {"tension": 2.0, "friction": 0.5}
    by_rate = lissom.Tendon("t", along(0.0, -D), friction_velocity=speed, **arguments)
    robot = till({"bend_y": 2}, [by_rate], **NO_GRAVITY)
    q, rest = np.array([2.0, 0.5]), np.zeros(2)
    for v in (np.zeros(2), np.array([0.1, 0]), np.array([-0.5, 0.3])):
        rate = robot.actuator_rate("t", q, v)
        assert_allclose(rate, -D * L * v[0], rtol=1e-12, atol=1e-18)
        given = lissom.Tendon("t", along(0.0, -D), sliding=-rate / np.hypot(rate, speed), **arguments)
        other = till({"bend_y": 2}, [given], **NO_GRAVITY)
        assert_allclose(robot.inverse_dynamics(q, v, rest), other.inverse_dynamics(q, v, rest), rtol=1e-12)


# Published robots


def till_with(actuators):
    modes = {"bend_y": 9, "stretch": 4, "shear_z": 6}
    return till(modes, actuators, gravity=(9.81, 0, 0))


@pytest.mark.parametrize(("tension", "values"), TILL_VALUES.items())
def test_tendon_robot_of_till(tension, values):
    robot = till_with([lissom.Tendon("t", along(0.0, -D), tension=tension)])
    q = settled(robot)
    tip = robot.pose(q, link="rod")[:3, 3]
    assert_allclose([tip[0], tip[2], robot.actuator_length("t", q)], values[:3], rtol=0, atol=1e-10)


def test_tendon_robot_of_till_and_back():
    """The four lengths are given, the tensions result. The other three tendons are slack."""
    stiffness, slack = 1e4, 1e-3
    sides = [(0.0, -D), (D, 0.0), (0.0, D), (-D, 0.0)]
    lengths = [lissom.Input(f"l{i}", default=L) for i in range(4)]
    tendons = [
        lissom.Tendon(f"t{i}", along(*side), length=length, stiffness=stiffness)
        for i, (side, length) in enumerate(zip(sides, lengths, strict=True))
    ]
    robot = till_with(tendons)
    for tension in (5.0, 10.0, 15.0, 20.0):
        free = till_with([lissom.Tendon(f"t{i}", along(*side), tension=0.0) for i, side in enumerate(sides)])
        driven = till_with([lissom.Tendon("t0", along(*sides[0]), tension=tension)])
        q = settled(driven)
        u = [free.actuator_length(f"t{i}", q) + slack for i in range(4)]
        u[0] = TILL_VALUES[tension][2] - tension / stiffness
        found = lissom.statics(robot, u=u)
        assert found.success, found.message
        tensions = [robot.actuator_force(f"t{i}", found.q, 0 * found.q, u=u) for i in range(4)]
        assert_allclose(tensions, [tension, 0, 0, 0], rtol=0, atol=1e-6)


@pytest.mark.parametrize(("tensions", "tip"), RUCKER_AND_WEBSTER_TIPS.items())
def test_robot_of_rucker_and_webster(tensions, tip):
    rod = RUCKER_AND_WEBSTER
    modes = {"torsion": 6, "bend_y": 10, "bend_z": 10, "stretch": 5, "shear_y": 8, "shear_z": 8}
    segment = lissom.Segment(rod.length, rod.radius, rod.young_modulus, rod.shear_modulus, rod.density, modes)
    actuators = [
        lissom.Tendon(f"t{i}", along(*routing(0.0)[0][1:]), tension=tension)
        for i, (routing, tension) in enumerate(zip(rod.routings, tensions, strict=True))
    ]
    robot = lissom.Robot([lissom.Link("rod", rod=[segment], orientation=UP)], actuators=actuators)
    q = settled(robot)
    assert_allclose(robot.pose(q, link="rod")[:3, 3], tip, rtol=0, atol=1e-8)


def test_reference_of_the_robot_of_till_is_that_of_these_tests():
    assert (TILL.length, TILL.radius, TILL.young_modulus, TILL.density) == (L, RADIUS, E, RHO)


def test_step_response_of_a_tendon():
    """Bending only, 5 N from the start, no damping: the tip; the tendon's work equals the energy."""
    mass, modulus = 0.034, 207e9
    segment = lissom.Segment(L, RADIUS, modulus, 80e9, mass / (L * np.pi * RADIUS**2), {"bend_y": 4})
    tendon = lissom.Tendon("t", along(0.0, -D), tension=5.0)
    robot = lissom.Robot([lissom.Link("rod", rod=[segment])], actuators=[tendon], **NO_GRAVITY)
    expected = {
        0.01: (0.4996892508, 0.0072958641),
        0.02: (0.4988836518, 0.0159311330),
        0.05: (0.4989952985, 0.0288248648),
        0.1: (0.4911943993, 0.0845520911),
        0.2: (0.4915337196, 0.0786421969),
    }
    times = [0.0, *expected]
    motion = lissom.simulate(robot, 0.2, method="radau", rtol=1e-11, atol=1e-11, t_eval=times)
    assert motion.success, motion.message
    tips = robot.pose(motion.q, link="rod")[1:, :3, 3]
    assert_allclose(tips[:, [0, 2]] * [1, -1], list(expected.values()), rtol=0, atol=2e-9)
    for q, v in zip(motion.q, motion.v, strict=True):
        energy = robot.energy(q, v)
        work = 5.0 * (L - robot.actuator_length("t", q))
        assert_allclose(energy.kinetic + energy.elastic, work, rtol=1e-7, atol=1e-12)


# Lengths


def test_length_control_holds_the_length():
    """T = k (l - l0) under any loads; a stiff tendon has the commanded length."""
    stiffness, wanted = 1e6, 0.49
    tendon = lissom.Tendon("t", along(0.0, -D), length=wanted, stiffness=stiffness)
    weight = lissom.Load(force=(0.05, 0.02, -0.1), link="rod")
    modes = {"torsion": 1, "bend_y": 4, "bend_z": 4}
    robot = till(modes, [tendon], loads=[weight], **NO_GRAVITY)
    q = settled(robot)
    tension = robot.actuator_force("t", q, 0 * q)
    length = robot.actuator_length("t", q)
    assert tension > 1.0
    assert_allclose(tension, stiffness * (length - wanted), rtol=1e-6)
    assert abs(length - wanted) < 1e-4


def test_a_tendon_that_is_long_enough_is_slack():
    tendon = lissom.Tendon("t", along(0.0, -D), length=L + 0.01, stiffness=1e4)
    robot = till({"bend_y": 2, "stretch": 1}, [tendon], **NO_GRAVITY)
    found = lissom.statics(robot)
    assert found.success
    assert_allclose(found.q, 0, atol=1e-14)
    assert robot.actuator_force("t", found.q, 0 * found.q) == 0.0
    assert "Slack: 't'" in found.message


def test_a_damped_tendon_pulls_while_it_is_lengthened():
    k, c, free = 2e3, 50.0, 0.49
    tendon = lissom.Tendon("t", along(0.0, -D), length=free, stiffness=k, damping=c)
    robot = till({"bend_y": 1}, [tendon], **NO_GRAVITY)
    for q, v in ((0.5, 0.3), (0.5, -30.0), (2.0, 0.0), (1.32, -1.0)):
        length, rate = L - D * L * q, -D * L * v
        tension = max(0.0, k * (length - free) + c * rate)
        assert_allclose(robot.actuator_force("t", [q], [v]), tension, rtol=1e-9)


def test_lengths_of_tendons_through_points():
    """From a drum through the base of a finger to a pulley at its tip: straight, embedded, straight."""
    segment = lissom.Segment(L, RADIUS, E, G, RHO, {"bend_y": 1})
    path = [
        lissom.Via(None, (-0.1, 0, -D)),
        lissom.Along("rod", (0.0, -D), (0.0, 0.4)),
        lissom.Via("rod", (0.0, 0.0, -D)),
    ]
    tendon = lissom.Tendon("t", path, tension=1.0)
    robot = lissom.Robot([lissom.Link("rod", rod=[segment])], actuators=[tendon])
    kappa = 1.5
    # The chord of an arc between two sections at a distance of 0.1.
    chord = 2 * (1 / kappa - D) * np.sin(kappa * 0.1 / 2)
    length = 0.1 + 0.4 * (1 - kappa * D) + chord
    assert_allclose(robot.actuator_length("t", [kappa]), length, rtol=1e-12)


# Energy


@pytest.mark.parametrize("actuator", ["tendon", "chamber", "active strain", "length"])
def test_work_of_actuators_is_in_the_balance(actuator):
    signal = lissom.Harmonic(1.0, 3.0, mean=1.5)
    made = {
        "tendon": lambda: lissom.Tendon("it", along(0.0, -D), tension=signal),
        "length": lambda: lissom.Tendon(
            "it", along(0.0, -D), length=lissom.Harmonic(2e-3, 3.0, mean=0.495), stiffness=1e3, damping=2.0
        ),
        "chamber": lambda: lissom.Chamber("it", along(0.0, D), 1e-4, lissom.Harmonic(1e4, 3.0, mean=1e4)),
        "active strain": lambda: lissom.ActiveStrain("rod", "bend_y", (0.0, 1.0), signal),
    }[actuator]()
    robot = till({"bend_y": 3, "stretch": 1}, [made], **NO_GRAVITY)
    motion = lissom.simulate(robot, 0.3, method="radau", rtol=1e-9, atol=1e-9, dt=1e-3)
    assert motion.success, motion.message
    balance = motion.balance
    assert balance.moves
    assert balance.drift < 1e-5


@pytest.mark.parametrize(
    "actuator",
    [
        lissom.Tendon("it", along(0.01, -D), tension=3.0),
        lissom.Tendon("it", along(0.01, -D), length=0.3, stiffness=1e3, damping=2.0),
        lissom.Chamber("it", along(0.01, D), 1e-4, 2e4),
        lissom.ActiveStrain("rod", "bend_y", (0.2, 1.0), 1.5),
        lissom.Motor("tool", 0.4),
        lissom.Motor("tool", position=0.3, gains=(2.0, 0.1)),
    ],
    ids=["tension", "cable", "chamber", "active strain", "torque", "servo"],
)
def test_what_actuators_do_at_rest_is_the_slope_of_their_energy(actuator):
    """Constant commands have a potential: the forces that they require are its derivatives."""
    actuated, plain = with_tool(actuator), with_tool()
    random = np.random.default_rng(5)
    q, along_it, rest = random.normal(0, 0.3, plain.n), random.normal(0, 1, plain.n), np.zeros(plain.n)
    q[:3] += 0.7

    def energy(h):
        return actuated.energy(q + h * along_it, rest).total - plain.energy(q + h * along_it, rest).total

    slopes = [(energy(h) - energy(-h)) / (2 * h) for h in (1e-3, 2e-3)]
    forces = actuated.inverse_dynamics(q, rest, rest) - plain.inverse_dynamics(q, rest, rest)
    assert abs(forces @ along_it) > 1e-3
    # Without the error of second order.
    assert_allclose((4 * slopes[0] - slopes[1]) / 3, forces @ along_it, rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "u"),
    [
        (lambda u: lissom.Tendon("it", along(0.01, -D), tension=u), 3.0),
        (lambda u: lissom.Tendon("it", along(0.01, -D), length=u, stiffness=1e3, damping=2.0), 0.3),
        (lambda u: lissom.Chamber("it", along(0.01, D), 1e-4, u), 2e4),
        (lambda u: lissom.ActiveStrain("rod", "bend_y", (0.2, 1.0), u), 1.5),
        (lambda u: lissom.Motor("tool", u), 0.4),
        (lambda u: lissom.Motor("tool", u, limits=(-0.3, 0.4)), 0.399),
        (lambda u: lissom.Motor("tool", position=u, gains=(2.0, 0.1)), 0.3),
        (lambda u: lissom.Motor("tool", position=u, gains=(2.0, 0.1), limits=(-0.6, 0.8)), 0.8),
    ],
    ids=["tension", "cable", "chamber", "active strain", "torque", "limited", "servo", "limited servo"],
)
def test_what_inputs_change_is_the_derivative_of_the_forces(make, u):
    robot = with_tool(make(lissom.Input("u", u)))
    state = np.random.default_rng(6).normal(0, 0.3, (3, robot.n))
    state[0, -1] = 0.4
    h = 1e-4 * abs(u)
    slopes = [
        (robot.inverse_dynamics(*state, u=[u + k * h]) - robot.inverse_dynamics(*state, u=[u - k * h]))
        / (2 * k * h)
        for k in (1, 2)
    ]
    found = robot.input_tangent(*state, u=[u])[:, 0]
    assert np.abs(found).max() > 0
    assert_allclose(found, (4 * slopes[0] - slopes[1]) / 3, rtol=0, atol=1e-5 * np.abs(found).max())


def test_tension_times_shortening_is_the_work():
    """The balance by hand: the work done at the drum is stored in the rod."""
    tendon = lissom.Tendon("t", along(0.0, -D), tension=lissom.Harmonic(2.0, 3.0, mean=3.0))
    robot = till({"bend_y": 3}, [tendon], **NO_GRAVITY)
    motion = lissom.simulate(robot, 0.3, method="radau", rtol=1e-10, atol=1e-10, dt=1e-4)
    assert motion.success
    power = [
        -robot.actuator_force("t", q, v, t=t) * robot.actuator_rate("t", q, v, t=t)
        for t, q, v in zip(motion.t, motion.q, motion.v, strict=True)
    ]
    work = simpson(power, x=motion.t)
    energy = robot.energy(motion.q[-1], motion.v[-1], t=motion.t[-1])
    assert_allclose(energy.kinetic + energy.elastic, work, rtol=1e-6)


# Active strains and motors


def test_active_strain_is_the_shape_of_a_free_rod():
    """Without loads the rod takes the active strain, and is free of stress."""
    active = lissom.ActiveStrain("rod", "bend_y", (0.5, 1.0), 2.0)
    robot = till({"bend_y": 2}, [active], **NO_GRAVITY)
    q = settled(robot)
    for X in (0.0, 0.2, L):
        assert_allclose(robot.strain(q, X, link="rod")[1], 1.0 + X / L, rtol=1e-10)
    # Of the strain that the rod does not take it is EI / 2 times the integral of its square.
    assert robot.energy(q, 0 * q).elastic == pytest.approx(0.0, abs=1e-12 * EI * L)
    straight = robot.energy(0 * q, 0 * q).elastic
    assert_allclose(straight, EI / 2 * L * 7 / 3, rtol=1e-12)


def test_motor_and_servo_against_a_spring():
    body = lissom.Body(1.0, inertia=(1, 1, 1))
    hinge = lissom.Revolute((0, 1, 0), stiffness=2.0)

    def angle(motor):
        return settled(
            lissom.Robot([lissom.Link("bar", body=body, joint=hinge)], actuators=[motor], **NO_GRAVITY)
        )

    assert_allclose(angle(lissom.Motor("bar", 0.6)), [0.3], rtol=1e-12)
    assert_allclose(angle(lissom.Motor("bar", position=0.5, gains=(3.0, 0.1))), [0.3], rtol=1e-12)


def test_limits_of_a_motor():
    """The torque stays within the limits, increases with the command, and equals it in between."""
    body = lissom.Body(1.0, inertia=(1, 1, 1))
    torques = np.linspace(-30, 30, 121)

    def given(torque):
        motor = lissom.Motor("bar", torque, limits=(-2.0, 5.0))
        bar = lissom.Link("bar", body=body, joint=lissom.Revolute((0, 1, 0)))
        robot = lissom.Robot([bar], actuators=[motor], **NO_GRAVITY)
        return -robot.inverse_dynamics([0.0], [0.0], [0.0])[0]

    found = np.array([given(torque) for torque in torques])
    assert found.min() >= -2.0
    assert found.max() <= 5.0
    assert (np.diff(found) >= 0).all()
    assert_allclose([found[0], found[-1]], [-2.0, 5.0], rtol=0.02)
    assert_allclose(given(0.5), 0.5, rtol=0.1)
