"""Pictures of links: files of meshes that a URDF file names, and meshes of its shapes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ..common import disk
from ..model.visual_files import LARGEST, MAX_TRIANGLES, MeshRead, meshes_of

Array = NDArray[np.float64]

#: Sides of the prism that stands for a cylinder.
SIDES = 24

#: Circles of latitude of a ball, and of the ends of capsules.
RINGS = 12


class MeshRefused(Exception):
    """A file of a mesh that cannot be read."""

    def __init__(self, wrong: str, right: str) -> None:
        super().__init__(wrong)
        self.wrong, self.right = wrong, right


class Pictures:
    """The files of meshes that a URDF file in a folder names."""

    def __init__(self, folder: Path, packages: Mapping[str, Path]) -> None:
        self._folder, self._packages = folder, packages
        self._read: dict[tuple[str, tuple[float, ...]], list[MeshRead]] = {}

    def meshes(self, name: str, scale: Sequence[float]) -> list[MeshRead]:
        """The meshes of a file, read once.

        Raises
        ------
        MeshRefused
            If the file does not exist, or is none of its kind.
        ImportError
            If what reads it is not installed.
        """
        key = (name, tuple(scale))
        if key not in self._read:
            path = self._path(name)
            try:
                content = disk.read(path, LARGEST)
                self._read[key] = meshes_of(content, path.suffix, np.array(scale), MAX_TRIANGLES)
            except OSError as error:
                wrong = f"which cannot be read: {error.strerror}"
                raise MeshRefused(wrong, f"expected a file of a mesh at {path}") from None
            except ValueError as error:
                right = f"expected an STL, OBJ or COLLADA file at {path}; `visuals=False` leaves pictures out"
                raise MeshRefused(f"which {error}", right) from None
        return self._read[key]

    def _path(self, name: str) -> Path:
        scheme, separator, rest = name.partition("://")
        if not separator:
            return self._folder / name
        if scheme == "file":
            return Path(unquote(rest))
        if scheme not in ("package", "model"):
            raise MeshRefused("which is no name of a file", "expected package://, file:// or a path")
        package, _, inner = rest.partition("/")
        if package in self._packages:
            return self._packages[package] / inner
        home = self._folder.resolve()
        for folder in (home, *home.parents):
            for root in (folder,) if folder.name == package else (folder / package,):
                if (root / inner).is_file():
                    return root / inner
        raise MeshRefused(
            f'and found no folder "{package}" with this file around {home}',
            f"expected it there, or packages={{{package!r}: ...}} with the folder of the package",
        )


def solid_of(tag: str, sizes: Sequence[float]) -> tuple[Array, NDArray[np.int64]]:
    """Corners and triangles of a box, sphere, cylinder or capsule; those with an axis have it along z."""
    if tag == "box":
        half = 0.5 * np.asarray(sizes)
        signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        triangles = [face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))]
        return signs * half, np.array(triangles, np.int64)
    if tag == "cylinder":
        return prism(*sizes)
    radius, length = (sizes[0], 0.0) if tag == "sphere" else sizes
    polar = np.pi * (np.arange(RINGS) + 0.5) / RINGS
    middle = np.where(polar < 0.5 * np.pi, 0.5, -0.5) * length
    around = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([np.cos(around), np.sin(around)], axis=-1)
    corners = np.concatenate(
        [
            [[0.0, 0.0, 0.5 * length + radius], [0.0, 0.0, -0.5 * length - radius]],
            *(
                np.column_stack(
                    [radius * np.sin(angle) * ring, np.full(SIDES, place + radius * np.cos(angle))]
                )
                for angle, place in zip(polar, middle, strict=True)
            ),
        ]
    )
    k, after = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    last = 2 + (RINGS - 1) * SIDES
    faces = [
        np.stack([0 * k, 2 + k, 2 + after], axis=-1),
        np.stack([0 * k + 1, last + after, last + k], axis=-1),
    ]
    for first in range(2, last, SIDES):
        a, b, c, d = first + k, first + after, first + SIDES + k, first + SIDES + after
        faces += [np.stack([a, c, d], axis=-1), np.stack([a, d, b], axis=-1)]
    return corners, np.concatenate(faces).astype(np.int64)


def prism(radius: float, length: float) -> tuple[Array, NDArray[np.int64]]:
    """A regular prism along z with the volume of a cylinder."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    outer = radius * np.sqrt(2.0 * np.pi / (SIDES * np.sin(2.0 * np.pi / SIDES)))
    ring = np.stack([outer * np.cos(angle), outer * np.sin(angle), np.zeros(SIDES)], axis=-1)
    half = np.array([0.0, 0.0, 0.5 * length])
    k = np.arange(SIDES)
    after = (k + 1) % SIDES
    walls = [(k, after, after + SIDES), (k, after + SIDES, k + SIDES)]
    fan = np.arange(1, SIDES - 1)
    ends = [(0 * fan, fan + 1, fan), (0 * fan + SIDES, fan + SIDES, fan + 1 + SIDES)]
    faces = np.concatenate([np.stack(each, axis=-1) for each in (*walls, *ends)])
    return np.concatenate([ring - half, ring + half]), faces
