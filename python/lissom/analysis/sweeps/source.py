"""Sources of sweeps: scenes, models, and functions that return them."""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..._lissom import Model, Scene
from ...model import paths
from ...model.scenes import changed
from ...model.views import is_rod

Parameters = Mapping[str, Any]


@dataclass(frozen=True)
class Case:
    """A run with its parameters: the model, and the arguments of `simulate`."""

    model: Model
    options: dict[str, Any]


@dataclass(frozen=True)
class Source(ABC):
    """The object of a sweep. ``options`` override those of scenes."""

    options: dict[str, Any]

    @abstractmethod
    def case(self, parameters: Parameters) -> Case:
        """The run with these parameters; raises ValueError or TypeError if they are invalid."""

    def check_names(self, names: list[str]) -> None:
        """Raise ValueError for an unknown parameter name, as far as this can be checked without a value."""
        for name in names:
            paths.parts(name)

    @abstractmethod
    def identity(self) -> Any:
        """Data that distinguish it from other sources, as JSON types."""

    def _of(self, thing: object) -> Case:
        if isinstance(thing, Scene):
            return Case(thing.model, thing.options | self.options)
        if isinstance(thing, Model):
            return Case(thing, self.options)
        raise TypeError(f"model: got {type(thing).__name__}, expected a Model or a Scene")


@dataclass(frozen=True)
class OfScene(Source):
    """A scene, whose parameters are its keys."""

    text: str
    name: str
    imports: dict[str, bytes] = field(default_factory=dict)

    def case(self, parameters: Parameters) -> Case:
        return self._of(changed(self.text, parameters, self.name, self.imports))

    def identity(self) -> Any:
        imports = {name: content.decode(errors="surrogateescape") for name, content in self.imports.items()}
        return {"scene": self.text, "imports": imports}


@dataclass(frozen=True)
class OfModel(Source):
    """A model made in Python, whose parameters are named as in scenes or in the classes of its parts."""

    model: Model

    def case(self, parameters: Parameters) -> Case:
        model = self.model
        for path, value in parameters.items():
            within = paths.of_model(paths.parts(path), is_rod(model))
            model = paths.replaced(model, within, value)
        return self._of(model)

    def identity(self) -> Any:
        return {"model": paths.plain(self.model)}


@dataclass(frozen=True)
class OfFunction(Source):
    """A function that creates a model or a scene; its parameters are the arguments."""

    build: Callable[..., object]

    def case(self, parameters: Parameters) -> Case:
        return self._of(self.build(**parameters))

    def check_names(self, names: list[str]) -> None:
        known = inspect.signature(self.build).parameters
        if any(parameter.kind is parameter.VAR_KEYWORD for parameter in known.values()):
            return
        for name in names:
            if name not in known:
                raise ValueError(f"parameters: got {name!r}, {paths.meant(name, known)}")

    def identity(self) -> Any:
        return {"function": paths.plain(self.build)}


def source_of(thing: object, options: dict[str, Any]) -> Source:
    """The source for the first argument of `sweep`."""
    if isinstance(thing, Scene):
        return OfScene(options, thing.text, thing.name, dict(thing.imports))
    if isinstance(thing, Model):
        return OfModel(options, thing)
    if callable(thing):
        return OfFunction(options, thing)
    raise TypeError(
        f"model: got {type(thing).__name__}, expected a Scene, a Model, or a function that makes one of them"
    )
