"""Initial states of scenes: states that close the loops, and starting points for equilibria."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._lissom import Model, Scene, Simulation

Array = NDArray[np.float64]


def has_loops(model: Model) -> bool:
    """Whether a model has closed loops."""
    return bool(getattr(model, "loops", ()))


def has_contacts(model: Model) -> bool:
    """Whether surfaces of a model can touch."""
    return bool(getattr(model, "contacts", ()))


def check_start(scene: Scene) -> None:
    """Raise ValueError if a scene cannot start: loops that stay open, a method that is not for its model.

    Motions without inertia have no initial velocities, and are for robots only.
    """
    settings = scene.simulation
    if not has_loops(scene.model) and settings.method != "quasi_static":
        return
    method = "radau" if settings.method == "auto" else settings.method
    Simulation(scene.model, t0=settings.t0, q0=scene.q0, v0=scene.v0, method=method, dt=settings.dt)


def rest_start(scene: Scene) -> Array | None:
    """Starting point for the equilibrium of a scene: its q0, which determines how loops are closed.

    None represents the unloaded state.
    """
    return scene.q0 if has_loops(scene.model) and np.any(scene.q0) else None
