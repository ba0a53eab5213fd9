"""Properties of every rod and method: orders, scaling, reversibility, restarts, identical reruns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

import lissom
from reference.rod import STRAINS
from rod_cases import random_rods, random_states, rich_rod, seeds

FIXED_STEP = [
    "average_acceleration",
    "linear_acceleration",
    "fox_goodwin",
    "central_difference",
    "hht",
    "generalised_alpha",
]
ADAPTIVE = ["rk45", "dop853", "radau"]
METHODS = ["newmark", *FIXED_STEP, *ADAPTIVE]


def finger(retardation_time=0.02):
    """A rod that bends in space under a force out of its plane, with a smooth motion."""
    modes = {"bend_y": 2, "bend_z": 1}
    segment = lissom.Segment(0.3, 0.02, 1e5, 4e4, 1e3, modes, retardation_time)
    return lissom.Rod([segment], tip_force=(0.0, 0.05, 0.0))


def slope(x, y):
    """Exponent p of y ~ x^p."""
    return np.polyfit(np.log(x), np.log(y), 1)[0]


# Order of convergence in time


def final_errors(duration, runs):
    """Largest error of a coordinate at the end of each run, and the mean step."""
    rod = finger()
    exact = lissom.simulate(rod, duration, method="dop853", rtol=1e-13, atol=1e-14).q[-1]
    motions = [lissom.simulate(rod, duration, **run) for run in runs]
    assert all(motion.success for motion in motions)
    steps = [duration / motion.stats.steps for motion in motions]
    return steps, [np.abs(motion.q[-1] - exact).max() for motion in motions]


@pytest.mark.parametrize("method", FIXED_STEP)
def test_fixed_steps_have_order_two(method):
    runs = [{"method": method, "dt": 0.4 / n, "rtol": 1e-10, "atol": 1e-12} for n in (40, 80, 160, 320)]
    assert_allclose(slope(*final_errors(0.4, runs)), 2, atol=0.05)


def test_newmark_with_numerical_damping_has_order_one():
    runs = [{"dt": 0.4 / n, "gamma": 0.6, "beta": 0.3025, "rtol": 1e-10} for n in (80, 160, 320, 640)]
    assert_allclose(slope(*final_errors(0.4, runs)), 1, atol=0.05)


@pytest.mark.parametrize(
    ("method", "order", "numbers", "within"),
    [("rk45", 5, [32, 48, 64, 96, 128], 0.15), ("dop853", 8, [24, 28, 32, 36, 40], 0.3)],
)
def test_explicit_steps_have_the_order_of_the_method(method, order, numbers, within):
    """Tolerances that are always satisfied, so that all steps have the given size."""
    rod, duration = finger(), 0.35
    exact = lissom.simulate(rod, duration, method="dop853", rtol=1e-14, atol=1e-15)
    right, errors = np.concatenate((exact.q[-1], exact.v[-1])), []
    for n in numbers:
        steps = {"first_step": duration / n, "max_step": duration / n, "rtol": 0.1, "atol": 1e9}
        found = lissom.solve_ivp(rod, (0.0, duration), np.zeros(2 * rod.n), method, **steps)
        assert found.naccepted in (n, n + 1)
        errors.append(np.abs(found.y[:, -1] - right).max())
    assert_allclose(-slope(numbers, errors), order, atol=within)


def test_radau_has_order_five():
    """Errors as a function of the mean step for decreasing tolerances, also of Newton's iteration."""
    runs = [{"method": "radau", "rtol": x, "atol": x} for x in np.geomspace(1e-4, 1e-9, 11)]
    assert_allclose(slope(*final_errors(1.0, runs)), 5, atol=0.25)


# Spectral convergence in modes


def cantilever(modes):
    return lissom.Rod([lissom.Segment(0.5, 0.01, 1e7, 1e7 / 3, 1e3, {"bend_y": modes}, 0.01)])


def equilibrium(rod):
    """The centre line in equilibrium, relative to the length."""
    return (
        rod.pose(lissom.statics(rod, space_error=False).q, np.linspace(0.0, rod.length, 11))[:, :3, 3]
        / rod.length
    )


def vibration(rod):
    """Path of the tip, relative to the length, started along the first natural mode: smooth in time."""
    rest = lissom.statics(rod, space_error=False).q
    found = lissom.modes(rod, rest)
    shape = found.shapes[:, 0].real
    tip = rod.jacobian(rest, rod.length)[3:] @ shape
    v0 = 0.02 * shape * np.sign(tip[2]) / np.linalg.norm(tip)
    times = np.linspace(0.0, 0.3, 6)
    motion = lissom.simulate(rod, 0.3, q0=rest, v0=v0, method="radau", rtol=1e-9, atol=1e-10, t_eval=times)
    return rod.pose(motion.q, [rod.length])[:, 0, :3, 3] / rod.length


