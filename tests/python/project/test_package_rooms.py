"""The rooms of the package, listed in CONTRIBUTING.md, and their allowed imports."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

from lissom import cli

ROOT = Path(__file__).parents[3]
PACKAGE = ROOT / "python" / "lissom"

#: A dozen, and `attached`, which gives compiled results their methods.
MOST_ROOMS = 13


def rooms():
    """The rooms from the bottom up."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.split("## Rooms of the package")[1].split("\n## ")[0]
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) +\|", section, re.MULTILINE)
    return [name for row in rows for name in re.findall(r"`(\w+)`", row)]


def python_imports():
    """The modules of the package by their paths, and their imports at any place."""
    files = {file.relative_to(PACKAGE).with_suffix("").parts: file for file in PACKAGE.rglob("*.py")}
    files = {path[:-1] if path[-1] == "__init__" else path: file for path, file in files.items()}
    found = {path: set() for path in files}
    for path, file in files.items():
        folder = path if file.name == "__init__.py" else path[:-1]
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert not any(alias.name.partition(".")[0] == "lissom" for alias in node.names), file
            if not isinstance(node, ast.ImportFrom):
                continue
            # Absolute imports would hide from this test.
            assert (node.module or "").partition(".")[0] != "lissom", file
            if node.level:
                up = len(folder) - (node.level - 1)
                base = (*folder[:up], *(node.module or "").split(".")) if node.module else folder[:up]
                inner = {(*base, alias.name) for alias in node.names}
                found[path] |= inner & files.keys() or {base} & files.keys()
        # The package itself re-exports what lies below all of them.
        found[path] -= {(), path}
    # The command line imports a command by its name when it is called.
    found[("cli",)] |= {("cli", name) for name in cli.COMMANDS}
    return found


def test_the_package_consists_of_its_rooms():
    """Beside the compiled module, its stub and what Python itself asks for."""
    files = ("__init__.py", "__main__.py", "__pycache__", "_lissom", "py.typed")
    entries = {entry.name for entry in PACKAGE.iterdir() if not entry.name.startswith(files)}
    known = rooms()
    assert {entry.removesuffix(".py") for entry in entries} == set(known)
    assert len(known) == len(entries) <= MOST_ROOMS


def test_rooms_of_the_package_use_only_lower_ones():
    floor = {room: at for at, room in enumerate(rooms())}
    found = python_imports()
    assert ("model", "views") in found[("results", "runs")]
    assert ("cli", "saving") in found[("cli", "run")]
    upwards = [
        (".".join(path), ".".join(other))
        for path, others in found.items()
        if path not in ((), ("__main__",))
        for other in others
        if floor[other[0]] > floor[path[0]]
    ]
    assert upwards == []


def test_no_python_modules_import_each_other():
    assert list(TopologicalSorter(python_imports()).static_order())
