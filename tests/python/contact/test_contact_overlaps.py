"""The deepest overlap in results, and messages about contacts that are too soft or hold up a run."""

from __future__ import annotations

import copy
import pickle
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import lissom

FLOOR = lissom.HalfSpace()
RADIUS = 5e-3


def cable(stiffness=None, height=0.05, young=5e7, **options):
    """A clamped rod above a floor on which it comes to lie."""
    segment = lissom.Segment(
        0.5, RADIUS, young, poisson_ratio=0.4, density=1500, modes={"bend_y": 4}, retardation_time=0.02
    )
    contact = lissom.Contact("rod", FLOOR, stiffness=stiffness, name="ground")
    link = lissom.Link("rod", rod=[segment], position=(0, 0, height))
    return lissom.Robot([link], contacts=[contact], **options)


def test_statics_has_the_deepest_overlap():
    robot = cable(1e4)
    found = lissom.statics(robot)
    assert found.success
    deepest = max(touch.overlap for touch in robot.touches(found.q))
    assert found.deepest.contact == "ground"
    assert found.deepest.t is None
    assert_allclose(found.deepest.depth, deepest, rtol=1e-9)
    assert_allclose(found.deepest.share, deepest / RADIUS, rtol=1e-9)
    assert lissom.statics(cable(1e4, height=1.0)).deepest is None
    assert lissom.statics(lissom.Robot(robot.links)).deepest is None


@pytest.mark.parametrize("method", ["newmark", "radau"])
def test_motions_have_the_deepest_overlap_of_their_steps(method):
    robot = cable(1e5)
    motion = lissom.simulate(robot, 0.4, dt=2e-3, method=method)
    assert motion.success
    overlaps = [
        max((touch.overlap for touch in robot.touches(q, v)), default=0.0)
        for q, v in zip(motion.q, motion.v, strict=True)
    ]
    deepest = motion.deepest
    assert deepest.contact == "ground"
    assert_allclose(deepest.share, deepest.depth / RADIUS, rtol=1e-12)
    if method == "newmark":
        # Its steps are all states of the result.
        assert_allclose(deepest.depth, max(overlaps), rtol=1e-9)
        assert deepest.t == motion.t[np.argmax(overlaps)]
    else:
        assert deepest.depth >= 0.9 * max(overlaps)
    assert lissom.simulate(cable(1e5, height=1.0), 0.05, dt=5e-3, method=method).deepest is None


def test_results_keep_it(tmp_path):
    robot = cable(1e5)
    for result in (lissom.statics(robot), lissom.simulate(robot, 0.2, dt=2e-3)):
        path = tmp_path / f"{type(result).__name__}.nc"
        result.save(path)
        for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), lissom.load(path)):
            deepest = again.deepest
            known = result.deepest
            assert (deepest.contact, deepest.depth, deepest.share, deepest.t) == (
                known.contact,
                known.depth,
                known.share,
                known.t,
            )
    assert repr(result.deepest).startswith('<Overlap of "ground": ')


def advised(message):
    """The stiffness that a message advises."""
    (number,) = re.findall(r"raise `stiffness` from \S+ to ([\d.e+-]+) N/m\^2", message)
    return float(number)


def test_contacts_that_are_too_soft_are_named_with_a_number_that_helps():
    soft = lissom.statics(cable(2000.0))
    assert soft.success
    assert soft.deepest.share > 0.35
    assert 'The contact "ground" is soft for its load' in soft.message
    better = lissom.statics(cable(advised(soft.message)))
    assert better.success
    assert better.deepest.share < 0.2
    assert "soft" not in better.message
    # Without rebounds it does not sink in.
    stopped = lissom.methods.Newmark(impacts="stopped")
    motion = lissom.simulate(cable(1e4), 0.3, dt=2e-3, method=stopped)
    assert motion.success
    assert motion.deepest.share > 0.35
    assert_allclose(advised(motion.message), 1e4 * (motion.deepest.share / 0.15) ** 1.5, rtol=0.1)
    better = lissom.simulate(cable(advised(motion.message)), 0.3, dt=2e-3, method=stopped)
    assert better.deepest.share < 0.35
    assert "soft" not in better.message
    assert "soft" not in lissom.simulate(cable(), 0.3, dt=2e-3).message


def test_what_touches_where_a_search_fails_is_named():
    failed = lissom.statics(cable("material"), max_iter=10)
    assert not failed.success
    place = r'contact "ground" overlaps most at \((\S+), \S+, \S+\) m, (\S+) m along "rod", (\S+) m deep'
    x, along, deep = map(float, re.search(place, failed.message).groups())
    touches = cable("material").touches(failed.q)
    most = max(touches, key=lambda touch: touch.overlap)
    assert_allclose([x, along], [most.position[0], most.along[0]], atol=1e-4)
    assert_allclose(deep, most.overlap, rtol=0.1)
    # With a number that does not hold it up.
    (number,) = re.findall(r"It is stiff for its load: `stiffness=(\S+)` in place of 4.7e7", failed.message)
    assert_allclose(float(number), cable()._contact_stiffness()[0], rtol=0.1)
    # What is as stiff as it must be, is not called stiff.
    failed = lissom.statics(cable(), max_iter=10)
    assert not failed.success
    assert 'contact "ground" overlaps most' in failed.message
    assert "stiff for its load" not in failed.message


def test_steps_into_a_first_touch_that_fail_say_what_meets():
    # Of impacts that no step follows: the last state touches nothing.
    wire = lissom.Segment(
        6.0, 5e-4, 2e11, poisson_ratio=0.4, density=1500, modes={"bend_y": 8}, retardation_time=0.01
    )
    contact = lissom.Contact("wire", lissom.HalfSpace((0, 0, -0.3)), stiffness="material", name="ground")
    robot = lissom.Robot([lissom.Link("wire", rod=[wire])], contacts=[contact])
    motion = lissom.simulate(robot, 1.0, dt=2e-2)
    assert not motion.success
    assert motion.deepest is None
    assert re.search(
        r'meet in the next step: those of contact "ground" near \(\S+, \S+, -0.3', motion.message
    )
    assert re.search(r"`stiffness=\S+e6` in place of 1.9e11 N/m\^2", motion.message)


def test_runs_that_end_early_say_what_touches():
    def stop(t):
        return (0.0, 0.0, np.nan if t > 0.3 else 0.0)

    robot = cable(1e5, loads=[lissom.Load(force=stop)])
    motion = lissom.simulate(robot, 0.5, dt=2e-3)
    assert motion.status == "non_finite"
    assert 'contact "ground" overlaps most at' in motion.message
    by_steps = lissom.Simulation(robot, dt=2e-3)
    by_steps.step(duration=0.5)
    assert by_steps.status == "non_finite"
    assert 'contact "ground" overlaps most at' in by_steps.message
