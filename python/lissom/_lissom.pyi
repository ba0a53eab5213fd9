import builtins
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import Field
from os import PathLike
from typing import Any, ClassVar, Literal, Self, TypeAlias, TypeVar, final

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray
from typing_extensions import deprecated, disjoint_base

from . import methods as _methods
from .analysis.contact_events import ContactEvent
from .analysis.peaks import Peak
from .drawing.live.server import LiveView
from .model.contacts import Touch
from .model.targets import Target
from .model.visuals import Visual

__version__: str
build_profile: str

class LissomError(Exception): ...
class AccuracyWarning(UserWarning): ...

class ConvergenceError(LissomError):
    result: RootResult

@disjoint_base
class Part:
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    def __new__(cls, *args: Any, **kwargs: Any) -> Self: ...
    def __hash__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, _memo: Any, /) -> Self: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...
    def to_toml(self) -> str: ...

# Classes that are made from the tables of `description`; `test_description.py` compares them.
class Section(Part):
    @property
    def shape(self) -> Literal["circle", "hollow_circle", "rectangle", "ellipse", "given"]: ...
    @property
    def parameters(self) -> dict[str, Any]: ...
    def area(self, x: float = 0.0) -> float: ...
    def second_moments(self, x: float = 0.0) -> tuple[float, float]: ...
    def torsion_constant(self, x: float = 0.0) -> float: ...
    def cowper(self, poisson_ratio: float, x: float = 0.0) -> tuple[float, float]: ...
    def half_extents(self, x: float = 0.0) -> tuple[float, float]: ...
    @staticmethod
    def circle(
        radius: _Size,
        *,
        length: float | None = None,
    ) -> Section: ...
    @staticmethod
    def hollow_circle(
        outer: _Size,
        inner: _Size,
        *,
        length: float | None = None,
    ) -> Section: ...
    @staticmethod
    def rectangle(
        width: _Size,
        height: _Size,
        *,
        length: float | None = None,
    ) -> Section: ...
    @staticmethod
    def ellipse(
        semi_axis_y: _Size,
        semi_axis_z: _Size,
        *,
        length: float | None = None,
    ) -> Section: ...
    @staticmethod
    def given(
        stiffness: _Along,
        mass: _Along,
        inertia: _Along = (0.0, 0.0, 0.0),
        centre: _Along = (0.0, 0.0),
        *,
        length: float | None = None,
    ) -> Section: ...

class Segment(Part):
    __match_args__ = (
        "length",
        "radius",
        "young_modulus",
        "shear_modulus",
        "density",
        "modes",
        "retardation_time",
        "reference_strain",
        "shear_correction",
        "nodes",
    )
    def __init__(
        self,
        length: float,
        radius: _Size | None = None,
        young_modulus: float | None = None,
        shear_modulus: float | None = None,
        density: float | None = None,
        modes: dict[str, int] | Literal["auto"] | None = None,
        retardation_time: float = 0.0,
        reference_strain: _Along = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
        shear_correction: ArrayLike | Literal["cowper"] = 1.0,
        nodes: int | None = None,
        *,
        basis: Literal["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"] = "legendre",
        section: Section | None = None,
        poisson_ratio: float | None = None,
        magnetisation: _Along = (0.0, 0.0, 0.0),
        min_bend_radius: float | None = None,
        max_strain: float | None = None,
        max_stress: float | None = None,
    ) -> None: ...
    @property
    def length(self) -> float: ...
    @property
    def radius(self) -> tuple[float, float] | Profile | None: ...
    @property
    def young_modulus(self) -> float | None: ...
    @property
    def shear_modulus(self) -> float | None: ...
    @property
    def density(self) -> float | None: ...
    @property
    def modes(self) -> dict[str, int]: ...
    @property
    def retardation_time(self) -> float: ...
    @property
    def reference_strain(self) -> tuple[float, float, float, float, float, float] | Profile: ...
    @property
    def shear_correction(self) -> float | tuple[float, float] | Literal["cowper"]: ...
    @property
    def nodes(self) -> int | None: ...
    @property
    def basis(self) -> Literal["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"]: ...
    @property
    def section(self) -> Section: ...
    @property
    def poisson_ratio(self) -> float | None: ...
    @property
    def magnetisation(self) -> tuple[float, float, float] | Profile: ...
    @property
    def min_bend_radius(self) -> float | None: ...
    @property
    def max_strain(self) -> float | None: ...
    @property
    def max_stress(self) -> float | None: ...
    def stiffness(self, X: float = 0.0) -> NDArray[np.float64]: ...
    def generalised_stiffness(self) -> NDArray[np.float64]: ...
    def inertia(self, X: float = 0.0) -> NDArray[np.float64]: ...

class Body(Part):
    __match_args__ = ("mass",)
    def __init__(
        self,
        mass: float,
        *,
        at: float | None = None,
        centre: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        link: str | None = None,
        volume: float = 0.0,
        centre_of_volume: ArrayLike | None = None,
        added_mass_coefficient: float = 0.5,
        drag_area: float = 0.0,
        drag_coefficient: float = 1.0,
        viscous_drag: float = 0.0,
    ) -> None: ...
    @property
    def mass(self) -> float: ...
    @property
    def at(self) -> float | None: ...
    @property
    def centre(self) -> tuple[float, float, float]: ...
    @property
    def inertia(self) -> NDArray[np.float64]: ...
    @property
    def link(self) -> str | None: ...
    @property
    def volume(self) -> float: ...
    @property
    def centre_of_volume(self) -> tuple[float, float, float] | None: ...
    @property
    def added_mass_coefficient(self) -> float: ...
    @property
    def drag_area(self) -> float: ...
    @property
    def drag_coefficient(self) -> float: ...
    @property
    def viscous_drag(self) -> float: ...

class BaseMotion(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        translation: _Vector = (0.0, 0.0, 0.0),
        axis: ArrayLike | None = None,
        angle: _Number | None = None,
        rotation: _Vector | None = None,
    ) -> None: ...
    @property
    def translation(self) -> Any: ...
    @property
    def axis(self) -> tuple[float, float, float] | None: ...
    @property
    def angle(self) -> Any | None: ...
    @property
    def rotation(self) -> Any | None: ...

class Joint(Part): ...

class Weld(Joint):
    __match_args__ = ()
    def __init__(
        self,
    ) -> None: ...

class Mimic(Part):
    __match_args__ = ("link",)
    def __init__(
        self,
        link: str,
        *,
        multiplier: float = 1.0,
        offset: float = 0.0,
    ) -> None: ...
    @property
    def link(self) -> str: ...
    @property
    def multiplier(self) -> float: ...
    @property
    def offset(self) -> float: ...

class Revolute(Joint):
    __match_args__ = ("axis",)
    def __init__(
        self,
        axis: ArrayLike,
        *,
        stiffness: float = 0.0,
        rest: float = 0.0,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_velocity: float = 0.001,
        limits: ArrayLike | None = None,
        limit_stiffness: float = 0.0,
        limit_dissipation: float = 0.0,
        armature: float = 0.0,
        motion: _Number | None = None,
        mimic: Mimic | None = None,
    ) -> None: ...
    @property
    def axis(self) -> tuple[float, float, float]: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def rest(self) -> float: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def friction_velocity(self) -> float: ...
    @property
    def limits(self) -> tuple[float, float] | None: ...
    @property
    def limit_stiffness(self) -> float: ...
    @property
    def limit_dissipation(self) -> float: ...
    @property
    def armature(self) -> float: ...
    @property
    def motion(self) -> Any | None: ...
    @property
    def mimic(self) -> Mimic | None: ...

class Prismatic(Joint):
    __match_args__ = ("axis",)
    def __init__(
        self,
        axis: ArrayLike,
        *,
        stiffness: float = 0.0,
        rest: float = 0.0,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_velocity: float = 0.001,
        limits: ArrayLike | None = None,
        limit_stiffness: float = 0.0,
        limit_dissipation: float = 0.0,
        armature: float = 0.0,
        motion: _Number | None = None,
        mimic: Mimic | None = None,
    ) -> None: ...
    @property
    def axis(self) -> tuple[float, float, float]: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def rest(self) -> float: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def friction_velocity(self) -> float: ...
    @property
    def limits(self) -> tuple[float, float] | None: ...
    @property
    def limit_stiffness(self) -> float: ...
    @property
    def limit_dissipation(self) -> float: ...
    @property
    def armature(self) -> float: ...
    @property
    def motion(self) -> Any | None: ...
    @property
    def mimic(self) -> Mimic | None: ...

