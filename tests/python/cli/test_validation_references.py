"""References of the validation gallery, compared with SciPy, printed values and other derivations."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp
from scipy.special import jn_zeros

from lissom.cli.evidence.validation import (
    beams,
    contacts,
    exact,
    exact_contacts,
    exact_frames,
    exact_lines,
    exact_space,
    jumper,
    lines,
    paths,
    rotation,
    rotor,
    turbine,
)
from lissom.cli.evidence.validation.exact_contacts import Drum
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
        vibration = exact_space.clamped_motion(1.0, 1e7, 1.0, beams.released_shape, np.zeros(1))
        np.testing.assert_allclose(vibration.omega[:3], exact_space.beam_roots("cc", 3) ** 2, rtol=1e-4)
        assert vibration.middle[0] == pytest.approx(beams.released_shape(np.array(0.5)))

    def test_shear_lowers_the_frequency(self):
        assert beams.released_exact().omega[0] / (2.0 * np.pi) == pytest.approx(3.5520, abs=1e-4)


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


class TestContacts:
    @pytest.mark.parametrize("friction", contacts.FRICTIONS)
    def test_a_thin_rope_is_held_by_the_capstan_equation_with_its_weight(self, friction):
        """As the benchmark cosseratbench has it; a rope that is not thin slides earlier."""
        drum = contacts.drum_of(friction)
        ratio = np.exp(friction * np.pi)
        held = ratio * drum.short + drum.radius * 2.0 * friction / (1.0 + friction**2) * (ratio + 1.0)
        thin = Drum(drum.radius, 1e-8 * drum.radius, friction, drum.short, drum.gravity)
        assert exact_contacts.longest(thin) == pytest.approx(held, rel=1e-6)
        lost = {0.1: 0.008, 0.3: 0.023, 0.6: 0.052}[friction]
        assert 1.0 - exact_contacts.longest(drum) / held == pytest.approx(lost, abs=5e-4)

    def test_a_rope_on_a_drum_by_integration(self):
        """Along the drum with the contact force as the unknown, for a rope that slides."""
        drum, long, moved, speed = contacts.drum_of(0.6), 1.4, 0.02, 0.3
        a = exact_contacts.acceleration(drum, long, moved, speed)
        mu, R, p = drum.friction, drum.radius, drum.thickness / drum.radius

        def tension(phi, force, change):
            return force + mu * p * change - R * np.sin(phi) + speed**2 / drum.gravity

        def rate(phi, y):
            force, change = y
            known = mu * (1.0 - p) * force + 2.0 * R * np.cos(phi) + R * a
            return [change, (known - change) / (mu * p)]

        # On the solution that grows slowly: the other one dies out within the thickness of the rope, which
        # a start without it shows.
        def end(force):
            low = solve_ivp(rate, (-0.5, 0.0), [force, 0.0], method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
            high = solve_ivp(rate, (0.0, np.pi), low, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
            return tension(0.0, *low), tension(np.pi, *high)

        light = (drum.short - moved) * (1.0 + a)
        (low0, _), (low1, _) = end(0.0), end(1.0)
        _, heavy = end((light - low0) / (low1 - low0))
        assert heavy == pytest.approx((long + moved) * (1.0 - a), rel=1e-6)

    def test_a_rope_that_slides_by_another_method(self):
        drum = contacts.drum_of(0.3)
        long = 1.1 * exact_contacts.longest(drum)

        def rate(t, y):
            return [y[1], drum.gravity * exact_contacts.acceleration(drum, long, y[0], y[1])]

        times = np.array([0.1, 0.2])
        wanted = solve_ivp(rate, (0.0, 0.2), [0.0, 0.0], t_eval=times, rtol=1e-10, atol=1e-13).y[0]
        np.testing.assert_allclose(exact_contacts.sliding(drum, long, times), wanted, rtol=1e-5)
        assert not exact_contacts.sliding(drum, 0.9 * long, times).any()

    def test_friction_on_the_ground_takes_up_tension(self):
        line = lines.chain(*lines.CHAINS[0][:3])
        fairlead, anchor = exact_contacts.dragged(line, 0.5)
        H, V = exact_lines.resting(line, 0.5)
        assert fairlead == pytest.approx(np.hypot(H, V))
        assert H - anchor == pytest.approx(0.5 * (line.weight * line.length - V))
        assert exact_contacts.dragged(line, 0.0)[1] == pytest.approx(exact_lines.resting(line)[0])
        assert exact_contacts.dragged(line, 5.0)[1] == 0.0

    def test_a_ply_by_its_other_form(self):
        """Of Clauvelin, Audoly and Neukirch, for the given tension: T = sin^4 a (1 / 2 + 1 / cos 2 a)."""
        for degrees in (15.0, 20.0, 25.0):
            angle = np.radians(degrees)
            tension = np.sin(angle) ** 4 * (0.5 + 1.0 / np.cos(2.0 * angle))
            assert exact_contacts.ply_tension(angle) == pytest.approx(tension, rel=1e-12)
            found, torque = exact_contacts.ply(tension)
            assert found == pytest.approx(angle, rel=1e-12)
            assert torque == pytest.approx(2.0 * np.sin(angle) ** 3 * np.cos(angle) / np.cos(2.0 * angle))


class LumpedMasses:
    """The jumper as masses on springs, in space: shares nothing with lissom."""

    #: Axial damping, N s, of a relative velocity between neighbours; smaller changes no digit that counts.
    DAMPING = 2e5

    def __init__(self, count, motion):
        self.count, self.motion = count, motion
        self.part = jumper.LENGTH / count
        self.area = np.pi * jumper.DIAMETER**2 / 4.0

    def ends(self, t):
        """Places and velocities of both ends."""
        place, velocity = np.array([jumper.RISER, jumper.VESSEL]), np.zeros((2, 3))
        if self.motion is not None:
            h = 1e-4
            before, now, after = (jumper.setting_out(np.array(max(t + d, 0.0))) for d in (-h, 0.0, h))
            place[1, self.motion.axis] += now
            velocity[1, self.motion.axis] = (after - before) / (2.0 * h)
        return place, velocity

    def rate(self, t, y, brake=0.0):
        inner = y.reshape(-1, 6)
        (first, last), (still, moving) = self.ends(t)
        r = np.vstack([first, inner[:, :3], last])
        v = np.vstack([still, inner[:, 3:], moving])
        chords = np.diff(r, axis=0)
        lengths = np.linalg.norm(chords, axis=1, keepdims=True)
        along = chords / lengths
        stretching = (np.diff(v, axis=0) * along).sum(axis=1, keepdims=True)
        pull = (jumper.STRETCH * (lengths / self.part - 1.0) + self.DAMPING * stretching) * along
        bends = jumper.BENDING * (r[2:] - 2.0 * r[1:-1] + r[:-2]) / self.part**3
        force = np.zeros_like(r)
        force[:-1] += pull
        force[1:] -= pull
        force[:-2] -= bends
        force[1:-1] += 2.0 * bends
        force[2:] -= bends
        force[:, 2] -= (jumper.MASS - jumper.WATER * self.area) * jumper.GRAVITY * self.part
        tangents = r[2:] - r[:-2]
        tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
        velocity = v[1:-1]
        across = velocity - (velocity * tangents).sum(axis=1, keepdims=True) * tangents
        speed = np.linalg.norm(across, axis=1, keepdims=True)
        drag = 0.5 * jumper.WATER * jumper.DRAG * jumper.DIAMETER * self.part * speed * across
        inner_force = force[1:-1] - drag - brake * self.part * velocity
        axial = (inner_force * tangents).sum(axis=1, keepdims=True) * tangents
        moved = (jumper.MASS + jumper.ADDED_MASS * jumper.WATER * self.area) * self.part
        acceleration = axial / (jumper.MASS * self.part) + (inner_force - axial) / moved
        return np.hstack([velocity, acceleration]).ravel()

    def solved(self, y, times, **brake):
        """LSODA with the band of its Jacobian: a mass feels two neighbours on each side."""
        settings = {"method": "LSODA", "lband": 17, "uband": 17, "rtol": 1e-6, "atol": 1e-6}
        rate = lambda t, y: self.rate(t, y, **brake)  # noqa: E731
        found = solve_ivp(rate, (0.0, times[-1]), y, t_eval=times, **settings)
        assert found.success
        return found.y.T

    def at_rest(self):
        """From a parabola, in syrup."""
        s = np.linspace(0.0, 1.0, self.count + 1)[1:-1, None]
        start = jumper.RISER + s * (jumper.VESSEL - jumper.RISER)
        start[:, 2] -= 4.0 * 45.0 * (s * (1.0 - s))[:, 0]
        y = np.hstack([start, 0.0 * start]).ravel()
        unmoved = LumpedMasses(self.count, None)
        return unmoved.solved(y, np.array([400.0]), brake=100.0)[-1]

    def tension(self, t, y):
        """At the top, kN: of the last spring, with weight, inertia and drag of half a part."""
        (_, last), (_, velocity) = self.ends(t)
        h, half = 1e-3, self.part / 2.0
        acceleration = (self.ends(t + h)[1][1] - self.ends(max(t - h, 0.0))[1][1]) / (2.0 * h)
        chord = last - y.reshape(-1, 6)[-1, :3]
        length = np.linalg.norm(chord)
        along = chord / length
        force = jumper.STRETCH * (length / self.part - 1.0) * along
        force[2] += (jumper.MASS - jumper.WATER * self.area) * jumper.GRAVITY * half
        across, turned = (part - (part @ along) * along for part in (velocity, acceleration))
        drag = 0.5 * jumper.WATER * jumper.DRAG * jumper.DIAMETER * np.linalg.norm(across) * across
        carried = jumper.MASS * acceleration + jumper.ADDED_MASS * jumper.WATER * self.area * turned
        return 1e-3 * np.linalg.norm(force + half * (drag + carried))


@pytest.mark.slow
@pytest.mark.parametrize("motion", jumper.MOTIONS, ids=lambda motion: motion.name)
def test_tensions_of_the_jumper_by_lumped_masses(motion):
    """Extrapolated, since the forces at the end are of first order; tensions vary by 5 to 10 kN."""
    at = jumper.EVERY * np.arange(1, len(motion.tensions) + 1)
    times = np.concatenate([[0.0], jumper.PERIOD + at])
    found = []
    for count in (17, 34):
        masses = LumpedMasses(count, motion)
        states = masses.solved(masses.at_rest(), times)
        found.append([masses.tension(t, y) for t, y in zip(times, states, strict=True)])
    lumped = 2.0 * np.array(found[1]) - found[0]
    np.testing.assert_allclose(lumped[1:], motion.tensions, atol=0.4)
    t, tension, failure = jumper.tensions(motion)
    assert not failure
    np.testing.assert_allclose(np.interp(at, t, tension), lumped[1:], atol=0.4)
    assert tension[0] == pytest.approx(lumped[0], rel=1e-3)
