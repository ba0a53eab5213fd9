"""Visuals from files of meshes: STL, OBJ and COLLADA, read by trimesh (extra `meshes`)."""

from __future__ import annotations

import io
import os
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..common import disk
from ..common.arguments import number, path_of, suggesting, text, vector, whole
from ..common.extras import missing
from .glyphs.contacts import turn_of
from .visuals import Visual, simplified

Array = NDArray[np.float64]

#: Suffixes of files that are read, and the modules that read them.
SUFFIXES = {".stl": ("trimesh",), ".obj": ("trimesh",), ".dae": ("trimesh", "collada")}

#: Largest file, bytes: an STL file of a million triangles has 50 MB.
LARGEST = 64 * 2**20

#: Largest number of triangles that is kept of a file unless said otherwise: about 50 kB of a report.
MAX_TRIANGLES = 5000

#: Largest distance of a corner from the origin along an axis, metres: beyond it is a mistake of units.
FARTHEST = 1e9

#: Bytes of a binary STL file before its triangles, of which the last four are their number, and of each
#: triangle.
_STL_HEAD, _STL_TRIANGLE = 84, 50

#: Quaternions are often rounded; the norm may differ from one by this much, as for a `Link`.
_QUATERNION_TOLERANCE = 1e-3


@dataclass(frozen=True)
class MeshRead:
    """A mesh of one colour, as far as the file has one."""

    points: Array
    faces: NDArray[np.int64]
    colour: str | None
    #: Number of triangles in the file.
    triangles: int


@suggesting
def read_visuals(
    path: str | os.PathLike[str],
    link: str,
    *,
    scale: float = 1.0,
    position: ArrayLike = (0.0, 0.0, 0.0),
    orientation: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    colour: str | None = None,
    opacity: float = 1.0,
    max_triangles: int = MAX_TRIANGLES,
) -> list[Visual]:
    """Read a file of meshes as visuals of a link: STL, OBJ or COLLADA (extra `meshes`).

    Parameters
    ----------
    path : path-like
        ``.stl``, ``.obj`` or ``.dae``, at most 64 MiB. Other files that it names, such as textures, are not
        opened.
    link : str
        The link that carries the mesh.
    scale : float
        Length of a unit of the file, metres: 1e-3 for millimetres. COLLADA files say their unit; then it is a
        factor beside.
    position : array_like, shape (3,)
        Origin of the mesh in the frame of the link, metres.
    orientation : array_like, shape (4,)
        Quaternion (w, x, y, z) from the axes of the mesh to those of the link.
    colour : str, optional
        A hexadecimal colour such as ``"#8090a0"``; by default that of the file, if it has one.
    opacity : float
        From above 0 to 1.
    max_triangles : int
        A larger mesh is simplified: corners in the same cell of a grid become their mean.

    Returns
    -------
    visuals : list of Visual
        One for each colour of the file.

    Raises
    ------
    ValueError, TypeError
        If an argument is invalid, or the file is none of its kind or has no triangles.
    OSError
        If the file cannot be read, or is too large.
    ImportError
        If trimesh, or for COLLADA pycollada, is not installed.
    """
    file = path_of(path)
    factor = number("scale", scale)
    if not (np.isfinite(factor) and factor > 0.0):
        raise ValueError(
            f"scale: got {factor:g}, expected a finite number above zero: metres per unit of the file"
        )
    place, turn = vector("position", position, 3), vector("orientation", orientation, 4)
    norm = float(np.linalg.norm(turn))
    if not abs(norm - 1.0) <= _QUATERNION_TOLERANCE:
        raise ValueError(f"orientation: got a quaternion of norm {norm:.6g}, expected (w, x, y, z) of norm 1")
    most = whole("max_triangles", max_triangles)
    if most < 1:
        raise ValueError(f"max_triangles: got {most}, expected at least 1")
    try:
        found = meshes_of(disk.read(file, LARGEST), file.suffix, factor * np.ones(3), most)
    except ValueError as error:
        raise ValueError(f"path: {file.name!r} {error}") from None
    rotation = turn_of((turn / norm).tolist())
    return [
        Visual(
            link,
            each.points @ rotation.T + place,
            each.faces,
            name=file.stem,
            colour=each.colour if colour is None else colour,
            opacity=opacity,
        )
        for each in found
    ]


