"""Arrays of any layout are passed to Rust correctly, and arrays without real numbers are rejected."""

import array
import datetime
import decimal
import fractions

import numpy as np
import pytest
import scipy.sparse

import lissom

N = 3
WIRE = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": N})
ROD = lissom.Rod([WIRE])
STIFFNESS = np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 5.0]])
VECTOR = np.array([0.25, -0.5, 0.125])
STATES = np.array([[0.25, -0.5, 0.125], [0.5, 0.25, 0.0], [1.0, 0.0, -0.25], [0.0, 0.125, 0.5]])


def packed(x):
    """A column of a record array without padding: a stride of 12 bytes."""
    records = np.zeros(x.shape, dtype=np.dtype([("label", "i4"), ("value", "f8")]))
    records["value"] = x
    records["label"] = -1
    return records["value"]


def unaligned(x):
    buffer = bytearray(x.nbytes + 1)
    found = np.frombuffer(buffer, dtype=np.uint8)[1:].view(np.float64).reshape(x.shape)
    found[...] = x
    assert not found.flags.aligned
    return found


def reversed_in_memory(x):
    return x[::-1].copy()[::-1]


def every_other(x):
    wide = np.full((2 * x.shape[0], *x.shape[1:]), np.nan)
    wide[::2] = x
    return wide[::2]


def in_the_middle(x):
    wide = np.full((*x.shape, 3), np.nan)
    wide[..., 1] = x
    return wide[..., 1]


def read_only(x):
    found = x.copy()
    found.flags.writeable = False
    return found


class Subclass(np.ndarray):
    """Without attributes of its own."""


class Wrapper:
    """An object that NumPy converts to an array."""

    def __init__(self, x):
        self.x = x

    def __array__(self, dtype=None, copy=None):
        return self.x.astype(dtype or self.x.dtype)


LAYOUTS = {
    "packed": packed,
    "unaligned": unaligned,
    "big-endian": lambda x: x.astype(">f8"),
    "unaligned big-endian": lambda x: unaligned(x.astype(">f8").view(np.float64)).view(">f8"),
    "negative strides": reversed_in_memory,
    "strided": every_other,
    "inner strides": in_the_middle,
    "read-only": read_only,
    "Fortran": np.asfortranarray,
    "subclass": lambda x: x.view(Subclass),
    "float32": lambda x: x.astype(np.float32),
    "float16": lambda x: x.astype(np.float16),
    "long double": lambda x: x.astype(np.longdouble),
    "objects": lambda x: x.astype(object),
    "lists": lambda x: x.tolist(),
    "tuples": lambda x: tuple(tuple(row) if x.ndim > 1 else row for row in x.tolist()),
    "NumPy's scalars": lambda x: [list(row) if x.ndim > 1 else row for row in x],
    "fractions": lambda x: np.vectorize(fractions.Fraction, otypes=[object])(x).tolist(),
    "decimals": lambda x: np.vectorize(decimal.Decimal, otypes=[object])(x).tolist(),
    "__array__": Wrapper,
    "memoryview": lambda x: memoryview(x.copy()),
}


def solve(fun, y0=VECTOR, method="radau", **options):
    return lissom.solve_ivp(fun, (0.0, 1.0), y0, method, **options).y


def newmark(value=lambda x: x, jac=False):
    options = (
        {"jac": lambda t, q, v, a: [value(x) for x in (STIFFNESS, 0.25 * STIFFNESS, np.eye(N))]}
        if jac
        else {}
    )
    result = lissom.newmark(
        lambda t, q, v, a: value(a + STIFFNESS @ q), (0.0, 1.0), VECTOR, STATES[1], dt=0.25, **options
    )
    return result.q


def section(name, value):
    given = {"stiffness": np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), "mass": 1.0}
    return lissom.Section.given(**(given | {name: value}), length=0.5).parameters[name]


def of_load(name, value, attribute=None):
    found = getattr(lissom.Load(**{name: value}), attribute or name)
    return found[1] if isinstance(found[0], np.ndarray) else found


def driven(value):
    rod = lissom.Rod([WIRE], loads=[lissom.Load(force=lambda t: value(VECTOR * t))])
    return lissom.simulate(rod, 0.05).q


def shaken(value):
    place = STATES[0] * 2.0**-8
    motion = lissom.BaseMotion(translation=lambda t: [value(x) for x in (place, 0.0 * place, 0.0 * place)])
    return lissom.Rod([WIRE], base_motion=motion).pose(VECTOR, 0.25, t=0.5)