@pytest.mark.parametrize("observe", [equilibrium, vibration])
def test_errors_fall_by_a_factor_with_every_mode(observe):
    exact = observe(cantilever(14))
    numbers = np.arange(1, 9)
    errors = [np.abs(observe(cantilever(n)) - exact).max() for n in numbers]
    factor = np.exp(np.polyfit(numbers, np.log(errors), 1)[0])
    assert factor < 0.2
    assert np.corrcoef(numbers, np.log(errors))[0, 1] < -0.97, "exponential"


# Dimensional analysis: other units of length, mass and time. Powers of two change exponents only.


class Units:
    """Scales all properties of a rod, and its states, by powers of its length, mass and time."""

    def __init__(self, length=0, mass=0, time=0):
        self.length, self.mass, self.time = 2.0**length, 2.0**mass, 2.0**time
        self.acceleration = self.length / self.time**2
        self.force = self.mass * self.acceleration
        self.energy = self.force * self.length
        self.pressure = self.force / self.length**2

    def arguments(self, arguments, size):
        """Dimensional arguments multiplied by their size, all others unchanged."""
        return arguments | {
            name: (size[name] * np.asarray(value)).tolist()
            for name, value in arguments.items()
            if name in size and value is not None
        }

    def segment(self, segment):
        size = {
            "length": self.length,
            "radius": self.length,
            "young_modulus": self.pressure,
            "shear_modulus": self.pressure,
            "density": self.mass / self.length**3,
            "retardation_time": self.time,
            "reference_strain": np.array([1 / self.length] * 3 + [1.0] * 3),
        }
        arguments = self.arguments(segment, size)
        if isinstance(segment.get("radius"), tuple):
            arguments["radius"] = tuple(arguments["radius"])
        if "section" in segment:
            shape, sizes = segment["section"]
            scaled = {name: (self.length * np.asarray(value)).tolist() for name, value in sizes.items()}
            arguments["section"] = getattr(lissom.Section, shape)(**scaled)
        return lissom.Segment(**arguments)

    def load(self, load):
        """Distributed loads are given per length."""
        per = self.length if "along" in load else 1.0
        size = {
            "at": self.length,
            "along": self.length,
            "force": self.force / per,
            "moment": self.energy / per,
        }
        return lissom.Load(**self.arguments(load, size))

    def body(self, body):
        size = {
            "mass": self.mass,
            "at": self.length,
            "centre": self.length,
            "inertia": self.mass * self.length**2,
        }
        return lissom.Body(**self.arguments(body, size))

    def rod(self, case):
        size = {
            "base_position": self.length,
            "gravity": self.acceleration,
            "tip_force": self.force,
            "tip_moment": self.energy,
            "tip_mass": self.mass,
        }
        arguments = self.arguments(case.arguments, size)
        for name, scaled in (("segments", self.segment), ("loads", self.load), ("bodies", self.body)):
            arguments[name] = [scaled(part) for part in arguments[name]]
        return lissom.Rod(**arguments)

    def coordinates(self, case):
        """Torsion and bending are angles per length, stretch and shear are dimensionless."""
        is_angle = [
            strain < 3
            for segment in case.arguments["segments"]
            for strain, name in enumerate(STRAINS)
            for _ in range(segment["modes"].get(name, 0))
        ]
        return np.where(is_angle, 1 / self.length, 1.0)


exponents = st.integers(-12, 12)


def same(found, right, size):
    """Bitwise equal, except for underflow."""
    found = found / size
    assert_array_equal(
        np.where(np.abs(found) < 1e-200, 0.0, found), np.where(np.abs(right) < 1e-200, 0.0, right)
    )


