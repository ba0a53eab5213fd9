"""Magnets and magnetised segments: exact shapes, forces of charges, what is conserved, tangents, scenes."""

import pickle
import re

import numpy as np
import pytest

import lissom
from reference import magnets as reference

L, R, E, G = 0.1, 1e-3, 1e6, 4e5
AREA, EI = np.pi * R**2, E * np.pi / 4 * R**4
MAGNETISATION = 8e4
BODY = lissom.Body(0.1, inertia=np.diag([1e-4, 2e-4, 3e-4]))
TABLE = ([0.0, 0.3, 1.0], [[0.0, 0.01, 0.02], [0.03, -0.02, 0.0], [0.01, 0.02, 0.05]])
SWING = lissom.Harmonic((0.01, 0.02, -0.03), 1.5, mean=(0.02, 0.0, 0.01))
BEND = {"bend_y": 3, "bend_z": 2, "torsion": 1, "stretch": 1, "shear_z": 1}


def strip(magnetisation, *, length=L, modes=BEND, radius=R, **more):
    return lissom.Segment(length, radius, E, G, 2000.0, modes, magnetisation=magnetisation, **more)


def free(name, position=(0, 0, 0), joint=None, **more):
    return lissom.Link(name, body=BODY, joint=joint or lissom.Free(), position=position, **more)


def robot(links, **more):
    return lissom.Robot(links, gravity=(0, 0, 0), **more)


def forces(model, q, **at):
    zero = np.zeros(model.n)
    return model.inverse_dynamics(q, zero, zero, **at)


def two_bodies(moments, way, **more):
    """Two free bodies with a dipole each."""
    magnets = [lissom.Magnet(moment, link=name) for moment, name in zip(moments, "ab", strict=True)]
    return robot([free("a"), free("b", way)], magnets=magnets, **more)


def arm(field=(0.02, -0.01, 0.03), *, planar=False, magnets=True, base=(1, 0, 0, 0), **more):
    """Magnetised rods with branches, and magnets on rods and bodies, also beside their axes."""
    modes = {"bend_y": 3, "stretch": 1} if planar else BEND
    along = ([0, 0.05, 0.1], [[3e5, 1e4, 2e5], [1e5, 2e5, -3e5], [-2e5, 0, 1e5]])
    hinge = lissom.Revolute((0, 1, 0))
    links = [
        lissom.Link(
            "upper", rod=[strip(along, modes=modes), strip((0, 0, 2e5), modes=modes)], orientation=base
        ),
        free("side", (0.02, 0, 0.05), joint=hinge, parent="upper", at=0.07),
        lissom.Link(
            "plate", body=BODY, parent="side", position=(0.03, 0, 0.02), orientation=(0.8, 0, 0.6, 0)
        ),
        lissom.Link("lower", rod=[strip((2e5, 1e5, 0), modes=modes)], joint=hinge, parent="upper"),
    ]
    some = [
        lissom.Magnet((0.1, 0.4, 0.2), link="upper", at=0.04),
        lissom.Magnet((0.5, 0.2, -0.3), link="side", position=(0.01, 0, 0.02)),
        lissom.Magnet((-0.2, 0.6, 0.4), link="plate", position=(0, 0, 0.01)),
        lissom.Magnet((0.3, -0.1, 0.2), link="lower"),
    ]
    return robot(links, magnets=some if magnets else [], field=field, **more)


def state(model, seed, size=0.5):
    return size * np.random.default_rng(seed).standard_normal((3, model.n))


def differences(function, q, step=1e-4):
    """Central differences, of fourth order."""

    def column(unit):
        near, far = (function(q + k * step * unit) - function(q - k * step * unit) for k in (1, 2))
        return (8 * near - far) / (12 * step)

    return np.transpose([column(unit) for unit in np.eye(len(q))])


def assert_same(found, expected, rtol):
    np.testing.assert_allclose(found, expected, rtol=0, atol=rtol * np.abs(expected).max())


