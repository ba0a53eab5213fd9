"""`lissom.Rod` compared with the NumPy reference, and general laws of rods."""

import copy
import inspect
import pickle
import signal
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from reference.rod import STRAINS
from rod_cases import (
    Case,
    random_rods,
    random_states,
    rich_bodies,
    rich_loads,
    rich_rod,
    rich_segments,
    seeds,
)

# Quadrature error of segments that turn by up to about half a turn, relative to the largest force.
QUADRATURE = 1e-8

# Tangents are those of the exact rod; differences include the derivative of the quadrature error.
TANGENT = 1e-7


def assert_forces_agree(found, case, q, qd, qdd):
    """Up to the quadrature error for the forces of motion, and to rounding for elastic forces."""
    wanted = case.reference.inverse_dynamics(q, qd, qdd)
    elastic = case.reference.elastic_forces(q, qd)
    atol = QUADRATURE * np.abs(wanted - elastic).max() + 1e-12 * np.abs(elastic).max()
    assert_allclose(found, wanted, rtol=0, atol=atol)


@pytest.mark.parametrize("name", ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"])
@pytest.mark.parametrize("length", [1.0, 0.3, 2.5])
def test_inverse_dynamics_of_a_single_strain(name, length):
    segment = {
        "length": length,
        "radius": 0.02,
        "young_modulus": 1e6,
        "shear_modulus": 4e5,
        "density": 1000.0,
        "modes": {name: 2},
        "retardation_time": 0.02,
    }
    case = Case([segment], tip_force=(0.3, 0.5, -0.2), tip_moment=(0.01, 0.02, 0.03), tip_mass=0.1)
    q, qd, qdd = random_states(case, seed=1)
    assert_forces_agree(case.lissom.inverse_dynamics(q, qd, qdd), case, q, qd, qdd)


def test_inverse_dynamics_of_everything_at_once():
    case = rich_rod()
    q, qd, qdd = random_states(case, seed=2)
    assert case.lissom.n == case.reference.n == 19
    assert_forces_agree(case.lissom.inverse_dynamics(q, qd, qdd), case, q, qd, qdd)


def test_default_arguments_of_segment_and_rod_are_the_documented_ones():
    segment = {
        "length": 0.6,
        "radius": 0.02,
        "young_modulus": 1e6,
        "shear_modulus": 4e5,
        "density": 1000.0,
        "modes": {"bend_y": 2, "shear_z": 1},
    }
    spelled = segment | {
        "retardation_time": 0.0,
        "reference_strain": (0, 0, 0, 1, 0, 0),
        "shear_correction": 1.0,
        "basis": "legendre",
    }
    rod = lissom.Rod([lissom.Segment(**segment)])
    explicit = lissom.Rod(
        [lissom.Segment(**spelled)],
        base_position=(0, 0, 0),
        base_orientation=(1, 0, 0, 0),
        gravity=(0, 0, -9.81),
        tip_force=(0, 0, 0),
        tip_moment=(0, 0, 0),
        tip_mass=0.0,
    )
    q, qd, qdd = random_states(Case([segment]), seed=3)
    tau = rod.inverse_dynamics(q, qd, qdd)
    assert np.array_equal(tau, explicit.inverse_dynamics(q, qd, qdd))
    assert_forces_agree(tau, Case([segment]), q, qd, qdd)


@given(random_rods(), seeds)
def test_inverse_dynamics_of_random_rods(case, seed):
    q, qd, qdd = random_states(case, seed)
    assert_forces_agree(case.lissom.inverse_dynamics(q, qd, qdd), case, q, qd, qdd)


@given(random_rods(), seeds, st.lists(st.floats(0, 1), min_size=1, max_size=4))
def test_poses_of_random_rods(case, seed, places):
    q, _, _ = random_states(case, seed)
    X = case.length * np.array(places)
    assert_allclose(case.lissom.pose(q, X), case.reference.poses(q, X), atol=QUADRATURE * max(1, case.length))


@given(random_rods(), seeds)
def test_energies_of_random_rods(case, seed):
    q, qd, _ = random_states(case, seed)
    found, wanted = case.lissom.energy(q, qd), case.reference.energy(q, qd)
    scale = max(abs(wanted.kinetic), abs(wanted.gravitational), abs(wanted.loads))
    assert_allclose(found.kinetic, wanted.kinetic, atol=QUADRATURE * scale)
    assert_allclose(found.gravitational, wanted.gravitational, atol=QUADRATURE * scale)
    assert_allclose(found.loads, wanted.loads, atol=QUADRATURE * scale)
    assert_allclose(found.elastic, wanted.elastic, rtol=1e-11)
    assert_allclose(
        found.total, found.kinetic + found.elastic + found.gravitational + found.loads, rtol=1e-14
    )


@given(random_rods(), seeds)
def test_mass_matrix_of_random_rods(case, seed):
    q, qd, _ = random_states(case, seed)
    mass = case.lissom.mass_matrix(q)
    # In units of the coordinates, so that entries of different strains are comparable.
    unit = np.outer(case.coordinate_scale, case.coordinate_scale)
    error = np.abs(mass - case.reference.mass_matrix(q)) * unit
    assert error.max() <= QUADRATURE * np.abs(mass * unit).max()
    assert np.array_equal(mass, mass.T)
    assert np.linalg.eigvalsh(mass / np.sqrt(np.outer(mass.diagonal(), mass.diagonal()))).min() > 0
    assert_allclose(qd @ mass @ qd / 2, case.lissom.energy(q, qd).kinetic, rtol=1e-9)


@given(random_rods(), seeds)
def test_mass_matrix_column_by_column(case, seed):
    """As in the lab: differences of the inverse dynamics for unit accelerations."""
    q, rest = random_states(case, seed)[0], np.zeros(case.lissom.n)
    bias = case.lissom.inverse_dynamics(q, rest, rest)
    columns = [case.lissom.inverse_dynamics(q, rest, unit) - bias for unit in np.eye(case.lissom.n)]
    mass = case.lissom.mass_matrix(q)
    scale = np.sqrt(np.outer(mass.diagonal(), mass.diagonal())) + np.abs(bias).max()
    assert np.all(np.abs(np.column_stack(columns) - mass) <= 1e-13 * scale)


def moment_of_loads(rod):
    """Moments about the base; generalised forces follow by differentiation."""
    mass = sum(s.inertia(X)[3, 3] * s.length for s in rod.segments for X in (0, s.length))
    bodies = rod.tip_mass + sum(body.mass for body in rod.bodies)
    weight = (mass + bodies) * np.linalg.norm(rod.gravity)
    moment = (weight + np.linalg.norm(rod.tip_force)) * rod.length + np.linalg.norm(rod.tip_moment)
    for load in rod.loads:
        amount = 1.0 if load.along is None else np.ptp(load.along)
        moment += amount * (np.linalg.norm(load.force) * rod.length + np.linalg.norm(load.moment))
    return moment


@given(random_rods(), seeds)
def test_forward_dynamics_needs_no_generalised_force(case, seed):
    q, qd, _ = random_states(case, seed)
    qdd = case.lissom.forward_dynamics(q, qd)
    bias = case.lissom.inverse_dynamics(q, qd, 0 * q)
    tau = case.lissom.inverse_dynamics(q, qd, qdd)
    condition = np.linalg.cond(case.lissom.mass_matrix(q))
    atol = 1e-14 * condition * np.abs(bias).max() + 1e-12 * np.abs(bias).max()
    assert_allclose(tau, 0, atol=atol + 1e-14 * moment_of_loads(case.lissom))


@given(random_rods(), seeds)
def test_tangents_of_random_rods(case, seed):
    state = random_states(case, seed)
    for which, tangent in enumerate(case.lissom.tangent(*state)):
        wanted = central_difference(case.lissom.inverse_dynamics, state, which, case.coordinate_scale)
        rows = np.abs(wanted * case.coordinate_scale).max(axis=1, keepdims=True)
        # Loads may cancel: their rounding is divided by the steps of the differences, 2e-3.
        rounding = 1e-12 * np.abs(case.lissom.inverse_dynamics(*state)).max()
        rounding += 1e-13 * moment_of_loads(case.lissom)
        assert np.all(np.abs(tangent - wanted) * case.coordinate_scale <= TANGENT * rows + rounding)


def central_difference(function, state, which, scale, step=2e-3):
    """Derivative of function(q, qd, qdd) with respect to one argument, by fourth-order differences."""
    columns = []
    for direction in np.diag(scale):

        def along(h, direction=direction):
            moved = [part + h * direction if i == which else part for i, part in enumerate(state)]
            return function(*moved)

        near, far = along(step) - along(-step), along(2 * step) - along(-2 * step)
        columns.append((8 * near - far) / (12 * step) / direction.max())
    return np.column_stack(columns)


def test_tangents_of_a_rod_with_everything():
    case = rich_rod()
    state = random_states(case, seed=5)
    tangents = case.lissom.tangent(*state)
    for which, tangent in enumerate(tangents):
        wanted = central_difference(case.lissom.inverse_dynamics, state, which, case.coordinate_scale)
        assert_allclose(tangent, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())
    assert_allclose(tangents[2], case.lissom.mass_matrix(state[0]), rtol=0, atol=1e-14)


def test_tangents_against_the_reference():
    segment = rich_segments()[0] | {"modes": dict.fromkeys(STRAINS, 1)}
    case = Case([segment], tip_force=(0.05, -0.1, 0.2), tip_moment=(0.003, 0.002, -0.004), tip_mass=0.05)
    state = random_states(case, seed=6)
    for which, tangent in enumerate(case.lissom.tangent(*state)):
        wanted = central_difference(case.reference.inverse_dynamics, state, which, case.coordinate_scale)
        assert_allclose(tangent, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


@pytest.mark.parametrize("load", rich_loads(), ids=repr)
def test_power_of_each_load(load):
    """The generalised forces of a load give its power, or the rate of its potential."""
    load = load | {"at": load["at"] * 0.7} if "at" in load else load
    segments, bodies = rich_segments(), rich_bodies()
    loaded, free = Case(segments, loads=[load]), Case(segments)
    with_bodies = Case(segments, loads=[load], bodies=bodies)
    q, qd, _ = random_states(loaded, seed=8)
    rest = np.zeros_like(q)
    tau = [case.reference.inverse_dynamics(q, rest, rest) for case in (free, loaded)]
    h = 1e-4
    potential = np.subtract(*(loaded.lissom.energy(q + step * qd, rest).loads for step in (h, -h))) / (2 * h)
    power = qd @ (tau[0] - tau[1])
    for rod in (loaded.lissom, with_bodies.lissom):
        assert_allclose(rod.supplied_power(q, qd) - potential, power, rtol=1e-6)
        assert_allclose(rod.supplied_power(q, -2 * qd), -2 * rod.supplied_power(q, qd), rtol=1e-12)


def test_default_arguments_of_load_and_body_are_the_documented_ones():
    load = lissom.Load(force=(1, 2, 3))
    assert load == lissom.Load(force=(1, 2, 3), moment=(0, 0, 0), at=None, along=None, frame="world")
    body = lissom.Body(0.3)
    assert body == lissom.Body(0.3, at=None, centre=(0, 0, 0), inertia=(0, 0, 0))
    segments = [lissom.Segment(**segment) for segment in rich_segments()]
    q, qd, qdd = random_states(Case(rich_segments()), seed=9)
    length = sum(segment.length for segment in segments)
    at_tip = lissom.Rod(segments, loads=[load], bodies=[body])
    spelled = [
        lissom.Rod(segments, tip_force=(1, 2, 3), tip_mass=0.3),
        lissom.Rod(
            segments, loads=[lissom.Load(force=(1, 2, 3), at=length)], bodies=[lissom.Body(0.3, at=length)]
        ),
    ]
    for rod in spelled:
        assert_allclose(rod.inverse_dynamics(q, qd, qdd), at_tip.inverse_dynamics(q, qd, qdd), rtol=1e-13)


def test_loads_and_bodies_are_copied_and_pickled():
    rod = rich_rod().lissom
    for load in rod.loads:
        assert copy.copy(load) == pickle.loads(pickle.dumps(load)) == load
        assert eval(repr(load), {"Load": lissom.Load}) == load
    for body in rod.bodies:
        assert copy.copy(body) == pickle.loads(pickle.dumps(body)) == body
        assert eval(repr(body), {"Body": lissom.Body}) == body
    twin = pickle.loads(pickle.dumps(rod))
    assert twin.loads == rod.loads
    assert twin.bodies == rod.bodies


@given(random_rods(), seeds)
def test_power_goes_into_energy_and_damping(case, seed):
    # A dead moment has no potential, so that its power is not in the energy.
    segments = [arguments_of(segment) for segment in case.lissom.segments]
    rod = Case(segments, gravity=(1, 2, -9), tip_force=(0.1, 0.2, 0.3), tip_mass=0.1)
    q, qd, qdd = random_states(rod, seed)

    def energy(h):
        return rod.lissom.energy(q + h * qd + h**2 / 2 * qdd, qd + h * qdd)

    h = 1e-3
    near, far = (np.subtract(parts(energy(step)), parts(energy(-step))) for step in (h, 2 * h))
    rate = (8 * near - far) / (12 * h)
    undamped = Case([segment | {"retardation_time": 0.0} for segment in segments])
    dissipated = qd @ (rod.reference.elastic_forces(q, qd) - undamped.reference.elastic_forces(q, qd))
    assert dissipated >= 0
    power = qd @ rod.lissom.inverse_dynamics(q, qd, qdd)
    assert_allclose(power - dissipated, rate.sum(), rtol=0, atol=1e-7 * (np.abs(rate).sum() + dissipated))


def parts(energy):
    return energy.kinetic, energy.elastic, energy.gravitational, energy.loads


def arguments_of(segment):
    # Poisson's ratio replaces the shear modulus, the radius a section. The reference has neither magnets
    # nor limits.
    left_out = {"nodes", "basis", "radius", "section", "poisson_ratio", "magnetisation"}
    left_out |= {"min_bend_radius", "max_strain", "max_stress"}
    names = inspect.signature(lissom.Segment).parameters.keys() - left_out
    section = {"section": (segment.section.shape, segment.section.parameters)}
    return {name: getattr(segment, name) for name in names} | section


def turned_load(load, turn):
    """Follower loads rotate with the base, dead ones do not."""
    force, moment = load.force, load.moment
    if load.frame == "world":
        force, moment = turn.apply(force), turn.apply(moment)
    return lissom.Load(force=force, moment=moment, at=load.at, along=load.along, frame=load.frame)


@given(random_rods(), seeds)
def test_rotating_base_gravity_and_loads_together_rotates_the_motion(case, seed):
    turn = Rotation.random(None, np.random.default_rng(seed))
    q, qd, qdd = random_states(case, seed)
    rod = case.lissom
    w, x, y, z = rod.base_orientation
    x, y, z, w = (turn * Rotation.from_quat([x, y, z, w])).as_quat()
    turned = lissom.Rod(
        rod.segments,
        base_position=turn.apply(rod.base_position),
        base_orientation=(w, x, y, z),
        gravity=turn.apply(rod.gravity),
        tip_force=turn.apply(rod.tip_force),
        tip_moment=turn.apply(rod.tip_moment),
        tip_mass=rod.tip_mass,
        loads=[turned_load(load, turn) for load in rod.loads],
        bodies=rod.bodies,
    )
    tau = rod.inverse_dynamics(q, qd, qdd)
    atol = 1e-12 * np.abs(tau).max() + 1e-14 * moment_of_loads(rod)
    assert_allclose(turned.inverse_dynamics(q, qd, qdd), tau, rtol=0, atol=atol)
    pose, turned_pose = rod.pose(q, case.length), turned.pose(q, case.length)
    assert_allclose(turned_pose[:3, :3], turn.as_matrix() @ pose[:3, :3], atol=1e-13)
    assert_allclose(turned_pose[:3, 3], turn.apply(pose[:3, 3]), atol=1e-12)
    energies, turned_energies = parts(rod.energy(q, qd)), parts(turned.energy(q, qd))
    atol = 1e-12 * np.abs(energies).max() + 1e-14 * moment_of_loads(rod)
    assert_allclose(turned_energies, energies, rtol=0, atol=atol)


@given(st.lists(st.floats(-40, 40), min_size=9, max_size=9), st.floats(0, 1))
def test_rotations_stay_proper_for_several_full_turns(q, X):
    segment = {
        "length": 1.0,
        "radius": 0.01,
        "young_modulus": 1e6,
        "shear_modulus": 4e5,
        "density": 1000.0,
        "modes": {"torsion": 3, "bend_y": 3, "bend_z": 3},
    }
    pose = lissom.Rod([lissom.Segment(**segment)]).pose(q, X)
    assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-13)
    assert_allclose(np.linalg.det(pose[:3, :3]), 1, rtol=1e-13)
    assert np.array_equal(pose[3], [0, 0, 0, 1])


def test_constant_curvature_turns_exactly_however_often():
    segment = {
        "length": 2.0,
        "radius": 0.01,
        "young_modulus": 1e6,
        "shear_modulus": 4e5,
        "density": 1000.0,
        "modes": {"torsion": 1, "bend_y": 1, "bend_z": 1},
    }
    rod, kappa = lissom.Rod([lissom.Segment(**segment)]), np.array([9.0, -14.0, 11.0])
    for X in (0.0, 0.3, 1.0, 2.0):
        wanted = Rotation.from_rotvec(kappa * X).as_matrix()
        assert_allclose(rod.pose(kappa, X)[:3, :3], wanted, atol=1e-12)


def test_pose_takes_a_number_or_an_array():
    case = rich_rod()
    q, _, _ = random_states(case, seed=7)
    X = np.linspace(0, case.length, 5)
    poses = case.lissom.pose(q, X)
    assert poses.shape == (5, 4, 4)
    assert case.lissom.pose(q, []).shape == (0, 4, 4)
    for pose, at in zip(poses, X, strict=True):
        assert case.lissom.pose(q, at).shape == (4, 4)
        assert np.array_equal(case.lissom.pose(q, float(at)), pose)
    assert_allclose(poses[0, :3, 3], (0.3, -2.0, 1.0), atol=1e-15)


def test_a_rod_of_several_equal_segments_is_one_rod():
    """Constant strains: two halves equal the whole, for any place of the joint."""
    whole = rich_segments()[1] | {"modes": {"torsion": 1, "bend_y": 1, "bend_z": 1}}
    pieces = [whole | {"length": 0.3}, whole | {"length": 0.4}]
    one, two = Case([whole]).lissom, Case(pieces).lissom
    q, qd = np.array([0.8, -0.5, 0.3]), np.array([1.0, 2.0, -1.0])
    assert_allclose(one.pose(q, [0.2, 0.5, 0.7]), two.pose(np.tile(q, 2), [0.2, 0.5, 0.7]), atol=1e-10)
    assert_allclose(parts(one.energy(q, qd)), parts(two.energy(np.tile(q, 2), np.tile(qd, 2))), rtol=1e-10)


def test_the_same_call_gives_the_same_bits():
    case = rich_rod()
    state, other = random_states(case, seed=8), random_states(case, seed=9)
    tau, tangent = case.lissom.inverse_dynamics(*state), case.lissom.tangent(*state)
    case.lissom.inverse_dynamics(*other)
    assert np.array_equal(case.lissom.inverse_dynamics(*state), tau)
    case.lissom.mass_matrix(other[0])
    assert all(map(np.array_equal, case.lissom.tangent(*state), tangent))
    assert np.array_equal(rich_rod().lissom.inverse_dynamics(*state), tau)


def test_arguments_are_not_changed_and_results_are_new_arrays():
    rod = rich_rod().lissom
    q = np.zeros(rod.n)
    first, second = (rod.inverse_dynamics(q, q, q) for _ in range(2))
    first[:] = 1e9
    assert not np.array_equal(first, second)
    assert np.array_equal(second, rod.inverse_dynamics(q, q, q))
    assert not q.any()


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda rod: pickle.loads(pickle.dumps(rod))])
def test_rods_can_be_copied_and_pickled(duplicate):
    case = rich_rod()
    state = random_states(case, seed=10)
    assert np.array_equal(
        duplicate(case.lissom).inverse_dynamics(*state), case.lissom.inverse_dynamics(*state)
    )


