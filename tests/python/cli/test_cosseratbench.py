"""The adaptor for `cosseratbench`: its parts on scenarios of plain data, and whole runs where the
benchmark is installed."""

import importlib.util
import tomllib
from enum import Enum
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from lissom.cli.evidence import cosseratbench as adaptor

ROOT = Path(__file__).parents[3]
needs_benchmark = pytest.mark.skipif(
    importlib.util.find_spec("cosseratbench") is None, reason="cosseratbench is not installed"
)


class Ends(Enum):
    FREE = "free"
    PINNED = "pinned"
    CLAMPED = "clamped"


class At(Enum):
    START = "start"
    END = "end"


def rod(points, **changes):
    """A rod with the attributes of the benchmark's."""
    points = np.asarray(points, dtype=float)
    given = {
        "centerline": tuple(map(tuple, points)),
        "radius": 0.01,
        "material": SimpleNamespace(youngs_modulus=1e6, shear_modulus=4e5, density=1000.0),
        "normal": (0.0, 0.0, 1.0),
        "start": Ends.CLAMPED,
        "end": Ends.FREE,
        "loads": (),
        "rest_arc_length": None,
        "start_motion": None,
        "end_motion": None,
        "friction": 0.0,
        "length": float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()),
        "area": np.pi * 1e-4,
    } | changes
    return SimpleNamespace(**given)


def scenario(*rods, **changes):
    given = {
        "rods": rods,
        "duration": 0.1,
        "gravity": (0.0, 0.0, -9.81),
        "obstacles": (),
        "self_contact": False,
        "quasi_static": False,
        "slowest_frequency": lambda: 3.0,
    } | changes
    return SimpleNamespace(**given)


def motion(times, displacement, rotation, slides_along=None):
    axis = None if slides_along is None else np.asarray(slides_along) / np.linalg.norm(slides_along)
    return SimpleNamespace(
        times=times, displacement=displacement, rotation=rotation, slides_along=slides_along, axis=axis
    )


LINE = [(1.0, 2.0, 3.0), (1.0, 2.5, 3.0)]
ARC = [(np.sin(a), 0.0, 1 - np.cos(a)) for a in np.linspace(0.0, 1.0, 601)]


def test_a_rod_lies_along_its_centreline_without_twist():
    # A clamp would hold the direction of the first chord.
    pinned = rod(ARC, normal=(0.0, 1.0, 0.0), start=Ends.PINNED)
    robot, q0 = adaptor.robot_of(scenario(pinned), 3)
    X = np.linspace(0.0, robot.links[0].rod[0].length * 3, 601)
    poses = robot.pose(q0, X)
    assert_allclose(poses[:, :3, 3], ARC, atol=1e-6)
    # The direction across the plane is the second axis of all sections.
    assert_allclose(poses[:, :3, 1], np.tile([0.0, 1.0, 0.0], (601, 1)), atol=1e-9)


def test_unstretched_lengths_are_those_of_the_scenario():
    stretched = rod(LINE, rest_arc_length=(0.0, 0.4), length=0.4)
    robot, q0 = adaptor.robot_of(scenario(stretched), 2)
    assert_allclose(robot.pose(q0, [0.2, 0.4])[:, :3, 3], [(1, 2.25, 3), (1, 2.5, 3)], atol=1e-9)
    assert_allclose(robot.strain(q0, 0.1)[3], 1.25, rtol=1e-9)


@pytest.mark.parametrize(
    ("start", "end", "coordinates", "constraints"),
    [
        (Ends.CLAMPED, Ends.FREE, 0, 0),
        (Ends.PINNED, Ends.PINNED, 3, 3),
        (Ends.FREE, Ends.CLAMPED, 6, 6),
        (Ends.CLAMPED, Ends.CLAMPED, 0, 6),
    ],
)
def test_ends_are_joints_and_loops(start, end, coordinates, constraints):
    robot, q0 = adaptor.robot_of(scenario(rod(ARC, start=start, end=end, normal=(0.0, 1.0, 0.0))), 2)
    assert robot.n == coordinates + 2 * sum(adaptor.MODES.values())
    assert robot.constraints == constraints
    if constraints:
        assert np.abs(robot.loop_gaps(q0)).max() < 1e-4


def test_the_driven_end_turns_and_slides():
    twist = motion((0.0, 0.1), ((0, 0, 0), (0, 0, 0)), ((0, 0, 0), (0, 0.3, 0)), slides_along=(0.0, 1.0, 0.0))
    load = SimpleNamespace(force=(0.0, 1.0, 0.0), at=At.END)
    driven = rod(LINE, end=Ends.CLAMPED, end_motion=twist, loads=(load,))
    robot, q0 = adaptor.robot_of(scenario(driven, gravity=(0.0, 0.0, 0.0)), 2)
    assert robot.constraints == 5
    result = lissom.simulate(robot, 0.1, q0=q0, dt=1e-3)
    assert result.success
    turned = result.pose(link="rod0")[-1] @ np.linalg.inv(result.pose(link="rod0")[0])
    assert_allclose(Rotation.from_matrix(turned[:3, :3]).as_rotvec(), [0.0, 0.3, 0.0], atol=1e-6)
    assert result.pose(link="rod0")[-1, 1, 3] > 2.5


