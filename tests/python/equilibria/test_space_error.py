"""Estimated errors of equilibria due to the finite number of modes.

Beside collocation and closed forms (`reference.statics`), and the same robots with every segment divided
into many.
"""

import copy
import pickle
import re
import warnings

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

import lissom
from reference.statics import buckled_column, planar_rod

YOUNG, SHEAR = 1e9, 4e8
HINGE = lissom.Revolute((0, 1, 0))

warned = pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")


def bending(radius, young=YOUNG):
    return young * np.pi / 4 * radius**4


def segments(modes, parts=1, *, length=1.0, radius=0.01, density=1000.0, grading=1.0):
    strains = modes if isinstance(modes, dict) else {"bend_y": modes}
    ends = np.linspace(0, 1, parts + 1)
    if grading != 1.0:
        ends = 1 - np.geomspace(1, 1 / grading, parts + 1)
        ends /= ends[-1]
    base, tip = radius if isinstance(radius, tuple) else (radius, radius)
    sizes = base + (tip - base) * ends
    return [
        lissom.Segment(
            length * (end - start), (first, last) if base != tip else base, YOUNG, SHEAR, density, strains
        )
        for start, end, first, last in zip(ends, ends[1:], sizes, sizes[1:], strict=False)
    ]


def sections(model, q):
    fractions = np.linspace(0, 1 - 1e-12, 21)
    if isinstance(model, lissom.Rod):
        return [model.pose(q, fractions * model.length)[:, :3, 3]]
    lengths = [(part.name, sum(segment.length for segment in part.rod)) for part in model.links]
    return [model.pose(q, fractions * length, link=name)[:, :3, 3] for name, length in lengths]


def true_error(build, model, q, parts=12):
    """Largest distances, of any section and of any tip, from the same robot of many segments."""
    fine = build(5, parts)
    found = lissom.statics(fine, space_error=False, stability=False)
    assert found.success, found.message
    pairs = zip(sections(model, q), sections(fine, found.q), strict=True)
    apart = [np.linalg.norm(a - b, axis=1) for a, b in pairs]
    return max(x.max() for x in apart), max(x[-1] for x in apart)


def pulled(load):
    def build(modes, parts=1):
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), tip_force=(0, 0, -load * bending(0.01)))

    return build


def heavy(load, radius=0.01, grading=1.0):
    base = radius[0] if isinstance(radius, tuple) else radius

    def build(modes, parts=1):
        density = load * bending(base) / (9.81 * np.pi * base**2)
        rod = segments(modes, parts, radius=radius, density=density, grading=grading if parts > 1 else 1.0)
        return lissom.Rod(rod)

    return build


def inside(**what):
    def build(modes, parts=1):
        load = lissom.Load(at=0.3, **{key: np.multiply(x, bending(0.01)) for key, x in what.items()})
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), loads=[load])

    return build


def actuated(actuator):
    def build(modes, parts=1):
        return lissom.Robot([lissom.Link("rod", rod=segments(modes, parts))], actuators=[actuator])

    return build


def loop(start, to, end):
    def build(modes, parts=1):
        density = 50 * bending(0.01) / (9.81 * np.pi * 1e-4)
        joint = {} if start is None else {"joint": start}
        link = lissom.Link("rod", rod=segments(modes, parts, density=density), **joint)
        return lissom.Robot([link], loops=[lissom.Loop(("rod",), (None, None, to), end)])

    return build


def on_plane(modes, parts=1):
    density = 30 * bending(0.01) / (9.81 * np.pi * 1e-4)
    contact = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.05), (0, 0, 1)), stiffness=1e5)
    link = lissom.Link("rod", rod=segments(modes, parts, density=density))
    return lissom.Robot([link], contacts=[contact])


def tree(modes, parts=1):
    strains = {"torsion": modes, "bend_y": modes, "bend_z": modes}
    turned = [np.cos(0.5), 0, 0, np.sin(0.5)]
    links = [
        lissom.Link("trunk", rod=segments(strains, 2 * parts, density=4000.0)),
        lissom.Link(
            "left", parent="trunk", orientation=turned, rod=segments(strains, parts, length=0.5, density=4e3)
        ),
        lissom.Link(
            "right", parent="trunk", at=0.4, orientation=turned, rod=segments(strains, parts, length=0.7)
        ),
    ]
    return lissom.Robot(links)


def tendon(end, tension=3.0):
    path = lissom.Along("rod", (0, 0.008), along=(0.0, end))
    return lissom.Tendon("tendon", [path], tension=tension * bending(0.01) / 0.008)


def chamber(end):
    path = lissom.Along("rod", (0, 0.005), along=(0.0, end))
    return lissom.Chamber("chamber", [path], area=2e-5, pressure=2 * bending(0.01) / (2e-5 * 0.005))


