"""Key paths such as ``rod[0].segment[0].radius``: parsing, reading and replacing."""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import json
import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from .._lissom import did_you_mean
from .._lissom import meant as like

Part = str | int

#: In place of an index: all entries of a list, which share a value.
EVERY = "*"

#: A name, bare or in quotes, or in brackets an index, a star or the name of an entry.
PART = re.compile(
    r'(?P<bare>[A-Za-z0-9_-]+)|"(?P<quoted>[^"]+)"|\[(?P<index>\d+|\*)\]|\[(?P<entry>[^\W\d][^\[\]"*]*)\]'
)


def parts(path: str) -> list[Part]:
    """Names and indices of a path.

    Raises ValueError for an invalid path.
    """
    found: list[Part] = []
    place = 0
    while place < len(path):
        if found and path[place] == "." and place + 1 < len(path):
            place += 1
            if path[place] == "[":
                raise _no_path(path)
        elif found and path[place] != "[":
            raise _no_path(path)
        match = PART.match(path, place)
        if match is None:
            raise _no_path(path)
        index = match["index"]
        if match["entry"] and not found:
            raise _no_path(path)
        if index is None:
            found.append(match["bare"] or match["quoted"] or match["entry"])
        else:
            found.append(EVERY if index == EVERY else int(index))
        place = match.end()
    if not found or isinstance(found[0], int) or found[0] == EVERY:
        raise _no_path(path)
    return found


def _no_path(path: str) -> ValueError:
    return ValueError(f"parameters: got {path!r}, expected a path of keys such as 'rod[0].segment[0].radius'")


def meant(name: str, known: Iterable[str], thing: Any = None, place: str = "") -> str:
    """Advice in place of an unknown name, also one of a part within the thing at this place."""
    names = sorted(known)
    before = f"{place}." if place else ""
    inside = within(thing, _exactly(name))
    advice = f"did you mean '{before}{inside}'?" if inside else did_you_mean(name, names)
    if not advice and (inside := within(thing, lambda inner: like(name, inner))):
        advice = f"did you mean '{before}{inside}'?"
    close = next(iter(difflib.get_close_matches(name, names, 1, 0.5)), None)
    if close and not advice:
        advice = f"did you mean '{close}'?"
    listed = ", ".join(f"'{other}'" for other in names)
    return f"expected one of {listed}" + (f"; {advice}" if advice else "")


def _parts_of(thing: Any) -> dict[str, Any]:
    """What a table of a scene or an object consists of, by name; empty for plain values."""
    if isinstance(thing, dict):
        return thing
    return {} if thing is None or isinstance(thing, (*PLAIN, list, tuple)) else constructed(thing) or {}


def _exactly(name: str) -> Callable[[list[str]], str | None]:
    return lambda inner: name if name in inner else None


def within(thing: Any, is_meant: Callable[[list[str]], str | None]) -> str | None:
    """The path of the nearest part within a thing whose name is meant, with a star for each list."""
    nearest = [("", thing)]
    for path, part in nearest:
        for key, value in _parts_of(part).items():
            is_list = isinstance(value, list | tuple) and len(value) > 0
            inner, place = (value[0], f"{path}{key}[*]") if is_list else (value, f"{path}{key}")
            found = is_meant(list(_parts_of(inner)))
            if found:
                return f"{place}.{found}"
            nearest.append((f"{place}.", inner))
    return None


def up_to(path: Sequence[Part], count: int) -> str:
    """The first parts of a path as text."""
    text = ""
    for part in path[:count]:
        text += f"[{part}]" if isinstance(part, int) or part == EVERY else f".{part}" if text else part
    return text


def expanded(path: Sequence[Part], has: Callable[[Sequence[Part]], bool]) -> list[list[Part]]:
    """The path with indices in place of each star, for all entries that are there.

    `has` says whether there is something at the end of a path. Lists without entries are left out beside
    others, such as those of links that have no rod. Where no list has any, a star becomes an index of zero,
    so that what is missing is reported.
    """
    there, missing = _with_indices(path, has)
    return there or missing


