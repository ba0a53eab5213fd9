"""What to use in place of attributes that results and simulations do not have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._lissom import ModesResult, MotionResult, Simulation, StaticsResult

_ENERGY = "`balance` has the energies: `balance.total`, `balance.kinetic` and so on"
_FILM = "`animate(path)` writes a film: .gif, .mp4 or .webm"
_FIGURE = "`picture(path)` writes a figure, `plot()` draws curves, `report(path)` writes a page"
_TABLE = (
    "`save(path)` writes .nc (NetCDF) or .npz (NumPy), and `to_xarray().to_dataframe()` makes a table, which "
    "has `to_csv(path)`"
)
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
        **dict.fromkeys(("film", "video", "movie", "animation", "gif", "mp4", "play", "to_video"), _FILM),
        **dict.fromkeys(("figure", "draw", "savefig", "image", "png", "pdf", "svg", "to_png"), _FIGURE),
        **dict.fromkeys(("to_csv", "csv", "save_csv", "to_pandas", "to_dataframe", "dataframe"), _TABLE),
        "export": f"{_TABLE}; {_FILM}",
        "write": f"{_TABLE}; {_FILM}",
        "qdd": "accelerations are `a`",
        "inputs": "inputs are `u`",
        "final": "the last state is `q[-1]`, `v[-1]`",
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
        **dict.fromkeys(
            ("figure", "draw", "savefig", "show", "image", "png"),
            "`picture(path, model)` writes a figure, `plot(model)` draws the shape, `report(path, model)` "
            "writes a page",
        ),
        "v": "an equilibrium is at rest; its coordinates are `q`",
    },
    ModesResult: {
        **dict.fromkeys(("frequencies", "freq", "f"), "natural frequencies in hertz are `frequency`"),
        "omega": "natural frequencies are `frequency`, in hertz; eigenvalues in 1/s are `eigenvalues`",
        **dict.fromkeys(("damping", "zeta"), "damping ratios are `damping_ratio`"),
        **dict.fromkeys(("vectors", "eigenvectors", "modes"), "mode shapes are the columns of `shapes`"),
        **dict.fromkeys(("film", "video", "movie"), "`animate(path, model, q)` writes a film of a mode"),
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
    from ..common.elsewhere import no_attribute

    no_attribute(self, name, INSTEAD.get(type(self), {}))
