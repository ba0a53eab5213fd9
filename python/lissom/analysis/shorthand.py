"""Methods as objects in the words of their shorthands: a name, and options beside it."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from .. import methods

#: The name of a method for each class but that of the Newmark family, which has several.
NAMES = {"QuasiStatic": "quasi_static"}


def shorthand(method: Any, options: dict[str, Any]) -> tuple[Any, dict[str, Any]]:
    """The name of a method and the options beside it that stand for one of `lissom.methods`.

    Anything else is returned as it is with these options, among which an object takes none of its own.
    """
    name = type(method).__name__
    if type(method).__module__ != methods.__name__:
        return method, options
    given = {}
    for field in fields(method):
        if field.name in options:
            raise ValueError(
                f"{field.name}: `method` is one of lissom.methods and has all of its options: leave "
                f"`{field.name}` out"
            )
        value = getattr(method, field.name)
        # Runs of the Newmark family are differentiated only where nothing meets.
        if value != field.default and field.name != "impacts":
            given[field.name] = value
    if name != "Newmark":
        return NAMES.get(name, name.lower()), given | options
    by_parameter = {"rho_inf": "generalised_alpha", "alpha": "hht"}
    name = next((by_parameter[key] for key in by_parameter if key in given), "newmark")
    return name, given | options