def profile_of(value, name):
    stations = {"stations": np.array([0.0, 0.25, 0.5, 1.0]), "values": STATES}
    profile = lissom.Profile(1.0, **(stations | {name: value}))
    return profile(np.linspace(0.0, 1.0, 7))


def strained(value):
    strain = np.array([0.0, 0.5, 0.0, 1.0, 0.0, 0.0])
    segment = lissom.Segment(
        0.5, 1e-3, 2e11, 8e10, 7800, {"bend_y": 2}, reference_strain=lambda X: value(strain * (1 + X))
    )
    return segment.reference_strain([0.0, 0.25, 0.5])


#: Every function that takes an array: plain numbers, and the result for them.
PLACES = {
    "root, x0": (VECTOR, lambda x: lissom.root(lambda y: y**3 - VECTOR, x).x),
    "root, x_scale": (2.0 + VECTOR, lambda x: lissom.root(lambda y: y**3 - VECTOR, VECTOR, x_scale=x).x),
    "root, f_scale": (2.0 + VECTOR, lambda x: lissom.root(lambda y: y**3 - VECTOR, VECTOR, f_scale=x).x),
    "jacobian, x": (VECTOR, lambda x: lissom.jacobian(lambda y: y**2, x)),
    "check_jacobian, x": (
        VECTOR,
        lambda x: lissom.check_jacobian(lambda y: y**2, lambda y: np.diag(2 * y), x).given,
    ),
    "solve_ivp, y0": (VECTOR, lambda x: solve(lambda t, y: -STIFFNESS @ y, x)),
    "solve_ivp, t_span": (np.array([0.0, 1.0]), lambda x: lissom.solve_ivp(lambda t, y: -y, x, VECTOR).y),
    "solve_ivp, t_eval": (
        np.array([0.0, 0.25, 0.5]),
        lambda x: solve(lambda t, y: -STIFFNESS @ y, t_eval=x),
    ),
    "solve_ivp, atol": (2.0**-20 * (1 + VECTOR**2), lambda x: solve(lambda t, y: -STIFFNESS @ y, atol=x)),
    "solve_ivp, jac": (-STIFFNESS, lambda x: solve(lambda t, y: -STIFFNESS @ y, jac=x)),
    "solve_ivp, jac_sparsity": (STIFFNESS, lambda x: solve(lambda t, y: -STIFFNESS @ y, jac_sparsity=x)),
    "DenseOutput, t": (
        np.array([0.0, 0.25, 0.5]),
        lambda x: lissom.solve_ivp(lambda t, y: -y, (0, 1), VECTOR, dense_output=True).sol(x),
    ),
    "RK45, y0": (VECTOR, lambda x: lissom.RK45(lambda t, y: -y, 0.0, x, 1.0).y),
    "newmark, q0": (VECTOR, lambda x: lissom.newmark(lambda t, q, v, a: a + q, (0, 1), x, VECTOR, dt=0.25).q),
    "newmark, v0": (VECTOR, lambda x: lissom.newmark(lambda t, q, v, a: a + q, (0, 1), VECTOR, x, dt=0.25).q),
    "newmark, a0": (
        VECTOR,
        lambda x: lissom.newmark(lambda t, q, v, a: a + q, (0, 1), VECTOR, VECTOR, a0=x, dt=0.25).q,
    ),
    "simulate, q0": (VECTOR, lambda x: lissom.simulate(ROD, 0.03, q0=x).q),
    "simulate, v0": (VECTOR, lambda x: lissom.simulate(ROD, 0.03, v0=x).q),
    "simulate, t_eval": (np.array([0.0, 2.0**-7, 2.0**-6]), lambda x: lissom.simulate(ROD, 0.03, t_eval=x).q),
    "simulate, rtol": (2.0**-16 * (1 + VECTOR**2), lambda x: lissom.simulate(ROD, 0.03, rtol=x).q),
    "statics, q0": (VECTOR, lambda x: lissom.statics(ROD, x).q),
    "statics, load_steps": (
        np.array([0.25, 0.5, 1.0]),
        lambda x: lissom.statics(ROD, load_steps=x).path.load_factor,
    ),
    "continuation, q0": (VECTOR * 2.0**-9, lambda x: lissom.continuation(ROD, x).path.q),
    "continuation, bounds": (np.array([0.0, 0.5]), lambda x: lissom.continuation(ROD, bounds=x).path.q),
    "modes, q": (VECTOR, lambda x: lissom.modes(ROD, x).frequency),
    "mass_matrix": (VECTOR, ROD.mass_matrix),
    "inverse_dynamics": (VECTOR, lambda x: ROD.inverse_dynamics(x, x, x)),
    "forward_dynamics": (VECTOR, lambda x: ROD.forward_dynamics(x, x)),
    "tangent": (VECTOR, lambda x: ROD.tangent(x, x, x)[0]),
    "energy": (VECTOR, lambda x: ROD.energy(x, x).total),
    "supplied_power": (VECTOR, lambda x: ROD.supplied_power(x, x, x)),
    "dissipated_power": (VECTOR, lambda x: ROD.dissipated_power(x, x)),
    "pose, q": (VECTOR, lambda x: ROD.pose(x, 0.25)),
    "pose, states": (STATES, lambda x: ROD.pose(x, 0.25)),
    "pose, X": (np.array([0.0, 0.25, 0.375]), lambda x: ROD.pose(VECTOR, x)),
    "pose, t": (np.array([0.0, 0.25, 0.5, 1.0]), lambda x: ROD.pose(STATES, 0.25, t=x)),
    "jacobian": (VECTOR, lambda x: ROD.jacobian(x, 0.25)),
    "velocity": (VECTOR, lambda x: ROD.velocity(x, x, 0.25)),
    "base_wrench": (VECTOR, lambda x: ROD.base_wrench(x, x, x)),
    "Rod, base_position": (VECTOR, lambda x: lissom.Rod([WIRE], base_position=x).base_position),
    "Rod, gravity": (VECTOR, lambda x: lissom.Rod([WIRE], gravity=x).gravity),
    "Rod, tip_force": (VECTOR, lambda x: lissom.Rod([WIRE], tip_force=x).tip_force),
    "Rod, base_orientation": (
        np.array([0.5, 0.5, 0.5, 0.5]),
        lambda x: lissom.Rod([WIRE], base_orientation=x).base_orientation,
    ),
    "Segment, reference_strain": (
        np.array([0.0, 0.5, 0.0, 1.0, 0.0, 0.0]),
        lambda x: (
            lissom.Segment(1.0, 1e-3, 2e11, 8e10, 7800, {"bend_y": 1}, reference_strain=x).reference_strain
        ),
    ),
    "Segment, radius": (np.array([0.5, 0.25]), lambda x: lissom.Section.circle(x).parameters["radius"]),
    "Segment, shear_correction": (
        np.array([0.5, 0.75]),
        lambda x: (
            lissom.Segment(1.0, 1e-3, 2e11, 8e10, 7800, {"bend_y": 1}, shear_correction=x).shear_correction
        ),
    ),
    "Section.given, stiffness": (np.diag([4.0, 2.0, 3.0, 4.0, 5.0, 6.0]), lambda x: section("stiffness", x)),
    "Section.given, diagonal": (np.array([4.0, 2.0, 3.0, 4.0, 5.0, 6.0]), lambda x: section("stiffness", x)),
    "Section.given, inertia": (np.diag([2.0, 1.0, 1.0]), lambda x: section("inertia", x)),
    "Section.given, centre": (np.array([0.5, 0.25]), lambda x: section("centre", x)),
    "Profile, stations": (np.array([0.0, 0.25, 0.5, 1.0]), lambda x: profile_of(x, "stations")),
    "Profile, values": (STATES, lambda x: profile_of(x, "values")),
    "Profile, coefficients": (STATES, lambda x: lissom.Profile(1.0, coefficients=x).coefficients),
    "Profile, X": (np.array([0.0, 0.25]), lissom.Profile(1.0, coefficients=STATES)),
    "Load, force": (VECTOR, lambda x: of_load("force", x)),
    "Load, moment": (VECTOR, lambda x: of_load("moment", x)),
    "Load, along": (np.array([0.0, 0.25]), lambda x: lissom.Load(force=VECTOR, along=x).along),
    "Load, table": (STATES[:2], lambda x: of_load("force", ([0.0, 1.0], x))),
    "Load, times": (np.array([0.0, 0.5]), lambda x: lissom.Load(force=(x, STATES[:2])).force[0]),
    "Harmonic": (VECTOR, lambda x: lissom.Harmonic(x, 2.0, mean=x, rate=x).amplitude),
    "BaseMotion, axis": (VECTOR, lambda x: lissom.BaseMotion(axis=x, angle=lissom.Harmonic(1.0, 1.0)).axis),
    "BaseMotion, translation": (
        STATES,
        lambda x: lissom.BaseMotion(translation=([0.0, 1.0, 2.0, 3.0], x)).translation[1],
    ),
    "Body, centre": (VECTOR, lambda x: lissom.Body(1.0, centre=x).centre),
    "Body, inertia": (STIFFNESS, lambda x: lissom.Body(1.0, inertia=x).inertia),
    "Support, stiffness": (1.0 + VECTOR, lambda x: lissom.Support(stiffness=x).stiffness),
    "Support, position": (VECTOR, lambda x: lissom.Support(stiffness=1.0, position=x).position),
    "Support, orientation": (
        np.array([0.5, 0.5, 0.5, 0.5]),
        lambda x: lissom.Support(stiffness=1.0, orientation=x).orientation,
    ),
    "Fluid, velocity": (VECTOR, lambda x: lissom.Fluid(1e3, x).velocity),
    "Fluid, viscous_drag": (np.array([0.5, 0.25]), lambda x: lissom.Fluid(1e3, viscous_drag=x).viscous_drag),
    "Balance": (
        VECTOR**2,
        lambda x: lissom.Balance(kinetic=x, elastic=x, gravitational=x, loads=x, dissipated=x, work=x).total,
    ),
    "linearise, q": (lissom.statics(ROD).q.round(6), lambda x: lissom.linearise(ROD, np.asarray(x, float)).A),
}