@settings(max_examples=40)
@given(case=random_rods(), seed=seeds, length=exponents, mass=exponents, time=exponents)
def test_the_equations_scale_to_the_bit(case, seed, length, mass, time):
    units = Units(length, mass, time)
    rod, scaled, u = case.lissom, units.rod(case), units.coordinates(case)
    q, v, a = random_states(case, seed)
    state = u * q, u * v / units.time, u * a / units.time**2
    same(scaled.inverse_dynamics(*state), rod.inverse_dynamics(q, v, a), units.energy / u)
    size = units.energy / np.outer(u, u)
    same(scaled.mass_matrix(state[0]), rod.mass_matrix(q), size * units.time**2)
    for power, (found, right) in enumerate(zip(scaled.tangent(*state), rod.tangent(q, v, a), strict=True)):
        same(found, right, size * units.time**power)
    energy, scaled_energy = rod.energy(q, v), scaled.energy(*state[:2])
    for part in ("kinetic", "elastic", "gravitational", "loads"):
        same(getattr(scaled_energy, part), getattr(energy, part), units.energy)
    X = np.linspace(0.0, rod.length, 4)
    poses, scaled_poses = rod.pose(q, X), scaled.pose(state[0], units.length * X)
    same(scaled_poses[:, :3, 3], poses[:, :3, 3], units.length)
    same(scaled_poses[:, :3, :3], poses[:, :3, :3], 1.0)


@settings(max_examples=10)
@given(length=exponents, mass=exponents, time=exponents)
def test_equilibria_and_natural_frequencies_scale(length, mass, time):
    """Square roots of odd powers of two round, and pivots differ: not bitwise."""
    case, units = rich_rod(), Units(length, mass, time)
    rod, scaled, u = case.lissom, units.rod(case), units.coordinates(case)
    rest, scaled_rest = (lissom.statics(each, space_error=False) for each in (rod, scaled))
    assert rest.success
    assert scaled_rest.success
    assert scaled_rest.stability == rest.stability
    assert_allclose(scaled_rest.q, u * rest.q, rtol=1e-9, atol=1e-12 * np.abs(rest.q).max())
    found, scaled_found = lissom.modes(rod, rest.q), lissom.modes(scaled, u * rest.q)
    assert_allclose(scaled_found.frequency * units.time, found.frequency, rtol=1e-10)
    assert_allclose(scaled_found.damping_ratio, found.damping_ratio, atol=1e-11)


def scaled_motions(units, method, rtol):
    """Coordinates after sixteen steps, in the same units."""
    case = rich_rod()
    u, tolerance, motions = units.coordinates(case), np.full(case.lissom.n, 1e-9), []
    for rod, time, atol in (
        (case.lissom, 1.0, tolerance),
        (units.rod(case), units.time, tolerance * u / units.time**2),
    ):
        motions.append(lissom.simulate(rod, time / 32, method=method, dt=time / 512, rtol=rtol, atol=atol))
        assert motions[-1].success
    assert_array_equal(motions[1].t, motions[0].t * units.time)
    return motions[1].q / u, motions[0].q


@settings(max_examples=5)
@given(mass=exponents, time=exponents)
@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha"])
def test_motions_scale_with_mass_and_time_to_the_bit(method, mass, time):
    assert_array_equal(*scaled_motions(Units(0, mass, time), method, 1e-6))


@settings(max_examples=5)
@given(length=exponents, mass=exponents, time=exponents)
@pytest.mark.parametrize("method", ["newmark", "hht", "generalised_alpha"])
def test_motions_scale_with_length_to_rounding(method, length, mass, time):
    """Bending and stretch scale differently with the length, so that pivots may differ.

    Steps are solved to rounding accuracy: an additional iteration changes as much as the tolerance allows.
    """
    found, right = scaled_motions(Units(length, mass, time), method, 1e-13)
    assert_allclose(found, right, atol=1e-12 * np.abs(right).max())


@pytest.mark.slow
@settings(max_examples=5)
@given(length=exponents, mass=exponents, time=exponents)
def test_accuracy_on_request_knows_no_units(length, mass, time):
    case, units, tolerance = rich_rod(), Units(length, mass, time), 1e-5
    ends = []
    for rod, second in ((case.lissom, 1.0), (units.rod(case), units.time)):
        motion = lissom.simulate(rod, second / 32, method="auto", rtol=tolerance, dt=second / 128)
        assert motion.success
        ends.append(rod.pose(motion.q, [rod.length])[:, 0, :3, 3] / rod.length)
    assert np.abs(ends[1] - ends[0]).max() < 2 * tolerance


# Reversed motion, and restarts from the middle


def conservative():
    modes = {"torsion": 2, "bend_y": 2, "bend_z": 2, "stretch": 1}
    segment = lissom.Segment(0.3, 0.02, 1e5, 4e4, 1e3, modes)
    return lissom.Rod([segment], tip_force=(0.0, 0.05, 0.0), tip_mass=0.01)


