"""Thin wires at rest over sharp edges and boxes, from a straight start with the default stiffness."""

import numpy as np
import pytest

import lissom

G, DENSITY = 9.81, 1500.0


def wire(obstacles, *, stiffness=None, young=2e11, radius=5e-4, span=None):
    """A wire from a clamp, seven times as long as its weight bends it; `span` is where its tip is clamped."""
    weight, bending = DENSITY * G * np.pi * radius**2, young * np.pi * radius**4 / 4
    length = 7 * (bending / weight) ** (1 / 3)
    segment = lissom.Segment(
        length / 4,
        radius,
        young,
        poisson_ratio=0.4,
        density=DENSITY,
        modes={"torsion": 2, "bend_y": 4, "bend_z": 4},
    )
    contacts = [
        lissom.Contact("rod", obstacle, name=f"o{i}", stiffness=stiffness)
        for i, obstacle in enumerate(obstacles(length))
    ]
    loops = [lissom.Loop(("rod",), (None, None, (span * length, 0, 0)), lissom.Weld())] if span else []
    link = lissom.Link("rod", rod=[segment] * 4)
    return lissom.Robot([link], contacts=contacts, loops=loops), length, bending


def edge(height):
    return lambda L: [lissom.Box((1.6 * L, 0, -(height + 0.15) * L), (1.35 * L, 2 * L, 0.15 * L))]


def boxes(L):
    return [
        lissom.Box((x * L, 0, z * L), (0.075 * L, L, 0.1 * L)) for x, z in ((0.225, -0.2), (0.575, -0.25))
    ]


def bars(L):
    return [
        lissom.Capsule((x * L, -L, z * L), (x * L, L, z * L), 0.02 * L)
        for x, z in ((0.3, -0.08), (0.55, -0.12))
    ]


def chain_over_edge(height, radius, number):
    """Energy over B / L and the tip over L of a chain of rigid bars with springs of bending, over an edge at
    x = L / 4 and the face behind it.

    Bars are above the corner, joints above the face, by penalties that grow to 1e8 B / L^3 (Levenberg).
    """
    weight, h = 343.0, 1 / number
    lower = np.tril(np.ones((number, number))) * h
    change = np.eye(number) - np.eye(number, k=-1)
    change[0, 0] = np.sqrt(2)
    bending = change.T @ change / h
    lever = weight * h * h * (number - np.arange(number) - 0.5)

    def gaps(angles):
        c, s = np.cos(angles), np.sin(angles)
        x, z = np.cumsum(c) * h, -np.cumsum(s) * h
        on_face = x > 0.25
        found, rows = [z[on_face] + height - radius], [-(lower * c)[on_face]]
        i = int(np.argmax(on_face))
        start = np.array([x[i] - h * c[i], z[i] + h * s[i]])
        away = np.array([0.25, -height]) - start
        row = -(lower[i - 1] * s) * s[i] - (lower[i - 1] * c) * c[i] if i else np.zeros(number)
        row[i] -= away[0] * c[i] - away[1] * s[i]
        found.append([-(away[0] * s[i] + away[1] * c[i]) - radius])
        return np.concatenate(found), np.vstack([*rows, row])

    def energy(angles, k):
        own = 0.5 * angles @ bending @ angles - lever @ np.sin(angles)
        return own + 0.5 * k * (np.minimum(gaps(angles)[0], 0) ** 2).sum()

    angles, shift = np.zeros(number), 1e-3
    for k in np.geomspace(1e2, 1e8, 7):
        for _ in range(300):
            gap, rows = gaps(angles)
            rows = rows[gap < 0]
            gradient = bending @ angles - lever * np.cos(angles) + k * rows.T @ gap[gap < 0]
            if np.abs(gradient).max() < 1e-9 * weight:
                break
            hessian = bending + np.diag(lever * np.sin(angles)) + k * rows.T @ rows
            step = -np.linalg.solve(hessian + shift * bending, gradient)
            is_good = np.abs(step).max() < 0.3 and energy(angles + step, k) < energy(angles, k)
            angles, shift = (angles + step, shift / 8) if is_good else (angles, 4 * shift)
            if shift > 1e12:
                break
    own = 0.5 * angles @ bending @ angles - lever @ np.sin(angles)
    return own, np.cumsum(np.cos(angles))[-1] * h, -np.cumsum(np.sin(angles))[-1] * h


@pytest.mark.parametrize("height", [0.03, 0.12, 0.21])
def test_wires_over_an_edge_against_a_chain_of_bars(height):
    robot, length, bending = wire(edge(height))
    found = lissom.statics(robot)
    assert found.success, found.message
    assert found.njev <= 220
    # The error of a chain falls with the square of the length of its bars.
    coarse, fine = (np.array(chain_over_edge(height, 5e-4 / length, n)) for n in (40, 80))
    energy, *tip = (4 * fine - coarse) / 3
    np.testing.assert_allclose(robot.energy(found.q, 0 * found.q).total * length / bending, energy, rtol=1e-3)
    np.testing.assert_allclose(robot.pose(found.q, length, link="rod")[[0, 2], 3] / length, tip, atol=1e-3)


