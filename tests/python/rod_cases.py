"""Test rods: each built twice from the same arguments, by lissom and by the NumPy reference.

A section is a pair, the name of its constructor and its arguments.
"""

import numpy as np
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import lissom
from reference import rod as reference

#: Springs and dampers of all kinds at the tip and inside, as arguments.
TWO_SUPPORTS = [
    {"stiffness": (20, 40, 5), "rotational_stiffness": (0.1, 0.4, 0.2)},
    {
        "at": 0.25,
        "stiffness": (30, 10, 50),
        "rotational_stiffness": (0.5, 0, 0.1),
        "damping": (0.2, 0.1, 0.3),
        "rotational_damping": (0.01, 0.03, 0.02),
        "position": (0.4, -1.9, 1.1),
        "orientation": (0.5, 0.5, -0.5, 0.5),
    },
]


# The motion of a base in all directions.


def drift(t):
    return np.array([0.3 * np.sin(2 * t), 0.2 * t**2, 0.1 * np.cos(3 * t)])


def turn(t):
    """A rotation vector with changing direction."""
    return np.array([0.5 * np.sin(t), 0.8 * t, 0.3 * np.cos(2 * t)])


def quaternion(t):
    return Rotation.from_rotvec(turn(t)).as_quat(scalar_first=True)


def assert_tangents_agree_with_differences(rod, state):
    """Compares the three tangents at a state, shape (3, n), with central differences of the forces."""
    for which, exact in enumerate(rod.tangent(*state)):
        for k in range(rod.n):
            change = np.zeros_like(state)
            change[which, k] = 1e-5
            difference = rod.inverse_dynamics(*(state + change)) - rod.inverse_dynamics(*(state - change))
            assert_allclose(exact[:, k], difference / 2e-5, atol=1e-8 * max(1, np.abs(exact).max()))


class Case:
    """One rod in both implementations; `segments`, `loads` and `bodies` are dicts of arguments."""

    def __init__(self, segments, loads=(), bodies=(), **rod):
        self.arguments = {"segments": segments, "loads": loads, "bodies": bodies} | rod

        def build(package):
            return package.Rod(
                [package.Segment(**with_section(segment, package)) for segment in segments],
                loads=[package.Load(**load) for load in loads],
                bodies=[package.Body(**body) for body in bodies],
                **rod,
            )

        self.lissom, self.reference = build(lissom), build(reference)
        self.length = sum(segment["length"] for segment in segments)
        self.coordinate_scale = np.concatenate([coordinate_scale(segment) for segment in segments])

    def __repr__(self):
        return f"Case(**{self.arguments})"


def with_section(segment, package):
    """The arguments of a segment, with its section created by this package."""
    if "section" not in segment:
        return segment
    shape, parameters = segment["section"]
    return segment | {"section": getattr(package.Section, shape)(**parameters)}


def coordinate_scale(segment):
    """The unit of each coordinate: one radian over the segment, or a stretch or shear of a tenth."""
    sizes = [1 / segment["length"]] * 3 + [0.1] * 3
    return [
        size
        for name, size in zip(reference.STRAINS, sizes, strict=True)
        for _ in range(segment["modes"].get(name, 0))
    ]


def rich_segments():
    """Three segments with all features."""
    return [
        {
            "length": 0.4,
            "radius": (0.02, 0.015),
            "young_modulus": 3e5,
            "shear_modulus": 1.1e5,
            "density": 1100.0,
            "modes": {"torsion": 2, "bend_y": 3, "bend_z": 1, "stretch": 1, "shear_y": 2, "shear_z": 1},
            "retardation_time": 0.01,
            "reference_strain": (0.3, -0.5, 0.2, 1.02, 0.01, -0.02),
            "shear_correction": 0.9,
        },
        {
            "length": 0.7,
            "radius": 0.015,
            "young_modulus": 2e5,
            "shear_modulus": 0.8e5,
            "density": 900.0,
            "modes": {"torsion": 1, "bend_y": 2, "bend_z": 2},
        },
        {
            "length": 0.25,
            "radius": (0.012, 0.006),
            "young_modulus": 4e5,
            "shear_modulus": 1.5e5,
            "density": 1000.0,
            "modes": {"bend_y": 2, "stretch": 1, "shear_z": 1},
        },
    ]