#: Every user function that returns arrays: a result for a function that wraps these.
CALLBACKS = {
    "root, fun": lambda wrap: lissom.root(lambda y: wrap(STIFFNESS @ y - VECTOR), VECTOR).x,
    "root, jac": lambda wrap: (
        lissom.root(lambda y: STIFFNESS @ y - VECTOR, VECTOR, jac=lambda y: wrap(STIFFNESS)).x
    ),
    "jacobian, fun": lambda wrap: lissom.jacobian(lambda y: wrap(np.round(y * 2**20) / 2**20), VECTOR),
    "check_jacobian, jac": lambda wrap: (
        lissom.check_jacobian(
            lambda y: STIFFNESS @ y, lambda y: wrap(STIFFNESS + np.eye(N)), VECTOR
        ).relative_difference
    ),
    "solve_ivp, fun": lambda wrap: solve(lambda t, y: wrap(VECTOR * (t > 0.5)), method="rk45"),
    "solve_ivp, vectorized": lambda wrap: solve(
        lambda t, y: wrap(np.repeat(VECTOR[:, None], y.shape[1], axis=1)), vectorized=True
    ),
    "solve_ivp, jac": lambda wrap: solve(lambda t, y: -STIFFNESS @ y, jac=lambda t, y: wrap(-STIFFNESS)),
    "newmark, residual": lambda wrap: newmark(lambda x: wrap(np.round(x * 2.0**6) / 2.0**6)),
    "newmark, jac": lambda wrap: (
        lissom.newmark(
            lambda t, q, v, a: a + STIFFNESS @ q,
            (0.0, 1.0),
            VECTOR,
            STATES[1],
            dt=0.25,
            jac=lambda t, q, v, a: [wrap(x) for x in (STIFFNESS, np.zeros((N, N)), np.eye(N))],
        ).q
    ),
    "Load, force": driven,
    "BaseMotion, translation": shaken,
    "Segment, reference_strain": strained,
}

