"""lissom: soft rods that move."""

from ._lissom import __version__

__all__ = ["__version__"]
