"""The rubber rod by a flex of one dimension, MuJoCo 4's rod: point masses, springs along edges, bending.

MuJoCo 4.0.0 has no cable plugin any more. Its flex stretches and bends but neither shears nor has a rotary
inertia of bending. `integrator="discrete"`, which is implicit, takes no stiffness of edges: edges keep their
length there by equality constraints, so that the rod only bends.
"""

import math
from functools import partial

import mujoco
import numpy as np
from cases import (
    GRAVITY,
    LONGEST_RUN,
    OUTPUT_STEP,
    QUICK_LONGEST_RUN,
    RUBBER_ROD,
    on_one_core,
    packages,
    quick_requested,
    run_series,
    steps_per_output,
)
from mujoco_run import measured

# Where the first edge, whose two vertices are pinned, lies: in the rod, or half an edge earlier.
CLAMPS = {"clamp as documented": 0.0, "clamp in mid-edge": 0.5}
EDGES = {
    "clamp as documented": (10, 20, 40, 80, 160),
    "clamp in mid-edge": (5, 10, 20, 40, 80, 160),
}
# Explicit steps, fractions of the largest stable one; implicit ones in seconds.
STEP_FRACTIONS = (0.8, 0.4, 0.2)
IMPLICIT_STEPS = (5e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
# Time constant of the equality constraints over the step: MuJoCo makes it no shorter.
TIME_CONSTANT = 2.0
# MuJoCo refuses 0.5; the rod is not twisted here.
POISSON_RATIO = 0.49

MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 {gravity!r}" integrator="{integrator}"/>
  <size memory="200M"/>
  <worldbody>
    <flexcomp name="rod" type="direct" dim="1" dof="full" radius="{radius!r}" mass="1"
              point="{points}" element="{elements}">
      <contact contype="0" conaffinity="0" selfcollide="none"/>
      <elasticity young="{young_modulus!r}" poisson="{poisson_ratio!r}" section="circle"/>
      <edge {edge}/>
      <pin id="0 1"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""


def edge_length(edges: int, shift: float) -> float:
    return RUBBER_ROD.length / (edges - shift)


def build(edges: int, shift: float, integrator: str, step: float) -> mujoco.MjModel:
    rod, length = RUBBER_ROD, edge_length(edges, shift)
    spring = f'stiffness="{rod.young_modulus * rod.area / length!r}"'
    tie = f'equality="true" solref="{TIME_CONSTANT * step!r} 1"'
    model = mujoco.MjModel.from_xml_string(
        MODEL.format(
            step=step,
            gravity=-GRAVITY,
            integrator=integrator,
            radius=rod.radius,
            points=" ".join(f"{(i - shift) * length!r} 0 0" for i in range(edges + 1)),
            elements=" ".join(f"{i} {i + 1}" for i in range(edges)),
            young_modulus=rod.young_modulus,
            poisson_ratio=POISSON_RATIO,
            edge=tie if integrator == "discrete" else spring,
        )
    )
    weigh(model, rod.density * rod.area * length)
    return model


def weigh(model: mujoco.MjModel, mass: float) -> None:
    """Give vertices the mass of an edge, the last one half of it: MuJoCo gives all of them the same."""
    vertices = np.flatnonzero(model.body_dofnum == 3)
    factors = mass / model.body_mass[vertices]
    factors[-1] *= 0.5
    model.body_mass[vertices] *= factors
    model.body_inertia[vertices] *= factors[:, None]
    mujoco.mj_setConst(model, mujoco.MjData(model))


def largest_stable_step(length: float) -> float:
    """Of explicit steps: the fastest waves of stretch and of bending in a chain of point masses."""
    stretch = 2.0 * RUBBER_ROD.sound_speed / length
    bending = 2.0 * RUBBER_ROD.sound_speed * RUBBER_ROD.radius / length**2
    return 2.0 / math.hypot(stretch, bending)


def tip_of(model: mujoco.MjModel):
    """The last vertex."""
    tip = int(np.flatnonzero(model.body_dofnum == 3)[-1])
    return lambda data: data.xpos[tip]


def series(clamp: str, integrator: str, longest: float):
    """Runs with ever more edges, each with several steps."""
    shift = CLAMPS[clamp]
    code = "MuJoCo flex" if integrator == "Euler" else "MuJoCo flex, inextensible"
    for edges in EDGES[clamp]:
        implicit = [round(OUTPUT_STEP / step) for step in IMPLICIT_STEPS]
        explicit = steps_per_output(largest_stable_step(edge_length(edges, shift)), STEP_FRACTIONS)
        compiled = partial(build, edges, shift, integrator)
        for steps in explicit if integrator == "Euler" else implicit:
            name = f"{edges} edges, {integrator}"
            yield partial(measured, f"{code}, {clamp}", name, compiled, tip_of, steps, longest)


def main() -> None:
    on_one_core()
    longest = QUICK_LONGEST_RUN if quick_requested(__doc__) else LONGEST_RUN
    packages("mujoco", "numpy")
    for clamp in CLAMPS:
        for integrator in ("Euler", "discrete"):
            run_series(series(clamp, integrator, longest), longest)


if __name__ == "__main__":
    main()
