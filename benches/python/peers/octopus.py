"""The octopus of scenes/octopus.toml: what every code is given, and lissom's runs.

Error: the largest distance of any tip from where it should be, at the output times of the scene, relative to
the length of an arm.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import lissom

SCENE = Path(__file__).parents[3] / "scenes" / "octopus.toml"
END, OUTPUT_STEP = 6.0, 0.04
TIMES = np.linspace(0.0, END, round(END / OUTPUT_STEP) + 1)

# Bending across the plane in which an arm beats; the same in all runs.
MODES_ACROSS = 2


@dataclass(frozen=True)
class Moment:
    """About the y axis of the section at an arc length, which it turns with."""

    at: float
    amplitude: float
    frequency: float
    phase: float


@dataclass(frozen=True)
class Arm:
    position: tuple[float, ...]
    orientation: tuple[float, ...]
    length: float
    # At base and tip, linear between.
    radius: tuple[float, float]
    young_modulus: float
    density: float
    retardation_time: float
    moments: tuple[Moment, ...]


@dataclass(frozen=True)
class Octopus:
    """A free rigid head and arms that bend, without stretch, shear and torsion; no gravity."""

    head_mass: float
    head_inertia: np.ndarray
    arms: tuple[Arm, ...]


def described() -> Octopus:
    """What the scene's file says, without the fluid."""
    robot = lissom.Scene.load(SCENE).model
    head, *arms = robot.links
    return Octopus(
        head.body.mass,
        np.diag(head.body.inertia),
        tuple(
            Arm(
                arm.position,
                # The file has it to twelve digits.
                tuple(arm.orientation / np.linalg.norm(arm.orientation)),
                arm.rod[0].length,
                arm.rod[0].radius,
                arm.rod[0].young_modulus,
                arm.rod[0].density,
                arm.rod[0].retardation_time,
                tuple(
                    Moment(load.at, load.moment.amplitude[1], load.moment.frequency, load.moment.phase)
                    for load in robot.loads
                    if load.link == arm.name
                ),
            )
            for arm in arms
        ),
    )


def robot(modes: int, fluid: bool) -> lissom.Robot:
    """The scene's, with so many modes of bending in the plane of an arm."""
    scene = lissom.Scene.load(SCENE).model

    def link(given: lissom.Link) -> lissom.Link:
        if not given.rod:
            return given
        (segment,) = given.rod
        rod = lissom.Segment(
            segment.length,
            segment.radius,
            segment.young_modulus,
            poisson_ratio=segment.poisson_ratio,
            density=segment.density,
            retardation_time=segment.retardation_time,
            modes={"bend_y": modes, "bend_z": MODES_ACROSS},
        )
        return lissom.Link(
            given.name,
            rod=[rod],
            joint=given.joint,
            parent=given.parent,
            position=given.position,
            orientation=given.orientation,
        )

    return lissom.Robot(
        [link(each) for each in scene.links],
        gravity=scene.gravity,
        loads=scene.loads,
        fluid=scene.fluid if fluid else None,
    )


def tips(model: lissom.Robot, **options: object) -> np.ndarray:
    """Places of the tips of all arms at TIMES, of shape (4, 151, 3)."""
    motion = lissom.simulate(model, END, t_eval=TIMES, **options)
    if not motion.success:
        return np.full((len(model.links) - 1, TIMES.size, 3), np.inf)
    return np.array([model.pose(motion.q, link=link.name)[:, :3, 3] for link in model.links[1:]])


def error(found: np.ndarray, reference: np.ndarray) -> float:
    """Relative to the length of an arm; infinite for a run that failed."""
    with np.errstate(invalid="ignore"):
        largest = np.linalg.norm(found - reference, axis=-1).max() / described().arms[0].length
    return float(largest) if np.isfinite(largest) else np.inf
