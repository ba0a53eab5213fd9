"""Many runs at once by SoRoMoX on this processor, beside `lissom.simulate_many` in docs/run_times.md.

Rods of segments of constant strain (all six), the same as those of `beside_soromox` in
benches/python/speed/ensembles.py: one motion of one second for each row, states every 10 ms, all rows in one
compiled function (`jax.vmap`). Run it with the interpreter of an environment that has soromox 0.5.0:

    python benches/python/peers/soromox_batch.py [--runs 16] [--dt 2e-4] [--coordinates 6]
"""

import argparse
import json
import time
from importlib.metadata import version

import diffrax
import jax

jax.config.update("jax_enable_x64", True)

import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
from soromox.systems import GVS, SystemState  # noqa: E402
from soromox.systems.components import JointSpec, LinkSpec  # noqa: E402
from soromox.systems.gvs import GVSSegment, StrainBasisSpec  # noqa: E402

LENGTH, RADIUS, DENSITY = 0.3, 0.01, 1000.0
YOUNG_MODULUS, SHEAR_MODULUS, RETARDATION_TIME = 1e6, 4e5, 0.01
DURATION = 1.0
TIMES = np.linspace(0.0, DURATION, 101)
#: Quadrature nodes of a segment; more do not change a constant strain's polynomial by much.
NODES = 5


def rod(segments: int) -> GVS:
    """A straight rod along x, clamped, gravity along -z."""
    segment = GVSSegment(
        link=LinkSpec.circular(
            length=LENGTH / segments,
            radius=RADIUS,
            density=DENSITY,
            reference_strain=[0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            young_modulus=YOUNG_MODULUS,
            shear_modulus=SHEAR_MODULUS,
            material_damping_coefficient=RETARDATION_TIME * SHEAR_MODULUS,
        ),
        joint=JointSpec.fixed(),
        basis=StrainBasisSpec("legendre", [1] * 6, [0] * 6),
        num_gauss_points=NODES,
    )
    return GVS.from_segments(
        [segment] * segments,
        gravity=jnp.array([0.0, 0.0, -9.81]),
        base_pose=jnp.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
    )


def main() -> None:
    """Print the times, as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=16)
    parser.add_argument("--dt", type=float, default=2e-4)
    parser.add_argument("--coordinates", type=int, default=6)
    given = parser.parse_args()
    robot = rod(given.coordinates // 6)
    n = int(robot.num_velocities)
    q0 = 1e-3 * np.random.default_rng(0).standard_normal((given.runs, n))
    starts = jnp.asarray(np.concatenate([q0, np.zeros_like(q0)], axis=1))

    def one(state):
        motion = robot.rollout_to(
            SystemState(t=0.0, y=state),
            t1=DURATION,
            solver_dt=given.dt,
            save_ts=jnp.asarray(TIMES),
            solver=diffrax.Tsit5(),
            stepsize_controller=diffrax.ConstantStepSize(),
            max_steps=None,
        )
        return motion.y

    begun = time.perf_counter()
    batch = jax.jit(jax.vmap(one)).lower(starts).compile()
    compiled = time.perf_counter()
    states = np.asarray(jax.block_until_ready(batch(starts)))
    took = time.perf_counter() - compiled
    print(
        json.dumps(
            {
                "coordinates": n,
                "runs": given.runs,
                "dt": given.dt,
                "compile_seconds": round(compiled - begun, 2),
                "seconds": round(took, 3),
                "runs_per_second": round(given.runs / took, 3),
                "finite": bool(np.isfinite(states).all()),
                "last": states[0, -1, :n].round(6).tolist(),
                "versions": {name: version(name) for name in ("soromox", "jax", "diffrax")},
            }
        )
    )


if __name__ == "__main__":
    main()
