"""Messages name the limits of segments that a result exceeds: which, by how much, where and when."""

import copy
import pickle
import re

import numpy as np
import pytest

import lissom
from lissom.analysis import limits

LENGTH = 0.3


def finger(gravity=(0, 0, -9.81), actuators=(), **limits):
    segment = lissom.Segment(
        LENGTH, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3}, retardation_time=0.02, **limits
    )
    return lissom.Rod([segment], gravity=gravity, actuators=actuators)


def tendon():
    return lissom.Tendon("pull", [lissom.Along(offset=(0, 0.008))], tension=lissom.Input("pull", 0.0))


def largest(peaks, quantity):
    return next(peak for peak in peaks if peak.quantity == quantity and peak.share is not None)


@pytest.mark.parametrize(
    ("limit", "quantity"),
    [("min_bend_radius", "curvature"), ("max_strain", "axial strain"), ("max_stress", "axial stress")],
)
def test_equilibria_name_each_limit(limit, quantity):
    plain = {peak.quantity: peak.value for peak in lissom.statics(finger()).peaks(finger())}
    allowed = 0.5 * plain[quantity]
    bent = finger(**{limit: 1.0 / allowed if limit == "min_bend_radius" else allowed})
    rest = lissom.statics(bent)
    peak = largest(rest.peaks(bent), quantity)
    assert peak.share == pytest.approx(2.0)
    assert f"Beyond `{limit}`, 2 times what is allowed: {peak}." in rest.message
    assert f"at X = {peak.X:.4g} m" in rest.message
    within = finger(**{limit: 0.4 / allowed if limit == "min_bend_radius" else 3.0 * allowed})
    assert "Beyond" not in lissom.statics(within).message
    assert "Beyond" not in lissom.statics(finger()).message


def test_motions_say_when():
    bent = finger(min_bend_radius=0.5)
    motion = lissom.simulate(bent, 0.3, dt=2e-3)
    peak = largest(motion.peaks(), "curvature")
    assert peak.share > 1.0
    assert f"what is allowed: {peak}." in motion.message
    assert f"t = {peak.t:.6g} s" in motion.message
    assert motion.message in repr(motion).replace("\\'", "'")
    # Copies and files say it once.
    for again in (copy.copy(motion), pickle.loads(pickle.dumps(motion))):
        assert again.message == motion.message
        assert again.message.count("Beyond") == motion.message.count("Beyond") == 1


def test_equilibria_of_files_say_it_once(tmp_path):
    bent = finger(min_bend_radius=0.5)
    rest = lissom.statics(bent)
    rest.save(tmp_path / "x.lissom")
    again = lissom.load(tmp_path / "x.lissom")
    assert again.message == rest.message
    assert again.message.count("Beyond") == 1


def test_found_inputs_and_rows_say_it():
    bent = finger((0, 0, 0), [tendon()], min_bend_radius=0.5)
    there = lissom.statics(bent, u=[5.0])
    assert "Beyond `min_bend_radius`" in there.message
    target = bent.pose(there.q)[:3, 3]
    found = lissom.actuate(bent, target)
    assert found.success
    assert "Beyond `min_bend_radius`" in found.message
    rows = lissom.statics_many(bent, {"pull": [0.0, 5.0]})
    assert ["Beyond" in message for message in rows.message] == [False, True]


def test_nothing_is_evaluated_until_a_message_is_read(monkeypatch):
    asked = []
    monkeypatch.setattr(limits, "exceeded_by_motion", lambda result: asked.append(result) or ["Asked."])
    motion = lissom.simulate(finger(min_bend_radius=0.5), 0.02, dt=2e-3)
    assert asked == []
    assert motion.message.endswith(" Asked.")
    assert motion.message.endswith(" Asked.")
    assert len(asked) == 1
    # Without limits nothing is evaluated at all.
    assert "Asked" not in lissom.simulate(finger(), 0.02, dt=2e-3).message
    assert len(asked) == 1


def test_failed_runs_name_what_they_exceed_before():
    """A rod that is pulled until the run fails, its last state being meaningless."""
    bent = finger((0, 0, 0), [tendon()], min_bend_radius=0.5)
    with np.errstate(all="ignore"):
        motion = lissom.simulate(bent, 1.0, dt=1e-3, u={"pull": 200.0})
    assert not motion.success
    assert re.search(
        r"Beyond `min_bend_radius`, \S+ times what is allowed: curvature of rod: ", motion.message
    )
