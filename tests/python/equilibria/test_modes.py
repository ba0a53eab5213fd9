"""Natural modes and linear models: beam theory, independent eigenvalues, differences, simulated motions."""

import inspect

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.signal import StateSpace, lsim
from scipy.spatial.transform import Rotation

import lissom
from reference import modes as reference
from rod_cases import random_rods, seeds


def wire(modes, *, retardation_time=0.0, nodes=None, **loads):
    segment = lissom.Segment(
        1.0, 1e-3, 210e9, 80e9, 7800, modes=modes, retardation_time=retardation_time, nodes=nodes
    )
    return lissom.Rod([segment], **loads)


class TestFrequencies:
    @pytest.mark.parametrize(
        ("modes", "published"),
        [(3, [1.452225, 9.18028, 48.78]), (6, [1.451787, 9.098290, 25.48286])],
    )
    def test_lab_wire(self, modes, published):
        found = lissom.modes(wire({"bend_y": modes}, gravity=(0, 0, 0)), np.zeros(modes))
        np.testing.assert_allclose(found.frequency[:3], published, rtol=2e-6, atol=6e-3 if modes == 3 else 0)

    def test_beam_theory(self):
        """Up to a few times the rotary inertia, (r / L)^2."""
        found = lissom.modes(wire({"bend_y": 14}, nodes=32, gravity=(0, 0, 0)), np.zeros(14))
        exact = reference.cantilever(210e9 * np.pi / 4 * 1e-12, 7800 * np.pi * 1e-6, 1.0, 5)
        np.testing.assert_allclose(found.frequency[:5], exact, rtol=5e-4)
        np.testing.assert_allclose(exact[:3], [1.451788, 9.098201, 25.475226], atol=1e-6)

    def test_slow_modes_are_exact_beside_shear_waves(self):
        """Shear of a wire vibrates some millions of times faster."""
        alone = lissom.modes(wire({"bend_y": 6}, gravity=(0, 0, 0)), np.zeros(6))
        names = {"bend_y": 6, "stretch": 4, "shear_z": 6}
        model = wire(names, nodes=24, gravity=(0, 0, 0))
        found = lissom.modes(model, np.zeros(model.n))
        assert found.frequency[-1] > 1e5 * found.frequency[0]
        np.testing.assert_allclose(found.frequency[:2], alone.frequency[:2], rtol=1e-4)

    def test_pendulum(self):
        """Small swings of a hanging mass on a spring: sqrt(g / r) and sqrt(k / m)."""
        pendulum = lissom.SpringPendulum()
        found = lissom.modes(pendulum, lissom.statics(pendulum).q)
        np.testing.assert_allclose(found.angular_frequency, np.sqrt([9.81 / 1.981, 10.0]), rtol=1e-12)
        assert found.is_classical
        assert found.is_stable
        assert (found.damping_ratio == 0).all()

    def test_a_pendulum_that_stands_falls(self):
        found = lissom.modes(lissom.SpringPendulum(), [np.pi / 2, -0.981])
        assert not found.is_stable
        assert found.frequency[0] == 0
        assert found.eigenvalues[0] == pytest.approx(np.sqrt(9.81 / 0.019))

    def test_under_an_axial_load(self):
        """The lowest frequency of a column vanishes at its buckling load, its square nearly linearly."""
        euler = np.pi**2 / 4 * 210e9 * np.pi / 4 * 1e-12
        squares = []
        for ratio in (0.0, 0.5, 1.0):
            model = wire({"bend_y": 8}, nodes=24, gravity=(0, 0, 0), tip_force=(-ratio * euler, 0, 0))
            squares.append(lissom.modes(model, np.zeros(8)).frequency[0] ** 2)
        assert squares[1] / squares[0] == pytest.approx(0.5, abs=0.03)
        assert squares[2] / squares[0] < 1e-5