def there_and_back(rod, method):
    """Deviation of a rod from its path after its velocities are reversed at the end, relative to the path."""
    options = {"method": method, "dt": 1e-3, "rtol": 1e-12, "atol": 1e-12}
    there = lissom.simulate(rod, 0.3, **options)
    back = lissom.simulate(rod, 0.3, q0=there.q[-1], v0=-there.v[-1], **options)
    return max(
        np.abs(back.q[::-1] - there.q).max() / np.abs(there.q).max(),
        np.abs(back.v[::-1] + there.v).max() / np.abs(there.v).max(),
    )


@pytest.mark.parametrize("method", FIXED_STEP[:4])
def test_undamped_motions_can_be_reversed(method):
    assert there_and_back(conservative(), method) < 1e-12


def test_damping_cannot_be_reversed():
    assert there_and_back(finger(), "average_acceleration") > 1e-2
    assert 1e-7 < there_and_back(conservative(), "generalised_alpha") < 1e-3, "numerical damping"


def from_the_middle(rod, method, **options):
    """Difference of the second half and its rerun from the middle, relative to the largest value."""
    whole = lissom.simulate(rod, 0.25, method=method, dt=2.0**-10, **options)
    half = len(whole.t) // 2
    rerun = lissom.simulate(
        rod, 0.125, q0=whole.q[half], v0=whole.v[half], method=method, dt=2.0**-10, **options
    )
    return np.abs(rerun.q - whole.q[half:]).max() / np.abs(whole.q).max()


@pytest.mark.parametrize("method", FIXED_STEP[:4])
def test_newmark_is_restarted_to_rounding(method):
    """The initial accelerations are solved for again."""
    assert from_the_middle(finger(), method, rtol=1e-12, atol=1e-12) < 1e-13


@pytest.mark.parametrize("method", ["hht", "generalised_alpha"])
def test_the_alpha_methods_are_restarted_to_their_error(method):
    """They carry averaged accelerations along; a restart begins with the true ones."""
    assert 1e-9 < from_the_middle(finger(), method, rtol=1e-12, atol=1e-12) < 1e-5


@pytest.mark.parametrize("method", ADAPTIVE)
def test_adaptive_methods_are_restarted_to_the_tolerance(method):
    """Step sizes are chosen anew."""
    assert from_the_middle(finger(), method, rtol=1e-7, atol=1e-8) < 1e-6


@pytest.mark.parametrize("method", ["rk45", "dop853"])
def test_explicit_methods_with_given_steps_are_restarted_to_the_bit(method):
    """Such a step depends on the state only."""
    rod, h = finger(), 2.0**-10
    steps = {"first_step": h, "max_step": h, "rtol": 0.1, "atol": 1e9}
    whole = lissom.solve_ivp(rod, (0.0, 0.25), np.zeros(2 * rod.n), method, **steps)
    assert len(whole.t) == 257
    rerun = lissom.solve_ivp(rod, (0.125, 0.25), whole.y[:, 128], method, **steps)
    assert_array_equal(rerun.t, whole.t[128:])
    assert_array_equal(rerun.y, whole.y[:, 128:])


def test_newmark_with_given_accelerations_is_restarted_to_the_bit():
    """With given accelerations, and no other memory between steps: no extrapolation, no Jacobian."""
    rod = finger()

    def residual(t, q, v, a):
        return rod.inverse_dynamics(q, v, a)

    def newmark(t0, q0, v0, **options):
        jac = {"jac": lambda t, q, v, a: rod.tangent(q, v, a), "reuse_jacobian": False}
        return lissom.newmark(residual, (t0, 0.25), q0, v0, dt=2.0**-10, predictor="last", **jac, **options)

    whole = newmark(0.0, np.zeros(rod.n), np.zeros(rod.n))
    rerun = newmark(0.125, whole.q[128], whole.v[128], a0=whole.a[128])
    for name in ("t", "q", "v", "a"):
        assert_array_equal(getattr(rerun, name), getattr(whole, name)[128:])


@pytest.mark.parametrize(
    ("method", "adaptive"),
    [
        *((method, False) for method in METHODS),
        *((method, True) for method in ("newmark", "hht", "generalised_alpha")),
    ],
)
def test_two_runs_the_same_bits(method, adaptive):
    options = {"method": method, "dt": 1e-4} | ({"adaptive": True} if adaptive else {})
    runs = [lissom.simulate(rich_rod().lissom, 0.02, **options) for _ in range(2)]
    for name in ("t", "q", "v", "a"):
        assert_array_equal(getattr(runs[1], name), getattr(runs[0], name))
    assert runs[1].balance.drift == runs[0].balance.drift