#: The arguments of these functions are exact in half precision; their results are not.
ROUNDED = {"float16", "float32"}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("place", PLACES)
def test_arguments_are_read_right_from_every_layout(place, layout):
    plain, make = PLACES[place]
    if layout == "float16" and not np.array_equal(plain.astype(np.float16), plain):
        pytest.skip("half precision does not have these numbers")
    if layout == "float32" and not np.array_equal(plain.astype(np.float32), plain):
        plain = plain.astype(np.float32).astype(np.float64)
    if place == "linearise, q" and layout == "memoryview":
        pytest.skip("read by NumPy")
    found = make(LAYOUTS[layout](plain))
    np.testing.assert_array_equal(found, make(plain))


@pytest.mark.parametrize("layout", sorted(LAYOUTS.keys() - ROUNDED))
@pytest.mark.parametrize("place", CALLBACKS)
def test_what_functions_return_is_read_right_from_every_layout(place, layout):
    make = CALLBACKS[place]
    np.testing.assert_array_equal(make(LAYOUTS[layout]), make(lambda x: x))


def test_arrays_without_strides():
    """NumPy broadcasts with zero strides."""
    broadcast = np.broadcast_to(np.float64(0.25), (N,))
    np.testing.assert_array_equal(ROD.mass_matrix(broadcast), ROD.mass_matrix([0.25] * N))
    rows = np.broadcast_to(VECTOR, (4, N))
    np.testing.assert_array_equal(ROD.pose(rows, 0.25), ROD.pose(rows.copy(), 0.25))
    found = lissom.solve_ivp(lambda t, y: broadcast, (0.0, 1.0), VECTOR)
    np.testing.assert_allclose(found.y[:, -1], VECTOR + 0.25, rtol=1e-12)


