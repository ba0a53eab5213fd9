from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, ClassVar, Literal, Self, TypeAlias, final

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
    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, t: float = 0.0
    ) -> NDArray[np.float64]: ...
    def mass_matrix(self, q: ArrayLike) -> NDArray[np.float64]: ...
    def forward_dynamics(self, q: ArrayLike, qd: ArrayLike, *, t: float = 0.0) -> NDArray[np.float64]: ...
    def tangent(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, t: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def energy(self, q: ArrayLike, qd: ArrayLike, *, t: float = 0.0) -> Energy: ...
    def dissipated_power(self, q: ArrayLike, qd: ArrayLike) -> float: ...
    def supplied_power(self, q: ArrayLike, qd: ArrayLike, *, t: float = 0.0) -> float: ...

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
    ) -> Literal["finished", "event", "too_many_steps", "step_too_small", "non_finite", "interrupted"]: ...
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
    method: Literal["RK45", "DOP853", "Radau"] | type[OdeSolver] = "RK45",
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
        reference_strain: ArrayLike | tuple[ArrayLike, ArrayLike] | Callable[[float], ArrayLike] | Profile = (
            0,
            0,
            0,
            1,
            0,
            0,
        ),
        shear_correction: float = 1.0,
        nodes: int | None = None,
        *,
        basis: Literal["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"] = "legendre",
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
    def reference_strain(self) -> tuple[float, float, float, float, float, float] | Profile: ...
    @property
    def shear_correction(self) -> float: ...
    @property
    def nodes(self) -> int | None: ...
    @property
    def basis(
        self,
    ) -> Literal["legendre", "chebyshev", "monomial", "piecewise_constant", "hermite"]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

#: Three numbers, or what varies in time: (times, values), a Harmonic, or a function of time.
_Vector: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike] | Harmonic | Callable[[float], ArrayLike]

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

@final
class Load:
    def __new__(
        cls,
        *,
        force: _Vector = (0, 0, 0),
        moment: _Vector = (0, 0, 0),
        at: float | None = None,
        along: ArrayLike | None = None,
        frame: Literal["world", "body"] = "world",
    ) -> Load: ...
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
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Body:
    def __new__(
        cls,
        mass: float,
        *,
        at: float | None = None,
        centre: ArrayLike = (0, 0, 0),
        inertia: ArrayLike = (0, 0, 0),
    ) -> Body: ...
    @property
    def mass(self) -> float: ...
    @property
    def at(self) -> float | None: ...
    @property
    def centre(self) -> tuple[float, float, float]: ...
    @property
    def inertia(self) -> NDArray[np.float64]: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __getnewargs_ex__(self) -> tuple[tuple[float], dict[str, Any]]: ...

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
        *,
        loads: Iterable[Load] = (),
        bodies: Iterable[Body] = (),
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
    def loads(self) -> tuple[Load, ...]: ...
    @property
    def bodies(self) -> tuple[Body, ...]: ...
    @property
    def nodes(self) -> tuple[int, ...]: ...
    @property
    def kernel(self) -> Literal["planar", "spatial"]: ...
    @property
    def multiplications(self) -> dict[str, int]: ...
    def explain(self) -> str: ...
    def pose(self, q: ArrayLike, X: ArrayLike) -> NDArray[np.float64]: ...
    def jacobian(self, q: ArrayLike, X: float) -> NDArray[np.float64]: ...
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
    @property
    def duration(self) -> float: ...
    @property
    def method(self) -> Literal["newmark", "hht", "generalised_alpha", "rk45", "dop853", "radau", "auto"]: ...
    @property
    def step(self) -> float: ...
    @property
    def jacobian(self) -> Literal["analytic", "forward", "central"]: ...
    @property
    def rtol(self) -> float: ...
    @property
    def atol(self) -> float: ...
    @property
    def output_step(self) -> float | None: ...
    @property
    def quantities(self) -> tuple[str, ...]: ...

@final
class Scene:
    @staticmethod
    def load(path: str | PathLike[str]) -> Scene: ...
    @staticmethod
    def loads(text: str, name: str = "scene") -> Scene: ...
    @staticmethod
    def schema() -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def model(self) -> Rod | SpringPendulum: ...
    @property
    def q0(self) -> NDArray[np.float64]: ...
    @property
    def v0(self) -> NDArray[np.float64]: ...
    @property
    def simulation(self) -> SimulationSettings: ...
    def run(self, **options: Any) -> MotionResult: ...

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
    def stats(self) -> Statistics: ...
    @property
    def balance(self) -> Balance | None: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(self) -> str: ...
    @property
    def message(self) -> str: ...

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
    atol: ArrayLike = 1e-09,
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
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    method: _NewmarkMethod | Literal["rk45", "dop853", "radau", "auto"] = "newmark",
    dt: float = 0.01,
    jac: Literal["analytic", "forward", "central"] = "analytic",
    rtol: ArrayLike = 1e-06,
    atol: ArrayLike = 1e-09,
    t_eval: ArrayLike | None = None,
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
) -> MotionResult: ...

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
    def q(self) -> NDArray[np.float64]: ...
    @property
    def directions(self) -> NDArray[np.float64]: ...

@final
class EquilibriumPath:
    @property
    def load_factor(self) -> NDArray[np.float64]: ...
    @property
    def q(self) -> NDArray[np.float64]: ...
    @property
    def lowest_eigenvalue(self) -> NDArray[np.float64]: ...
    @property
    def stability(self) -> list[_Stability | None]: ...
    @property
    def critical_points(self) -> list[CriticalPoint]: ...

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
    def lowest_eigenvalue(self) -> float: ...
    @property
    def path(self) -> EquilibriumPath | None: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...

@final
class ContinuationResult:
    @property
    def path(self) -> EquilibriumPath: ...
    @property
    def success(self) -> bool: ...
    @property
    def status(self) -> Literal["finished", "no_start", "step_too_small", "too_many_steps"]: ...
    @property
    def message(self) -> str: ...
    @property
    def nit(self) -> int: ...
    @property
    def nfev(self) -> int: ...
    @property
    def njev(self) -> int: ...

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
) -> StaticsResult: ...
def continuation(
    model: Model,
    q0: ArrayLike | None = None,
    *,
    load_factor: float = 0.0,
    direction: ArrayLike | None = None,
    bounds: tuple[float, float] = (0.0, 1.0),
    max_step: float = 0.25,
    max_steps: int = 500,
    t: float = 0.0,
    tol: float = 1e-10,
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
    def residual_norm(self) -> float: ...

def modes(model: Model, q: ArrayLike, *, t: float = 0.0) -> ModesResult: ...