def test_poses_of_many_states():
    rod = rich_rod().lissom
    states = np.random.default_rng(1).normal(size=(5, rod.n))
    places = [0.0, 0.3, rod.length]
    each = np.array([rod.pose(q, places) for q in states])
    assert np.array_equal(rod.pose(states, places), each)
    assert np.array_equal(rod.pose(states.tolist(), 0.3), each[:, 1])
    assert rod.pose(states[:0], places).shape == (0, 3, 4, 4)
    with pytest.raises(ValueError, match=rf"q: expected shape \(k, {rod.n}\), got \(5, {rod.n - 1}\)"):
        rod.pose(states[:, 1:], places)
    states[3, 2] = np.nan
    with pytest.raises(ValueError, match=r"q\[3, 2\]: got NaN, expected a finite number"):
        rod.pose(states, places)


@pytest.mark.parametrize("size", [(4000, 1), (1, 4000)], ids=["states", "places"])
def test_ctrl_c_stops_poses(size):
    """Long before the two seconds of the complete computation; the handler may use the same rod."""
    rod = rich_rod().lissom
    random = np.random.default_rng(0)
    straight = np.zeros(rod.n)

    def interrupt(*_):
        rod.pose(straight, 0.0)
        raise KeyboardInterrupt

    def arguments(states, places):
        # Different states, because the rod caches the last one.
        return random.standard_normal((states, rod.n)), np.full(places, rod.length)

    def seconds(q, x):
        start = time.perf_counter()
        try:
            rod.pose(q, x)
        except KeyboardInterrupt:
            return time.perf_counter() - start, True
        return time.perf_counter() - start, False

    alone, _ = seconds(*arguments(*size))
    many = arguments(*(1 if number == 1 else int(2 * number / alone) for number in size))
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.05)
    try:
        taken, stopped = seconds(*many)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert stopped
    assert taken < 1.0


