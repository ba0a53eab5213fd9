"""The rubber rod by MuJoCo's cable plugin: rigid links with ball joints, inextensible and without shear."""

from functools import partial

import mujoco
import numpy as np
from cases import (
    GRAVITY,
    LONGEST_RUN,
    QUICK_LONGEST_RUN,
    RUBBER_ROD,
    on_one_core,
    packages,
    quick_requested,
    run_series,
    steps_per_output,
)
from mujoco_run import measured

# Where the first link, which is held, lies: at the clamp as in MuJoCo's examples, or half a link earlier,
# which puts the clamp where the discretisation has it.
CLAMPS = {"clamp as documented": 0.0, "clamp in mid-link": 0.5}
LINKS = {
    "clamp as documented": (10, 20, 40, 80, 160, 320),
    "clamp in mid-link": (5, 7, 10, 14, 20, 40, 80),
}
# Largest stable product of step and frequency; fractions of it that are run.
STABILITY = {"Euler": 2.0, "RK4": 2.8}
STEP_FRACTIONS = (0.8, 0.4, 0.2)

# Links are cylinders: capsules would count the mass of their round ends twice.
MODEL = """
<mujoco>
  <extension><plugin plugin="mujoco.elasticity.cable"/></extension>
  <option timestep="{step!r}" gravity="0 0 {gravity!r}" integrator="{integrator}">
    <flag contact="disable" constraint="disable"/>
  </option>
  <size memory="200M"/>
  <worldbody>
    <composite type="cable" prefix="rod" curve="s" count="{nodes} 1 1" size="{length!r}"
               offset="{offset!r} 0 0" initial="none">
      <plugin plugin="mujoco.elasticity.cable">
        <config key="twist" value="{shear_modulus!r}"/>
        <config key="bend" value="{young_modulus!r}"/>
      </plugin>
      <joint kind="main" damping="0" armature="0" frictionloss="0"/>
      <geom type="cylinder" size="{radius!r}" density="{density!r}" contype="0" conaffinity="0"/>
    </composite>
  </worldbody>
</mujoco>
"""


def link_length(links: int, shift: float) -> float:
    return RUBBER_ROD.length / (links - shift)


def build(links: int, shift: float, integrator: str, step: float) -> mujoco.MjModel:
    rod, length = RUBBER_ROD, link_length(links, shift)
    model = mujoco.MjModel.from_xml_string(
        MODEL.format(
            step=step,
            gravity=-GRAVITY,
            integrator=integrator,
            nodes=links + 1,
            length=links * length,
            offset=-shift * length,
            shear_modulus=rod.shear_modulus,
            young_modulus=rod.young_modulus,
            radius=rod.radius,
            density=rod.density,
        )
    )
    mass = rod.density * rod.area * links * length
    assert abs(model.body_mass.sum() - mass) < 1e-6 * mass, "the links do not weigh what the rod weighs"
    return model


def largest_frequency(length: float) -> float:
    """Of bending between neighbouring links, with the rotary inertia of the section."""
    wave_number = 2.0 / length
    slenderness = 0.5 * RUBBER_ROD.radius * wave_number
    return wave_number * RUBBER_ROD.sound_speed * slenderness / np.hypot(1.0, slenderness)


def tip_of(model: mujoco.MjModel):
    """The end of the last link."""
    last, length = model.nbody - 1, 2.0 * model.geom_size[-1, 1]
    return lambda data: data.xpos[last] + length * data.xmat[last].reshape(3, 3)[:, 0]


def series(clamp: str, integrator: str, longest: float):
    """Runs with ever more links, each with the steps that are stable."""
    shift = CLAMPS[clamp]
    for links in LINKS[clamp]:
        largest = STABILITY[integrator] / largest_frequency(link_length(links, shift))
        compiled = partial(build, links, shift, integrator)
        for steps in steps_per_output(largest, STEP_FRACTIONS):
            name = f"{links} links, {integrator}"
            yield partial(measured, f"MuJoCo cable, {clamp}", name, compiled, tip_of, steps, longest)


def main() -> None:
    on_one_core()
    longest = QUICK_LONGEST_RUN if quick_requested(__doc__) else LONGEST_RUN
    packages("mujoco", "numpy")
    for clamp in CLAMPS:
        for integrator in STABILITY:
            run_series(series(clamp, integrator, longest), longest)


if __name__ == "__main__":
    main()
