"""The tendon arm by SoRoMoX's geometric variable strain model (GVS), with the same modes as lissom's."""

import diffrax
import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
import tendon_arm as arm  # noqa: E402
from soromox.actuation import ThreadlikeActuator, ThreadlikeRouting  # noqa: E402
from soromox.systems import GVS  # noqa: E402
from soromox.systems.components import JointSpec, LinkSpec  # noqa: E402
from soromox.systems.gvs import GVSSegment, StrainBasisSpec  # noqa: E402

STRAIGHT = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
# Of torsion and bending; stretch and shear have none.
FREE = [1, 1, 1, 0, 0, 0]
HIGHEST = arm.MODES - 1
# Quadrature nodes of a segment.
FEWEST_NODES = 5
# Of Newton's iterations.
RTOL, ATOL = 1e-4, 1e-6


def robot(nodes: int) -> GVS:
    """With so many quadrature nodes a segment."""
    segment = GVSSegment(
        link=LinkSpec.circular(
            length=arm.LENGTH / arm.SEGMENTS,
            radius=arm.RADIUS,
            density=arm.DENSITY,
            reference_strain=STRAIGHT,
            young_modulus=arm.YOUNG_MODULUS,
            shear_modulus=arm.SHEAR_MODULUS,
            material_damping_coefficient=arm.RETARDATION_TIME * arm.SHEAR_MODULUS,
        ),
        joint=JointSpec.fixed(),
        basis=StrainBasisSpec("legendre", FREE, [HIGHEST * free for free in FREE]),
        num_gauss_points=nodes,
    )
    routing = ThreadlikeRouting.linear(
        intercept=jnp.array([(0.0, *offset) for offset in arm.OFFSETS]),
        start_segment_index=0,
        end_segment_index=arm.SEGMENTS - 1,
    )
    return GVS.from_segments(
        [segment] * arm.SEGMENTS,
        gravity=jnp.array(arm.GRAVITY),
        # No turn: the scalar of a quaternion last, then the position.
        base_pose=jnp.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        actuators=[ThreadlikeActuator.tendons(routing)],
        # Coordinates are strains in 1/m, as lissom's.
        scale_rotational_basis_by_length=False,
    )


def deviations(nodes: int) -> dict[str, float]:
    """From lissom, largest entries relative to the largest ones, in a bent and twisted state that moves."""
    ours, theirs = arm.arm(), robot(nodes)
    random = np.random.default_rng(0)
    size = np.tile(np.repeat([1.0, 3.0, 3.0], arm.MODES), arm.SEGMENTS)
    q, v = size * random.normal(size=ours.n), 5.0 * random.normal(size=ours.n)
    u = random.uniform(0.0, 2.0 * arm.PULL, len(arm.OFFSETS))
    end = jnp.asarray(arm.LENGTH)

    @jax.jit
    def evaluated(q, v, u):
        state = jnp.concatenate([q, v])
        return (
            theirs.actuation_force(q, u),
            theirs.forward_kinematics(q, end)[:3, 3],
            theirs.forward_dynamics(0.0, state, (u,))[q.size :],
        )

    pairs = zip(
        ("tendons", "tip", "accelerations"),
        evaluated(*map(jnp.asarray, (q, v, u))),
        (
            -ours.input_tangent(q) @ u,
            ours.pose(q)[:3, 3],
            ours.forward_dynamics(q, v, u=u),
        ),
        strict=True,
    )
    return {name: float(np.abs(found - own).max() / np.abs(own).max()) for name, found, own in pairs}


def stepper(method: str, substeps: int):
    """One control step as a compiled function of state and tensions: so many steps, all alike.

    The Newton iterations of Kvaerno3, which is implicit, keep the Jacobian of a step.
    """
    theirs = robot(FEWEST_NODES)
    term = diffrax.ODETerm(lambda t, state, u: theirs.forward_dynamics(t, state, (u,)))
    solver = {
        "Tsit5": diffrax.Tsit5(),
        "Kvaerno3": diffrax.Kvaerno3(root_finder=diffrax.VeryChord(rtol=RTOL, atol=ATOL)),
    }[method]

    @jax.jit
    def step(state, u):
        solution = diffrax.diffeqsolve(
            term,
            solver,
            t0=0.0,
            t1=arm.CONTROL_STEP,
            dt0=arm.CONTROL_STEP / substeps,
            y0=state,
            args=u,
            saveat=diffrax.SaveAt(t1=True),
            max_steps=substeps + 1,
            throw=False,
        )
        # A Newton iteration that does not converge ends a motion; its state is not that of the end.
        failed = solution.result != diffrax.RESULTS.successful
        return jnp.where(failed, jnp.nan, solution.ys[-1])

    return step


def moved(step, coordinates: int, inputs: np.ndarray) -> np.ndarray:
    """Coordinates after every control step from the start, read after each."""
    state = jnp.zeros(2 * coordinates)
    q = np.empty((len(inputs), coordinates))
    for index, u in enumerate(inputs):
        state = step(state, u)
        q[index] = np.asarray(state)[:coordinates]
    return q
