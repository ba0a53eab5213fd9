"""Input that `lissom.Segment` and `lissom.Rod` reject, with messages, and unusual input that they accept.

The first tests show valid input; every later test varies one part of it.
"""

import inspect
import pickle

import numpy as np
import pytest

import lissom

SEGMENT = {
    "length": 0.5,
    "radius": 0.01,
    "young_modulus": 1e6,
    "shear_modulus": 4e5,
    "density": 1000.0,
    "modes": {"bend_y": 2, "torsion": 1},
}


def segment(**changes):
    return lissom.Segment(**(SEGMENT | changes))


def rod(**arguments):
    return lissom.Rod([segment()], **arguments)


def test_what_is_right_is_taken():
    assert rod().n == 3
    assert lissom.Rod((segment(), segment())).n == 6
    assert lissom.Rod(iter([segment()])).n == 3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"length": 0.0}, r"length: got 0.*> 0.*metres"),
        ({"length": -2.5}, r"length: got -2\.5"),
        ({"length": float("nan")}, r"length: got NaN"),
        ({"length": float("inf")}, r"length: got inf"),
        ({"radius": -0.01}, r"radius.*-0\.01"),
        ({"radius": (0.01, 0.0)}, r"radius\[1\]: got 0"),
        ({"young_modulus": 0.0}, r"young_modulus: got 0"),
        ({"shear_modulus": -1.0}, r"shear_modulus: got -1"),
        ({"shear_modulus": 3e5}, r"shear_modulus.*Poisson.*0\.6667.*\(-1, 0\.5\]"),
        ({"density": 0.0}, r"density: got 0.*kg/m\^3"),
        ({"retardation_time": -1e-3}, r"retardation_time: got -0\.001.*>= 0.*seconds"),
        ({"reference_strain": (0, 0, 0, 0, 0, 0)}, r"reference_strain\[3\]: got 0"),
        ({"reference_strain": (0, np.nan, 0, 1, 0, 0)}, r"reference_strain.*NaN"),
        ({"reference_strain": (0, 0, 0, 1, 0)}, r"reference_strain: expected 6 values, got 5"),
        ({"shear_correction": 0.0}, r"shear_correction: got 0"),
        ({"nodes": -1}, r"nodes: got -1, expected an integer >= 0"),
        ({"nodes": 0}, r"nodes: got 0.*between 1 and 256"),
        ({"nodes": 257}, r"nodes: got 257.*between 1 and 256"),
        ({"modes": {"bendy": 1}}, r"bendy.*bend_y"),
        ({"modes": {"bend_y": -1}}, r"bend_y.*-1.*>= 0"),
        ({"modes": {"bend_y": 1.5}}, r"bend_y.*1\.5"),
        ({"modes": {"bend_y": True}}, r"bend_y.*got True, expected a whole number >= 0"),
        ({"modes": {"bend_y": 65}}, r"bend_y.*65.*at most 64"),
        ({"modes": {"bend_y": 10**30}}, r"bend_y.*10"),
    ],
)
def test_impossible_segments(changes, message):
    with pytest.raises(ValueError, match=message):
        segment(**changes)


def test_everything_wrong_is_said_at_once():
    with pytest.raises(ValueError, match=r"length") as caught:
        segment(length=-1.0, density=np.nan, retardation_time=-1.0)
    assert all(name in str(caught.value) for name in ("length", "density", "retardation_time"))


