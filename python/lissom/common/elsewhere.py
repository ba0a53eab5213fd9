"""What to use in place of names that do not exist, in words of other programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NoReturn

#: Names of other programs and of American English, by what lissom has.
NAMES: Mapping[str, str] = {
    "linearize": "linearise",
    "integrate": "simulate",
    "solve": "simulate",
    "odeint": "solve_ivp",
    "ode45": "solve_ivp",
    "ode23": "solve_ivp",
    "ode15s": "solve_ivp",
    "ode": "solve_ivp",
    "rk4": "solve_ivp",
    "RK4": "solve_ivp",
    "RK23": "solve_ivp",
    "runge_kutta": "solve_ivp",
    "euler": "solve_ivp",
    "LSODA": "solve_ivp",
    "BDF": "solve_ivp",
    "HHT": "newmark",
    "hht": "newmark",
    "generalised_alpha": "newmark",
    "generalized_alpha": "newmark",
    "verlet": "newmark",
    "quasi_static": "simulate",
    "fsolve": "root",
    "newton": "root",
    "newton_raphson": "root",
    "root_scalar": "root",
    "least_squares": "root",
    "brentq": "root",
    "bisect": "root",
    "curve_fit": "fit",
    "identify": "fit",
    "inverse_kinematics": "actuate",
    "workspace": "statics_many",
    "buckling": "continuation",
    **dict.fromkeys(
        ("MjModel", "MultibodyPlant", "Manipulator", "Articulation", "SoftRobot", "SerialLink"), "Robot"
    ),
    **dict.fromkeys(("MjData", "Simulator", "Integrator"), "Simulation"),
    "equilibrium": "statics",
    "eigenmodes": "modes",
    **dict.fromkeys(("Beam", "CosseratRod", "StraightRod", "PlanarPCS", "PCS", "GVS", "PCC"), "Rod"),
    "Spring": "Support",
    "Cable": "Rod",
    "Rope": "Rod",
    "Wire": "Rod",
    **dict.fromkeys(("Force", "PointForce", "EndpointForces", "UniformForces"), "Load"),
    **dict.fromkeys(("PositionVerlet", "Verlet"), "newmark"),
    "Gravity": "Robot",
    "Plane": "HalfSpace",
    "Floor": "HalfSpace",
    "Ground": "HalfSpace",
    "Cylinder": "Capsule",
    "Hinge": "Revolute",
    "Slider": "Prismatic",
    "Fixed": "Weld",
    "Muscle": "Chamber",
    "Material": "Segment",
}


#: What other packages have, by names.
OTHERS: Mapping[str, str] = {
    **dict.fromkeys(
        ("lqr", "dlqr", "place", "kalman", "lqe"),
        "`control` and SciPy take the matrices of `linear = lissom.linearise(...)`: "
        "`control.lqr(linear.A, linear.B, Q, R)`",
    ),
    **dict.fromkeys(
        ("minimize", "minimise", "fmin"), "SciPy has it; lissom.actuate finds inputs, lissom.fit parameters"
    ),
    **dict.fromkeys(("quad", "interp1d", "CubicSpline"), "SciPy has it"),
    "plot": "results have `plot()`, `picture(path)` and `report(path)`",
    "run": "`lissom.Scene.load(path).run()` runs a scene, `lissom.simulate(model, t_end)` a model",
    **dict.fromkeys(
        ("load_scene", "read_scene", "load_toml", "open"), "`lissom.Scene.load(path)` reads a scene"
    ),
    **dict.fromkeys(
        ("Start", "State", "initial_state"),
        "a motion starts where `lissom.simulate(model, t_end, q0=q, v0=v)` says",
    ),
    **dict.fromkeys(
        ("IMU", "Imu", "Encoder", "Marker", "Sensor", "ForceTorque", "Accelerometer"),
        "sensors are in `lissom.sensors`, such as `lissom.sensors.Imu`",
    ),
    **dict.fromkeys(
        ("RobotEnv", "Env", "Task", "make"),
        "environments are in `lissom.gym`: `lissom.gym.RobotEnv(task)`",
    ),
    **dict.fromkeys(("GravityForces", "gravity"), "`gravity` of a Rod or a Robot, (0, 0, -9.81) by default"),
    **dict.fromkeys(
        ("OneEndFixedBC", "OneEndFixedRod", "FixedConstraint", "Clamp"),
        "the base of a Rod is clamped; a Link has a `joint`, and loops hold other places",
    ),
    **dict.fromkeys(
        ("AnalyticalLinearDamper", "Damper", "damping"),
        "`retardation_time` of a Segment damps a rod, `damping` a joint",
    ),
    "load_urdf": "`lissom.Robot.from_urdf(path)` reads robots",
    "from_urdf": "`lissom.Robot.from_urdf(path)` reads robots",
    "buildModelFromUrdf": "`lissom.Robot.from_urdf(path)` reads robots",
    "forward_kinematics": "`model.pose(q)` has the pose of the tip",
    "rnea": "`model.inverse_dynamics(q, v, a)` has what holds a posture if v and a are zero",
    "aba": "`model.forward_dynamics(q, v)` has accelerations",
    "crba": "`model.mass_matrix(q)`",
    "gravity_compensation": "`model.inverse_dynamics(q, v, a)` has what holds a posture if v and a are zero",
}


#: Materials, which have no names in lissom.
MATERIALS = ("steel", "aluminium", "aluminum", "nitinol", "rubber", "silicone", "ecoflex")


def no_attribute(thing: object, name: str, instead: Mapping[str, str]) -> NoReturn:
    """Raise AttributeError for an attribute that a thing does not have, with what to use instead."""
    sentence = f"'lissom.{type(thing).__name__}' object has no attribute {name!r}"
    hint = instead.get(name)
    if hint is None and not name.startswith("_"):
        from .._lissom import did_you_mean

        hint = did_you_mean(name, [each for each in dir(thing) if not each.startswith("_")])
    raise AttributeError(f"{sentence}: {hint}" if hint else sentence, name=name, obj=thing)


def of_class(cls: type, name: str) -> NoReturn:
    """Raise AttributeError for a name that the class of a part does not have, with what to write instead."""
    missing = f"type object {cls.__name__!r} has no attribute {name!r}"
    hint = ""
    if not name.startswith("_"):
        from .._lissom import did_you_mean

        is_material = name.lower() in MATERIALS
        known = [each for each in dir(cls) if not each.startswith("_")]
        hint = did_you_mean("material" if is_material else name, known) or ""
    raise AttributeError(f"{missing}; {hint}" if hint else missing, name=name, obj=cls)


_TABLE = "a table is `result.to_xarray().to_dataframe()`, which has `to_csv(path)` and others"
_FILM, _FIGURE = "films are written by `animate(path)`", "pictures are written by `picture(path)`"

#: What writes files of other kinds, by their suffixes.
WRITTEN: Mapping[str, str] = {
    **dict.fromkeys((".csv", ".txt", ".dat", ".xlsx", ".parquet", ".json", ".feather"), _TABLE),
    **dict.fromkeys((".gif", ".mp4", ".webm", ".avi", ".mov"), _FILM),
    **dict.fromkeys((".png", ".pdf", ".svg", ".jpg", ".jpeg"), _FIGURE),
    **dict.fromkeys((".html", ".htm"), "pages are written by `report(path)`"),
    ".gltf": "glTF is written in its binary form, .glb",
    **dict.fromkeys((".stl", ".step", ".dae"), "surfaces are written as .obj, .ply or .glb"),
    **dict.fromkeys((".vtk", ".vtu", ".vtp", ".pvd"), "ParaView reads .vtkhdf"),
    **dict.fromkeys((".h5", ".hdf5"), ".nc is HDF5 as well"),
    ".mat": "MATLAB reads .nc (`ncread`)",
    **dict.fromkeys((".pkl", ".pickle"), ".lissom is read by `lissom.load`"),
}

#: What reads files of other kinds, by their suffixes.
READ: Mapping[str, str] = {
    **dict.fromkeys((".urdf", ".xml"), "robots are read by `lissom.Robot.from_urdf(path)`"),
    ".toml": "scenes are read by `lissom.Scene.load(path)`",
    ".csv": "tables are read by `numpy.loadtxt`, and `lissom.RecordedMotion` takes them",
}


def of_package(name: str, known: Iterable[str]) -> str:
    """What to use in place of a name of the package; empty if there is nothing like it."""
    if name in NAMES:
        return f"; use lissom.{NAMES[name]}"
    if name in OTHERS:
        return f"; {OTHERS[name]}"
    from .._lissom import did_you_mean, meant

    if name.lower() in MATERIALS:
        return f"; {did_you_mean('material', ('young_modulus', 'density'))}"
    # Names of Python's own protocols, such as `__path__`, stand for nothing.
    if name.startswith("_"):
        return ""
    names = list(known)
    close = next((each for each in names if each.lower() == name.lower()), None) or meant(name, names)
    return f"; did you mean {close!r}?" if close else ""


def of_module(module: str, name: str, known: Iterable[str], instead: Mapping[str, str]) -> str:
    """The message about a name that a module does not have, with the one to use."""
    missing = f"module {module!r} has no attribute {name!r}"
    if name in instead:
        return f"{missing}; use {module}.{instead[name]}"
    from .._lissom import meant

    names = list(known)
    close = next((each for each in names if each.lower() == name.lower()), None)
    close = close or (None if name.startswith("_") else meant(name, names))
    return f"{missing}; did you mean {close!r}?" if close else missing


def of_suffix(suffix: str, instead: Mapping[str, str], asked: str) -> str:
    """What to use for files with a suffix that a method does not take; empty if nothing else is known."""
    hint = instead.get(suffix.lower(), "")
    return f"; {hint}" if hint and f"`{asked}(" not in hint else ""