class TestUniformField:
    @pytest.mark.parametrize("slope", [0.1, 10.0, 45.0, 90.0, 135.0, 170.0])
    @pytest.mark.parametrize("strains", [("bend_y",), ("bend_y", "bend_z", "torsion")])
    def test_a_magnetised_cantilever_is_that_with_a_force_at_its_tip(self, slope, strains):
        # The field turns by 175 degrees from the rod's axis towards -z.
        angle = np.radians(175.0)
        size = reference.load_of_slope(np.radians(slope), angle) * EI / L**2 / (AREA * MAGNETISATION)
        field = (size * np.cos(angle), 0, -size * np.sin(angle))
        segment = strip((MAGNETISATION, 0, 0), modes=dict.fromkeys(strains, 10))
        model = robot([lissom.Link("rod", rod=[segment])], field=field)
        start = np.zeros(model.n)
        start[model.coordinates.index("rod.bend_y[0]")] = np.radians(slope) / L
        found = lissom.statics(model, start)
        assert found.success, found.message
        along = model.pose(found.q, L)[:3, 0]
        assert np.degrees(np.arctan2(-along[2], along[0])) == pytest.approx(slope, rel=1e-7)
        force = np.array(field) * AREA * MAGNETISATION
        pulled = robot([lissom.Link("rod", rod=[strip((0, 0, 0), modes=dict.fromkeys(strains, 10))])])
        pulled = robot(pulled.links, loads=[lissom.Load(force=force)])
        there = lissom.statics(pulled, found.q)
        np.testing.assert_allclose(there.q, found.q, atol=1e-9)

    def test_couples_are_those_on_charges(self):
        moment, field = (0.3, -0.2, 0.5), (0.02, 0.05, -0.01)
        model = robot([free("a")], magnets=[lissom.Magnet(moment)], field=field)
        torque, energy = reference.in_uniform_field(moment, field)
        np.testing.assert_allclose(forces(model, np.zeros(6)), [0, 0, 0, *-torque], atol=1e-17)
        assert model.energy(np.zeros(6), np.zeros(6)).loads == pytest.approx(energy, rel=1e-14)

    def test_a_compass_swings(self):
        joint = lissom.Revolute((0, 0, 1))
        model = robot(
            [free("needle", joint=joint)], magnets=[lissom.Magnet((0.02, 0, 0))], field=(0.05, 0, 0)
        )
        found = lissom.modes(model, [0.0])
        assert found.frequency[0] == pytest.approx(np.sqrt(0.02 * 0.05 / 3e-4) / (2 * np.pi), rel=1e-12)

    @pytest.mark.parametrize("radius", [1e-3, (1.5e-3, 0.5e-3)])
    def test_the_moment_at_the_base_is_that_of_all_sections(self, radius):
        segment = strip(([0, L], [[1e5, 0, 0], [3e5, 0, 0]]), radius=radius, modes={"bend_y": 1})
        model = robot([lissom.Link("rod", rod=[segment])], field=(0, 0, 0.01))
        ends = np.ravel(radius)[[0, -1]]
        x = np.polynomial.Polynomial([0, 1])
        of_radius, of_magnetisation = ends[0] + (ends[1] - ends[0]) * x, 1e5 + 2e5 * x
        total = L * (np.pi * of_radius**2 * of_magnetisation).integ()(1)
        moment = model.joint_wrench([0], [0], [0], link="rod")[:3]
        np.testing.assert_allclose(moment, [0, total * 0.01, 0], rtol=1e-12, atol=1e-20)


