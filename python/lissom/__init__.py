"""Simulation of soft robots and slender bodies as Cosserat rods. `Rod` and `Robot` describe a model;
`simulate`, `statics`, `modes` and `linearise` compute with it. `root`, `solve_ivp` and `newmark` are solvers
for your own functions."""

# Names are imported on first access (PEP 562), so that the command line handles Ctrl-C before it imports
# NumPy.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from . import gym as gym
    from . import jax as jax
    from . import sensors as sensors
    from . import torch as torch
    from . import urdf as urdf
    from ._lissom import (
        DOP853,
        RK45,
        AccuracyWarning,
        ActiveStrain,
        ActuateResult,
        Along,
        Balance,
        BaseMotion,
        Body,
        Chamber,
        ContinuationResult,
        ConvergenceError,
        CriticalPoint,
        Cylindrical,
        DenseOutput,
        Distance,
        Energy,
        EnsembleResult,
        EquilibriumPath,
        Fluid,
        Free,
        Gear,
        Harmonic,
        Input,
        JacobianCheck,
        Joint,
        LissomError,
        Load,
        Loop,
        LoopEnd,
        Mimic,
        Model,
        ModesResult,
        MotionResult,
        Motor,
        OdeResult,
        OdeSolver,
        Planar,
        Prismatic,
        Profile,
        Radau,
        ReachResult,
        Revolute,
        Robot,
        Rod,
        RootResult,
        Scene,
        SceneError,
        SceneProblem,
        Section,
        Segment,
        Simulation,
        Simulations,
        SimulationSettings,
        Spherical,
        SpringPendulum,
        StaticsResult,
        Statistics,
        Support,
        Tendon,
        Universal,
        Via,
        Weld,
        __version__,
        actuate,
        check_jacobian,
        choose_modes,
        continuation,
        jacobian,
        modes,
        newmark,
        root,
        simulate,
        simulate_many,
        solve_ivp,
        statics,
    )
    from .contact_events import ContactEvent
    from .contacts import Ball, Box, Capsule, Contact, ConvexMesh, HalfSpace, HeightField, Sphere, Touch
    from .equilibria import EquilibriumSensitivityResult, equilibrium_sensitivity
    from .fits import FitResult, fit
    from .keeping import load
    from .linear import LinearModel, linearise
    from .links import Link
    from .measurements import NaturalFrequencies, StaticShapes
    from .sensitivities import SensitivityResult, sensitivity
    from .sweeps import sweep
    from .targets import Target

__all__ = [
    "DOP853",
    "RK45",
    "AccuracyWarning",
    "ActiveStrain",
    "ActuateResult",
    "Along",
    "Balance",
    "Ball",
    "BaseMotion",
    "Body",
    "Box",
    "Capsule",
    "Chamber",
    "Contact",
    "ContactEvent",
    "ContinuationResult",
    "ConvergenceError",
    "ConvexMesh",
    "CriticalPoint",
    "Cylindrical",
    "DenseOutput",
    "Distance",
    "Energy",
    "EnsembleResult",
    "EquilibriumPath",
    "EquilibriumSensitivityResult",
    "FitResult",
    "Fluid",
    "Free",
    "Gear",
    "HalfSpace",
    "Harmonic",
    "HeightField",
    "Input",
    "JacobianCheck",
    "Joint",
    "LinearModel",
    "Link",
    "LissomError",
    "Load",
    "Loop",
    "LoopEnd",
    "Mimic",
    "Model",
    "ModesResult",
    "MotionResult",
    "Motor",
    "NaturalFrequencies",
    "OdeResult",
    "OdeSolver",
    "Planar",
    "Prismatic",
    "Profile",
    "Radau",
    "ReachResult",
    "Revolute",
    "Robot",
    "Rod",
    "RootResult",
    "Scene",
    "SceneError",
    "SceneProblem",
    "Section",
    "Segment",
    "SensitivityResult",
    "Simulation",
    "SimulationSettings",
    "Simulations",
    "Sphere",
    "Spherical",
    "SpringPendulum",
    "StaticShapes",
    "StaticsResult",
    "Statistics",
    "Support",
    "Target",
    "Tendon",
    "Touch",
    "Universal",
    "Via",
    "Weld",
    "__version__",
    "actuate",
    "check_jacobian",
    "choose_modes",
    "continuation",
    "equilibrium_sensitivity",
    "fit",
    "jacobian",
    "linearise",
    "load",
    "modes",
    "newmark",
    "root",
    "sensitivity",
    "simulate",
    "simulate_many",
    "solve_ivp",
    "statics",
    "sweep",
]

if not TYPE_CHECKING:

    def __getattr__(name):
        from importlib import import_module

        if name in ("gym", "jax", "sensors", "torch", "urdf"):
            return import_module(f"lissom.{name}")
        if name != "_lissom" and name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        # The first module imports NumPy. If NumPy is missing or its import is interrupted, Python's own error
        # is raised.
        modules = [
            import_module(f"lissom.{name}")
            for name in (
                "contact_events",
                "contacts",
                "equilibria",
                "fits",
                "keeping",
                "linear",
                "links",
                "measurements",
                "sensitivities",
                "sweeps",
                "targets",
                "_lissom",
            )
        ]
        import_module("lissom.methods").attach()
        found = {known: value for module in modules for known, value in vars(module).items()}
        globals().update({known: found[known] for known in __all__})
        return globals()[name]

    def __dir__():
        return sorted(globals().keys() | set(__all__))
