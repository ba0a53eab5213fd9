"""lissom: soft rods that move."""

from ._lissom import (
    ConvergenceError,
    Energy,
    JacobianCheck,
    LissomError,
    Model,
    RootResult,
    SpringPendulum,
    __version__,
    check_jacobian,
    jacobian,
    root,
)

__all__ = [
    "ConvergenceError",
    "Energy",
    "JacobianCheck",
    "LissomError",
    "Model",
    "RootResult",
    "SpringPendulum",
    "__version__",
    "check_jacobian",
    "jacobian",
    "root",
]
