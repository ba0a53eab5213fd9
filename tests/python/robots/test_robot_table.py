"""The table of robots for the crate's tests agrees with the NumPy reference, and is readable without it."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference import joint
from reference.robot import build
from reference.robot_table import DESCRIPTIONS, PATH, rounded, states, values


@pytest.fixture(scope="module")
def written():
    return json.loads(PATH.read_text(encoding="utf-8"))["robots"]


def test_all_robots_are_written_as_described(written):
    assert {robot["name"]: robot["description"] for robot in written} == DESCRIPTIONS


def compare(actual, desired, place=()):
    """The same keys, and arrays equal to ten digits of their largest number."""
    if isinstance(desired, dict):
        assert actual.keys() == desired.keys(), place
        for key, value in desired.items():
            compare(actual[key], value, (*place, key))
    else:
        size = np.abs(desired).max(initial=0)
        assert_allclose(actual, desired, rtol=0, atol=1e-10 * size + 1e-14, err_msg=str(place))


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_values_are_up_to_date(written, name):
    """`python -m reference.robot_table` updates them."""
    [robot] = [robot for robot in written if robot["name"] == name]
    built = build(robot["description"])
    assert robot["n"] == built.n
    expected = states(built, list(DESCRIPTIONS).index(name))
    for state, triple in zip(robot["states"], expected, strict=True):
        state = dict(state)
        q, v, a = (np.array(state.pop(key)) for key in "qva")
        assert_allclose([q, v, a], triple, rtol=0, atol=1e-15)
        compare(state, values(built, q, v, a))


def test_the_table_has_every_joint_and_rotation_vectors_nearly_as_long_as_pi(written):
    kinds, longest = set(), 0.0
    for robot in written:
        built = build(robot["description"])
        kinds |= {type(link.joint) for link in built.links}
        for state in robot["states"]:
            for link, dofs in zip(built.links, built.joint_dofs, strict=True):
                phi = np.array(state["q"])[dofs][link.joint.rotation_vector]
                longest = max(longest, np.linalg.norm(phi))
    assert kinds == set(joint.Joint.__subclasses__())
    assert 3.09 < longest < np.pi


def test_rounding_keeps_digits_of_the_largest_number():
    assert rounded({"x": [np.array([1.23456789012345678e3, 1e-12])]}) == {"x": [[1234.567890123, 0.0]]}
    assert rounded(np.zeros(2)) == [0.0, 0.0]
