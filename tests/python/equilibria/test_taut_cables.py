"""Cables that are exactly as long as their span: if they cannot stretch, nothing finite holds them."""

import numpy as np
import pytest

import lissom

SPAN = 10.0


def cable(length, modes, joint=None):
    """A steel rope of this length between two pins."""
    pin = lissom.Revolute((0, 1, 0)) if joint is None else joint
    rope = lissom.Segment(length, 0.01, 2.1e11, poisson_ratio=0.3, density=7850.0, modes=modes)
    end = lissom.Loop("cable", (None, None, (SPAN, 0, 0)), pin)
    return lissom.Robot([lissom.Link("cable", rod=[rope], joint=pin)], loops=[end])


@pytest.mark.parametrize("joint", [None, lissom.Spherical()])
def test_a_taut_cable_is_called_so(joint):
    found = lissom.statics(cable(SPAN, {"bend_y": 8}, joint))
    assert not found.success
    assert (
        'A chain that does not stretch is taut, exactly as long as its ends are apart ("cable"'
        in found.message
    )
    assert "and the world: 10 m)" in found.message


def test_what_is_advised_works():
    """With stretch it sags by s, whose strain is 8/3 (s/L)^2, and whose tension w L^2 / (8 s)."""
    tight = lissom.statics(cable(SPAN, {"bend_y": 8, "stretch": 1}))
    assert tight.success
    weight = 7850.0 * 9.81
    sag = (3 * weight * SPAN**4 / (64 * 2.1e11)) ** (1 / 3)
    model = cable(SPAN, {"bend_y": 8, "stretch": 1})
    assert -model.pose(tight.q, 0.5 * SPAN)[2, 3] == pytest.approx(sag, rel=0.05)
    slack = lissom.statics(cable(SPAN * (1 + 1e-4), {"bend_y": 8}))
    assert slack.success
    assert "taut" not in slack.message


def test_other_failures_are_not_called_taut():
    free = lissom.Robot([lissom.Link("a", joint=lissom.Free(), body=lissom.Body(1.0, inertia=(1e-3,) * 3))])
    fallen = lissom.statics(free)
    assert not fallen.success
    assert "taut" not in fallen.message
    with pytest.raises(ValueError, match=r"10 m apart, and what joins them is only 9.9 m long"):
        lissom.statics(cable(9.9, {"bend_y": 8}))
    assert np.isfinite(fallen.q).all()
