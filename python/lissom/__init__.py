"""lissom: soft rods that move."""

from ._lissom import (
    Energy,
    LissomError,
    Model,
    SpringPendulum,
    __version__,
)

__all__ = [
    "Energy",
    "LissomError",
    "Model",
    "SpringPendulum",
    "__version__",
]