class TestDamping:
    def test_proportional_damping_is_classical(self):
        """Kelvin-Voigt: damping ratio mu omega / 2 in every mode of an unloaded rod, also if overdamped."""
        mu = 1e-2
        found = lissom.modes(wire({"bend_y": 4}, retardation_time=mu, gravity=(0, 0, 0)), np.zeros(4))
        assert found.is_classical
        np.testing.assert_allclose(found.damping_ratio, mu * found.angular_frequency / 2, rtol=1e-9)
        assert found.damping_ratio[-1] > 1
        exact = found.angular_frequency**2
        s = found.eigenvalues
        np.testing.assert_allclose(s**2 + mu * exact * s + exact, 0, atol=1e-6 * exact.max())
        assert (s.real < 0).all()

    def test_two_materials_couple(self):
        soft = lissom.Segment(0.2, 0.01, 1e6, 4e5, 1000, modes={"bend_y": 2}, retardation_time=0.05)
        hard = lissom.Segment(0.2, 0.01, 4e6, 1.6e6, 1000, modes={"bend_y": 2})
        model = lissom.Rod([soft, hard])
        found = lissom.modes(model, lissom.statics(model).q)
        assert not found.is_classical
        assert found.shapes.dtype == complex
        assert model.n <= len(found.frequency) <= 2 * model.n
        mass = model.mass_matrix(lissom.statics(model).q)
        np.testing.assert_allclose(
            np.einsum("im,ij,jm->m", found.shapes.conj(), mass, found.shapes), 1, rtol=1e-9
        )
        # What decays by exp(-d w t) at the frequency w.
        sizes = np.abs(found.eigenvalues)
        np.testing.assert_allclose(found.angular_frequency, sizes, rtol=1e-12)
        np.testing.assert_allclose(found.damping_ratio, -found.eigenvalues.real / sizes, rtol=1e-12)

    @settings(max_examples=25)
    @given(random_rods(), seeds)
    def test_eigenvalues_are_those_of_numpy(self, case, seed):
        model = case.lissom
        q = np.random.default_rng(seed).normal(scale=0.1, size=model.n) * case.coordinate_scale
        found = lissom.modes(model, q)
        zero = np.zeros(model.n)
        K, D, M = model.tangent(q, zero, zero)
        shapes, s = found.shapes, found.eigenvalues
        left = M @ shapes * s**2 + D @ shapes * s + K @ shapes
        sizes = (
            np.abs(M) @ np.abs(shapes) * np.abs(s) ** 2
            + np.abs(D) @ np.abs(shapes) * np.abs(s)
            + np.abs(K) @ np.abs(shapes)
        )
        assert np.abs(left).max() <= 1e-4 * sizes.max()
        assert (np.diff(found.frequency) >= -1e-9 * found.frequency.max()).all()

    def test_a_moment_fixed_in_space_has_no_potential(self):
        model = wire({"torsion": 2, "bend_y": 3, "bend_z": 3}, gravity=(0, 0, 0), tip_moment=(0.05, 0, 0))
        q = lissom.statics(model).q
        found = lissom.modes(model, q)
        exact = reference.eigenvalues(*reference.matrices(model, q))
        wanted = exact[exact.imag >= 0]
        near = np.abs(found.eigenvalues[:, None] - wanted[None]).min(axis=1)
        assert (near <= 1e-4 * np.abs(found.eigenvalues)).all()


class TestShapes:
    def test_orthogonal_with_modal_mass_one(self):
        model = wire({"bend_y": 4, "bend_z": 3, "torsion": 2})
        q = lissom.statics(model).q
        found = lissom.modes(model, q)
        zero = np.zeros(model.n)
        stiffness = model.tangent(q, zero, zero)[0]
        shapes = found.shapes
        np.testing.assert_allclose(shapes.T @ model.mass_matrix(q) @ shapes, np.eye(model.n), atol=1e-9)
        modal = shapes.T @ stiffness @ shapes
        np.testing.assert_allclose(modal.diagonal(), found.angular_frequency**2, rtol=1e-9)

    def test_a_motion_in_the_first_mode_has_its_frequency(self):
        model = wire({"bend_y": 3})
        q = lissom.statics(model).q
        found = lissom.modes(model, q)
        shape = found.shapes[:, 0]
        period = 1 / found.frequency[0]
        motion = lissom.simulate(
            model,
            period,
            q0=q + 1e-5 * shape,
            method="dop853",
            rtol=1e-10,
            atol=1e-13,
            t_eval=[0, period / 2, period],
        )
        np.testing.assert_allclose(motion.q[1], q - 1e-5 * shape, atol=1e-8)
        np.testing.assert_allclose(motion.q[2], q + 1e-5 * shape, atol=1e-8)


