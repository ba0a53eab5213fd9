"""Derivatives of runs of many kinds of robots, and of places, compared with differences of complete runs."""

import numpy as np
import pytest

import lissom
from lissom.analysis.parameters import model_with, value_of

TIGHT = {"rtol": 1e-13, "atol": 1e-13}


def segment(**changes):
    options = {"modes": {"bend_y": 2, "bend_z": 1}, "retardation_time": 0.02} | changes
    return lissom.Segment(0.2, 0.01, 3e5, 1.2e5, 1100, **options)


def shaken():
    base = lissom.BaseMotion(
        translation=lissom.Harmonic((0.02, 0, 0.01), 3.0), axis=(0, 0, 1), angle=lissom.Harmonic(0.3, 1.5)
    )
    return lissom.Rod([segment()], base_motion=base)


def rowed():
    oar = lissom.Revolute((0, 1, 0), motion=lissom.Harmonic(0.5, 2.0))
    return lissom.Robot(
        [
            lissom.Link("oar", body=lissom.Body(0.1, inertia=(1e-4, 1e-4, 1e-4)), joint=oar),
            lissom.Link("tail", rod=[segment()], parent="oar", position=(0.05, 0, 0)),
        ]
    )


def wired(length=0.1995):
    """Tendons that are slack in some states, one on either side."""
    wires = [
        lissom.Tendon(name, [lissom.Along(offset=(0, side * 0.006))], length=length, stiffness=100.0)
        for name, side in (("left", 1), ("right", -1))
    ]
    return lissom.Rod([segment(modes={"bend_y": 2, "stretch": 1})], actuators=wires)


def pushed():
    """A load at the end given by its arc length, isotropic springs, a table."""
    gust = ([0.0, 0.03, 0.2], [[0, 0, 0], [0, 0.01, 0.02], [0, 0, 0.01]])
    return lissom.Rod(
        [segment()],
        loads=[lissom.Load(force=(0, 0, 0.03), at=0.2), lissom.Load(force=gust, at=0.1)],
        supports=[lissom.Support(stiffness=30.0, position=(0.19, 0.01, 0.0))],
    )


def tapering():
    """A tendon that approaches the axis towards the end, with a chamber and a muscle beside it."""
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, (0.008, 0.004)))], tension=0.4)
    chamber = lissom.Chamber("chamber", [lissom.Along(offset=(0.003, 0))], area=2e-5, pressure=2e3)
    muscle = lissom.ActiveStrain(None, "bend_z", (1.0, 2.0), 0.7)
    return lissom.Rod(
        [segment(modes={"bend_y": 2, "bend_z": 1, "stretch": 1})], actuators=[pull, chamber, muscle]
    )


def silicone():
    """Segments with Poisson's ratios: the shear modulus is proportional to Young's modulus."""
    options = {"modes": {"bend_y": 1, "torsion": 1, "bend_z": 1}, "retardation_time": 0.02, "density": 1100}
    soft = [lissom.Segment(0.1, 0.01, 3e5, poisson_ratio=ratio, **options) for ratio in (0.5, 0.4)]
    return lissom.Rod(soft, loads=[lissom.Load(force=(0, 0.1, 0.0), moment=(0.003, 0, 0))])


@pytest.mark.parametrize(
    ("make", "name"),
    [
        # These parameters also affect places directly, through the prescribed motion.
        (shaken, "base_motion.translation.amplitude[0]"),
        (shaken, "base_motion.angle.frequency"),
        (rowed, "link[0].joint.motion.amplitude"),
        (rowed, "link[0].joint.motion.frequency"),
        (rowed, "link[1].position[0]"),
        # Slack in the states that test whether forces depend on a parameter.
        (wired, "actuators[0].length"),
        (wired, "actuators[1].stiffness"),
        # The tendons end at the end of the rod, for any length.
        (tapering, "segments[0].length"),
        (tapering, "actuators[0].path[0].offset[1][0]"),
        (silicone, "segments[0].young_modulus"),
        (silicone, "segments[1].poisson_ratio"),
        (pushed, "supports[0].stiffness"),
        (pushed, "loads[1].force[1][1][2]"),
    ],
)
def test_places_and_states_against_whole_runs(make, name):
    model = make()
    rng = np.random.default_rng(3)
    start = {"q0": 0.2 * rng.standard_normal(model.n), "v0": 0.5 * rng.standard_normal(model.n)}
    span = {"t_end": 0.12, "dt": 0.005, **start, **TIGHT}
    found = lissom.sensitivity(model, parameters=[name], **span)
    value = value_of(model, name)
    step = 1e-4 * abs(value)

    def run(change):
        moved = model_with(model, {name: value + change})
        result = lissom.simulate(moved, **span)
        return result.q, moved.pose(result.q, link=moved.links[-1].name, t=result.t)[:, :3, 3]

    runs = {k: run(k * step) for k in (-2, -1, 1, 2)}
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    for i, derivative in enumerate((found.dq, found.position()[1])):
        expected = sum(weights[k] * runs[k][i] for k in runs) / step
        assert np.abs(derivative[..., 0] - expected).max() < 1e-6 * np.abs(expected).max()


