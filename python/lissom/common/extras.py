"""Packages that not every installation has."""

from __future__ import annotations

import importlib.util


def missing(*modules: str) -> list[str]:
    """The modules that cannot be imported."""
    return [module for module in modules if not _is_there(module)]


def _is_there(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except ValueError:
        # Python has an entry for it that is no module, as where an import is blocked.
        return False