@pytest.mark.parametrize("dtype", ["i1", "i4", "i8", "u1", "u8", ">i4"])
def test_integers_are_numbers(dtype):
    np.testing.assert_array_equal(
        ROD.mass_matrix(np.array([1, 0, 1], dtype)), ROD.mass_matrix([1.0, 0.0, 1.0])
    )
    assert lissom.Rod([WIRE], gravity=np.array([1, 2, 3], dtype)).gravity == (1.0, 2.0, 3.0)


def test_other_sequences_are_arrays():
    expected = ROD.mass_matrix([0.0, 1.0, 2.0])
    for value in (range(N), array.array("d", range(N)), array.array("i", range(N))):
        np.testing.assert_array_equal(ROD.mass_matrix(value), expected)
    assert ROD.mass_matrix([10**25, 0, 0]).shape == (N, N)


def test_arrays_of_one_entry_are_no_numbers():
    """They keep their dimension, and do not stand for all three axes."""
    assert ROD.pose(VECTOR, [0.25]).shape == (1, 4, 4)
    assert ROD.pose(VECTOR, np.array([0.25])).shape == (1, 4, 4)
    assert ROD.pose(VECTOR, np.array(0.25)).shape == (4, 4)
    assert lissom.Support(stiffness=np.array(2.0)).stiffness == (2.0, 2.0, 2.0)
    with pytest.raises(ValueError, match="stiffness: expected 3 values, got 1"):
        lissom.Support(stiffness=np.array([2.0]))


MASKED = np.ma.masked_array(VECTOR, [False, True, False])
NOT_NUMBERS = {
    "masked": (MASKED, r"got a masked array of shape \(3,\)"),
    "nothing masked": (np.ma.masked_array(VECTOR), "got a masked array"),
    "masked entry": ([0.0, np.ma.masked, 0.0], r"\[1\]: expected a real number, got a masked array"),
    "rows of which one is masked": ([VECTOR, MASKED, VECTOR], r"\[1\]: expected a real number, got a masked"),
    "None": (None, "got NoneType"),
    "None within": ([0.0, None, 0.0], r"\[1\]: expected a real number, got None"),
    "objects": (np.array([0.0, 1.0, None]), r"\[2\]: expected a real number, got None"),
    "booleans": (np.array([True, False, True]), "got an array .* dtype bool"),
    "boolean within": ([0.0, 1.0, True], r"\[2\]: expected a real number, got True"),
    "NumPy's boolean within": ([0.0, np.False_, 1.0], r"\[1\]: expected a real number, got "),
    "text": ("123", "got str"),
    "texts": (["1", "2", "3"], r"\[0\]: expected a real number, got '1'"),
    "array of texts": (np.array(["1", "2", "3"]), "dtype <U1"),
    "bytes": (b"123", "got bytes"),
    "dates": (np.array(["2020-01-01"] * 3, dtype="M8[s]"), "dtype datetime64"),
    "durations": (np.array([1, 2, 3], dtype="m8[s]"), "dtype timedelta64"),
    "duration within": ([0.0, 1.0, np.timedelta64(1, "s")], r"\[2\]: expected a real number"),
    "date within": ([0.0, 1.0, datetime.date(2020, 1, 1)], r"\[2\]: expected a real number"),
    "complex": (VECTOR + 1j, "dtype complex128"),
    "complex without imaginary parts": (VECTOR.astype(complex), "dtype complex128"),
    "complex within": ([0.0, 1.0, 2.0 + 0j], r"\[2\]: expected a real number, got \(2\+0j\)"),
    "records": (np.zeros(3, dtype=[("x", "f8")]), "dtype"),
    "set": ({0.0, 1.0, 2.0}, "got set"),
    "dict": ({0: 1.0}, "got dict"),
    "generator": ((x for x in VECTOR), "got generator"),
    "ragged": ([[0.0, 1.0], [2.0]], "got list"),
}


