"""What to use in place of attributes that results and simulations do not have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._lissom import ModesResult, MotionResult, Robot, Rod, Simulation, StaticsResult

_ENERGY = "`balance` has the energies: `balance.total`, `balance.kinetic` and so on"
_FILM = "`animate(path)` writes a film: .gif, .mp4 or .webm"
_FIGURE = "`picture(path)` writes a figure, `plot()` draws curves, `report(path)` writes a page"
_TABLE = (
    "`save(path)` writes .nc (NetCDF) or .npz (NumPy), and `to_xarray().to_dataframe()` makes a table, which "
    "has `to_csv(path)`"
)
_MOVED = "`pose()` has the poses of the tip at all times: its positions are `pose()[:, :3, 3]`"
_RESTS = "`model.pose(result.q)` is the pose of the tip: its position is `model.pose(result.q)[:3, 3]`"
_PEAKS = "`peaks()` has the largest curvature, strain, stress and forces, with their limits"
_TOUCHES = "`model.touches(q)` has the places that touch, `model.contact_forces(q, v)` the forces on links"
_CURVED = dict.fromkeys(
    ("bend_radius", "min_bend_radius", "curvature", "max_curvature", "stress", "strain"), _PEAKS
)
_TOUCHED = dict.fromkeys(("contacts", "contact", "contact_forces", "touches"), _TOUCHES)
_AT_BASE = "forces in a joint are `model.joint_wrench(link, q, v, a, t=t)`"
_AT_TIP = "`pose(q)` has the pose of the tip: its position is `pose(q)[:3, 3]`"
_HOLDS = "`inverse_dynamics(q, v, a)` has generalised forces, at rest those that hold a posture"

#: Of models.
_OF_MODELS: Mapping[str, str] = {
    **dict.fromkeys(("tip", "position", "tip_position", "forward_kinematics", "fk", "shape"), _AT_TIP),
    **dict.fromkeys(
        ("plot", "show", "draw"),
        "`lissom.statics(model).plot(model)` draws an equilibrium; motions have `plot()` and `report(path)`",
    ),
    **dict.fromkeys(
        ("gravity_compensation", "gravity_torque", "gravity_forces", "nonlinear_effects", "rnea", "bias"),
        _HOLDS,
    ),
    **dict.fromkeys(
        ("mass", "M", "inertia", "crba"),
        "`mass_matrix(q)` has the inertia of the coordinates, `explain()` the masses",
    ),
    **dict.fromkeys(("com", "center_of_mass"), "`centre_of_mass(q)`"),
    **dict.fromkeys(
        ("neutral", "rest", "zero"), "`numpy.zeros(model.n)` are the coordinates of the unstressed shape"
    ),
    **dict.fromkeys(
        ("stiffness", "stiffness_matrix", "K"), "`tangent(q, v, a)` has the derivatives of the forces"
    ),
    **dict.fromkeys(("simulate", "run"), "`lissom.simulate(model, t_end)`"),
    **dict.fromkeys(("statics", "solve", "equilibrium"), "`lissom.statics(model)`"),
    **dict.fromkeys(
        ("workspace", "reachable"), "`lissom.statics_many(model, u)` finds the equilibria of many inputs"
    ),
    **dict.fromkeys(
        ("inverse_kinematics", "ik"), "`reach(targets)` finds coordinates, `lissom.actuate` inputs"
    ),
    **dict.fromkeys(
        ("bend_radius", "curvature"),
        "`lissom.statics(model).peaks()` has the largest curvature; `strain(q, X)` has it everywhere",
    ),
}

_NOW = "`model.pose(q)` has it: `simulation.model.pose(simulation.q, t=simulation.t)`"

#: What to use, by classes and attributes.
INSTEAD: Mapping[type, Mapping[str, str]] = {
    Robot: _OF_MODELS,
    Rod: _OF_MODELS,
    MotionResult: {
        **_CURVED,
        **_TOUCHED,
        **dict.fromkeys(("insertion_force", "reaction", "reactions", "base_wrench"), _AT_BASE),
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
        **_CURVED,
        **_TOUCHED,
        **dict.fromkeys(("reaction", "reactions", "base_wrench"), _AT_BASE),
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
        **dict.fromkeys(
            ("set_state", "set"),
            "`lissom.Simulation(model, q0=q, v0=v, t0=t)` begins elsewhere",
        ),
    },
}


def of_attribute(self: Any, name: str) -> Any:
    """Explain what to use instead of a missing attribute."""
    from ..common.elsewhere import no_attribute

    no_attribute(self, name, INSTEAD.get(type(self), {}))
