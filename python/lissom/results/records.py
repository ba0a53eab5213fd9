"""Records: results and models as data, a tree in JSON and the bytes of its arrays.

Reading a record runs no code of the file. Every node of the tree is one value: a number, text, a container,
an array, or an object of one of the classes in `PARTS`, which its own constructor creates and checks; fields
of results are compared with their annotations. Nodes do not share values, and arrays follow each other in the
order of the tree, so that reading takes time and memory in proportion to the file. Only models (`Robot`,
`Rod`, `SpringPendulum`), of which no part is another model, may be named again.
"""

from __future__ import annotations

import copyreg
import json
import math
import re
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Model, Part, Section
from ..analysis.fitted import split_data
from . import layouts

#: The classes that results and models consist of, by module, besides those of parts.
PARTS = {
    "_lissom": (
        *("MotionResult", "StaticsResult", "ContinuationResult", "ModesResult", "EnsembleResult"),
        *("ActuateResult", "ReachResult", "Balance", "CriticalPoint", "EquilibriumPath", "Statistics"),
        *("Overlap", "HardSteps", "SpaceError", "Harmonic", "Input", "Profile", "Robot", "Rod", "Section"),
        "SpringPendulum",
    ),
    "analysis.fitted": ("FitResult", "FittedData"),
    "analysis.sensitivities": ("SensitivityResult",),
    "analysis.equilibria": ("EquilibriumSensitivityResult",),
    "analysis.parameters": ("OfInput", "OfModel", "OfStart"),
    "analysis.materials": ("OfMaterial", "OfSection"),
}


def _made(base: type[Part]) -> list[type[Part]]:
    """The classes of parts below one that have no further ones; methods of simulations are no parts."""
    below = [kind for kind in base.__subclasses__() if kind.__module__ in ("lissom", Part.__module__)]
    return [leaf for kind in below for leaf in _made(kind)] if below else [base]


#: The classes by name; records of older versions name those of sections as functions of `Section`.
CLASSES: dict[str, type] = {kind.__qualname__: kind for kind in _made(Part)} | {
    name: getattr(import_module(f"lissom.{module}"), name)
    for module, names in PARTS.items()
    for name in names
}
_NAMES = {known: name for name, known in CLASSES.items()}

#: Modules whose dataclasses compare their fields with the annotations here; the others check them themselves.
CHECKED = tuple(module for module in PARTS if module.startswith("analysis."))

#: Constructor of results and other compiled objects from what `__reduce__` returns.
RESTORE = "_restore"

#: Allowed kinds of array elements: booleans, integers, floats, complex numbers, text.
KINDS = "biufcSU"

#: How NumPy writes them, with their sizes.
_DTYPE = re.compile(rf"[<>|][{KINDS}][0-9]{{1,9}}")

#: Largest number of dimensions of an array of NumPy.
DIMENSIONS = 64

#: Bytes for the length of the tree.
LENGTH = 8


class NotKept(ValueError):
    """Something that a record cannot hold."""


class Damaged(ValueError):
    """A record that does not describe a result."""