@pytest.mark.parametrize(
    "changes",
    [
        {"length": "1 m"},
        {"length": None},
        {"radius": "thin"},
        {"modes": 3},
        {"modes": [("bend_y", 3)]},
        {"reference_strain": "straight"},
    ],
)
def test_wrong_types_of_segment_arguments(changes):
    with pytest.raises(TypeError, match=next(iter(changes))):
        segment(**changes)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"base_position": (0, 0)}, r"base_position: expected 3 values, got 2"),
        ({"base_position": (0, 0, np.nan)}, r"base_position.*NaN"),
        ({"base_orientation": (0, 0, 0, 0)}, r"base_orientation.*norm"),
        ({"base_orientation": (1, 1, 0, 0)}, r"base_orientation.*norm"),
        ({"base_orientation": (1, 0, 0)}, r"base_orientation: expected 4 values, got 3"),
        ({"gravity": (0, 0, np.inf)}, r"gravity.*inf"),
        ({"tip_force": (1, 2, 3, 4)}, r"tip_force: expected 3 values, got 4"),
        ({"tip_moment": (np.nan, 0, 0)}, r"tip_moment.*NaN"),
        ({"tip_mass": -0.1}, r"tip_mass: got -0\.1"),
    ],
)
def test_impossible_rods(arguments, message):
    with pytest.raises(ValueError, match=message):
        rod(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, r"force: got neither force nor moment"),
        ({"force": (0, 0)}, r"force: expected 3 values, got 2"),
        ({"moment": (0, 0, np.nan)}, r"moment\[2\]: got NaN"),
        ({"force": (0, 0, 1), "at": -0.1}, r"at: got -0\.1.*arc length >= 0"),
        ({"force": (0, 0, 1), "at": np.inf}, r"at: got inf"),
        ({"force": (0, 0, 1), "along": (0.2, 0.1)}, r"along\[1\]: got 0\.1.*> along\[0\] = 0\.2"),
        ({"force": (0, 0, 1), "along": (0.2,)}, r"along: expected 2 values, got 1"),
        ({"force": (0, 0, 1), "along": (0, 1), "at": 0.5}, r"along: got both at and along"),
        ({"force": (0, 0, 1), "frame": "tip"}, r"frame: got 'tip'.*'world' or 'body'"),
    ],
)
def test_impossible_loads(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Load(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": -1.0}, r"mass: got -1"),
        ({"mass": 1.0, "at": -0.1}, r"at: got -0\.1"),
        ({"mass": 1.0, "centre": (0, np.nan, 0)}, r"centre\[1\]: got NaN"),
        ({"mass": 1.0, "inertia": (1, 2)}, r"inertia: expected shape \(3,\) or \(3, 3\)"),
        ({"mass": 1.0, "inertia": (1, 1, 3)}, r"inertia.*principal moments 1, 1, 3"),
        ({"mass": 1.0, "inertia": ((1, 0.1, 0), (0, 1, 0), (0, 0, 1))}, r"inertia.*symmetric"),
    ],
)
def test_impossible_bodies(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Body(**arguments)


def test_loads_and_bodies_beyond_the_end_of_the_rod():
    with pytest.raises(ValueError, match=r"loads\[0\]\.at: got 0\.6.*\[0, 0\.5\]"):
        rod(loads=[lissom.Load(force=(0, 0, 1), at=0.6)])
    with pytest.raises(ValueError, match=r"loads\[0\]\.along\[1\]: got 0\.6"):
        rod(loads=[lissom.Load(force=(0, 0, 1), along=(0.1, 0.6))])
    with pytest.raises(ValueError, match=r"bodies\[0\]\.at: got 0\.6"):
        rod(bodies=[lissom.Body(0.1, at=0.6)])


def test_wrong_types_of_loads_and_bodies():
    with pytest.raises(TypeError, match=r"loads.*lissom\.Load"):
        rod(loads=[lissom.Body(1.0)])
    with pytest.raises(TypeError, match=r"bodies.*lissom\.Body"):
        rod(bodies=lissom.Body(1.0))
    with pytest.raises(TypeError, match="inertia"):
        lissom.Body(1.0, inertia="round")
    with pytest.raises(TypeError, match="force"):
        lissom.Load(force="down")


def test_a_rod_needs_segments():
    with pytest.raises(ValueError, match="segments"):
        lissom.Rod([])
    for wrong in (segment(), [1.0], ["segment"], None):
        with pytest.raises(TypeError, match=r"segments.*lissom\.Segment"):
            lissom.Rod(wrong)


def test_too_many_coordinates_are_refused_before_memory_is_taken():
    many = segment(modes=dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"), 64))
    with pytest.raises(ValueError, match="6144"):
        lissom.Rod([many] * 100)


def test_a_slightly_unnormalised_quaternion_is_normalised():
    q = np.zeros(3)
    orientation = rod(base_orientation=(0.7071, 0, 0.7071, 0)).pose(q, 0.5)[:3, :3]
    assert np.allclose(orientation @ orientation.T, np.eye(3), atol=1e-15)


CALLS = {
    "inverse_dynamics": ("q", "qd", "qdd"),
    "tangent": ("q", "qd", "qdd"),
    "forward_dynamics": ("q", "qd"),
    "energy": ("q", "qd"),
    "mass_matrix": ("q",),
}


@pytest.mark.parametrize(
    ("method", "wrong"), [(method, name) for method, names in CALLS.items() for name in names]
)
def test_states_of_the_wrong_size_or_kind(method, wrong):
    call = getattr(rod(), method)
    good = {name: np.zeros(3) for name in CALLS[method]}
    call(**good)
    for value in (np.zeros(2), np.zeros(4), []):
        with pytest.raises(ValueError, match=rf"\b{wrong}: expected 3 values, got {len(value)}"):
            call(**(good | {wrong: value}))
    for value in ([0, np.nan, 0], [0, 0, -np.inf]):
        with pytest.raises(ValueError, match=rf"\b{wrong}\b"):
            call(**(good | {wrong: value}))
    for value in (np.zeros((3, 1)), np.zeros(3, complex), "abc", None, ["a", "b", "c"], 0.0):
        with pytest.raises(TypeError, match=rf"\b{wrong}\b"):
            call(**(good | {wrong: value}))


@pytest.mark.parametrize("X", [-1e-9, 0.51, np.nan, np.inf, [0.1, 0.6]])
def test_places_outside_the_rod(X):
    with pytest.raises(ValueError, match=r"X: got .*\[0, 0\.5\].*metres"):
        rod().pose(np.zeros(3), X)


@pytest.mark.parametrize("X", ["tip", [None], np.zeros((2, 2))])
def test_places_that_are_no_numbers(X):
    with pytest.raises(TypeError, match="X"):
        rod().pose(np.zeros(3), X)


def test_any_kind_of_array_is_taken():
    model, values = rod(), np.array([0.25, -0.5, 0.125])
    wanted = model.inverse_dynamics(values, 2 * values, 4 * values)
    read_only = values.copy()
    read_only.flags.writeable = False
    strided = np.zeros(6)
    strided[::2] = values
    for same in (
        list(values),
        tuple(values),
        values.astype(np.float32),
        values.astype(">f8"),
        strided[::2],
        values[::-1].copy()[::-1],
        np.asfortranarray(values),
        read_only,
    ):
        assert np.array_equal(model.inverse_dynamics(same, 2 * values, 4 * values), wanted)
    whole = np.array([1, 2, 3])
    assert np.array_equal(model.mass_matrix(whole), model.mass_matrix(whole.astype(float)))


def test_a_rod_without_coordinates_is_a_rigid_body():
    rigid = lissom.Rod([segment(modes={})])
    assert rigid.n == 0
    assert rigid.inverse_dynamics([], [], []).shape == (0,)
    assert rigid.mass_matrix([]).shape == (0, 0)
    assert rigid.forward_dynamics([], []).shape == (0,)
    assert np.allclose(rigid.pose([], 0.5)[:3, 3], [0.5, 0, 0])


def test_rods_and_segments_cannot_be_changed():
    with pytest.raises(AttributeError):
        segment().length = 2.0
    with pytest.raises(AttributeError):
        rod().tip_mass = 2.0


def test_help_shows_the_defaults():
    defaults = {
        name: parameter.default
        for cls in (lissom.Segment, lissom.Rod)
        for name, parameter in inspect.signature(cls).parameters.items()
        if parameter.default is not parameter.empty
    }
    assert defaults == {
        # Messages about missing arguments name those that the kind of section needs.
        **dict.fromkeys(("radius", "young_modulus", "shear_modulus", "density", "modes", "section")),
        "poisson_ratio": None,
        "retardation_time": 0.0,
        "reference_strain": (0, 0, 0, 1, 0, 0),
        "shear_correction": 1.0,
        "magnetisation": (0, 0, 0),
        **dict.fromkeys(("min_bend_radius", "max_strain", "max_stress")),
        "nodes": None,
        "basis": "legendre",
        "base_position": (0, 0, 0),
        "base_orientation": (1, 0, 0, 0),
        "gravity": (0, 0, -9.81),
        "tip_force": (0, 0, 0),
        "tip_moment": (0, 0, 0),
        "tip_mass": 0.0,
        "loads": (),
        "bodies": (),
        "base_motion": None,
        "supports": (),
        "fluid": None,
        "actuators": (),
        "contacts": (),
        "magnets": (),
        "field": (0, 0, 0),
    }


SILICONE = {"length": 0.2, "radius": 0.01, "young_modulus": 3e5, "density": 1070.0, "modes": {"bend_y": 2}}


@pytest.mark.parametrize("ratio", [-0.5, 0.0, 0.3, 0.5])
def test_poisson_ratio_stands_for_the_shear_modulus(ratio):
    made = lissom.Segment(**SILICONE, poisson_ratio=ratio)
    other = lissom.Segment(**SILICONE, shear_modulus=3e5 / (2 * (1 + ratio)))
    assert made.shear_modulus == other.shear_modulus
    assert made.poisson_ratio == ratio
    np.testing.assert_array_equal(made.stiffness(), other.stiffness())
    # They are not equal: with another Young's modulus they differ.
    assert made != other
    assert pickle.loads(pickle.dumps(made)) == made
    scene = f"""version = 1
[[rod]]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = {ratio}
density = 1070
modes = {{ bend_y = 2 }}
[simulation]
t_end = 1
"""
    assert lissom.Scene.loads(scene).model.segments == (made,)


GIVEN = {"length": 1.0, "section": lissom.Section.given([1.0] * 6, 1.0), "modes": {"bend_y": 1}}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (SILICONE, "^shear_modulus: got neither shear_modulus nor poisson_ratio, expected one of them"),
        (
            SILICONE | {"shear_modulus": 1e5, "poisson_ratio": 0.5},
            "^poisson_ratio: got both poisson_ratio and shear_modulus, expected one of them$",
        ),
        (
            SILICONE | {"poisson_ratio": 0.6},
            r"^poisson_ratio: got 0.6, expected a Poisson's ratio in \(-1, 0.5\]$",
        ),
        (SILICONE | {"poisson_ratio": -1.0}, "^poisson_ratio: got -1"),
        (SILICONE | {"poisson_ratio": np.nan}, "^poisson_ratio: got NaN"),
        (
            SILICONE | {"poisson_ratio": 0.3, "young_modulus": -1.0},
            "^young_modulus: got -1, expected a finite number > 0 .*$",
        ),
        (GIVEN | {"poisson_ratio": 0.3}, "^poisson_ratio: got 0.3, expected none: a given section"),
    ],
)
def test_the_shear_modulus_or_poisson_ratio(arguments, message):
    with pytest.raises(ValueError, match=message):
        lissom.Segment(**arguments)


def test_a_given_section_has_no_poisson_ratio():
    assert lissom.Segment(**GIVEN).poisson_ratio is None