def test_quadrature_nodes_may_be_chosen():
    def rod(nodes):
        return lissom.Rod([lissom.Segment(**(rich_segments()[0] | {"nodes": nodes}))])

    assert rod(32).nodes == (32,)
    assert rod(9).nodes == (12,)
    states = random_states(rich_rod(), seed=3)
    exact, default, coarse = (
        rod(nodes).inverse_dynamics(*(state[: rod(nodes).n] for state in states)) for nodes in (64, None, 4)
    )
    assert_allclose(default, exact, rtol=0, atol=1e-7 * np.abs(exact).max())
    assert np.abs(coarse - exact).max() > 1e-7 * np.abs(exact).max()


def test_a_rod_explains_what_is_skipped():
    text = rich_rod().lissom.explain()
    assert "spatial kernel" in text
    assert text.index("dead loads") < text.index("follower loads") < text.index("skipped")


def test_a_rod_tells_how_many_multiplications_it_takes():
    def multiplications(modes, segments=1, nodes=12):
        finger = lissom.Segment(0.2, 0.01, 3e5, 1e5, 1070.0, modes, nodes=nodes)
        return lissom.Rod([finger] * segments).multiplications

    planar = multiplications({"bend_y": 3})
    assert planar["factorisation"] == 8  # (n^3 - n) / 3
    assert planar["solution"] == 9
    assert rich_rod().lissom.multiplications.keys() == planar.keys()
    # A curve out of the plane costs at least in proportion to the additional components.
    assert multiplications({"bend_y": 3, "torsion": 1})["residual"] > 2 * planar["residual"]
    # Linear in segments, at most quadratic in coordinates (design goals).
    one, two, four = (multiplications({"bend_y": 3}, segments) for segments in (1, 2, 4))
    assert four["residual"] == 4 * one["residual"] == 2 * two["residual"]
    assert four["tangent"] < 16 * one["tangent"]
    assert multiplications({"bend_y": 3}, nodes=24)["residual"] < 4 * planar["residual"]


def test_a_rod_tells_what_it_was_made_of():
    rod = rich_rod().lissom
    wanted = rich_segments()[0]
    radius = wanted.pop("radius")
    segment = rod.segments[0]
    assert arguments_of(segment) == wanted | {"section": ("circle", {"radius": radius})}
    assert segment.radius == radius
    assert segment == lissom.Segment(**rich_segments()[0])
    assert segment != rod.segments[1]
    assert segment.nodes is None
    assert rod.length == pytest.approx(1.35)
    assert rod.kernel == "spatial"
    assert lissom.Rod([lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800.0, {"bend_y": 3})]).kernel == "planar"
    assert rod.base_orientation == (0.8, 0.2, -0.4, 0.4)
    assert rod.tip_mass == 0.05
    assert eval(repr(segment), {"Segment": lissom.Segment}) == segment
