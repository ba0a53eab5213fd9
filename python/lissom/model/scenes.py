"""Models as scene files."""

from __future__ import annotations

import re
import tomllib
import warnings
from dataclasses import replace
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from .._lissom import Load, Robot, Rod, Scene, SceneError, SpringPendulum, Weld
from ..common.arguments import number, path_of, text, vector
from . import paths
from .paths import toml

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from numpy.typing import ArrayLike

    from .._lissom import Model

#: A part, after its place in the model.
Placed = tuple[str, Any]


def to_scene(
    model: Model,
    *,
    t_end: float = 1.0,
    name: str = "model",
    q0: ArrayLike | None = None,
    v0: ArrayLike | None = None,
    **simulation: Any,
) -> Scene:
    """`Model.to_scene`."""
    name = text("name", name)
    settings = {"t_end": number("t_end", t_end)}
    settings |= {key: _plain(value, key) for key, value in simulation.items()}
    states = {
        key: vector(key, given, model.n).tolist()
        for key, given in (("q0", q0), ("v0", v0))
        if given is not None
    }
    blocks = ["version = 1\n", *_of_model(model, name, states), _keys(settings, "[simulation]")]
    return Scene.loads("\n".join(blocks), name)


def changed(text: str, values: Mapping[str, Any], name: str, imports: Mapping[str, bytes]) -> Scene:
    """A scene with other values of some keys, by their paths.

    Raises ValueError if a path does not exist or the scene becomes invalid.
    """
    document = tomllib.loads(text)
    for path, value in values.items():
        parts = paths.parts(path)
        if parts[0] == "import" and "urdf" in parts[1:]:
            raise ValueError(f"{path}: an imported file is read with the scene: write a scene for each file")
        paths.set_in_document(document, parts, value)
    with warnings.catch_warnings():
        # The warnings were issued when the scene was read.
        warnings.simplefilter("ignore")
        try:
            return Scene.loads(paths.document_text(document), name, imports=dict(imports))
        except SceneError as error:
            raise ValueError(_in_words(error)) from None


def _in_words(error: SceneError) -> str:
    """The problems of a generated scene, without line numbers."""
    problems = [
        f"{problem.key}: {problem.wrong}" + (f"; {problem.right}" if problem.right else "")
        for problem in error.problems
    ]
    return " / ".join(problems)