#: Robots by modes and parts of each segment, and numbers of modes.
ROBOTS = {
    "light pull": (pulled(1.0), (1, 2, 3)),
    "strong pull": (pulled(20.0), (1, 2, 3, 4)),
    "heavy": (heavy(1e2), (2, 3, 6)),
    "cable": (heavy(1e4), (3, 6, 10)),
    "cone 1:10": (heavy(20.0, (0.02, 0.002)), (2, 4, 6)),
    "force inside": (inside(force=(0, 0, -10.0)), (2, 3, 6)),
    "moment inside": (inside(moment=(0, 3.0, 0)), (2, 3, 6)),
    "tendon": (actuated(tendon(1.0)), (1, 2, 3)),
    "tendon inside": (actuated(tendon(0.35)), (2, 3, 6)),
    "chamber inside": (actuated(chamber(0.35)), (2, 3, 6)),
    "clamped": (loop(None, (0.8, 0, 0), lissom.Weld()), (4, 6)),
    "pinned": (loop(HINGE, (0.8, 0, 0), HINGE), (3, 5)),
    "on a plane": (on_plane, (2, 3, 6)),
    "tree": (tree, (1, 2)),
}


@warned
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_estimate_is_near_the_error_by_many_segments(robot):
    build, numbers = ROBOTS[robot]
    for modes in numbers:
        model = build(modes)
        found = lissom.statics(model)
        assert found.success, found.message
        shape, _ = true_error(build, model, found.q, 12 if robot != "cable" else 30)
        error = lissom.statics(model, space_error=True).space_error
        assert 0.3 * shape < error.shape < 3 * shape + 1e-9, (modes, shape, error)
        # What is found by the balance alone may be more, and never hides anything.
        assert found.space_error.shape > 0.3 * shape, (modes, shape, found.space_error)
        if shape > 1e-2:
            assert found.space_error.shape < 3 * shape, (modes, shape, found.space_error)


@warned
@pytest.mark.parametrize("modes", [1, 2, 3])
@pytest.mark.parametrize("ratio", [0.8, 0.95])
def test_compression_multiplies_errors(ratio, modes):
    def build(modes, parts=1):
        critical = np.pi**2 / 4 * bending(0.01)
        force = (-ratio * critical, 0, -0.02 * critical)
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), tip_force=force)

    model = build(modes)
    found = lissom.statics(model)
    shape, tip = true_error(build, model, found.q)
    error = lissom.statics(model, space_error=True).space_error
    assert 0.5 * shape < error.shape < 2 * shape
    assert 0.5 * tip < error.tip < 2 * tip
    assert found.space_error.shape > 0.3 * shape


@warned
@pytest.mark.parametrize("load", [2.0, 10.0])
def test_beside_collocation(load):
    EI = bending(0.01)
    reference = planar_rod(EI, 1.0, force=(0.0, -load * EI))
    for modes in (2, 3, 4):
        model = pulled(load)(modes)
        found = lissom.statics(model, space_error=True)
        tip = np.hypot(*(model.pose(found.q, 1.0)[[0, 2], 3] - [reference.x, reference.z]))
        assert 0.5 * tip < found.space_error.tip < 2 * tip


@warned
def test_beside_the_elastica():
    along, deflection, _ = buckled_column(1.5)
    force = (-1.5 * np.pi**2 / 4 * bending(0.01), 0, 0)
    for modes in (2, 3):
        model = lissom.Rod(segments(modes), gravity=(0, 0, 0), tip_force=force)
        start = np.zeros(modes)
        start[0] = 0.5
        found = lissom.statics(model, start, space_error=True)
        x, z = model.pose(found.q, 1.0)[[0, 2], 3]
        tip = np.hypot(x - along, abs(z) - deflection)
        assert 0.5 * tip < found.space_error.tip < 2 * tip


def test_curvature_of_a_boundary_layer():
    """A cable under tension bends near its clamp alone: phi'' = s^2 phi there."""
    EI, load = bending(0.01), 3e3

    def rate(X, y):
        return np.array([y[1], -load * (1 - X) * np.cos(y[0])])

    X = np.concatenate([np.linspace(0, 0.2, 200), np.linspace(0.2, 1, 200)[1:]])
    guess = np.array([np.pi / 2 * (1 - np.exp(-X / 0.05)), np.exp(-X / 0.05) * np.pi / 0.1])
    found = solve_bvp(rate, lambda a, b: np.array([a[0], b[1]]), X, guess, tol=1e-8, max_nodes=100_000)
    assert found.success
    model = heavy(load)(8)
    result = lissom.statics(model)
    strains = model.strain(result.q, found.x)
    true = np.abs(strains[:, 1] - found.y[1]).max()
    assert 0.3 * true < result.space_error.curvature < 3 * true
    assert 0.3 * true * EI < result.space_error.moment < 3 * true * EI


