"""The player as one script: its modules in the order of their imports, each in a function of its own.

Reports are single files that load nothing, and modules can only be loaded: from another file, or from a
``data:`` address, which a content policy should not allow.
"""

from __future__ import annotations

import io
import pkgutil
import re
from functools import cache

#: Prefix of module names in the player's imports.
PREFIX = "lissom/"

_IMPORT = re.compile(rf'^import \{{ ([\w, ]+) \}} from "{PREFIX}(\w+)\.js";$', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:const|function|class) (\w+))", re.MULTILINE)


def asset(name: str) -> str:
    """The text of a file of the player."""
    content = pkgutil.get_data(__package__, f"player/{name}")
    assert content is not None, "packages are read from files or archives"
    return io.TextIOWrapper(io.BytesIO(content), encoding="utf-8").read()


@cache
def script(first: str) -> str:
    """The script that runs the module `first`, and before it the modules that it imports."""
    parts: dict[str, str] = {}

    def add(name: str) -> None:
        text = asset(f"{name}.js")
        imports = _IMPORT.findall(text)
        for _, needed in imports:
            if needed not in parts:
                add(needed)
        exports = ", ".join(_EXPORT.findall(text))
        body = _EXPORT.sub("", _IMPORT.sub(r"const { \1 } = \2Module;", text))
        parts[name] = f"const {name}Module = (() => {{\n{body}return {{ {exports} }};\n}})();\n"

    add(first)
    return '"use strict";\n' + "".join(parts.values())
