"""Mutations of scenes: of the tree of keys, using the JSON Schema, and of the text.

A tree is the result of `tomllib`: dicts, lists, numbers, strings. `Raw` is text that is written unchanged.
"""

import copy
import json

import numpy as np


class Raw(str):
    """A value that is written to the file without quotes."""


# Writing.


def word(text: str) -> str:
    """A key or a string, quoted if necessary; the escapes of JSON are also those of TOML."""
    return json.dumps(text, ensure_ascii=False)


def inline(value) -> str:
    """A value on one line."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return word(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key_text(k)} = {inline(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return repr(value) if isinstance(value, int | float) else str(value)


def key_text(key: str) -> str:
    bare = key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key)
    return key if bare else word(key)


def write(tree: dict, path: tuple[str, ...] = ()) -> str:
    """A table with one key per line; tables and arrays of tables have headers on the first three levels."""
    lines, later = [], []
    for key, value in tree.items():
        tables = isinstance(value, list) and value and all(isinstance(item, dict) for item in value)
        if len(path) < 2 and (isinstance(value, dict) or tables):
            later.append((key, value))
        else:
            lines.append(f"{key_text(key)} = {inline(value)}")
    text = "".join(line + "\n" for line in lines)
    for key, value in later:
        name = ".".join(map(key_text, (*path, key)))
        for item in value if isinstance(value, list) else [value]:
            head = f"[[{name}]]" if isinstance(value, list) else f"[{name}]"
            text += f"\n{head}\n{write(item, (*path, key))}"
    return text


# Replacement values.

NUMBERS = [
    0,
    0.0,
    -0.0,
    1,
    -1,
    2,
    3,
    64,
    65,
    256,
    257,
    1000,
    10**6,
    10**9,
    2**31,
    2**53,
    2**63 - 1,
    -(2**63),
    5e-324,
    2.3e-308,
    1e-300,
    1e-160,
    1e-30,
    1e-9,
    1e-3,
    0.5,
    1e3,
    3e3,
    1e9,
    1e15,
    1e30,
    1e100,
    1e160,
    1e300,
    1.7976931348623157e308,
    float("inf"),
    -float("inf"),
    float("nan"),
    Raw("-nan"),
    Raw("1e400"),
    Raw("-1e400"),
    Raw("1e-400"),
    Raw("9223372036854775808"),
    Raw("0x7fffffffffffffff"),
    Raw("0b1"),
    Raw("1_000"),
    Raw("1" * 400),
    Raw("0." + "1" * 5000),
]
OTHERS = [
    True,
    False,
    "",
    "0.5",
    "auto",
    "newmark",
    "body",
    "given",
    "cowper",
    "hermite",
    "a" * 10_000,
    "\u0000",
    "\u202e\U0001f40d",
    "../../etc/passwd",
    "<script>alert(1)</script>",
    "{% %}%s%n{0}",
    [],
    [[]],
    {},
    [{}],
    [1],
    [1, 2, 3],
    [0.5, "x"],
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    [[1, 2], [3]],
    {"times": [0, 1], "values": [[0, 0, 0], [0, 0, 1]]},
    {"times": [], "values": []},
    {"times": [0, 0], "values": [0, 0]},
    {"times": [0, 5e-324], "values": [[0, 0, 0], [0, 0, 1e308]]},
    {"amplitude": [0, 0, 1e300], "frequency": 1e300},
    {"amplitude": 1, "frequency": 1e-300},
    {"rate": 1e308},
    {"stations": [0, 0.1], "values": [0.01, 0.02]},
    {"stations": [0.1, 0], "values": [0.01, 0.02]},
    Raw("1979-05-27T07:32:00Z"),
    Raw("1979-05-27"),
    Raw("07:32:00"),
    Raw('"""\nlines\n"""'),
    Raw("'''raw\\'''"),
    Raw('"\\ud800"'),
    Raw('"\\U00110000"'),
    Raw(""),
    Raw("="),
    Raw("[" * 200),
]


class Schema:
    """The JSON Schema of scenes: the allowed keys of tables, and values of keys."""

    def __init__(self, text: str) -> None:
        self.root = json.loads(text)

    def resolve(self, node: dict) -> list[dict]:
        """The alternatives of a node, with references resolved."""
        if "$ref" in node:
            return self.resolve(self.root["definitions"][node["$ref"].rpartition("/")[2]])
        for word in ("allOf", "anyOf", "oneOf"):
            if word in node and "properties" not in node:
                return [found for item in node[word] for found in self.resolve(item)]
        return [node]

    def value(self, node: dict, rng, depth=0):
        """A random value of a node, with half of the keys of tables."""
        node = _one(self.resolve(node), rng)
        if "const" in node:
            return node["const"]
        if "enum" in node:
            return _one(node["enum"], rng)
        kind = node.get("type")
        if kind == "object":
            required = node.get("required", []) + _one(node.get("oneOf", [{}]), rng).get("required", [])
            return {
                key: self.value(inner, rng, depth + 1)
                for key, inner in node["properties"].items()
                if key in required or (depth < 5 and rng.random() < 0.5 and not inner.get("deprecated"))
            }
        if kind == "array":
            fewest, most = node.get("minItems", 0), node.get("maxItems", 3)
            count = int(rng.integers(fewest, max(most, fewest) + 1))
            return [self.value(node["items"], rng, depth + 1) for _ in range(count)]
        if kind == "boolean":
            return bool(rng.random() < 0.5)
        if kind == "integer":
            return int(rng.integers(node.get("minimum", 0), node.get("maximum", 4) + 1))
        if kind == "number":
            sign = 1 if "minimum" in node or "exclusiveMinimum" in node else rng.choice([-1, 1])
            return float(_one([0.0, 1.0, sign * 10 ** rng.uniform(-4, 3)], rng))
        return "text"

    def tables(self, tree: dict) -> list[tuple[dict, dict]]:
        """All tables of a tree with their nodes."""
        found: list[tuple[dict, dict]] = []

        def fits(value, node):
            """Whether a table has the `kind` or `type` of a node, if it is one of several."""
            if not isinstance(value, dict) or "properties" not in node:
                return True
            return all(
                value.get(key) in node["properties"][key].get("enum", [value.get(key)])
                for key in ("kind", "type")
                if key in node["properties"]
            )

        def unknown(value, node):
            """Number of keys of a table that a node does not have."""
            return len(set(value) - set(node.get("properties", ()))) if isinstance(value, dict) else 0

        def walk(value, node):
            fitting = [each for each in self.resolve(node) if fits(value, each)]
            for alternative in sorted(fitting, key=lambda each: unknown(value, each)):
                if isinstance(value, dict) and "properties" in alternative:
                    found.append((value, alternative))
                    for key, inner in list(value.items()):
                        if key in alternative["properties"]:
                            walk(inner, alternative["properties"][key])
                    return
                if isinstance(value, list) and alternative.get("type") == "array":
                    for item in value:
                        walk(item, alternative["items"])
                    return

        walk(tree, self.root)
        return found


def _one(items, rng):
    return items[int(rng.integers(len(items)))]


def places(tree) -> list[tuple]:
    """All pairs (container, key) of a tree."""
    found = []
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in items:
        found.append((tree, key))
        found += places(value)
    return found


def leaves(tree, kinds=(int, float, str)) -> list[tuple]:
    return [(inside, key) for inside, key in places(tree) if isinstance(inside[key], kinds)]


# Mutations of trees. Each modifies its tree and returns it.


def replace_number(tree, rng, schema):
    spots = leaves(tree, (int, float))
    if spots:
        inside, key = _one(spots, rng)
        inside[key] = _one(NUMBERS, rng)
    return tree


def scale_number(tree, rng, schema):
    """Scale a number by some powers of ten, which often gives a valid scene of unusual size."""
    spots = leaves(tree, float)
    if spots:
        inside, key = _one(spots, rng)
        inside[key] = float(inside[key] * 10 ** rng.normal(0, 2) * rng.choice([1, 1, 1, -1]))
    return tree


def replace_value(tree, rng, schema):
    spots = places(tree)
    if spots:
        inside, key = _one(spots, rng)
        inside[key] = copy.deepcopy(_one(OTHERS, rng))
    return tree


def add_key(tree, rng, schema):
    """Add a key that the schema has at this place, with a valid value."""
    tables = schema.tables(tree)
    if tables:
        table, node = _one(tables, rng)
        key = _one(list(node["properties"]), rng)
        table[key] = schema.value(node["properties"][key], rng)
    return tree


def remove(tree, rng, schema):
    inside, key = _one(places(tree), rng)
    del inside[key]
    return tree


def duplicate(tree, rng, schema):
    spots = [(inside, key) for inside, key in places(tree) if isinstance(inside, list)]
    if spots:
        inside, key = _one(spots, rng)
        inside[key:key] = [
            copy.deepcopy(inside[key]) for _ in range(int(_one([1, 1, 2, 10, 100, 1000], rng)))
        ]
    return tree


def misspell(tree, rng, schema):
    spots = [(inside, key) for inside, key in places(tree) if isinstance(inside, dict)]
    inside, key = _one(spots, rng)
    cut = int(rng.integers(len(key) + 1))
    inside[_one([key[:cut] + key[cut + 1 :], key.upper(), key + "\u0000", "", "a" * 1000], rng)] = inside.pop(
        key
    )
    return tree


def crowd(tree, rng, schema):
    """Add very many unknown keys."""
    inside = _one([tree, *(table for table, _ in schema.tables(tree))], rng)
    for number in range(int(_one([1, 10, 300, 3000, 20_000], rng))):
        inside[f"key_{number}"] = number
    return tree


def deepen(tree, rng, schema):
    inside, key = _one(places(tree), rng)
    depth = int(_one([1, 2, 50, 1000, 20_000], rng))
    if rng.random() < 0.5:
        inside[key] = Raw("[" * depth + "0" + "]" * depth)
    else:
        inside[key] = Raw("{a = " * depth + "0" + "}" * depth)
    return tree


def lengthen(tree, rng, schema):
    """Insert a long array, or a table with many stations."""
    inside, key = _one(places(tree), rng)
    count = int(_one([4, 100, 1000, 50_000], rng))
    numbers = [round(k / count, 9) for k in range(count)]
    vectors = Raw("[" + "[0, 0, 1], " * count + "]")
    table = {"times": numbers, "values": _one([numbers, vectors], rng)}
    stations = {"stations": numbers, "values": [0.01] * count}
    inside[key] = _one([numbers, vectors, table, stations, "x" * count], rng)
    return tree


TREE = [
    (replace_number, 5),
    (scale_number, 6),
    (replace_value, 2),
    (add_key, 6),
    (remove, 1),
    (duplicate, 1.5),
    (misspell, 0.7),
    (crowd, 0.3),
    (deepen, 0.5),
    (lengthen, 0.5),
]


#: Mutations that often keep a scene valid.
GENTLE = [(scale_number, 6), (add_key, 3), (replace_number, 1)]


def mutate_tree(tree: dict, rng, schema: Schema) -> dict:
    """Apply some mutations, or, equally often, one or two gentle ones."""
    tree = copy.deepcopy(tree)
    table, counts = (GENTLE, [1, 1, 2]) if rng.random() < 0.5 else (TREE, [1, 1, 2, 3, 6])
    weights = np.array([weight for _, weight in table])
    for _ in range(int(_one(counts, rng))):
        change = table[rng.choice(len(table), p=weights / weights.sum())][0]
        if tree:
            tree = change(tree, rng, schema)
    return tree


def mutate_text(text: bytes, rng) -> bytes:
    """Mutate bytes and lines."""
    data = bytearray(text)
    for _ in range(int(_one([1, 2, 5, 30], rng))):
        start = int(rng.integers(len(data) + 1))
        end = min(len(data), start + int(_one([1, 2, 10, 100], rng)))
        lines = bytes(data).split(b"\n")
        kind = int(rng.integers(8))
        if kind == 0 and start < len(data):
            data[start] ^= 1 << int(rng.integers(8))
        elif kind == 1:
            del data[start:end]
        elif kind == 2:
            data[start:start] = data[start:end] * int(_one([1, 2, 100], rng))
        elif kind == 3:
            data[start:start] = _one(
                [b"\x00", b"\xff", b"\xef\xbb\xbf", b"\r", b"\r\n", b'"', b"'''", b"#"], rng
            )
        elif kind == 4:
            lines.insert(int(rng.integers(len(lines))), _one(lines, rng))
            data = bytearray(b"\n".join(lines))
        elif kind == 5:
            rng.shuffle(lines)
            data = bytearray(b"\n".join(lines))
        elif kind == 6:
            del data[start:]
        else:
            data = data.replace(b"\n", b"\r\n")
    return bytes(data)
