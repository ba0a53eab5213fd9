"""Results as meshes: motions as glTF or USD with an animation, single instants also as PLY or OBJ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import Model, MotionResult, StaticsResult, __version__
from ..analysis.between import state_at
from ..common.arguments import number
from ..model.views import View, drawn
from ..model.visuals import Visual
from ..results.runs import Made
from ..results.studies import setting_for
from . import gltf, usd
from .parts import Part, named, normals, parts
from .report import motion, symbols

Array = NDArray[np.float64]

#: Parts and the direction that is up to bytes, for files of one instant.
Writer = Callable[[list[Part], Array, tuple[int, bool]], bytes]


def of_motion(result: MotionResult, suffix: str, t: float | None, visuals: Sequence[Visual] = ()) -> bytes:
    """The file of a motion, or of its state at a time."""
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    seen = _with_parts(result.model, suffix, visuals)
    if t is None:
        if suffix not in MOVING:
            raise ValueError(f"t: {suffix} files show one instant; give its time in seconds, such as `t=0.5`")
        run = Made(result, result.model, visuals)
        at = motion.frames(run)
        return _file(suffix, seen, result.q[at], result.v[at], result.u[at], result.t[at])
    t = number("t", t)
    if not result.t[0] <= t <= result.t[-1]:
        raise ValueError(f"t: {t:g} s is not within the motion, from {result.t[0]:g} to {result.t[-1]:g} s")
    q, v = state_at(result, t)
    before = max(int(np.searchsorted(result.t, t, side="right")) - 1, 0)
    return _file(suffix, seen, q[None], v[None], result.u[before, None], np.array([t]))


def of_statics(
    result: StaticsResult, suffix: str, model: Model | None, t: float | None, visuals: Sequence[Visual] = ()
) -> bytes:
    """The file of an equilibrium."""
    if model is None:
        raise ValueError(f"model: {suffix} files show the model, which the result does not keep; pass it")
    setting = setting_for(result, model, t)
    seen = _with_parts(model, suffix, visuals)
    at, rest = np.array([setting.t]), np.zeros_like(result.q)
    return _file(suffix, seen, result.q[None], rest[None], np.asarray(setting.u)[None], at)


def _with_parts(model: Model, suffix: str, visuals: Sequence[Visual]) -> View:
    seen = drawn(model, visuals)
    if not seen.is_spatial:
        raise ValueError(f"path: {suffix} files show rods and bodies, and this model has none")
    return seen


def _file(suffix: str, seen: View, q: Array, v: Array, u: Array, t: Array) -> bytes:
    with np.errstate(over="ignore", invalid="ignore"):
        # The last state of a failed run can overflow.
        found, is_there = parts(seen, q, v, u, t)
    if not is_there.any():
        raise ValueError("result: none of its states is finite")
    axis, _, is_up = symbols.floor(seen.glyphs.gravity, np.zeros(3), np.zeros(3))
    return WRITERS[suffix](found, t[is_there], (axis, is_up))


def ply(found: list[Part], t: Array, up: tuple[int, bool]) -> bytes:
    """All parts of the first shape as one mesh with colours, binary."""
    vertices, triangles, of_vertices, colours = [], [], [], []
    count = 0
    for part in found:
        points = part.vertices(0)
        vertices.append(points)
        of_vertices.append(normals(points, part.triangles))
        triangles.append(part.triangles + np.uint32(count))
        colour = part.colour
        colours += [[int(colour[i : i + 2], 16) for i in (1, 3, 5)]] * len(points)
        count += len(points)
    row = np.dtype([("point", "<f8", 3), ("normal", "<f4", 3), ("colour", "u1", 3)])
    rows = np.empty(count, row)
    rows["point"], rows["normal"] = np.concatenate(vertices), np.concatenate(of_vertices)
    rows["colour"] = np.array(colours)
    corners = np.concatenate(triangles)
    faces = np.empty(len(corners), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, corners
    head = [
        "ply",
        "format binary_little_endian 1.0",
        f"comment lissom {__version__}, metres, t = {t[0]:.17g} s",
        f"element vertex {count}",
        *(f"property double {name}" for name in "xyz"),
        *(f"property float n{name}" for name in "xyz"),
        *(f"property uchar {name}" for name in ("red", "green", "blue")),
        f"element face {len(faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    return "\n".join([*head, ""]).encode() + rows.tobytes() + faces.tobytes()


def obj(found: list[Part], t: Array, up: tuple[int, bool]) -> bytes:
    """Each part of the first shape as an object with its name."""
    lines = [f"# lissom {__version__}, metres, t = {t[0]:.17g} s"]
    first = 1
    for name, part in zip(named(found), found, strict=True):
        points = part.vertices(0)
        lines.append(f"o {name.replace(' ', '_')}")
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
        lines += [f"vn {x:.6f} {y:.6f} {z:.6f}" for x, y, z in normals(points, part.triangles)]
        lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in part.triangles.astype(int) + first]
        first += len(points)
    return "\n".join([*lines, ""]).encode()


WRITERS: dict[str, Writer] = {
    ".glb": gltf.write,
    **{suffix: partial(usd.write, suffix=suffix) for suffix in usd.SUFFIXES},
    ".ply": ply,
    ".obj": obj,
}

#: Suffixes of files that have animations.
MOVING = (".glb", *usd.SUFFIXES)


def motion_writers(t: float | None, visuals: Sequence[Visual] = ()) -> dict[str, Callable[[Any, Any], bytes]]:
    """For `results.io.save`: what writes a motion, by the suffix of the file."""
    return {
        suffix: lambda result, model, suffix=suffix: of_motion(result, suffix, t, visuals)  # type: ignore[misc]
        for suffix in WRITERS
    }


def statics_writers(
    t: float | None, visuals: Sequence[Visual] = ()
) -> dict[str, Callable[[Any, Any], bytes]]:
    """For `results.io.save`: what writes an equilibrium, by the suffix of the file."""
    return {
        suffix: lambda result, model, suffix=suffix: of_statics(result, suffix, model, t, visuals)  # type: ignore[misc]
        for suffix in WRITERS
    }
