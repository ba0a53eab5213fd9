"""References of the validation gallery, compared with SciPy, printed values and other derivations."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.special import jn_zeros

from lissom.cli.evidence.validation import (
    beams,
    exact,
    exact_frames,
    exact_lines,
    exact_space,
    lines,
    paths,
    rotation,
    rotor,
    turbine,
)
from lissom.cli.evidence.validation.exact_lines import Line


class TestLines:
    @pytest.mark.parametrize("number", lines.MOORED)
    def test_forces_hold_the_weight_and_reach_the_end(self, number):
        """From A along the line: an initial value problem."""
        line, _ = lines.MOORED[number]
        ax, az, bx, bz = lines.moored_wanted(number)
        if number != lines.ON_FLOOR:
            assert (ax, az + bz) == pytest.approx((-bx, -line.weight * line.length))

        def rate(s, y):
            bottom = line.length + bz / line.weight if number == lines.ON_FLOOR else 0.0
            up = line.weight * max(s - bottom, 0.0) + az
            tension = np.hypot(bx, up)
            return np.array([-bx, up]) * (1.0 / tension + 1.0 / line.EA)

        end = solve_ivp(rate, (0.0, line.length), [0.0, 0.0], rtol=1e-10, atol=1e-9, method="DOP853").y[:, -1]
        np.testing.assert_allclose(end, [line.x, line.z], atol=1e-5)

    @pytest.mark.parametrize("number", lines.MOORED)
    def test_what_moorpy_misses(self, number):
        _, published = lines.MOORED[number]
        wanted = lines.moored_wanted(number)
        missed = np.abs(np.array(published) - wanted).max() / np.abs(wanted).max()
        assert missed == pytest.approx(lines.MOORPY[number], rel=0.03)

    def test_friction_of_the_floor(self):
        """MoorPy's lines 1 and 3, of which lissom has no equilibrium."""
        line, _ = lines.MOORED[lines.ON_FLOOR]
        for friction, forces in (
            (5.0, (96643.43501616362, 237751.75997440016)),
            (0.1, (96643.42877136687, 237751.75577183915)),
        ):
            np.testing.assert_allclose(exact_lines.resting(line, friction), forces, rtol=5e-7)

    def test_cable_with_bending(self):
        line = lines.rope(0.8)

        def rate(s, y, p):
            _, _, angle, bend = y
            up = p[1] - line.weight * (1.0 - s)
            stretch = 1.0 + (p[0] * np.cos(angle) + up * np.sin(angle)) / line.EA
            dx, dz = stretch * np.cos(angle), stretch * np.sin(angle)
            return np.array([dx, dz, bend / lines.ROPE_BENDING, dz * p[0] - dx * up])

        def ends(a, b, p):
            return np.array([a[0], a[1], a[3], b[0] - 0.8, b[1], b[3]])

        s = np.linspace(0.0, 1.0, 201)
        forces = exact_lines.hanging(line)
        x, z = exact_lines.hanging_shape(line, forces, s)
        start = np.array([x, z, np.arctan2(np.gradient(z, s), np.gradient(x, s)), 0.0 * s])
        found = solve_bvp(rate, ends, s, start, p=forces, tol=1e-9, max_nodes=20000)
        assert found.success
        H, V, _, z = exact_lines.stiff_cable(line, lines.ROPE_BENDING)
        np.testing.assert_allclose(found.p, [H, V], rtol=1e-7)
        assert found.sol(0.5)[1] == pytest.approx(z[len(z) // 2], rel=1e-7)

    def test_pressed_cable(self):
        """Without a load it is a half of the whole cable; loads move it by what they do."""
        line = lines.rope(0.8)
        _, x, z = exact_lines.pressed_cable(line, lines.ROPE_BENDING, 0.0)
        *_, whole = exact_lines.stiff_cable(line, lines.ROPE_BENDING)
        assert (x[-1], z[-1]) == pytest.approx((0.4, whole[len(whole) // 2]), rel=1e-9)
        low, high, force = lines.crossing_exact()
        assert high - low == pytest.approx(2.0 * lines.ROPE_RADIUS)
        assert exact_lines.pressed_cable(line, lines.ROPE_BENDING, force)[2][-1] == pytest.approx(low)
        lifted = exact_lines.pressed_cable(line, lines.ROPE_BENDING, -force)[2][-1]
        assert lifted - lines.DROP == pytest.approx(high)

    def test_cable_without_bending_is_a_chain(self):
        omega = exact_lines.swinging_cable(1.0, 1e12, 1e-7, 0.1, 0.0, 9.81, degree=120)
        np.testing.assert_allclose(omega[:2], jn_zeros(0, 2) / 2.0 * np.sqrt(9.81), rtol=1e-4)


class TestSpace:
    def test_it_is_the_other_shooting_without_moments(self):
        curvature, force = (0.0, 0.0, 1.0 / beams.GX_RADIUS), (0.0, 0.0, beams.GX_FORCE)
        (line,) = exact.space_rod(beams.GX_LENGTH, beams.GX_STIFFNESS, curvature, (force,))
        np.testing.assert_allclose(beams.gx_line()[-1], line[-1], atol=1e-5)

    def test_moment_of_a_helix(self):
        moment = (3.0, 0.0, 4.0)
        stiffness, straight = (1.0,) * 3 + (1e9,) * 3, (0.0, 0.0, 0.0)
        line = exact_space.pushed_rod(1.0, stiffness, straight, straight, moment)
        X = np.linspace(0.0, 1.0, len(line))
        np.testing.assert_allclose(line, exact.helix(moment, 1.0, X), atol=1e-7)

    def test_moment_that_turns_with_the_tip(self):
        """From the tip inwards all is known: an initial value problem."""
        stiffness = np.array(beams.EIGHTH_STIFFNESS)
        line = beams.eighth_line(True)
        clamp = exact_space.pushed_rod(
            beams.EIGHTH_LENGTH, stiffness, (0.0,) * 3, beams.EIGHTH_FORCE, beams.EIGHTH_MOMENT, follows=False
        )
        assert 1e-6 < np.abs(line[-1] - clamp[-1]).max() < 1e-3
        end = beams.eighth().values
        np.testing.assert_allclose(end[3:], line[-1], atol=1e-9)

    def test_twist_under_tension(self):
        assert exact_space.twisted_under_tension(0.01) == pytest.approx(
            2.0 * exact.greenhill_root(), rel=1e-3
        )
        # Values of the benchmark's description.
        found = [exact_space.twisted_under_tension(tension) for tension in (1.0, 10.0, 30.0)]
        np.testing.assert_allclose(found, [9.1347300889, 10.4288564393, 13.1134997530], rtol=1e-9)

    def test_roots_as_printed(self):
        """Blevins (1979), table 8-1."""
        printed = {
            "ff": (4.73004074, 7.85320462),
            "cf": (1.87510407, 4.69409113),
            "cp": (3.92660231, 7.06858275),
            "cs": (2.36502037, 5.49780392),
            "pp": (np.pi, 2.0 * np.pi),
        }
        for ends, roots in printed.items():
            np.testing.assert_allclose(exact_space.beam_roots(ends, 2), roots, rtol=3e-9)

    def test_vibration_without_shear_is_that_of_a_slender_beam(self):
        vibration = exact_space.clamped_motion(1.0, 1e7, 1.0, beams.let_go_shape, np.zeros(1))
        np.testing.assert_allclose(vibration.omega[:3], exact_space.beam_roots("cc", 3) ** 2, rtol=1e-4)
        assert vibration.middle[0] == pytest.approx(beams.let_go_shape(np.array(0.5)))

    def test_shear_lowers_the_frequency(self):
        assert beams.let_go_exact().omega[0] / (2.0 * np.pi) == pytest.approx(3.5520, abs=1e-4)


class TestFrames:
    @pytest.mark.parametrize("frame", paths.FULL)
    @pytest.mark.parametrize("point", [0, 1])
    def test_lees_frame(self, frame, point):
        """From the first foot: an initial value problem that ends at the other one."""
        lee = exact_frames.LeeFrame(paths.LEG, paths.AT, follows=frame == "body")
        angle, nx, nz, load = lee.at_limit(paths.STARTS[frame][point]) * [1.0, *[lee.leg.EI / 120.0**2] * 3]

        def marched(y, length):
            def rate(s, y):
                _, _, angle, moment, nx, nz = y
                stretch = 1.0 + (nx * np.cos(angle) + nz * np.sin(angle)) / lee.leg.EA
                dx, dz = stretch * np.cos(angle), stretch * np.sin(angle)
                return [dx, dz, moment / lee.leg.EI, nx * dz - nz * dx, 0.0, 0.0]

            return solve_ivp(rate, (0.0, length), y, rtol=1e-9, atol=1e-7, method="DOP853").y[:, -1]

        y = marched([0.0, 0.0, 0.5 * np.pi + angle, 0.0, nx, nz], 120.0) - [
            0.0,
            0.0,
            0.5 * np.pi,
            0.0,
            0.0,
            0.0,
        ]
        loaded = marched(y, paths.AT)
        turn = loaded[2] if lee.follows else 0.0
        after = loaded + load * np.array([0.0, 0.0, 0.0, 0.0, -np.sin(turn), np.cos(turn)])
        end = marched(after, 120.0 - paths.AT)
        np.testing.assert_allclose(end[:2], 120.0, rtol=1e-6)
        assert end[3] * 120.0 / lee.leg.EI == pytest.approx(0.0, abs=1e-4)
        assert lee.limit(paths.STARTS[frame][point])[0] == pytest.approx(load)

    def test_a_limit_is_an_extremum(self):
        """Of a parabola, whose load is the square of what leads along it."""
        miss = lambda x: np.array([x[1] - 3.0 * x[0], x[2] - (2.0 - (x[0] - 0.7) ** 2)])  # noqa: E731
        found = exact_frames.limit_point(miss, np.array([0.5, 1.0, 1.0]), 1e-2)
        np.testing.assert_allclose(found, [0.7, 2.1, 2.0], atol=1e-5)

    def test_bent_frame(self):
        """Without load it hangs; small forces are those of linear theory."""
        assert exact_frames.bent_frame(paths.BENT, 0.0) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
        force, leg = 1e-3, paths.BENT
        left, up, _ = exact_frames.bent_frame(leg, force)
        # The first leg bends by the moment F L, the second one by the force.
        assert left == pytest.approx(-force * leg.length**3 / leg.EI * (1.0 + 1.0 / 3.0), rel=1e-3)
        assert up == pytest.approx(-force * leg.length**3 / (2.0 * leg.EI), rel=1e-3)

    def test_arch_sways_as_printed(self):
        """Timoshenko and Gere (1961), table 7-2: k by the opening."""
        for opening, printed in ((60.0, 8.62), (120.0, 4.37), (180.0, 3.00)):
            k = np.sqrt(exact_frames.arch_sway(np.radians(opening)) + 1.0)
            assert k == pytest.approx(printed, abs=6e-3)

    def test_arch_that_is_loaded_a_little(self):
        """The first limit is far above the pressure at which it sways."""
        pressure, drop = paths.arch_limit()
        assert pressure > exact_frames.arch_sway(paths.OPENING)
        assert 0.0 < drop < 0.05


def test_the_turbine_is_closed():
    """Blades and struts meet where they are welded, and it weighs what its parts weigh."""
    model = turbine.turbine(0.0)
    q = np.zeros(model.n)
    assert np.abs(model.loop_gaps(q, t=0.0)).max() < 1e-5
    still = np.zeros(model.n)
    steps = np.hypot(*np.diff(turbine.SHAPE, axis=0).T)
    heights = 0.5 * (turbine.SHAPE[1:, 1] + turbine.SHAPE[:-1, 1])
    masses = np.array([146.781, 87.3025, 69.3173])
    blade = steps @ masses[[turbine.ORDER[i] for i in np.searchsorted(turbine.CHANGES, heights)]]
    struts = 2.0 * masses[0] * (turbine.SHAPE[1, 0] + turbine.SHAPE[-2, 0])
    weight = 9.81 * (330.755 * turbine.HEIGHT + 2.0 * blade + struts)
    assert abs(model.base_wrench(q, still, still, t=0.0)[5]) == pytest.approx(weight, rel=1e-6)


def test_whirls_are_those_at_rest_in_turning_axes():
    slow, fast = rotation.wanted_whirls().reshape(2, -1)
    first, second = exact.cantilever_roots(2) ** 2
    assert slow == pytest.approx([0.5 * first, 1.5 * first, second - 0.5 * first, second + 0.5 * first])
    assert fast == pytest.approx(
        sorted([2.0 * first, 4.0 * first, second - 3.0 * first, second + 3.0 * first])
    )


def test_blade_on_a_hub():
    """At the axis it is the blade of the power series; a hub stiffens it."""
    found = [exact_space.hubbed_blade(1.0, 1.0, 1.0, hub, 6.0, 1)[0] for hub in (0.0, 0.1)]
    assert found[0] == pytest.approx(exact.flapping_blade(6.0), rel=1e-9)
    assert found[1] > found[0]
    assert rotor.straight_wanted()[0] == pytest.approx(1.4872, abs=1e-4)


def test_a_buoyant_line_is_a_mirrored_one():
    forces = exact_lines.hanging(Line(30.0, 10.0, 50.0, 1e6, 100.0))
    line = Line(30.0, -10.0, 50.0, 1e6, -100.0)
    x, z = exact_lines.hanging_shape(line, (forces[0], -forces[1]), np.array(50.0))
    assert (x, z) == pytest.approx((30.0, -10.0))
