from collections.abc import Callable, Iterable
from typing import Any, Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import disjoint_base

__version__: str
build_profile: str

class LissomError(Exception): ...

class ConvergenceError(LissomError):
    result: RootResult

@disjoint_base
class Model:
    @property
    def n(self) -> int: ...
    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> NDArray[np.float64]: ...
    def mass_matrix(self, q: ArrayLike) -> NDArray[np.float64]: ...
    def forward_dynamics(self, q: ArrayLike, qd: ArrayLike) -> NDArray[np.float64]: ...
    def tangent(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def energy(self, q: ArrayLike, qd: ArrayLike) -> Energy: ...

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
class SpringPendulum(Model):
    def __new__(
        cls, length: float = 1.0, mass: float = 1.0, stiffness: float = 10.0, gravity: float = 9.81
    ) -> SpringPendulum: ...
    @property
    def length(self) -> float: ...
    @property
    def mass(self) -> float: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def gravity(self) -> float: ...
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
def check_jacobian(
    fun: Callable[..., Any],
    jac: Callable[..., Any],
    x: ArrayLike,
    *,
    x_scale: ArrayLike | None = None,
    args: tuple[Any, ...] = (),
) -> JacobianCheck: ...

@final
class Segment:
    def __new__(
        cls,
        length: float,
        radius: float | tuple[float, float],
        young_modulus: float,
        shear_modulus: float,
        density: float,
        modes: dict[str, int],
        retardation_time: float = 0.0,
        reference_strain: ArrayLike = (0, 0, 0, 1, 0, 0),
        shear_correction: float = 1.0,
    ) -> Segment: ...
    @property
    def length(self) -> float: ...
    @property
    def radius(self) -> tuple[float, float]: ...
    @property
    def young_modulus(self) -> float: ...
    @property
    def shear_modulus(self) -> float: ...
    @property
    def density(self) -> float: ...
    @property
    def modes(self) -> dict[str, int]: ...
    @property
    def retardation_time(self) -> float: ...
    @property
    def reference_strain(self) -> tuple[float, float, float, float, float, float]: ...
    @property
    def shear_correction(self) -> float: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs__(self) -> tuple[Any, ...]: ...

@final
class Rod(Model):
    def __new__(
        cls,
        segments: Iterable[Segment],
        base_position: ArrayLike = (0, 0, 0),
        base_orientation: ArrayLike = (1, 0, 0, 0),
        gravity: ArrayLike = (0, 0, -9.81),
        tip_force: ArrayLike = (0, 0, 0),
        tip_moment: ArrayLike = (0, 0, 0),
        tip_mass: float = 0.0,
    ) -> Rod: ...
    @property
    def segments(self) -> tuple[Segment, ...]: ...
    @property
    def length(self) -> float: ...
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
    def nodes(self) -> tuple[int, ...]: ...
    def pose(self, q: ArrayLike, X: ArrayLike) -> NDArray[np.float64]: ...
    def __getnewargs__(self) -> tuple[Any, ...]: ...
