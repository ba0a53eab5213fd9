"""Records: serialised results and models, from which only results and models can be created.

A record is a pickle with a restricted vocabulary. Pickles are programs: they call the functions that they
name, and modify objects. Here they may name only the members of `ALLOWED`, and use only the instructions in
`INSTRUCTIONS`, none of which sets attributes (`BUILD` could rewrite classes and forge arrays of objects).
Arrays are stored as types, shapes and bytes, because NumPy's own format accepts bytes as addresses of
objects.
"""

from __future__ import annotations

import io
import math
import pickle
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from importlib import import_module
from types import SimpleNamespace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ._lissom import Section

#: The classes and functions that results and models consist of, by module.
PARTS = {
    "_lissom": (
        *("MotionResult", "StaticsResult", "ContinuationResult", "ModesResult", "EnsembleResult"),
        *("Balance", "BaseMotion", "Body", "CriticalPoint", "EquilibriumPath", "Fluid", "Harmonic", "Input"),
        *("Load", "Profile", "Robot", "Rod", "Section", "Segment", "SpringPendulum", "Statistics", "Support"),
        *("ActuateResult", "ReachResult"),
    ),
    "links": (
        *("Cylindrical", "Free", "Link", "Mimic", "Planar", "Prismatic", "Revolute", "Spherical"),
        *("Universal", "Weld"),
    ),
    "actuators": ("ActiveStrain", "Along", "Chamber", "Motor", "Tendon", "Via"),
    "loops": ("Distance", "Gear", "Loop", "LoopEnd"),
    "contacts": ("Ball", "Box", "Capsule", "Contact", "ConvexMesh", "HalfSpace", "HeightField", "Sphere"),
    "fits": ("FitResult",),
    "sensitivities": ("SensitivityResult",),
    "equilibria": ("EquilibriumSensitivityResult",),
    "parameters": ("OfInput", "OfModel", "OfStart"),
    "materials": ("OfMaterial", "OfSection"),
}

#: Allowed kinds of array elements: booleans, integers, floats, complex numbers, text.
KINDS = "biufcSU"

#: Opcodes allowed in a record, a subset of those of `pickle`.
INSTRUCTIONS = (
    *(
        pickle.PROTO,
        pickle.FRAME,
        pickle.STOP,
        pickle.MARK,
        pickle.MEMOIZE,
        pickle.BINGET,
        pickle.LONG_BINGET,
    ),
    *(pickle.NONE, pickle.NEWTRUE, pickle.NEWFALSE, pickle.BININT, pickle.BININT1, pickle.BININT2),
    *(pickle.LONG1, pickle.BINFLOAT, pickle.SHORT_BINUNICODE, pickle.BINUNICODE, pickle.BINUNICODE8),
    *(pickle.SHORT_BINBYTES, pickle.BINBYTES, pickle.BINBYTES8),
    *(pickle.EMPTY_TUPLE, pickle.TUPLE1, pickle.TUPLE2, pickle.TUPLE3, pickle.TUPLE),
    *(pickle.EMPTY_LIST, pickle.APPEND, pickle.APPENDS, pickle.EMPTY_DICT, pickle.SETITEM, pickle.SETITEMS),
    *(pickle.STACK_GLOBAL, pickle.REDUCE, pickle.NEWOBJ, pickle.NEWOBJ_EX),
)


def write(thing: Any) -> bytes:
    """The record of a result.

    Raises pickle.PicklingError, AttributeError or TypeError if it contains anything not allowed in a record.
    """
    content = io.BytesIO()
    _Writer(content, protocol=5).dump(thing)
    return content.getvalue()


def read(content: bytes) -> Any:
    """Read a record; raises various errors if it is invalid."""
    return _Reader(io.BytesIO(content)).load()


