"""Stability and natural frequencies: directions without stiffness, stiff beside soft, other units."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

import lissom

HINGE = lissom.Revolute((0, 1, 0))


def others(stiffness, *, at=(3.0, 0.0, 0.0), gravity=9.81, force=1.0):
    """A ball on a rail that rests on ground of this stiffness: a link and its contact."""
    x, y, z = at
    weight = min(9.81 * force, 0.01 * stiffness)
    link = lissom.Link(
        "ball",
        joint=lissom.Prismatic((0, 0, 1)),
        position=(x, y, z + 0.1 - weight / stiffness),
        body=lissom.Body(weight / gravity),
    )
    contact = lissom.Contact(lissom.Ball("ball", 0.1), lissom.HalfSpace((0, 0, z)), stiffness=stiffness)
    return link, contact


def standing(part, stiffness, *, length=1.0, mass=1.0, time=1.0):
    """A pendulum held upright by this part of the critical stiffness, beside a ball on stiff ground."""
    g, m, height = 9.81 * length / time**2, mass, 0.5 * length
    force = mass * length / time**2
    ball, contact = others(stiffness * force / length, gravity=g, force=force, at=(3 * length, 0, 0))
    joint = lissom.Revolute((0, 1, 0), stiffness=part * m * g * height)
    body = lissom.Body(m, centre=(0, 0, height), inertia=np.eye(3) * 0.01 * m * length**2)
    links = [lissom.Link("pendulum", joint=joint, body=body), ball]
    return lissom.Robot(links, contacts=[contact], gravity=(0, 0, -g))


STIFFNESSES = [10.0**e for e in range(0, 17, 2)]


class TestBesideStiffThings:
    @pytest.mark.parametrize("stiffness", STIFFNESSES)
    @pytest.mark.parametrize(("part", "verdict"), [(1.0001, "stable"), (0.9999, "divergence")])
    def test_a_pendulum_near_its_critical_stiffness(self, part, verdict, stiffness):
        robot = standing(part, stiffness)
        found = lissom.statics(robot, np.zeros(2), method="newton")
        assert found.success
        assert found.stability == verdict
        modes = lissom.modes(robot, found.q)
        assert modes.stability == verdict
        # J w^2 = (part - 1) m g h with J = 0.01 + m h^2.
        square = (part - 1) * 9.81 * 0.5 / 0.26
        if verdict == "stable":
            slow = modes.angular_frequency[np.argmin(np.abs(modes.angular_frequency**2 - square))]
            assert slow**2 == pytest.approx(square, rel=1e-10)
        else:
            assert modes.frequency[0] == 0
            assert modes.eigenvalues[0].real == pytest.approx(np.sqrt(-square), rel=1e-10)

    @pytest.mark.parametrize(("length", "mass", "time"), [(1e3, 1, 1), (1e-3, 1e3, 1), (1, 1e-3, 1e3)])
    def test_in_other_units(self, length, mass, time):
        for part, verdict in ((1.0001, "stable"), (0.9999, "divergence")):
            robot = standing(part, 1e11, length=length, mass=mass, time=time)
            assert lissom.statics(robot, np.zeros(2), method="newton").stability == verdict
            assert lissom.modes(robot, np.zeros(2)).stability == verdict

    @pytest.mark.parametrize("stiffness", [1.0, 1e8, 1e16])
    def test_exactly_critical_is_neutral(self, stiffness):
        modes = lissom.modes(standing(1.0, stiffness), np.zeros(2))
        assert modes.stability == "neutral"
        assert modes.frequency.min() == 0

    @pytest.mark.parametrize("exponent", range(0, 17, 2))
    def test_a_hinged_line_on_the_ground(self, exponent):
        """On elastic ground of k L^4 / E I from 1 to 1e16, a turn about the hinge is slowest."""
        length, bending = 100.0, 1e5
        k = 10.0**exponent * bending / length**4
        modulus, weight = bending / (np.pi / 4 * 0.05**4), min(1e3, 0.01 * k)
        density = weight / 9.81 / (np.pi * 0.05**2)
        segment = lissom.Segment(length / 5, 0.05, modulus, modulus / 3, density, modes={"bend_y": 4})
        ground = lissom.HalfSpace((0, 0, weight / k - 0.05))
        robot = lissom.Robot(
            [lissom.Link("line", joint=HINGE, rod=[segment] * 5)],
            contacts=[lissom.Contact("line", ground, stiffness=k)],
        )
        q = np.zeros(robot.n)
        modes = lissom.modes(robot, q)
        assert modes.stability == "stable"
        assert lissom.statics(robot, q, method="newton").stability == "stable"
        # Without other restoring forces all of the line has the frequency sqrt(k / m).
        slowest = np.sqrt(k * 9.81 / weight)
        assert modes.angular_frequency[0] == pytest.approx(slowest, rel=1e-3)

    @pytest.mark.parametrize("follows", [0.1, 0.25, 0.4])
    @pytest.mark.parametrize(("part", "verdict"), [(0.999, "stable"), (1.001, "divergence")])
    def test_a_force_that_follows_in_part_buckles(self, part, verdict, follows):
        """Without a potential, yet without flutter up to a half: cos(l) = -a / (1 - a), F = l^2 E I / L^2.

        From E I y'' = F (y(L) - y) - a F y'(L) (L - x) with both ends of the deflection y (Leipholz 1970).
        """
        radius, modulus = 0.01, 1e7
        critical = np.arccos(-follows / (1 - follows)) ** 2 * modulus * np.pi / 4 * radius**4
        parts = {"world": (1 - follows) * part * critical, "body": follows * part * critical}
        loads = [lissom.Load(force=(-force, 0, 0), frame=frame) for frame, force in parts.items()]
        rod = [lissom.Segment(1.0, radius, modulus, modulus / 3, 1000, modes={"bend_y": 8}, nodes=24)]
        model = lissom.Rod(rod, loads=loads, gravity=(0, 0, 0))
        found = lissom.statics(model, np.zeros(8), method="newton")
        assert np.abs(found.q).max() < 1e-9
        assert found.stability == lissom.modes(model, found.q).stability == verdict

    @pytest.mark.parametrize("stiffness", [None, 1e4, 1e12])
    @pytest.mark.parametrize(("force", "verdict"), [(19.8, "stable"), (20.3, "flutter")])
    def test_becks_column(self, force, verdict, stiffness):
        """Follower forces above 20.05 E I / L^2 make a cantilever flutter (Beck 1952)."""
        radius, modulus = 0.01, 1e7
        load = lissom.Load(
            force=(-force * modulus * np.pi / 4 * radius**4, 0, 0), frame="body", link="column"
        )
        rod = [lissom.Segment(1.0, radius, modulus, modulus / 3, 1000, modes={"bend_y": 6}, nodes=24)]
        links, contacts = [lissom.Link("column", rod=rod)], []
        if stiffness:
            ball, contact = others(stiffness)
            # Weightless, so that gravity bends nothing: the ball presses by a load of its own.
            links, contacts = [*links, ball], [contact]
        press = [lissom.Load(force=(0, 0, -9.81), link="ball")] if stiffness else []
        robot = lissom.Robot(links, contacts=contacts, loads=[load, *press], gravity=(0, 0, 0))
        found = lissom.statics(robot, np.zeros(robot.n), method="newton")
        assert found.undamped_stability == verdict


def random_body(rng):
    """A body on a ball joint; its centre and its inertia about that."""
    a, centre = rng.normal(size=(3, 3)), rng.normal(size=3) * 10 ** rng.uniform(-2, 0)
    inertia = a @ a.T * 10 ** rng.uniform(-3, 0)
    inertia = np.trace(inertia) * np.eye(3) - inertia
    body = lissom.Body(1.0, centre=centre, inertia=inertia)
    return lissom.Robot([lissom.Link("b", joint=lissom.Spherical(), body=body)]), centre, inertia


def hanging(centre, about):
    """A rotation vector in which the centre hangs below the joint, turned about the vertical by an angle."""
    down = Rotation.align_vectors([[0, 0, -1]], [centre])[0]
    return (Rotation.from_rotvec([0, 0, about]) * down).as_rotvec()


class TestBodiesThatTurnFreely:
    def test_frequencies_on_ball_joints(self):
        """From the inertia about the joint: one direction has no stiffness, but moves in all modes."""
        rng = np.random.default_rng(7)
        for _ in range(100):
            robot, centre, inertia = random_body(rng)
            q = hanging(centre, rng.uniform(-3, 3))
            up = Rotation.from_rotvec(q).inv().apply([0, 0, 1])
            about = inertia + centre @ centre * np.eye(3) - np.outer(centre, centre)
            across = np.linalg.svd(up[None])[2][1:]
            stiffness = 9.81 * np.linalg.norm(centre) * np.eye(2)
            moved = about - np.outer(about @ up, about @ up) / (up @ about @ up)
            squares = eigh(stiffness, across @ moved @ across.T)[0]
            for shape in (q, lissom.statics(robot, q, method="newton").q):
                modes = lissom.modes(robot, shape)
                assert modes.stability == "neutral"
                assert modes.frequency[0] == 0
                np.testing.assert_allclose(modes.angular_frequency[1:], np.sqrt(squares), rtol=1e-9)

    def test_bodies_under_pins(self):
        """A free body that a loop holds above its centre: the loop's force balances its weight."""
        rng = np.random.default_rng(3)
        for inertia in np.linspace(0.05, 0.3, 8):
            body = lissom.Body(1.0, inertia=np.eye(3) * inertia)
            loop = lissom.Loop(("b", None, (0, 0, 1)), (None, None, (0, 0, 2)), lissom.Spherical())
            robot = lissom.Robot([lissom.Link("b", joint=lissom.Free(), body=body)], loops=[loop])
            turned = np.array([0, 0, rng.uniform(-3, 3)])
            q = np.concatenate([[0, 0, 1], turned])
            modes = lissom.modes(robot, q)
            assert modes.stability == "neutral"
            assert modes.frequency[0] == 0
            np.testing.assert_allclose(modes.angular_frequency[1:], np.sqrt(9.81 / (1 + inertia)), rtol=1e-9)

    @pytest.mark.parametrize("beside", [None, 1e4, 1e12])
    def test_a_round_rod_that_buckles_may_turn(self, beside):
        """A buckled column may buckle to every side: neutral, whatever is beside it."""
        radius, modulus = 0.01, 1e7
        critical = np.pi**2 / 4 * modulus * np.pi / 4 * radius**4
        load = lissom.Load(force=(-1.1 * critical, 0, 0), link="column")
        modes = {"bend_y": 4, "bend_z": 4}
        rod = [lissom.Segment(1.0, radius, modulus, modulus / 3, 1000, modes=modes, nodes=24)]
        links, contacts, loads = [lissom.Link("column", rod=rod)], [], [load]
        if beside:
            ball, contact = others(beside, at=(0, 5, 0))
            links, contacts = [*links, ball], [contact]
            loads.append(lissom.Load(force=(0, 0, -9.81), link="ball"))
        robot = lissom.Robot(links, contacts=contacts, loads=loads, gravity=(0, 0, 0))
        q0 = np.zeros(robot.n)
        q0[0], q0[4] = 0.5, 0.3
        found = lissom.statics(robot, q0)
        assert found.success
        assert found.stability == "neutral"
        assert lissom.modes(robot, found.q).frequency[0] == 0