def test_large_errors_are_warned_of():
    model = pulled(20.0)(2)
    with pytest.warns(lissom.AccuracyWarning, match=r"bend_y of segments\[0\]") as caught:
        found = lissom.statics(model)
    assert found.space_error.relative > 1e-2
    assert found.message.endswith(str(caught[0].message))
    assert found.success
    assert found.status == "converged"
    warnings.simplefilter("error")
    with pytest.raises(lissom.AccuracyWarning) as raised:
        lissom.statics(model)
    np.testing.assert_array_equal(raised.value.result.q, found.q)


@warned
def test_the_segment_that_lacks_modes_is_named():
    coarse = segments(1, length=0.5)
    fine = segments(8, length=0.5)
    for rod, number in ((coarse + fine, 0), (fine + coarse, 1)):
        model = lissom.Rod(rod, gravity=(0, 0, 0), tip_force=(0, 0, -40 * bending(0.01)))
        error = lissom.statics(model).space_error
        assert (error.segment, error.strain) == (number, "bend_y")
        assert error.name == f"segments[{number}]"
    fore = lissom.Link("fore", parent="upper", rod=segments(1, length=0.8, density=1e4))
    error = lissom.statics(lissom.Robot([lissom.Link("upper", rod=fine), fore])).space_error
    assert error.segment == 1
    assert error.name == 'segments[0] of link "fore"'


@pytest.mark.parametrize("value", [None, True])
def test_shapes_that_the_modes_contain_have_no_error(value):
    moment = (0, 2.0 * bending(0.01), 0)
    circle = lissom.Rod(segments(1), gravity=(0, 0, 0), tip_moment=moment)
    unloaded = lissom.Rod(segments(3), gravity=(0, 0, 0))
    for model in (circle, unloaded):
        error = lissom.statics(model, space_error=value).space_error
        assert error.shape < 1e-12
        assert error.tip < 1e-12
        assert error.curvature < 1e-10
    assert lissom.statics(unloaded, space_error=value).space_error.relative < 1e-15


@warned
@pytest.mark.parametrize("basis", ["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"])
def test_every_basis_has_an_estimate(basis):
    def build(modes, parts=1):
        rod = [
            lissom.Segment(
                1.0 / parts,
                0.01,
                YOUNG,
                SHEAR,
                1000.0,
                {"bend_y": modes},
                basis=basis if parts == 1 else "legendre",
            )
            for _ in range(parts)
        ]
        return lissom.Rod(rod, gravity=(0, 0, 0), tip_force=(0, 0, -3 * bending(0.01)))

    for modes in (2, 4):
        model = build(modes)
        found = lissom.statics(model)
        shape, _ = true_error(build, model, found.q)
        assert 0.3 * shape < found.space_error.shape < 3 * shape


@warned
def test_units_and_directions_do_not_matter():
    def rod(unit, turn):
        axes = np.eye(3) if turn is None else turn
        force = axes @ [0, 0, -8 * bending(0.01) * unit]
        segment = lissom.Segment(
            unit, 0.01 * unit, YOUNG / unit**2, SHEAR / unit**2, 1000.0, {"bend_y": 2, "bend_z": 2}
        )
        w = np.sqrt(1 + np.trace(axes)) / 2
        turned = (
            w,
            *(
                np.array([axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]])
                / (4 * w)
            ),
        )
        return lissom.Rod([segment], gravity=(0, 0, 0), tip_force=force / unit, base_orientation=turned)

    angle = 0.7
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    turn = turn @ np.array([[1, 0, 0], [0, np.cos(1.1), -np.sin(1.1)], [0, np.sin(1.1), np.cos(1.1)]])
    reference = lissom.statics(rod(1.0, None), space_error=True).space_error
    for unit in (1e-3, 1.0, 1e3):
        for axes in (None, turn):
            error = lissom.statics(rod(unit, axes), space_error=True).space_error
            assert error.relative == pytest.approx(reference.relative, rel=1e-6)
            assert error.tip == pytest.approx(reference.tip * unit, rel=1e-6)
            assert error.curvature == pytest.approx(reference.curvature / unit, rel=1e-6)


