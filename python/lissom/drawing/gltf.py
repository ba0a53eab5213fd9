"""Motions as glTF 2.0 in one binary file (.glb), which Blender, three.js and office programs read.

Rods and tendons are skins: each section is a joint of the skin, and vertices follow their section. That
is exact for rigid sections, and takes 28 bytes for a section at a time; morph targets would take 600. Bodies
and obstacles are nodes that move. Between times viewers interpolate places and rotations.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import __version__
from .parts import Part, named, normals
from .report.layers import rotations

Array = NDArray[np.float64]

#: Constants of the format (glTF 2.0, sections 3.6, 4 and 5).
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = b"glTF", 2, b"JSON", b"BIN\0"
VERTICES, INDICES = 34962, 34963
COMPONENTS = {"u1": 5121, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {(): "SCALAR", (3,): "VEC3", (4,): "VEC4", (4, 4): "MAT4"}

#: Chunks and accessors begin at multiples of this many bytes.
ALIGNED = 4

#: Largest number of vertices or joints that one and two bytes can count.
BYTE, SHORT = 1 << 8, 1 << 16

#: Axes of the world as rows: in glTF, y is up, so the axis that is up in the world turns there.
UP: dict[tuple[int, bool], list[list[float]]] = {
    (0, True): [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
    (0, False): [[0, 1, 0], [-1, 0, 0], [0, 0, 1]],
    (1, True): [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    (1, False): [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    (2, True): [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    (2, False): [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
}

#: Roughness of all surfaces, from 0 for mirrors to 1.
ROUGHNESS = 0.6


def write(parts: Sequence[Part], t: Array, up: tuple[int, bool]) -> bytes:
    """The file of parts over times (shapes,), seconds; an animation if there are several.

    `up` is the axis of the world that is up, and whether it is so along its own direction.
    """
    return _Document(parts, np.asarray(t, float), np.array(UP[up], float)).file()


class _Document:
    """The tree of the format, and the bytes that it refers to."""

    def __init__(self, parts: Sequence[Part], t: Array, turn: Array) -> None:
        self._binary: list[bytes] = []
        self._size = 0
        self._tree: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"lissom {__version__}"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"name": "lissom", "matrix": _column_major(_placed(turn)), "children": []}],
            "extras": {"start": float(t[0]), "unit": "m"},
        }
        self._channels: list[tuple[int, str, Array]] = []
        self._turn = turn
        for name, part in zip(named(parts), parts, strict=True):
            if len(part.turns[0]) == 1:
                self._rigid(name, part)
            else:
                self._skinned(name, part)
        if len(t) > 1:
            self._animate(t)

    def _add(self, kind: str, item: dict[str, Any]) -> int:
        self._tree.setdefault(kind, []).append(item)
        return len(self._tree[kind]) - 1

    def _node(self, parent: int, item: dict[str, Any]) -> int:
        number = self._add("nodes", item)
        self._tree["nodes"][parent].setdefault("children", []).append(number)
        return number

    def _rigid(self, name: str, part: Part) -> None:
        """A node with a mesh in its own axes."""
        attributes = self._shape(part.corners, part)
        mesh = self._mesh(name, part, attributes)
        self._bone(0, name, part, 0, {"mesh": mesh, "extras": {"layer": part.layer}})

    def _skinned(self, name: str, part: Part) -> None:
        """A mesh as it is in the first shape, and a node for each bone."""
        group = self._node(0, {"name": name, "extras": {"layer": part.layer}})
        count = part.turns.shape[1]
        joints = [self._bone(group, f"{name} {k}", part, k, {}) for k in range(count)]
        attributes = self._shape(part.vertices(0) @ self._turn.T, part)
        joint = np.zeros((len(part.bone), 4), "u1" if count <= BYTE else "u2")
        joint[:, 0] = part.bone
        # Each vertex follows one bone: all of the weight, in a byte.
        weights = np.zeros((len(part.bone), 4), "u1")
        weights[:, 0] = BYTE - 1
        attributes["JOINTS_0"] = self._accessor(joint, VERTICES)
        attributes["WEIGHTS_0"] = self._accessor(weights, VERTICES, normalized=True)
        mesh = self._mesh(name, part, attributes)
        inverse = np.stack([_inverse(part, k, self._turn) for k in range(count)])
        skin = {
            "joints": joints,
            "skeleton": group,
            # Columns first.
            "inverseBindMatrices": self._accessor(np.swapaxes(inverse, 1, 2).astype("f4")),
        }
        # Placed by its joints alone, so it stands beside their root.
        number = self._add(
            "nodes", {"name": f"skin of {name}", "mesh": mesh, "skin": self._add("skins", skin)}
        )
        self._tree["scenes"][0]["nodes"].append(number)

    def _bone(self, parent: int, name: str, part: Part, bone: int, more: dict[str, Any]) -> int:
        """A node with the pose of a bone, and channels for what changes."""
        places = part.centres[:, bone].astype("f4")
        # The scalar is last here.
        turns = np.roll(part.turns[:, bone], -1, axis=-1).astype("f4")
        item = {"name": name, "translation": places[0].tolist(), "rotation": turns[0].tolist(), **more}
        node = self._node(parent, item)
        for path, values in (("translation", places), ("rotation", turns)):
            if np.any(values != values[0]):
                self._channels.append((node, path, values))
        return node

    def _shape(self, vertices: Array, part: Part) -> dict[str, int]:
        points = vertices.astype("f4")
        return {
            "POSITION": self._accessor(points, VERTICES, with_range=True),
            "NORMAL": self._accessor(normals(vertices, part.triangles).astype("f4"), VERTICES),
        }

    def _mesh(self, name: str, part: Part, attributes: dict[str, int]) -> int:
        kind = "u2" if len(part.corners) < SHORT else "u4"
        primitive = {
            "attributes": attributes,
            "indices": self._accessor(part.triangles.reshape(-1).astype(kind), INDICES),
            "material": self._material(part),
        }
        return self._add("meshes", {"name": name, "primitives": [primitive]})

    def _material(self, part: Part) -> int:
        colour = {
            "pbrMetallicRoughness": {
                "baseColorFactor": [*linear(part.colour), part.opacity],
                "metallicFactor": 0.0,
                "roughnessFactor": ROUGHNESS,
            },
            "name": part.layer,
            **({"alphaMode": "BLEND"} if part.opacity < 1.0 else {}),
            **({"doubleSided": True} if part.is_open else {}),
        }
        known: list[Any] = self._tree.get("materials", [])
        return known.index(colour) if colour in known else self._add("materials", colour)

    def _animate(self, t: Array) -> None:
        """One animation with all channels; its time begins at zero, as the format demands."""
        if not self._channels:
            return
        times = self._accessor((t - t[0]).astype("f4"), with_range=True)
        outputs = self._accessors([values for _, _, values in self._channels])
        self._tree["animations"] = [
            {
                "name": "motion",
                "samplers": [{"input": times, "output": output} for output in outputs],
                "channels": [
                    {"sampler": k, "target": {"node": node, "path": path}}
                    for k, (node, path, _) in enumerate(self._channels)
                ],
            }
        ]

    def _accessor(
        self,
        values: NDArray[Any],
        target: int | None = None,
        *,
        normalized: bool = False,
        with_range: bool = False,
    ) -> int:
        """Numbers in a view of their own."""
        number = self._accessors([values], target)[0]
        found = self._tree["accessors"][number]
        if normalized:
            found["normalized"] = True
        if with_range:
            flat = values.reshape(len(values), -1)
            found["min"], found["max"] = flat.min(axis=0).tolist(), flat.max(axis=0).tolist()
        return number

    def _accessors(self, arrays: Sequence[NDArray[Any]], target: int | None = None) -> list[int]:
        """Numbers in one view."""
        start, found = self._size, []
        view = len(self._tree.get("bufferViews", []))
        for values in arrays:
            item = {
                "bufferView": view,
                "byteOffset": self._size - start,
                "componentType": COMPONENTS[values.dtype.str[1:]],
                "count": len(values),
                "type": TYPES[values.shape[1:]],
            }
            found.append(self._add("accessors", item))
            content = values.astype(values.dtype.newbyteorder("<")).tobytes()
            content += bytes(-len(content) % ALIGNED)
            self._binary.append(content)
            self._size += len(content)
        given = {"buffer": 0, "byteOffset": start, "byteLength": self._size - start}
        self._add("bufferViews", given if target is None else given | {"target": target})
        return found

    def file(self) -> bytes:
        """The header, the tree and the bytes."""
        self._tree["buffers"] = [{"byteLength": self._size}]
        text = json.dumps(self._tree, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()
        text += b" " * (-len(text) % ALIGNED)
        binary = b"".join(self._binary)
        chunks = b"".join(
            struct.pack("<I4s", len(content), kind) + content
            for content, kind in ((text, JSON_CHUNK), (binary, BINARY_CHUNK))
        )
        head = struct.calcsize("<4sII")
        return struct.pack("<4sII", MAGIC, VERSION, head + len(chunks)) + chunks


def _placed(turn: Array, place: Array | None = None) -> Array:
    pose = np.eye(4)
    pose[:3, :3] = turn
    if place is not None:
        pose[:3, 3] = place
    return pose


def _inverse(part: Part, bone: int, turn: Array) -> Array:
    """From the file's axes to those of a bone in the first shape."""
    own = turn @ rotations(part.turns[0, bone])
    return _placed(own.T, -own.T @ turn @ part.centres[0, bone])


def _column_major(matrix: Array) -> list[float]:
    return [float(value) for value in matrix.T.reshape(-1)]


def linear(colour: str) -> list[float]:
    """Red, green and blue of a hexadecimal colour as intensities (IEC 61966-2-1, sRGB)."""
    parts = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return [round(float(value), 6) for value in linear]
