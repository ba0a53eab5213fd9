"""Models as scene files."""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from .._lissom import Load, Robot, Rod, Scene, SpringPendulum, Weld
from ..common.arguments import number, path_of, text, vector
from .paths import toml

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Sequence

    from numpy.typing import ArrayLike

    from .._lissom import Model

#: The lists of a scene's actuators.
_ACTUATORS = {"Tendon": "tendon", "Chamber": "chamber", "Motor": "motor", "ActiveStrain": "active_strain"}


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
    return [*_general(robot, name), *_links(robot, states), *_around(robot)]


@_of_model.register(Rod)
def _of_rod(rod: Rod, name: str, states: dict[str, list[float]]) -> list[str]:
    return [*_general(rod, name), *_rod(rod, states), *_around(rod)]


def _general(robot: Robot, name: str) -> list[str]:
    # The field takes the forms of a force.
    field = _text(Load(force=robot.field), "field").replace("force = ", "field = ", 1)
    return [_keys({"name": name, "gravity": list(robot.gravity)}, "[scene]") + field]


def _around(robot: Robot) -> list[str]:
    actuators = [
        _part(f"[[{_ACTUATORS[type(part).__name__]}]]", part, f"actuators[{i}]")
        for i, part in enumerate(robot.actuators)
    ]
    return actuators + _list("loop", robot.loops, "loops") + _list("contact", robot.contacts, "contacts")


def _links(robot: Robot, states: dict[str, list[float]]) -> list[str]:
    blocks = []
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
            blocks += _list("link.rod.segment", link.rod, f"{where}.rod")
        if link.body is not None:
            blocks.append(_part("[link.body]", link.body, f"{where}.body"))
        blocks += _of_link("link.fixed_body", robot.bodies, link.name, "bodies")
        blocks += _of_link("link.load", robot.loads, link.name, "loads")
        blocks += _of_link("link.support", robot.supports, link.name, "supports")
        blocks += _of_link("link.magnet", robot.magnets, link.name, "magnets")
    if robot.base_motion is not None:
        blocks.append(_part("[base_motion]", robot.base_motion, "base_motion"))
    if robot.fluid is not None:
        blocks.append(_part("[fluid]", robot.fluid, "fluid"))
    return blocks


def _rod(rod: Rod, states: dict[str, list[float]]) -> list[str]:
    base = {"position": list(rod.base_position), "orientation": list(rod.base_orientation)}
    ends = {key: getattr(rod, key) for key in ("tip_force", "tip_moment")}
    keys = {"base": base, **{key: list(value) for key, value in ends.items()}, "tip_mass": rod.tip_mass}
    blocks = [_keys(keys | states, "[[rod]]")]
    if rod.base_motion is not None:
        blocks.append(_part("[rod.base_motion]", rod.base_motion, "base_motion"))
    if rod.fluid is not None:
        blocks.append(_part("[rod.fluid]", rod.fluid, "fluid"))
    blocks += _list("rod.segment", rod.segments, "segments") + _list("rod.load", rod.loads, "loads")
    blocks += _list("rod.body", rod.bodies, "bodies") + _list("rod.support", rod.supports, "supports")
    return blocks + _list("rod.magnet", rod.magnets, "magnets")


def _of_link(key: str, parts: Sequence[Any], link: str, where: str) -> list[str]:
    """Those of one link; a part that names no link is on the only one."""
    own = ((i, part) for i, part in enumerate(parts) if part.link in (link, None))
    return [_part(f"[[{key}]]", part, f"{where}[{i}]") for i, part in own]


def _list(key: str, parts: Iterable[Any], where: str) -> list[str]:
    return [_part(f"[[{key}]]", part, f"{where}[{i}]") for i, part in enumerate(parts)]


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
    beside = [(file.parent / name, content) for name, content in scene.imports.items()]
    for other, content in beside:
        if other.exists() and other.read_bytes() != content:
            raise FileExistsError(f"{other}: the scene imports another file of this name")
    for other, content in beside:
        other.parent.mkdir(parents=True, exist_ok=True)
        other.write_bytes(content)
    # Byte by byte: text files would get the ends of lines of the system.
    file.write_bytes(scene.text.encode())