def _plain(value: Any, key: str) -> Any:
    """A value of a key as TOML has it."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, list | tuple):
        return [_plain(inner, f"{key}[{i}]") for i, inner in enumerate(value)]
    if isinstance(value, dict):
        return {str(inner): _plain(part, f"{key}.{inner}") for inner, part in value.items()}
    raise TypeError(f"{key}: expected a number, a text, a list or a dictionary, got {type(value).__name__}")


@singledispatch
def _of_model(model: Model, name: str, states: dict[str, list[float]]) -> list[str]:
    raise TypeError(f"model: expected a Robot, a Rod or a SpringPendulum, got {type(model).__name__}")


@_of_model.register(SpringPendulum)
def _of_pendulum(pendulum: SpringPendulum, name: str, states: dict[str, list[float]]) -> list[str]:
    numbers = {key: getattr(pendulum, key) for key in ("length", "mass", "stiffness", "gravity")}
    return [_keys({"name": name}, "[scene]"), _keys(numbers | states, "[pendulum]")]


@_of_model.register(Robot)
def _of_robot(robot: Robot, name: str, states: dict[str, list[float]]) -> list[str]:
    on_links, around = _parts(robot)
    blocks = _general(robot, name)
    for link in robot.links:
        where = f"links[{link.name!r}]"
        # The rest is easier to read in tables of its own.
        keys = _part("[[link]]", replace(link, joint=Weld(), rod=None, body=None), where)
        blocks.append(keys + _lines({key: state[robot.slice(link.name)] for key, state in states.items()}))
        kind = type(link.joint).__name__.lower()
        if kind != "weld":
            text = _text(link.joint, f"{where}.joint")
            blocks.append(f"[link.joint]\ntype = {toml(kind)}\n{text}")
        if link.rod is not None:
            segments = ((f"{where}.rod[{i}]", segment) for i, segment in enumerate(link.rod))
            blocks += _tables("link.rod.", segments)
        if link.body is not None:
            blocks.append(_part("[link.body]", link.body, f"{where}.body"))
        # A part that names no link is on the only one.
        own = [(where, part) for where, part in on_links if part.link in (link.name, None)]
        blocks += [table.replace("[[link.body]]", "[[link.fixed_body]]") for table in _tables("link.", own)]
    return [*blocks, *_surroundings(robot), *_tables("", around)]


@_of_model.register(Rod)
def _of_rod(rod: Rod, name: str, states: dict[str, list[float]]) -> list[str]:
    on_rod, around = _parts(rod)
    base = {"position": list(rod.base_position), "orientation": list(rod.base_orientation)}
    ends = {key: list(getattr(rod, key)) for key in ("tip_force", "tip_moment")}
    keys = {"base": base, **ends, "tip_mass": rod.tip_mass, **states}
    segments = ((f"segments[{i}]", segment) for i, segment in enumerate(rod.segments))
    blocks = [*_general(rod, name), _keys(keys, "[[rod]]"), *_surroundings(rod, "rod.")]
    return [*blocks, *_tables("rod.", segments), *_tables("rod.", on_rod), *_tables("", around)]


def _general(robot: Robot, name: str) -> list[str]:
    # The field takes the forms of a force.
    field = _text(Load(force=robot.field), "field").replace("force = ", "field = ", 1)
    return [_keys({"name": name, "gravity": list(robot.gravity)}, "[scene]") + field]


def _surroundings(robot: Robot, within: str = "") -> list[str]:
    parts = {key: getattr(robot, key) for key in ("base_motion", "fluid")}
    return [_part(f"[{within}{key}]", part, key) for key, part in parts.items() if part is not None]


def _parts(robot: Robot) -> tuple[list[Placed], list[Placed]]:
    """The parts in lists besides links and segments: those that lie on a link, and the others."""
    on_links: list[Placed] = []
    around: list[Placed] = []
    for name in robot.__dataclass_fields__:
        value = getattr(robot, name)
        if name in ("links", "segments") or not isinstance(value, tuple):
            continue
        # Numbers are no parts.
        parts = [(f"{name}[{i}]", part) for i, part in enumerate(value) if hasattr(part, "to_toml")]
        is_on_links = all(hasattr(part, "link") and hasattr(part, "at") for _, part in parts)
        (on_links if is_on_links else around).extend(parts)
    return on_links, around


def _tables(within: str, parts: Iterable[Placed]) -> list[str]:
    """An item of an array of tables for each part; the array has the name of its class."""
    return [_part(f"[[{within}{_snake(type(part).__name__)}]]", part, where) for where, part in parts]


def _snake(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()


def _part(header: str, part: Any, where: str) -> str:
    return f"{header}\n{_text(part, where)}"


def _text(part: Any, where: str) -> str:
    try:
        text: str = part.to_toml()
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return text


def _keys(keys: dict[str, Any], header: str) -> str:
    return f"{header}\n{_lines(keys)}"


def _lines(keys: dict[str, Any]) -> str:
    return "".join(f"{key} = {toml(value)}\n" for key, value in keys.items())


def save(scene: Scene, path: str | os.PathLike[str]) -> None:
    """`Scene.save`."""
    file = path_of(path)
    content, arrays = scene._set_aside(file.stem)
    # Arrays that an earlier version of this file names belong to it.
    before = _files_in(file) if file.exists() else set()
    beside = dict(scene.imports)
    for name, rows in arrays:
        if name in beside:
            raise FileExistsError(f"{name}: the scene imports a file of this name, save it under another one")
        beside[name] = rows.encode()
    for name, data in beside.items():
        other = file.parent / name
        if (
            other.exists()
            and other.read_bytes() != data
            and not (name not in scene.imports and name in before)
        ):
            raise FileExistsError(
                f"{other}: another file of this name is there; save the scene elsewhere, or by another name"
            )
    for name, data in beside.items():
        other = file.parent / name
        other.parent.mkdir(parents=True, exist_ok=True)
        other.write_bytes(data)
    # Byte by byte: text files would get the ends of lines of the system.
    file.write_bytes(content.encode())


def _files_in(scene: Path) -> set[str]:
    """Names of the arrays in files that a scene has, if it is one."""
    try:
        document = tomllib.loads(scene.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError):
        return set()

    def names(value: Any) -> Iterable[str]:
        if isinstance(value, dict):
            if isinstance(value.get("file"), str):
                yield value["file"]
            value = list(value.values())
        if isinstance(value, list):
            for inner in value:
                yield from names(inner)

    return set(names(document))