class _Writer(pickle.Pickler):
    """Writes objects as constructor calls, where `pickle` would modify them after construction."""

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, np.ndarray | np.generic):
            if thing.dtype.kind not in KINDS:
                raise pickle.PicklingError(f"an array of {thing.dtype}")
            number = isinstance(thing, np.generic)
            return _array, (thing.dtype.str, thing.shape, thing.tobytes(), number)
        if type(thing) is SimpleNamespace:
            return _made, (SimpleNamespace, vars(thing))
        if is_dataclass(type(thing)):
            return _made, (type(thing), {field.name: getattr(thing, field.name) for field in fields(thing)})
        return NotImplemented


class _Reader(pickle._Unpickler):
    """Reads only the classes and functions that results consist of.

    Based on the Python implementation of the reader, because it has a table of its instructions.
    """

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) not in ALLOWED:
            raise pickle.UnpicklingError(f"{module}.{name}")
        return ALLOWED[module, name]


def _refused(reader: pickle._Unpickler) -> NoReturn:
    raise pickle.UnpicklingError("an instruction that records do not have")


def _new(depth: int, known: Callable[[Any], None]) -> Callable[[Any], None]:
    """`known`, restricted to compiled classes, whose ``__new__`` validates its arguments."""

    def make(reader: Any) -> None:
        owner = reader.stack[-depth]
        if not _is_part(owner) or is_dataclass(owner):
            raise pickle.UnpicklingError(f"{owner!r:.80} without its checks")
        known(reader)

    return make


_REFUSED: Callable[[Any], None] = _refused
_Reader.dispatch = {
    code: known if code in {word[0] for word in INSTRUCTIONS} else _REFUSED
    for code, known in pickle._Unpickler.dispatch.items()
}
for _word, _depth in ((pickle.NEWOBJ, 2), (pickle.NEWOBJ_EX, 3)):
    _Reader.dispatch[_word[0]] = _new(_depth, _Reader.dispatch[_word[0]])


def _array(kind: str, shape: tuple[int, ...], content: bytes, number: bool) -> NDArray[Any]:
    """An array from its bytes, or the single number in it if `number` is set."""
    dtype = np.dtype(str(kind))
    if dtype.kind not in KINDS or dtype.fields is not None or dtype.subdtype is not None:
        raise pickle.UnpicklingError(f"an array of {kind}")
    if dtype.itemsize == 0 or math.prod(shape) * dtype.itemsize != len(content):
        raise pickle.UnpicklingError(f"an array of shape {shape} in {len(content)} bytes")
    array = np.frombuffer(content, dtype).reshape(shape) if content else np.empty(shape, dtype)
    # Copy, because the arrays of a model must be writable.
    found: NDArray[Any] = array.copy()
    return found[()] if number else found


def _made(owner: type, attributes: dict[str, Any]) -> Any:
    """An object with these attributes, created and validated by its class."""
    if owner is not SimpleNamespace and not (_is_part(owner) and is_dataclass(owner)):
        raise pickle.UnpicklingError(f"{owner!r:.80} from attributes")
    return owner(**attributes)


def _maker(owner: Any, name: str) -> Callable[..., Any]:
    """Replaces `getattr` in records: gives access only to the constructors of compiled classes."""
    if not (_is_part(owner) and (name == "_restore" or (owner is Section and name in SHAPES))):
        raise pickle.UnpicklingError(f"attribute {name}")
    maker: Callable[..., Any] = getattr(owner, name)
    return maker


def _is_part(owner: Any) -> bool:
    return any(owner is known for known in ALLOWED.values())


#: The functions that create sections, by shape.
SHAPES = tuple(name for name in vars(Section) if isinstance(vars(Section)[name], staticmethod))

ALLOWED: dict[tuple[str, str], Any] = {
    ("types", "SimpleNamespace"): SimpleNamespace,
    ("builtins", "complex"): complex,
    ("builtins", "getattr"): _maker,
    (__name__, "_array"): _array,
    (__name__, "_made"): _made,
    **{
        (place, name): getattr(import_module(f"lissom.{module}"), name)
        for module, names in PARTS.items()
        for name in names
        for place in (f"lissom.{module}", "lissom")
    },
}