def _with_indices(
    path: Sequence[Part], has: Callable[[Sequence[Part]], bool]
) -> tuple[list[list[Part]], list[list[Part]]]:
    """The paths whose stars all stand for entries, and the others."""
    if EVERY not in path:
        return [list(path)], []
    at = list(path).index(EVERY)
    before, after = list(path[:at]), list(path[at + 1 :])
    count = 0
    while has([*before, count]):
        count += 1
    each = [_with_indices([*before, i, *after], has) for i in range(max(count, 1))]
    there, missing = ([one for part in parts for one in part] for parts in zip(*each, strict=True))
    return (there, missing) if count else ([], there + missing)


def _numbered_in_document(here: Any, part: Part) -> Part:
    """The number of an entry of an array that has this name; anything else as it is."""
    if not isinstance(here, list) or not isinstance(part, str):
        return part
    names = [each.get("name") if isinstance(each, dict) else None for each in here]
    return names.index(part) if part in names else part


def _is_in_document(document: dict[str, Any], path: Sequence[Part]) -> bool:
    here: Any = document
    for part in path:
        part = _numbered_in_document(here, part)
        if isinstance(part, int):
            is_there = isinstance(here, list) and part < len(here)
        else:
            is_there = isinstance(here, dict) and part in here
        if not is_there:
            return False
        here = here[part]
    return True


def set_in_document(document: dict[str, Any], path: Sequence[Part], value: Any) -> None:
    """Set a value in a scene's document, or all those of a path with stars.

    The last key may be new; the scene checks whether it is known. Raises ValueError if the path does not
    exist.
    """
    for one in expanded(path, lambda part: _is_in_document(document, part)):
        _set_in_document(document, one, value)


def _set_in_document(document: dict[str, Any], path: Sequence[Part], value: Any) -> None:
    """Set one value.

    Raises ValueError if the path does not exist.
    """
    here: Any = document
    for i, part in enumerate(path):
        is_last = i == len(path) - 1
        part = _numbered_in_document(here, part)
        if isinstance(part, int):
            if not isinstance(here, list) or part >= len(here):
                there = _entries(here) if isinstance(here, list) else "no array"
                raise ValueError(f"{up_to(path, i + 1)}: the scene has {there} at {up_to(path, i)}")
        elif not isinstance(here, dict):
            raise ValueError(f"{up_to(path, i + 1)}: {up_to(path, i)} has no keys")
        elif not is_last and part not in here:
            raise ValueError(
                f"{up_to(path, i + 1)}: the scene has no such key, {meant(part, here)} "
                "(a default has to be written into the scene before its parts can be swept, such as "
                "`gravity = [0, 0, -9.81]` in [scene] for 'scene.gravity[2]')"
            )
        if is_last and i == 0 and part not in here:
            # The top level has tables alone.
            inside = within(document, _exactly(str(part)))
            if inside:
                raise ValueError(f"{part}: the scene has no such key; did you mean '{inside}'?")
        if is_last:
            here[part] = value
        else:
            here = here[part]


def _entries(sequence: Sequence[Any]) -> str:
    count = len(sequence)
    return f"{count} entry" if count == 1 else f"{count} entries"


