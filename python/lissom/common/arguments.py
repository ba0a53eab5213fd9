"""Arguments of functions and fields, checked and converted: numbers to floats, names to text.

The extension and NumPy are loaded by the first conversion: commands that print help do not wait for them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

if TYPE_CHECKING:
    import inspect
    from collections.abc import Mapping
    from typing import TypeAlias

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    #: Inputs of a model, or some of them by name.
    Inputs: TypeAlias = ArrayLike | Mapping[str, ArrayLike]
    #: The same for each row of many.
    InputRows: TypeAlias = Inputs | Sequence[Mapping[str, ArrayLike]]


def number(name: str, value: object) -> float:
    """A number as a float. Booleans, text and times are rejected, although Python converts some of them."""
    from .._lissom import as_number

    return as_number(value, name)


def whole(name: str, value: object) -> int:
    """A whole number of 64 bits; booleans are none."""
    from .._lissom import as_whole

    return as_whole(value, name)


def flag(name: str, value: object) -> bool:
    """True or False."""
    from .._lissom import as_flag

    return as_flag(value, name)


def text(name: str, value: object) -> str:
    """A text."""
    from .._lissom import as_text

    return as_text(value, name)


def one_of(name: str, value: object, known: Sequence[str]) -> str:
    """One of these words."""
    word = text(name, value)
    if word not in known:
        *first, last = map(repr, known)
        raise ValueError(f"{name}: got {word!r}, expected {', '.join(first)} or {last}")
    return word


def keywords(function: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Raise TypeError for keyword arguments that do not exist, with those that may be meant."""
    names = list(known)
    others = [name for name in given if name not in names]
    if others:
        from .._lissom import unexpected_keywords

        raise TypeError(f"{function}() {unexpected_keywords(others, names)}")


def is_by_name(u: Any) -> bool:
    """Whether inputs of rows are given by names, at least in one of them."""
    return isinstance(u, dict) or (isinstance(u, list | tuple) and any(isinstance(row, dict) for row in u))


def _stand_ins(function: str, given: Iterable[str], missing: Iterable[str]) -> None:
    """Raise TypeError for a keyword argument that seems to stand for a missing argument."""
    from .._lissom import did_you_mean

    required = list(missing)
    for name in given:
        advice = did_you_mean(name, required)
        if advice:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}; {advice}")


#: The remark about positional arguments that a function does not take.
MORE = "*"


def _too_many(function: str, given: int, parameters: Sequence[inspect.Parameter], remark: str = "") -> None:
    """Raise TypeError for more positional arguments than a function takes, with the names of the others."""
    own = [e.name for e in parameters if e.kind in (e.POSITIONAL_ONLY, e.POSITIONAL_OR_KEYWORD)]
    first = [name for name in own if name != "self"]
    given -= len(own) - len(first)
    others = [each.name for each in parameters if each.kind is each.KEYWORD_ONLY]
    by_name = f": give the others by name, of {', '.join(others)}" if others else ""
    taken = f"{len(first)} positional arguments ({', '.join(first)})" if first else "no arguments"
    raise TypeError(
        f"{function}() takes {taken} but {given} were given{by_name or (remark and f': {remark}')}"
    )


def suggesting(called: F, remarks: Mapping[str, str] | None = None) -> F:
    """Let a function, or a class where it is called, refuse keyword arguments by `keywords`.

    A function that passes further arguments on checks these itself; of it, those are refused that stand for
    arguments it requires. Warnings of the function have one more frame to their caller. `remarks` say of
    arguments that are required what they are, where they are missing.
    """
    import functools
    import inspect

    function: Any = vars(called)["__init__"] if isinstance(called, type) else called
    shown = called.__qualname__
    parameters = inspect.signature(function).parameters.values()
    passes_on = any(each.kind is each.VAR_KEYWORD for each in parameters)
    takes_all = any(each.kind is each.VAR_POSITIONAL for each in parameters)
    most = sum(each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD) for each in parameters)
    named = [each for each in parameters if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
    known = [each.name for each in named if each.name != "self"]
    required = [each.name for each in named if each.default is each.empty]
    names = frozenset(known)
    explained = remarks or {}

    @functools.wraps(function)
    def checked(*args: Any, **kwargs: Any) -> Any:
        if not names.issuperset(kwargs):
            if passes_on:
                missing = [name for name in required[len(args) :] if name not in kwargs]
                _stand_ins(shown, [name for name in kwargs if name not in names], missing)
            else:
                keywords(shown, kwargs, known)
        for name in explained:
            if name in required[len(args) :] and name not in kwargs:
                raise TypeError(f"{shown}() missing required argument {name!r}: {explained[name]}")
        if len(args) > most and not takes_all:
            _too_many(shown, len(args), list(parameters), explained.get(MORE, ""))
        return function(*args, **kwargs)

    if isinstance(called, type):
        type.__setattr__(called, "__init__", checked)
        return called
    return checked  # type: ignore[return-value]


def explaining(**remarks: str) -> Callable[[F], F]:
    """`suggesting` with these remarks."""
    return lambda called: suggesting(called, remarks)


def takes(name: str, function: Callable[..., Any], arguments: str, what: str) -> None:
    """Raise TypeError for a function that cannot be called with these arguments, as far as that is known."""
    import inspect

    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return
    try:
        signature.bind(*arguments.split(", "))
    except TypeError:
        raise TypeError(
            f"{name}: is called as {name}({arguments}), with {what}, but takes {signature}: write "
            f"`def {name}({arguments}): ...`"
        ) from None


def sequence(name: str, value: Any, of: str) -> list[Any]:
    """The entries of a sequence; a text is none."""
    try:
        if not isinstance(value, str | bytes):
            return list(value)
    except TypeError:
        pass
    raise TypeError(f"{name}: expected a sequence of {of}, got {type(value).__name__}")


def path_of(value: Any, name: str = "path") -> Path:
    """A path of a file."""
    if isinstance(value, str | os.PathLike):
        found = os.fspath(value)
        if isinstance(found, str):
            return Path(found)
    raise TypeError(f"{name}: expected a str or a path, got {type(value).__name__}")


def vector(name: str, values: ArrayLike, count: int) -> NDArray[np.float64]:
    """An array of ``count`` finite numbers."""
    import numpy as np

    try:
        array = np.asarray(values)
    except ValueError:  # lists of different lengths
        array = np.empty((), object)
    if array.ndim != 1 or (array.dtype.kind not in "iuf" and len(array)):
        given = type(values).__name__
        raise TypeError(f"{name}: expected a one-dimensional array of real numbers, got {given}")
    if len(array) != count:
        raise ValueError(f"{name}: expected {count} values, got {len(array)}")
    numbers: NDArray[np.float64] = array.astype(float)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name}: expected finite numbers, got {numbers[~np.isfinite(numbers)][0]}")
    return numbers


def _set(thing: object, name: str, value: Any) -> None:
    object.__setattr__(thing, name, value)


def with_number(thing: object, *names: str) -> None:
    """Convert attributes to floats."""
    for name in names:
        _set(thing, name, number(name, getattr(thing, name)))
