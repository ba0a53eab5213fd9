"""Generalised stiffness of segments, and derivatives with respect to material parameters."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom
from lissom.analysis.materials import OF_DAMPING, OF_STIFFNESS
from lissom.analysis.parameters import resolved

SIX = ("torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z")


@st.composite
def segments(draw):
    basis = draw(st.sampled_from(["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"]))
    # Bending depends on Young's modulus, torsion on the shear modulus.
    strains = {"bend_y", "torsion"} | draw(st.sets(st.sampled_from(SIX), max_size=3))
    count = draw(st.sampled_from([2, 4]))
    modes = dict.fromkeys(sorted(strains), count)
    if basis in ("legendre", "chebyshev", "monomial"):
        modes = {strain: draw(st.integers(1, 3)) for strain in sorted(strains)}
    shape = draw(st.sampled_from(["circle", "taper", "rectangle", "tube"]))
    section = {
        "circle": {"radius": 0.01},
        "taper": {"radius": (0.012, 0.006)},
        "rectangle": {"section": lissom.Section.rectangle(0.02, 0.01)},
        "tube": {"section": lissom.Section.hollow_circle(0.01, 0.006)},
    }[shape]
    return lissom.Segment(
        draw(st.floats(0.05, 0.4)),
        young_modulus=draw(st.floats(1e5, 1e7)),
        poisson_ratio=draw(st.floats(0.0, 0.49)),
        density=1100.0,
        modes=modes,
        basis=basis,
        retardation_time=draw(st.floats(1e-4, 0.1)),
        shear_correction=draw(st.sampled_from(["cowper", 0.8])) if shape != "rectangle" else 0.8,
        **section,
    )


def coupled():
    """A section that couples stretch with bending and torsion."""
    stiffness = np.diag([0.02, 0.03, 0.04, 900.0, 300.0, 300.0])
    stiffness[3, 1] = stiffness[1, 3] = 1.5
    stiffness[0, 2] = stiffness[2, 0] = 0.004
    section = lissom.Section.given(stiffness=stiffness, mass=0.3, inertia=[3e-5, 1.5e-5, 1.5e-5])
    modes = {"torsion": 2, "bend_y": 3, "bend_z": 1, "stretch": 2}
    return lissom.Segment(0.3, section=section, modes=modes, retardation_time=0.01)


def robot(parts):
    """Two links with joints, both with these segments."""
    joint = lissom.Spherical()
    return lissom.Robot(
        [
            lissom.Link("upper", rod=parts, joint=lissom.Revolute((0, 1, 0))),
            lissom.Link("lower", rod=parts, joint=joint, parent="upper"),
        ]
    )


def material_is_right(segment):
    rod = lissom.Rod([segment], gravity=(0, 0, 0))
    rest = np.zeros(rod.n)
    stiffness, damping, _ = rod.tangent(rest, rest, rest)
    found = segment.generalised_stiffness()
    np.testing.assert_allclose(found, stiffness, rtol=1e-13, atol=1e-15 * np.abs(stiffness).max())
    np.testing.assert_allclose(
        segment.retardation_time * found, damping, rtol=1e-13, atol=1e-15 * np.abs(damping).max()
    )


@settings(max_examples=40, deadline=None)
@given(segments())
def test_generalised_stiffness_is_that_of_a_rod(segment):
    material_is_right(segment)


def test_generalised_stiffness_of_a_coupled_section():
    material_is_right(coupled())


def test_generalised_stiffness_in_closed_form():
    segment = lissom.Segment(2.0, 0.1, 1e6, 4e5, 1000, modes={"bend_y": 1, "stretch": 1})
    area, moment = np.pi * 0.1**2, np.pi * 0.1**4 / 4
    np.testing.assert_allclose(
        segment.generalised_stiffness(), np.diag([1e6 * moment * 2, 1e6 * area * 2]), rtol=1e-14
    )


@settings(max_examples=30, deadline=None)
@given(st.lists(segments(), min_size=1, max_size=3), st.sampled_from([*OF_STIFFNESS, OF_DAMPING]), st.data())
def test_derivatives_are_those_of_whole_models(parts, key, data):
    """The robot's forces, in any state."""
    model = data.draw(st.sampled_from([lissom.Rod(parts), robot(parts)]))
    i, j = data.draw(st.integers(0, len(parts) - 1)), data.draw(st.integers(0, 1))
    name = f"segments[{i}].{key}" if isinstance(model, lissom.Rod) else f"link[{j}].rod.segment[{i}].{key}"
    [parameter] = resolved(model, [name])
    assert parameter.material is not None
    random = np.random.default_rng(3)
    q, v, a = 0.3 * random.standard_normal((3, model.n))
    forces = [weight * other.inverse_dynamics(q, v, a) for other, weight in parameter.terms]
    size = np.abs(forces).sum(0).max()
    material = parameter.material
    expected = np.sum(forces, axis=0)
    found = np.zeros(model.n)
    of_segment = slice(material.first, material.first + len(material.stiffness))
    found[of_segment] = material.stiffness @ q[of_segment] + material.damping @ v[of_segment]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * size)


