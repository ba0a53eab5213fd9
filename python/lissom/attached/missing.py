"""What to use in place of attributes that results and simulations do not have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._lissom import (
    ModesResult,
    MotionResult,
    OdeResult,
    Robot,
    Rod,
    RootResult,
    Scene,
    Simulation,
    StaticsResult,
)

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

_SIZE = dict.fromkeys(
    ("ndof", "nq", "nv", "dof", "dofs", "num_dofs", "n_dofs", "n_q"), "`n` is the number of coordinates"
)
_LINE = (
    "`pose(q, numpy.linspace(0, length, 50))[:, :3, 3]` has points of the axis of a rod of this length; "
    "robots take `link=...`"
)
_TENSIONS = "`model.actuator_force(name, q, v, t=t, u=u)` has the force of an actuator, `u` has the inputs"

#: Of models.
_OF_MODELS: Mapping[str, str] = {
    **_SIZE,
    **dict.fromkeys(("backbone", "centerline", "centreline", "positions", "points", "curve"), _LINE),
    **dict.fromkeys(("nu", "n_inputs", "num_inputs"), "`len(model.inputs)` is the number of inputs"),
    **dict.fromkeys(("state_dim", "nx", "n_states"), "a state has `2 * model.n` numbers: q and v"),
    **dict.fromkeys(("tendons", "motors", "chambers", "muscles"), "`actuators` has all of them"),
    **dict.fromkeys(
        ("set_input", "set_inputs", "actuate"), "inputs are arguments: `lissom.statics(model, u=u)`"
    ),
    **dict.fromkeys(
        ("coriolis", "coriolis_matrix", "C", "bias_forces", "gravity_vector", "g"),
        "`inverse_dynamics(q, v, 0 * q)` has forces of gravity, springs and Coriolis together",
    ),
    **dict.fromkeys(
        ("dynamics", "f", "rhs", "ode", "acceleration_of"),
        "`forward_dynamics(q, v)` has accelerations; `lissom.solve_ivp(model, t_span, y0)` takes models",
    ),
    **dict.fromkeys(("total_mass", "weight"), "`explain()` has the masses"),
    "joints": "each of `links` has a `joint`",
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
        "tip_position": _MOVED,
        **dict.fromkeys(("tension", "tensions", "forces", "actuator_force"), _TENSIONS),
    },
    StaticsResult: {
        **_CURVED,
        **_TOUCHED,
        **dict.fromkeys(("reaction", "reactions", "base_wrench"), _AT_BASE),
        "x": "coordinates are `q`",
        "tip": _RESTS,
        "tip_position": _RESTS,
        **dict.fromkeys(("tension", "tensions", "forces", "actuator_force"), _TENSIONS),
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
    Scene: {
        **dict.fromkeys(("simulate", "play", "solve"), "`run()` simulates the scene"),
        **dict.fromkeys(
            ("statics", "modes", "equilibrium"), "its model is `model`: `lissom.statics(scene.model)`"
        ),
        **dict.fromkeys(("robot", "rod", "links"), "its model is `model`"),
        **dict.fromkeys(("dt", "t_end", "method"), "what it says of the simulation is `simulation`"),
        "view": "`lissom view scene.toml` shows it in a browser",
        "report": "`scene.run().report(path)` writes a page",
    },
    OdeResult: {
        "x": "solutions are `y`, of shape (n, times)",
        **dict.fromkeys(("plot", "show"), "`matplotlib.pyplot.plot(result.t, result.y.T)`"),
        "naccept": "accepted steps are `naccepted`",
        "nit": "accepted steps are `naccepted`",
    },
    RootResult: {
        **dict.fromkeys(("root", "solution", "value", "zero"), "the root is `x`"),
        **dict.fromkeys(
            ("converged", "flag", "ok"), "whether it has converged is `success`, how is `status`"
        ),
        **dict.fromkeys(("iterations", "niter", "n_iter", "iter"), "the number of iterations is `nit`"),
        **dict.fromkeys(("function_calls", "fcalls"), "the number of evaluations is `nfev`"),
        **dict.fromkeys(("residual", "error", "fvec"), "the residual is `fun`, its norm `residual_norm`"),
    },
    Simulation: {
        "tip": _NOW,
        "tip_position": _NOW,
        **dict.fromkeys(("state", "x", "get_state", "qpos"), "the state is `q` and `v`, its time `t`"),
        **dict.fromkeys(("qvel", "qd", "dq"), "velocities are `v`"),
        **dict.fromkeys(("time", "now"), "the time is `t`"),
        **dict.fromkeys(
            ("ctrl", "inputs", "set_inputs", "set_input", "set_control"), "`step(u, duration)` sets inputs"
        ),
        **dict.fromkeys(
            ("forward", "integrate", "advance", "simulate", "step_forward"), "`step(u, duration)` goes on"
        ),
        **dict.fromkeys(("observe", "sense", "sensordata"), "sensors read it: `sensor.observe(simulation)`"),
        **dict.fromkeys(("render", "show", "plot"), "`view()` shows it in a browser"),
        "close": "it holds no files: there is nothing to close",
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
