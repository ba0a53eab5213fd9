"""lissom.SpringPendulum: Newton's law in Cartesian coordinates, and the common interface of models."""

import copy
import inspect
import pickle
import re
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom
from reference import pendulum as reference

PARAMETERS = {"length": 1.3, "mass": 0.7, "stiffness": 22.0, "gravity": 9.81}

bounded = st.floats(-5.0, 5.0)
angles = st.tuples(st.floats(-7.0, 7.0), st.floats(-0.5, 2.0)).map(np.array)
pairs = st.tuples(bounded, bounded).map(np.array)


def test_defaults_are_the_lab_pendulum():
    pendulum = lissom.SpringPendulum()
    assert (pendulum.length, pendulum.mass, pendulum.stiffness, pendulum.gravity) == (1.0, 1.0, 10.0, 9.81)
    assert pendulum.n == 2
    assert isinstance(pendulum, lissom.Model)
    q, qd, qdd = (-0.7, 0.5), (0.3, -0.2), (1.0, 2.0)
    expected = reference.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(pendulum.inverse_dynamics(q, qd, qdd), expected, rtol=1e-9)


@given(q=angles, qd=pairs, qdd=pairs)
@settings(deadline=None, max_examples=100)
def test_inverse_dynamics_and_energy(q, qd, qdd):
    pendulum = lissom.SpringPendulum(**PARAMETERS)
    expected = reference.inverse_dynamics(q, qd, qdd, **PARAMETERS)
    np.testing.assert_allclose(pendulum.inverse_dynamics(q, qd, qdd), expected, rtol=1e-7, atol=1e-7)
    energy = pendulum.energy(q, qd)
    found = (energy.kinetic, energy.elastic, energy.gravitational)
    np.testing.assert_allclose(found, reference.energy(q, qd, **PARAMETERS), rtol=1e-12, atol=1e-12)
    assert energy.loads == 0.0
    assert energy.total == pytest.approx(sum(found), rel=1e-14, abs=1e-14)


@given(q=angles, qd=pairs, qdd=pairs)
@settings(deadline=None, max_examples=50)
def test_tangent_mass_matrix_and_forward_dynamics(q, qd, qdd):
    pendulum = lissom.SpringPendulum(**PARAMETERS)

    def column(which, j):
        step = 1e-5
        shifted = []
        for sign in (1.0, -1.0):
            state = [q.copy(), qd.copy(), qdd.copy()]
            state[which][j] += sign * step
            shifted.append(reference.inverse_dynamics(*state, **PARAMETERS))
        return (shifted[0] - shifted[1]) / (2 * step)

    tangents = pendulum.tangent(q, qd, qdd)
    for which, tangent in enumerate(tangents):
        assert tangent.shape == (2, 2)
        expected = np.column_stack([column(which, j) for j in range(2)])
        np.testing.assert_allclose(tangent, expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(pendulum.mass_matrix(q), tangents[2], rtol=1e-14, atol=1e-300)
    free = pendulum.forward_dynamics(q, qd)
    np.testing.assert_allclose(reference.inverse_dynamics(q, qd, free, **PARAMETERS), 0.0, atol=1e-6)


@pytest.mark.parametrize(
    "make",
    [
        list,
        tuple,
        np.array,
        lambda x: np.array(x, dtype=np.float32),
        lambda x: np.array([x[0], 9.0, x[1], 9.0])[::2],
        lambda x: np.array(x, dtype=">f8"),
    ],
    ids=["list", "tuple", "array", "float32", "strided", "big-endian"],
)
def test_anything_array_like_is_taken(make):
    pendulum = lissom.SpringPendulum()
    expected = pendulum.inverse_dynamics([0.5, 0.25], [1.0, 2.0], [-1.0, 0.125])
    found = pendulum.inverse_dynamics(make([0.5, 0.25]), make([1.0, 2.0]), make([-1.0, 0.125]))
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, expected)


def test_integers_and_read_only_arrays_are_taken():
    pendulum = lissom.SpringPendulum()
    q = np.array([0, 1])
    q.flags.writeable = False
    np.testing.assert_array_equal(pendulum.mass_matrix(q), [[4.0, 0.0], [0.0, 1.0]])