#: A stiffness with all couplings, for rods of some centimetres of rubber.
COUPLED = np.diag([0.02, 0.05, 0.03, 300.0, 90.0, 110.0]) + 0.1 * np.outer(
    *[np.sqrt([0.02, 0.05, 0.03, 300.0, 90.0, 110.0])] * 2
)


def mixed_segments():
    """One segment for each noncircular section, with all strains."""
    every = {"torsion": 1, "bend_y": 2, "bend_z": 2, "stretch": 1, "shear_y": 1, "shear_z": 1}
    rubber = {"young_modulus": 3e5, "shear_modulus": 1.1e5, "density": 1100.0, "modes": every}
    heavy = {"inertia": [(2e-4, 1e-5, 2e-5), (1e-5, 1.5e-4, -3e-5), (2e-5, -3e-5, 1e-4)], "mass": 0.7}
    return [
        {"length": 0.4, "section": ("rectangle", {"width": (0.03, 0.02), "height": 0.015}), **rubber},
        {
            "length": 0.3,
            "section": ("ellipse", {"semi_axis_y": (0.01, 0.012), "semi_axis_z": (0.02, 0.01)}),
            "shear_correction": (0.8, 0.9),
            "retardation_time": 0.01,
            **rubber,
        },
        {
            "length": 0.25,
            "section": ("given", {"stiffness": COUPLED, "centre": (0.004, -0.007), **heavy}),
            "modes": every,
            "retardation_time": 0.02,
            "reference_strain": (0.2, -0.4, 0.3, 1.01, 0.01, -0.02),
        },
        {
            "length": 0.2,
            "section": ("hollow_circle", {"outer": (0.02, 0.015), "inner": (0.01, 0.012)}),
            **rubber,
        },
    ]


def rich_loads():
    """Every kind of load, on segments and at their interfaces."""
    return [
        {"force": (0.1, -0.2, 0.1), "moment": (0.004, 0.002, -0.003), "frame": "body"},
        {"force": (0.2, 0.3, -0.4), "moment": (0.01, -0.02, 0.03), "at": 0.25},
        {"force": (-0.3, 0.1, 0.2), "moment": (0.02, 0.01, 0.01), "at": 0.25, "frame": "body"},
        {"force": (0.1, -0.1, 0.3), "at": 0.4},
        {"force": (0, 0, 0.5), "at": 0.9, "frame": "body"},
        {"force": (0.1, 0.4, -0.2), "moment": (0.02, 0, 0.01), "along": (0, 1.35)},
        {"force": (0.05, -0.3, 0.2), "moment": (0.01, 0.02, -0.01), "along": (0.3, 1.2), "frame": "body"},
    ]


def rich_bodies():
    inertia = ((2e-4, 1e-5, 0), (1e-5, 3e-4, -2e-5), (0, -2e-5, 4e-4))
    return [
        {"mass": 0.04, "centre": (0.02, -0.01, 0.03), "inertia": inertia},
        {"mass": 0.1, "at": 0.1, "centre": (-0.01, 0.02, 0.01), "inertia": (1e-4, 2e-4, 2.5e-4)},
        {"mass": 0.03, "at": 0.6},
    ]


def rich_rod(**changes):
    arguments = {
        "base_position": (0.3, -2.0, 1.0),
        "base_orientation": (0.8, 0.2, -0.4, 0.4),
        "gravity": (1.0, -2.0, -9.0),
        "tip_force": (0.05, -0.1, 0.2),
        "tip_moment": (0.003, 0.002, -0.004),
        "tip_mass": 0.05,
        "loads": rich_loads(),
        "bodies": rich_bodies(),
    }
    return Case(rich_segments(), **(arguments | changes))


def random_states(case, seed, size=0.3):
    """q, qd, qdd of a case: strains of about `size`, rates of up to some radians per second."""
    return size * case.coordinate_scale * np.random.default_rng(seed).standard_normal((3, case.lissom.n))