class TestBetweenMagnets:
    @pytest.mark.parametrize("signs", [(1, 1), (1, -1)])
    def test_coaxial_dipoles_attract_as_in_textbooks(self, signs):
        first, second, apart = 2.0 * signs[0], 3.0 * signs[1], 0.3
        model = two_bodies([(0, 0, first), (0, 0, second)], (0, 0, apart))
        force = -forces(model, np.zeros(12))
        pull = 3 * reference.MU_0 * first * second / (2 * np.pi * apart**4)
        assert_same(force, [0, 0, pull, 0, 0, 0, 0, 0, -pull, 0, 0, 0], 1e-14)

    @pytest.mark.parametrize("seed", range(5))
    def test_wrenches_and_energy_are_those_of_charges(self, seed):
        first, second, way = np.random.default_rng(seed).standard_normal((3, 3))
        model = two_bodies([first, second], way)
        moment, force, energy = reference.between((first, (0, 0, 0)), (second, way))
        back, opposite, _ = reference.between((second, way), (first, (0, 0, 0)))
        expected = np.concatenate([force, moment, opposite, back])
        assert_same(-forces(model, np.zeros(12)), expected, 1e-9)
        assert model.energy(np.zeros(12), np.zeros(12)).loads == pytest.approx(energy, rel=1e-9)

    def test_a_far_strip_is_a_dipole_and_pushes_back(self):
        magnetisation, moment = (2e5, 1e5, -3e5), (3.0, -1.0, 2.0)
        segment = strip(magnetisation, modes={"bend_y": 1})
        links = [lissom.Link("strip", rod=[segment], joint=lissom.Free()), free("far", (0.3, 4.0, -2.0))]
        model = robot(links, magnets=[lissom.Magnet(moment, link="far")])
        found = -forces(model, np.zeros(model.n))
        expected = np.zeros(12)
        nodes, weights = np.polynomial.legendre.leggauss(8)
        for x, weight in zip((nodes + 1) * L / 2, weights * L / 2, strict=True):
            small = np.multiply(magnetisation, AREA * weight)
            pair = ((small, (x, 0, 0)), (moment, (0.3, 4.0, -2.0)))
            torque, force, _ = reference.between(*pair)
            expected[:3] += force
            expected[3:6] += torque + np.cross((x, 0, 0), force)
            torque, force, _ = reference.between(*pair[::-1])
            expected[6:] += [*force, *torque]
        assert_same(found[[*range(6), *range(7, 13)]], expected, 1e-8)

    def test_a_strip_takes_the_field_of_magnets_on_other_links_alone(self):
        segment = strip((2e5, 0, 0), modes={"bend_y": 2})
        alone = robot([lissom.Link("rod", rod=[segment])], magnets=[lissom.Magnet((0, 0, 1.0))])
        np.testing.assert_array_equal(forces(alone, [0.1, 0.2]), forces(robot(alone.links), [0.1, 0.2]))

    def test_magnets_of_one_rod_act_on_each_other(self):
        magnets = [lissom.Magnet((0, 0, 1.0), at=0.02), lissom.Magnet((0, 0, 1.0), at=0.08)]
        links = [lissom.Link("rod", rod=[strip((0, 0, 0), modes={"stretch": 1})])]
        force = forces(robot(links, magnets=magnets), [0.0])[0]
        push = 3 * reference.MU_0 / (4 * np.pi * 0.06**4)
        assert force == pytest.approx(-push * 0.06, rel=1e-12)

    @pytest.mark.parametrize("method", ["radau", "newmark"])
    def test_two_free_magnets_keep_momentum_and_energy(self, method):
        model = two_bodies([(3, 1, 0), (-1, 2, 2)], (0.1, 0.05, 0.02))
        options = {"rtol": 1e-10, "atol": 1e-12} if method == "radau" else {"dt": 1e-4}
        run = lissom.simulate(model, 0.2, method=method, **options)
        assert run.success, run.message
        assert np.abs(run.v[-1]).max() > 0.5
        momenta = [momentum(model, q, v) for q, v in zip(run.q, run.v, strict=True)]
        tolerance = 1e-9 if method == "radau" else 1e-5
        sizes = [0.1 * np.abs(run.v[-1, 3:6]).max() * 0.1, 3e-4]
        assert np.abs(momenta).max() < tolerance * max(sizes)
        assert run.balance.drift < (1e-8 if method == "radau" else 1e-4)


