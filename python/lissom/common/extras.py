"""Packages that not every installation has."""

from __future__ import annotations

import importlib.util


def missing(*modules: str) -> list[str]:
    """The modules that cannot be imported."""
    return [module for module in modules if importlib.util.find_spec(module) is None]