def arm(*, beside=None, turning=None):
    """A double pendulum whose modes a damper couples, beside a ball on ground and a disc."""
    body = lissom.Body(1.0, centre=(0.3, 0, 0), inertia=np.eye(3) * 0.02)
    links = [
        lissom.Link("upper", joint=lissom.Revolute((0, 1, 0)), body=body),
        lissom.Link(
            "lower",
            parent="upper",
            position=(0.6, 0, 0),
            joint=lissom.Revolute((0, 1, 0), damping=0.1),
            body=body,
        ),
    ]
    contacts = []
    if turning is not None:
        disc = lissom.Body(1.0, inertia=np.eye(3) * 0.5)
        links.append(lissom.Link("disc", joint=lissom.Revolute((0, 0, 1), damping=turning), body=disc))
    if beside:
        ball, contact = others(beside)
        links, contacts = [*links, ball], [contact]
    return lissom.Robot(links, contacts=contacts)


class TestCoupledDamping:
    @pytest.mark.parametrize("beside", [None, 1e4, 1e10, 1e16])
    @pytest.mark.parametrize("turning", [None, 0.0, 0.3])
    def test_slow_eigenvalues_beside_stiff_ones(self, beside, turning):
        """Eigenvalues of the double pendulum alone, from SciPy, with whatever is beside it."""
        alone, q = arm(), np.array([np.pi / 2, 0.0])
        K, D = alone.tangent(q, 0 * q, 0 * q)[:2]
        state = np.block(
            [[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(alone.mass_matrix(q), np.hstack([K, D]))]]
        )
        right = np.linalg.eigvals(state)
        robot = arm(beside=beside, turning=turning)
        found = lissom.modes(robot, np.concatenate([q, np.zeros(robot.n - 2)]))
        assert not found.is_classical
        for value in right[right.imag > 0]:
            assert np.abs(found.eigenvalues - value).min() < 1e-9 * abs(value)
        assert found.stability == ("stable" if turning is None else "neutral")
        assert np.count_nonzero(found.frequency == 0) == (turning is not None)
        if turning:
            assert np.abs(found.eigenvalues + turning / 0.5).min() < 1e-9

    def test_references_of_random_robots(self):
        """SciPy's generalised eigenvalues of the matrices, about hanging shapes of random chains."""
        rng = np.random.default_rng(5)
        for _ in range(20):
            links, parent = [], None
            for name in "abc":
                joint = lissom.Revolute(rng.normal(size=3), stiffness=10 ** rng.uniform(0, 6))
                body = lissom.Body(
                    10 ** rng.uniform(-3, 1), centre=rng.normal(size=3) * 0.2, inertia=np.eye(3) * 0.1
                )
                links.append(
                    lissom.Link(
                        name, parent=parent, position=rng.normal(size=3) * 0.3, joint=joint, body=body
                    )
                )
                parent = name
            robot = lissom.Robot(links)
            found = lissom.statics(robot)
            if not found.success:
                continue
            q = found.q
            K = robot.tangent(q, 0 * q, 0 * q)[0]
            squares = 1 / eigh(robot.mass_matrix(q), K)[0][::-1]
            np.testing.assert_allclose(lissom.modes(robot, q).angular_frequency, np.sqrt(squares), rtol=1e-7)


