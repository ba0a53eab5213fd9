"""Robots compared with exact solutions, hand-written equations, and motions computed by other codes.

Rotation vectors may be wrapped at any time, so that poses and angular velocities are compared, but never
coordinates of spherical and free joints.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import lissom

G = 9.81
Z_HINGE = lissom.Revolute((0, 0, 1))
DOWN_Y = (0.5**0.5, 0.0, 0.0, -(0.5**0.5))
"""Rotates x to -y."""
TIGHT = {"method": "dop853", "rtol": 1e-11, "atol": 1e-12}
STRAINS = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


def run(model, times, **options):
    """The motion at these times, which start at zero."""
    assert times[0] == 0
    result = lissom.simulate(model, times[-1], t_eval=times, **options)
    assert result.success, result.message
    return result


def integrate(rates, start, times):
    """SciPy's solution of hand-written equations, shape (len(times), n)."""
    path = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-12)
    assert path.success
    return path.y.T


# Pendulums


def pendulum():
    """A point mass at one metre from a hinge; it hangs at -pi / 2 and starts, at pi, at (-1, 0)."""
    body = lissom.Body(1.0, centre=(1, 0, 0))
    return lissom.Robot([lissom.Link("bar", body=body, joint=Z_HINGE)], gravity=(0, -G, 0))


def places_of_pendulum(times):
    """x and y by elliptic functions: sin(angle from the vertical / 2) = k cd(w t, k^2), k = sin(pi / 4)."""
    k2, w = 0.5, G**0.5
    half = -ellipj(ellipk(k2) + w * np.asarray(times), k2)[0] * k2**0.5
    angle = 2 * np.arcsin(half)
    return np.column_stack([np.sin(angle), -np.cos(angle)])


IFTOMM = {
    1.0: (0.9862917511318754, -0.165010853125541),
    5.0: (-0.9423054350437567, -0.3347543384140022),
    9.99: (-0.316436469913032, -0.948613704575777),
    10.0: (-0.275087462576117, -0.961419205099125),
}


def test_places_of_the_pendulum_are_those_of_the_benchmark():
    assert_allclose(places_of_pendulum(list(IFTOMM)), list(IFTOMM.values()), atol=1e-12)


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        (TIGHT, 1e-10),
        ({"method": "rk45", "rtol": 1e-10, "atol": 1e-11}, 1e-7),
        ({"method": "radau", "rtol": 1e-9, "atol": 1e-10}, 1e-7),
        ({"method": "newmark", "dt": 1e-3}, 1e-4),
        ({"method": "generalised_alpha", "dt": 1e-3}, 1e-4),
    ],
    ids=lambda value: value["method"] if isinstance(value, dict) else "",
)
def test_pendulum(options, tolerance):
    """Ten seconds of IFToMM's first benchmark, with its usual energy tolerance of 5e-5 J."""
    robot, times = pendulum(), [0.0, *IFTOMM]
    result = run(robot, times, q0=[np.pi], **options)
    angle = result.q[:, 0]
    assert_allclose(
        np.column_stack([np.cos(angle), np.sin(angle)]), places_of_pendulum(times), atol=tolerance
    )
    energies = [robot.energy(q, v).total for q, v in zip(result.q, result.v, strict=True)]
    assert_allclose(energies, 0, atol=5e-5)


def test_small_swings_of_a_pendulum_and_its_equilibria():
    robot = pendulum()
    hanging = lissom.statics(robot, [np.pi / 2 - 1e-3])
    assert hanging.success
    assert hanging.stability == "stable"
    assert_allclose(hanging.q, -np.pi / 2)
    assert_allclose(lissom.modes(robot, hanging.q).angular_frequency, G**0.5)
    linear = lissom.linearise(robot, hanging.q)
    assert_allclose(linear.A, [[0, 1], [-G, 0]], atol=1e-12)
    assert lissom.statics(robot, [np.pi / 2]).stability == "stable"
    top = lissom.statics(robot, [np.pi / 2], method="newton")
    assert top.success
    assert top.stability == "divergence"
    assert_allclose(lissom.modes(robot, top.q).eigenvalues.real, G**0.5)


POINTS = {
    0.5: (0.570472051233, 1.203875111158),
    1.0: (-0.625087699806, -1.034585085680),
    2.0: (-0.482971534252, -1.324048712302),
    5.0: (-0.627186705067, -1.301315550209),
}
BARS = {
    0.5: (0.448142625932, 1.041962887304),
    1.0: (-1.207716238191, -0.814391023091),
    2.0: (-0.082758306821, 0.407362074912),
    5.0: (1.138543796664, 1.244379927773),
}


def double_pendulum(c, I):
    """Arms of a metre and a kilogram, with centres at c; angles are zero in the hanging position."""
    arm = lissom.Body(1.0, centre=(c, 0, 0), inertia=(0, I, I))
    links = [
        lissom.Link("upper", body=arm, joint=Z_HINGE, orientation=DOWN_Y),
        lissom.Link("lower", body=arm, joint=Z_HINGE, parent="upper", position=(1, 0, 0)),
    ]
    return lissom.Robot(links, gravity=(0, -G, 0))


def angles_of_double_pendulum(c, I, times):
    """Lagrange's equations for both angles from the downward vertical."""

    def rates(t, y):
        (a, b), (p, q) = y[:2], y[2:]
        cos, sin = c * np.cos(a - b), c * np.sin(a - b)
        mass = [[I + c**2 + 1, cos], [cos, I + c**2]]
        force = [-sin * q**2 - (c + 1) * G * np.sin(a), sin * p**2 - c * G * np.sin(b)]
        return [p, q, *np.linalg.solve(mass, force)]

    return integrate(rates, [np.pi / 2, np.pi / 2, 0, 0], times)[:, :2]


@pytest.mark.parametrize(
    ("c", "I", "table"), [(1.0, 0.0, POINTS), (0.5, 1 / 12, BARS)], ids=["points", "bars"]
)
def test_double_pendulum(c, I, table):
    """Small differences grow about a thousandfold in five seconds."""
    times = [0.0, *table]
    angles = angles_of_double_pendulum(c, I, times)
    assert_allclose(angles[1:], list(table.values()), atol=1e-8)
    robot = double_pendulum(c, I)
    assert robot.kernel == "planar"
    result = run(robot, times, q0=[np.pi / 2, 0], **TIGHT)
    assert_allclose(np.cumsum(result.q, axis=1), angles, atol=1e-7)


def test_small_swings_of_a_double_pendulum():
    """w^2 = g (2 -+ sqrt 2) for two point masses."""
    frequencies = lissom.modes(double_pendulum(1.0, 0.0), [0, 0]).angular_frequency
    assert_allclose(frequencies, np.sqrt(G * (2 + np.array([-1, 1]) * 2**0.5)))


