"""Simulation of soft robots and slender bodies as Cosserat rods. `Rod` and `Robot` describe a model;
`simulate`, `statics`, `modes` and `linearise` compute with it. `root`, `solve_ivp` and `newmark` are solvers
for your own functions."""

import sys

# Python imports what is used (PEP 562): `import lissom` takes no time, a name imports its module alone.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from . import gym as gym
    from . import jax as jax
    from . import methods as methods
    from . import sensors as sensors
    from . import torch as torch
    from . import urdf as urdf
    from ._lissom import DOP853 as DOP853
    from ._lissom import RK45 as RK45
    from ._lissom import AccuracyWarning as AccuracyWarning
    from ._lissom import ActiveStrain as ActiveStrain
    from ._lissom import ActuateResult as ActuateResult
    from ._lissom import Along as Along
    from ._lissom import Balance as Balance
    from ._lissom import BaseMotion as BaseMotion
    from ._lissom import Body as Body
    from ._lissom import Chamber as Chamber
    from ._lissom import ContinuationResult as ContinuationResult
    from ._lissom import ConvergenceError as ConvergenceError
    from ._lissom import CriticalPoint as CriticalPoint
    from ._lissom import CurveResult as CurveResult
    from ._lissom import Cylindrical as Cylindrical
    from ._lissom import DenseOutput as DenseOutput
    from ._lissom import Distance as Distance
    from ._lissom import Energy as Energy
    from ._lissom import EnsembleResult as EnsembleResult
    from ._lissom import EquilibriumPath as EquilibriumPath
    from ._lissom import Fluid as Fluid
    from ._lissom import Free as Free
    from ._lissom import Gear as Gear
    from ._lissom import HardSteps as HardSteps
    from ._lissom import Harmonic as Harmonic
    from ._lissom import Input as Input
    from ._lissom import JacobianCheck as JacobianCheck
    from ._lissom import Joint as Joint
    from ._lissom import Link as Link
    from ._lissom import LissomError as LissomError
    from ._lissom import Load as Load
    from ._lissom import Loop as Loop
    from ._lissom import LoopEnd as LoopEnd
    from ._lissom import Magnet as Magnet
    from ._lissom import Mimic as Mimic
    from ._lissom import Model as Model
    from ._lissom import ModesResult as ModesResult
    from ._lissom import MotionResult as MotionResult
    from ._lissom import Motor as Motor
    from ._lissom import OdeResult as OdeResult
    from ._lissom import OdeSolver as OdeSolver
    from ._lissom import Overlap as Overlap
    from ._lissom import Planar as Planar
    from ._lissom import Prismatic as Prismatic
    from ._lissom import Profile as Profile
    from ._lissom import Radau as Radau
    from ._lissom import ReachResult as ReachResult
    from ._lissom import Revolute as Revolute
    from ._lissom import Robot as Robot
    from ._lissom import Rod as Rod
    from ._lissom import RootResult as RootResult
    from ._lissom import Scene as Scene
    from ._lissom import SceneError as SceneError
    from ._lissom import SceneProblem as SceneProblem
    from ._lissom import Screw as Screw
    from ._lissom import Section as Section
    from ._lissom import Segment as Segment
    from ._lissom import Simulation as Simulation
    from ._lissom import Simulations as Simulations
    from ._lissom import SimulationSettings as SimulationSettings
    from ._lissom import SpaceError as SpaceError
    from ._lissom import Spherical as Spherical
    from ._lissom import SpringPendulum as SpringPendulum
    from ._lissom import StaticsResult as StaticsResult
    from ._lissom import Statistics as Statistics
    from ._lissom import Support as Support
    from ._lissom import Tendon as Tendon
    from ._lissom import Universal as Universal
    from ._lissom import Via as Via
    from ._lissom import Weld as Weld
    from ._lissom import __version__ as __version__
    from ._lissom import actuate as actuate
    from ._lissom import check_jacobian as check_jacobian
    from ._lissom import choose_modes as choose_modes
    from ._lissom import continuation as continuation
    from ._lissom import jacobian as jacobian
    from ._lissom import modes as modes
    from ._lissom import newmark as newmark
    from ._lissom import root as root
    from ._lissom import simulate as simulate
    from ._lissom import simulate_many as simulate_many
    from ._lissom import solve_ivp as solve_ivp
    from ._lissom import statics as statics
    from .analysis.contact_events import ContactEvent as ContactEvent
    from .analysis.equilibria import EquilibriumSensitivityResult as EquilibriumSensitivityResult
    from .analysis.equilibria import equilibrium_sensitivity as equilibrium_sensitivity
    from .analysis.fits import FitResult as FitResult
    from .analysis.fits import FittedData as FittedData
    from .analysis.fits import fit as fit
    from .analysis.linear import LinearModel as LinearModel
    from .analysis.linear import linearise as linearise
    from .analysis.many import EquilibriaResult as EquilibriaResult
    from .analysis.many import statics_many as statics_many
    from .analysis.measurements import NaturalFrequencies as NaturalFrequencies
    from .analysis.measurements import RecordedMotion as RecordedMotion
    from .analysis.measurements import StaticShapes as StaticShapes
    from .analysis.peaks import Peak as Peak
    from .analysis.sensitivities import SensitivityResult as SensitivityResult
    from .analysis.sensitivities import sensitivity as sensitivity
    from .analysis.sweeps import sweep as sweep
    from .model.contacts import Ball as Ball
    from .model.contacts import Box as Box
    from .model.contacts import Capsule as Capsule
    from .model.contacts import Contact as Contact
    from .model.contacts import ConvexMesh as ConvexMesh
    from .model.contacts import DistanceGrid as DistanceGrid
    from .model.contacts import HalfSpace as HalfSpace
    from .model.contacts import HeightField as HeightField
    from .model.contacts import Mesh as Mesh
    from .model.contacts import Sphere as Sphere
    from .model.contacts import Touch as Touch
    from .model.contacts import Tube as Tube
    from .model.targets import Target as Target
    from .model.visual_files import read_visuals as read_visuals
    from .model.visuals import Visual as Visual
    from .results.io import load as load

    __all__: list[str]
