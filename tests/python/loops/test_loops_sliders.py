"""Loops that end on links which only slide and have no size: columns on sliders and slider-cranks."""

import numpy as np
import pytest

import lissom

HINGE = lissom.Revolute((0, 1, 0))
#: What the slider carries; statics and small motions must not depend on its inertia.
BODIES = {
    "a point": lissom.Body(0.2),
    "a small body": lissom.Body(0.2, inertia=(1e-12,) * 3),
    "a large body": lissom.Body(0.2, inertia=(1e-2,) * 3),
}


def crank(body, scale=1.0):
    def bar(mass, length):
        return lissom.Body(
            mass, centre=(length / 2, 0, 0), inertia=(0, mass * length**2 / 12, mass * length**2 / 12)
        )

    a, b = 0.1 * scale, 0.3 * scale
    slide = lissom.Prismatic((1, 0, 0), stiffness=20.0, rest=0.3 * scale)
    links = [
        lissom.Link("crank", joint=HINGE, body=bar(0.1, a)),
        lissom.Link("rod", parent="crank", position=(a, 0, 0), joint=HINGE, body=bar(0.3, b)),
        lissom.Link("slider", joint=slide, body=body),
    ]
    gravity = (0.0, 0.0, -9.81 * scale)
    return lissom.Robot(
        links, loops=[lissom.Loop(("rod", None, (b, 0, 0)), "slider", HINGE)], gravity=gravity
    )


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_a_slider_crank_rests_where_its_energy_is_least(body, scale):
    """Of one angle: the crank's, with the slider below the rod's other end."""
    robot = crank(body, scale)
    found = lissom.statics(robot, [0.5, -0.6, 0.3 * scale])
    assert (found.status, found.stability) == ("converged", "stable")
    a, b, angle = 0.1, 0.3, np.linspace(-np.pi, np.pi, 2_000_001)
    height = -a * np.sin(angle)
    reach = a * np.cos(angle) + np.sqrt(b**2 - height**2)
    energy = 9.81 * (0.1 * height / 2 + 0.3 * height / 2) + 10.0 * (reach - 0.3) ** 2
    is_least = np.r_[False, (energy[1:-1] < energy[:-2]) & (energy[1:-1] < energy[2:]), False]
    assert np.abs(angle[is_least] - found.q[0]).min() < 1e-5
    rest = lissom.modes(robot, found.q)
    assert rest.stability == "stable"
    assert rest.frequency[0] > 0.0


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("share", [0.0, 1e-9, -0.5, 0.5, 0.9, 1.1])
def test_a_column_on_a_slider_buckles_under_the_load_of_euler(share, body):
    """Pinned at both ends, P = pi^2 E I / L^2; also without any load, straight from the start."""
    length, radius, modulus = 0.5, 0.01, 1e6
    bending = modulus * np.pi * radius**4 / 4.0
    critical = np.pi**2 * bending / length**2
    segment = lissom.Segment(length, radius, modulus, modulus / 2.6, 1200.0, {"bend_y": 6})
    slide = lissom.Prismatic((1, 0, 0))
    links = [
        lissom.Link("column", joint=HINGE, rod=[segment]),
        lissom.Link("end", joint=slide, position=(length, 0, 0), body=body),
    ]
    loads = [lissom.Load(force=(-share * critical, 0, 0), link="end")] if share else []
    robot = lissom.Robot(links, gravity=(0, 0, 0), loops=[lissom.Loop("column", "end", HINGE)], loads=loads)
    found = lissom.statics(robot)
    assert found.status == "converged"
    assert found.stability == ("stable" if share < 1.0 else "divergence")
    assert np.abs(found.q).max() < 1e-9
    if share < 1.0:
        density = 1200.0 * np.pi * radius**2
        first = np.pi / 2.0 / length**2 * np.sqrt(bending / density * (1.0 - share))
        assert lissom.modes(robot, found.q).frequency[0] == pytest.approx(first, rel=2e-3)
