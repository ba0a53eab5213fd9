"""Loading of scenes for commands, and messages about invalid ones."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .exits import BAD_INPUT, FAILED

if TYPE_CHECKING:
    from .._lissom import Scene
    from ..model.visuals import Visual

#: The scene argument of a command.
SCENE = click.Path(exists=True, dir_okay=False, path_type=Path)


#: The option of commands that draw meshes of URDF files.
visuals_option = click.option(
    "--visuals", is_flag=True, help="Draw the meshes and shapes of <visual> of the URDF file of SCENE."
)


def _read_inputs(
    context: click.Context, parameter: click.Parameter, given: tuple[str, ...]
) -> dict[str, float | list[float]]:
    """Values of inputs by name."""
    found: dict[str, float | list[float]] = {}
    for text in given:
        name, is_given, value = text.partition("=")
        try:
            numbers = [float(each) for each in value.split(",")] if is_given else []
        except ValueError:
            numbers = []
        if not name or not numbers:
            raise click.BadParameter(f"{text!r} is not NAME=NUMBER", context, parameter)
        found[name.strip()] = numbers[0] if len(numbers) == 1 else numbers
    return found


#: The option of commands that take inputs of a scene.
inputs_option = click.option(
    "--input",
    "inputs",
    multiple=True,
    metavar="NAME=NUMBER",
    callback=_read_inputs,
    help="Value of an input, such as pull=0.3, or wind=1,0,0; may be repeated.  [default: the scene's]",
)


def value_of(text: str) -> Any:
    """A value of a key as TOML writes it, or else a text."""
    import tomllib

    for read in (int, float, lambda value: tomllib.loads(f"value = {value}")["value"]):
        try:
            return read(text)
        except ValueError:
            continue
    return text


def _read_changes(
    context: click.Context, parameter: click.Parameter, given: tuple[str, ...]
) -> dict[str, Any]:
    """Values of keys by their paths."""
    found = {}
    for text in given:
        key, _, value = text.partition("=")
        if not key or not value:
            raise click.BadParameter(f"{text!r} is not KEY=VALUE", context, parameter)
        found[key.strip()] = value_of(value.strip())
    return found


#: The option of commands that take other values of keys.
set_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    callback=_read_changes,
    help="Another value of a key of SCENE, such as simulation.dt=1e-3; may be repeated.",
)


class Refused(click.ClickException):
    """An invalid scene, with all of its problems."""

    exit_code = BAD_INPUT

    def show(self, file: Any = None) -> None:
        click.echo(self.message, err=True)


class Unresolved(Refused):
    """A scene whose open modes could not be chosen."""

    exit_code = FAILED


def load(path: Path, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene, with other values of some keys.

    Raises Refused, which ends the program unless it is caught.
    """
    from .._lissom import LissomError, Scene, SceneError

    try:
        with _notes():
            scene = Scene.load(path, anywhere=_may_import_anywhere())
    except OSError as error:
        raise click.UsageError(f"{path} cannot be read: {error.strerror}") from None
    except SceneError as error:
        raise Refused(str(error)) from None
    except (LissomError, ValueError) as error:
        raise Unresolved(f"{path}: {error}") from None
    if not changes:
        return scene
    from ..model.scenes import changed

    try:
        return changed(scene.text, changes, scene.name, scene.imports)
    except ValueError as error:
        raise Refused(f"{path}: --set: {error}") from None


def visuals_of(path: Path, scene: Scene) -> list[Visual]:
    """The visuals of the URDF file that a scene imports; raises Refused if it has none, or one is invalid."""
    import tomllib

    from .._lissom import Robot
    from ..urdf import read_urdf

    imported = tomllib.loads(scene.text).get("import", {})
    if "urdf" not in imported:
        raise Refused(
            f"{path}: --visuals: the scene imports no URDF file; it needs [import] with the key urdf"
        )
    known = {link.name for link in scene.model.links} if isinstance(scene.model, Robot) else set()
    try:
        read = read_urdf(path.parent / imported["urdf"], mend_inertia=True, visuals=True)
    except (OSError, ValueError, ImportError) as error:
        raise Refused(f"{path}: --visuals: {error}") from None
    return [visual for visual in read.visuals if visual.link in known]


def _may_import_anywhere() -> bool:
    """The option of the program, which is given before the command."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.find_root().params.get("import_anywhere"))


@contextmanager
def _notes() -> Iterator[None]:
    """Print deprecations of scenes as notes instead of warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", FutureWarning)
        try:
            yield
        finally:
            for warning in caught:
                click.echo(f"Note: {warning.message}", err=True)


@contextmanager
def refusals_of(path: Path) -> Iterator[None]:
    """Turn errors of solvers about a scene into a one-line message and exit."""
    try:
        yield
    except ValueError as error:
        click.echo(f"{path}: {' '.join(str(error).split())}", err=True)
        raise click.exceptions.Exit(BAD_INPUT) from None