class TestWithoutVerdict:
    def test_nobody_asks(self):
        segment = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": 3})
        judged = lissom.statics(lissom.Rod([segment]))
        found = lissom.statics(lissom.Rod([segment]), stability=False)
        np.testing.assert_array_equal(found.q, judged.q)
        assert judged.stability == "stable"
        assert found.success
        assert found.stability is None
        assert found.is_stable is None
        assert found.undamped_stability is None
        assert found.path.stability == [None] * len(judged.path.stability)
        assert "unknown" not in found.message

    def test_with_loops(self):
        loop = lissom.Loop("a", (None, None, (0.9, 0, 0.2)), HINGE)
        segment = lissom.Segment(1.0, 0.01, 1e7, 4e6, 1000, modes={"bend_y": 4})
        robot = lissom.Robot([lissom.Link("a", joint=HINGE, rod=[segment])], loops=[loop])
        for method in ("auto", "newton"):
            found = lissom.statics(robot, stability=False, method=method)
            assert found.stability is None
            assert "unknown" not in found.message


class TestPlacesAtTheEnd:
    @settings(max_examples=60, deadline=None)
    @given(st.integers(1, 12), st.floats(1e-3, 10.0))
    def test_sums_of_lengths_are_rounded(self, n, length):
        """Where a rod of n equal segments ends, n times their length is a place; a little beyond is none."""
        segment = lissom.Segment(length, 0.01 * length, 1e6, 4e5, 1000, modes={"bend_y": 1})
        end = n * length
        link = lissom.Link("a", rod=[segment] * n)
        robot = lissom.Robot(
            [link],
            loads=[
                lissom.Load(force=(0, 0, 1), at=end, link="a"),
                lissom.Load(force=(0, 0, 1), along=(0, end), link="a"),
            ],
            supports=[lissom.Support(stiffness=1.0, at=end, link="a")],
            contacts=[
                lissom.Contact(
                    lissom.Ball("a", 0.01 * length, at=end), lissom.HalfSpace((0, 0, -99)), stiffness=1e3
                )
            ],
            actuators=[
                lissom.Tendon(
                    "t",
                    [lissom.Via(None, (0, 0, 1)), lissom.Via("a", (0, 0, 0), at=end)],
                    stiffness=1,
                    length=9,
                )
            ],
        )
        q = np.zeros(robot.n)
        near = {"rtol": 1e-12, "atol": 1e-12 * end}
        np.testing.assert_allclose(robot.pose(q, end), robot.pose(q), **near)
        np.testing.assert_allclose(robot.jacobian(q, end), robot.jacobian(q), **near)
        np.testing.assert_allclose(robot.strain(q, end), robot.strain(q, sum([length] * n)), **near)
        assert np.isfinite(robot.internal_wrench(q, q, q, end)).all()
        for beyond in (end * (1 + 1e-9), -1e-9 * end):
            with pytest.raises(ValueError, match="arc length"):
                robot.pose(q, beyond)


