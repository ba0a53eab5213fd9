"""Statics: exact and published shapes, independent references, buckling, stability, reported failures."""

import inspect
import signal
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom
from reference import statics as reference
from rod_cases import random_rods

L, R, E, G = 1.0, 0.01, 1e9, 4e8
EI = E * np.pi / 4 * R**4
EULER = np.pi**2 / 4 * EI / L**2


def rod(modes, *, density=1000.0, gravity=(0, 0, 0), nodes=None, **loads):
    segment = lissom.Segment(L, R, E, G, density, modes=modes, nodes=nodes)
    return lissom.Rod([segment], gravity=gravity, **loads)


def tip(rod, q):
    return rod.pose(q, rod.length)[:3, 3]


def column(ratio, modes=None, **loads):
    return rod(modes or {"bend_y": 8}, nodes=24, tip_force=(-ratio * EULER, 0, 0), **loads)


def unbalanced(model, q):
    """Largest remaining generalised force, relative to the elastic force of a radian."""
    zero = np.zeros(model.n)
    stiffness = model.tangent(zero, zero, zero)[0].diagonal()
    return np.abs(model.inverse_dynamics(q, zero, zero) / np.abs(stiffness).max()).max()


class TestKnownShapes:
    @pytest.mark.parametrize("turns", [1, 2])
    @pytest.mark.parametrize(
        "modes", [{"bend_y": 1}, {"bend_y": 1, "bend_z": 1, "torsion": 1}, {"bend_y": 3, "stretch": 2}]
    )
    def test_a_moment_rolls_the_rod_up_to_circles(self, turns, modes):
        rolled = rod(modes, nodes=24, tip_moment=(0, 2 * np.pi * turns * EI / L, 0))
        found = lissom.statics(rolled)
        assert found.success, found.message
        q = dict(zip(_names(rolled), found.q, strict=True))
        assert q.pop(("bend_y", 0)) == pytest.approx(2 * np.pi * turns, rel=1e-12)
        assert np.abs(list(q.values())).max(initial=0.0) < 1e-9
        np.testing.assert_allclose(tip(rolled, found.q), 0, atol=1e-11)

    @pytest.mark.parametrize(
        ("alpha", "shortening", "deflection", "angle"),
        [
            (1, 0.05643324, 0.30172077, 0.46135195),
            (5, 0.38762836, 0.71379152, 1.21536812),
            (10, 0.55499560, 0.81060902, 1.43028554),
        ],
    )
    def test_elastica(self, alpha, shortening, deflection, angle):
        model = rod({"bend_y": 10}, nodes=24, tip_force=(0, 0, -alpha * EI))
        found = lissom.statics(model)
        assert found.success
        assert found.is_stable
        np.testing.assert_allclose(tip(model, found.q), [1 - shortening, 0, -deflection], atol=1e-8)
        assert 0.5 * found.q[0] * 2 == pytest.approx(angle, abs=1e-8)  # the mean curvature is the tip's angle

    @pytest.mark.parametrize(
        ("load", "x", "z"), [(5, 0.8466571800, -0.4959050446), (20, 0.4452320522, -0.8298814434)]
    )
    def test_heavy_elastica(self, load, x, z):
        density = load * EI / (9.81 * np.pi * R**2)
        model = rod({"bend_y": 12}, nodes=28, density=density, gravity=(0, 0, -9.81))
        found = lissom.statics(model)
        assert found.success
        assert found.is_stable
        np.testing.assert_allclose(tip(model, found.q), [x, 0, z], atol=1e-9)

    @pytest.mark.parametrize(
        ("force", "moment", "weight"),
        [((0.0, -100.0), 0.0, 0.0), ((30.0, 20.0), 3.0, 10.0), ((-1.5, -0.4), -2.0, 40.0)],
    )
    def test_a_boundary_value_problem_has_the_same_solution(self, force, moment, weight):
        """Loads in units of the bending stiffness."""
        model = rod(
            {"bend_y": 16},
            nodes=40,
            density=weight * EI / (9.81 * np.pi * R**2) or 1e-6,
            gravity=(0, 0, -9.81) if weight else (0, 0, 0),
            tip_force=(force[0] * EI, 0, force[1] * EI),
            tip_moment=(0, moment * EI, 0),
        )
        found = lissom.statics(model)
        exact = reference.planar_rod(1.0, 1.0, weight=weight, force=force, moment=moment)
        assert found.success
        np.testing.assert_allclose(tip(model, found.q)[[0, 2]], [exact.x, exact.z], atol=2e-7)
        assert found.q[0] == pytest.approx(exact.angle, abs=2e-7)

    def test_a_very_flexible_rod_hangs_straight_down(self):
        density = 1e5 * EI / (9.81 * np.pi * R**2)
        model = rod({"bend_y": 24}, nodes=64, density=density, gravity=(0, 0, -9.81))
        found = lissom.statics(model)
        assert found.success
        assert found.is_stable
        # The infinitely long hanging elastica bends within the length sqrt(EI / (w L)) of the clamp: the tip
        # is at sqrt(2) times this length in x, and 2 - sqrt(2) times it is lost in z.
        bend = np.sqrt(1e-5)
        x, _, z = tip(model, found.q)
        assert x == pytest.approx(np.sqrt(2) * bend, rel=0.15)
        assert 1 + z == pytest.approx((2 - np.sqrt(2)) * bend, rel=0.2, abs=1e-3)

    @pytest.mark.parametrize(
        ("modes", "q", "tip_xz"),
        [
            (1, [0.2408062382], None),
            (2, [0.2381234153, -0.3586538798], None),
            (3, [0.238212308, -0.3585635333, 0.1214608904], (0.9818006251, -0.1775638079)),
            (10, None, (0.981801548109, -0.177564708339)),
        ],
    )
    def test_the_lab_wire_sags(self, modes, q, tip_xz):
        model = _wire(modes)
        # The numbers are those of so few modes.
        found = lissom.statics(model, space_error=False)
        assert found.success
        assert found.is_stable
        if q is not None:
            np.testing.assert_allclose(found.q, q, atol=2e-10)
        if tip_xz is not None:
            np.testing.assert_allclose(tip(model, found.q)[[0, 2]], tip_xz, atol=2e-10)

    def test_the_hanging_wire_is_straight(self):
        found = lissom.statics(_wire(3, orientation=(0.7071068, 0, 0.7071068, 0)))
        np.testing.assert_allclose(found.q, 0, atol=1e-6)
        assert found.is_stable
        assert found.lowest_eigenvalue > 1

    @pytest.mark.parametrize(
        ("force", "published"),
        [
            # Simo and Vu-Quoc (1986), Bathe and Bolourchi (1979): as quoted, to a few percent.
            (300, (-11.9, -7.0, 40.2)),
            (450, (-18.5, -10.8, 48.5)),
            (600, (-23.5, -13.6, 53.5)),
        ],
    )
    def test_45_degree_bend(self, force, published):
        model = _bend(force)
        found = lissom.statics(model)
        moved = tip(model, found.q) - tip(model, np.zeros(model.n))
        assert found.success
        assert found.is_stable
        np.testing.assert_allclose(moved, published, atol=0.1)
        if force == 600:
            np.testing.assert_allclose(moved, (-23.560582, -13.604632, 53.475478), atol=2e-6)