def endless():
    nested = []
    nested.append(nested)
    return nested


@pytest.mark.parametrize("kind", NOT_NUMBERS)
def test_what_is_no_array_of_real_numbers_is_refused_with_its_place(kind):
    value, message = NOT_NUMBERS[kind]
    functions = {
        "q": lambda: ROD.mass_matrix(value),
        "x0": lambda: lissom.root(lambda x: x, value),
        "y0": lambda: lissom.solve_ivp(lambda t, y: y, (0.0, 1.0), value),
        "fun": lambda: lissom.solve_ivp(lambda t, y: value, (0.0, 1.0), VECTOR),
        "residual": lambda: lissom.newmark(lambda t, q, v, a: value, (0.0, 1.0), VECTOR, VECTOR, dt=0.1),
        "force": lambda: lissom.simulate(lissom.Rod([WIRE], loads=[lissom.Load(force=lambda t: value)]), 0.1),
    }
    for name, function in functions.items():
        if value is None and name in ("fun", "residual", "force"):
            expected = "returned None"
        elif name == "y0" and "complex" in kind:
            expected = "complex states are not supported"
        else:
            expected = message
        with pytest.raises(TypeError, match=f"{name}.*{expected}"):
            function()


def test_vectors_are_asked_for_with_their_length():
    with pytest.raises(
        TypeError,
        match=r"^gravity: expected a one-dimensional array of 3 real numbers, got float; along z it is "
        r"\(0, 0, -9.81\)$",
    ):
        lissom.Rod([WIRE], gravity=9.81)
    with pytest.raises(
        TypeError,
        match=r"^inertia: expected shape \(3,\) or \(3, 3\), got float; equal ones are \(0.00001,\) \* 3$",
    ):
        lissom.Body(0.1, inertia=1e-5)
    with pytest.raises(ValueError, match=r"^gravity: expected 3 values, got 1$"):
        lissom.Rod([WIRE], gravity=[9.81])


def test_lists_that_contain_themselves_are_refused():
    with pytest.raises(TypeError, match="q: expected a one-dimensional array"):
        ROD.mass_matrix(endless())
    with pytest.raises(TypeError, match="got list"):
        ROD.pose(endless(), 0.25)


@pytest.mark.parametrize(
    "value",
    [True, np.True_, "1", None, 1j, np.timedelta64(1, "s"), np.ma.masked, np.array([1.0]), [1.0]],
    ids=repr,
)
def test_numbers_are_no_booleans_and_the_like(value):
    calls = [
        lambda: lissom.Body(value),
        lambda: lissom.Rod([WIRE], tip_mass=value),
        lambda: lissom.simulate(ROD, value),
        lambda: lissom.Segment(value, 1e-3, 2e11, 8e10, 7800, {"bend_y": N}),
        lambda: lissom.newmark(lambda t, q, v, a: a, (0, 1), [0.0], [0.0], dt=value),
        lambda: lissom.Fluid(value),
        lambda: lissom.SpringPendulum(value),
    ]
    if value is not None:  # The tip.
        calls.append(lambda: ROD.jacobian(VECTOR, value))
    for call in calls:
        with pytest.raises(TypeError, match=r"^\w+: expected a real number, got "):
            call()


@pytest.mark.parametrize("value", [10**400, -(10**400), fractions.Fraction(10**400, 3)])
def test_numbers_that_no_double_can_hold_are_refused_with_their_place(value):
    calls = {
        "mass": lambda: lissom.Body(value),
        "t_end": lambda: lissom.simulate(ROD, value),
        "X": lambda: ROD.jacobian(VECTOR, value),
        "frequency": lambda: lissom.Harmonic(1.0, value),
        "radius": lambda: lissom.Sphere((0, 0, 0), value),
        "stiffness": lambda: lissom.Revolute((0, 1, 0), stiffness=value),
        "tension": lambda: lissom.Tendon("t", [lissom.Along(offset=(0, 0.01))], tension=value),
    }
    if isinstance(value, int):
        calls[r"q\[1\]"] = lambda: ROD.energy([0.0, value, *VECTOR[2:]], VECTOR)
        calls[r"gravity\[2\]"] = lambda: lissom.Rod([WIRE], gravity=(0, 0, value))
    for name, call in calls.items():
        with pytest.raises(ValueError, match=f"{name}: got a number beyond 1.8e308"):
            call()