def vectors(size):
    component = st.floats(-size, size).map(lambda x: round(x, 6))
    return st.tuples(component, component, component)


@st.composite
def random_sections(draw, size):
    """A radius or another shape, with every size drawn from `size`."""
    shape, names = draw(
        st.sampled_from(
            [
                ("radius", ()),
                ("hollow_circle", ("outer",)),
                ("rectangle", ("width", "height")),
                ("ellipse", ("semi_axis_y", "semi_axis_z")),
            ]
        )
    )
    if shape == "radius":
        return {"radius": draw(size)}
    sizes = {name: draw(size) for name in names}
    if shape == "hollow_circle":
        sizes["inner"] = tuple(draw(st.floats(0, 0.9)) * np.broadcast_to(sizes["outer"], 2))
    return {"section": (shape, sizes)}


@st.composite
def random_segments(draw):
    """A segment of any length but one, from a stiff wire to soft rubber."""
    length = draw(st.floats(0.2, 3.0).filter(lambda x: abs(x - 1) > 0.05))
    radius = st.floats(0.005, 0.05).map(lambda ratio: ratio * length)
    young_modulus = 10 ** draw(st.floats(4, 9))
    bend = st.floats(-0.5, 0.5).map(lambda angle: angle / length)
    shear = st.floats(-0.1, 0.1)
    size = st.one_of(radius, st.tuples(radius, radius))
    return draw(random_sections(size)) | {
        "length": length,
        "young_modulus": young_modulus,
        "shear_modulus": young_modulus / (2 * (1 + draw(st.floats(-0.2, 0.5)))),
        "density": draw(st.floats(500, 8000)),
        "modes": draw(st.dictionaries(st.sampled_from(reference.STRAINS), st.integers(0, 3))),
        "retardation_time": draw(st.floats(0, 0.1)),
        "reference_strain": draw(st.tuples(bend, bend, bend, st.floats(0.9, 1.1), shear, shear)),
        "shear_correction": draw(st.floats(0.5, 1.0)),
    }


@st.composite
def random_loads(draw, length):
    """A dead or follower load at the tip, at a place or along a part of a rod."""
    load = {
        "force": draw(vectors(2.0)),
        "moment": draw(vectors(0.5)),
        "frame": draw(st.sampled_from(["world", "body"])),
    }
    at = st.floats(0.05, 0.95).map(lambda x: x * length)
    place = draw(st.sampled_from(["tip", "at", "along"]))
    if place == "at":
        load["at"] = draw(at)
    elif place == "along":
        load["along"] = (draw(st.floats(0, 0.04)) * length, draw(at))
    return load


@st.composite
def random_bodies(draw, length):
    """A point mass or a general body at any place."""
    place = st.floats(0.05, 0.95).map(lambda x: x * length)
    body = {"mass": draw(st.floats(0.01, 0.5)), "at": draw(st.none() | place)}
    if draw(st.booleans()):
        body["centre"] = draw(vectors(0.05))
        body["inertia"] = ((2e-3, 1e-4, 0), (1e-4, 3e-3, -2e-4), (0, -2e-4, 4e-3))
    return body


@st.composite
def random_rods(draw):
    """A rod of one to three random segments with at least one coordinate, with any pose and all loads."""
    segments = draw(st.lists(random_segments(), min_size=1, max_size=3))
    if not any(number for segment in segments for number in segment["modes"].values()):
        segments[-1]["modes"] = {"bend_y": 1}
    orientation = np.array([draw(st.floats(0.1, 1)), *draw(vectors(1.0))])
    length = sum(segment["length"] for segment in segments)
    return Case(
        segments,
        loads=draw(st.lists(random_loads(length), max_size=1)),
        bodies=draw(st.lists(random_bodies(length), max_size=1)),
        base_position=draw(vectors(10.0)),
        base_orientation=tuple(orientation / np.linalg.norm(orientation)),
        gravity=draw(vectors(10.0)),
        tip_force=draw(vectors(5.0)),
        tip_moment=draw(vectors(1.0)),
        tip_mass=draw(st.sampled_from([0.0, 0.3])),
    )


seeds = st.integers(0, 2**32 - 1)