class Screw(Joint):
    __match_args__ = ("axis", "lead")
    def __init__(
        self,
        axis: ArrayLike,
        lead: float,
        *,
        stiffness: float = 0.0,
        rest: float = 0.0,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_velocity: float = 0.001,
        limits: ArrayLike | None = None,
        limit_stiffness: float = 0.0,
        limit_dissipation: float = 0.0,
        armature: float = 0.0,
        motion: _Number | None = None,
        mimic: Mimic | None = None,
    ) -> None: ...
    @property
    def axis(self) -> tuple[float, float, float]: ...
    @property
    def lead(self) -> float: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def rest(self) -> float: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def friction_velocity(self) -> float: ...
    @property
    def limits(self) -> tuple[float, float] | None: ...
    @property
    def limit_stiffness(self) -> float: ...
    @property
    def limit_dissipation(self) -> float: ...
    @property
    def armature(self) -> float: ...
    @property
    def motion(self) -> Any | None: ...
    @property
    def mimic(self) -> Mimic | None: ...

class Cylindrical(Joint):
    __match_args__ = ("axis",)
    def __init__(
        self,
        axis: ArrayLike,
    ) -> None: ...
    @property
    def axis(self) -> tuple[float, float, float]: ...

class Universal(Joint):
    __match_args__ = ("axis1", "axis2")
    def __init__(
        self,
        axis1: ArrayLike,
        axis2: ArrayLike,
    ) -> None: ...
    @property
    def axis1(self) -> tuple[float, float, float]: ...
    @property
    def axis2(self) -> tuple[float, float, float]: ...

class Planar(Joint):
    __match_args__ = ("normal",)
    def __init__(
        self,
        normal: ArrayLike,
    ) -> None: ...
    @property
    def normal(self) -> tuple[float, float, float]: ...

class Spherical(Joint):
    __match_args__ = ()
    def __init__(
        self,
    ) -> None: ...

class Free(Joint):
    __match_args__ = ()
    def __init__(
        self,
        *,
        motion: BaseMotion | None = None,
    ) -> None: ...
    @property
    def motion(self) -> BaseMotion | None: ...