def toml(value: Any) -> str:
    """A value in TOML syntax within a line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return f"{{{', '.join(f'{toml(key)} = {toml(inner)}' for key, inner in value.items())}}}"


def document_text(document: dict[str, Any]) -> str:
    """A document as the text of a TOML file."""
    return "".join(f"{toml(key)} = {toml(value)}\n" for key, value in document.items())


#: Names of scenes that differ from those of classes, apart from plurals.
PLURALS = {"body": "bodies"}

#: Actuators of one kind, which are counted by themselves, as in scenes: the second motor is ``motors[1]``.
OF_KIND = {
    **dict.fromkeys(("tendon", "tendons"), "Tendon"),
    **dict.fromkeys(("chamber", "chambers"), "Chamber"),
    **dict.fromkeys(("motor", "motors"), "Motor"),
}

#: Arguments that can replace each other.
TWO_OF_ONE = {"poisson_ratio": "shear_modulus", "shear_modulus": "poisson_ratio"}


#: Values without parts; Python can copy them from arguments, as objects with parts.
PLAIN = (bool, int, float, str)


def replaced(thing: Any, path: Sequence[Part], value: Any) -> Any:
    """A copy of a model, or of a part of one, with another value at the end of a path, or of all with a star.

    Raises ValueError if the path does not exist, and the exceptions of the constructors.
    """
    for one in each_of(thing, path):
        thing = replacing(thing, one)(value)
    return thing


def each_of(thing: Any, path: Sequence[Part]) -> list[list[Part]]:
    """The paths that a path with stars stands for."""

    def has(part: Sequence[Part]) -> bool:
        try:
            found(thing, part)
        except ValueError:
            return False
        return True

    return expanded(path, has)


def replacing(thing: Any, path: Sequence[Part]) -> Callable[[Any], Any]:
    """The same as a function of the value."""
    within: list[_Inside] = []
    while not within or within[-1].done < len(path):
        inside = _inside(thing, path, within[-1].done if within else 0)
        within.append(inside)
        thing = inside.parts[inside.key]

    def made(value: Any) -> Any:
        for inside in reversed(within):
            parts = inside.parts.copy()
            parts[inside.key] = value
            # Two such arguments determine each other.
            if inside.key in TWO_OF_ONE:
                parts.pop(TWO_OF_ONE[inside.key], None)
            value = inside.made(parts)
        return value

    return made


def found(thing: Any, path: Sequence[Part]) -> Any:
    """The value at the end of a path.

    Raises ValueError if the path does not exist.
    """
    done = 0
    while done < len(path):
        inside = _inside(thing, path, done)
        thing, done = inside.parts[inside.key], inside.done
    return thing


def with_numbers(thing: Any, path: Sequence[Part]) -> list[Part]:
    """The path with numbers in place of names of entries, up to its first star."""
    numbered = list(path)
    for i, part in enumerate(path):
        if part == EVERY:
            break
        try:
            here = found(thing, numbered[:i])
        except ValueError:
            break
        names = [getattr(one, "name", None) for one in here] if isinstance(here, list | tuple) else []
        if part in names:
            numbered[i] = names.index(part)
    return numbered


def written_out(thing: Any, path: Sequence[Part]) -> tuple[Part, ...]:
    """The keys that a path uses: equal for two spellings of one path.

    Raises ValueError where nothing of the kind is there.
    """
    keys: list[Part] = []
    done = 0
    while done < len(path):
        inside = _inside(thing, path, done)
        thing, done = inside.parts[inside.key], inside.done
        keys.append(inside.key)
    return tuple(keys)


class _Inside(NamedTuple):
    """Copies of the parts of an object, and the part to which a path leads."""

    parts: Any
    key: Any
    #: Creates an object from its parts.
    made: Callable[[Any], Any]
    #: Number of the path's parts up to here.
    done: int


def _inside(thing: Any, path: Sequence[Part], done: int) -> _Inside:
    part = path[done]
    if hasattr(thing, "tolist"):
        # Numbers of a table or a matrix.
        thing = thing.tolist()
    # A scene's `rod.segment[0]` is the first entry of a link's `rod`.
    if isinstance(thing, list | tuple) and done + 1 < len(path) and part in ("segment", "segments"):
        done += 1
        part = path[done]
    if isinstance(part, int):
        places = _numbered(thing, path, done)
        if places is None or part >= len(places):
            there = "no sequence" if places is None else _entries(places)
            raise ValueError(f"{up_to(path, done + 1)}: the model has {there} at {up_to(path, done)}")
        return _Inside(list(thing), places[part], tuple, done + 1)
    if isinstance(thing, dict):
        if part not in thing:
            raise ValueError(f"{up_to(path, done + 1)}: {meant(part, thing)}")
        return _Inside(dict(thing), part, dict, done + 1)
    if isinstance(thing, list | tuple):
        here = up_to(path, done)
        names = [getattr(one, "name", None) for one in thing]
        if part in names:
            return _Inside(list(thing), names.index(part), tuple, done + 1)
        named = [str(name) for name in names if name]
        raise ValueError(
            f"{up_to(path, done + 1)}: {here} has {_entries(thing)}, expected the number of one, such as "
            f"'{here}[0].{part}'" + (f", or the name of one, such as '{here}[{named[0]}]'" if named else "")
        )
    maker: Callable[..., Any] = type(thing)
    arguments = None if isinstance(thing, PLAIN) else constructed(thing)
    if arguments is None:
        raise ValueError(f"{up_to(path, done + 1)}: {up_to(path, done)} has no parts")
    known = set(arguments) | set(_parameters(maker))
    of_all = "actuators" if part in OF_KIND else PLURALS.get(part, f"{part}s")
    name = next((name for name in (part, of_all) if name in known), None)
    if name is None and part in ("segment", "segments") and "links" in known:
        rest = "".join(f".{each}" if isinstance(each, str) else f"[{each}]" for each in path[done + 1 :])
        raise ValueError(
            f"{up_to(path, done + 1)}: the segments of a robot are those of its links, expected "
            f"'links[*].rod.{part}{rest}', or the number of a link in place of the star"
        )
    if name is None:
        # What follows a name says of which kind it is.
        is_last = done == len(path) - 1
        advice = meant(part, known, thing if is_last else None, up_to(path, done))
        raise ValueError(f"{up_to(path, done + 1)}: {advice}")
    # For example Poisson's ratio, which is stored as a shear modulus.
    arguments.setdefault(name, getattr(thing, name, None))
    return _Inside(arguments, name, lambda parts: maker(**parts), done + 1)


def _numbered(thing: Any, path: Sequence[Part], done: int) -> Sequence[int] | None:
    """Where the entries of a sequence are that a number counts: those of one kind; None for other things."""
    if not isinstance(thing, list | tuple):
        return None
    kind = OF_KIND.get(str(path[done - 1])) if done else None
    return [i for i, one in enumerate(thing) if kind is None or type(one).__name__ == kind]


def of_model(path: Sequence[Part], is_rod: bool) -> list[Part]:
    """A scene's path within its model: for a rod, the model is the rod itself."""
    if is_rod and path[:1] == ["rod"]:
        rest = list(path[1:])
        if rest and isinstance(rest[0], int) and rest[0] > 0:
            raise ValueError(f"rod[{rest[0]}]: the model is one rod, expected rod[0]")
        return rest[1:] if rest[:1] == [0] else rest
    return list(path)


