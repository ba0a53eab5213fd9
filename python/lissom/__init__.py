"""lissom: soft rods that move."""

from ._lissom import (
    ConvergenceError,
    Energy,
    JacobianCheck,
    LissomError,
    Model,
    Rod,
    RootResult,
    Segment,
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
    "Rod",
    "RootResult",
    "Segment",
    "SpringPendulum",
    "__version__",
    "check_jacobian",
    "jacobian",
    "root",
]