def balls(turns, step, **more):
    """A chain of bodies on ball joints, each turned about the chain by an angle that nothing holds."""
    links = [
        lissom.Link(
            f"b{i}",
            parent=f"b{i - 1}" if i else None,
            position=step if i else (0, 0, 0),
            joint=lissom.Spherical(),
            body=lissom.Body(1.0, centre=0.5 * np.array(step), inertia=(0.1, 0.12, 0.15)),
        )
        for i in range(len(turns))
    ]
    tip = lissom.Link("tip", parent=links[-1].name, position=step, body=lissom.Body(1e-9))
    return lissom.Robot([*links, tip], **more)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
@pytest.mark.parametrize("pulled", [False, True])
def test_chains_of_ball_joints_can_turn_about_themselves(count, pulled):
    """Whatever rounding leaves of such turns is neither a stiffness nor an instability."""
    rng = np.random.default_rng(count)
    for _ in range(6):
        turns, q = rng.uniform(-3, 3, count), np.zeros(3 * count)
        if pulled:
            q[:3] = rng.normal(size=3)
            q[3::3] = turns[1:]
            force = 10 * Rotation.from_rotvec(q[:3]).as_matrix()[:, 0]
            robot = balls(turns, (1, 0, 0), gravity=(0, 0, 0), loads=[lissom.Load(force=force, link="tip")])
        else:
            q[2::3] = turns
            robot = balls(turns, (0, 0, -1))
        found = lissom.modes(robot, q)
        assert found.stability == "neutral"
        assert (found.angular_frequency == 0).sum() == count
        assert (found.angular_frequency > 0.1).sum() == 2 * count
        assert lissom.statics(robot, q, method="newton").stability == "neutral"


