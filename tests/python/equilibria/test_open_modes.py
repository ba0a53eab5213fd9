"""Segments whose modes are left to an accuracy: `modes="auto"`."""

import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

STEEL = {"young_modulus": 210e9, "shear_modulus": 80e9, "density": 7800}


def wire(modes="auto", length=1.0, radius=1e-3, **of_segment):
    return lissom.Segment(length, radius, **STEEL, modes=modes, **of_segment)


def rod(*modes, **of_rod):
    return lissom.Rod([wire(each, 1.0 / len(modes)) for each in modes], **of_rod)


def test_open_modes_are_a_part_of_the_description():
    segment = wire()
    assert segment.modes == "auto"
    assert "modes='auto'" in repr(segment)
    model = rod("auto", {"bend_y": 2})
    assert [each.modes for each in model.segments] == ["auto", {"bend_y": 2}]
    assert "modes open" in repr(model)
    for other in (copy.copy(model), pickle.loads(pickle.dumps(model)), lissom.Rod(model.segments)):
        assert other == model
        assert other.segments[0].modes == "auto"
    assert model != rod({"bend_y": 1, "bend_z": 1}, {"bend_y": 2})
    with pytest.raises(ValueError, match="modes: got 'many', expected 'auto'"):
        wire("many")


REFUSED = {
    "n": lambda model: model.n,
    "coordinates": lambda model: model.coordinates,
    "slice": lambda model: model.slice("rod"),
    "pose": lambda model: model.pose([0, 0]),
    "jacobian": lambda model: model.jacobian([0, 0]),
    "mass_matrix": lambda model: model.mass_matrix([0, 0]),
    "inverse_dynamics": lambda model: model.inverse_dynamics([0, 0], [0, 0], [0, 0]),
    "explain": lambda model: model.explain(),
    "nodes": lambda model: model.nodes,
    "kernel": lambda model: model.kernel,
    "reach": lambda model: model.reach((0.5, 0, 0.5)),
    "Simulation": lambda model: lissom.Simulation(model, 1e-3),
    "simulate_many": lambda model: lissom.simulate_many(model, 1.0, q0=np.zeros((2, 2))),
    "statics_many": lambda model: lissom.statics_many([model] * 2),
    "continuation": lambda model: lissom.continuation(model),
    "linearise": lambda model: lissom.linearise(model, [0, 0]),
    "sensitivity": lambda model: lissom.sensitivity(model, 1.0, ["segments[0].radius"]),
    "equilibrium_sensitivity": lambda model: lissom.equilibrium_sensitivity(model, ["segments[0].radius"]),
    "fit": lambda model: lissom.fit(model, ([0.1, 0.2], np.zeros((2, 3))), {"segments[0].radius": 1e-3}),
    "solve_ivp": lambda model: lissom.solve_ivp(model, (0, 1), [0, 0, 0, 0]),
    "actuate": lambda model: lissom.actuate(model, (0.5, 0, 0.5)),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_needs_coordinates_says_who_gives_them(what):
    with pytest.raises(
        ValueError, match=r'segments\[0\] has modes="auto".*`lissom.choose_modes\(robot, rtol'
    ):
        REFUSED[what](rod("auto"))


def test_the_segment_is_named():
    robot = lissom.Robot(
        [lissom.Link("a", rod=[wire({"bend_y": 1})]), lissom.Link("b", parent="a", rod=[wire()])]
    )
    with pytest.raises(ValueError, match=r'modes: segments\[0\] of link "b" has'):
        robot.pose([0, 0, 0], link="b")


def test_an_equilibrium_chooses_open_modes_alone():
    model = rod("auto", {"bend_y": 8})
    found = lissom.statics(model)
    assert found.success
    assert found.space_error.relative <= 1e-4
    first, second = (segment.modes for segment in found.model.segments)
    assert first["bend_y"] > 1
    assert second == {"bend_y": 8}
    assert f"Modes chosen: bend_y {first['bend_y']}" in found.message
    frozen = lissom.choose_modes(model)
    assert frozen == found.model
    assert_allclose(lissom.statics(frozen).q, found.q, rtol=1e-9)
    # All are chosen where none is open.
    assert lissom.choose_modes(rod({"bend_y": 1}), rtol=1e-3) == lissom.choose_modes(rod("auto"), rtol=1e-3)
    with pytest.raises(ValueError, match=r"q0: the modes are open.*`lissom.choose_modes`"):
        lissom.statics(model, [0.0])


def test_given_modes_that_are_too_few_are_named():
    """More modes of the open segment do not help: the trials end at once."""
    found = lissom.statics(rod("auto", {"bend_y": 1}), rtol=1e-5)
    assert found.status == "accuracy_not_reached"
    assert found.space_error.segment == 1
    assert "the modes of segments[1], which are given" in found.message
    with pytest.raises(lissom.LissomError, match=r"the modes of segments\[1\], which are given"):
        lissom.choose_modes(rod("auto", {"bend_y": 1}), rtol=1e-5)


def test_a_motion_chooses_open_modes_to_its_accuracy():
    model = lissom.Rod([wire(retardation_time=1e-4)])
    run = lissom.simulate(model, 0.3, method="auto", rtol=1e-3)
    assert run.success
    assert run.stats.space_error <= 1e-3
    assert "Modes chosen: bend_y" in run.message
    assert run.model == lissom.choose_modes(model, 0.3, rtol=1e-3)
    assert run.q.shape[1] == run.model.n
    described = lissom.simulate(model, 0.3, method=lissom.methods.Auto(rtol=1e-3))
    assert_allclose(described.q, run.q)
    with pytest.raises(ValueError, match=r'method: the modes are open.*method="auto".*`lissom.choose_modes'):
        lissom.simulate(model, 0.3)
    with pytest.raises(ValueError, match=r"v0: the modes are open"):
        lissom.simulate(model, 0.3, method="auto", v0=[0.0])
    stopped = lissom.simulate(model, 0.3, method="auto", rtol=1e-3, max_seconds=1e-6)
    assert stopped.status == "time_limit"


@pytest.mark.parametrize("count", [1, 4])
def test_vibrations_choose_modes_that_resolve_them(count):
    """Beside the cantilever beam of Euler and Bernoulli; each frequency belongs to two planes."""
    model = rod("auto", gravity=(0, 0, 0))
    found = lissom.modes(model, frequencies=count)
    roots = np.repeat([1.8751040687, 4.6940911330, 7.8547574382], 2)[:count]
    per_length = 7800 * np.pi * 1e-6
    bending = 210e9 * np.pi / 4 * 1e-12
    exact = roots**2 * np.sqrt(bending / per_length) / (2 * np.pi)
    assert_allclose(found.frequency[:count], exact, rtol=1e-2)
    assert_allclose(found.refined_frequency[:count], found.frequency[:count], rtol=1e-2)
    assert "Modes chosen: bend_y" in found.message
    assert found.q.shape == (found.model.n,)
    again = lissom.modes(found.model, found.q)
    assert_allclose(again.frequency, found.frequency)


def test_vibrations_about_a_sagging_shape():
    model = lissom.Rod([lissom.Segment(1.0, (5e-3, 1e-3), 1e9, 4e8, 1200, "auto")])
    found = lissom.modes(model)
    assert found.space_error.relative <= 1e-4
    fine = [
        lissom.Segment(0.1, (5e-3 - 4e-4 * k, 4.6e-3 - 4e-4 * k), 1e9, 4e8, 1200, BOTH) for k in range(10)
    ]
    exact = lissom.Rod(fine)
    there = lissom.modes(exact, lissom.statics(exact).q)
    assert_allclose(found.frequency[:3], there.frequency[:3], rtol=1e-2)
    with pytest.raises(ValueError, match=r"q: the modes are open"):
        lissom.modes(model, [0.0])
    with pytest.raises(ValueError, match=r"frequencies: only for a robot with modes="):
        lissom.modes(exact, there.q, frequencies=2)
    with pytest.raises(ValueError, match=r"frequencies: got 0"):
        lissom.modes(model, frequencies=0)


#: Modes of one of ten pieces of a sagging rod that vibrates in space.
BOTH = {"torsion": 1, "bend_y": 3, "bend_z": 3}


def test_scenes_and_python_mean_the_same(tmp_path):
    text = """
version = 1
[simulation]
t_end = 0.3
method = "auto"
rtol = 1e-3
[[rod]]
[[rod.segment]]
length = 1.0
radius = 1e-3
young_modulus = 210e9
shear_modulus = 80e9
density = 7800.0
retardation_time = 1e-4
modes = "auto"
"""
    path = tmp_path / "open.toml"
    path.write_text(text)
    scene = lissom.Scene.load(path)
    model = lissom.Rod([wire(retardation_time=1e-4)])
    assert scene.model.segments == lissom.choose_modes(model, 0.3, rtol=1e-3).segments