class TestModesFail:
    def test_without_mass(self):
        with pytest.raises(lissom.LissomError, match="mass matrix at q is not positive definite"):
            lissom.modes(lissom.SpringPendulum(gravity=0.0), [0.0, -1.0])

    def test_not_finite(self):
        model = wire({"bend_y": 1, "stretch": 1})
        with pytest.raises(lissom.LissomError, match="NaN or infinite"):
            lissom.modes(model, [1.0, 1e308])

    def test_wrong_arguments(self):
        with pytest.raises(ValueError, match="q: expected 2 values, got 3"):
            lissom.modes(lissom.SpringPendulum(), [0, 0, 0])
        with pytest.raises(TypeError, match="model: expected a Model"):
            lissom.modes("wire", [0])
        with pytest.raises(ValueError, match="t: got NaN"):
            lissom.modes(lissom.SpringPendulum(), [0, 0], t=np.nan)

    def test_where_there_is_no_equilibrium(self):
        found = lissom.modes(wire({"bend_y": 2}), [0, 0])
        assert found.residual_norm > 1e-3
        assert lissom.modes(wire({"bend_y": 2}, gravity=(0, 0, 0)), [0, 0]).residual_norm == 0
        assert repr(found).startswith("<ModesResult: 2 modes, stable, ")
        with pytest.raises(AttributeError):
            found.frequency = 1


class TestJacobian:
    @settings(max_examples=25)
    @given(random_rods(), seeds)
    def test_is_the_derivative_of_the_pose(self, case, seed):
        model = case.lissom
        random = np.random.default_rng(seed)
        q = random.normal(scale=0.3, size=model.n) * case.coordinate_scale
        X = random.uniform(0, model.length)
        jacobian = model.jacobian(q, X)
        for k in range(model.n):
            step = 1e-6 * case.coordinate_scale[k] * np.eye(model.n)[k]
            ahead, behind = model.pose(q + step, X), model.pose(q - step, X)
            size = 2 * step[k]
            turn = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec() / size
            velocity = (ahead[:3, 3] - behind[:3, 3]) / size
            scale = 1 / case.coordinate_scale[k]
            np.testing.assert_allclose(jacobian[:3, k], turn, atol=1e-7 * scale)
            np.testing.assert_allclose(jacobian[3:, k], velocity, atol=1e-7 * scale * max(1.0, model.length))

    def test_its_transpose_makes_generalised_forces(self):
        q = np.array([0.3, -0.2, 0.5, 0.1])
        free = wire({"bend_y": 2, "bend_z": 2}, gravity=(0, 0, 0))
        loaded = wire(
            {"bend_y": 2, "bend_z": 2}, gravity=(0, 0, 0), tip_force=(1, 2, 3), tip_moment=(4, 5, 6)
        )
        zero = np.zeros(4)
        difference = free.inverse_dynamics(q, zero, zero) - loaded.inverse_dynamics(q, zero, zero)
        np.testing.assert_allclose(free.jacobian(q, 1.0).T @ [4, 5, 6, 1, 2, 3], difference, atol=1e-9)

    def test_wrong_arguments(self):
        with pytest.raises(ValueError, match=r"X: got 2, expected an arc length in \[0, 1\]"):
            wire({"bend_y": 1}).jacobian([0], 2.0)
        with pytest.raises(ValueError, match="q: expected 1 values"):
            wire({"bend_y": 1}).jacobian([0, 0], 1.0)


