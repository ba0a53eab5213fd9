"""The comparison of `make peers`: its mathematics, its random trees, its page."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import lissom

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "benches" / "python"))
sys.path.insert(0, str(ROOT / "benches" / "python" / "peers"))
import candidates  # noqa: E402
import foreign_coordinates  # noqa: E402
import octopus  # noqa: E402
import rigid_trees  # noqa: E402
import rotation_vectors  # noqa: E402
import tendon_arm  # noqa: E402
from peers import cosseratbench_report, environment, robot_peers_report  # noqa: E402

ROOTS = ["weld", "revolute", "spherical", "free"]
seeds = st.integers(0, 10_000)


def rotation_vector(rng):
    """A rotation vector of up to half a turn."""
    vector = rng.normal(size=3)
    return rng.uniform(0.0, np.pi) * vector / np.linalg.norm(vector)


@given(seeds)
def test_rotation_vectors_turn_as_those_of_scipy(seed):
    rng = np.random.default_rng(seed)
    phi, rate = rotation_vector(rng), rng.normal(size=3)
    turn = Rotation.from_rotvec(phi)
    np.testing.assert_allclose(rotation_vectors.rotated(phi, rate), turn.apply(rate), atol=1e-13)
    w, x, y, z = rotation_vectors.quaternion(phi)
    np.testing.assert_allclose(abs(turn.as_quat() @ [x, y, z, w]), 1.0, atol=1e-13)
    # The angular velocity in the rotating axes, by a fourth-order central difference.
    step = 1e-3

    def turned(t):
        return (turn.inv() * Rotation.from_rotvec(phi + t * rate)).as_rotvec()

    difference = (8 * (turned(step) - turned(-step)) - (turned(2 * step) - turned(-2 * step))) / (12 * step)
    np.testing.assert_allclose(rotation_vectors.angular_velocity(phi, rate), difference, atol=1e-9)


@given(seeds)
def test_the_bias_is_the_derivative_of_the_angular_velocity(seed):
    rng = np.random.default_rng(seed)
    phi, rate = rotation_vector(rng), rng.normal(size=3)
    by_phi = rotation_vectors.derivative(lambda x: rotation_vectors.angular_velocity(x, rate), phi)
    found = rotation_vectors.angular_acceleration_at_constant_rate(phi, rate)
    np.testing.assert_allclose(found, by_phi @ rate, atol=1e-12)


def test_tangents_follow_from_those_of_another_code():
    # Two freely rotating bodies, coupled by springs of their angular velocities, independent of lissom.
    rng = np.random.default_rng(1)
    mass = rng.normal(size=(6, 6))
    mass = mass @ mass.T + 6.0 * np.eye(6)
    damping = rng.normal(size=(6, 6))
    ball = foreign_coordinates.JointCoordinates(
        3,
        rotation_vectors.quaternion,
        rotation_vectors.angular_velocity,
        rotation_vectors.angular_acceleration_at_constant_rate,
    )
    robot = foreign_coordinates.Coordinates([ball, ball])

    def foreign(w, a):
        return mass @ a + damping @ w * (1.0 + w @ w)

    def tau(q, v, a):
        w = robot.rate(q, v)
        return robot.matrix(q).T @ foreign(w, robot.rate(q, a) + robot.bias(q, v))

    q = np.concatenate([rotation_vector(rng), rotation_vector(rng)])
    v, a = rng.normal(size=6), rng.normal(size=6)
    w = robot.rate(q, v)
    by_rate = damping * (1.0 + w @ w) + np.outer(damping @ w, 2.0 * w)
    there = foreign(w, robot.rate(q, a) + robot.bias(q, v))
    tangents = robot.tangents(q, v, a, there, (np.zeros((6, 6)), by_rate, mass))
    state, step = [q, v, a], 1e-5
    for place, found in enumerate(tangents):
        columns = []
        for unit in np.eye(6):
            ahead, behind = (
                [x + sign * step * unit * (i == place) for i, x in enumerate(state)] for sign in (1, -1)
            )
            columns.append((tau(*ahead) - tau(*behind)) / (2.0 * step))
        np.testing.assert_allclose(found, np.array(columns).T, rtol=1e-6, atol=1e-6)


@given(seeds, st.integers(4, 20), st.sampled_from(ROOTS), st.booleans())
def test_random_trees_are_bodies_in_order_of_depth(seed, links, root, serial):
    tree = rigid_trees.random_tree(seed, links, root, 6.0, serial)
    assert len(tree.members) == links
    assert tree.members[0].kind == root
    ancestors: list[int | None] = [None]
    for index, each in enumerate(tree.members):
        # A subtree is contiguous: the parent is the previous link or one of its ancestors.
        assert each.parent in ancestors
        ancestors = [*ancestors[: ancestors.index(each.parent) + 1], index]
        a, b, c = np.sort(each.principal)
        assert 0.0 < a <= b <= c < a + b
        np.testing.assert_allclose(np.linalg.eigvalsh(each.inertia), [a, b, c], rtol=1e-9)
    assert tree.depth == links if serial else tree.depth <= links
    q, v, _ = rigid_trees.state(tree, seed)
    assert q.size == v.size == rigid_trees.robot(tree).n


def test_the_octopus_is_that_of_the_scene():
    scene = lissom.Scene.load(octopus.SCENE)
    settings = scene.simulation
    assert (settings.t_end, settings.output_dt) == (octopus.END, octopus.OUTPUT_STEP)
    assert scene.model.gravity == (0.0, 0.0, 0.0)
    assert not scene.q0.any()
    assert not scene.v0.any()
    described = octopus.described()
    assert len(described.arms) == 4
    for arm in described.arms:
        assert [moment.at for moment in arm.moments] == [0.05, 0.12]
        assert np.linalg.norm(arm.orientation) == pytest.approx(1.0, abs=1e-15)
    own = octopus.robot(4, True)
    q = 0.1 * np.sin(np.arange(own.n))
    np.testing.assert_array_equal(
        own.inverse_dynamics(q, q, q, t=0.3), scene.model.inverse_dynamics(q, q, q, t=0.3)
    )
    # Features that the peers lack: moments about other axes, forces, bodies on the arms.
    for load in scene.model.loads:
        assert load.force == (0.0, 0.0, 0.0)
        assert load.frame == "body"
        assert load.moment.amplitude[::2] == (0.0, 0.0)
        assert load.moment.mean == load.moment.rate == (0.0, 0.0, 0.0)
    assert scene.model.bodies == ()


def test_the_tendon_arm_is_converged_where_others_are_compared_with_it():
    tensions = tendon_arm.tensions()
    assert tensions.shape == (tendon_arm.STEPS, 4)
    assert tensions.min() >= 0.0
    reference = tendon_arm.tips(tendon_arm.REFERENCE_MODES, tendon_arm.REFERENCE_STEP)
    assert np.ptp(reference, axis=0).max() > 0.5 * tendon_arm.LENGTH
    # What is left is the error of its modes, in steps as long as those of the controller, too.
    errors = [np.abs(tendon_arm.tips(tendon_arm.MODES, step) - reference).max() for step in (1e-2, 1e-3)]
    assert 1e-3 * tendon_arm.LENGTH > errors[0] > errors[1] > 0.0


def test_the_fastest_way_counts_only_if_finer_steps_are_as_exact():
    def way(code, size, substeps, error, seconds):
        return candidates.Candidate(code, size, f"{size} links", substeps, error, seconds, lambda: None)

    ways = [
        way("one", 4, 1, 0.5e-2, 1.0),  # by chance: twice as many steps are off
        way("one", 4, 2, 2.0e-2, 2.0),
        way("one", 8, 1, 3.0e-2, 3.0),
        way("one", 8, 2, 0.9e-2, 4.0),
        way("one", 8, 4, 0.5e-2, 8.0),
        way("other", 4, 1, np.inf, 0.1),
        way("other", 4, 2, 0.9e-2, 9.0),
    ]
    assert candidates.within(ways, 1e-2) == [ways[3], ways[6]]
    assert candidates.within(ways, 1e-3) == []


def octopus_run(code, water, discretisation, seconds, error):
    kinds = {"code": code, "water": water, "discretisation": discretisation, "step": "Euler, dt = 1"}
    return {"part": "octopus", **kinds, "seconds": seconds, "error": error}


def arm_run(part, code, discretisation, seconds, error):
    kinds = {"part": part, "code": code, "discretisation": discretisation, "step": 1e-2}
    return {**kinds, "seconds": seconds, "error": error}


def test_the_page_has_a_section_for_every_table():
    deviations = dict.fromkeys(robot_peers_report.WHAT, 1e-15)
    sizes = {"links": 3, "depth": 2, "coordinates": 5, "condition": 1e3}
    largest = {"Pinocchio": deviations, "MuJoCo": {"mass matrix": 2e-15}}
    away = dict.fromkeys(robot_peers_report.WHAT, 1e-12)
    functions = {"lissom, derivatives": 3e-6, "Pinocchio, derivatives": 1e-6}
    rows = [
        {"part": "agreement", "group": "g", "trees": 2, "sizes": sizes, "largest": largest, "agrees": False},
        {"part": "away", "distance": 10.0, "Pinocchio": away, "MuJoCo": away},
        {
            "part": "arms",
            "joints": 7,
            "functions": functions,
            "steps": {"lissom": 1e-6, "MuJoCo, Euler": 2e-6},
            "iterations": 2.0,
            "tangents": 1.0,
            "errors": {"lissom": 1e-5, "MuJoCo": 1e-3, "MuJoCo, fine": 1e-5},
        },
        {
            "part": "octopus reference",
            "water": True,
            "modes": 10,
            "step": 1e-3,
            "twice the step": 1e-5,
            "more modes": 1e-4,
        },
        {
            "part": "tendon arm reference",
            "modes": 6,
            "step": 1e-3,
            "twice the step": 1e-5,
            "more modes": 1e-6,
            "reach": 0.2,
        },
        {
            "part": "tendon arm agreement",
            "nodes": 5,
            "tendons": 1e-9,
            "tip": 1e-6,
            "accelerations": 1e-5,
        },
        arm_run("tendon arm", "lissom", "12 coordinates", 2e-5, 5e-3) | {"tolerance": 1e-2},
        arm_run("tendon arm", "MuJoCo", "11 links", 8e-5, 9e-3) | {"tolerance": 1e-2},
        arm_run("tendon arms", "lissom", "12 coordinates", 1e-5, 5e-3) | {"rows": 64},
        arm_run("tendon arm candidate", "MuJoCo", "11 links", 8e-5, 9e-3),
        arm_run("tendon arm candidate", "MuJoCo", "5 links", 1e-5, None),
        octopus_run("lissom", True, "4 modes", 0.1, 5e-3),
        octopus_run("lissom", False, "4 modes", 0.05, 5e-3),
        octopus_run("MuJoCo", False, "9 links", 0.5, 5e-3),
        octopus_run("MuJoCo", False, "5 links", 0.01, None),
    ]
    sections = robot_peers_report.sections(rows, "on this machine")
    page = (ROOT / "docs" / "peers.md").read_text(encoding="utf-8")
    others = cosseratbench_report.sections([], "on this machine")
    assert set(re.findall(r"<!-- (\w+) -->", page)) == set(sections) | set(others)
    for text in sections.values():
        for found in text.split("\n\n"):
            lines = [line.count("|") for line in found.splitlines() if line.startswith("|")]
            assert len(set(lines)) <= 1
    assert "**no**" in sections["agreement"]
    assert "3, not reached" in sections["functions"]
    assert "0.5, reached" in sections["steps"]
    assert "60 times faster than real time; the goal of 20 is reached" in sections["water"]
    assert "10 times as long as lissom" in sections["without"]
    assert "| 5 links | fails |" in sections["without"]
    assert "| 80 µs | 1.25e+04 | 4 |" in sections["arm_steps"]
    assert "| MuJoCo | 5 links | fails |" in sections["arm_convergence"]
    alone = robot_peers_report.sections([row for row in rows if "tendon" in row["part"]], "on this machine")
    assert alone == {name: text for name, text in sections.items() if name.startswith("arm_")}


def test_tables_of_the_benchmark_say_how_runs_ended():
    def row(solver, variant="default", **more):
        given = {"experiment": "pile", "solver": solver, "variant": variant, "outcome": "completed"}
        return given | {"metrics": {"pile_height": 2.5}, "processor_time": 3.0, "failure": None} | more

    failed = {"outcome": "diverged", "metrics": {}, "processor_time": None, "diverged_at": 1.25}
    rows = [
        row("lissom", **failed, failure="The limit of 2 s of wall-clock time was reached: what was"),
        row("pyelastica"),
        row("mujoco", outcome="unsupported", metrics={}, processor_time=None),
        row("lissom", variant="time_step_scale=2", metrics={"pile_height": None}),
    ]
    sections = cosseratbench_report.sections(rows, "about")
    ordinary = sections["cosseratbench"]
    assert (
        "| pile | lissom | **ended at 1.25 s**: The limit of 2 s of wall-clock time was reached |  |"
        in ordinary
    )
    assert "| pile | PyElastica | pile height 2.5 | 3 s |" in ordinary
    assert "| pile | MuJoCo | does not express it |  |" in ordinary
    assert "| pile | time step scale=2 | pile height n/a | 3 s |" in sections["cosseratbench_variants"]


def test_what_is_installed_is_pinned_with_hashes():
    _, requirement = environment.PEERS["robots"]
    pinned = re.findall(r"^(\S+)==\S+.*\\\n    --hash=sha256:", requirement.read_text(), re.MULTILINE)
    assert {"pin", "mujoco", "soromox", "jax", "numpy"} <= set(pinned)
    assert set(environment.RODS) < set(environment.PEERS)
