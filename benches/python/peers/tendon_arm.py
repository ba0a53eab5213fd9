"""A soft arm that hangs, bent by four tendons whose tensions change every 10 ms; and how lissom moves it.

Two segments with two Legendre polynomials each of torsion and of bending about y and z: 12 coordinates.
Nothing stretches or shears, so that a chain of rigid links with hinges is the same arm in the limit.
"""

from functools import cache

import numpy as np

import lissom

SEGMENTS, LENGTH, RADIUS = 2, 0.3, 0.01
# Poisson's ratio is 1/2, so that SoRoMoX's law of damping (Trouton's ratio) is a retardation time.
YOUNG_MODULUS, SHEAR_MODULUS, DENSITY, RETARDATION_TIME = 1.2e6, 4e5, 1000.0, 0.01
GRAVITY = (9.81, 0.0, 0.0)
# y and z of the tendons, metres.
OFFSETS = ((0.008, 0.0), (-0.008, 0.0), (0.0, 0.008), (0.0, -0.008))
CONTROL_STEP, STEPS = 0.01, 100
# Of the tensions: means and amplitudes in newtons, frequencies in hertz.
PULL, FREQUENCIES = 1.5, (0.7, 1.1, 1.6, 0.9)

STRAINS = ("torsion", "bend_y", "bend_z")
MODES = 2
# The converged rod, in space and time.
REFERENCE_MODES, REFERENCE_STEP = 6, 2.5e-4


def tensions() -> np.ndarray:
    """Of all control steps, newtons, shape (STEPS, 4)."""
    t = CONTROL_STEP * np.arange(STEPS)[:, None]
    phases = np.arange(len(FREQUENCIES))
    return PULL * (1.0 + np.sin(2.0 * np.pi * np.array(FREQUENCIES) * t + phases))


@cache
def arm(modes: int = MODES) -> lissom.Rod:
    segment = lissom.Segment(
        LENGTH / SEGMENTS,
        RADIUS,
        YOUNG_MODULUS,
        SHEAR_MODULUS,
        DENSITY,
        dict.fromkeys(STRAINS, modes),
        retardation_time=RETARDATION_TIME,
    )
    tendons = [
        lissom.Tendon(f"t{i}", [lissom.Along("rod", offset)], tension=lissom.Input(f"t{i}"))
        for i, offset in enumerate(OFFSETS)
    ]
    return lissom.Rod([segment] * SEGMENTS, gravity=GRAVITY, actuators=tendons)


def moved(simulation: lissom.Simulation, inputs: np.ndarray) -> np.ndarray:
    """Coordinates after every control step from the start, shape (STEPS, n)."""
    simulation.reset()
    q = np.empty((len(inputs), simulation.model.n))
    for step, u in enumerate(inputs):
        if simulation.step(u, CONTROL_STEP) != "finished":
            raise ArithmeticError(simulation.message)
        q[step] = simulation.q
    return q


def tips(modes: int, step: float) -> np.ndarray:
    """Places of the tip after every control step, metres, shape (STEPS, 3)."""
    model = arm(modes)
    return model.pose(moved(lissom.Simulation(model, dt=step), tensions()))[:, :3, 3]