def test_what_cannot_be_shorter_is_differentiated_to_the_other_side():
    """A load that stays at 0.2 m does not allow a shorter rod."""
    model = pushed()
    found = lissom.sensitivity(model, 0.1, ["segments[0].length"], dt=0.005, **TIGHT)
    step = 2e-6

    def end(change):
        return lissom.simulate(
            model_with(model, {"segments[0].length": 0.2 + change}), 0.1, dt=0.005, **TIGHT
        ).q[-1]

    expected = (-1.5 * end(0.0) + 2 * end(step) - 0.5 * end(2 * step)) / step
    assert np.abs(found.dq[-1, :, 0] - expected).max() < 1e-5 * np.abs(expected).max()


def test_what_cannot_change_by_itself_is_named():
    profile = lissom.Profile(0.2, stations=[0, 0.1, 0.2], values=[0.012, 0.01, 0.006])
    slender = lissom.Segment(0.2, profile, 3e5, 1.2e5, 1100, modes={"bend_y": 2})
    with pytest.raises(
        ValueError, match=r"'segments\[0\]\.length', expected a number that can change by itself"
    ):
        lissom.sensitivity(lissom.Rod([slender]), 0.1, ["segments[0].length"])
    box = lissom.Segment(
        0.2,
        section=lissom.Section.rectangle(0.02, 0.01),
        young_modulus=3e5,
        shear_modulus=1.2e5,
        density=1100,
        modes={"bend_y": 2},
    )
    with pytest.raises(ValueError, match=r"^segments\[0\]\.section\.widht: .*did you mean 'width'"):
        lissom.sensitivity(lissom.Rod([box]), 0.1, ["segments[0].section.widht"])


def test_tendons_of_longer_rods_are_longer():
    """A tendon along the complete rod still is after a change of the length."""
    found = lissom.sweep(tapering(), {"segments[0].length": [0.15, 0.2, 0.25]}, t_end=0.1, dt=0.005)
    for length, row in zip((0.15, 0.2, 0.25), found.q.values, strict=True):
        made = lissom.Segment(
            length, 0.01, 3e5, 1.2e5, 1100, {"bend_y": 2, "bend_z": 1, "stretch": 1}, retardation_time=0.02
        )
        pull = lissom.Tendon("pull", [lissom.Along(offset=(0, (0.008, 0.004)))], tension=0.4)
        chamber = lissom.Chamber("chamber", [lissom.Along(offset=(0.003, 0))], area=2e-5, pressure=2e3)
        muscle = lissom.ActiveStrain(None, "bend_z", (1.0, 2.0), 0.7)
        rod = lissom.Rod([made], actuators=[pull, chamber, muscle])
        np.testing.assert_array_equal(row, lissom.simulate(rod, 0.1, dt=0.005).q[-1])


def test_a_modulus_of_silicone_can_be_swept_and_fitted():
    """Poisson's ratio is kept: at 1/2 the modulus could not increase otherwise."""
    soft = lissom.Segment(
        0.2, 0.01, 3e5, poisson_ratio=0.5, density=1100, modes={"bend_y": 2}, retardation_time=0.02
    )
    assert "poisson_ratio=0.5" in repr(soft)
    rod = lissom.Rod([soft])
    assert rod.segments[0] == soft
    assert model_with(rod, {"segments[0].young_modulus": 6e5}).segments[0].shear_modulus == 2e5
    # One of the two replaces the other.
    assert model_with(rod, {"segments[0].shear_modulus": 1.1e5}).segments[0].shear_modulus == 1.1e5
    run = lissom.simulate(rod, 0.3)
    tips = np.array([rod.pose(q)[:3, 3] for q in run.q[1:]])
    guess = model_with(rod, {"segments[0].young_modulus": 2e5})
    found = lissom.fit(guess, (run.t[1:], tips), {"segments[0].young_modulus": (1e5, 2e5, 1e6)})
    np.testing.assert_allclose(found.values, [3e5], rtol=1e-6)
    assert found.model.segments[0].poisson_ratio == 0.5
