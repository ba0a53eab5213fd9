"""Models as functions of the parameters that are fitted."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from .._lissom import Robot
from ..model import paths
from .parameters import START, OfArgument, check_shared, model_with, resolved


@dataclass(frozen=True)
class NumbersOfModel:
    """A model whose numbers are fitted."""

    model: Any

    def __call__(self, values: Mapping[str, float]) -> Robot:
        """The model with these values, apart from initial states."""
        changed: Robot = model_with(self.model, without_starts(values))
        return changed

    def first(self, values: Mapping[str, float]) -> Robot:
        """A model whose coordinates and places are those of all."""
        return self._checked()

    def check(self, name: str) -> None:
        """Raise ValueError unless there is a number with this name."""
        check_shared(self._checked(), name)

    def wanted(self, model: Robot, values: Mapping[str, float]) -> list[Any]:
        """The parameters of the derivatives, for the model with these values."""
        numbers = without_starts(values)
        found = dict(zip(numbers, resolved(model, list(numbers)), strict=True)) if numbers else {}
        return [found.get(name, name) for name in values]

    def _checked(self) -> Robot:
        return robot(self.model, "model: expected a Rod or a Robot, or a function that makes one, got")


@dataclass(frozen=True)
class ArgumentsOfFunction:
    """A function that makes a model, whose arguments are fitted."""

    build: Callable[..., Any]

    def __call__(self, values: Mapping[str, float]) -> Robot:
        """The model with these values, apart from initial states."""
        return robot(
            self.build(**without_starts(values)),
            "model: expected a function that makes a Rod or a Robot, got",
        )

    def first(self, values: Mapping[str, float]) -> Robot:
        """A model whose coordinates and places are those of all."""
        return self(values)

    def check(self, name: str) -> None:
        """Raise ValueError unless the function has this argument."""
        known = inspect.signature(self.build).parameters
        if name not in known and not any(each.kind is each.VAR_KEYWORD for each in known.values()):
            raise ValueError(f"parameters: got {name!r}, {paths.meant(name, known)}")

    def wanted(self, model: Robot, values: Mapping[str, float]) -> list[Any]:
        """The parameters of the derivatives, for the model with these values."""

        def of(name: str) -> str | OfArgument:
            if START.fullmatch(name):
                return name
            make = partial(self._with, values, name)
            return OfArgument(name, values[name], None, model, make=make)

        return [of(name) for name in values]

    def _with(self, values: Mapping[str, float], name: str, value: float) -> Robot:
        return self({**values, name: value})


def robot(model: Any, expected: str) -> Robot:
    if not isinstance(model, Robot):
        raise TypeError(f"{expected} {type(model).__name__}, which has no places")
    return model


def without_starts(values: Mapping[str, float]) -> dict[str, float]:
    """The parameters that are no initial states."""
    return {name: value for name, value in values.items() if not START.fullmatch(name)}