@pytest.mark.parametrize("stiffness", [1e2, 1e4, 1e8, 1e12])
@pytest.mark.parametrize("turn", [0.0, 1e-15, 1e-12, 1e-6, 1e-2])
def test_a_ball_on_a_floor_is_neutral_however_it_is_turned(stiffness, turn):
    """Nothing turns it back: what is left of its stiffness is rounding of forces times its radius."""
    ball = lissom.Body(1.0, inertia=np.eye(3) * 0.004)
    robot = lissom.Robot(
        [lissom.Link("b", joint=lissom.Free(), body=ball, position=(0, 0, 1))],
        contacts=[lissom.Contact(lissom.Ball("b", 0.1), lissom.HalfSpace(), stiffness=stiffness)],
    )
    q = [0.1, 0.2, -0.9 - 9.81 / stiffness, turn, -turn, 0.5]
    found = lissom.modes(robot, q)
    assert found.stability == "neutral"
    np.testing.assert_array_equal(found.frequency[:5], 0.0)
    np.testing.assert_allclose(found.angular_frequency[5], np.sqrt(stiffness), rtol=1e-6)


@pytest.mark.parametrize("stiffness", [1e2, 1e6, 1e10])
@pytest.mark.parametrize("turn", [0.0, 1e-12, 1e-3, 1.0])
def test_balls_on_each_other_are_neutral_however_they_are_turned(stiffness, turn):
    """Nothing but the contact couples them, and nothing turns them back."""
    rail = lissom.Prismatic((0, 0, 1))
    links = []
    for name, height in (("low", 0.1), ("high", 0.3)):
        ball = lissom.Body(1.0, inertia=np.eye(3) * 0.004)
        links.append(lissom.Link(f"{name} rail", joint=rail, position=(0, 0, height)))
        links.append(lissom.Link(name, parent=f"{name} rail", joint=lissom.Spherical(), body=ball))
    low, high = lissom.Ball("low", 0.1), lissom.Ball("high", 0.1)
    contacts = [
        lissom.Contact(low, lissom.HalfSpace(), stiffness=2 * stiffness),
        lissom.Contact(low, high, stiffness=stiffness),
    ]
    robot = lissom.Robot(links, contacts=contacts)
    sunk = 9.81 / stiffness
    found = lissom.modes(robot, [-sunk, turn, -turn, 0.5, -2 * sunk, 0.3, turn, -turn])
    assert found.stability == "neutral"
    np.testing.assert_array_equal(found.frequency[:6], 0.0)
    # Two masses of one kilogram on springs of 2 k and k: squares of k (2 -+ sqrt(2)).
    squares = stiffness * (2 + np.array([-1, 1]) * np.sqrt(2))
    np.testing.assert_allclose(found.angular_frequency[6:], np.sqrt(squares), rtol=1e-6)