class Link(Part):
    __match_args__ = ("name",)
    def __init__(
        self,
        name: str,
        *,
        rod: Iterable[Segment] | None = None,
        body: Body | None = None,
        joint: Joint = ...,
        parent: str | None = None,
        at: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def rod(self) -> tuple[Segment, ...] | None: ...
    @property
    def body(self) -> Body | None: ...
    @property
    def joint(self) -> Joint: ...
    @property
    def parent(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...

class Load(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        force: _Vector = (0.0, 0.0, 0.0),
        moment: _Vector = (0.0, 0.0, 0.0),
        at: float | None = None,
        along: ArrayLike | None = None,
        frame: Literal["world", "body"] = "world",
        link: str | None = None,
    ) -> None: ...
    @property
    def force(self) -> Any: ...
    @property
    def moment(self) -> Any: ...
    @property
    def at(self) -> float | None: ...
    @property
    def along(self) -> tuple[float, float] | None: ...
    @property
    def frame(self) -> Literal["world", "body"]: ...
    @property
    def link(self) -> str | None: ...

class Support(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        stiffness: ArrayLike = 0.0,
        rotational_stiffness: ArrayLike = 0.0,
        damping: ArrayLike = 0.0,
        rotational_damping: ArrayLike = 0.0,
        at: float | None = None,
        position: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        link: str | None = None,
    ) -> None: ...
    @property
    def stiffness(self) -> tuple[float, float, float]: ...
    @property
    def rotational_stiffness(self) -> tuple[float, float, float]: ...
    @property
    def damping(self) -> tuple[float, float, float]: ...
    @property
    def rotational_damping(self) -> tuple[float, float, float]: ...
    @property
    def at(self) -> float | None: ...
    @property
    def position(self) -> tuple[float, float, float] | None: ...
    @property
    def orientation(self) -> tuple[float, float, float, float] | None: ...
    @property
    def link(self) -> str | None: ...

class Fluid(Part):
    __match_args__ = ("density", "velocity")
    def __init__(
        self,
        density: float,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        *,
        viscous_drag: ArrayLike = (0.0, 0.0),
        drag_coefficients: ArrayLike = (0.0, 0.0),
        added_mass_coefficient: float = 1.0,
        buoyancy: bool = True,
    ) -> None: ...
    @property
    def density(self) -> float: ...
    @property
    def velocity(self) -> tuple[float, float, float]: ...
    @property
    def viscous_drag(self) -> tuple[float, float]: ...
    @property
    def drag_coefficients(self) -> tuple[float, float]: ...
    @property
    def added_mass_coefficient(self) -> float: ...
    @property
    def buoyancy(self) -> bool: ...

class Along(Part):
    __match_args__ = ("link", "offset", "along")
    def __init__(
        self,
        link: str | None = None,
        offset: Sequence[_AlongRod] = (0.0, 0.0),
        along: ArrayLike | None = None,
    ) -> None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def offset(self) -> tuple[Any, Any]: ...
    @property
    def along(self) -> tuple[float, float] | None: ...

class Via(Part):
    __match_args__ = ("link", "point", "at")
    def __init__(
        self,
        link: str | None,
        point: ArrayLike,
        at: float | None = None,
    ) -> None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def point(self) -> tuple[float, float, float]: ...
    @property
    def at(self) -> float | None: ...

class Tendon(Part):
    __match_args__ = ("name", "path")
    def __init__(
        self,
        name: str,
        path: Iterable[Along | Via],
        *,
        tension: _Number | None = None,
        length: _Number | None = None,
        stiffness: float | None = None,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_velocity: float = 0.001,
        sliding: _Number | None = None,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> tuple[Along | Via, ...]: ...
    @property
    def tension(self) -> Any | None: ...
    @property
    def length(self) -> Any | None: ...
    @property
    def stiffness(self) -> float | None: ...
    @property
    def damping(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def friction_velocity(self) -> float: ...
    @property
    def sliding(self) -> Any | None: ...

class Chamber(Part):
    __match_args__ = ("name", "path", "area", "pressure")
    def __init__(
        self,
        name: str,
        path: Iterable[Along],
        area: float,
        pressure: _Number = 0.0,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> tuple[Along, ...]: ...
    @property
    def area(self) -> float: ...
    @property
    def pressure(self) -> Any: ...

class Motor(Part):
    __match_args__ = ("joint", "torque")
    def __init__(
        self,
        joint: str,
        torque: _Number | None = None,
        *,
        position: _Number | None = None,
        gains: ArrayLike | None = None,
        limits: ArrayLike | None = None,
        name: str | None = None,
    ) -> None: ...
    @property
    def joint(self) -> str: ...
    @property
    def torque(self) -> Any | None: ...
    @property
    def position(self) -> Any | None: ...
    @property
    def gains(self) -> tuple[float, float] | None: ...
    @property
    def limits(self) -> tuple[float, float] | None: ...
    @property
    def name(self) -> str | None: ...

class ActiveStrain(Part):
    __match_args__ = ("link", "strain", "shape", "amount")
    def __init__(
        self,
        link: str | None,
        strain: Literal["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"],
        shape: _AlongRod = 1.0,
        amount: _Number = 0.0,
        *,
        name: str | None = None,
    ) -> None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def strain(self) -> Literal["torsion", "bend_y", "bend_z", "stretch", "shear_y", "shear_z"]: ...
    @property
    def shape(self) -> Any: ...
    @property
    def amount(self) -> Any: ...
    @property
    def name(self) -> str | None: ...

class LoopEnd(Part):
    __match_args__ = ("link", "at", "position", "orientation")
    def __init__(
        self,
        link: str | None = None,
        at: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    ) -> None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...

class Distance(Part):
    __match_args__ = ("length",)
    def __init__(
        self,
        length: float,
    ) -> None: ...
    @property
    def length(self) -> float: ...

class Gear(Part):
    __match_args__ = ("ratio",)
    def __init__(
        self,
        ratio: float = 1.0,
        *,
        offset: float = 0.0,
    ) -> None: ...
    @property
    def ratio(self) -> float: ...
    @property
    def offset(self) -> float: ...

class Loop(Part):
    __match_args__ = ("a", "b", "kind")
    def __init__(
        self,
        a: str | LoopEnd | Sequence[object] | Mapping[str, object] | None,
        b: str | LoopEnd | Sequence[object] | Mapping[str, object] | None,
        kind: Weld | Revolute | Prismatic | Cylindrical | Universal | Planar | Spherical | Distance | Gear,
        *,
        name: str = "",
    ) -> None: ...
    @property
    def a(self) -> str | LoopEnd: ...
    @property
    def b(self) -> str | LoopEnd: ...
    @property
    def kind(
        self,
    ) -> Weld | Revolute | Prismatic | Cylindrical | Universal | Planar | Spherical | Distance | Gear: ...
    @property
    def name(self) -> str: ...

class Ball(Part):
    __match_args__ = ("link", "radius")
    def __init__(
        self,
        link: str,
        radius: float,
        *,
        at: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None: ...
    @property
    def link(self) -> str: ...
    @property
    def radius(self) -> float: ...
    @property
    def at(self) -> float | None: ...
    @property
    def position(self) -> tuple[float, float, float]: ...

class HalfSpace(Part):
    __match_args__ = ("point", "normal")
    def __init__(
        self,
        point: ArrayLike = (0.0, 0.0, 0.0),
        normal: ArrayLike = (0.0, 0.0, 1.0),
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def point(self) -> tuple[float, float, float]: ...
    @property
    def normal(self) -> tuple[float, float, float]: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Sphere(Part):
    __match_args__ = ("centre", "radius")
    def __init__(
        self,
        centre: ArrayLike,
        radius: float,
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def centre(self) -> tuple[float, float, float]: ...
    @property
    def radius(self) -> float: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Capsule(Part):
    __match_args__ = ("start", "end", "radius")
    def __init__(
        self,
        start: ArrayLike,
        end: ArrayLike,
        radius: float,
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def start(self) -> tuple[float, float, float]: ...
    @property
    def end(self) -> tuple[float, float, float]: ...
    @property
    def radius(self) -> float: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Box(Part):
    __match_args__ = ("centre", "half_extents", "orientation")
    def __init__(
        self,
        centre: ArrayLike,
        half_extents: ArrayLike,
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def centre(self) -> tuple[float, float, float]: ...
    @property
    def half_extents(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class HeightField(Part):
    __match_args__ = ("heights", "spacing", "corner", "orientation")
    def __init__(
        self,
        heights: ArrayLike,
        spacing: ArrayLike,
        corner: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def heights(self) -> tuple[tuple[float, ...], ...]: ...
    @property
    def spacing(self) -> tuple[float, float]: ...
    @property
    def corner(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class ConvexMesh(Part):
    __match_args__ = ("points", "faces", "radius")
    def __init__(
        self,
        points: ArrayLike,
        faces: ArrayLike,
        radius: float = 0.0,
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def points(self) -> tuple[tuple[float, float, float], ...]: ...
    @property
    def faces(self) -> tuple[tuple[int, int, int], ...]: ...
    @property
    def radius(self) -> float: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Tube(Part):
    __match_args__ = ("points", "radius")
    def __init__(
        self,
        points: ArrayLike,
        radius: float,
        *,
        wall: float | None = None,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def points(self) -> tuple[tuple[float, float, float], ...]: ...
    @property
    def radius(self) -> float: ...
    @property
    def wall(self) -> float | None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class DistanceGrid(Part):
    __match_args__ = ("values", "spacing", "corner", "orientation")
    def __init__(
        self,
        values: ArrayLike,
        spacing: ArrayLike,
        corner: ArrayLike = (0.0, 0.0, 0.0),
        orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def values(self) -> tuple[tuple[tuple[float, ...], ...], ...]: ...
    @property
    def spacing(self) -> tuple[float, float, float]: ...
    @property
    def corner(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Mesh(Part):
    __match_args__ = ("points", "faces", "cell")
    def __init__(
        self,
        points: ArrayLike,
        faces: ArrayLike,
        cell: float | None = None,
        *,
        link: str | None = None,
        at: float | None = None,
    ) -> None: ...
    @property
    def points(self) -> tuple[tuple[float, float, float], ...]: ...
    @property
    def faces(self) -> tuple[tuple[int, int, int], ...]: ...
    @property
    def cell(self) -> float | None: ...
    @property
    def link(self) -> str | None: ...
    @property
    def at(self) -> float | None: ...

class Contact(Part):
    __match_args__ = ("a", "b")
    def __init__(
        self,
        a: str
        | Ball
        | HalfSpace
        | Sphere
        | Capsule
        | Box
        | HeightField
        | ConvexMesh
        | Tube
        | DistanceGrid
        | Mesh,
        b: str
        | Ball
        | HalfSpace
        | Sphere
        | Capsule
        | Box
        | HeightField
        | ConvexMesh
        | Tube
        | DistanceGrid
        | Mesh,
        *,
        stiffness: float | Literal["material"] | None = None,
        dissipation: float = 1.0,
        friction: ArrayLike | tuple[ArrayLike, ArrayLike] = 0.0,
        static_friction: float | None = None,
        stribeck_velocity: float = 0.1,
        slip_velocity: float = 0.0001,
        patch_radius: float = 0.0,
        name: str = "",
    ) -> None: ...
    @property
    def a(
        self,
    ) -> (
        str
        | Ball
        | HalfSpace
        | Sphere
        | Capsule
        | Box
        | HeightField
        | ConvexMesh
        | Tube
        | DistanceGrid
        | Mesh
    ): ...
    @property
    def b(
        self,
    ) -> (
        str
        | Ball
        | HalfSpace
        | Sphere
        | Capsule
        | Box
        | HeightField
        | ConvexMesh
        | Tube
        | DistanceGrid
        | Mesh
    ): ...
    @property
    def stiffness(self) -> float | Literal["material"] | None: ...
    @property
    def dissipation(self) -> float: ...
    @property
    def friction(self) -> tuple[float, float, float] | tuple[tuple[float, ...], tuple[float, ...]]: ...
    @property
    def static_friction(self) -> float | None: ...
    @property
    def stribeck_velocity(self) -> float: ...
    @property
    def slip_velocity(self) -> float: ...
    @property
    def patch_radius(self) -> float: ...
    @property
    def name(self) -> str: ...

class Magnet(Part):
    __match_args__ = ("moment",)
    def __init__(
        self,
        moment: ArrayLike,
        *,
        at: float | None = None,
        position: ArrayLike = (0.0, 0.0, 0.0),
        link: str | None = None,
    ) -> None: ...
    @property
    def moment(self) -> tuple[float, float, float]: ...
    @property
    def at(self) -> float | None: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def link(self) -> str | None: ...

# End of these classes.

@disjoint_base
class Model:
    @property
    def n(self) -> int: ...
    def to_scene(
        self,
        *,
        t_end: float = 1.0,
        name: str = "model",
        q0: ArrayLike | None = None,
        v0: ArrayLike | None = None,
        **simulation: Any,
    ) -> Scene: ...
    def advice(self) -> list[str]: ...
    @property
    def inputs(self) -> tuple[str, ...]: ...
    @property
    def u0(self) -> NDArray[np.float64]: ...
    def input_tangent(
        self,
        q: ArrayLike,
        qd: ArrayLike | None = None,
        qdd: ArrayLike | None = None,
        *,
        t: float | None = None,
        u: _Inputs | None = None,
    ) -> NDArray[np.float64]: ...
    def check_shape(self, q: ArrayLike) -> None: ...
    def inverse_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        t: float | None = None,
        u: _Inputs | None = None,
    ) -> NDArray[np.float64]: ...
    def mass_matrix(self, q: ArrayLike, *, t: float | None = None) -> NDArray[np.float64]: ...
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, *, t: float | None = None, u: _Inputs | None = None
    ) -> NDArray[np.float64]: ...
    def tangent(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        t: float | None = None,
        u: _Inputs | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def _tangent_at_rest(
        self, q: ArrayLike, *, t: float | None = None, u: _Inputs | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def energy(
        self, q: ArrayLike, qd: ArrayLike, *, t: float | None = None, u: _Inputs | None = None
    ) -> Energy: ...
    def dissipated_power(
        self, q: ArrayLike, qd: ArrayLike, *, t: float | None = None, u: _Inputs | None = None
    ) -> float: ...
    def supplied_power(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike | None = None,
        *,
        t: float | None = None,
        u: _Inputs | None = None,
    ) -> float: ...

@final
class Energy:
    @property
    def kinetic(self) -> float: ...
    @property
    def elastic(self) -> float: ...
    @property
    def gravitational(self) -> float: ...
    @property
    def loads(self) -> float: ...
    @property
    def total(self) -> float: ...

@final
class Balance:
    def __new__(
        cls,
        *,
        kinetic: ArrayLike,
        elastic: ArrayLike,
        gravitational: ArrayLike,
        loads: ArrayLike,
        dissipated: ArrayLike,
        work: ArrayLike,
    ) -> Balance: ...
    @property
    def kinetic(self) -> NDArray[np.float64]: ...
    @property
    def elastic(self) -> NDArray[np.float64]: ...
    @property
    def gravitational(self) -> NDArray[np.float64]: ...
    @property
    def loads(self) -> NDArray[np.float64]: ...
    @property
    def dissipated(self) -> NDArray[np.float64]: ...
    @property
    def work(self) -> NDArray[np.float64]: ...
    @property
    def total(self) -> NDArray[np.float64]: ...
    @property
    def scale(self) -> float: ...
    @property
    def drift(self) -> float: ...
    @property
    def moves(self) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class SpringPendulum(Model):
    def __new__(
        cls, length: float = 1.0, mass: float = 1.0, stiffness: float = 10.0, gravity: float = 9.81
    ) -> SpringPendulum: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def length(self) -> float: ...
    @property
    def mass(self) -> float: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def gravity(self) -> float: ...
    def explain(self) -> str: ...
    def __getnewargs__(self) -> tuple[float, float, float, float]: ...

@final
class RootResult:
    @property
    def x(self) -> Any: ...
    @property
    def fun(self) -> Any: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(
        self,
    ) -> Literal[
        "converged_residual",
        "converged_step",
        "already_root",
        "stationary_point",
        "singular_jacobian",
        "iteration_limit",
        "diverged",
        "stalled",
        "line_search_failed",
        "trust_region_collapsed",
        "longest_steps",
        "non_finite_residual",
        "non_finite_jacobian",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def residual_norm(self) -> float: ...
    @property
    def step_norm(self) -> float: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    @property
    def nlu(self) -> int: ...
    @property
    def nfev_jac(self) -> int: ...
    @property
    def doubt(self) -> str | None: ...
    @property
    def multiplicity(self) -> int | None: ...
    @property
    def history(self) -> dict[str, NDArray[np.float64]] | None: ...

@final
class JacobianCheck:
    @property
    def relative_difference(self) -> float: ...
    @property
    def row(self) -> int: ...
    @property
    def column(self) -> int: ...
    @property
    def given(self) -> float: ...
    @property
    def difference(self) -> float: ...

@final
class OdeResult:
    @property
    def t(self) -> NDArray[np.float64]: ...
    @property
    def y(self) -> NDArray[np.float64]: ...
    @property
    def sol(self) -> DenseOutput | None: ...
    @property
    def t_events(self) -> list[NDArray[np.float64]] | None: ...
    @property
    def y_events(self) -> list[NDArray[np.float64]] | None: ...
    @property
    def nfev(self) -> int: ...
    @property
    def nfev_jac(self) -> int: ...
    @property
    def njev(self) -> int: ...
    @property
    def nlu(self) -> int: ...
    @property
    def naccepted(self) -> int: ...
    @property
    def nrejected(self) -> int: ...
    @property
    def status(self) -> Literal[0, 1, -1]: ...
    @property
    def reason(
        self,
    ) -> Literal[
        "finished",
        "event",
        "too_many_steps",
        "step_too_small",
        "non_finite",
        "non_finite_jacobian",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def success(self) -> bool: ...
    @property
    def stiff_at(self) -> float | None: ...

@final
class DenseOutput:
    @property
    def ts(self) -> NDArray[np.float64]: ...
    @property
    def t_min(self) -> float: ...
    @property
    def t_max(self) -> float: ...
    def __call__(self, t: ArrayLike) -> NDArray[np.float64]: ...

@disjoint_base
class OdeSolver:
    def step(self) -> str | None: ...
    def dense_output(self) -> DenseOutput: ...
    def error_estimate(self) -> NDArray[np.float64]: ...
    @property
    def n(self) -> int: ...
    @property
    def status(self) -> Literal["running", "finished", "failed"]: ...
    @property
    def t(self) -> float: ...
    @property
    def y(self) -> NDArray[np.float64]: ...
    @property
    def t_old(self) -> float | None: ...
    @property
    def t_bound(self) -> float: ...
    @property
    def direction(self) -> float: ...
    @property
    def step_size(self) -> float | None: ...
    @property
    def nfev(self) -> int: ...
    @property
    def nfev_jac(self) -> int: ...
    @property
    def njev(self) -> int: ...
    @property
    def nlu(self) -> int: ...
    @property
    def naccepted(self) -> int: ...
    @property
    def nrejected(self) -> int: ...

class RK45(OdeSolver):
    A: ClassVar[NDArray[np.float64]]
    B: ClassVar[NDArray[np.float64]]
    C: ClassVar[NDArray[np.float64]]
    def __new__(
        cls,
        fun: Callable[..., Any] | int | Model | Any,
        t0: float,
        y0: ArrayLike,
        t_bound: float,
        *,
        args: tuple[Any, ...] | ArrayLike | None = None,
        rtol: ArrayLike = 0.001,
        atol: ArrayLike = 1e-06,
        first_step: float | None = None,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
        vectorized: bool = False,
        controller: Literal["I", "PI"] = "I",
    ) -> Self: ...

class DOP853(OdeSolver):
    A: ClassVar[NDArray[np.float64]]
    B: ClassVar[NDArray[np.float64]]
    C: ClassVar[NDArray[np.float64]]
    def __new__(
        cls,
        fun: Callable[..., Any] | int | Model | Any,
        t0: float,
        y0: ArrayLike,
        t_bound: float,
        *,
        args: tuple[Any, ...] | ArrayLike | None = None,
        rtol: ArrayLike = 0.001,
        atol: ArrayLike = 1e-06,
        first_step: float | None = None,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
        vectorized: bool = False,
        controller: Literal["I", "PI"] = "I",
    ) -> Self: ...

class Radau(OdeSolver):
    def __new__(
        cls,
        fun: Callable[..., Any] | int | Model | Any,
        t0: float,
        y0: ArrayLike,
        t_bound: float,
        *,
        args: tuple[Any, ...] | ArrayLike | None = None,
        rtol: ArrayLike = 0.001,
        atol: ArrayLike = 1e-06,
        first_step: float | None = None,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
        vectorized: bool = False,
        jac: Callable[..., Any] | ArrayLike | Any | None = None,
        jac_sparsity: ArrayLike | Any | None = None,
    ) -> Self: ...

def solve_ivp(
    fun: Callable[..., Any] | int | Model | Any,
    t_span: tuple[float, float] | ArrayLike,
    y0: ArrayLike,
    method: Literal["rk45", "dop853", "radau", "RK45", "DOP853", "Radau"] | type[OdeSolver] = "rk45",
    t_eval: ArrayLike | None = None,
    dense_output: bool = False,
    events: Callable[..., Any] | Sequence[Callable[..., Any]] | None = None,
    vectorized: bool = False,
    args: tuple[Any, ...] | ArrayLike | None = None,
    *,
    rtol: ArrayLike = 0.001,
    atol: ArrayLike = 1e-06,
    first_step: float | None = None,
    max_step: float | None = None,
    min_step: float = 0.0,
    max_steps: int | None = None,
    jac: Callable[..., Any] | ArrayLike | Any | None = None,
    jac_sparsity: ArrayLike | Any | None = None,
    controller: Literal["I", "PI"] = "I",
    event_samples: int = 10,
    callback: Callable[[float, NDArray[np.float64]], object] | None = None,
) -> OdeResult: ...
def root(
    fun: Callable[..., Any],
    x0: ArrayLike,
    *,
    args: tuple[Any, ...] = (),
    jac: Literal["forward", "central"] | Callable[..., Any] = "forward",
    method: Literal["newton", "line_search", "trust_region"] = "newton",
    tol: float = 1e-6,
    max_iter: int = 1000,
    xtol: float = 0.0,
    xtol_abs: float = 0.0,
    x_scale: ArrayLike | None = None,
    f_scale: ArrayLike | None = None,
    max_step: float | None = None,
    keep_jacobian: bool = False,
    accelerate: bool = False,
    history: bool = False,
    raise_on_failure: bool = False,
) -> RootResult: ...
def jacobian(
    fun: Callable[..., Any],
    x: ArrayLike,
    method: Literal["central", "forward"] = "central",
    *,
    x_scale: ArrayLike | None = None,
    args: tuple[Any, ...] = (),
) -> NDArray[np.float64]: ...
def _stub_of_methods() -> str: ...
def _stub_of_parts() -> str: ...
def _stub_of_models() -> list[tuple[str, str]]: ...
def check_target(target: Target) -> None: ...
def check_model(found: object, place: str) -> None: ...
def measured_places(model: Model, t: ArrayLike, q: ArrayLike) -> list[list[float]]: ...
def scales_of(model: Model) -> tuple[float, list[float]]: ...
def meant(word: str, known: Sequence[str], /) -> str | None: ...
def did_you_mean(word: str, known: Sequence[str], /) -> str | None: ...
def unexpected_keywords(words: Sequence[str], known: Sequence[str], /) -> str: ...
def centre_line(points: ArrayLike) -> NDArray[np.float64]: ...
def machine() -> tuple[str, int]: ...
def finite_array(value: Any, name: str) -> NDArray[np.float64]: ...
def inputs_by_name(u: Any, models: Sequence[Model]) -> Any: ...
def as_number(value: Any, name: str) -> float: ...
def as_whole(value: Any, name: str) -> int: ...
def as_flag(value: Any, name: str) -> bool: ...
def as_text(value: Any, name: str) -> str: ...
def check_jacobian(
    fun: Callable[..., Any],
    jac: Callable[..., Any],
    x: ArrayLike,
    *,
    x_scale: ArrayLike | None = None,
    args: tuple[Any, ...] = (),
) -> JacobianCheck: ...

@final
class Profile:
    def __new__(
        cls,
        length: float,
        *,
        stations: ArrayLike | None = None,
        values: ArrayLike | None = None,
        coefficients: ArrayLike | None = None,
    ) -> Profile: ...
    @property
    def length(self) -> float: ...
    @property
    def stations(self) -> NDArray[np.float64] | None: ...
    @property
    def values(self) -> NDArray[np.float64] | None: ...
    @property
    def coefficients(self) -> NDArray[np.float64] | None: ...
    def __call__(self, X: ArrayLike) -> NDArray[np.float64]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[float], dict[str, Any]]: ...

# A number, a pair (base, tip), or a function of the arc length: a table, a callable or a profile.
_Inputs: TypeAlias = ArrayLike | Mapping[str, ArrayLike]
_InputRows: TypeAlias = (
    _Inputs | Sequence[Mapping[str, ArrayLike]] | Sequence[Sequence[Mapping[str, ArrayLike]]]
)
_Size: TypeAlias = (
    float | tuple[float, float] | tuple[ArrayLike, ArrayLike] | Callable[[float], float] | Profile
)
_Along: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike] | Callable[[float], ArrayLike] | Profile

#: Times and values, and their interpolation: linear for loads; by default cubic for prescribed motions.
_Table: TypeAlias = (
    tuple[ArrayLike, ArrayLike] | tuple[ArrayLike, ArrayLike, Literal["linear", "monotone", "cubic"]]
)
#: Three numbers, or what varies in time: a table, a Harmonic, an Input, or a function of time.
_Number: TypeAlias = float | _Table | Harmonic | Input | Callable[[float], Any]
_AlongRod: TypeAlias = (
    float | tuple[float, float] | tuple[ArrayLike, ArrayLike] | Profile | Callable[[float], float]
)
_Actuator: TypeAlias = Tendon | Chamber | Motor | ActiveStrain
_Vector: TypeAlias = ArrayLike | _Table | Harmonic | Input | Callable[[float], ArrayLike]

@final
class Input:
    def __new__(cls, name: str, default: ArrayLike = 0.0) -> Self: ...
    @property
    def name(self) -> str: ...
    @property
    def default(self) -> float | tuple[float, float, float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __getnewargs__(self) -> tuple[str, float | tuple[float, float, float]]: ...

@final
class Harmonic:
    def __new__(
        cls,
        amplitude: ArrayLike = 0,
        frequency: float = 0.0,
        *,
        phase: float = 0.0,
        mean: ArrayLike = 0,
        rate: ArrayLike = 0,
    ) -> Harmonic: ...
    @property
    def amplitude(self) -> float | tuple[float, float, float]: ...
    @property
    def frequency(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def mean(self) -> float | tuple[float, float, float]: ...
    @property
    def rate(self) -> float | tuple[float, float, float]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, float], dict[str, Any]]: ...

@disjoint_base
class Robot(Model):
    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]
    # From the table of `described::Robot`.
    def __new__(
        cls,
        links: Iterable[Link],
        *,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        loads: Iterable[Load] = (),
        bodies: Iterable[Body] = (),
        supports: Iterable[Support] = (),
        fluid: Fluid | None = None,
        base_motion: BaseMotion | None = None,
        actuators: Iterable[Tendon | Chamber | Motor | ActiveStrain] = (),
        loops: Iterable[Loop] = (),
        contacts: Iterable[Contact] = (),
        magnets: Iterable[Magnet] = (),
        field: _Vector = (0.0, 0.0, 0.0),
    ) -> Self: ...
    @property
    def links(self) -> tuple[Link, ...]: ...
    @property
    def gravity(self) -> tuple[float, float, float]: ...
    @property
    def loads(self) -> tuple[Load, ...]: ...
    @property
    def bodies(self) -> tuple[Body, ...]: ...
    @property
    def supports(self) -> tuple[Support, ...]: ...
    @property
    def fluid(self) -> Fluid | None: ...
    @property
    def base_motion(self) -> BaseMotion | None: ...
    @property
    def actuators(self) -> tuple[Tendon | Chamber | Motor | ActiveStrain, ...]: ...
    @property
    def loops(self) -> tuple[Loop, ...]: ...
    @property
    def contacts(self) -> tuple[Contact, ...]: ...
    @property
    def magnets(self) -> tuple[Magnet, ...]: ...
    @property
    def field(self) -> Any: ...
    # End of what is from it.
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @staticmethod
    def from_urdf(path: str | PathLike[str], **options: Any) -> Robot: ...
    @property
    def coordinates(self) -> tuple[str, ...]: ...
    def slice(self, link: str) -> builtins.slice[int, int, int]: ...
    @property
    def constraints(self) -> int: ...
    def redundant_constraints(self, q: ArrayLike) -> dict[str, int]: ...
    def _contact_stiffness(self) -> list[float]: ...
    def _implausible_units(self) -> list[str]: ...
    def _loops_at_rest(
        self, q: ArrayLike, *, t: ArrayLike | None = None, u: _Inputs | None = None
    ) -> NDArray[np.float64]: ...
    def loop_gaps(self, q: ArrayLike, *, t: ArrayLike | None = None) -> NDArray[np.float64]: ...
    def loop_forces(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        name: str | None = None,
        t: ArrayLike | None = None,
        u: _Inputs | None = None,
    ) -> Any: ...
    def contact_forces(
        self, q: ArrayLike, qd: ArrayLike, *, name: str | None = None, t: ArrayLike | None = None
    ) -> NDArray[np.float64]: ...
    def touches(
        self, q: ArrayLike, qd: ArrayLike | None = None, *, t: float | None = None
    ) -> list[Touch]: ...
    def actuator_length(self, name: str, q: ArrayLike, *, t: ArrayLike | None = None) -> Any: ...
    def actuator_rate(self, name: str, q: ArrayLike, qd: ArrayLike, *, t: ArrayLike | None = None) -> Any: ...
    def actuator_gradient(
        self, name: str, q: ArrayLike, *, t: ArrayLike | None = None
    ) -> NDArray[np.float64]: ...
    def actuator_force(
        self,
        name: str,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        t: ArrayLike | None = None,
        u: _Inputs | None = None,
        qdd: ArrayLike | None = None,
    ) -> Any: ...
    @property
    def nodes(self) -> tuple[int, ...]: ...
    @property
    def kernel(self) -> Literal["planar", "spatial"]: ...
    @property
    def multiplications(self) -> dict[str, int]: ...
    def explain(self) -> str: ...
    def pose(
        self,
        q: ArrayLike,
        X: ArrayLike | None = None,
        *,
        link: str | None = None,
        t: ArrayLike | None = None,
    ) -> NDArray[np.float64]: ...
    def jacobian(
        self, q: ArrayLike, X: float | None = None, *, link: str | None = None, t: ArrayLike | None = None
    ) -> NDArray[np.float64]: ...
    def velocity(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        X: float | None = None,
        *,
        link: str | None = None,
        t: ArrayLike | None = None,
    ) -> NDArray[np.float64]: ...
    def acceleration(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        X: float | None = None,
        *,
        link: str | None = None,
        t: ArrayLike | None = None,
    ) -> NDArray[np.float64]: ...
    def centre_of_mass(self, q: ArrayLike, *, t: ArrayLike | None = None) -> NDArray[np.float64]: ...
    def momentum(self, q: ArrayLike, qd: ArrayLike, *, t: ArrayLike | None = None) -> NDArray[np.float64]: ...
    def joint_wrench(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        link: str | None = None,
        t: ArrayLike | None = None,
        u: _Inputs | None = None,
    ) -> NDArray[np.float64]: ...
    def strain(
        self, q: ArrayLike, X: ArrayLike | None = None, *, link: str | None = None
    ) -> NDArray[np.float64]: ...
    def internal_wrench(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        X: ArrayLike | None = None,
        *,
        link: str | None = None,
        t: ArrayLike | None = None,
        by: Literal["balance", "material"] = "balance",
        u: _Inputs | None = None,
    ) -> NDArray[np.float64]: ...
    def reach(
        self,
        link: str | Mapping[str, ArrayLike] | Iterable[Target] | None,
        pose: ArrayLike | None = None,
        *,
        X: float | None = None,
        point: ArrayLike | None = None,
        position_weight: ArrayLike = 1.0,
        orientation_weight: ArrayLike = 1.0,
        q0: ArrayLike | None = None,
        bounds: tuple[ArrayLike, ArrayLike] | None = None,
        prefer: Literal["start", "energy"] | ArrayLike | None = None,
        t: float | None = None,
        tol: float = 1e-9,
        max_iter: int = 200,
        restarts: int = 8,
    ) -> ReachResult: ...
    def coordinates_of(
        self,
        points: ArrayLike,
        frames: ArrayLike | None = None,
        *,
        X: ArrayLike | None = None,
        link: str | None = None,
        q0: ArrayLike | None = None,
    ) -> CurveResult: ...
    def base_wrench(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        t: ArrayLike | None = None,
        u: _Inputs | None = None,
    ) -> NDArray[np.float64]: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...

@final
class Rod(Robot):
    # From the table of `described::Rod`.
    def __new__(
        cls,
        segments: Iterable[Segment],
        base_position: ArrayLike = (0.0, 0.0, 0.0),
        base_orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
        gravity: ArrayLike = (0.0, 0.0, -9.81),
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        tip_moment: ArrayLike = (0.0, 0.0, 0.0),
        tip_mass: float = 0.0,
        *,
        loads: Iterable[Load] = (),
        bodies: Iterable[Body] = (),
        base_motion: BaseMotion | None = None,
        supports: Iterable[Support] = (),
        fluid: Fluid | None = None,
        actuators: Iterable[Tendon | Chamber | Motor | ActiveStrain] = (),
        contacts: Iterable[Contact] = (),
        magnets: Iterable[Magnet] = (),
        field: _Vector = (0.0, 0.0, 0.0),
    ) -> Self: ...
    @property
    def segments(self) -> tuple[Segment, ...]: ...
    @property
    def base_position(self) -> tuple[float, float, float]: ...
    @property
    def base_orientation(self) -> tuple[float, float, float, float]: ...
    @property
    def gravity(self) -> tuple[float, float, float]: ...
    @property
    def tip_force(self) -> tuple[float, float, float]: ...
    @property
    def tip_moment(self) -> tuple[float, float, float]: ...
    @property
    def tip_mass(self) -> float: ...
    @property
    def loads(self) -> tuple[Load, ...]: ...
    @property
    def bodies(self) -> tuple[Body, ...]: ...
    @property
    def base_motion(self) -> BaseMotion | None: ...
    @property
    def supports(self) -> tuple[Support, ...]: ...
    @property
    def fluid(self) -> Fluid | None: ...
    @property
    def actuators(self) -> tuple[Tendon | Chamber | Motor | ActiveStrain, ...]: ...
    @property
    def contacts(self) -> tuple[Contact, ...]: ...
    @property
    def magnets(self) -> tuple[Magnet, ...]: ...
    @property
    def field(self) -> Any: ...
    # End of what is from it.
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    @property
    def length(self) -> float: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Any, ...], dict[str, Any]]: ...

class SceneError(ValueError):
    problems: list[SceneProblem]

@final
class SceneProblem:
    @property
    def file(self) -> str: ...
    @property
    def line(self) -> int: ...
    @property
    def column(self) -> int: ...
    @property
    def key(self) -> str: ...
    @property
    def wrong(self) -> str: ...
    @property
    def right(self) -> str: ...
    @property
    def snippet(self) -> str: ...

@final
class SimulationSettings:
    def __dir__(self) -> list[str]: ...
    @property
    def t0(self) -> float: ...
    @property
    def t_end(self) -> float: ...
    @property
    def method(
        self,
    ) -> Literal[
        "newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau", "quasi_static", "auto"
    ]: ...
    @property
    def dt(self) -> float: ...
    @property
    def jac(self) -> Literal["analytic", "forward", "central"]: ...
    @property
    def rtol(self) -> float: ...
    @property
    def atol(self) -> float | None: ...
    @property
    def output_dt(self) -> float | None: ...
    @property
    def quantities(self) -> tuple[str, ...]: ...
    @property
    @deprecated("write t_end - t0")
    def duration(self) -> float: ...
    @property
    @deprecated("write dt")
    def step(self) -> float: ...
    @property
    @deprecated("write jac")
    def jacobian(self) -> Literal["analytic", "forward", "central"]: ...
    @property
    @deprecated("write output_dt")
    def output_step(self) -> float | None: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...

@final
class Scene:
    @staticmethod
    def load(path: str | PathLike[str], *, anywhere: bool = False) -> Scene: ...
    @staticmethod
    def loads(
        text: str,
        name: str = "scene",
        *,
        anywhere: bool = False,
        imports: dict[str, bytes] | None = None,
    ) -> Scene: ...
    @staticmethod
    def schema() -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def imports(self) -> dict[str, bytes]: ...
    @property
    def model(self) -> Robot | SpringPendulum: ...
    @property
    def q0(self) -> NDArray[np.float64]: ...
    @property
    def v0(self) -> NDArray[np.float64]: ...
    @property
    def simulation(self) -> SimulationSettings: ...
    @property
    def options(self) -> dict[str, Any]: ...
    def run(self, **options: Any) -> MotionResult: ...
    def _set_aside(self, stem: str) -> tuple[str, list[tuple[str, str]]]: ...
    def advice(self) -> list[str]: ...
    def save(self, path: str | PathLike[str]) -> None: ...

@final
class Statistics:
    @property
    def wall_time(self) -> float: ...
    @property
    def time_error(self) -> float | None: ...
    @property
    def space_error(self) -> float | None: ...
    @property
    def steps(self) -> int: ...
    @property
    def rejected(self) -> int: ...
    @property
    def unsolved(self) -> int: ...
    @property
    def newton_iterations(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def nfev_jac(self) -> int: ...
    @property
    def njev(self) -> int: ...
    @property
    def nlu(self) -> int: ...
    @property
    def reuse_failures(self) -> int: ...
    @property
    def full_newton(self) -> int: ...

@final
class HardSteps:
    def __len__(self) -> int: ...
    @property
    def t(self) -> NDArray[np.float64]: ...
    @property
    def dt(self) -> NDArray[np.float64]: ...
    @property
    def attempts(self) -> NDArray[np.int64]: ...
    @property
    def halvings(self) -> NDArray[np.int64]: ...
    @property
    def iterations(self) -> NDArray[np.int64]: ...
    @property
    def tangents(self) -> NDArray[np.int64]: ...
    @property
    def evaluations(self) -> NDArray[np.int64]: ...
    @property
    def reasons(self) -> list[str]: ...
    @property
    def contacts(self) -> list[str | None]: ...

@final
class MotionResult:
    @property
    def t(self) -> NDArray[np.float64]: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def v(self) -> NDArray[np.float64]: ...
    @property
    def a(self) -> NDArray[np.float64]: ...
    @property
    def u(self) -> NDArray[np.float64]: ...
    @property
    def stats(self) -> Statistics: ...
    @property
    def balance(self) -> Balance | None: ...
    @property
    def model(self) -> Model | None: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(self) -> str: ...
    @property
    def message(self) -> str: ...
    @property
    def slack(self) -> list[str]: ...
    @property
    def doubt(self) -> str | None: ...
    @property
    def evaluations(self) -> NDArray[np.int64] | None: ...
    @property
    def deepest(self) -> Overlap | None: ...
    @property
    def hard_steps(self) -> HardSteps | None: ...
    def plot(self) -> NDArray[Any]: ...
    def animate(
        self,
        path: str | PathLike[str],
        *,
        fps: float = 25.0,
        speed: float = 1.0,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def picture(
        self,
        path: str | PathLike[str],
        *,
        times: ArrayLike | None = None,
        view: str | ArrayLike | None = None,
        width: float = 0.085,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def report(
        self, path: str | PathLike[str], *, title: str = "Motion", visuals: Sequence[Visual] = ()
    ) -> None: ...
    def contact_events(self) -> list[ContactEvent]: ...
    def peaks(self) -> list[Peak]: ...
    def pose(self, X: ArrayLike | None = None, *, link: str | None = None) -> NDArray[Any]: ...
    def save(
        self, path: str | PathLike[str], *, t: float | None = None, visuals: Sequence[Visual] = ()
    ) -> None: ...
    def to_xarray(self) -> xarray.Dataset: ...

_NewmarkMethod = Literal[
    "newmark",
    "average_acceleration",
    "linear_acceleration",
    "fox_goodwin",
    "central_difference",
    "hht",
    "generalised_alpha",
    "generalized_alpha",
]
_Method: TypeAlias = (
    _methods.Newmark | _methods.Radau | _methods.RK45 | _methods.DOP853 | _methods.QuasiStatic | _methods.Auto
)

def newmark(
    residual: Callable[..., Any],
    t_span: Iterable[float],
    q0: ArrayLike,
    v0: ArrayLike,
    *,
    dt: float,
    beta: float = 0.25,
    gamma: float = 0.5,
    jac: Literal["forward", "central"] | Callable[..., Any] = "forward",
    method: _NewmarkMethod = "newmark",
    alpha: float | None = None,
    rho_inf: float | None = None,
    rtol: ArrayLike = 1e-06,
    atol: ArrayLike | None = None,
    adaptive: bool = False,
    max_step: float | None = None,
    min_step: float = 0.0,
    max_steps: int | None = None,
    t_eval: ArrayLike | None = None,
    a0: ArrayLike | None = None,
    predictor: Literal["best", "last", "zero"] = "best",
    reuse_jacobian: bool = True,
    args: tuple[Any, ...] | None = None,
    callback: Callable[[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], object]
    | None = None,
) -> MotionResult: ...
def simulate(
    model: Model,
    t_end: float,
    *,
    t0: float = 0.0,
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    method: _NewmarkMethod | Literal["rk45", "dop853", "radau", "quasi_static", "auto"] | _Method = "newmark",
    dt: float = 0.01,
    jac: Literal["analytic", "forward", "central"] = "analytic",
    rtol: ArrayLike = 1e-06,
    atol: ArrayLike | None = None,
    t_eval: ArrayLike | Literal["steps"] | None = None,
    progress: Callable[[float], object] | None = None,
    beta: float = 0.25,
    gamma: float = 0.5,
    alpha: float | None = None,
    rho_inf: float | None = None,
    adaptive: bool = False,
    max_step: float | None = None,
    min_step: float = 0.0,
    max_steps: int | None = None,
    predictor: Literal["best", "last", "zero"] = "best",
    reuse_jacobian: bool = True,
    control: Callable[[float, NDArray[np.float64], NDArray[np.float64]], _Inputs] | None = None,
    control_step: float | None = None,
    max_seconds: float | None = None,
    u: _Inputs | None = None,
) -> MotionResult: ...
def has_separate_sections(model: Model) -> bool: ...
def has_free_lengths(model: Model) -> bool: ...
def has_one_sided_forces(model: Model) -> bool: ...
def sensitivities(
    model: Model,
    t: ArrayLike,
    q: ArrayLike,
    v: ArrayLike,
    a: ArrayLike,
    forces: Sequence[
        Sequence[tuple[Model, float]]
        | tuple[int, ArrayLike, ArrayLike]
        | tuple[int, ArrayLike, ArrayLike, int, Sequence[tuple[Segment, float]]]
        | tuple[int, int]
        | int
    ],
    dq0: ArrayLike,
    dv0: ArrayLike,
    *,
    method: str = "newmark",
    beta: float | None = None,
    gamma: float | None = None,
    alpha: float | None = None,
    rho_inf: float | None = None,
    intervals: Sequence[tuple[int, ArrayLike]] | None = None,
    weights: tuple[ArrayLike, ArrayLike] | None = None,
) -> tuple[NDArray[np.float64], ...]: ...
def simulate_many(
    model: Model | Iterable[Model],
    t_end: float,
    *,
    t0: float = 0.0,
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    u: _InputRows | None = None,
    control_step: float | None = None,
    workers: int | None = None,
    progress: bool | Callable[[int], object] = False,
    keep: Literal["states", "final", "summary"] = "states",
    places: Iterable[float | str | tuple[str, float]] | None = None,
    memory_limit: float = 4294967296.0,
    method: _NewmarkMethod | Literal["rk45", "dop853", "radau", "quasi_static", "auto"] | _Method = "newmark",
    dt: float = 0.01,
    jac: Literal["analytic", "forward", "central"] = "analytic",
    rtol: ArrayLike = 1e-06,
    atol: ArrayLike | None = None,
    t_eval: ArrayLike | None = None,
    beta: float = 0.25,
    gamma: float = 0.5,
    alpha: float | None = None,
    rho_inf: float | None = None,
    adaptive: bool = False,
    max_step: float | None = None,
    min_step: float = 0.0,
    max_steps: int | None = None,
    predictor: Literal["best", "last", "zero"] = "best",
    reuse_jacobian: bool = True,
    max_seconds: float | None = None,
) -> EnsembleResult: ...

@final
class EnsembleResult:
    @property
    def t(self) -> NDArray[np.float64]: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def v(self) -> NDArray[np.float64]: ...
    @property
    def poses(self) -> NDArray[np.float64] | None: ...
    @property
    def lowest(self) -> NDArray[np.float64] | None: ...
    @property
    def highest(self) -> NDArray[np.float64] | None: ...
    @property
    def mean(self) -> NDArray[np.float64] | None: ...
    @property
    def variance(self) -> NDArray[np.float64] | None: ...
    @property
    def reached(self) -> NDArray[np.float64]: ...
    @property
    def success(self) -> NDArray[np.bool_]: ...
    @property
    def status(self) -> NDArray[np.str_]: ...
    @property
    def message(self) -> tuple[str, ...]: ...
    @property
    def doubt(self) -> tuple[str | None, ...]: ...
    @property
    def slack(self) -> tuple[tuple[str, ...], ...]: ...
    @property
    def stats(self) -> dict[str, NDArray[Any]]: ...
    @property
    def keep(self) -> str: ...
    @property
    def workers(self) -> int: ...
    @property
    def wall_time(self) -> float: ...
    @property
    def nbytes(self) -> int: ...
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    @staticmethod
    def _restore(state: object) -> EnsembleResult: ...
    def plot(self, model: Model | None = None) -> NDArray[Any]: ...
    def report(
        self, path: str | PathLike[str], model: Model | None = None, *, title: str = "Many runs"
    ) -> None: ...
    def save(self, path: str | PathLike[str], model: Model | None = None) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

@final
class Simulation:
    def __new__(
        cls,
        model: Model,
        *,
        dt: float,
        method: _NewmarkMethod | Literal["rk45", "dop853", "radau", "quasi_static"] | _Method = "newmark",
        q0: ArrayLike | None = None,
        v0: ArrayLike | None = None,
        t0: float = 0.0,
        rtol: ArrayLike = 1e-06,
        atol: ArrayLike | None = None,
        beta: float = 0.25,
        gamma: float = 0.5,
        alpha: float | None = None,
        rho_inf: float | None = None,
        adaptive: bool = False,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_seconds: float | None = None,
    ) -> Self: ...
    def step(self, u: _Inputs | None = None, duration: float | None = None) -> str: ...
    def reset(
        self, *, q0: ArrayLike | None = None, v0: ArrayLike | None = None, t0: float | None = None
    ) -> None: ...
    def copy(self) -> Simulation: ...
    def view(
        self,
        *,
        port: int = 8080,
        speed: float = 1.0,
        paused: bool = False,
        ranges: Mapping[str, Sequence[float]] | None = None,
        block: bool = True,
        allow_hosts: Sequence[str] = (),
        dark: bool = False,
        visuals: Sequence[Visual] = (),
    ) -> LiveView: ...
    def __copy__(self) -> Simulation: ...
    def __deepcopy__(self, _memo: object) -> Simulation: ...
    @property
    def model(self) -> Model: ...
    @property
    def t(self) -> float: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def v(self) -> NDArray[np.float64]: ...
    @property
    def a(self) -> NDArray[np.float64]: ...
    @property
    def u(self) -> NDArray[np.float64]: ...
    @property
    def energy(self) -> Energy: ...
    @property
    def status(self) -> str: ...
    @property
    def success(self) -> bool: ...
    @property
    def message(self) -> str: ...
    @property
    def doubt(self) -> str | None: ...
    @property
    def time_error(self) -> float | None: ...

@final
class Simulations:
    def __new__(
        cls,
        model: Model | Iterable[Model],
        count: int | None = None,
        *,
        dt: float,
        method: _NewmarkMethod | Literal["rk45", "dop853", "radau", "quasi_static"] | _Method = "newmark",
        q0: ArrayLike | None = None,
        v0: ArrayLike | None = None,
        t0: float = 0.0,
        workers: int | None = None,
        rtol: ArrayLike = 1e-06,
        atol: ArrayLike | None = None,
        beta: float = 0.25,
        gamma: float = 0.5,
        alpha: float | None = None,
        rho_inf: float | None = None,
        adaptive: bool = False,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_seconds: float | None = None,
    ) -> Self: ...
    def step(self, u: _InputRows | None = None, duration: float | None = None) -> NDArray[np.bool_]: ...
    def reset(
        self,
        which: ArrayLike | None = None,
        *,
        q0: ArrayLike | None = None,
        v0: ArrayLike | None = None,
        t0: float | None = None,
    ) -> None: ...
    def message(self, row: int) -> str: ...
    def copy(self) -> Simulations: ...
    def __copy__(self) -> Simulations: ...
    def __deepcopy__(self, _memo: object) -> Simulations: ...
    def __len__(self) -> int: ...
    def __getitem__(self, row: int, /) -> Simulation: ...
    @property
    def models(self) -> tuple[Model, ...]: ...
    @property
    def count(self) -> int: ...
    @property
    def workers(self) -> int: ...
    @property
    def t(self) -> NDArray[np.float64]: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def v(self) -> NDArray[np.float64]: ...
    @property
    def a(self) -> NDArray[np.float64]: ...
    @property
    def u(self) -> NDArray[np.float64]: ...
    @property
    def status(self) -> list[str]: ...
    @property
    def success(self) -> NDArray[np.bool_]: ...

_AnyRobot = TypeVar("_AnyRobot", Robot, Rod)

def choose_modes(
    rod: _AnyRobot,
    t_end: float | None = None,
    *,
    rtol: float = 0.0001,
    dt: float = 0.01,
    segments: Sequence[int] | None = None,
    t0: float = 0.0,
) -> _AnyRobot: ...

_Stability = Literal["stable", "neutral", "divergence", "flutter"]

@final
class CriticalPoint:
    @property
    def kind(self) -> Literal["limit", "bifurcation"]: ...
    @property
    def index(self) -> int: ...
    @property
    def load_factor(self) -> float: ...
    @property
    def u(self) -> NDArray[np.float64] | None: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def directions(self) -> NDArray[np.float64]: ...

@final
class EquilibriumPath:
    @property
    def load_factor(self) -> NDArray[np.float64]: ...
    @property
    def u(self) -> NDArray[np.float64] | None: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def lowest_eigenvalue(self) -> NDArray[np.float64]: ...
    @property
    def stability(self) -> list[_Stability | None]: ...
    @property
    def critical_points(self) -> list[CriticalPoint]: ...

@final
class Overlap:
    @property
    def contact(self) -> str: ...
    @property
    def depth(self) -> float: ...
    @property
    def share(self) -> float: ...
    @property
    def t(self) -> float | None: ...

@final
class SpaceError:
    @property
    def tip(self) -> float: ...
    @property
    def shape(self) -> float: ...
    @property
    def relative(self) -> float: ...
    @property
    def curvature(self) -> float: ...
    @property
    def moment(self) -> float: ...
    @property
    def segment(self) -> int: ...
    @property
    def name(self) -> str: ...
    @property
    def strain(self) -> str: ...
    @property
    def rigid_stretch(self) -> float | None: ...
    @property
    def method(self) -> Literal["balance", "more_modes"]: ...

@final
class StaticsResult:
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(self) -> str: ...
    @property
    def message(self) -> str: ...
    @property
    def load_factor(self) -> float: ...
    @property
    def residual_norm(self) -> float: ...
    @property
    def step_norm(self) -> float: ...
    @property
    def is_stable(self) -> bool | None: ...
    @property
    def stability(self) -> _Stability | None: ...
    @property
    def undamped_stability(self) -> _Stability | None: ...
    @property
    def lowest_eigenvalue(self) -> float: ...
    @property
    def slack(self) -> list[str]: ...
    @property
    def path(self) -> EquilibriumPath | None: ...
    @property
    def deepest(self) -> Overlap | None: ...
    @property
    def space_error(self) -> SpaceError | None: ...
    @property
    def model(self) -> Robot | None: ...
    @property
    def u(self) -> NDArray[np.float64] | None: ...
    @property
    def t(self) -> float | None: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    def plot(self, model: Model) -> NDArray[Any]: ...
    def picture(
        self,
        path: str | PathLike[str],
        model: Model,
        *,
        view: str | ArrayLike | None = None,
        width: float = 0.085,
        t: float | None = None,
        u: _Inputs | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def report(
        self,
        path: str | PathLike[str],
        model: Model,
        *,
        title: str = "Equilibrium",
        t: float | None = None,
        u: _Inputs | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def peaks(self, model: Model, *, t: float | None = None, u: _Inputs | None = None) -> list[Peak]: ...
    def save(
        self,
        path: str | PathLike[str],
        model: Model | None = None,
        *,
        t: float | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

@final
class ReachResult:
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(
        self,
    ) -> Literal[
        "reached",
        "not_settled",
        "nearest",
        "at_limits",
        "iteration_limit",
        "stalled",
        "unresolved",
        "inverted",
        "collapsed",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def position_error(self) -> float | NDArray[np.float64]: ...
    @property
    def orientation_error(self) -> float | NDArray[np.float64]: ...
    @property
    def pose(self) -> NDArray[np.float64]: ...
    @property
    def at_limits(self) -> list[str]: ...
    @property
    def starts(self) -> int: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    def save(self, path: str | PathLike[str], model: Model | None = None) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

@final
class CurveResult:
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(
        self,
    ) -> Literal[
        "fitted",
        "iteration_limit",
        "stalled",
        "unresolved",
        "inverted",
        "collapsed",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def X(self) -> NDArray[np.float64]: ...
    @property
    def distance(self) -> NDArray[np.float64]: ...
    @property
    def angle(self) -> NDArray[np.float64]: ...
    @property
    def largest_distance(self) -> float: ...
    @property
    def rms_distance(self) -> float: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]: ...

@final
class ActuateResult:
    @property
    def u(self) -> NDArray[np.float64]: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(
        self,
    ) -> Literal[
        "reached",
        "not_settled",
        "nearest",
        "at_limits",
        "equilibrium_lost",
        "no_start",
        "iteration_limit",
        "stalled",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def position_error(self) -> float | NDArray[np.float64]: ...
    @property
    def orientation_error(self) -> float | NDArray[np.float64]: ...
    @property
    def pose(self) -> NDArray[np.float64]: ...
    @property
    def at_limits(self) -> list[str]: ...
    @property
    def is_stable(self) -> bool | None: ...
    @property
    def stability(self) -> _Stability | None: ...
    @property
    def space_error(self) -> SpaceError | None: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    @property
    def equilibria(self) -> int: ...
    def save(self, path: str | PathLike[str], model: Model | None = None) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

@final
class ContinuationResult:
    @property
    def path(self) -> EquilibriumPath: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(
        self,
    ) -> Literal[
        "finished",
        "no_start",
        "step_too_small",
        "too_many_steps",
        "unresolved",
        "inverted",
        "collapsed",
        "deep_penetration",
        "interrupted",
    ]: ...
    @property
    def message(self) -> str: ...
    @property
    def u(self) -> NDArray[np.float64] | None: ...
    @property
    def t(self) -> float | None: ...
    @property
    def space_error(self) -> SpaceError | None: ...
    @property
    def space_error_at(self) -> float | None: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...
    def plot(self, model: Model | None = None) -> NDArray[Any]: ...
    def animate(
        self,
        path: str | PathLike[str],
        model: Model,
        *,
        fps: float = 25.0,
        duration: float = 4.0,
        t: float | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def report(
        self,
        path: str | PathLike[str],
        model: Model,
        *,
        title: str = "Path of equilibria",
        t: float | None = None,
        u: _Inputs | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def save(self, path: str | PathLike[str], model: Model | None = None) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

def actuate(
    robot: Robot,
    target: ArrayLike | Target | Sequence[Target] | Mapping[str, ArrayLike],
    *,
    inputs: str | Sequence[str] | None = None,
    limits: tuple[ArrayLike, ArrayLike] | Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    u: _Inputs | None = None,
    q0: ArrayLike | None = None,
    t: float = 0.0,
    tol: float = 1e-9,
    max_iter: int = 100,
) -> ActuateResult: ...
def statics(
    model: Model,
    q0: ArrayLike | None = None,
    *,
    load_steps: Literal["auto"] | int | ArrayLike = "auto",
    method: Literal["auto", "load_path", "descent", "newton"] = "auto",
    t: float = 0.0,
    tol: float = 1e-10,
    max_iter: int = 500,
    max_steps: int = 500,
    u: _Inputs | None = None,
    stability: bool = True,
    space_error: bool | None = None,
    rtol: float | None = None,
) -> StaticsResult: ...
def continuation(
    model: Model,
    q0: ArrayLike | None = None,
    *,
    load_factor: float = 0.0,
    direction: ArrayLike | None = None,
    bounds: ArrayLike = (0.0, 1.0),
    max_step: float = 0.25,
    max_steps: int = 500,
    t: float = 0.0,
    tol: float = 1e-10,
    u: _Inputs | None = None,
    inputs: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
) -> ContinuationResult: ...

@final
class ModesResult:
    @property
    def frequency(self) -> NDArray[np.float64]: ...
    @property
    def angular_frequency(self) -> NDArray[np.float64]: ...
    @property
    def damping_ratio(self) -> NDArray[np.float64]: ...
    @property
    def eigenvalues(self) -> NDArray[np.complex128]: ...
    @property
    def shapes(self) -> NDArray[Any]: ...
    @property
    def is_classical(self) -> bool: ...
    @property
    def is_stable(self) -> bool: ...
    @property
    def stability(self) -> _Stability | None: ...
    @property
    def residual_norm(self) -> float: ...
    @property
    def u(self) -> NDArray[np.float64] | None: ...
    @property
    def t(self) -> float | None: ...
    @property
    def space_error(self) -> SpaceError | None: ...
    @property
    def q(self) -> NDArray[np.float64] | None: ...
    @property
    def model(self) -> Robot | None: ...
    @property
    def refined_frequency(self) -> NDArray[np.float64] | None: ...
    @property
    def message(self) -> str: ...
    def plot(self) -> NDArray[Any]: ...
    def animate(
        self,
        path: str | PathLike[str],
        model: Model,
        q: ArrayLike,
        *,
        mode: int = 0,
        fps: float = 25.0,
        duration: float = 2.0,
        t: float | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def report(
        self,
        path: str | PathLike[str],
        model: Model,
        q: ArrayLike,
        *,
        title: str = "Natural modes",
        t: float | None = None,
        u: _Inputs | None = None,
        visuals: Sequence[Visual] = (),
    ) -> None: ...
    def save(self, path: str | PathLike[str], model: Model | None = None) -> None: ...
    def to_xarray(self, model: Model | None = None) -> xarray.Dataset: ...

def modes(
    model: Model,
    q: ArrayLike | None = None,
    *,
    t: float = 0.0,
    u: _Inputs | None = None,
    frequencies: int | None = None,
) -> ModesResult: ...