def _names(model):
    return [
        (strain, degree)
        for segment in model.segments
        for strain, number in segment.modes.items()
        for degree in range(number)
    ]


def _wire(modes, orientation=(1, 0, 0, 0)):
    segment = lissom.Segment(1.0, 1e-3, 210e9, 80e9, 7800, modes={"bend_y": modes})
    return lissom.Rod([segment], base_orientation=orientation)


def _bend(force):
    """R = 100, 1 x 1 section, E = 1e7, G = 5e6, GJ = G/6, ks = 5/6: as a circle of radius 1/sqrt(3)."""
    radius = 1 / np.sqrt(3)
    area = np.pi * radius**2
    names = ["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]
    segment = lissom.Segment(
        100 * np.pi / 4,
        radius,
        1e7 / area,
        5e6 / area,
        1.0,
        modes=dict.fromkeys(names, 8),
        reference_strain=(0, 0, 1 / 100, 1, 0, 0),
        shear_correction=5 / 6,
        nodes=24,
    )
    return lissom.Rod([segment], gravity=(0, 0, 0), tip_force=(0, 0, force))


class TestBuckling:
    def test_the_straight_column_is_found_with_its_bifurcation(self):
        found = lissom.statics(column(2.0))
        assert found.success
        assert found.stability == "divergence"
        assert found.is_stable is False
        np.testing.assert_allclose(found.q, 0, atol=1e-12)
        (point,) = found.path.critical_points
        assert point.kind == "bifurcation"
        assert 2.0 * point.load_factor == pytest.approx(1.0, abs=1e-9)
        assert "bifurcation at load factor 0.500000" in found.message
        # The lowest eigenvalue is nearly 1 - P / P_Euler.
        assert found.lowest_eigenvalue == pytest.approx(-1.0, rel=0.05)

    @pytest.mark.parametrize("ratio", [1.02, 1.5, 3.0])
    @pytest.mark.parametrize("side", [1, -1])
    def test_both_branches_by_a_seed(self, ratio, side):
        model = column(ratio)
        found = lissom.statics(model, q0=side * 1e-3 * np.eye(model.n)[0])
        x, deflection, angle = reference.buckled_column(ratio)
        assert found.success
        assert found.is_stable
        np.testing.assert_allclose(tip(model, found.q), [x, 0, -side * deflection], atol=1e-6)
        assert found.q[0] == pytest.approx(side * angle, abs=1e-6)

    @pytest.mark.parametrize("side", [1, -1])
    def test_both_branches_by_continuation_from_the_bifurcation(self, side):
        model = column(1.5)
        (point,) = lissom.continuation(model).path.critical_points
        branch = lissom.continuation(
            model, point.q, load_factor=point.load_factor, direction=side * point.directions[0]
        )
        assert branch.success
        assert branch.path.load_factor[-1] == 1
        assert branch.path.stability[1:] == ["stable"] * (len(branch.path.stability) - 1)
        for q, load_factor in zip(branch.path.q[1:], branch.path.load_factor[1:], strict=True):
            if 1.5 * load_factor > 1.001:
                x, deflection, _ = reference.buckled_column(1.5 * load_factor)
                np.testing.assert_allclose(np.abs(tip(model, q)), [x, 0, deflection], atol=1e-6)
        q0 = 1e-3 * np.sign(branch.path.q[-1][0]) * np.eye(model.n)[0]
        np.testing.assert_allclose(branch.path.q[-1], lissom.statics(model, q0).q, atol=1e-8)

    def test_a_round_column_buckles_in_two_directions_at_once(self):
        modes = {"torsion": 2, "bend_y": 5, "bend_z": 5}
        found = lissom.statics(column(1.5, modes))
        (point,) = found.path.critical_points
        assert point.directions.shape == (2, 12)
        assert np.linalg.matrix_rank(point.directions) == 2
        # It may buckle in any direction: the rotation is free.
        buckled = lissom.statics(column(1.5, modes), q0=1e-2 * point.directions.sum(axis=0))
        assert buckled.success
        assert buckled.stability == "neutral"
        assert buckled.is_stable is False

    @staticmethod
    def held(stiffness, is_clamp):
        """A tip that may only slide and twist; stiffness in E I / L^3 and E I / L."""
        across, about = stiffness * EI, stiffness * EI if is_clamp else 0
        return lissom.Support(stiffness=(0, across, across), rotational_stiffness=(0, about, about))

    @staticmethod
    def in_plane_and_in_space(**options):
        """Critical loads of a round rod: those in space are those in the plane, each of them twice."""
        plane, space = (
            lissom.continuation(rod(modes, nodes=24, **options))
            for modes in ({"bend_y": 10}, {"torsion": 1, "bend_y": 10, "bend_z": 10})
        )
        assert plane.status == space.status == "finished"
        assert plane.path.stability[-1] == space.path.stability[-1]
        found = [[point.load_factor for point in way.path.critical_points] for way in (plane, space)]
        np.testing.assert_allclose(*found, rtol=1e-8)
        assert [len(point.directions) for point in plane.path.critical_points] == [1] * len(found[0])
        assert [len(point.directions) for point in space.path.critical_points] == [2] * len(found[0])
        for point in space.path.critical_points:
            assert np.linalg.matrix_rank(point.directions, tol=1e-3) == 2
        return found[0]

    @pytest.mark.parametrize("stiffness", [1e3, 1e8, 1e12])
    @pytest.mark.parametrize(("is_clamp", "critical"), [(False, 4.493409457909064**2), (True, 4 * np.pi**2)])
    def test_round_columns_between_supports_pass_double_bifurcations(self, stiffness, is_clamp, critical):
        loads = self.in_plane_and_in_space(
            tip_force=(-1.25 * critical * EI, 0, 0), supports=[self.held(stiffness, is_clamp)]
        )
        assert loads == pytest.approx([0.8], rel=3 / stiffness + 1e-6)

    @pytest.mark.parametrize(("part", "count"), [(0.2, 2), (0.4, 2), (0.6, 0), (1, 0)])
    def test_bifurcations_come_in_pairs_under_loads_that_follow_in_part(self, part, count):
        """Nonsymmetric tangents: determinants keep their sign when two eigenvalues change it."""
        load = 40 * EI
        loads = self.in_plane_and_in_space(
            tip_force=(-(1 - part) * load, 0, 0),
            loads=[lissom.Load(force=(-part * load, 0, 0), frame="body")],
        )
        assert len(loads) == count

    @pytest.mark.parametrize("stiffness", [1e8, 1e12])
    @pytest.mark.parametrize("twist", [0.2, 0.5, 1])
    def test_twisted_and_compressed_shafts_buckle_as_helices(self, stiffness, twist):
        """Clamps at both ends; y + i z is a sum of 1, s and exp(a s) with a^2 - i m a + p = 0."""
        moment, force = 10 * twist, 50 * (1 - twist)
        half = (0.5 * moment * EI, 0, 0)
        shaft = rod(
            {"torsion": 1, "bend_y": 12, "bend_z": 12},
            nodes=28,
            tip_force=(-force * EI, 0, 0),
            tip_moment=half,
            loads=[lissom.Load(moment=half, frame="body")],
            supports=[self.held(stiffness, True)],
        )

        def singular(factor):
            m, p = factor * moment, factor * force
            root = np.sqrt(m**2 + 4 * p)
            a, b = 0.5j * (m + root), 0.5j * (m - root)
            # Without thrust: 1, s, s^2.
            last = [1, b, np.exp(b), b * np.exp(b)] if p > 0 else [0, 0, 1, 2]
            clamps = np.array([[1, 0, 1, 0], [0, 1, 1, 1], [1, a, np.exp(a), a * np.exp(a)], last])
            return np.linalg.svd(clamps, compute_uv=False)[-1]

        found = lissom.continuation(shaft)
        assert found.status == "finished"
        first, *_ = found.path.critical_points
        assert first.kind == "bifurcation"
        assert first.directions.shape == (2, 25)
        assert singular(first.load_factor) < 1e-5
        assert min(singular(factor) for factor in np.linspace(0.3, 0.98, 30) * first.load_factor) > 1e-3
        assert found.path.stability[-1] == "divergence"

    @pytest.mark.parametrize("stiffness", 10.0 ** np.arange(3, 13))
    @pytest.mark.parametrize(("moment", "force"), [(11, 0), (5, 60), (0, 60)])
    def test_straight_shafts_between_clamps_are_unstable_beyond_their_load(self, stiffness, moment, force):
        half = (0.5 * moment * EI, 0, 0)
        shaft = rod(
            {"torsion": 1, "bend_y": 6, "bend_z": 6},
            nodes=28,
            tip_force=(-force * EI, 0, 0),
            tip_moment=half,
            loads=[lissom.Load(moment=half, frame="body")],
            supports=[self.held(stiffness, True)],
        )
        found = lissom.statics(shaft)
        assert found.status == "converged"
        assert found.stability == "divergence"
        np.testing.assert_allclose(found.q[1:], 0, atol=1e-9)
        assert found.nit < 50

    def test_a_path_may_end_at_a_bifurcation(self):
        shaft = column(1.25, {"torsion": 1, "bend_y": 8, "bend_z": 8})
        (point,) = lissom.continuation(shaft).path.critical_points
        found = lissom.continuation(shaft, bounds=(0, point.load_factor))
        assert found.status == "finished"
        assert found.path.load_factor[-1] == point.load_factor
        np.testing.assert_allclose(found.path.q[-1], 0, atol=1e-9)
        branch = lissom.continuation(
            shaft, point.q, load_factor=point.load_factor, direction=point.directions.sum(axis=0)
        )
        assert branch.status == "finished"
        # It may rotate about its axis.
        assert set(branch.path.stability[1:]) == {"neutral"}

    def test_higher_buckling_loads(self):
        loads = [10 * point.load_factor for point in lissom.statics(column(10)).path.critical_points]
        np.testing.assert_allclose(loads, [1, 9], rtol=1e-6)

    @pytest.mark.parametrize("push", [1e-2, 1e-4, 1e-6])
    def test_an_imperfect_column_bends_to_its_side(self, push):
        """The full load at once would lead to the unstable straight shape, or to the wrong side."""
        found = lissom.statics(column(2.0, gravity=(0, 0, push), density=1e4))
        x, deflection, _ = reference.buckled_column(2.0)
        assert found.success
        assert found.is_stable
        np.testing.assert_allclose(tip(column(2.0), found.q), [x, 0, deflection], atol=10 * push)
        assert found.path.critical_points == []

    def test_the_wrong_side_has_a_limit_point(self):
        """A column pushed to one side can stand on the other one until the load falls below a limit."""
        push = 0.02 * EULER
        model = rod({"bend_y": 6}, nodes=24, tip_force=(-2 * EULER, 0, push))
        wrong = lissom.statics(model, q0=0.5 * np.eye(6)[0])
        assert wrong.is_stable
        assert tip(model, wrong.q)[2] < 0
        path = lissom.continuation(model, wrong.q, load_factor=1.0, direction=-wrong.q).path
        limit, *_ = path.critical_points
        assert limit.kind == "limit"
        assert path.load_factor[limit.index] > limit.load_factor < 1.0
        assert path.stability[0] == "stable"
        assert path.stability[limit.index + 1] == "divergence"
        assert abs(path.load_factor.min() - limit.load_factor) < 0.05
        assert path.load_factor[-1] == 1

    def test_stability_is_that_of_differences(self):
        for model, q0 in [(column(2.0), None), (column(2.0), np.eye(8)[0]), (_bend(450), None)]:
            found = lissom.statics(model, q0)
            zero, step = np.zeros(model.n), 1e-5
            stiffness = np.transpose(
                [
                    (
                        model.inverse_dynamics(found.q + d, zero, zero)
                        - model.inverse_dynamics(found.q - d, zero, zero)
                    )
                    for d in step * np.eye(model.n)
                ]
            )
            scale = 1 / np.sqrt(model.tangent(zero, zero, zero)[0].diagonal().clip(1e-30))
            lowest = np.linalg.eigvalsh(scale[:, None] * (stiffness + stiffness.T) / (4 * step) * scale)[0]
            assert found.is_stable == (lowest > 0)


class TestStops:
    """Joints that loads press against their stops: the path of equilibria has a corner there."""

    @pytest.mark.parametrize("stop", [5.0, 20.0, 1e3, 1e6, 1e9])
    @pytest.mark.parametrize("limit", [0.01, 0.5, 1.9])
    def test_a_slider_on_its_stop(self, limit, stop):
        joint = lissom.Prismatic((0, 0, 1), stiffness=10.0, limits=(-limit, limit), limit_stiffness=stop)
        robot = lissom.Robot([lissom.Link("slider", joint=joint, body=lissom.Body(2.0))])
        weight = 2.0 * 9.81
        path = lissom.continuation(robot)
        assert path.success, path.message
        force = path.path.load_factor * weight
        sinks = np.where(force <= 10.0 * limit, force / 10.0, limit + (force - 10.0 * limit) / (10.0 + stop))
        np.testing.assert_allclose(path.path.q[:, 0], -sinks, rtol=1e-9, atol=1e-12)
        found = lissom.statics(robot)
        assert found.status == "converged", found.message
        np.testing.assert_allclose(found.q[0], -sinks[-1], rtol=1e-9)

    @pytest.mark.parametrize("part", [1e-3, 1e-4, 1e-6])
    def test_a_stop_met_at_a_small_part_of_the_load(self, part):
        joint = lissom.Prismatic((0, 0, 1), stiffness=1.0, limits=(-0.1, 0.1), limit_stiffness=1e6)
        robot = lissom.Robot([lissom.Link("slider", joint=joint, body=lissom.Body(0.1 / part / 9.81))])
        path = lissom.continuation(robot)
        assert path.success, path.message
        np.testing.assert_allclose(path.path.q[-1], -0.1 - (0.1 / part - 0.1) / (1.0 + 1e6), rtol=1e-10)

    @pytest.mark.parametrize("stop", [1.0, 1e3, 1e8, 1e12])
    @pytest.mark.parametrize("stiffness", [0.1, 10.0])
    def test_a_spring_that_presses_against_a_stop_at_rest(self, stiffness, stop):
        joint = lissom.Prismatic(
            (0, 0, 1), stiffness=stiffness, rest=0.5, limits=(-0.3, 0.3), limit_stiffness=stop
        )
        robot = lissom.Robot([lissom.Link("slider", joint=joint, body=lissom.Body(1.0))], gravity=(0, 0, 0))
        exact = (0.5 * stiffness + 0.3 * stop) / (stiffness + stop)
        path = lissom.continuation(robot)
        assert path.success, path.message
        np.testing.assert_allclose(path.path.q, exact, rtol=1e-10)
        np.testing.assert_allclose(lissom.statics(robot).q, exact, rtol=1e-10)

    @pytest.mark.parametrize("stop", [1e6, 1e8, 1e10])
    def test_every_point_of_a_path_from_a_stop_is_in_equilibrium(self, stop):
        """Two hinges, one on its stop from the start: across a stop, Newton's steps do not get smaller."""
        bar = lissom.Body(0.5, centre=(0.1, 0, 0), inertia=(1e-3, 1e-3, 1e-3))
        limits = ((-0.4, 0.4), (-0.5, 0.0))
        links = [
            lissom.Link(
                f"bar{k}",
                parent="bar0" if k else None,
                joint=lissom.Revolute((0, 1, 0), stiffness=1.0, limits=limits[k], limit_stiffness=stop),
                position=(0.2, 0, 0) if k else (0, 0, 0),
                body=bar,
            )
            for k in range(2)
        ]
        robot = lissom.Robot(links)
        path = lissom.continuation(robot)
        assert path.success, path.message
        for q, factor in zip(path.path.q, path.path.load_factor, strict=True):
            arm = 0.1 * np.cos(q.sum())
            weights = 0.5 * 9.81 * np.array([0.1 * np.cos(q[0]) + 0.2 * np.cos(q[0]) + arm, arm])
            beyond = np.maximum(q - [0.4, 0.0], 0.0)
            left = q + stop * beyond - factor * weights
            # Rounding of angles moves the stiff stops.
            assert np.abs(left).max() < 1e-8 + 1e-15 * stop

    def test_stops_one_after_another(self):
        """A chain of four hinges that sags: torques of the joints at rest hold the weights beyond them."""
        bar = lissom.Body(0.5, centre=(0.1, 0, 0), inertia=(1e-3, 1e-3, 1e-3))
        links, parent = [], None
        for k, limit in enumerate((0.3, 0.1, 0.2, 0.05)):
            joint = lissom.Revolute((0, 1, 0), stiffness=3.0, limits=(-limit, limit), limit_stiffness=500.0)
            place = (0.2, 0, 0) if k else (0, 0, 0)
            links.append(lissom.Link(f"bar{k}", parent=parent, joint=joint, position=place, body=bar))
            parent = f"bar{k}"
        robot = lissom.Robot(links)
        path = lissom.continuation(robot)
        assert path.success, path.message
        q = path.path.q[-1]
        heading = np.cumsum(q)
        ends = 0.2 * np.cumsum(np.cos(heading))
        starts = np.concatenate([[0.0], ends[:-1]])
        centres = starts + 0.1 * np.cos(heading)
        weight = 0.5 * 9.81
        torques = [weight * (centres[k:] - starts[k]).sum() for k in range(4)]
        limits = np.array([0.3, 0.1, 0.2, 0.05])
        assert (q > limits)[:2].all()
        np.testing.assert_allclose(3.0 * q + 500.0 * np.maximum(q - limits, 0.0), torques, rtol=1e-8)
        np.testing.assert_allclose(lissom.statics(robot).q, q, atol=1e-9)


class TestWays:
    @pytest.mark.parametrize("steps", [1, 4, [0.3, 1.0]])
    def test_the_way_does_not_change_the_end(self, steps):
        model = rod({"bend_y": 6}, tip_force=(0, 0, -8 * EI))
        found = lissom.statics(model, load_steps=steps)
        np.testing.assert_allclose(found.q, lissom.statics(model).q, atol=1e-9)
        stops = steps if isinstance(steps, list) else np.arange(1, steps + 1) / steps
        assert set(stops) <= set(found.path.load_factor)
        assert all(
            unbalanced(_part(model, part), q) < 1e-9
            for part, q in zip(found.path.load_factor, found.path.q, strict=True)
        )

    def test_the_defaults_are_the_documented_ones(self):
        model = rod({"bend_y": 4}, tip_force=(0, 0, -3 * EI))
        for function in (lissom.statics, lissom.continuation):
            given = {
                name: parameter.default
                for name, parameter in inspect.signature(function).parameters.items()
                if name not in ("model", "q0", "direction")
            }
            default, explicit = function(model), function(model, **given)
            assert default.nit == explicit.nit
            np.testing.assert_array_equal(default.path.q, explicit.path.q)

    def test_newtons_method_finds_what_is_near(self):
        pendulum = lissom.SpringPendulum()
        up = lissom.statics(pendulum, q0=(1.5, -1.0), method="newton")
        assert up.success
        assert up.stability == "divergence"
        assert up.path is None
        np.testing.assert_allclose(up.q, [np.pi / 2, -0.981], atol=1e-10)

    @given(st.floats(-10, 10), st.floats(-0.5, 2.0))
    def test_a_pendulum_comes_to_hang(self, angle, elongation):
        found = lissom.statics(lissom.SpringPendulum(), q0=(angle, elongation))
        assert found.success
        if found.is_stable:
            assert np.sin(found.q[0]) == pytest.approx(-1)
            assert found.q[1] == pytest.approx(0.981)

    def test_a_pendulum_has_no_shape_without_load(self):
        found = lissom.statics(lissom.SpringPendulum())
        assert found.is_stable
        assert found.path is None
        np.testing.assert_allclose(found.q, [-np.pi / 2, 0.981], atol=1e-9)

    @settings(max_examples=25)
    @given(random_rods(), st.booleans())
    def test_random_rods_come_to_rest(self, case, from_unloaded):
        model = case.lissom
        found = lissom.statics(model, None if from_unloaded else np.zeros(model.n), space_error=False)
        if found.success:
            assert found.load_factor == 1
            assert unbalanced(model, found.q) < 1e-6
        else:
            limits = (
                "iteration_limit",
                "stalled",
                "step_too_small",
                "too_many_steps",
                "unresolved",
                "inverted",
            )
            assert found.status in limits
            assert np.isfinite(found.q).all()

    def test_results_repeat_to_the_last_bit(self):
        model = _bend(450)
        np.testing.assert_array_equal(lissom.statics(model).q, lissom.statics(model).q)


def _part(model, part):
    return lissom.Rod(
        model.segments,
        gravity=part * np.array(model.gravity),
        tip_force=part * np.array(model.tip_force),
        tip_moment=part * np.array(model.tip_moment),
    )


class TestFailures:
    def test_a_path_that_is_cut_short_is_let_go(self):
        model = rod({"bend_y": 6}, nodes=64, tip_force=(0, 0, -100 * EI))
        found = lissom.statics(model, max_steps=1)
        assert found.success
        assert found.status == "released"
        assert "released" in found.message
        np.testing.assert_allclose(found.q, lissom.statics(model).q, atol=1e-8)

    def test_limits_keep_the_last_state(self):
        model = rod({"bend_y": 6}, nodes=64, tip_force=(0, 0, -100 * EI))
        found = lissom.statics(model, max_steps=1, max_iter=1)
        assert not found.success
        assert found.status == "too_many_steps"
        assert found.is_stable is None
        assert 0 < found.load_factor < 1
        assert "max_steps" in found.message
        assert unbalanced(_part(model, found.load_factor), found.q) < 1e-9
        found = lissom.statics(model, np.zeros(6), max_iter=2)
        assert not found.success
        assert found.status == "iteration_limit"
        assert "max_iter" in found.message
        found = lissom.continuation(model, max_steps=2)
        assert not found.success
        assert found.status == "too_many_steps"
        assert len(found.path.load_factor) == 3

    def test_forces_that_overflow(self):
        found = lissom.statics(rod({"bend_y": 1, "stretch": 1}, gravity=(0, 0, -9.81)), q0=[1.0, 1e308])
        assert not found.success
        assert found.status == "non_finite"

    def test_no_equilibrium_at_the_start(self):
        model = rod({"bend_y": 6}, nodes=64, tip_force=(0, 0, -100 * EI))
        found = lissom.continuation(model, 30 * np.ones(6), load_factor=0.5)
        assert not found.success
        assert found.status == "no_start"
        assert "q0" in found.message
        assert len(found.path.load_factor) == 0

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"q0": [1.0]}, "q0: expected 2 values, got 1"),
            ({"q0": [np.nan, 0]}, "q0.0.: got NaN"),
            ({"method": "magic"}, 'method: got "magic", expected "auto"'),
            ({"load_steps": 0}, "load_steps: got 0"),
            ({"load_steps": -1}, "load_steps: got -1"),
            ({"load_steps": [0.5, 0.2, 1]}, "load_steps: got .*, expected increasing parts"),
            ({"load_steps": [0.5]}, "the last one 1"),
            ({"load_steps": 3, "q0": [0, 0]}, "load_steps: with `q0`, .* leave `load_steps` out"),
            ({"method": "load_path", "q0": [0, 0]}, "q0: the method .* leave `q0` out"),
            ({"tol": 0.0}, "tol: got 0, expected a finite number > 0"),
            ({"max_iter": -1}, "max_iter: got -1"),
            ({"t": np.inf}, "t: got inf"),
        ],
    )
    def test_wrong_arguments_of_statics(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            lissom.statics(_wire(2), **arguments)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"direction": [0, 0]}, "direction: got zero"),
            ({"bounds": (1, 0)}, "bounds: got"),
            ({"load_factor": 2.0}, "load_factor: got 2, expected a number between the bounds 0 and 1"),
            ({"max_step": 0.0}, "max_step: got 0"),
        ],
    )
    def test_wrong_arguments_of_continuation(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            lissom.continuation(_wire(2), **arguments)

    def test_wrong_types(self):
        for function in (lissom.statics, lissom.continuation):
            with pytest.raises(TypeError, match="model: expected a Model"):
                function("wire")
        with pytest.raises(TypeError, match="load_steps: expected"):
            lissom.statics(_wire(2), load_steps="many")

    def test_ctrl_c_is_heard(self):
        timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            lissom.continuation(column(0.5), max_step=1e-7, max_steps=10**7)
        timer.join()

    def test_results_are_frozen_and_have_names(self):
        found = lissom.statics(column(1.5))
        with pytest.raises(AttributeError):
            found.success = False
        assert repr(found).startswith("<StaticsResult: converged, load factor 1, divergence, ")
        assert repr(found.path.critical_points) == "[<CriticalPoint bifurcation at load factor 0.666667>]"
        assert repr(found.path) == "<EquilibriumPath of 2 points, 1 of them critical in between>"


# Shapes that do not exist


class TestInverted:
    @staticmethod
    def pressed(load, **modes):
        soft = lissom.Segment(1.0, 0.01, 4e4, 2e4, 1000, modes or {"stretch": 3})
        return lissom.Rod([soft], gravity=(0, 0, 0), tip_force=(-load, 0, 0))

    #: E A
    LIMIT = 4e4 * np.pi * 1e-4

    @pytest.mark.parametrize(
        "modes", [{"stretch": 3}, {"stretch": 1, "bend_y": 3}, {"stretch": 2, "torsion": 1}]
    )
    def test_a_rod_cannot_be_pressed_beyond_its_stiffness(self, modes):
        found = lissom.statics(self.pressed(20.0, **modes))
        assert (found.success, found.status, found.stability) == (False, "inverted", None)
        assert "inside out" in found.message
        assert found.load_factor == pytest.approx(self.LIMIT / 20, rel=1e-3)
        below = lissom.statics(self.pressed(0.99 * self.LIMIT))
        assert below.success
        assert below.q[0] == pytest.approx(-0.99)

    def test_nor_be_led_there_by_a_path_or_from_a_shape(self):
        model = self.pressed(20.0)
        along = lissom.continuation(model)
        assert (along.success, along.status) == (False, "inverted")
        assert along.path.load_factor[-1] < self.LIMIT / 20
        for method in ("descent", "newton"):
            assert lissom.statics(model, np.zeros(3), method=method).status == "inverted"

    def test_a_soft_standing_column(self):
        """Its weight exceeds E A: only the base is inverted."""
        soft = lissom.Segment(1.0, 0.01, 4e3, 2e3, 1000, {"stretch": 4})
        rod = lissom.Rod([soft], gravity=(-9.81, 0, 0))
        found = lissom.statics(rod)
        assert found.status == "inverted"
        assert "X = 0" in found.message
        assert found.load_factor == pytest.approx(4e3 / 9810, rel=1e-3)

    def test_such_shapes_are_refused_everywhere(self):
        model = self.pressed(1.0)
        wrong = [-1.5, 0, 0]
        for call in (
            lambda: lissom.modes(model, wrong),
            lambda: lissom.statics(model, wrong),
            lambda: lissom.continuation(model, wrong),
            lambda: lissom.simulate(model, 0.1, q0=wrong),
            lambda: lissom.linearise(model, wrong),
            lambda: model.check_shape(wrong),
        ):
            with pytest.raises(ValueError, match=r"inside out \(stretch -0.5 at X = 0\), expected a stretch"):
                call()
        # At one end only.
        with pytest.raises(ValueError, match="at X = 1"):
            model.check_shape([-0.5, -0.6, 0])

    def test_motions_end_there(self):
        run = lissom.simulate(self.pressed(40.0), 1.0, dt=1e-3)
        assert (run.success, run.status) == (False, "inverted")
        assert "inside out" in run.message


# Verdicts


def follower(force, retardation_time, modes=8):
    """Beck's column: one metre, E I = 1, rho A = 1."""
    young = 1 / (np.pi / 4 * 1e-12)
    segment = lissom.Segment(
        1.0,
        1e-3,
        young,
        0.4 * young,
        1 / (np.pi * 1e-6),
        {"bend_y": modes},
        retardation_time=retardation_time,
    )
    load = lissom.Load(force=(-force, 0, 0), frame="body")
    return lissom.Rod([segment], gravity=(0, 0, 0), loads=[load])


class TestVerdicts:
    @pytest.mark.parametrize(
        ("retardation_time", "critical"),
        [(0.0, 20.0509), (1e-6, 10.94), (1e-4, 10.94)],
        ids=["none", "tiny", "small"],
    )
    def test_becks_column(self, retardation_time, critical):
        """Beck 1952; Bolotin 1963: vanishing internal damping halves the critical load."""
        for part, wanted in ((0.999, "stable"), (1.001, "flutter")):
            rod = follower(part * critical, retardation_time)
            found = lissom.statics(rod)
            assert found.stability == lissom.modes(rod, found.q).stability == wanted
            assert found.is_stable == (wanted == "stable")
            assert found.undamped_stability == ("stable" if part * critical < 20.05 else "flutter")
            assert ("Without damping" in found.message) == (found.undamped_stability != found.stability)
            assert found.path.stability[-1] == wanted

    def test_damping_calms_equal_frequencies(self):
        """A follower moment couples the two bending planes of a round rod: undamped, any causes flutter."""
        for retardation_time, wanted in ((0.0, "flutter"), (1e-2, "stable")):
            young = 1 / (np.pi / 4 * 1e-8)
            segment = lissom.Segment(
                1.0,
                1e-2,
                young,
                0.4 * young,
                1e3,
                {"torsion": 2, "bend_y": 4, "bend_z": 4},
                retardation_time=retardation_time,
            )
            load = lissom.Load(moment=(0.1, 0, 0), frame="body")
            rod = lissom.Rod([segment], gravity=(0, 0, 0), loads=[load])
            found = lissom.statics(rod)
            assert found.stability == lissom.modes(rod, found.q).stability == wanted
            assert found.undamped_stability == "flutter"

    @pytest.mark.parametrize("seed", range(12))
    def test_statics_and_modes_agree_and_eigenvalues_prove_them(self, seed):
        """Random tapered rods under follower loads, damped or not, compared with NumPy's eigenvalues."""
        random = np.random.default_rng(seed)
        strains = ("torsion", "bend_y", "bend_z", *("stretch",) * (seed % 2))
        segment = lissom.Segment(
            0.5,
            (0.01, random.uniform(0.003, 0.01)),
            1e6,
            4e5,
            1000,
            dict.fromkeys(strains, 3),
            retardation_time=(0.0, 1e-4, 1e-2)[seed % 3],
        )
        loads = [
            lissom.Load(force=random.normal(0, 0.05, 3), frame="body"),
            lissom.Load(moment=random.normal(0, 2e-3, 3), frame="body"),
        ]
        rod = lissom.Rod([segment], loads=loads)
        found = lissom.statics(rod, space_error=False)
        assert found.success, found.message
        assert found.path.lowest_eigenvalue[0] == pytest.approx(1.0, abs=1e-12)
        modes = lissom.modes(rod, found.q)
        assert found.stability == modes.stability
        rates = np.linalg.eigvals(lissom.linearise(rod, found.q).A)
        growth = (rates.real / np.abs(rates)).max()
        if abs(growth) > 1e-6:
            assert found.is_stable == (growth < 0)

    def test_without_load_the_lowest_eigenvalue_is_one(self):
        """Tapered rods, sections with couplings, rods on springs."""
        tapered = lissom.Segment(
            1.0, (0.02, 0.002), 1e7, 4e6, 1000, dict.fromkeys(("torsion", "bend_y", "bend_z", "stretch"), 4)
        )
        held = lissom.Support(stiffness=1e5, rotational_stiffness=1e3)
        for supports in ([], [held]):
            rod = lissom.Rod([tapered], gravity=(0, 0, 0), supports=supports)
            assert lissom.statics(rod).lowest_eigenvalue == pytest.approx(1.0, abs=1e-9)
