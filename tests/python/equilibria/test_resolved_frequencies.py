"""Which natural frequencies the modes of rods resolve: results, messages and the command line say it."""

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom import cli

#: Eigenvalues of a clamped and free beam: cos(x) cosh(x) = -1.
BEAM = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073])
LENGTH, RADIUS, MODULUS, DENSITY = 1.0, 5e-3, 2e9, 1200.0


def beam(modes, **others):
    segment = lissom.Segment(LENGTH, RADIUS, MODULUS, poisson_ratio=0.4, density=DENSITY, modes=modes)
    return lissom.Rod([segment], gravity=(0, 0, 0), **others)


def exact(count):
    stiffness = MODULUS * np.pi / 4 * RADIUS**4
    mass = DENSITY * np.pi * RADIUS**2
    return BEAM[:count] ** 2 * np.sqrt(stiffness / mass) / (2 * np.pi * LENGTH**2)


def test_refined_frequencies_are_those_of_a_beam():
    found = lissom.modes(beam({"bend_y": 4}), np.zeros(4))
    assert found.frequency[3] > 1.3 * exact(4)[3]
    # Sections of a rod have rotary inertia, a beam has none: 4e-4 at the fourth.
    assert found.refined_frequency == pytest.approx(exact(4), rel=2e-3)
    assert found.message.startswith(
        "4 modes, stable. The first 2 frequencies are resolved; the following change by"
    )
    fourth = f"number 4 of {found.frequency[3]:.4g} Hz becomes {found.refined_frequency[3]:.4g} Hz"
    assert fourth.split(" of ")[0] in found.message
    assert f"{found.refined_frequency[3]:.3f}"[:4] in found.message


def test_enough_modes_resolve_all_that_matters():
    found = lissom.modes(beam({"bend_y": 10}), np.zeros(10))
    close = np.abs(found.frequency / found.refined_frequency - 1) < 0.01
    assert close[:5].all()
    assert not close[-1]


def test_vibrations_are_found_again_between_others():
    """In a round rod: pairs of bending, and torsion between them, whose place in the order changes."""
    modes = {"torsion": 3, "bend_y": 3, "bend_z": 3}
    segment = lissom.Segment(0.2, 0.02, 1e6, poisson_ratio=0.45, density=1000.0, modes=modes)
    found = lissom.modes(lissom.Rod([segment], gravity=(0, 0, 0)), np.zeros(9))
    twists = np.abs(found.shapes[:3]).sum(axis=0) > np.abs(found.shapes[3:]).sum(axis=0)
    wave = np.sqrt(segment.shear_modulus / segment.density) / (4 * segment.length)
    assert found.refined_frequency[twists] == pytest.approx(wave * np.array([1, 3, 5]), rel=1e-3)
    bends = found.refined_frequency[~twists]
    assert bends[::2] == pytest.approx(bends[1::2], rel=1e-6)


def test_robots_with_loops_and_damping_have_them_too():
    segment = lissom.Segment(0.3, 5e-3, 1e7, 4e6, 1000.0, modes={"bend_y": 3}, retardation_time=2e-3)
    links = [lissom.Link("arm", joint=lissom.Revolute((0, 1, 0), stiffness=1.0), rod=[segment])]
    loop = lissom.Loop("arm", (None, None, (0.3, 0, 0)), lissom.Planar((0, 0, 1)))
    robot = lissom.Robot(links, gravity=(0, 0, 0), loops=[loop])
    found = lissom.modes(robot, np.zeros(robot.n))
    assert found.refined_frequency.shape == found.frequency.shape
    assert found.refined_frequency[0] == pytest.approx(found.frequency[0], rel=1e-2)
    assert (found.refined_frequency <= found.frequency * (1 + 1e-6)).all()


def test_models_without_modes_say_nothing_of_them():
    found = lissom.modes(lissom.SpringPendulum(), lissom.statics(lissom.SpringPendulum()).q)
    assert found.refined_frequency is None
    assert found.message == "2 modes, stable."


def test_they_are_saved(tmp_path):
    found = lissom.modes(beam({"bend_y": 3}), np.zeros(3))
    found.save(tmp_path / "x.lissom")
    again = lissom.load(tmp_path / "x.lissom")
    assert (again.refined_frequency == found.refined_frequency).all()
    assert again.message == found.message
    with pytest.raises(ValueError, match="read-only"):
        found.refined_frequency[0] = 1.0


def test_inputs_and_times_count():
    """A wire under tension, which raises its frequencies in the larger model as in the smaller one."""
    pulled = beam(
        {"bend_y": 8}, loads=[lissom.Load(force=lissom.Input("pull", (0.0, 0.0, 0.0)), frame="world")]
    )
    free, taut = (lissom.modes(pulled, np.zeros(8), u=[force, 0, 0]) for force in (0.0, 500.0))
    assert taut.frequency[0] > 1.5 * free.frequency[0]
    assert taut.refined_frequency[0] == pytest.approx(taut.frequency[0], rel=1e-2)


SCENE = f"""version = 1
[scene]
gravity = [0, 0, 0]
[[rod]]
[[rod.segment]]
length = {LENGTH}
radius = {RADIUS}
young_modulus = {MODULUS}
poisson_ratio = 0.4
density = {DENSITY}
modes = {{ bend_y = 4 }}
[simulation]
t_end = 1.0
"""


def test_the_command_line_says_it(tmp_path):
    path = tmp_path / "beam.toml"
    path.write_text(SCENE, encoding="utf-8")
    done = CliRunner().invoke(
        cli.commands, ["modes", str(path), "-o", str(tmp_path / "out")], standalone_mode=False
    )
    assert done.return_value == 0, done.output
    found = lissom.modes(beam({"bend_y": 4}), np.zeros(4))
    assert f"{found.refined_frequency[3]:.4g} Hz with more modes" in done.output
    assert "The first 2 frequencies are resolved" in done.output