def momentum(model, q, v):
    """Angular momentum about the origin, and momentum, of two free bodies."""
    sums = np.zeros(6)
    for name in "ab":
        pose = model.pose(q, link=name)
        spin, velocity = np.split(model.velocity(q, v, link=name), 2)
        inertia = pose[:3, :3] @ np.diag([1e-4, 2e-4, 3e-4]) @ pose[:3, :3].T
        sums += [*(inertia @ spin + np.cross(pose[:3, 3], 0.1 * velocity)), *(0.1 * velocity)]
    return sums


class TestAll:
    @pytest.mark.parametrize("seed", range(3))
    @pytest.mark.parametrize("planar", [False, True])
    @pytest.mark.parametrize("magnets", [False, True])
    def test_tangents_are_derivatives_of_forces(self, seed, planar, magnets):
        model = arm(planar=planar, magnets=magnets)
        assert (model.kernel == "planar") == planar
        q, qd, qdd = state(model, seed)
        tangents = model.tangent(q, qd, qdd)
        assert_same(tangents[0], differences(lambda q: model.inverse_dynamics(q, qd, qdd), q), 1e-8)
        assert_same(tangents[1], differences(lambda qd: model.inverse_dynamics(q, qd, qdd), qd), 1e-8)

    @pytest.mark.parametrize("seed", range(3))
    @pytest.mark.parametrize("planar", [False, True])
    def test_forces_are_derivatives_of_the_energy(self, seed, planar):
        model = arm(planar=planar)
        q = state(model, seed)[0]
        rest = np.zeros(model.n)
        of_magnets = forces(model, q) - forces(robot(model.links), q)
        slope = differences(lambda q: model.energy(q, rest).loads, q)
        assert np.abs(of_magnets).max() > 1e-3
        assert_same(of_magnets, slope, 1e-9)

    def test_a_plane_and_space_agree(self):
        planar = arm(planar=True)
        # A joint out of the plane that nothing turns.
        aside = lissom.Link("aside", body=BODY, joint=lissom.Revolute((1, 0, 0)))
        space = robot([*planar.links, aside], magnets=planar.magnets, field=planar.field)
        assert space.kernel == "spatial"
        q = state(planar, 5)[0]
        assert_same(forces(space, [*q, 0])[:-1], forces(planar, q), 1e-11)
        rest = np.zeros(planar.n)
        energies = [planar.energy(q, rest).loads, space.energy([*q, 0], [*rest, 0]).loads]
        assert energies[1] == pytest.approx(energies[0], rel=1e-12)

    @pytest.mark.parametrize("field", [TABLE, SWING, lambda t: (0.1 * t, 0.02, t * t)])
    def test_at_every_time_forces_are_those_of_the_field_then(self, field):
        moving, t = arm(field), 0.21
        if callable(field):
            value = field(t)
        elif field is SWING:
            value = np.array(SWING.mean) + np.array(SWING.amplitude) * np.sin(2 * np.pi * 1.5 * t)
        else:
            value = [np.interp(t, TABLE[0], column) for column in np.transpose(TABLE[1])]
        q, qd, qdd = state(moving, 1)
        still = arm(value)
        assert_same(moving.inverse_dynamics(q, qd, qdd, t=t), still.inverse_dynamics(q, qd, qdd), 1e-13)
        for a, b in zip(moving.tangent(q, qd, qdd, t=t), still.tangent(q, qd, qdd), strict=True):
            assert_same(a, b, 1e-13)

    def test_inputs_have_exact_derivatives(self):
        model = arm(lissom.Input("B", (0.01, 0.02, 0.03)))
        assert model.inputs == ("B.x", "B.y", "B.z")
        q, qd, qdd = state(model, 2)
        u = np.array([0.05, -0.02, 0.01])
        assert_same(model.inverse_dynamics(q, qd, qdd, u=u), arm(u).inverse_dynamics(q, qd, qdd), 1e-13)
        expected = differences(lambda u: model.inverse_dynamics(q, qd, qdd, u=u), u)
        assert_same(model.input_tangent(q, qd, qdd, u=u), expected, 1e-9)

    def test_fields_are_those_of_the_world(self):
        turned = (0.5, 0.5, 0.5, 0.5)  # x to y, y to z, z to x
        q = state(arm(), 3)[0]
        assert_same(
            forces(arm((0.03, 0.01, 0.02), base=turned), q), forces(arm((0.01, 0.02, 0.03)), q), 1e-12
        )

    def test_fields_stay_where_they_are_while_the_base_turns(self):
        turn = lissom.BaseMotion(axis=(0, 0, 1), angle=lissom.Harmonic(rate=2.0))
        t, field = 0.3, (0.03, 0.01, 0.02)
        q, qd, qdd = state(arm(), 6)
        moving = [arm(field, base_motion=turn), arm((0, 0, 0), base_motion=turn)]
        still = [arm(size, base=(np.cos(t), 0, 0, np.sin(t))) for size in (field, (0, 0, 0))]
        in_motion = [model.inverse_dynamics(q, qd, qdd, t=t) for model in moving]
        at_rest = [model.inverse_dynamics(q, qd, qdd) for model in still]
        assert_same(np.subtract(*in_motion), np.subtract(*at_rest), 1e-10)
        energies = [model.energy(q, qd, t=t).loads for model in (moving[0], still[0])]
        assert energies[0] == pytest.approx(energies[1], rel=1e-12)

    @pytest.mark.parametrize("field", [(0.05, 0, 0.02), SWING, TABLE])
    def test_energy_is_balanced(self, field):
        segment = strip((2e5, 0, 1e5), modes={"bend_y": 3, "bend_z": 2}, retardation_time=0.1, nodes=32)
        links = [
            lissom.Link("rod", rod=[segment]),
            free("side", (0.1, 0.04, 0), joint=lissom.Revolute((0, 0, 1))),
        ]
        magnets = [lissom.Magnet((0, 0.5, 0.1), link="side"), lissom.Magnet((0.02, 0, 0), link="rod")]
        model = robot(links, magnets=magnets, field=field)
        run = lissom.simulate(model, 0.4, method="radau", rtol=1e-7, atol=1e-9)
        assert run.success, run.message
        assert run.balance.moves
        assert run.balance.drift < 1e-8
        assert (np.ptp(run.balance.work) > 0) == (field is SWING or field is TABLE)

    def test_runs_have_derivatives_with_respect_to_all_of_it(self):
        def model(moment, magnetisation, radius, size):
            segment = strip((magnetisation, 0, 0), modes={"bend_y": 3}, radius=radius, retardation_time=0.05)
            links = [
                lissom.Link("rod", rod=[segment]),
                free("far", (0.2, 0, 0.05), joint=lissom.Prismatic((0, 0, 1))),
            ]
            magnets = [lissom.Magnet((0, 0, moment), link="far"), lissom.Magnet((0.01, 0, 0), link="rod")]
            return robot(links, magnets=magnets, field=(0, 0, size))

        def end(values):
            return lissom.simulate(model(*values), 0.05, dt=1e-3, rtol=1e-13).q[-1]

        values = np.array([1.0, 1e4, R, 0.01])
        names = [
            "magnets[0].moment[2]",
            "links[0].rod[0].magnetisation[0]",
            "links[0].rod[0].radius",
            "field[2]",
        ]
        found = lissom.sensitivity(model(*values), 0.05, names, dt=1e-3, rtol=1e-13).dq[-1]
        expected = differences(lambda relative: end(values * (1 + relative)), np.zeros(4), 1e-3) / values
        for k in range(len(names)):
            assert_same(found[:, k], expected[:, k], 1e-6)

    def test_what_is_computed_is_explained(self):
        text = arm().explain()
        assert re.search(r"uniform magnetic field +turns 4 magnets and 3 magnetised segments; has a", text)
        assert re.search(r"forces between magnets +of dipoles, pair by pair", text)
        assert "magnet" not in robot([free("a")]).explain()