def random_inertia(rng):
    """Of a body: its mass, its centre and its inertia about that."""
    a = rng.normal(size=(3, 3))
    inertia = (np.eye(3) + 0.05 * (a + a.T)) * 10 ** rng.uniform(-5, -1)
    return 10 ** rng.uniform(-2, 1), rng.normal(size=3) * 10 ** rng.uniform(-3, 0), inertia


def hung(rng, count, *, stiffness=None, length=1.0, mass=1.0, fixed=1, places=1, damping=0.0):
    """A free body on elastic cords between places of the world and places of its own."""
    own, centre, inertia = random_inertia(rng)
    body = lissom.Body(own * mass, centre=centre * length, inertia=inertia * mass * length**2)
    turned = Rotation.random(random_state=int(rng.integers(1 << 30))).as_quat(scalar_first=True)
    holds, held = rng.normal(size=(fixed, 3)) + np.array([0, 0, 1]), rng.normal(size=(places, 3)) * 0.3
    cords = [
        lissom.Tendon(
            f"c{i}",
            [
                lissom.Via(None, holds[i % fixed] * length),
                lissom.Via("b", held[i % places] * length),
            ],
            length=(0.3 + rng.random()) * length,
            stiffness=(10 ** rng.uniform(1, 4) if stiffness is None else stiffness) * mass,
            damping=damping,
        )
        for i in range(count)
    ]
    link = lissom.Link("b", joint=lissom.Free(), orientation=turned, body=body)
    start = rng.normal(size=6) * rng.choice([0.3, 1.0, 2.0])
    start[:3] *= length
    return lissom.Robot([link], actuators=cords, gravity=(0, 0, -9.81 * length)), start


def judge(robot, start, verdict, neutral=None):
    """Verdicts of statics and modes, and how many frequencies are zero."""
    # Verdicts are those of the modes there are, few or not.
    found = lissom.statics(robot, start, space_error=False)
    assert found.success, found.message
    assert found.stability == verdict
    modes = lissom.modes(robot, found.q)
    assert modes.stability == verdict
    zeros = np.count_nonzero(modes.frequency == 0)
    assert zeros == neutral if neutral is not None else (zeros > 0) == (verdict == "neutral")


