"""Motions that grow from unstable starts: followed by `method="auto"`, doubted where steps lose them."""

import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lissom
from reference.standing import Chain

TIMES = 101
# The start of a chain in an arbitrary direction in space.
TURNED = Rotation.from_rotvec([0.3, -1.1, 0.7])


def robot(chain, turn=None):
    """The same chain of rods without modes."""
    turn = turn or Rotation.identity()
    x, y, z, w = turn.as_quat()
    links = []
    for i in range(chain.n):
        density = chain.masses[i] / (np.pi * chain.radii[i] ** 2 * chain.lengths[i])
        segment = lissom.Segment(chain.lengths[i], chain.radii[i], 1e9, 4e8, density, {})
        joint = lissom.Revolute((0, 1, 0), stiffness=chain.springs[i], damping=chain.dampers[i])
        where = {"parent": f"link{i - 1}"} if i else {"orientation": (w, x, y, z)}
        links.append(lissom.Link(f"link{i}", rod=[segment], joint=joint, **where))
    push = lissom.Load(force=(-chain.follower, 0, 0), frame="body", link=links[-1].name)
    return lissom.Robot(
        links, gravity=turn.apply([-chain.gravity, 0, 0]), loads=[push] if chain.follower else []
    )


def error(chain, motion, q0, v0, turn=None):
    """Largest distance of a link's end from where it should be, relative to the length."""
    made = robot(chain, turn)
    turn = turn or Rotation.identity()
    ends = [made.pose(motion.q, link=link.name, t=motion.t)[:, :3, 3] for link in made.links]
    ends = np.stack([turn.inv().apply(end) for end in ends], axis=1)
    right = chain.tips(q0, v0, motion.t)
    return np.linalg.norm(ends - right, axis=2).max() / chain.lengths.sum()


def whip(unit=1.0):
    """A pendulum with a small whip on top; lengths in units of so many metres."""
    lengths, masses = unit * np.array([1.0, 0.1]), [1.0, 1e-3]
    return Chain(lengths, masses, springs=[0.0, 0.5 * unit**2], gravity=9.81 * unit)


def double():
    return Chain([0.6, 0.4], [1.0, 0.5], gravity=9.81, dampers=0.01)


def beck(links=6, push=1.6, damping=1e-3):
    """A column of springs under a follower force beyond the critical one of a rod, 20.05 E I / L^2."""
    lengths = np.full(links, 1 / links)
    return Chain(lengths, lengths, springs=links, dampers=damping * links, follower=20.05 * push)


def column(links=5, weight=2.5):
    """A column of springs beyond the weight that buckles a rod, 7.84 E I / L^3."""
    lengths = np.full(links, 1 / links)
    return Chain(lengths, lengths, springs=links, dampers=1e-2, gravity=7.84 * weight)


CHAINS = {"whip": whip, "small whip": lambda: whip(1e-2), "double": double, "beck": beck, "column": column}


def start(chain, size, kicked=False):
    """Relative angles and rates of this size, and the time in which they become large."""
    rate = chain.rates().real.max()
    direction = np.cos(3.0 * np.arange(chain.n))
    q0, v0 = (0.0 * direction, size * rate * direction) if kicked else (size * direction, 0.0 * direction)
    return q0, v0, (np.log(1 / size) + 2.0) / rate