def meshes_of(content: bytes, suffix: str, scale: Array, most: int) -> list[MeshRead]:
    """The meshes in the content of a file, in metres, one for each colour, with so many triangles at most.

    Messages continue a sentence that begins with the name of the file.

    Raises
    ------
    ValueError
        If the content is none of its kind, or has no triangles.
    ImportError
        If what reads it is not installed.
    """
    kind = suffix.lower()
    if kind not in SUFFIXES:
        known = ", ".join(SUFFIXES)
        raise ValueError(f"ends with {text('suffix', suffix) or 'nothing'}, expected one of {known}")
    if lacking := missing(*SUFFIXES[kind]):
        raise ImportError(f"{kind} files need {' and '.join(lacking)}: pip install 'lissom[meshes]'")
    _refuse_no_mesh(content, kind)
    by_colour: dict[str | None, list[tuple[Array, NDArray[np.int64]]]] = {}
    for points, faces, colour in _loaded(content, kind):
        by_colour.setdefault(colour, []).append((points * scale, faces))
    found, triangles = [], sum(len(faces) for each in by_colour.values() for _, faces in each)
    if not triangles:
        raise ValueError("has no triangles with finite corners")
    for colour, several in by_colour.items():
        starts = np.cumsum([0, *(len(points) for points, _ in several)])
        points = np.concatenate([points for points, _ in several])
        faces = np.concatenate([faces + start for (_, faces), start in zip(several, starts, strict=False)])
        _refuse_far(points[faces])
        if np.prod(scale) < 0.0:
            # Mirrored: the outside stays outside.
            faces = faces[:, ::-1]
        share = max(most * len(faces) // triangles, 1)
        found.append(MeshRead(*simplified(points, faces, share), colour, len(faces)))
    return [each for each in found if len(each.faces)]


def _refuse_no_mesh(content: bytes, kind: str) -> None:
    """Raise where a file is what often stands in the place of a mesh."""
    if not content.strip(b"\0 \t\r\n"):
        raise ValueError("is empty")
    if content.startswith(b"version https://git-lfs"):
        raise ValueError("is a pointer of Git LFS in place of the mesh, which `git lfs pull` fetches")
    if kind == ".stl" and not content.lstrip().startswith(b"solid") and len(content) >= _STL_HEAD:
        (announced,) = struct.unpack_from("<I", content, _STL_HEAD - 4)
        whole_ones = (len(content) - _STL_HEAD) // _STL_TRIANGLE
        if whole_ones < announced:
            raise ValueError(
                f"is no STL file or is cut off: it has room for {whole_ones} triangles, its head says "
                f"{announced}"
            )


def _refuse_far(corners: Array) -> None:
    """Raise for corners at which nothing can be drawn."""
    if not np.isfinite(corners).all():
        raise ValueError("has corners that are not finite")
    farthest = float(np.abs(corners).max())
    if farthest > FARTHEST:
        raise ValueError(
            f"has a corner {farthest:.3g} m from its origin, expected at most {FARTHEST:g} m; `scale` is the "
            "length of its unit in metres"
        )


def _loaded(content: bytes, kind: str) -> list[tuple[Array, NDArray[np.int64], str | None]]:
    """Corners in metres where the file says its unit, triangles and colour of each mesh of a file."""
    if kind == ".dae" and (content[:2] == b"PK" or b"<!ENTITY" in content):
        raise ValueError("is an archive or declares entities, expected plain COLLADA")
    import trimesh

    try:
        # Without a resolver no other file is opened. Corners that overflow are refused later.
        with np.errstate(all="ignore"):
            scene: Any = trimesh.load_scene(io.BytesIO(content), file_type=kind[1:])
        found = []
        for node in scene.graph.nodes_geometry:
            pose, name = scene.graph[node]
            mesh = scene.geometry[name]
            if not isinstance(mesh, trimesh.Trimesh):
                continue
            points = np.asarray(mesh.vertices, float) @ pose[:3, :3].T + pose[:3, 3]
            faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
            if np.linalg.det(pose[:3, :3]) < 0.0:
                faces = faces[:, ::-1]
            unit = (
                trimesh.units.unit_conversion(mesh.units, "meters") if kind == ".dae" and mesh.units else 1.0
            )
            found.append((points * unit, faces, _colour(mesh)))
    except IndexError:
        raise ValueError(
            f"is a damaged {kind[1:].upper()} file: a triangle names a corner that is missing"
        ) from None
    # Whatever a damaged file makes of the readers.
    except Exception as error:
        shown = " ".join(str(error).split())[:200]
        raise ValueError(
            f"is no {kind[1:].upper()} file that can be read: {shown or type(error).__name__}"
        ) from None
    return found


def _colour(mesh: Any) -> str | None:
    """The colour that a file gives to a whole mesh."""
    material = getattr(mesh.visual, "material", None)
    given = getattr(material, "baseColorFactor", None)
    if given is None:
        return None
    red, green, blue = (int(part) for part in given[:3])
    return f"#{red:02x}{green:02x}{blue:02x}"