class TestBodiesOnCords:
    @pytest.mark.parametrize(("length", "mass"), [(1, 1), (1e3, 1), (1e-3, 1e-3)])
    @pytest.mark.parametrize("stiffness", [None, 1.0, 1e8, 1e14])
    def test_on_one_cord_they_turn_freely(self, stiffness, length, mass):
        """About the vertical through both ends of the cord: the weight acts in this line."""
        for seed in range(25):
            rng = np.random.default_rng(seed)
            robot, start = hung(rng, 1, stiffness=stiffness, length=length, mass=mass)
            # A tension of stiffness times rounding of the length leaves no other frequencies.
            judge(robot, start, "neutral", None if stiffness == 1e14 else 1)

    @pytest.mark.parametrize(("fixed", "places"), [(1, 2), (2, 1)])
    def test_on_two_cords_that_meet(self, fixed, places):
        """In a place of the world, or of the body."""
        for seed in range(20):
            rng = np.random.default_rng(seed)
            judge(*hung(rng, 2, fixed=fixed, places=places), "neutral")

    @pytest.mark.parametrize("damping", [0.1, 10.0])
    def test_with_damping(self, damping):
        for seed in range(15):
            judge(*hung(np.random.default_rng(seed), 1, damping=damping), "neutral")

    @pytest.mark.parametrize("stiffness", [1e2, 1e6, 1e10])
    def test_a_pendulum_on_a_body_on_three_cords_is_stable(self, stiffness):
        """However light it is beside the body."""
        angles = np.array([0, 2, 4])
        body = lissom.Body(100.0, centre=(0, 0, -0.1), inertia=np.eye(3))
        cords = [
            lissom.Tendon(
                f"c{i}",
                [
                    lissom.Via(None, (np.cos(a), np.sin(a), 1)),
                    lissom.Via("b", (0.2 * np.cos(a), 0.2 * np.sin(a), 0.1)),
                ],
                length=0.5,
                stiffness=stiffness * 10,
            )
            for i, a in enumerate(angles)
        ]
        for mass in (1e-3, 1e-5, 1e-7):
            bob = lissom.Body(mass, centre=(0, 0, -0.1))
            links = [
                lissom.Link("b", joint=lissom.Free(), body=body),
                lissom.Link("p", parent="b", joint=HINGE, position=(0, 0.1, 0), body=bob),
            ]
            robot = lissom.Robot(links, actuators=cords)
            judge(robot, 0.2 * np.random.default_rng(0).normal(size=7), "stable")


@pytest.mark.parametrize("seed", range(6))
def test_three_hinges_that_meet_turn_freely(seed):
    """A body on them hangs as on a ball joint: one turn of it is that of all three."""
    rng = np.random.default_rng(seed)
    turned = Rotation.random(random_state=seed).as_quat(scalar_first=True)
    mass, centre, inertia = random_inertia(rng)
    body = lissom.Body(mass, centre=centre, inertia=inertia)
    links = [
        lissom.Link("x", joint=lissom.Revolute((1, 0, 0)), orientation=turned),
        lissom.Link("y", parent="x", joint=lissom.Revolute((0, 1, 0))),
        lissom.Link("z", parent="y", joint=lissom.Revolute((0, 0, 1)), body=body),
    ]
    judge(lissom.Robot(links), rng.normal(size=3), "neutral", 1)


def column(part, degree, *, length=1.0, modulus=1e9):
    """Of round section and clamped, under this part of its critical load."""
    radius = 0.01 * length
    critical = np.pi**2 / 4 * modulus * np.pi / 4 * radius**4 / length**2
    modes = {"bend_y": degree, "bend_z": degree}
    segment = lissom.Segment(length, radius, modulus, 0.4 * modulus, 1000, modes=modes)
    return lissom.Rod([segment], gravity=(0, 0, 0), tip_force=(-part * critical, 0, 0))


class TestRoundColumns:
    @pytest.mark.parametrize("length", [1.0, 1e-3, 1e3])
    @pytest.mark.parametrize("more", [1e-6, 1e-5, 1e-4, 1e-3, 0.1])
    def test_what_has_just_buckled_may_turn(self, more, length):
        """About the axis, however little it has buckled: by the root of what is over the critical load."""
        robot = column(1 + more, 6, length=length)
        for seed in range(4):
            start = 0.2 * np.random.default_rng(seed).normal(size=robot.n) / length
            judge(robot, start, "neutral", 1)

    @pytest.mark.parametrize("less", [1e-7, 1e-6, 1e-4])
    def test_what_has_nearly_buckled_is_stable(self, less):
        robot = column(1 - less, 8)
        for seed in range(3):
            judge(robot, 0.1 * np.random.default_rng(seed).normal(size=robot.n), "stable")

    @pytest.mark.parametrize("degree", [2, 3, 6])
    @pytest.mark.parametrize("part", [2.0, 4.0, 6.0])
    def test_what_has_buckled_far_may_turn(self, part, degree):
        """Few nodes for so much curvature: the stiffness is the change of the forces to quadrature only."""
        robot = column(part, degree)
        judge(robot, 0.3 * np.random.default_rng(1).normal(size=robot.n), "neutral", 1)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e-3])