else:
    #: The public names by the modules that define them; a test compares them with the imports above.
    _NAMES = {
        "_lissom": """
            DOP853 RK45 AccuracyWarning ActiveStrain ActuateResult Along Balance BaseMotion Body
            Chamber ContinuationResult ConvergenceError CriticalPoint CurveResult Cylindrical
            DenseOutput Distance Energy EnsembleResult EquilibriumPath Fluid Free Gear HardSteps Harmonic
            Input JacobianCheck Joint Link LissomError Load Loop LoopEnd Magnet Mimic Model ModesResult
            MotionResult Motor OdeResult OdeSolver Overlap Planar Prismatic Profile Radau ReachResult
            Revolute Robot Rod RootResult Scene SceneError SceneProblem Screw Section Segment Simulation
            SimulationSettings Simulations SpaceError Spherical SpringPendulum StaticsResult
            Statistics Support Tendon Universal Via Weld __version__ actuate check_jacobian choose_modes
            continuation jacobian modes newmark root simulate simulate_many solve_ivp statics
        """,
        "analysis.contact_events": "ContactEvent",
        "analysis.equilibria": "EquilibriumSensitivityResult equilibrium_sensitivity",
        "analysis.fits": "FitResult FittedData fit",
        "analysis.linear": "LinearModel linearise",
        "analysis.many": "EquilibriaResult statics_many",
        "analysis.measurements": "NaturalFrequencies RecordedMotion StaticShapes",
        "analysis.peaks": "Peak",
        "analysis.sensitivities": "SensitivityResult sensitivity",
        "analysis.sweeps": "sweep",
        "model.contacts": (
            "Ball Box Capsule Contact ConvexMesh DistanceGrid HalfSpace HeightField Mesh Sphere Touch Tube"
        ),
        "model.targets": "Target",
        "model.visual_files": "read_visuals",
        "model.visuals": "Visual",
        "results.io": "load",
    }
    #: Public modules.
    _ROOMS = ("gym", "jax", "methods", "sensors", "torch", "urdf")
    _MODULES = {name: module for module, names in _NAMES.items() for name in names.split()}

    __all__ = sorted(_MODULES)

    #: Modules that pickles and documents of earlier versions name, and where their contents are now.
    _MOVED = {
        "contact_events": "analysis.contact_events",
        "contacts": "model.contacts",
        "equilibria": "analysis.equilibria",
        "fits": "analysis.fits",
        "keeping": "results.io",
        "linear": "analysis.linear",
        "live": "drawing.live",
        "materials": "analysis.materials",
        "measurements": "analysis.measurements",
        "parameters": "analysis.parameters",
        "report": "drawing.report",
        "sensitivities": "analysis.sensitivities",
        "sweeps": "analysis.sweeps",
        "targets": "model.targets",
    }

    class _Moved:
        """Finds modules by their old names; the module itself is imported once, by its new name."""

        @staticmethod
        def find_spec(name, path=None, target=None):
            package, _, old = name.partition(".")
            if package != __name__ or old.partition(".")[0] not in _MOVED:
                return None
            from importlib.machinery import ModuleSpec

            return ModuleSpec(name, _Moved)

        @staticmethod
        def create_module(spec):
            return None

        @staticmethod
        def exec_module(module):
            from importlib import import_module

            old, *inner = module.__name__.split(".")[1:]
            sys.modules[module.__name__] = import_module(".".join([__name__, _MOVED[old], *inner]))

    # Before Python's own finders, which would import files in the moved folders a second time.
    sys.meta_path.insert(0, _Moved)

    def __getattr__(name):
        from importlib import import_module

        if name in _ROOMS or name in _MOVED:
            return import_module(f"lissom.{name}")
        if name not in _MODULES:
            from .common.elsewhere import of_package

            missing = f"module {__name__!r} has no attribute {name!r}{of_package(name, __all__)}"
            raise AttributeError(missing, name=name, obj=sys.modules[__name__])
        # Before the compiled module, which needs it. If it is missing or its import is interrupted, Python's
        # own error is raised.
        import_module("numpy")
        import_module("lissom.attached").attach()
        globals()[name] = found = getattr(import_module(f"lissom.{_MODULES[name]}"), name)
        return found

    def __dir__():
        return sorted(globals().keys() | set(__all__))
