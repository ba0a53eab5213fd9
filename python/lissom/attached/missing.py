"""What to use in place of attributes that results and simulations do not have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._lissom import MotionResult, Simulation, StaticsResult
from ..common.elsewhere import no_attribute

_ENERGY = "`balance` has the energies: `balance.total`, `balance.kinetic` and so on"
_MOVED = "`pose()` has the poses of the tip at all times: its positions are `pose()[:, :3, 3]`"
_RESTS = "`model.pose(result.q)` is the pose of the tip: its position is `model.pose(result.q)[:3, 3]`"
_NOW = "`model.pose(q)` has it: `simulation.model.pose(simulation.q, t=simulation.t)`"

#: What to use, by classes and attributes.
INSTEAD: Mapping[type, Mapping[str, str]] = {
    MotionResult: {
        "y": "coordinates are `q` and velocities `v`",
        "x": _MOVED,
        "energy": _ENERGY,
        "energies": _ENERGY,
        "tip": _MOVED,
        "position": _MOVED,
        "positions": _MOVED,
        "time": "times are `t`",
        "qd": "velocities are `v`",
        "show": "`plot()` draws curves, `report(path)` writes a page with the motion",
        "to_csv": "`save(path)` writes NetCDF or NumPy's .npz, `to_xarray().to_dataframe()` makes a table",
    },
    StaticsResult: {
        "x": "coordinates are `q`",
        "tip": _RESTS,
        "position": _RESTS,
        "pose": _RESTS,
        "energy": "`model.energy(q, 0 * q)` has the energies",
        "animate": (
            "an equilibrium does not move: `plot(model)` draws it, `report(path, model)` shows how it was "
            "loaded, and `continuation(model).animate(path, model)` makes a film of the growing loads"
        ),
    },
    Simulation: {
        "tip": _NOW,
        "position": _NOW,
        "pose": _NOW,
        "run": "`step(u, duration)` goes on, `lissom.simulate` makes a whole run",
        "dt": "the step is that of the call",
    },
}


def of_attribute(self: Any, name: str) -> Any:
    """Explain what to use instead of a missing attribute."""
    no_attribute(self, name, INSTEAD.get(type(self), {}))