@pytest.mark.parametrize("stiffness", [1e8, 1e12, 1e14, 1e16])
@pytest.mark.parametrize(
    ("joint", "verdict"),
    [
        (lissom.Free(), "neutral"),
        (lissom.Revolute((0, 0, 1)), "neutral"),
        (lissom.Spherical(), "neutral"),
        (HINGE, "stable"),
        (lissom.Weld(), "stable"),
    ],
    ids=["free", "upright hinge", "ball joint", "level hinge", "clamp"],
)
def test_lines_on_stiff_ground(joint, verdict, stiffness, unit):
    """Ground of a multiple of E I / L^4 without friction: nothing holds what shifts or turns on it."""
    radius, length, modulus = 0.01 * unit, 0.5 * unit, 1e7 / unit
    segment = lissom.Segment(length, radius, modulus, 0.4 * modulus, 1000 / unit**3, modes={"bend_y": 3})
    ground = lissom.Contact(
        "line", lissom.HalfSpace(), stiffness=stiffness * np.pi / 4 * radius**4 * modulus / length**4
    )
    link = lissom.Link("line", joint=joint, position=(0, 0, radius), rod=[segment])
    robot = lissom.Robot([link], contacts=[ground], gravity=(0, 0, -9.81 * unit))
    judge(robot, None, verdict)


@pytest.mark.parametrize("unit", [(1, 1, 1), (1e3, 1, 1), (1e-3, 1e-3, 1), (1, 1e3, 1e3)])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("seed", [0, 14, 23, 30])
def test_a_tendon_exactly_at_its_length_holds_nothing(seed, turned, unit):
    """A rod hangs on a ball joint and may turn about itself: one way the tendon becomes slack.

    Next to no force does work on its torsion, so that rounding is all that is left there.
    """
    length, mass, time = unit
    force = mass * length / time**2
    random = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed) if turned else Rotation.identity()
    x, y, z, w = turn.as_quat()
    place = np.array([3.0, -8.0, 5.0]) * length if turned else np.zeros(3)
    moduli = np.array([1e7, 4e6]) * force / length**2
    modes = {"torsion": 1, "bend_y": 2, "bend_z": 2}
    rod = lissom.Segment(0.3 * length, 0.01 * length, *moduli, 1000 * mass / length**3, modes=modes)
    down = (np.sqrt(0.5), 0, np.sqrt(0.5), 0)
    links = [
        lissom.Link("frame", position=place, orientation=(w, x, y, z)),
        lissom.Link("arm", parent="frame", joint=lissom.Spherical(), orientation=down, rod=[rod]),
    ]
    beside, at = random.normal(size=3) * 0.02 * length, 0.3 * length * random.uniform(0.5, 1)
    path = [lissom.Via("arm", beside, at=at), lissom.Via("frame", random.normal(size=3) * 0.5 * length)]
    stiffness = 10 ** random.uniform(1, 3) * force / length

    def robot(rest):
        tendon = lissom.Tendon("tendon", path, length=rest, stiffness=stiffness)
        return lissom.Robot(links, actuators=[tendon], gravity=turn.apply([0, 0, -9.81]) * length / time**2)

    q = np.zeros(8)
    just = robot(robot(length).actuator_length("tendon", q))
    found = lissom.statics(just, q, method="newton")
    assert (found.status, found.stability) == ("converged", "neutral")
    for shape in (q, found.q):
        vibrations = lissom.modes(just, shape)
        assert vibrations.stability == "neutral"
        assert vibrations.angular_frequency[0] == 0
        assert vibrations.angular_frequency[1] > 1 / time