def test_bad_arrays_are_refused_by_name():
    pendulum = lissom.SpringPendulum()
    good = [0.0, 0.0]
    with pytest.raises(ValueError, match="qd: expected 2 values, got 3"):
        pendulum.inverse_dynamics(good, [0.0] * 3, good)
    with pytest.raises(ValueError, match=r"qdd\[1\]: got NaN"):
        pendulum.inverse_dynamics(good, good, [0.0, np.nan])
    with pytest.raises(ValueError, match=r"q\[0\]: got inf"):
        pendulum.energy([np.inf, 0.0], good)
    with pytest.raises(TypeError, match="q: expected a one-dimensional array"):
        pendulum.mass_matrix("angle")
    with pytest.raises(TypeError, match="q: expected a one-dimensional array"):
        pendulum.mass_matrix(np.zeros((2, 1)))
    with pytest.raises(TypeError):
        pendulum.mass_matrix(np.zeros(2, dtype=complex))


def test_bad_parameters_are_refused_all_at_once():
    with pytest.raises(ValueError, match=r"length: got -1[^$]*mass: got NaN") as caught:
        lissom.SpringPendulum(length=-1.0, mass=float("nan"))
    assert "metres" in str(caught.value)
    with pytest.raises(TypeError):
        lissom.SpringPendulum(length="long")


def test_a_singular_mass_matrix_is_reported():
    with pytest.raises(lissom.LissomError, match="not positive definite"):
        lissom.SpringPendulum().forward_dynamics([0.0, -1.0], [0.0, 0.0])


def test_copies_repr_and_help():
    pendulum = lissom.SpringPendulum(**PARAMETERS)
    assert repr(pendulum) == "SpringPendulum(length=1.3, mass=0.7, stiffness=22.0, gravity=9.81)"
    for other in (copy.deepcopy(pendulum), pickle.loads(pickle.dumps(pendulum))):
        assert type(other) is lissom.SpringPendulum
        assert repr(other) == repr(pendulum)
        assert other.mass_matrix([0.0, 0.0])[1, 1] == 0.7
    signature = str(inspect.signature(lissom.SpringPendulum))
    assert "length=1.0, mass=1.0, stiffness=10.0, gravity=9.81" in signature
    assert "radians" in inspect.getdoc(lissom.SpringPendulum)
    assert "zero in free motion" in inspect.getdoc(lissom.SpringPendulum.inverse_dynamics)
    assert repr(pendulum.energy([0.0, 0.0], [0.0, 0.0])).startswith("Energy(kinetic=0.0")


def test_models_and_energies_are_immutable_and_shared_between_threads():
    pendulum = lissom.SpringPendulum()
    with pytest.raises(AttributeError):
        pendulum.length = 2.0
    with pytest.raises(TypeError):
        lissom.Model()
    results = []

    def work(k):
        q = np.array([0.1 * k, 0.2])
        expected = lissom.SpringPendulum().inverse_dynamics(q, q, q)
        results.append(all((pendulum.inverse_dynamics(q, q, q) == expected).all() for _ in range(500)))

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True] * 4


def test_starts_beyond_the_hinge_are_refused():
    pendulum, q0 = lissom.SpringPendulum(), [-0.785, -1.5]
    refused = r"q0\[1\]: got -1.5, expected an elongation of at least -1 m, where the spring has no length"
    with pytest.raises(ValueError, match=refused):
        lissom.simulate(pendulum, 1.0, q0=q0)
    with pytest.raises(ValueError, match=refused):
        lissom.simulate_many(pendulum, 1.0, q0=[q0])
    with pytest.raises(ValueError, match=r"q\[1\]: got -1"):
        pendulum.check_shape(q0)


def test_displacements_beyond_the_length_have_no_percentages():
    """What vibrates with an amplitude of eight lengths: linear vibrations would be of 120."""
    with pytest.warns(lissom.AccuracyWarning, match="moves the tip by more than the length"):
        found = lissom.simulate(lissom.SpringPendulum(), 10.0, q0=[0.0, 3.0], dt=1e-2)
    assert all(float(number) <= 100.0 for number in re.findall(r"([0-9.]+) %", found.doubt))