def test_without_an_equilibrium_there_is_no_estimate():
    model = pulled(50.0)(8)
    failed = lissom.statics(model, max_steps=1, max_iter=1, load_steps=[0.1, 1])
    assert not failed.success
    assert failed.space_error is None
    assert lissom.statics(pulled(1.0)(4), space_error=False).space_error is None
    pendulum = lissom.SpringPendulum(1.0, 1.0, 10.0)
    assert lissom.statics(pendulum).space_error is None
    with pytest.raises(TypeError, match="space_error"):
        lissom.statics(model, space_error="yes")


def test_inputs_and_time_are_those_of_the_search():
    path = lissom.Along("rod", (0, 0.008), along=(0.0, 0.35))
    actuator = lissom.Tendon("tendon", [path], tension=lissom.Input("pull", 0.0))
    model = lissom.Robot([lissom.Link("rod", rod=segments(3))], gravity=(0, 0, 0), actuators=[actuator])
    for value in (None, True):
        assert lissom.statics(model, space_error=value).space_error.shape < 1e-12
        errors = [
            lissom.statics(model, u=[pull], space_error=value).space_error.shape for pull in (10.0, 20.0)
        ]
        assert errors[0] > 1e-5
        assert errors[1] == pytest.approx(2 * errors[0], rel=0.1)
    force = (np.array([0.0, 1.0]), np.array([[0, 0, 0.0], [0, 0, -2 * bending(0.01)]]))
    model = lissom.Rod(segments(2), gravity=(0, 0, 0), loads=[lissom.Load(at=0.5, force=force)])
    assert lissom.statics(model, t=0.0, space_error=True).space_error.shape < 1e-12
    assert lissom.statics(model, t=1.0, space_error=True).space_error.shape > 1e-3


def test_estimates_are_kept_with_results(tmp_path):
    found = lissom.statics(pulled(1.0)(3))
    for kept in (pickle.loads(pickle.dumps(found)), copy.copy(found), copy.deepcopy(found)):
        assert kept.space_error.shape == found.space_error.shape
    found.save(tmp_path / "found.lissom")
    assert lissom.load(tmp_path / "found.lissom").space_error.shape == found.space_error.shape
    assert repr(found.space_error).startswith("<SpaceError: ")
    assert repr(found.space_error).endswith("bend_y of segments[0]>")


def test_estimates_are_repeatable():
    model = heavy(1e2)(3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lissom.AccuracyWarning)
        errors = [lissom.statics(model).space_error for _ in range(2)]
    assert errors[0].shape == errors[1].shape
    assert errors[0].moment == errors[1].moment


@pytest.mark.parametrize("value", [None, True])
@pytest.mark.parametrize("ratio", [1e8, 1e10, 1e12])
def test_slack_lines_that_hardly_bend_warn_of_nothing(ratio, value):
    """The balance of moments over a stiffness against bending of nearly nothing is no curvature."""
    length, weight, stiffness, chord = 10.0, 1.0, 1e4, 5.0
    radius = 2 * length / np.sqrt(ratio)
    area = np.pi * radius**2
    modulus = stiffness / area
    part = lissom.Segment(
        length / 10, radius, modulus, 0.4 * modulus, weight / (9.81 * area), {"bend_y": 4, "stretch": 2}
    )
    hinge = lissom.Revolute((0, 1, 0))
    robot = lissom.Robot(
        [lissom.Link("line", joint=hinge, rod=[part] * 10)],
        loops=[lissom.Loop(("line",), (None, None, (chord, 0, 0)), hinge)],
        gravity=(0, 0, -9.81),
    )
    found = lissom.statics(robot, space_error=value)
    assert found.success, found.message
    # Sag of a catenary, with the stretch left out, which is a ten-thousandth.
    a = brentq(lambda a: 2 * a * np.sinh(chord / 2 / a) - length, 0.5, 50)
    depth = max(-robot.pose(found.q, x)[2, 3] for x in np.linspace(0, length, 201))
    assert abs(depth - a * (np.cosh(chord / 2 / a) - 1)) < 1e-3 * length
    assert found.space_error is None or found.space_error.relative < 1e-2


def test_shear_that_is_left_out_of_thick_rods_is_named():
    """F L / (k G A) over F L^3 / (3 E I), with one as shear correction."""
    for radius, added in ((0.1, 24), (0.01, None)):
        thick = lissom.Segment(0.3, radius, 1e6, poisson_ratio=0.45, density=1000, modes={"bend_y": 1})
        force = 1e6 * np.pi * radius**4 / 4 / 0.3**2
        rod = lissom.Rod([thick], gravity=(0, 0, 0), tip_force=(0, 0, -force))
        with pytest.warns(lissom.AccuracyWarning, match="more `modes` of bend_y") as caught:
            lissom.statics(rod)
        said = re.search(r"Shear has no modes there .* would add (\d+) % ", str(caught[0].message))
        assert (said and int(said[1])) == added