@pytest.mark.parametrize("value", [2**63, 2**70, -(10**400), np.uint64(2**63)])
def test_whole_numbers_beyond_64_bits_are_refused_by_name(value):
    calls = {
        "max_steps": lambda: lissom.simulate(ROD, 1.0, max_steps=value),
        "nodes": lambda: lissom.Segment(0.1, 1e-3, 2e11, 8e10, 7800, {"bend_y": N}, nodes=value),
        "workers": lambda: lissom.simulate_many(ROD, 1.0, q0=np.zeros((2, ROD.n)), workers=value),
        "max_iter": lambda: lissom.root(lambda x: x, [1.0], max_iter=value),
        "load_steps": lambda: lissom.statics(ROD, load_steps=value),
    }
    for name, call in calls.items():
        with pytest.raises(ValueError, match=f"{name}: got a number beyond 2\\^63"):
            call()


def test_numbers_may_be_of_any_real_type():
    for value in (
        2,
        2.0,
        np.float32(2.0),
        np.int8(2),
        np.array(2),
        fractions.Fraction(4, 2),
        decimal.Decimal(2),
    ):
        assert lissom.Body(value).mass == 2.0
    assert lissom.simulate(ROD, 0.02, max_step=None).success


def test_patterns_may_be_truth_values():
    pattern = STIFFNESS != 0.0
    expected = solve(lambda t, y: -STIFFNESS @ y, jac_sparsity=STIFFNESS)
    for value in (pattern, pattern.tolist(), scipy.sparse.csr_matrix(pattern)):
        np.testing.assert_array_equal(solve(lambda t, y: -STIFFNESS @ y, jac_sparsity=value), expected)


def test_exceptions_of_conversions_come_through():
    class Stubborn:
        def __array__(self, dtype=None, copy=None):
            raise RuntimeError("not now")

    with pytest.raises(RuntimeError, match="not now"):
        ROD.mass_matrix(Stubborn())


def test_profiles_have_at_least_one_number_in_a_row():
    for options in (
        {"stations": [0.0, 1.0], "values": np.zeros((2, 0))},
        {"stations": [0.0, 0.0, np.nan], "values": np.zeros((3, 2, 0))},
        {"coefficients": np.zeros((3, 0))},
    ):
        with pytest.raises(ValueError, match="expected at least one number in a row"):
            lissom.Profile(1.0, **options)


# ------------------------------------------------------------------------- results that overflow are rejected

HUGE = [1e300, -1e300]


@pytest.mark.parametrize(
    "ask",
    [
        lambda rod: rod.inverse_dynamics(HUGE, HUGE, HUGE),
        lambda rod: rod.tangent(HUGE, HUGE, HUGE),
        lambda rod: rod.energy(HUGE, HUGE),
        lambda rod: rod.base_wrench(HUGE, HUGE, HUGE),
    ],
    ids=["inverse_dynamics", "tangent", "energy", "base_wrench"],
)
def test_numbers_that_overflow_are_no_result(ask):
    rod = lissom.Rod([lissom.Segment(1.0, 1e-2, 1e9, 4e8, 1000, modes={"bend_y": 2}, retardation_time=1e-3)])
    with pytest.raises(lissom.LissomError, match="the result is NaN or infinite"):
        ask(rod)


@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_functions_without_values_have_no_jacobian(value):
    with pytest.raises(ValueError, match="fun: component 0 is NaN or infinite"):
        lissom.jacobian(lambda x: [value, x[0]], [1.0])


@pytest.mark.parametrize("poisson_ratio", [-1.0, 0.6, np.inf])
def test_poisson_ratios_of_no_material(poisson_ratio):
    with pytest.raises(ValueError, match=r"poisson_ratio: got .*, expected a number above -1 and up to 0.5"):
        lissom.Section.circle(1e-2).cowper(poisson_ratio)
