"""Derivatives of equilibria and frequencies: closed forms, and differences of complete searches."""

import numpy as np
import pytest

import lissom

E, G, RHO, RADIUS, LENGTH = 2e9, 8e8, 1200.0, 4e-3, 0.6


def heavy(**changes):
    numbers = {"E": E, "G": G, "rho": RHO, "r": RADIUS, "L": LENGTH, "g": -9.81, "F": -0.05} | changes
    segment = lissom.Segment(
        numbers["L"],
        numbers["r"],
        numbers["E"],
        numbers["G"],
        numbers["rho"],
        modes={"bend_y": 4, "bend_z": 2, "stretch": 1},
    )
    load = lissom.Load(force=(0, 0.02, numbers["F"]))
    return lissom.Rod([segment], gravity=(0, 0, numbers["g"]), loads=[load])


NAMES = {
    "E": "segments[0].young_modulus",
    "G": "segments[0].shear_modulus",
    "rho": "segments[0].density",
    "r": "segments[0].radius",
    "L": "segments[0].length",
    "g": "gravity[2]",
    "F": "loads[0].force[2]",
}
VALUES = {"E": E, "rho": RHO, "r": RADIUS, "L": LENGTH, "g": -9.81, "F": -0.05}


def frequencies(rod, q):
    stiffness, _, mass = rod.tangent(q, 0 * q, 0 * q)
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)) / (2 * np.pi)


@pytest.mark.parametrize("key", VALUES)
def test_a_heavy_rod_against_differences(key):
    rod = heavy()
    found = lissom.equilibrium_sensitivity(rod, [NAMES[key]], frequencies=2, tol=1e-13)
    assert found.names == (NAMES[key],)
    step = 1e-4 * abs(VALUES[key])
    ends = []
    for sign in (1, -1):
        other = heavy(**{key: VALUES[key] + sign * step})
        q = lissom.statics(other, found.q, tol=1e-13).q
        ends.append((q, other.pose(q)[:3, 3], frequencies(other, q)[:2]))
    of_q, of_tip, of_frequencies = ((a - b) / (2 * step) for a, b in zip(*ends, strict=True))
    np.testing.assert_allclose(found.dq[:, 0], of_q, atol=1e-6 * np.abs(of_q).max())
    tip, derivative = found.position()
    np.testing.assert_allclose(tip, rod.pose(found.q)[:3, 3], atol=1e-15)
    np.testing.assert_allclose(derivative[:, 0], of_tip, atol=1e-6 * np.abs(of_tip).max())
    np.testing.assert_allclose(found.frequencies, frequencies(rod, found.q)[:2], rtol=1e-9)
    np.testing.assert_allclose(found.dfrequencies[:, 0], of_frequencies, rtol=1e-5)


def test_a_straight_cantilever():
    """The frequency is proportional to sqrt(E / rho) and to r, which gives the derivatives."""
    segment = lissom.Segment(1.0, 5e-3, E, G, RHO, modes={"bend_y": 5})
    rod = lissom.Rod([segment], gravity=(0, 0, 0))
    names = ["segments[0].young_modulus", "segments[0].density"]
    found = lissom.equilibrium_sensitivity(rod, names, frequencies=3)
    exact = np.array([0.5 / E, -0.5 / RHO])
    np.testing.assert_allclose(found.dfrequencies, found.frequencies[:, None] * exact, rtol=1e-8)
    assert np.abs(found.dq).max() == 0.0
    twins = lissom.Rod(
        [lissom.Segment(1.0, 5e-3, E, G, RHO, modes={"bend_y": 3, "bend_z": 3})], gravity=(0, 0, 0)
    )
    assert np.isnan(lissom.equilibrium_sensitivity(twins, names, frequencies=2).dfrequencies).all()


def test_a_small_deflection_is_that_of_a_beam():
    """F L^3 / 3 E I: derivatives by modulus and radius are -1 and -4 times the deflection over these."""
    force = -1e-4
    segment = lissom.Segment(LENGTH, RADIUS, E, G, RHO, modes={"bend_y": 4})
    rod = lissom.Rod([segment], gravity=(0, 0, 0), loads=[lissom.Load(force=(0, 0, force))])
    deflection = force * LENGTH**3 / (3 * E * np.pi / 4 * RADIUS**4)
    found = lissom.equilibrium_sensitivity(rod, [NAMES["E"], NAMES["r"], NAMES["L"], NAMES["F"]])
    tip, derivative = found.position()
    assert tip[2] == pytest.approx(deflection, rel=1e-5)
    exact = deflection * np.array([-1 / E, -4 / RADIUS, 3 / LENGTH, 1 / force])
    np.testing.assert_allclose(derivative[2], exact, rtol=1e-5)
    assert derivative[0, 2] == pytest.approx(1.0, rel=1e-5)


