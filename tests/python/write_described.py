"""Writes what follows from the tables of described parts: classes of the stub, definitions of the schema.

Run it with the extension built, and build again afterwards: the schema is compiled in.
"""

import json
from pathlib import Path

from lissom import _lissom

ROOT = Path(__file__).parents[2]
STUB = ROOT / "python/lissom/_lissom.pyi"
METHODS = ROOT / "python/lissom/methods/__init__.pyi"
SCHEMAS = (ROOT / "src/scene/schema.json", ROOT / "scenes/lissom-scene.schema.json")

#: The stubs before and behind them are written by hand.
MARKS = (
    "# Classes that are made from the tables of `description`; `test_description.py` compares them.\n",
    "# End of these classes.\n",
)


def write(stub, classes):
    """Replaces the classes of a stub."""
    text = stub.read_text(encoding="utf-8")
    (before, rest), (_, after) = text.split(MARKS[0]), text.split(MARKS[1])
    assert MARKS[1] in rest
    stub.write_text(before + MARKS[0] + classes + MARKS[1] + after, encoding="utf-8")


def references(node):
    """Names of the definitions to which a part of the schema refers."""
    if isinstance(node, dict):
        if "$ref" in node:
            yield node["$ref"].rsplit("/", 1)[1]
        node = list(node.values())
    if isinstance(node, list):
        for inner in node:
            yield from references(inner)


def used(schema):
    """The definitions to which the schema leads."""
    definitions = schema["definitions"]
    found, left = {}, list(references({key: schema[key] for key in schema if key != "definitions"}))
    while left:
        name = left.pop()
        if name not in found:
            found[name] = definitions[name]
            left += references(definitions[name])
    return found


def main():
    write(STUB, _lissom._stub_of_parts())
    write(METHODS, _lissom._stub_of_methods())
    definitions = json.loads(_lissom._schema_of_parts())
    for path in SCHEMAS:
        schema = json.loads(path.read_text(encoding="utf-8"))
        more = schema["definitions"]["Link"]["properties"]
        schema["definitions"] |= definitions
        # Scenes have more keys of links.
        schema["definitions"]["Link"]["properties"] = more | definitions["Link"]["properties"]
        schema["definitions"] = used(schema)
        text = json.dumps(schema, indent=2, sort_keys=True, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