def constructed(thing: Any) -> dict[str, Any] | None:
    """Arguments by name that create this object again; None if it has none."""
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        fields = dataclasses.fields(thing)
        return {field.name: getattr(thing, field.name) for field in fields if field.init}
    if hasattr(thing, "__getnewargs_ex__"):
        values, named = thing.__getnewargs_ex__()
    elif hasattr(thing, "__getnewargs__"):
        values, named = thing.__getnewargs__(), {}
    else:
        return None
    arguments: dict[str, Any] = dict(zip(_parameters(type(thing)), values, strict=False))
    arguments.update(named)
    return arguments


#: Cached argument names of classes, because reading a signature takes longer than creating most models.
_SIGNATURES: dict[Callable[..., Any], tuple[str, ...]] = {}


def _parameters(kind: Callable[..., Any]) -> tuple[str, ...]:
    if kind not in _SIGNATURES:
        _SIGNATURES[kind] = tuple(inspect.signature(kind).parameters)
    return _SIGNATURES[kind]


def plain(thing: Any) -> Any:
    """The data of an object as JSON types: equal for equal objects, in every process."""
    if thing is None or isinstance(thing, bool | int | float | str):
        return thing
    if isinstance(thing, dict):
        return {str(key): plain(value) for key, value in thing.items()}
    if isinstance(thing, list | tuple):
        return [plain(value) for value in thing]
    if hasattr(thing, "tolist"):
        return thing.tolist()
    name = type(thing).__qualname__
    arguments = constructed(thing)
    if arguments is not None:
        return {name: plain(arguments)}
    if callable(thing):
        return f"{thing.__module__}.{getattr(thing, '__qualname__', name)}"
    if type(thing).__module__.startswith("lissom"):
        return {name: plain(thing.__reduce__()[1])}
    return {name: repr(thing)}
