"""Methods of simulations with their options."""

from typing import Literal

from numpy.typing import ArrayLike

from .._lissom import Part

__all__ = ["DOP853", "RK45", "Auto", "Newmark", "QuasiStatic", "Radau"]

# Classes that are made from the tables of `description`; `test_description.py` compares them.
class Newmark(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rho_inf: float | None = None,
        alpha: float | None = None,
        beta: float | None = None,
        gamma: float | None = None,
        rtol: ArrayLike = 1e-6,
        atol: ArrayLike | None = None,
        adaptive: bool = False,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
        jac: Literal["analytic", "forward", "central"] = "analytic",
        predictor: Literal["best", "last", "zero"] = "best",
        reuse_jacobian: bool = True,
        impacts: Literal["auto", "stopped", "resolved"] = "auto",
    ) -> None: ...
    @property
    def rho_inf(self) -> float | None: ...
    @property
    def alpha(self) -> float | None: ...
    @property
    def beta(self) -> float | None: ...
    @property
    def gamma(self) -> float | None: ...
    @property
    def rtol(self) -> float | tuple[float, ...]: ...
    @property
    def atol(self) -> float | tuple[float, ...] | None: ...
    @property
    def adaptive(self) -> bool: ...
    @property
    def max_step(self) -> float | None: ...
    @property
    def min_step(self) -> float: ...
    @property
    def max_steps(self) -> int | None: ...
    @property
    def jac(self) -> Literal["analytic", "forward", "central"]: ...
    @property
    def predictor(self) -> Literal["best", "last", "zero"]: ...
    @property
    def reuse_jacobian(self) -> bool: ...
    @property
    def impacts(self) -> Literal["auto", "stopped", "resolved"]: ...

class Radau(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rtol: ArrayLike = 1e-6,
        atol: ArrayLike = 1e-9,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
    ) -> None: ...
    @property
    def rtol(self) -> float | tuple[float, ...]: ...
    @property
    def atol(self) -> float | tuple[float, ...]: ...
    @property
    def max_step(self) -> float | None: ...
    @property
    def min_step(self) -> float: ...
    @property
    def max_steps(self) -> int | None: ...

class RK45(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rtol: ArrayLike = 1e-6,
        atol: ArrayLike = 1e-9,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
    ) -> None: ...
    @property
    def rtol(self) -> float | tuple[float, ...]: ...
    @property
    def atol(self) -> float | tuple[float, ...]: ...
    @property
    def max_step(self) -> float | None: ...
    @property
    def min_step(self) -> float: ...
    @property
    def max_steps(self) -> int | None: ...

class DOP853(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rtol: ArrayLike = 1e-6,
        atol: ArrayLike = 1e-9,
        max_step: float | None = None,
        min_step: float = 0.0,
        max_steps: int | None = None,
    ) -> None: ...
    @property
    def rtol(self) -> float | tuple[float, ...]: ...
    @property
    def atol(self) -> float | tuple[float, ...]: ...
    @property
    def max_step(self) -> float | None: ...
    @property
    def min_step(self) -> float: ...
    @property
    def max_steps(self) -> int | None: ...

class QuasiStatic(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rtol: ArrayLike = 1e-6,
        atol: ArrayLike | None = None,
        max_steps: int | None = None,
    ) -> None: ...
    @property
    def rtol(self) -> float | tuple[float, ...]: ...
    @property
    def atol(self) -> float | tuple[float, ...] | None: ...
    @property
    def max_steps(self) -> int | None: ...

class Auto(Part):
    __match_args__ = ()
    def __init__(
        self,
        *,
        rtol: float = 0.0001,
        max_step: float | None = None,
        max_steps: int | None = None,
        space_error: bool = True,
    ) -> None: ...
    @property
    def rtol(self) -> float: ...
    @property
    def max_step(self) -> float | None: ...
    @property
    def max_steps(self) -> int | None: ...
    @property
    def space_error(self) -> bool: ...

# End of these classes.

def __dir__() -> list[str]: ...