class TestLinearModels:
    @pytest.mark.parametrize("inertia", [0.0, 0.1])
    def test_a_pendulum_beside_its_equilibrium_is_no_linear_model(self, inertia):
        """The body is beside the axis, and the frame of the link on it."""
        body = lissom.Body(1.0, centre=(0.5, 0, 0), inertia=inertia * np.eye(3))
        pendulum = lissom.Robot([lissom.Link("arm", joint=lissom.Revolute((0, 1, 0)), body=body)])
        for angle in (0.0, 1.0, np.pi / 2 + 0.01):
            with pytest.warns(lissom.AccuracyWarning, match="q is no equilibrium"):
                lissom.linearise(pendulum, [angle])
        lissom.linearise(pendulum, [np.pi / 2])

    def test_defaults_are_the_documented_ones(self):
        model = wire({"bend_y": 2})
        given = {
            name: parameter.default
            for name, parameter in inspect.signature(lissom.linearise).parameters.items()
            if name not in ("model", "q")
        }
        assert given == {"inputs": "forces", "outputs": "coordinates", "t": 0.0, "u": None, "held": False}
        linear = lissom.linearise(model, [0, 0], held=True)
        assert linear.states == ("q0", "q1", "v0", "v1")
        assert linear.inputs == ("force0", "force1")
        assert linear.outputs == ("q0", "q1")
        np.testing.assert_array_equal(linear.C, np.eye(2, 4))
        np.testing.assert_array_equal(linear.D, 0)

    def test_is_the_derivative_of_the_forward_dynamics(self):
        model = wire({"bend_y": 3, "bend_z": 2, "torsion": 1}, retardation_time=1e-3)
        q, n = lissom.statics(model).q, model.n
        linear = lissom.linearise(model, q)
        for k in range(2 * n):
            step = 1e-5 * np.eye(2 * n)[k]
            ahead = model.forward_dynamics(q + step[:n], step[n:])
            behind = model.forward_dynamics(q - step[:n], -step[n:])
            column = (ahead - behind) / 2e-5
            np.testing.assert_allclose(linear.A[n:, k], column, atol=1e-6 * np.abs(linear.A).max())
        eigenvalues = np.linalg.eigvals(linear.A)
        for s in lissom.modes(model, q).eigenvalues[:3]:
            assert np.abs(eigenvalues - s).min() < 1e-6 * abs(s)

    def test_a_small_push_at_the_tip(self):
        """The step response to a force, compared with the simulated motion of the full model."""
        push = 1e-6
        damped = {"retardation_time": 1e-2}
        model = wire({"bend_y": 3}, **damped)
        pushed = wire({"bend_y": 3}, **damped, tip_force=(0, 0, push))
        q = lissom.statics(model).q
        linear = lissom.linearise(
            model, q, inputs=["tip_force_z"], outputs=["tip_position", "tip_rotation_y", "tip_velocity_z"]
        )
        assert linear.outputs == (*(f"tip_position_{i}" for i in "xyz"), "tip_rotation_y", "tip_velocity_z")
        t = np.linspace(0, 0.5, 101)
        response = lsim(StateSpace(*linear), np.full(len(t), push), t)[1]
        motion = lissom.simulate(pushed, 0.5, q0=q, method="radau", rtol=1e-10, atol=1e-14, t_eval=t)
        poses = model.pose(motion.q, 1.0)
        moved = poses[:, :3, 3] - model.pose(q, 1.0)[:3, 3]
        np.testing.assert_allclose(response[:, :3], moved, atol=2e-3 * np.abs(moved).max())
        velocity = [model.jacobian(q, 1.0)[5] @ v for q, v in zip(motion.q, motion.v, strict=True)]
        np.testing.assert_allclose(response[:, 4], velocity, atol=2e-3 * np.abs(velocity).max())
        settled = lissom.statics(pushed).q - q
        np.testing.assert_allclose(
            -linear.C[:, :3] @ np.linalg.solve(linear.A, linear.B)[:3, 0] * push,
            linear.C[:, :3] @ settled,
            rtol=1e-3,
            atol=1e-12,
        )

    def test_python_control_takes_it(self):
        import control

        linear = lissom.linearise(lissom.SpringPendulum(), [-np.pi / 2, 0.981])
        system = control.ss(*linear)
        np.testing.assert_allclose(
            np.sort(np.abs(system.poles().imag)), np.sqrt([9.81 / 1.981, 9.81 / 1.981, 10, 10])
        )

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (
                {"inputs": "wind"},
                "inputs: got 'wind', expected 'forces', 'tip_force', 'tip_moment' or a component",
            ),
            ({"outputs": ["tip_position_w"]}, "outputs: got 'tip_position_w', expected"),
            ({"inputs": []}, "inputs: got none"),
        ],
    )
    def test_wrong_arguments(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            lissom.linearise(wire({"bend_y": 1}), [0], **arguments)

    def test_shapes_that_no_node_resolves_are_refused_as_by_modes(self):
        model, q = wire({"bend_y": 2}), [1e4, 0.0]
        for function in (lissom.modes, lissom.linearise):
            with pytest.raises(ValueError, match="q: got a rod that turns by more than half a turn between"):
                function(model, q)
        with pytest.raises(ValueError, match="more `nodes`, at least"):
            model.check_shape(q)
        assert model.check_shape([1.0, 0.0]) is None

    def test_a_pendulum_has_no_tip(self):
        with pytest.raises(ValueError, match="expected 'forces' or a component"):
            lissom.linearise(lissom.SpringPendulum(), [0, 0], inputs="tip_force")
        with pytest.raises(TypeError, match="model: expected a Model"):
            lissom.linearise("wire", [0])
        with pytest.raises(lissom.LissomError, match="mass matrix"):
            lissom.linearise(lissom.SpringPendulum(gravity=0.0), [0.0, -1.0])