def solve(model, duration, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        return lissom.simulate(model, duration, **options)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("size", [1e-7, 1e-4])
@pytest.mark.parametrize("name", CHAINS)
def test_what_grows_is_followed(name, size, tolerance):
    chain = CHAINS[name]()
    turn = TURNED if name in ("double", "beck") else None
    q0, v0, duration = start(chain, size, kicked=name == "column")
    times = np.linspace(0.0, duration, TIMES)
    motion = lissom.simulate(
        robot(chain, turn), duration, q0=q0, v0=v0, t_eval=times, method="auto", rtol=tolerance
    )
    assert motion.success
    assert motion.doubt is None
    assert error(chain, motion, q0, v0, turn) <= tolerance


def random_chain(rng):
    """A chain of one of the kinds, with its start and time, in other units and directions."""
    kind = rng.integers(4)
    links = int(rng.integers(2, 6))
    lengths, masses = np.full(links, 1 / links), np.full(links, 1 / links)
    damping = rng.choice([0.0, 1e-3, 1e-2])
    options = {"springs": np.full(links, float(links)), "dampers": np.full(links, damping * links)}
    if kind == 0:
        lengths, masses = rng.uniform(0.2, 1.0, links), rng.uniform(0.1, 1.0, links)
        options = {"springs": np.zeros(links), "dampers": np.full(links, 0.03), "gravity": 9.81}
    elif kind == 1:
        lengths[1:], masses[1:] = rng.uniform(0.05, 0.3, links - 1), 10 ** rng.uniform(-3, -1, links - 1)
        lengths[0] = masses[0] = 1.0
        options["springs"] = np.append(0.0, 10 ** rng.uniform(0, 2, links - 1) * masses[1])
        options["dampers"] = damping * options["springs"]
        options["gravity"] = 9.81
    elif kind == 2:
        options["follower"] = 20.05 * rng.uniform(1.2, 2.0)
    else:
        options["gravity"] = 7.84 * rng.uniform(1.3, 5.0)
    unit, second, kilogram = 10 ** rng.uniform(-2, 2, 3)
    moment = kilogram * unit**2 / second**2
    scales = {
        "springs": moment,
        "dampers": moment * second,
        "gravity": unit / second**2,
        "follower": moment / unit,
    }
    options = {key: value * scales[key] for key, value in options.items()}
    return Chain(lengths * unit, masses * kilogram, **options)


@pytest.mark.slow
def test_random_unstable_starts_are_as_accurate_as_asked():
    rng = np.random.default_rng(20)
    wrong, compared = [], 0
    while compared < 180:
        chain = random_chain(rng)
        q0, v0, duration = start(chain, 10 ** rng.uniform(-8, -2), rng.random() < 0.3)
        if chain.rates().real.max() * duration < 1.0 or duration <= 0.0:
            continue
        turn = Rotation.random(rng=rng)
        times = np.linspace(0.0, duration, TIMES)
        apart = np.abs(chain.tips(q0, v0, times) - chain.tips(q0, v0, times, 1e-10)).max()
        for tolerance in (1e-2, 1e-3, 1e-4):
            if apart > 0.1 * tolerance * chain.lengths.sum():
                continue
            motion = solve(
                robot(chain, turn), duration, q0=q0, v0=v0, t_eval=times, method="auto", rtol=tolerance
            )
            compared += 1
            if motion.success and motion.doubt is None:
                found = error(chain, motion, q0, v0, turn)
                if not found <= tolerance:
                    wrong.append((found, tolerance))
    assert wrong == []


@pytest.mark.parametrize("stretch", [0, 1])
def test_rods_that_buckle_under_their_weight_are_followed(stretch):
    length, radius, density = 0.5, 5e-3, 1100.0
    young = 4 * density * 9.81 * length**3 / (7.84 * radius**2) / 3.0
    modes = {"bend_y": 3} | ({"stretch": 1} if stretch else {})
    segment = lissom.Segment(length, radius, young, young / 3, density, modes, retardation_time=1e-3)
    rod = lissom.Robot([lissom.Link("rod", rod=[segment])], gravity=(-9.81, 0, 0))
    q0 = np.zeros(rod.n)
    q0[:3] = np.array([1e-4, -5e-5, 3e-5]) / length
    times = np.linspace(0.0, 3.0, TIMES)
    exact = lissom.simulate(
        rod, 3.0, q0=q0, t_eval=times, method="radau", rtol=1e-9, atol=1e-14, max_step=0.01
    )
    right = rod.pose(exact.q, link="rod")[:, :3, 3]
    assert np.ptp(right[:, 2]) > 0.5 * length
    for tolerance in (1e-2, 1e-4):
        motion = lissom.simulate(rod, 3.0, q0=q0, t_eval=times, method="auto", rtol=tolerance)
        tips = rod.pose(motion.q, link="rod")[:, :3, 3]
        assert np.linalg.norm(tips - right, axis=1).max() <= tolerance * length


def test_an_exact_equilibrium_costs_nothing_and_is_doubted_where_rounding_would_grow():
    chain = column()
    still = np.zeros(chain.n)
    rate = chain.rates().real.max()
    short = lissom.simulate(robot(chain), 10.0 / rate, q0=still, method="auto", rtol=1e-3)
    assert short.success
    assert short.doubt is None
    long = solve(robot(chain), 1000.0 / rate, q0=still, method="auto", rtol=1e-3)
    assert long.success
    assert f"{rate:.3f}"[:4] in long.doubt
    assert "unstable equilibrium" in long.doubt
    assert long.doubt in long.message
    assert long.stats.steps < 2 * short.stats.steps


def test_a_deviation_of_rounding_is_doubted_and_a_large_one_is_not():
    chain = column()
    rate = chain.rates().real.max()
    for size, is_doubted in ((1e-14, True), (1e-9, False)):
        q0 = size * np.eye(chain.n)[0]
        duration = (np.log(1 / size) + 1.0) / rate
        motion = solve(robot(chain), duration, q0=q0, method="auto", rtol=1e-2)
        assert (motion.doubt is not None) == is_doubted, size


def turned(moments, spin, times):
    """Rotations of a free body, by Euler's equations and quaternions."""

    def rhs(_, state):
        w, (real, *rest) = state[:3], state[3:]
        rates = np.append(-np.dot(rest, w), real * w + np.cross(rest, w))
        return np.concatenate([-np.cross(w, moments * w) / moments, 0.5 * rates])

    start = np.append(spin, [1.0, 0.0, 0.0, 0.0])
    found = solve_ivp(rhs, (0.0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-15)
    real, *rest = found.y[3:]
    return Rotation.from_quat(np.stack([*rest, real], axis=1))


MOMENTS = np.array([1.0, 2.0, 3.0])


def spinning(turn):
    body = lissom.Body(1.0, inertia=turn.as_matrix() @ np.diag(MOMENTS) @ turn.as_matrix().T)
    return lissom.Robot([lissom.Link("body", body=body, joint=lissom.Free())], gravity=(0, 0, 0))


@pytest.mark.parametrize("turn", [Rotation.identity(), TURNED])
def test_a_spin_about_the_middle_axis_is_followed_or_doubted(turn):
    model = spinning(turn)
    spin = np.array([1e-6, 50.0, 0.0])
    v0 = np.append(np.zeros(3), turn.apply(spin))

    def off(motion):
        pose = model.pose(motion.q, link="body")[:, :3, :3]
        exact = turn * turned(MOMENTS, spin, motion.t) * turn.inv()
        return (Rotation.from_matrix(pose).inv() * exact).magnitude().max()

    motion = lissom.simulate(model, 1.0, v0=v0, method="auto", rtol=1e-3)
    assert motion.doubt is None
    assert off(motion) < 1e-3
    fixed = solve(model, 1.0, v0=v0, dt=1e-3)
    assert off(fixed) > 0.5
    assert "unstable spin" in fixed.doubt
    # Before errors have grown.
    early = lissom.simulate(model, 0.5, v0=v0, dt=1e-3)
    assert early.doubt is None
    assert off(early) < 1e-3
    # About the other axes nothing grows.
    for axis in (0, 2):
        other = np.append(np.zeros(3), turn.apply(50.0 * np.eye(3)[axis] + 1e-2))
        assert lissom.simulate(model, 1.0, v0=other, dt=1e-3).doubt is None


@pytest.mark.parametrize(
    "options",
    [
        {"dt": 0.1, "method": "average_acceleration"},
        {"method": "radau", "rtol": 1e-2, "atol": 1e-2},
        {"method": "rk45", "rtol": 1e-2, "atol": 1e-2},
    ],
)
def test_given_steps_that_lose_what_grows_are_doubted(options):
    chain = double()
    q0, v0, duration = start(chain, 1e-5)
    motion = solve(robot(chain), duration, q0=q0, v0=v0, **options)
    assert error(chain, motion, q0, v0) > 0.1
    assert f"({chain.rates().real.max():.3f} per second)" in motion.doubt


@pytest.mark.parametrize(
    "options", [{"dt": 2e-2}, {"method": "radau", "rtol": 1e-7, "atol": 1e-10}, {"method": "dop853"}]
)
@pytest.mark.parametrize("name", CHAINS)
def test_given_steps_that_follow_what_grows_are_not_doubted(name, options):
    chain = CHAINS[name]()
    q0, v0, duration = start(chain, 1e-3)
    if "dt" in options:
        options = {"dt": options["dt"] / np.abs(chain.rates()).max()}
    motion = lissom.simulate(robot(chain), 0.8 * duration, q0=q0, v0=v0, **options)
    assert error(chain, motion, q0, v0) < 0.03
    assert motion.doubt is None