def test_the_adjoint_is_the_forward_derivative():
    rod, names = heavy(), list(NAMES.values())[:1] + list(NAMES.values())[2:]
    weight = np.linspace(0.5, 1.5, rod.n)
    forward = lissom.equilibrium_sensitivity(rod, names)
    adjoint = lissom.equilibrium_sensitivity(rod, names, objective=lambda q: (weight @ q, weight))
    assert adjoint.dq is None
    assert adjoint.value == pytest.approx(weight @ forward.q)
    np.testing.assert_allclose(adjoint.gradient, weight @ forward.dq, rtol=1e-9)
    with pytest.raises(ValueError, match="objective"):
        adjoint.position()


def test_a_pulled_finger_with_joints():
    segment = lissom.Segment(0.2, 5e-3, 1e6, 4e5, 1000.0, modes={"bend_y": 2})
    arm = lissom.Link("arm", joint=lissom.Revolute((0, 1, 0), stiffness=0.2), rod=[segment])
    tip = lissom.Link(
        "tip", joint=lissom.Revolute((0, 1, 0), stiffness=0.05), parent="arm", body=lissom.Body(0.01)
    )
    pull = lissom.Tendon("pull", [lissom.Along("arm", (0, 0.004))], tension=lissom.Input("pull", 1.0))
    robot = lissom.Robot([arm, tip], actuators=[pull])
    found = lissom.equilibrium_sensitivity(robot, ["link[0].joint.stiffness"], u=[0.5], tol=1e-13)
    step = 1e-4
    ends = []
    for sign in (1, -1):
        joint = lissom.Revolute((0, 1, 0), stiffness=0.2 + sign * step)
        moved = lissom.Robot([lissom.Link("arm", joint=joint, rod=[segment]), tip], actuators=[pull])
        ends.append(lissom.statics(moved, found.q, u=[0.5], tol=1e-13, space_error=False).q)
    of_q = (ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(found.dq[:, 0], of_q, atol=1e-6 * np.abs(of_q).max())


def test_what_has_no_derivative_is_refused():
    rod = heavy()
    with pytest.raises(ValueError, match="no start"):
        lissom.equilibrium_sensitivity(rod, ["q0"])
    with pytest.raises(ValueError, match="segment"):
        lissom.equilibrium_sensitivity(rod, ["segments[0].youngs_modulus"])
    with pytest.raises(ValueError, match="0 to 7"):
        lissom.equilibrium_sensitivity(rod, [NAMES["E"]], frequencies=8)
    with pytest.raises(TypeError, match="callable"):
        lissom.equilibrium_sensitivity(rod, [NAMES["E"]], objective=3)
    with pytest.raises(ValueError, match="shape"):
        lissom.equilibrium_sensitivity(rod, [NAMES["E"]], objective=lambda q: (0.0, [1.0]))
    rope = lissom.Tendon("rope", [lissom.Along(offset=(0, 2e-3))], length=LENGTH)
    with pytest.raises(ValueError, match="do not stretch"):
        lissom.equilibrium_sensitivity(
            lissom.Rod(rod.segments, gravity=(0, 0, -9.81), actuators=[rope]), [NAMES["E"]]
        )
    free = lissom.Robot([lissom.Link("ball", body=lissom.Body(1.0), joint=lissom.Prismatic((1, 0, 0)))])
    with pytest.raises(lissom.LissomError):
        lissom.equilibrium_sensitivity(free, ["gravity[0]"])


def test_who_asks_for_inputs_is_told_how_they_are_had():
    """The formula of the message, beside differences of equilibria."""
    soft = lissom.Segment(0.15, 0.006, 250e3, poisson_ratio=0.49, density=1070, modes={"bend_y": 3})
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0.0, 0.004))], tension=lissom.Input("pull", 0.0))
    model, u = lissom.Rod([soft], actuators=[pull]), [0.3]
    with pytest.raises(ValueError, match=r"by -solve\(K, model.input_tangent\(q, u=u\)\) with the stiffness"):
        lissom.equilibrium_sensitivity(model, ["u"], u=u)
    q = lissom.statics(model, u=u).q
    K = model.tangent(q, 0 * q, 0 * q, u=u)[0]
    found = -np.linalg.solve(K, model.input_tangent(q, u=u))[:, 0]
    step = 1e-4
    ahead, behind = (lissom.statics(model, u=[0.3 + sign * step], tol=1e-13).q for sign in (1, -1))
    np.testing.assert_allclose(found, (ahead - behind) / (2 * step), rtol=1e-5, atol=1e-7)
    assert lissom.linearise(model, q, u=u, inputs="inputs").B.shape == (6, 1)