def branched():
    """Two arms on a rod, all with different sections, one of them on a joint, with a tendon and a load."""
    trunk = lissom.Segment(
        0.2, (0.012, 0.008), 4e5, 1.5e5, 1100, modes={"bend_y": 2, "torsion": 1}, retardation_time=0.02
    )
    flat = lissom.Segment(
        0.15,
        section=lissom.Section.rectangle(0.02, 0.008),
        young_modulus=5e5,
        shear_modulus=2e5,
        density=1200.0,
        modes={"bend_y": 1, "bend_z": 1, "stretch": 1},
        retardation_time=0.01,
    )
    tube = lissom.Segment(
        0.1,
        section=lissom.Section.hollow_circle(0.01, 0.006),
        young_modulus=5e5,
        shear_modulus=2e5,
        density=1000.0,
        modes={"bend_y": 2},
        retardation_time=0.01,
    )
    links = [
        lissom.Link("trunk", rod=[trunk, tube]),
        lissom.Link(
            "left", rod=[flat, trunk], parent="trunk", at=0.1, joint=lissom.Revolute((0, 1, 0), damping=0.01)
        ),
        lissom.Link("right", rod=[tube], parent="trunk", joint=lissom.Spherical()),
    ]
    tendon = lissom.Tendon("pull", [lissom.Along("trunk", (0.0, -0.006))], tension=lissom.Input("pull", 0.5))
    return lissom.Robot(links, actuators=[tendon], loads=[lissom.Load(force=(0, 0.1, 0), link="right")])


@pytest.mark.parametrize("options", [{}, {"method": "generalised_alpha", "rho_inf": 0.6}])
def test_gradients_with_respect_to_sections_are_those_of_models_one_by_one(options):
    """Forward derivatives use separate models for each parameter."""
    names = [
        "link[0].rod.segment[0].density",
        "link[0].rod.segment[0].radius[0]",
        "link[0].rod.segment[0].radius[1]",
        "link[0].rod.segment[1].density",
        "link[0].rod.segment[1].section.outer",
        "link[1].rod.segment[0].section.width",
        "link[1].rod.segment[0].section.height",
        "link[1].rod.segment[1].radius[1]",
        "link[1].rod.segment[0].young_modulus",
        "link[2].rod.segment[0].section.inner",
        "link[2].rod.segment[0].density",
        "link[1].rod.segment[0].length",
        "u",
        "q0[3]",
    ]
    model = branched()
    held = {"u": [[0.5], [1.5], [0.0]], "control_step": 0.04, "dt": 0.01} | options
    forward = lissom.sensitivity(model, 0.12, names, **held)
    on_q, on_v = np.random.default_rng(6).standard_normal((2, *forward.q.shape))

    def objective(t, q, v):
        return float((on_q * q).sum() + (on_v * v).sum()), on_q, on_v

    gradient = lissom.sensitivity(model, 0.12, names, objective=objective, **held).gradient
    expected = np.einsum("mn,mnp->p", on_q, forward.dq) + np.einsum("mn,mnp->p", on_v, forward.dv)
    assert np.abs(expected).min() > 0.0
    np.testing.assert_allclose(gradient, expected, rtol=1e-8)


def test_gradients_with_respect_to_sections_take_no_models(monkeypatch):
    """Segments with nearby values give the inertia of their sections."""
    made = []
    replacing = lissom.analysis.materials.paths.replacing

    def counted(thing, path):
        made.append(type(thing))
        return replacing(thing, path)

    monkeypatch.setattr(lissom.analysis.materials.paths, "replacing", counted)
    segment = lissom.Segment(0.02, 0.01, 4e5, 1.5e5, 1100, modes={"bend_y": 1}, retardation_time=0.02)
    names = [f"segments[{i}].{key}" for i in range(5) for key in ("radius", "density")]
    lissom.sensitivity(lissom.Rod([segment] * 5), 0.05, names, objective=lambda t, q, v: (0.0, q, v))
    assert made == [lissom.Segment] * 10


@pytest.mark.parametrize("key", ["young_modulus", "retardation_time"])
def test_planar_robots(key):
    segment = lissom.Segment(
        0.3, (0.01, 0.006), 3e5, 1e5, 1100, modes={"bend_y": 2, "stretch": 1}, retardation_time=0.1
    )
    links = [
        lissom.Link("a", rod=[segment] * 2, joint=lissom.Revolute((0, 1, 0))),
        lissom.Link("b", rod=[segment] * 2, joint=lissom.Revolute((0, 1, 0)), parent="a"),
    ]
    model = lissom.Robot(links)
    [parameter] = resolved(model, [f"link[1].rod.segment[0].{key}"])
    assert parameter.material.first == 8
    q, v, a = 0.3 * np.random.default_rng(2).standard_normal((3, model.n))
    expected = np.sum([w * other.inverse_dynamics(q, v, a) for other, w in parameter.terms], axis=0)
    found = parameter.material.stiffness @ q[8:11] + parameter.material.damping @ v[8:11]
    np.testing.assert_allclose(expected[8:11], found, rtol=1e-9)
    np.testing.assert_allclose(np.delete(expected, [8, 9, 10]), 0.0, atol=1e-9 * np.abs(found).max())


def test_muscles_depend_on_the_modulus_too():
    """Then the parameter affects more than the segment's stiffness."""
    segment = lissom.Segment(0.3, 0.01, 3e5, 1.2e5, 1100, modes={"bend_y": 2})
    muscle = lissom.ActiveStrain(None, "bend_y", 2.0, 1.5)
    rod = lissom.Rod([segment], actuators=[muscle])
    [parameter] = resolved(rod, ["segments[0].young_modulus"])
    assert parameter.material is None
    found = lissom.equilibrium_sensitivity(rod, ["segments[0].young_modulus"])
    step = 1e3

    def shape(young_modulus):
        changed = lissom.Segment(0.3, 0.01, young_modulus, 1.2e5, 1100, modes={"bend_y": 2})
        return lissom.statics(lissom.Rod([changed], actuators=[muscle]), tol=1e-12, space_error=False).q

    expected = (shape(3e5 + step) - shape(3e5 - step)) / (2 * step)
    assert found.dq[:, 0] == pytest.approx(expected, rel=1e-4)