ROUND = {
    0.5: (0.08045081808, 0.25096246207, -0.96464786762),
    1.0: (-0.82456226010, -0.22128628709, -0.52070092987),
    2.0: (0.70703424932, 0.40437654148, -0.58015703304),
    5.0: (-0.20445805761, -0.43845296016, -0.87518906780),
    10.0: (0.61539325978, 0.18288181945, -0.76671075115),
}
START = np.array([np.sin(np.pi / 3), 0, -0.5])
SIDEWAYS = np.cross(START, np.cross([0, 0, 1], START))
"""Angular velocity without spin about the thread, for an azimuth rate of 1 rad/s."""


def places_of_spherical_pendulum(times):
    """r'' = g - (g . r + v . v) r in Cartesian coordinates."""
    g = np.array([0, 0, -G])

    def rates(t, y):
        r, v = y[:3], y[3:]
        return np.concatenate([v, g - (g @ r + v @ v) * r])

    return integrate(rates, [*START, *np.cross(SIDEWAYS, START)], times)[:, :3]


def ball_on_thread(factor=1.0):
    """A mass of one kilogram at one metre from a ball joint, with an inertia I = 0.01 about every axis.

    Without spin about the thread it moves as a point mass under a gravity reduced by the factor m l^2 / (m
    l^2 + I).
    """
    body = lissom.Body(1.0, centre=START, inertia=(0.01, 0.01, 0.01))
    return lissom.Robot([lissom.Link("ball", body=body, joint=lissom.Spherical())], gravity=(0, 0, -1.01 * G))


def centres(robot, result, centre):
    return robot.pose(result.q)[:, :3, :3] @ centre


def test_spherical_pendulum_on_a_ball_joint():
    times = [0.0, *ROUND]
    expected = places_of_spherical_pendulum(times)
    assert_allclose(expected[1:], list(ROUND.values()), atol=1e-9)
    robot = ball_on_thread()
    result = run(robot, times, v0=SIDEWAYS, **TIGHT)
    assert_allclose(centres(robot, result, START), expected, atol=1e-8)
    about_vertical = robot.momentum(result.q, result.v)[:, 2]
    assert_allclose(about_vertical, 1.01 * 0.75, atol=1e-9)


def test_spherical_pendulum_on_a_universal_joint():
    """At angles a about x and b about y the mass is at (-sin b, sin a cos b, -cos a cos b)."""
    times = [0.0, *ROUND]
    body = lissom.Body(1.0, centre=(0, 0, -1))
    joint = lissom.Universal((1, 0, 0), (0, 1, 0))
    robot = lissom.Robot([lissom.Link("bob", body=body, joint=joint)])
    # The velocity is (0, sin 60, 0) = a' cos b (0, 1, 0).
    result = run(robot, times, q0=[0, -np.pi / 3], v0=[2 * np.sin(np.pi / 3), 0], **TIGHT)
    places = centres(robot, result, np.array([0, 0, -1]))
    assert_allclose(places, places_of_spherical_pendulum(times), atol=1e-8)


@pytest.mark.parametrize(("method", "order"), [("newmark", 2), ("radau", 5)])
def test_conical_pendulum_stays_on_its_cone(method, order):
    """omega^2 = g / (l cos 60), for ten revolutions."""
    robot = ball_on_thread()
    omega = (2 * G) ** 0.5
    assert_allclose(omega, 4.42944691807002, rtol=1e-14)
    step = 2 * np.pi / omega / 500
    options = {"dt": step} if order == 2 else {"rtol": 1e-9, "atol": 1e-9}
    times = step * np.arange(0, 5001, 20)
    result = run(robot, times, v0=omega * SIDEWAYS, method=method, **options)
    places = centres(robot, result, START)
    # A step rotates by 0.0126: its square over twelve is the error of a second-order method, 1.3e-5.
    assert_allclose(places[:, 2], -0.5, atol=2e-5 if order == 2 else 1e-8)
    azimuth = np.unwrap(np.arctan2(places[:, 1], places[:, 0]))
    assert_allclose(azimuth, omega * times, atol=1.4e-5 * omega * times[-1] if order == 2 else 1e-7)


# Tops


HEAVY_TOP = {
    0.1: (0.4212966589, 0.8945719743, -0.1491647006),
    0.5: (-0.7024682971, -0.0211651847, -0.7114002577),
    1.0: (0.1733439641, 0.6400885921, -0.7484907911),
    1.5: (-0.9681657156, 0.2503060621, -0.0014220839),
    2.0: (-0.1504168227, -0.7241655916, -0.6730222696),
}
TOP_INERTIA = np.diag([0.234375, 0.46875, 0.234375])
TOP_RATES = np.array([0, 150, -4.61538])


def heavy_top():
    body = lissom.Body(15.0, centre=(0, 1, 0), inertia=TOP_INERTIA)
    return lissom.Robot([lissom.Link("top", body=body, joint=lissom.Spherical())])


def places_of_symmetric_top(times):
    """The axis u of a symmetric top in inertial axes: u' = L x u / A, L' = m l u x g.

    The angular momentum is L = C s u + A u x u', with the constant spin s about the axis.
    """
    A, C = TOP_INERTIA[0, 0] + 15.0, TOP_INERTIA[1, 1]

    def rates(t, y):
        u, L = y[:3], y[3:]
        return np.concatenate([np.cross(L, u) / A, np.cross(u, [0, 0, -15.0 * G])])

    return integrate(rates, [0, 1, 0, *(np.array([A, C, A]) * TOP_RATES)], times)[:, :3]


def test_heavy_top():
    """Two seconds at 150 rad/s, 48 turns. At q = 0 rates of a rotation vector are the angular velocity."""
    robot, times = heavy_top(), [0.0, *HEAVY_TOP]
    expected = places_of_symmetric_top(times)
    # The values of the table are from another integration, to nine digits.
    assert_allclose(expected[1:], list(HEAVY_TOP.values()), atol=3e-9)
    result = run(robot, times, v0=TOP_RATES, **TIGHT)
    assert_allclose(centres(robot, result, np.array([0, 1, 0])), expected, atol=1e-7)
    w, x, y, z = 0.1229471350, -0.4910798926, 0.3504300303, -0.7879868875
    attitude = Rotation.from_quat([x, y, z, w]).as_matrix()
    # The error of the rotation angle is that of the spin times the duration.
    assert_allclose(robot.pose(result.q[-1])[:3, :3], attitude, atol=1e-6)