@pytest.mark.parametrize(("obstacles", "span"), [(boxes, 0.85), (bars, None)])
def test_wires_over_boxes_and_bars_keep_the_shape_of_stiff_ones(obstacles, span):
    robot, length, _ = wire(obstacles, span=span)
    found = lissom.statics(robot)
    assert found.success, found.message
    assert found.njev <= 250
    stiff, *_ = wire(obstacles, span=span, stiffness="material")
    rigid = lissom.statics(stiff)
    assert rigid.success, rigid.message
    places = np.linspace(0, length, 50)
    here, there = (robot.pose(q, places, link="rod")[:, :3, 3] for q in (found.q, rigid.q))
    assert np.abs(here - there).max() < 1e-3 * length
    # Without the way by soft contacts: Newton's method in the model's own contacts stays there.
    again = lissom.statics(robot, found.q + 1e-9, method="newton")
    assert again.success
    np.testing.assert_allclose(again.q, found.q, atol=1e-8)


def over_a_bar(unit, radius=7e-4, young=1.4e9, place=0.62, height=-0.1, bar=4e-4, **options):
    """A clamped wire of one metre over a thin bar, with this many length units in a metre."""
    segment = lissom.Segment(
        unit,
        radius * unit,
        young / unit,
        poisson_ratio=0.3,
        density=1200 / unit**3,
        modes={"bend_y": 4},
    )
    ends = [(place * unit, y * unit, height * unit) for y in (-0.3, 0.3)]
    contact = lissom.Contact("rod", lissom.Capsule(*ends, bar * unit))
    rod = lissom.Rod([segment], gravity=(0, 0, -9.81 * unit), contacts=[contact])
    return rod, lissom.statics(rod, **options)


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("unit", [2.0**-12, 2.0**-5, 2.0**5, 2.0**10, 2.0**20])
def test_the_unit_of_length_does_not_matter(unit):
    """Curvatures are small numbers in small units: wires fell through bars in millimetres, without a word.

    Units are powers of two, so that numbers differ in nothing else.
    """
    (_, expected), (_, found) = over_a_bar(1.0), over_a_bar(unit)
    assert (found.status, found.nit) == (expected.status, expected.nit)
    np.testing.assert_array_equal(found.q * unit, expected.q)
    assert found.deepest is not None


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
def test_wires_rest_in_millimetres_as_in_metres():
    (_, expected), (_, found) = over_a_bar(1.0), over_a_bar(1e3)
    assert found.success
    np.testing.assert_allclose(found.q * 1e3, expected.q, rtol=1e-8)


@pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")
@pytest.mark.parametrize("bar", [2e-3, 4e-4])
@pytest.mark.parametrize("radius", [2e-3, 7e-4, 2e-4, 5e-5])
def test_wires_of_the_same_shape_rest_on_a_bar(radius, bar):
    """Their weights bend them alike, down to radii far smaller than the bows of parts between samples."""
    young = 4 * 1200 * 9.81 / radius**2 / 30
    place = {"radius": radius, "young": young, "place": 0.3, "height": -0.023, "bar": bar}
    rod, found = over_a_bar(1.0, **place)
    assert found.success
    assert found.deepest is not None
    assert found.njev <= 100
    # The lower the top of both, the deeper hangs the tip.
    assert rod.pose(found.q, 1.0)[2, 3] == pytest.approx(-0.5975 + 1.8 * (radius + bar), abs=1e-3)


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
@pytest.mark.parametrize("radius", [5e-4, 2e-3])
@pytest.mark.parametrize("weight", [10.0, 30.0])
@pytest.mark.parametrize("upper", [0.3, 0.5])
def test_a_wire_between_two_bars_stays_there(radius, weight, upper):
    """Larger obstacles on both sides squeezed it out; the damped motion says where it belongs."""
    young, bar, gap = 5e10, 0.015, 1e-4
    bending_stiffness = young * np.pi * radius**4 / 4
    segment = lissom.Segment(
        1.0,
        radius,
        young,
        poisson_ratio=0.3,
        density=weight * bending_stiffness / (9.81 * np.pi * radius**2),
        modes={"bend_y": 5, "bend_z": 5},
        retardation_time=0.3,
    )
    contacts = [
        lissom.Contact("rod", lissom.Capsule((x, -1, z), (x, 1, z), bar))
        for x, z in [(0.6, -bar - radius - gap), (upper, bar + radius + gap)]
    ]
    rod = lissom.Rod([segment], contacts=contacts)
    found = lissom.statics(rod, space_error=False)
    assert found.success
    motion = lissom.simulate(rod, 20.0, dt=0.01, rho_inf=0.5)
    assert motion.success
    tips = [rod.pose(q)[:3, 3] for q in (found.q, motion.q[-1])]
    np.testing.assert_allclose(*tips, atol=2e-3)


@pytest.mark.parametrize("load_steps", [1, 2, 20])
@pytest.mark.parametrize("modes", [{"bend_y": 5}, {"bend_y": 5, "bend_z": 5}], ids=["plane", "space"])
def test_load_paths_do_not_go_through_a_bar(modes, load_steps):
    """The shape beside the bar is in equilibrium, too, but only steps through the bar lead there."""
    radius, young, bar = 2e-3, 5e10, 0.015
    density = 30 * young * radius**2 / (4 * 9.81)
    segment = lissom.Segment(1.0, radius, young, poisson_ratio=0.3, density=density, modes=modes)
    z = -bar - radius - 1e-4
    contact = lissom.Contact("rod", lissom.Capsule((0.6, -1, z), (0.6, 1, z), bar))
    rod = lissom.Rod([segment], contacts=[contact])
    expected = lissom.statics(rod, space_error=False)
    found = lissom.statics(rod, load_steps=load_steps, space_error=False)
    assert expected.success
    assert found.success
    assert found.deepest is not None
    np.testing.assert_allclose(found.q, expected.q, atol=1e-6)
