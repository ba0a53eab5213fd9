"""What acts one way only and is exactly reached without a force holds nothing, however its gap is rounded."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lissom

UNITS = [(1, 1, 1), (1e3, 1, 1), (1e3, 1e3, 1), (1e-3, 1e-3, 1), (1, 1e-3, 1e3)]

#: Parts of lengths by which gaps are rounded, or off.
ROUNDED = [0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-13, -1e-13]

#: Weight beside that with which the stop or the plate is only just reached.
PRESSED = 1e-6


class Spring:
    """A body on a spring that its weight presses onto a stop, a plate or a tendon."""

    def __init__(self, seed, unit, turned):
        random = np.random.default_rng(seed)
        self.length, mass, time = unit
        force = mass * self.length / time**2
        turn = Rotation.random(random_state=seed) if turned else Rotation.identity()
        self.place = random.normal(size=3) * 10 * self.length if turned else np.zeros(3)
        x, y, z, w = turn.as_quat()
        self.orientation = (w, x, y, z)
        self.up = turn.apply([0.0, 0.0, 1.0])
        self.mass = random.uniform(0.5, 2) * mass
        self.stiffness = 10 ** random.uniform(1, 4) * force / self.length
        self.weight = 9.81 * self.length / time**2
        self.radius = 0.1 * self.length * random.uniform(0.5, 2)
        self.height = (0.1 + 0.2) * self.length * random.uniform(0.5, 2)
        self.q = -self.mass * self.weight / self.stiffness
        self.frequency = np.sqrt(self.stiffness / self.mass)

    def robot(self, kind, ratio, off=0.0, heavier=0.0, damping=0.0):
        limits, contacts, actuators = {}, [], []
        stiffness = ratio * self.stiffness
        if kind == "stop":
            limits = {"limits": (self.q * (1 + off), -self.q), "limit_stiffness": stiffness}
        if kind == "plate":
            at = self.place + self.up * (self.height + self.q - self.radius + off * self.length)
            plate = lissom.HalfSpace(at, self.up)
            contacts = [lissom.Contact(lissom.Ball("body", self.radius), plate, stiffness=stiffness)]
        if kind == "tendon":
            ends = [lissom.Via("frame", (0, 0, 3 * self.height)), lissom.Via("body", (0, 0, 0))]
            given = {"stiffness": stiffness, "damping": damping}
            length = 2 * self.height - self.q + off * self.length
            actuators = [lissom.Tendon("tendon", ends, length=length, **given)]
        body = lissom.Body(self.mass)
        joint = lissom.Prismatic((0, 0, 1), stiffness=self.stiffness, **limits)
        links = [
            lissom.Link("frame", position=self.place, orientation=self.orientation),
            lissom.Link("body", parent="frame", joint=joint, position=(0, 0, self.height), body=body),
        ]
        gravity = -self.up * self.weight * (1 + heavier)
        return lissom.Robot(links, gravity=gravity, contacts=contacts, actuators=actuators)


def of_linear_model(robot, q):
    rates = np.linalg.eigvals(lissom.linearise(robot, q).A)
    return np.abs(rates).max()


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("kind", ["stop", "plate", "tendon"])
def test_a_spring_alone_holds_what_is_only_just_reached(kind, unit, turned):
    for seed in range(4):
        spring = Spring(seed, unit, turned)
        for ratio in (0.1, 1e2, 1e5, 1e9):
            for off in ROUNDED:
                robot = spring.robot(kind, ratio, off)
                found = lissom.statics(robot, [spring.q])
                assert (found.status, found.stability) == ("converged", "stable")
                for q in ([spring.q], found.q):
                    vibrations = lissom.modes(robot, q)
                    assert vibrations.stability == "stable"
                    frequencies = vibrations.angular_frequency[0], of_linear_model(robot, q)
                    np.testing.assert_allclose(frequencies, spring.frequency, rtol=1e-9)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("kind", ["stop", "plate", "tendon"])
def test_a_millionth_of_the_weight_presses(kind, unit, turned):
    for seed in range(4):
        spring = Spring(seed, unit, turned)
        for ratio in (0.1, 1e2, 1e3):
            robot = spring.robot(kind, ratio, heavier=PRESSED)
            q = lissom.statics(robot, [spring.q]).q
            frequencies = lissom.modes(robot, q).angular_frequency[0], of_linear_model(robot, q)
            np.testing.assert_allclose(frequencies, spring.frequency * np.sqrt(1 + ratio), rtol=1e-6)


@pytest.mark.parametrize("off", ROUNDED)
def test_a_tendon_that_holds_nothing_damps_nothing(off):
    spring = Spring(0, UNITS[0], False)
    robot = spring.robot("tendon", 1.0, off, damping=10.0)
    assert lissom.modes(robot, [spring.q]).damping_ratio == 0
    A = lissom.linearise(robot, [spring.q]).A
    np.testing.assert_allclose(A[1], [-(spring.frequency**2), 0.0], rtol=1e-12)


@pytest.mark.parametrize("off", ROUNDED)
def test_tendons_that_oppose_each_other_hold(off):
    """Just taut, either of two keeps the other one from becoming slack."""
    spring = Spring(1, UNITS[0], False)
    via = [[lissom.Via("frame", (0, 0, z)), lissom.Via("body", (0, 0, 0))] for z in (2.0, -2.0)]
    lengths = [2.0 - spring.height, 2.0 + spring.height]
    tendons = [
        lissom.Tendon(f"t{k}", path, length=length * (1 + sign * off), stiffness=100.0)
        for k, (path, length, sign) in enumerate(zip(via, lengths, (1, -1), strict=True))
    ]
    robot = spring.robot("none", 0.0)
    robot = lissom.Robot(list(robot.links), gravity=(0, 0, 0), actuators=tendons)
    expected = np.sqrt((spring.stiffness + 200.0) / spring.mass)
    frequencies = lissom.modes(robot, [0.0]).angular_frequency[0], of_linear_model(robot, [0.0])
    np.testing.assert_allclose(frequencies, expected, rtol=1e-9)


@pytest.mark.parametrize("off", ROUNDED)
def test_a_pendulum_upside_down_is_not_held_by_a_stop(off):
    joint = lissom.Revolute((0, 1, 0), limits=(-1, 0.1 + 0.2), limit_stiffness=1e4)
    body = lissom.Body(1.0, centre=(0, 0, 0.5), inertia=np.eye(3) * 0.01)
    turned = (np.cos(0.15), 0.0, -np.sin(0.15), 0.0)
    robot = lissom.Robot([lissom.Link("pendulum", joint=joint, orientation=turned, body=body)])
    found = lissom.statics(robot, [0.3 + off], method="newton")
    assert found.stability == "divergence"
    assert lissom.modes(robot, [0.3 + off]).stability == "divergence"
    assert lissom.modes(robot, [0.3001]).stability == "stable"


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("unit", UNITS)
def test_rods_that_only_just_touch_a_plate_vibrate_as_without_it(unit, turned):
    """The plate is beside the tip, or all along the rod; a spring to the world holds the tip as well."""
    length, mass, time = unit
    force = mass * length / time**2
    for seed in range(4):
        random = np.random.default_rng(seed)
        turn = Rotation.random(random_state=seed) if turned else Rotation.identity()
        place = random.normal(size=3) * length if turned else np.zeros(3)
        x, y, z, w = turn.as_quat()
        radius, up = 0.01 * length * random.uniform(0.5, 2), turn.apply([0.0, 0.0, 1.0])
        moduli = np.array([1e7, 4e6]) * force / length**2
        modes = {"torsion": 1, "bend_y": 3, "bend_z": 2}
        rod = lissom.Segment(0.3 * length, radius, *moduli, 1000 * mass / length**3, modes=modes)
        links = [lissom.Link("rod", position=place, orientation=(w, x, y, z), rod=[rod])]
        along = turn.apply([1.0, 0.0, 0.0])
        support = lissom.Support(stiffness=tuple(random.uniform(1, 1e6, 3) * force / length), link="rod")

        def robot(contacts, links=links, support=support):
            return lissom.Robot(links, supports=[support], contacts=contacts, gravity=(0, 0, 0))

        q = np.zeros(6)
        free = lissom.modes(robot([]), q)
        for ball, off in [(b, o) for b in (False, True) for o in ROUNDED]:
            beside = up if not ball else along
            far = radius if not ball else (0.3 + 0.05) * length
            first = lissom.Ball("rod", 0.05 * length, at=0.3 * length) if ball else "rod"
            plate = lissom.HalfSpace(place + beside * far * (1 + off), -beside)
            for stiffness in (1e3, 1e9):
                per = force / length ** (1 if ball else 2)
                touched = robot([lissom.Contact(first, plate, stiffness=stiffness * per)])
                found = lissom.modes(touched, q)
                assert found.stability == free.stability == "stable"
                np.testing.assert_allclose(found.angular_frequency, free.angular_frequency, rtol=1e-9)
                linear = np.linalg.eigvals(lissom.linearise(touched, q).A)
                np.testing.assert_allclose(
                    np.sort(np.abs(linear))[::2], np.sort(free.angular_frequency), rtol=1e-7
                )