def write(thing: Any) -> bytes:
    """The record of a result; raises NotKept if it contains anything that records do not have."""
    writer = _Writer()
    tree = json.dumps(writer.node(thing), ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode()
    return b"".join([len(tree).to_bytes(LENGTH, "little"), tree, *writer.arrays])


def read(content: bytes) -> Any:
    """Read a record; raises Damaged, or the error of a constructor, if it is invalid."""
    end = LENGTH + int.from_bytes(content[:LENGTH], "little")
    if end > len(content):
        raise Damaged("it is cut off")
    try:
        tree = json.loads(content[LENGTH:end].decode("ascii"), parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Damaged(f"its tree is no JSON: {error}") from None
    reader = _Reader(memoryview(content)[end:])
    found = reader.value(tree)
    if len(reader.left):
        raise Damaged(f"{len(reader.left)} bytes belong to no array")
    return found


def _no_constant(word: str) -> Any:
    raise ValueError(word)


class _Writer:
    """From values to nodes. What JSON cannot express is an object with one key, which names the kind."""

    def __init__(self) -> None:
        self.arrays: list[bytes] = []
        self._models: dict[int, int] = {}

    def node(self, thing: Any) -> Any:
        match thing:
            case np.ndarray() | np.generic():
                return self._array(thing)
            case None | bool() | str():
                return thing
            case int():
                return int(thing)
            case float():
                return float(thing) if math.isfinite(thing) else {"float": repr(float(thing))}
            case complex():
                return {"complex": [self.node(thing.real), self.node(thing.imag)]}
            case bytes():
                return {"bytes": self.node(np.frombuffer(thing, np.uint8))}
            case tuple():
                return {"tuple": self._list(thing)}
            case list():
                return self._list(thing)
            case dict():
                if not all(isinstance(key, str) for key in thing):
                    raise NotKept("keys that are no text")
                return {"dict": [self._list(item) for item in thing.items()]}
            case SimpleNamespace():
                return {"namespace": {name: self.node(value) for name, value in vars(thing).items()}}
        return self._object(thing)

    def _list(self, things: Sequence[Any]) -> list[Any]:
        return [self.node(thing) for thing in things]

    def _array(self, array: NDArray[Any] | np.generic) -> Any:
        if array.dtype.kind not in KINDS:
            raise NotKept(f"an array of {array.dtype}")
        self.arrays.append(array.tobytes())
        kind = "scalar" if isinstance(array, np.generic) else "array"
        return {kind: [array.dtype.str, list(array.shape)]}

    def _object(self, thing: Any) -> Any:
        owner = type(thing)
        if owner not in _NAMES:
            raise NotKept(f"a {owner.__name__}")
        name = _NAMES[owner]
        if isinstance(thing, Model):
            # Kept alive by the result that contains it, so that the address is its own.
            if id(thing) in self._models:
                return {"model": self._models[id(thing)]}
            node = self._made(name, thing)
            self._models[id(thing)] = len(self._models)
            return node
        if _is_written_by_fields(owner):
            # Of a part those that do not follow from others.
            values = {field.name: self.node(getattr(thing, field.name)) for field in fields(thing)}
            return {"fields": [name, values]}
        return self._made(name, thing)

    def _made(self, name: str, thing: Any) -> Any:
        maker, arguments, *state = thing.__reduce_ex__(4)
        if any(part is not None for part in state):
            raise NotKept(f"attributes of a {name}")
        options: Mapping[str, Any] = {}
        if maker is copyreg.__newobj__:  # type: ignore[attr-defined]
            (_, *arguments), function = arguments, None
        elif maker is copyreg.__newobj_ex__:  # type: ignore[attr-defined]
            (_, arguments, options), function = arguments, None
        else:
            function = maker.__name__
        named = {option: self.node(value) for option, value in options.items()}
        return {"made": [name, function, self._list(arguments), named]}


class _Reader:
    """From nodes to values."""

    def __init__(self, left: memoryview) -> None:
        #: Bytes of the arrays that follow.
        self.left = left
        self._models: list[Model] = []

    def value(self, node: Any) -> Any:
        if isinstance(node, list):
            return [self.value(inner) for inner in node]
        if not isinstance(node, dict):
            return node
        if len(node) != 1:
            raise Damaged("a node of no kind")
        ((kind, content),) = node.items()
        known = _KINDS_OF_NODES.get(kind)
        if known is None:
            raise Damaged(f"a node of the kind {kind!r:.40}")
        try:
            return known(self, content)
        except (KeyError, IndexError, AttributeError, OverflowError) as error:
            raise Damaged(f"a node of the kind {kind!r} with {error}") from None

    def _float(self, content: Any) -> float:
        return {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}[content]

    def _complex(self, content: Any) -> complex:
        real, imaginary = self.value(content)
        return complex(real, imaginary)

    def _bytes(self, content: Any) -> bytes:
        found: bytes = self.value(content).tobytes()
        return found

    def _tuple(self, content: Any) -> tuple[Any, ...]:
        return tuple(self.value(inner) for inner in content)

    def _dict(self, content: Any) -> dict[str, Any]:
        # Numbers can be chosen so that all of them collide in a dict; text cannot.
        if not all(isinstance(key, str) for key, _ in content):
            raise Damaged("a key that is no text")
        return {key: self.value(value) for key, value in content}

    def _namespace(self, content: Any) -> SimpleNamespace:
        return SimpleNamespace(**{name: self.value(value) for name, value in content.items()})

    def _array(self, content: Any) -> NDArray[Any]:
        kind, shape = content
        if not isinstance(kind, str) or not _DTYPE.fullmatch(kind):
            raise Damaged(f"an array of {kind!r:.40}")
        dtype = np.dtype(kind)
        if len(shape) > DIMENSIONS or not all(type(size) is int and 0 <= size < 2**63 for size in shape):
            raise Damaged(f"an array of {len(shape)} sizes that none has")
        size = math.prod(shape) * dtype.itemsize
        if dtype.itemsize == 0 or size > len(self.left):
            raise Damaged(f"an array of shape {shape!r:.80} in {len(self.left)} bytes")
        content, self.left = self.left[:size], self.left[size:]
        # Copied, because the arrays of a model must be writable.
        array: NDArray[Any] = np.frombuffer(content, dtype).copy() if size else np.empty(0, dtype)
        return array.reshape(shape)

    def _scalar(self, content: Any) -> Any:
        array = self._array(content)
        if array.shape != ():
            raise Damaged(f"a number of shape {array.shape}")
        return array[()]

    def _fields(self, content: Any) -> Any:
        name, values = content
        owner = CLASSES[name]
        if not _is_written_by_fields(owner):
            raise Damaged(f"{name} has no fields")
        found = {field: self.value(value) for field, value in values.items()}
        if name == "FitResult" and "data" not in found:
            # Of a version in which a fit had one recording.
            older, found = split_data(found)
            found["data"] = (_of_fields("FittedData", older),)
        return _of_fields(name, found)

    def _made(self, content: Any) -> Any:
        name, function, arguments, options = content
        owner = CLASSES[name]
        # The constructor of a part checks the contents of a record.
        is_written_by_fields = _is_written_by_fields(owner) and not (
            issubclass(owner, Part) and function is None
        )
        is_maker = function is None or function == RESTORE or _is_shape(owner, function)
        if is_written_by_fields or not is_maker:
            raise Damaged(f"{name}.{function!r:.40}")
        make: Callable[..., Any] = owner if function is None else getattr(owner, function)
        found = make(
            *(self.value(argument) for argument in arguments),
            **{option: self.value(value) for option, value in options.items()},
        )
        if isinstance(found, Model):
            self._models.append(found)
        return _laid_out(name, found)

    def _model(self, content: Any) -> Model:
        if type(content) is not int or content < 0:
            raise Damaged(f"the model {content!r:.40}")
        return self._models[content]


_KINDS_OF_NODES: dict[str, Callable[[_Reader, Any], Any]] = {
    name: getattr(_Reader, f"_{name}")
    for name in (
        *("float", "complex", "bytes", "tuple", "dict", "namespace", "array", "scalar"),
        *("fields", "made", "model"),
    )
}


def _of_fields(name: str, found: dict[str, Any]) -> Any:
    """An object of this class; raises Damaged if it has other fields, or of other kinds."""
    owner = CLASSES[name]
    names = {field.name for field in fields(owner)}
    if not (found.keys() <= names if issubclass(owner, Part) else found.keys() == names):
        raise Damaged(f"other fields than those of {name}")
    for field, kind in _annotations(name).items():
        if not fits(found[field], kind):
            raise Damaged(f"{name}.{field} is a {type(found[field]).__name__}")
    return _laid_out(name, owner(**found))


def _laid_out(name: str, thing: Any) -> Any:
    mismatch = layouts.mismatch(name, thing)
    if mismatch:
        raise Damaged(f"{name}.{mismatch} has not the type or the length that it should have")
    return thing


def _is_written_by_fields(owner: type) -> bool:
    """Models are written by the arguments of their classes, each of them once."""
    return is_dataclass(owner) and not issubclass(owner, Model)


def _is_shape(owner: type, function: Any) -> bool:
    return owner is Section and f"Section.{function}" in CLASSES


@cache
def _annotations(name: str) -> dict[str, Any]:
    """Annotations of the fields to compare, of the dataclass with this name."""
    module = next((module for module, names in PARTS.items() if name in names), "")
    if module not in CHECKED:
        return {}
    # Classes may name another module as theirs, where they have their methods.
    kinds = typing.get_type_hints(CLASSES[name], vars(import_module(f"lissom.{module}")))
    return {field.name: kinds[field.name] for field in fields(CLASSES[name])}


def fits(value: Any, kind: Any) -> bool:
    """Whether a value has the type of an annotation; sequences are lists or tuples."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any:
        return True
    if origin in (typing.Union, types.UnionType):
        return any(fits(value, one) for one in arguments)
    if origin is typing.Literal:
        return value in arguments
    if origin is np.ndarray:
        wanted = typing.get_args(arguments[1])[0]
        return isinstance(value, np.ndarray) and (wanted is Any or np.issubdtype(value.dtype, wanted))
    if origin is tuple and not (len(arguments) == 2 and arguments[1] is Ellipsis):
        return isinstance(value, tuple) and len(value) == len(arguments) and all(map(fits, value, arguments))
    if origin in (tuple, list) or (isinstance(origin, type) and issubclass(origin, Sequence)):
        known = tuple if origin is tuple else list if origin is list else (list, tuple)
        return isinstance(value, known) and all(fits(inner, arguments[0]) for inner in value)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return isinstance(value, dict) and all(
            fits(key, arguments[0]) and fits(inner, arguments[1]) for key, inner in value.items()
        )
    if kind is float:
        return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if kind is int:
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    return isinstance(value, type(None) if kind is None else kind)
