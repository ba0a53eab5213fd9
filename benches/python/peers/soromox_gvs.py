"""SoRoMoX's own two-segment case and the rubber rod, by its geometric variable strain model (GVS)."""

import time
from functools import partial

import diffrax
import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from cases import (  # noqa: E402
    DURATION,
    GRAVITY,
    LONGEST_RUN,
    QUICK_LONGEST_RUN,
    RUBBER_ROD,
    SEGMENT,
    SEGMENT_GRAVITY,
    SEGMENT_ORIENTATION,
    SEGMENT_VISCOSITY,
    SEGMENTS,
    TIMES,
    Rod,
    on_one_core,
    packages,
    print_run,
    quick_requested,
    record,
    shortest,
)
from soromox.systems import GVS, SystemState  # noqa: E402
from soromox.systems.components import JointSpec, LinkSpec  # noqa: E402
from soromox.systems.gvs import GVSSegment, StrainBasisSpec  # noqa: E402

STRAIGHT = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
# Torsion, bending about y and z, stretch, shear along y and z.
STRAINS = 6
BEND_Y, BEND_Z, STRETCH, SHEAR_Z = 1, 2, 3, 5
# Quadrature nodes of each of the two segments: those of SoRoMoX's own benchmark, and twice as many.
SEGMENT_NODES = (5, 10)

# Modes of bending, stretch and shear of the rubber rod, and quadrature nodes.
RUBBER_ROD_MODES = ((4, 0, 0, 8), (4, 1, 1, 8), (5, 2, 2, 10), (5, 3, 3, 10), (6, 3, 3, 12), (8, 6, 6, 16))
# ("fixed", step) or ("adaptive", tolerance); 1e-4 is the step of SoRoMoX's own benchmark.
TWO_SEGMENT_STEPS = (
    ("fixed", 4e-4),
    ("fixed", 2e-4),
    ("fixed", 1e-4),
    ("adaptive", 1e-2),
    ("adaptive", 1e-3),
    ("adaptive", 1e-5),
)
RUBBER_ROD_STEPS = (("fixed", 5e-4), ("fixed", 2.5e-4), ("adaptive", 1e-3), ("adaptive", 1e-5))
FIRST_ADAPTIVE_STEP = 1e-4


def segment(rod: Rod, modes: dict[int, int], nodes: int, viscosity: float | None) -> GVSSegment:
    """A segment with so many Legendre polynomials of each strain."""
    return GVSSegment(
        link=LinkSpec.circular(
            length=rod.length,
            radius=rod.radius,
            density=rod.density,
            reference_strain=STRAIGHT,
            young_modulus=rod.young_modulus,
            shear_modulus=rod.shear_modulus,
            material_damping_coefficient=viscosity,
        ),
        joint=JointSpec.fixed(),
        basis=StrainBasisSpec(
            "legendre",
            [int(modes.get(strain, 0) > 0) for strain in range(STRAINS)],
            [max(modes.get(strain, 0) - 1, 0) for strain in range(STRAINS)],
        ),
        num_gauss_points=nodes,
    )


def base_pose(orientation: tuple[float, float, float, float]) -> jax.Array:
    """SoRoMoX writes the scalar of a quaternion last, then the position."""
    w, x, y, z = orientation
    return jnp.array([x, y, z, w, 0.0, 0.0, 0.0])


def two_segments(nodes: int) -> GVS:
    own = segment(SEGMENT, {BEND_Y: 2, BEND_Z: 2, STRETCH: 2}, nodes, SEGMENT_VISCOSITY)
    return GVS.from_segments(
        [own] * SEGMENTS, gravity=jnp.array(SEGMENT_GRAVITY), base_pose=base_pose(SEGMENT_ORIENTATION)
    )


def rubber_rod(bending: int, stretch: int, shear: int, nodes: int) -> GVS:
    own = segment(RUBBER_ROD, {BEND_Y: bending, STRETCH: stretch, SHEAR_Z: shear}, nodes, None)
    return GVS.from_segments(
        [own], gravity=jnp.array([0.0, 0.0, -GRAVITY]), base_pose=base_pose((1.0, 0.0, 0.0, 0.0))
    )


def compiled(robot: GVS, length: float, kind: str, value: float):
    """The whole motion as one compiled function, and how long it took to compile."""
    adaptive = kind == "adaptive"
    controller = diffrax.PIDController(rtol=value, atol=value) if adaptive else diffrax.ConstantStepSize()
    tip = jax.vmap(lambda q: robot.forward_kinematics(q, jnp.asarray(length))[:3, 3])
    coordinates = int(robot.num_velocities)

    @jax.jit
    def tips_of(state):
        motion = robot.rollout_to(
            SystemState(t=0.0, y=state),
            t1=DURATION,
            solver_dt=FIRST_ADAPTIVE_STEP if adaptive else value,
            save_ts=jnp.asarray(TIMES),
            solver=diffrax.Tsit5(),
            stepsize_controller=controller,
            max_steps=None,
        )
        return tip(motion.y[:, :coordinates])

    at_rest = jnp.zeros(2 * coordinates)
    start = time.perf_counter()
    executable = tips_of.lower(at_rest).compile()
    compile_seconds = time.perf_counter() - start
    return lambda: np.asarray(jax.block_until_ready(executable(at_rest))), compile_seconds


def measure(
    make, length: float, case: str, discretisation: str, kind: str, value: float, longest: float
) -> dict:
    run, compile_seconds = compiled(make(), length, kind, value)
    tips, seconds = shortest(run, longest)
    step = f"Tsit5, dt = {value:.2e}" if kind == "fixed" else f"Tsit5, rtol = {value:.0e}"
    return record(case, "SoRoMoX", discretisation, step, seconds, tips, compile_seconds)


def main() -> None:
    quick = quick_requested(__doc__)
    on_one_core()
    longest = QUICK_LONGEST_RUN if quick else LONGEST_RUN
    packages("soromox", "jax", "diffrax", "numpy")
    for nodes in SEGMENT_NODES[:1] if quick else SEGMENT_NODES:
        for kind, value in TWO_SEGMENT_STEPS[1:4] if quick else TWO_SEGMENT_STEPS:
            make, length = partial(two_segments, nodes), SEGMENTS * SEGMENT.length
            discretisation = f"12 coordinates, {nodes} nodes"
            run = partial(measure, make, length, "two segments", discretisation, kind, value, longest)
            print_run(run())
    for modes in RUBBER_ROD_MODES[:3] if quick else RUBBER_ROD_MODES:
        for kind, value in RUBBER_ROD_STEPS[1:3] if quick else RUBBER_ROD_STEPS:
            make, length = partial(rubber_rod, *modes), RUBBER_ROD.length
            discretisation = "{} bending, {} stretch, {} shear".format(*modes)
            run = partial(measure, make, length, "rubber rod", discretisation, kind, value, longest)
            print_run(run())


if __name__ == "__main__":
    main()
