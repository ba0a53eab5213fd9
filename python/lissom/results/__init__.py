"""Results: of scenes, as datasets, and as files that can be read again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .runs import Made as Made
    from .runs import Run as Run


def __getattr__(name: str) -> Any:
    # The command line uses the folders of results before NumPy is imported.
    if name in ("Made", "Run"):
        from . import runs

        return getattr(runs, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