class TestDescription:
    def test_robots_are_pickled_and_saved_as_scenes(self):
        for field in ((0.02, -0.01, 0.03), SWING, TABLE):
            model = arm(field)
            q, qd, qdd = state(model, 4)
            scene = model.to_scene(q0=q)
            for other in (pickle.loads(pickle.dumps(model)), scene.model):
                np.testing.assert_array_equal(
                    other.inverse_dynamics(q, qd, qdd, t=0.2), model.inverse_dynamics(q, qd, qdd, t=0.2)
                )

    def test_rods_feel_what_links_feel(self):
        segments, field = [strip((2e5, 1e5, 0)), strip((0, 0, 2e5))], SWING
        magnets = [lissom.Magnet((0.1, 0.4, 0.2), at=0.04), lissom.Magnet((0.5, 0.2, -0.3))]
        rod = lissom.Rod(segments, gravity=(0, 0, 0), magnets=magnets, field=field)
        linked = robot([lissom.Link("rod", rod=segments)], magnets=magnets, field=field)
        q, qd, qdd = state(rod, 5)
        expected = linked.inverse_dynamics(q, qd, qdd, t=0.3)
        assert np.abs(expected - robot(linked.links).inverse_dynamics(q, qd, qdd)).max() > 1e-5
        for model in (rod, pickle.loads(pickle.dumps(rod)), rod.to_scene(q0=q).model):
            np.testing.assert_array_equal(model.inverse_dynamics(q, qd, qdd, t=0.3), expected)
            assert (model.magnets, model.field) == (tuple(magnets), field)
        with pytest.raises(ValueError, match=r"magnets\[0\].at: got 0.3"):
            lissom.Rod(segments, magnets=[lissom.Magnet((0, 0, 1), at=0.3)])

    @pytest.mark.parametrize(
        ("magnet", "message"),
        [
            ({"moment": (0, 0, 1), "link": "b"}, "magnets[0].link: got 'b', expected"),
            ({"moment": (0, 0, 1), "at": 0.3}, "magnets[0].at: got 0.3, expected an arc length in [0, 0.1]"),
            ({"moment": (0, 0, np.nan)}, "moment[2]: got NaN, expected a finite number (A m^2)"),
        ],
    )
    def test_wrong_magnets_are_refused(self, magnet, message):
        with pytest.raises(ValueError, match=re.escape(message)):
            robot([lissom.Link("rod", rod=[strip((0, 0, 0))])], magnets=[lissom.Magnet(**magnet)])

    def test_a_given_section_has_no_magnetisation(self):
        section = lissom.Section.given(np.eye(6), 1.0, np.eye(3))
        with pytest.raises(ValueError, match="magnetisation"):
            lissom.Segment(0.1, section=section, modes={"bend_y": 1}, magnetisation=(1, 0, 0))

    def test_a_field_that_is_not_finite_is_refused(self):
        with pytest.raises(ValueError, match=r"field\[2\]: got inf"):
            robot([free("a")], field=(0, 0, np.inf))


@pytest.mark.parametrize("start", [0.3, 1.0, 10.0])
def test_no_equilibrium_is_infinitely_far_away(start):
    """Forces of dipoles fade: Newton's method goes where they are no numbers any more."""
    fixed, moving = lissom.Body(1.0), lissom.Body(1.0)
    links = [
        lissom.Link("fixed", body=fixed),
        lissom.Link("moving", joint=lissom.Prismatic((1, 0, 0)), body=moving),
    ]
    magnets = [lissom.Magnet((10.0, 0, 0), link=name) for name in ("fixed", "moving")]
    contact = lissom.Contact(lissom.Ball("moving", 0.1), lissom.Sphere((0, 0, 0), 0.1), stiffness=1e3)
    robot = lissom.Robot(links, magnets=magnets, gravity=(0, 0, 0), contacts=[contact])
    found = lissom.statics(robot, [start], method="newton")
    assert not found.success or abs(found.q[0]) < 1.0