def test_the_driven_start_moves():
    descent = motion((0.0, 0.05), ((0, 0, 0), (0, 0, -0.02)), ((0, 0, 0), (0, 0, 0)))
    robot, q0 = adaptor.robot_of(scenario(rod(LINE, start_motion=descent)), 1)
    result = lissom.simulate(robot, 0.1, q0=q0, dt=1e-3)
    assert_allclose(result.pose(0.0, link="rod0")[-1, :3, 3], [1.0, 2.0, 2.98], atol=1e-12)


def test_what_cannot_be_expressed_is_said():
    wobble = motion((0.0, 0.1, 0.2), ((0, 0, 0),) * 3, ((0, 0, 0), (0, 0.3, 0), (0.3, 0, 0)))
    with pytest.raises(NotImplementedError, match="several axes"):
        adaptor.robot_of(scenario(rod(LINE, start_motion=wobble)), 1)
    slides = motion((0.0, 0.1), ((0, 0, 0),) * 2, ((0, 0, 0),) * 2, slides_along=(0.0, 1.0, 0.0))
    with pytest.raises(NotImplementedError, match="slides along"):
        adaptor.robot_of(scenario(rod(LINE, start_motion=slides)), 1)
    thick = rod(LINE, area=1.0)
    with pytest.raises(NotImplementedError, match="different masses"):
        adaptor.robot_of(scenario(rod(LINE), thick, quasi_static=True), 1)


def test_all_pairs_touch_with_the_larger_friction():
    floor = SimpleNamespace(
        kind="plane", point=(0.0, 0.0, 0.0), unit_normal=np.array([0.0, 0.0, 1.0]), friction=0.2
    )
    drum = SimpleNamespace(
        kind="cylinder",
        center=(0, 0, -1),
        unit_axis=np.array([0, 1, 0]),
        length=0.4,
        radius=0.1,
        friction=0.5,
    )
    rods = rod(LINE, friction=0.3), rod(LINE, friction=0.1)
    pairs = adaptor.contacts_of(scenario(*rods, obstacles=(floor, drum), self_contact=True))
    found = {contact.name: contact.friction[0] for contact in pairs}
    assert found == {
        "rod0 on obstacle 0": 0.3,
        "rod0 on obstacle 1": 0.5,
        "rod1 on obstacle 0": 0.2,
        "rod1 on obstacle 1": 0.5,
        "rod0 on rod0": 0.3,
        "rod0 on rod1": 0.3,
        "rod1 on rod1": 0.1,
    }
    assert len(adaptor.contacts_of(scenario(*rods))) == 1
    capsule = adaptor.shape_of(drum)
    assert_allclose([capsule.start, capsule.end], [(0, -0.2, -1), (0, 0.2, -1)])


def test_damping_is_that_of_mass_and_stops_a_falling_rod_at_its_speed():
    falling = rod(LINE, start=Ends.FREE)
    robot, q0 = adaptor.robot_of(scenario(falling, quasi_static=True), 1)
    result = lissom.simulate(robot, 1.0, q0=q0, dt=1e-3)
    rate, t = 6.0, result.t
    # v' = -g - rate v from rest.
    fall = -9.81 / rate * (t - (1 - np.exp(-rate * t)) / rate)
    assert_allclose(result.pose(0.25)[:, 2, 3] - 3.0, fall, atol=1e-5)
    assert adaptor.damping_of(scenario(falling)) is None


def test_quaternions_are_those_of_scipy():
    for turn in Rotation.random(50, random_state=1):
        ours = adaptor.quaternion_of(turn.as_matrix())
        assert_allclose(abs(ours @ turn.as_quat(scalar_first=True)), 1.0, atol=1e-12)


def test_the_entry_point_names_the_adaptor():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, _, name = project["entry-points"]["cosseratbench.solvers"]["lissom"].partition(":")
    assert module == adaptor.__name__
    assert getattr(adaptor, name) is adaptor.LissomSolver
    assert any(need.startswith("cosseratbench") for need in project["optional-dependencies"]["cosseratbench"])


@needs_benchmark
@pytest.mark.parametrize("name", ["cantilever", "pendulum"])
def test_experiments_complete(name):
    from cosseratbench import registry
    from cosseratbench.experiment import run

    experiment = registry.load_experiment(name)
    result = run(experiment, adaptor.LissomSolver(), n_elements=20)
    assert result.outcome == "completed"
    largest = {"tip_deflection_error": 1e-3, "period_error": 5e-5, "amplitude_change": 1e-4}
    for metric, value in result.metrics.items():
        assert abs(value) < largest.get(metric, 1.0)


@needs_benchmark
def test_a_limit_of_time_counts_as_diverged():
    from cosseratbench import registry
    from cosseratbench.experiment import run

    result = run(registry.load_experiment("pile"), adaptor.LissomSolver(max_seconds=0.2), n_elements=10)
    assert result.outcome == "diverged"
    assert "wall-clock" in result.failure