def test_heavy_top_by_newmarks_method():
    """Errors of second order: a quarter with half the step."""
    robot, expected = heavy_top(), places_of_symmetric_top([0.0, 0.5])[-1]
    errors = []
    for step in (2e-4, 1e-4):
        result = run(robot, [0.0, 0.5], v0=TOP_RATES, dt=step)
        errors.append(centres(robot, result, np.array([0, 1, 0]))[-1] - expected)
    assert np.abs(errors[0]).max() < 2e-3
    assert_allclose(errors[1], errors[0] / 4, atol=0.05 * np.abs(errors[0]).max())


TUMBLING = {
    1.0: (-0.0732633082, 2.0011577868, 0.0919556276),
    2.0: (-0.3535142808, 1.9710473493, 0.2198274677),
    5.0: (-1.2067742212, -1.5980287792, 0.7014993516),
    10.0: (1.1050666344, -1.6699783632, 0.6432138749),
    20.0: (-0.3845290272, -1.9652321561, 0.2365463822),
}


@pytest.mark.parametrize("joint", [lissom.Free(), lissom.Spherical()], ids=["free", "spherical"])
def test_torque_free_body(joint):
    """Rotation nearly about its middle axis (Dzhanibekov): Euler's equations, and conserved quantities."""
    inertia, start, times = np.array([1.0, 2, 3]), [0.1, 2, 0.1], [0.0, *TUMBLING]
    expected = integrate(lambda t, w: np.cross(inertia * w, w) / inertia, start, times)
    assert_allclose(expected[1:], list(TUMBLING.values()), atol=2e-9)
    body = lissom.Body(1.0, inertia=inertia)
    robot = lissom.Robot([lissom.Link("nut", body=body, joint=joint)], gravity=(0, 0, 0))
    v0 = start if robot.n == 3 else [0, 0, 0, *start]
    result = run(robot, times, v0=v0, **TIGHT)
    turns = robot.pose(result.q)[:, :3, :3]
    omega = np.einsum("kij,ki->kj", turns, robot.velocity(result.q, result.v)[:, :3])
    assert_allclose(omega, expected, atol=1e-7)
    angular = robot.momentum(result.q, result.v)[:, :3]
    assert_allclose(angular, [angular[0]] * len(times), atol=1e-8)
    energies = [robot.energy(q, v).kinetic for q, v in zip(result.q, result.v, strict=True)]
    assert_allclose(energies, energies[0], atol=1e-9)


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        (TIGHT, 1e-8),
        ({"method": "radau", "rtol": 1e-9, "atol": 1e-9}, 1e-8),
        ({"method": "newmark", "dt": 1e-3}, 1e-4),
    ],
    ids=["dop853", "radau", "newmark"],
)
def test_tumbling_body_between_the_steps(options, tolerance):
    """Several turns of an asymmetric body in five seconds, between the steps, by Euler's equations."""
    inertia, c, omega = np.diag([1, 2, 2.5]), np.array([0.1, 0.2, 0]), np.array([6.0, 1, -3])
    about_point = inertia + c @ c * np.eye(3) - np.outer(c, c)

    def rates(t, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        moment = np.cross(c, R.T @ [0, 0, -G])
        change = np.linalg.solve(about_point, moment - np.cross(w, about_point @ w))
        return np.concatenate([np.cross(R, w).ravel(), change])

    times = np.linspace(0, 5, 739)
    path = integrate(rates, [*np.eye(3).ravel(), *omega], times)
    body = lissom.Body(1.0, centre=c, inertia=inertia)
    robot = lissom.Robot([lissom.Link("stone", body=body, joint=lissom.Spherical())])
    result = run(robot, times, v0=omega, **options)
    turns = robot.pose(result.q)[:, :3, :3]
    assert_allclose(turns.reshape(-1, 9), path[:, :9], atol=tolerance)
    in_body = np.einsum("kij,ki->kj", turns, robot.velocity(result.q, result.v)[:, :3])
    assert_allclose(in_body, path[:, 9:], atol=tolerance)
    # Results satisfy the equations of motion, also between the steps and where vectors are wrapped.
    assert np.linalg.norm(result.q, axis=1).max() <= np.pi
    forces = [robot.inverse_dynamics(*qva) for qva in zip(result.q, result.v, result.a, strict=True)]
    assert_allclose(forces, 0, atol=1e-3)


@pytest.fixture(scope="module")
def tumbling_pair():
    """A free body with another one on a ball joint, both wrapped during the motion: error and steps."""
    inertia = (1.0e-3, 2.0e-3, 2.6e-3)
    carried = lissom.Body(0.2, centre=(0.05, 0.01, 0), inertia=(1e-4, 2e-4, 2e-4))
    robot = lissom.Robot(
        [
            lissom.Link("body", body=lissom.Body(0.5, inertia=inertia), joint=lissom.Free()),
            lissom.Link("ball", parent="body", position=(0.1, 0, 0), joint=lissom.Spherical(), body=carried),
        ]
    )
    state = {
        "q0": [0, 0, 0, 2.9, 0.4, -0.3, 0.5, 2.8, -0.6],
        "v0": [0.1, 0.2, 0.3, 12, 3, -2, 3, 9, -4],
    }

    def end(**options):
        motion = lissom.simulate(robot, 0.5, **state, **options)
        assert motion.success, motion.message
        found = [robot.pose(motion.q[-1], link=link).ravel() for link in ("body", "ball")]
        rates = [robot.velocity(motion.q[-1], motion.v[-1], link=link) / 20 for link in ("body", "ball")]
        return np.concatenate(found + rates), motion

    exact, motion = end(method="dop853", rtol=1e-12, atol=1e-12, t_eval=np.linspace(0, 0.5, 501))
    jumps = np.abs(np.diff(motion.q, axis=0)) > 1
    assert jumps[:, 3:6].any(), "the body is wrapped on the way"
    assert jumps[:, 6:].any(), "so is the ball joint"

    def error(**options):
        found, motion = end(**options)
        return np.abs(found - exact).max(), motion.stats.steps

    return error


@pytest.mark.parametrize("method", ["newmark", "linear_acceleration", "hht", "generalised_alpha"])
def test_order_of_newmarks_family_across_wraps(tumbling_pair, method):
    steps = [2e-3, 1e-3, 5e-4]
    errors = [tumbling_pair(method=method, dt=dt, rtol=1e-10, atol=1e-10)[0] for dt in steps]
    assert_allclose(np.diff(np.log2(errors)), -2, atol=0.06)


@pytest.mark.parametrize(("method", "order"), [("rk45", 5), ("dop853", 8), ("radau", 5)])
def test_order_of_adaptive_methods_across_wraps(tumbling_pair, method, order):
    """The order follows from the decrease of the error with the number of steps."""
    found = [tumbling_pair(method=method, rtol=tol, atol=tol) for tol in (1e-7, 1e-9)]
    (coarse, few), (fine, many) = found
    assert np.log(coarse / fine) / np.log(many / few) > order - 0.3


def test_free_tree_keeps_its_momenta():
    """Two bodies and a rod on ball joints, tumbling without gravity for several turns."""
    soft = lissom.Segment(
        0.3,
        0.02,
        1e7,
        poisson_ratio=0.4,
        density=1000,
        modes={"bend_y": 2, "bend_z": 2, "torsion": 1},
    )
    inertia = (1, 2, 2.5)
    links = [
        lissom.Link("a", body=lissom.Body(1.0, centre=(0.1, 0, 0.2), inertia=inertia), joint=lissom.Free()),
        lissom.Link(
            "b",
            body=lissom.Body(1.0, centre=(0.3, 0.1, 0), inertia=inertia),
            joint=lissom.Spherical(),
            parent="a",
            position=(1, 0, 0),
        ),
        lissom.Link("c", rod=[soft], joint=lissom.Spherical(), parent="b"),
    ]
    robot = lissom.Robot(links, gravity=(0, 0, 0))
    v0 = np.zeros(robot.n)
    v0[:12] = [1, -2, 0.5, 4, 2, -1, -3, 2, 5, 2, 1, -3]
    times = np.linspace(0, 4, 21)
    result = run(robot, times, v0=v0, method="dop853", rtol=1e-9, atol=1e-9)
    momentum = robot.momentum(result.q, result.v)
    assert_allclose(momentum, [momentum[0]] * len(times), atol=1e-6)
    centre = robot.centre_of_mass(result.q)
    mass = 2 + 0.3 * np.pi * 0.02**2 * 1000
    assert_allclose(centre, centre[0] + np.outer(times, momentum[0, 3:] / mass), atol=1e-6)
    assert result.balance.drift < 1e-7


# Rods


FLYING = {
    3: [
        (2.5, (3.39363900, 0.16869735, 0.03258477), (4.00997678, 8.47781220, -0.72884052)),
        (5.0, (19.57561861, 1.49801785, -1.46392683), (11.86529423, 6.89513879, 1.79237104)),
        (7.5, (31.97941199, 1.64179413, -1.91037548), (24.06065483, 6.66476521, 1.54535027)),
        (10.0, (44.42901124, 1.72247270, -2.09776734), (36.37208890, 6.25702202, 1.71295356)),
        # The source has -2.57257306 for the base's z, a misprint: two methods agree on -2.57273.
        (15.0, (69.40452640, 2.26013710, -2.57273), (61.36960481, 5.97001740, 2.00952196)),
    ],
    5: [
        (2.5, (3.41404331, 0.19927263, 0.01665102), (4.02344927, 8.49595991, -0.73303837)),
        (5.0, (19.56277676, 1.52231663, -1.50810818), (11.87818277, 6.88193709, 1.82833584)),
        (7.5, (31.95805032, 1.62318576, -1.91972081), (24.09346637, 6.71532297, 1.53945743)),
        (10.0, (44.40233838, 1.66654603, -2.06336439), (36.40856114, 6.33308983, 1.68413467)),
        (15.0, (69.36435826, 2.19469436, -2.54160338), (61.37295677, 6.01283241, 1.97887071)),
    ],
}
AFTERWARDS = {
    3: (879.4499823, (0, -295.1461495, -552.7328798)),
    5: (883.9915826, (0, -295.7060821, -553.0041555)),
}


def flying_rod(n):
    """Simo and Vu-Quoc (1988): from (6, 0, 0) to (0, 8, 0), with force and moment at its base until 5 s."""
    section = lissom.Section.given((500, 500, 500, 1e4, 1e4, 1e4), 1.0, (10, 10, 10))
    segment = lissom.Segment(10.0, section=section, modes=dict.fromkeys(STRAINS, n))
    x, y, z, w = Rotation.from_euler("z", np.arctan2(0.8, -0.6)).as_quat()
    link = lissom.Link(
        "rod", rod=[segment], joint=lissom.Free(), position=(6, 0, 0), orientation=(w, x, y, z)
    )
    ramps = ([0, 2.5, 5], np.array([[0.0], [1], [0]]))
    load = lissom.Load(
        force=(ramps[0], ramps[1] * [20, 0, 0]), moment=(ramps[0], ramps[1] * [0, -100, -200]), at=0
    )
    return lissom.Robot([link], gravity=(0, 0, 0), loads=[load])


@pytest.mark.parametrize("n", FLYING)
def test_flying_rod(n):
    robot = flying_rod(n)
    times = np.array([0.0, *(row[0] for row in FLYING[n])])
    result = run(robot, times, method="dop853", rtol=1e-9, atol=1e-9)
    places = robot.pose(result.q, [0, 10])[..., :3, 3]
    # Seven digits, as accurate as the quadrature with default nodes.
    assert_allclose(places[1:], [row[1:] for row in FLYING[n]], atol=3e-6)
    # The displacement depends on the impulse only: 50 N s in 5 s.
    centre = robot.centre_of_mass(result.q)
    assert_allclose(centre[:, 0], [3, 3 + 25 / 12, 15.5, 28, 40.5, 65.5], atol=2e-6)
    assert_allclose(centre[:, 1:], [[4, 0]] * 6, atol=2e-6)
    momentum = robot.momentum(result.q, result.v)
    assert_allclose(momentum[:, 3:], np.outer([0, 25, 50, 50, 50, 50], [1, 0, 0]), atol=2e-6)
    energy, angular = AFTERWARDS[n]
    assert_allclose(momentum[2:, :3], [angular] * 4, atol=1e-5)
    energies = [robot.energy(q, v, t=t).total for t, q, v in zip(result.t, result.q, result.v, strict=True)]
    assert_allclose(energies[2:], energy, rtol=1e-7)
    assert_allclose(energies[2:], energies[2], rtol=1e-8)


def test_flying_rod_by_newmarks_method_tumbles_past_a_whole_turn():
    robot = flying_rod(3)
    result = run(robot, np.array([0.0, 7.5, 10]), dt=2.5e-3)
    assert_allclose(robot.centre_of_mass(result.q)[:, 0], [3, 28, 40.5], atol=1e-3)
    places = robot.pose(result.q, [0, 10])[..., :3, 3]
    assert_allclose(places[1:], [row[1:] for row in FLYING[3][2:4]], atol=0.03)


#: Joint angle, x and y of the tip at these times, by number of modes.
SOFT_PENDULUM = {
    4: [
        (-0.3848501126, 0.9933382780, -0.0465142740),
        (-0.6483521834, 0.9402542444, -0.2066373380),
        (-1.5522404249, -0.2462670866, -0.9063318413),
        (-2.4919341243, -0.9356767310, -0.0964593448),
    ],
    6: [
        (-0.3626740765, 0.9930147559, -0.0483487198),
        (-0.7468032819, 0.9407482619, -0.2005846435),
        (-1.6480312037, -0.2378965952, -0.9163081910),
        (-2.5858478350, -0.9383029326, -0.0994680681),
    ],
    8: [
        (-0.3452988018, 0.9930485944, -0.0501074258),
        (-0.7314401792, 0.9408624086, -0.1992058197),
        (-1.6679647902, -0.2395176925, -0.9145518347),
        (-2.6433347238, -0.9408836387, -0.0897153072),
    ],
}


@pytest.mark.parametrize("n", SOFT_PENDULUM)
def test_flexible_pendulum(n):
    """A rubber rod released horizontally. Its fast vibrations require small steps."""
    rubber = lissom.Segment(1.0, 5e-3, 5e6, poisson_ratio=0.5, density=1100, modes={"bend_z": n})
    robot = lissom.Robot([lissom.Link("rod", rod=[rubber], joint=Z_HINGE)], gravity=(0, -G, 0))
    assert robot.kernel == "planar"
    result = run(robot, [0.0, 0.1, 0.2, 0.5, 1.0], method="radau", rtol=1e-8, atol=1e-8)
    tip = robot.pose(result.q)[:, :2, 3]
    assert_allclose(np.column_stack([result.q[:, 0], tip])[1:], SOFT_PENDULUM[n], atol=5e-7)


#: x and y of elbow and tip.
SOFT_DOUBLE_PENDULUM = {
    3: [
        (0.4953417077, -0.0536618234, 0.9952603264, -0.0501542549),
        (0.3099224162, -0.3914242227, 0.8036530730, -0.4661734069),
        (0.0187586674, -0.4989149654, -0.2128932411, -0.9408787183),
        (-0.4979759959, -0.0447129853, -0.9976174889, -0.0263240529),
    ],
    5: [
        (0.4953258147, -0.0536865396, 0.9952477501, -0.0499901552),
        (0.3100687313, -0.3913125165, 0.8037602303, -0.4659617434),
        (0.0186952891, -0.4989233254, -0.2118760544, -0.9415483528),
        (-0.4980364196, -0.0438769240, -0.9977450529, -0.0285157166),
    ],
    7: [
        (0.4953261171, -0.0536738057, 0.9952487343, -0.0499482428),
        (0.3100928423, -0.3912867272, 0.8037682964, -0.4660467735),
        (0.0187009663, -0.4989246213, -0.2118324709, -0.9415716352),
        (-0.4980454352, -0.0437705894, -0.9977571386, -0.0286045018),
    ],
}


@pytest.mark.parametrize("n", SOFT_DOUBLE_PENDULUM)
def test_flexible_double_pendulum(n):
    soft = lissom.Segment(0.5, 0.01, 1e7, poisson_ratio=0.5, density=1100, modes={"bend_z": n})
    links = [
        lissom.Link("upper", rod=[soft], joint=Z_HINGE),
        lissom.Link("lower", rod=[soft], joint=Z_HINGE, parent="upper"),
    ]
    robot = lissom.Robot(links, gravity=(0, -G, 0))
    result = run(robot, [0.0, 0.1, 0.3, 0.5, 1.0], method="radau", rtol=1e-7, atol=1e-7)
    ends = [robot.pose(result.q, link=name)[1:, :2, 3] for name in ("upper", "lower")]
    assert_allclose(np.hstack(ends), SOFT_DOUBLE_PENDULUM[n], atol=5e-7)


# The Princeton beam

#: Displacement of the tip for 8.896 and 13.345 N, by angle of the force in degrees.
PRINCETON = {
    0: ((-0.000135517, -0.010712765, 0), (-0.000304668, -0.016061179, 0)),
    15: ((-0.002248464, -0.010643581, 0.042192449), (-0.005340668, -0.016577652, 0.064734218)),
    30: ((-0.007680972, -0.010207614, 0.079547377), (-0.017258922, -0.016989799, 0.118179534)),
    45: ((-0.014411825, -0.008979197, 0.109113115), (-0.030452935, -0.015621150, 0.156774618)),
    60: ((-0.020486718, -0.006742044, 0.129957859), (-0.041257301, -0.011963546, 0.182003786)),
    75: ((-0.024586066, -0.003621979, 0.142218170), (-0.048085612, -0.006470335, 0.196138734)),
    90: ((-0.026021483, 0, 0.146252357), (-0.050401015, 0, 0.200683961)),
}
PRINCETON_LENGTH = 0.508
BENDING = np.array([2.9257441, 2.4288718, 36.285519])
STRETCHING = np.array([2842069.4, 1084759.3, 1084759.3])


def force_of_princeton(P, degrees):
    angle = np.deg2rad(degrees)
    return P * np.array([0, -np.cos(angle), np.sin(angle)])


def tip_of_princeton_beam(force):
    """Displacement and rotation by shooting for the moment at the base that gives zero moment at the tip."""

    def rates(X, y):
        R, m = y[3:12].reshape(3, 3), y[12:]
        slope = R @ ((R.T @ force) / STRETCHING + np.array([1, 0, 0]))
        turning = np.cross(R, (R.T @ m) / BENDING)
        return np.concatenate([slope, turning.ravel(), -np.cross(slope, force)])

    def tip(moment):
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        return solve_ivp(rates, (0, PRINCETON_LENGTH), start, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]

    guess = np.cross([PRINCETON_LENGTH, 0, 0], force)
    end = tip(root(lambda moment: tip(moment)[12:], guess, tol=1e-11).x)
    assert_allclose(end[12:], 0, atol=1e-10)
    return end[:3] - [PRINCETON_LENGTH, 0, 0], end[3:12].reshape(3, 3)


@pytest.mark.parametrize("degrees", PRINCETON)
@pytest.mark.parametrize("P", [4.448, 8.896, 13.345])
def test_princeton_beam(P, degrees):
    force = force_of_princeton(P, degrees)
    place, turn = tip_of_princeton_beam(force)
    if P > 5:
        assert_allclose(place, PRINCETON[degrees][int(P > 9)], atol=2e-9)
    section = lissom.Section.given((*BENDING, *STRETCHING), 1.0)
    beam = lissom.Segment(PRINCETON_LENGTH, section=section, modes=dict.fromkeys(STRAINS, 8))
    links = [lissom.Link("beam", rod=[beam])]
    robot = lissom.Robot(links, gravity=(0, 0, 0), loads=[lissom.Load(force=force)])
    bent = lissom.statics(robot)
    assert bent.success
    assert bent.stability == "stable"
    pose = robot.pose(bent.q)
    assert_allclose(pose[:3, 3] - [PRINCETON_LENGTH, 0, 0], place, atol=1e-9)
    assert_allclose(pose[:3, :3], turn, atol=1e-8)


def test_twist_and_small_load_of_the_princeton_beam():
    """Published with the table: the displacement for 4.448 N at 45 degrees, the twist for the others."""
    place, _ = tip_of_princeton_beam(force_of_princeton(4.448, 45))
    assert_allclose(place, (-0.003748208, -0.003976434, 0.056063501), atol=1e-9)
    for P, twist in ((8.896, 0.0306016), (13.345, 0.0640037)):
        _, turn = tip_of_princeton_beam(force_of_princeton(P, 45))
        assert_allclose(np.arctan2(turn[2, 1], turn[1, 1]), twist, atol=1e-7)


def test_free_beam():
    """Six zeros, then roots of cos x cosh x = 1, twice each: a round rod bends in two planes."""
    L, r, E, rho = 1.0, 1e-4, 1e9, 1000.0
    modes = {"bend_y": 12, "bend_z": 12, "torsion": 1, "stretch": 1}
    beam = lissom.Segment(L, r, E, poisson_ratio=0.3, density=rho, modes=modes)
    robot = lissom.Robot([lissom.Link("beam", rod=[beam], joint=lissom.Free())], gravity=(0, 0, 0))
    vibrations = lissom.modes(robot, np.zeros(robot.n))
    assert vibrations.stability == "neutral"
    unit = (E * r**2 / (4 * rho * L**4)) ** 0.5
    assert_allclose(vibrations.angular_frequency[:6], 0, atol=1e-4 * unit)
    roots = [brentq(lambda x: np.cos(x) - 1 / np.cosh(x), *bounds) for bounds in ((4, 5), (7, 8), (10, 12))]
    assert_allclose(roots, (4.7300407, 7.8532046, 10.9956078), atol=5e-8)
    # Rotary inertia reduces them by about (x r / L)^2 < 1e-6.
    assert_allclose(vibrations.angular_frequency[6:12], np.repeat(roots, 2) ** 2 * unit, rtol=2e-6)


# One robot with two descriptions


def small_states(n, seed=0, count=3):
    return 0.4 * np.random.default_rng(seed).standard_normal((count, 3, n))


def assert_close(actual, desired, tolerance=1e-12):
    assert_allclose(actual, desired, rtol=0, atol=tolerance * np.abs(desired).max())


FIRST = lissom.Segment(
    0.3,
    (0.02, 0.015),
    1e6,
    poisson_ratio=0.4,
    density=1000,
    modes=dict.fromkeys(STRAINS, 2),
    retardation_time=0.01,
    reference_strain=(0.5, 1, -0.5, 1, 0, 0.1),
)
SECOND = lissom.Segment(0.2, 0.015, 1e6, poisson_ratio=0.4, density=1000, modes=dict.fromkeys(STRAINS, 3))


def test_a_rod_cut_at_a_weld_is_the_same_rod():
    """With loads, bodies, supports and a fluid on both sides of the cut."""
    fluid = lissom.Fluid(900.0, (0.1, 0.2, 0.3), viscous_drag=(1.0, 0.5), drag_coefficients=(1, 0.1))
    push = {"force": (1, 2, 3), "moment": (0.1, 0.2, 0.3), "frame": "body"}
    spring = {"stiffness": (10, 20, 30), "damping": 1, "position": (0, 0, 0)}
    whole = lissom.Robot(
        [lissom.Link("rod", rod=[FIRST, SECOND], joint=lissom.Free())],
        loads=[lissom.Load(**push, at=0.4), lissom.Load(force=(0, 1, 0), along=(0.1, 0.45))],
        supports=[lissom.Support(**spring, at=0.4)],
        bodies=[lissom.Body(0.1, at=0.45, centre=(0, 0.01, 0))],
        fluid=fluid,
    )
    cut = lissom.Robot(
        [
            lissom.Link("rod", rod=[FIRST], joint=lissom.Free()),
            lissom.Link("rest", rod=[SECOND], parent="rod"),
        ],
        loads=[
            lissom.Load(**push, at=0.1, link="rest"),
            lissom.Load(force=(0, 1, 0), along=(0.1, 0.3), link="rod"),
            lissom.Load(force=(0, 1, 0), along=(0, 0.15), link="rest"),
        ],
        supports=[lissom.Support(**spring, at=0.1, link="rest")],
        bodies=[lissom.Body(0.1, at=0.15, centre=(0, 0.01, 0), link="rest")],
        fluid=fluid,
    )
    for q, v, a in small_states(whole.n):
        # The mass matrix of thin rods amplifies rounding errors.
        assert_close(cut.forward_dynamics(q, v), whole.forward_dynamics(q, v), 1e-10)
        assert_close(cut.inverse_dynamics(q, v, a), whole.inverse_dynamics(q, v, a))
        for part, other in zip(cut.tangent(q, v, a), whole.tangent(q, v, a), strict=True):
            assert_close(part, other)
        assert_close(cut.momentum(q, v), whole.momentum(q, v))
        assert_close(cut.pose(q, 0.1, link="rest"), whole.pose(q, 0.4))
        assert_close(cut.base_wrench(q, v, a), whole.base_wrench(q, v, a))
        assert_allclose(cut.energy(q, v).total, whole.energy(q, v).total, rtol=1e-12)
        assert_allclose(cut.dissipated_power(q, v), whole.dissipated_power(q, v), rtol=1e-12)


def test_a_ball_joint_is_three_hinges():
    """Away from singular configurations of the hinges: the same wrench and momentum in the same motion."""
    body = lissom.Body(1.5, centre=(0.3, 0.2, -0.4), inertia=(0.1, 0.12, 0.15))
    ball = lissom.Robot([lissom.Link("body", body=body, joint=lissom.Spherical())])
    links = [
        lissom.Link("yaw", joint=lissom.Revolute((0, 0, 1))),
        lissom.Link("pitch", joint=lissom.Revolute((0, 1, 0)), parent="yaw"),
        lissom.Link("body", joint=lissom.Revolute((1, 0, 0)), parent="pitch", body=body),
    ]
    hinges = lissom.Robot(links)
    for phi, omega, _ in small_states(3):
        angles = Rotation.from_rotvec(phi).as_euler("ZYX")
        assert_close(hinges.pose(angles, link="body"), ball.pose(phi))
        v = np.linalg.solve(ball.jacobian(phi)[:3], omega)
        rates = np.linalg.solve(hinges.jacobian(angles, link="body")[:3], omega)
        assert_close(hinges.momentum(angles, rates), ball.momentum(phi, v))
        one = ball.joint_wrench(phi, v, ball.forward_dynamics(phi, v))
        free = hinges.forward_dynamics(angles, rates)
        assert_close(hinges.joint_wrench(angles, rates, free, link="body"), one)


def test_nothing_changes_if_all_turns_together():
    """Gravity, loads in world axes and joints on the world are rotated."""
    block = lissom.Body(0.5, centre=(0.1, 0.05, 0), inertia=(0.01, 0.02, 0.02))
    gravity, force = np.array([1.0, 2, -9]), np.array([1, 0.5, -0.2])

    def robot(turn):
        x, y, z, w = turn.as_quat()
        frame = {"orientation": (w, x, y, z), "position": (1, 2, 3)}
        links = [
            lissom.Link("rod", rod=[FIRST], joint=lissom.Universal((0, 1, 0), (1, 0, 1)), **frame),
            lissom.Link("block", body=block, joint=lissom.Spherical(), parent="rod", at=0.25),
            lissom.Link("slide", rod=[SECOND], joint=lissom.Planar((0, 1, 1)), parent="block"),
            lissom.Link("end", body=block, joint=lissom.Cylindrical((1, 1, 0)), parent="slide", at=0.1),
        ]
        load = lissom.Load(force=turn.apply(force), link="slide", at=0.1)
        return lissom.Robot(links, gravity=turn.apply(gravity), loads=[load])

    one, other = robot(Rotation.identity()), robot(Rotation.from_rotvec((0.5, -1, 0.7)))
    for q, v, a in small_states(one.n):
        assert_close(other.inverse_dynamics(q, v, a), one.inverse_dynamics(q, v, a))
        for part, same in zip(other.tangent(q, v, a), one.tangent(q, v, a), strict=True):
            assert_close(part, same)


@pytest.mark.parametrize(
    ("axis", "bend", "shear"), [((0, 1, 0), "bend_y", "shear_z"), ((0, 0, 1), "bend_z", "shear_y")]
)
def test_the_planar_kernel_is_the_spatial_one(axis, bend, shear):
    """A mode of torsion, which stays zero, makes the robot spatial. Masses and forces leave the plane."""
    inertia = [[0.1, 0.01, 0.02], [0.01, 0.12, 0.015], [0.02, 0.015, 0.11]]
    body = lissom.Body(0.3, centre=(0.1, 0.02, 0.03), inertia=inertia)
    stop = {"limits": (-0.2, 0.2), "limit_stiffness": 10, "limit_dissipation": 0.5, "armature": 0.1}
    hinge = lissom.Revolute(axis, stiffness=0.3, damping=0.1, friction=0.2, **stop)
    slider = lissom.Prismatic((1, 0, 0), stiffness=3, friction=0.1)
    push = {"force": (1, 2, 3), "moment": (0.1, 0.2, 0.3)}

    def robot(extra):
        modes = {bend: 3, "stretch": 1, shear: 1} | extra
        soft = lissom.Segment(0.3, 0.02, 1e6, poisson_ratio=0.4, density=1000, modes=modes)
        links = [
            lissom.Link("a", body=body, joint=hinge, position=(1, 2, 3)),
            lissom.Link("b", rod=[soft], joint=hinge, parent="a", position=(0.2, 0, 0)),
            lissom.Link("c", body=body, joint=lissom.Planar(axis), parent="b", at=0.2),
            lissom.Link("d", rod=[soft], joint=slider, parent="c"),
        ]
        return lissom.Robot(
            links,
            gravity=(1, -7, -5),
            loads=[
                lissom.Load(**push, link="b", at=0.1, frame="body"),
                lissom.Load(**push, link="d", along=(0, 0.2)),
            ],
            supports=[lissom.Support(stiffness=(10, 20, 30), damping=0.3, link="b", at=0.2)],
            fluid=lissom.Fluid(900.0, viscous_drag=(1.0, 0.5), drag_coefficients=(1, 0.1)),
        )

    flat, spatial = robot({}), robot({"torsion": 1})
    assert (flat.kernel, spatial.kernel) == ("planar", "spatial")
    kept = ["torsion" not in name for name in spatial.coordinates]
    for state in small_states(flat.n):
        wide = np.zeros((3, spatial.n))
        wide[:, kept] = state
        assert_close(flat.inverse_dynamics(*state), spatial.inverse_dynamics(*wide)[kept])
        for part, other in zip(flat.tangent(*state), spatial.tangent(*wide), strict=True):
            assert_close(part, other[np.ix_(kept, kept)])
        for link in "abcd":
            assert_close(flat.joint_wrench(*state, link=link), spatial.joint_wrench(*wide, link=link))
            assert_close(flat.velocity(*state[:2], link=link), spatial.velocity(*wide[:2], link=link))
        assert_close(flat.momentum(*state[:2]), spatial.momentum(*wide[:2]))
        assert_allclose(flat.energy(*state[:2]).total, spatial.energy(*wide[:2]).total, rtol=1e-12)


def test_a_moving_base_is_joints_that_are_driven():
    """Three sliders and a hinge with the motion of the base, which rotates about the first link's joint."""
    axis, origin, t = np.array([1.0, 2, 2]) / 3, np.array([1.0, 2, 3]), 0.37
    swing, shake, drift = (0.4, 0.7, 0.3), (np.array([0.1, 0.2, -0.3]), 0.9), np.array([1.0, 0, 2])
    block = lissom.Body(1.0, centre=(0.1, 0.2, 0.3), inertia=(0.1, 0.11, 0.12))

    def children(parent, origin):
        places = origin + np.array([[0, 0, 0], [0.5, -0.2, 0.1], [0.5, 0.2, 0.1]])
        joints = [lissom.Spherical(), lissom.Universal((1, 0, 0), (0, 1, 0)), lissom.Free()]
        parts = [{"rod": [FIRST]}, {"body": block}, {"body": block}]
        return [
            lissom.Link(name, joint=joint, parent=parent, position=place, **part)
            for name, joint, place, part in zip("abc", joints, places, parts, strict=True)
        ]

    motion = lissom.BaseMotion(
        axis=axis,
        angle=lissom.Harmonic(*swing[:2], phase=swing[2]),
        translation=lissom.Harmonic(*shake, rate=drift),
    )
    moving = lissom.Robot(children(None, origin), base_motion=motion)
    drives = [
        lissom.Link("x", joint=lissom.Prismatic((1, 0, 0)), position=origin),
        lissom.Link("y", joint=lissom.Prismatic((0, 1, 0)), parent="x"),
        lissom.Link("z", joint=lissom.Prismatic((0, 0, 1)), parent="y"),
        lissom.Link("turn", joint=lissom.Revolute(axis), parent="z"),
    ]
    driven = lissom.Robot(drives + children("turn", np.zeros(3)))

    def harmonic(amplitude, frequency, phase=0.0):
        w = 2 * np.pi * frequency
        sin, cos = np.sin(w * t + phase), np.cos(w * t + phase)
        return [amplitude * sin, amplitude * w * cos, -amplitude * w**2 * sin]

    shift, turn = harmonic(*shake), harmonic(*swing)
    shift[0], shift[1] = shift[0] + drift * t, shift[1] + drift
    drive = np.column_stack([np.array(shift), turn])
    for state in small_states(moving.n):
        whole = np.hstack([drive, state])
        forces = driven.inverse_dynamics(*whole)
        assert_close(moving.inverse_dynamics(*state, t=t), forces[4:])
        assert_allclose(moving.supplied_power(*state, t=t), forces[:4] @ drive[1], rtol=1e-11)
        assert_close(moving.base_wrench(*state, t=t), driven.joint_wrench(*whole, link="turn"))
        assert_close(moving.momentum(*state[:2], t=t), driven.momentum(*whole[:2]))
        for link in "abc":
            velocity = driven.velocity(*whole[:2], link=link)
            assert_close(moving.velocity(*state[:2], link=link, t=t), velocity)


# Forces on joints and links


JOINT = {"stiffness": 1.2, "rest": 0.1, "damping": 0.02, "friction": 0.3, "friction_velocity": 0.05}
STOPS = {"limits": (-0.5, 0.5), "limit_stiffness": 50.0, "limit_dissipation": 0.8, "armature": 0.15}


@pytest.mark.parametrize("method", ["dop853", "radau"])
def test_forces_of_a_joint(method):
    """Spring, damper, dry friction, stops and armature as documented, written by hand."""
    body = lissom.Body(1.0, centre=(0.3, 0, 0), inertia=(0.4, 0.4, 0.4))
    joint = lissom.Revolute((0, 1, 0), **JOINT, **STOPS)
    robot = lissom.Robot([lissom.Link("arm", body=body, joint=joint)])

    def rates(t, y):
        q, v = y
        # The centre is at (cos q, 0, -sin q) 0.3: its weight rotates it downwards.
        force = G * 0.3 * np.cos(q) - 1.2 * (q - 0.1) - 0.02 * v - 0.3 * v / np.hypot(v, 0.05)
        force -= 50 * max(0.0, q - 0.5) * max(0.0, 1 + 0.8 * v)
        force += 50 * max(0.0, -0.5 - q) * max(0.0, 1 - 0.8 * v)
        return [v, force / (0.4 + 0.09 + 0.15)]

    times = np.linspace(0, 3, 7)
    path = integrate(rates, [-1.0, -3.0], times)
    result = run(robot, times, q0=[-1.0], v0=[-3.0], method=method, rtol=1e-9, atol=1e-10)
    assert_allclose(np.hstack([result.q, result.v]), path, atol=1e-6)


def test_what_sticks_creeps_as_documented():
    """3 N against dry friction of 5 N: v / sqrt(v^2 + v_f^2) = 3 / 5 at 3/4 of the friction velocity."""
    joint = lissom.Prismatic((1, 0, 0), friction=5.0)
    links = [lissom.Link("block", body=lissom.Body(1.0), joint=joint)]
    robot = lissom.Robot(links, gravity=(3, 0, -9))
    assert_allclose(run(robot, [0.0, 1.0]).v[-1], 0.75e-3, rtol=1e-6)


def test_a_block_rests_on_a_one_sided_stop():
    joint = lissom.Prismatic((0, 0, 1), limits=(0, np.inf), limit_stiffness=1e4)
    robot = lissom.Robot([lissom.Link("block", body=lissom.Body(1.0), joint=joint)])
    assert_allclose(lissom.statics(robot).q, -G / 1e4, rtol=1e-10)


def test_a_body_on_springs():
    """A support at its centre, with axes that are rotated, too."""
    inertia = np.array([0.1, 0.2, 0.3])
    link = lissom.Link(
        "body",
        body=lissom.Body(2.0, inertia=inertia),
        joint=lissom.Free(),
        position=(1, 2, 3),
        orientation=(0.8, 0.6, 0, 0),
    )
    support = lissom.Support(stiffness=50.0, rotational_stiffness=3.0, link="body")
    robot = lissom.Robot([link], gravity=(0, 0, 0), supports=[support])
    squares = np.sort([25, 25, 25, *(3 / inertia)])
    assert_allclose(lissom.modes(robot, np.zeros(6)).angular_frequency, np.sqrt(squares))


@pytest.mark.parametrize("quadratic", [False, True])
def test_a_free_rod_sinks_sideways(quadratic):
    """Weight minus buoyancy against drag; with added mass, and viscous drag c = 2 N s / m^2."""
    radius, density, water, c = 5e-3, 3000.0, 1000.0, 2.0
    area = np.pi * radius**2
    drag = {"drag_coefficients": (1.2, 0)} if quadratic else {"viscous_drag": (c, 1)}
    stick = lissom.Segment(0.3, radius, 1e9, poisson_ratio=0.4, density=density, modes={"bend_y": 1})
    link = lissom.Link("stick", rod=[stick], joint=lissom.Free())
    robot = lissom.Robot([link], fluid=lissom.Fluid(water, **drag))
    result = run(robot, [0.0, 3.0], method="radau", rtol=1e-9, atol=1e-9)
    weight = (density - water) * area * G
    inertia = (density + water) * area
    if quadratic:
        speed = np.sqrt(weight / (0.5 * water * 2 * radius * 1.2))
        depth = inertia / (weight / speed**2) * np.log(np.cosh(weight / speed / inertia * 3.0))
        final = speed * np.tanh(weight / speed / inertia * 3.0)
    else:
        speed, decay = weight / c, inertia / c
        final = speed * (1 - np.exp(-3.0 / decay))
        depth = speed * 3.0 - decay * final
    assert_allclose(robot.velocity(result.q[-1], result.v[-1])[3:], [0, 0, -final], atol=1e-7)
    assert_allclose(robot.pose(result.q[-1], 0.0)[:3, 3], [0, 0, -depth], atol=1e-6)
