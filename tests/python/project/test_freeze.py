"""The freeze, with which results before and after a change of the source are compared."""

import numpy as np

import freeze

BEFORE = {"a/q": np.array([1.0, 2.0]), "b/q": np.zeros(2), "c/q": np.array([np.nan, 1.0])}
WORDS = {"a/message": "stable"}


def test_the_same_is_no_difference():
    assert (
        freeze.differences(BEFORE, {key: value.copy() for key, value in BEFORE.items()}, WORDS, WORDS, 0.0)
        == {}
    )


def test_differences_are_found_and_measured():
    after = {
        "a/q": np.array([1.0, 2.0 + 2e-9]),
        "b/q": np.array([0.0, 1e-300]),
        "c/q": np.array([0.0, 1.0]),
        "d/q": [],
    }
    found = freeze.differences(BEFORE, after, WORDS, {"a/message": "neutral"}, 1e-12)
    assert found.keys() == {"a/q", "b/q", "c/q", "d/q", "a/message"}
    assert found["b/q"] == np.inf
    assert abs(found["a/q"] - 1e-9) < 1e-14
    # A looser tolerance allows it.
    assert "a/q" not in freeze.differences(BEFORE, after, WORDS, WORDS, 1e-8)


def test_random_robots_leave_the_same_bits_twice():
    first, second = (dict(freeze.of_robots(3)) for _ in range(2))
    numbers = {name for name, value in first.items() if not isinstance(value, str)}
    assert len(numbers) > 20
    assert first.keys() == second.keys()
    for name, value in first.items():
        np.testing.assert_array_equal(value, second[name], name)
