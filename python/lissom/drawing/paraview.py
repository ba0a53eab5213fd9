"""Motions for ParaView: one file in the format VTKHDF, which is opened as a time series.

The format is HDF5 with names defined by VTK (VTK File Formats, "VTKHDF", version 2.0, transient PolyData). It
is written by h5py, which NetCDF needs anyway. Alternatives need VTK itself, a large package for a file of
lines and polygons, or one file per time.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..common.extras import missing
from ..model.views import Link, view
from ..results.runs import MAX_SHAPES, instants
from .parts import STRANDS, Part, parts

if TYPE_CHECKING:
    from .._lissom import MotionResult

Array = NDArray[np.float64]
Cells = Sequence[NDArray[np.integer[Any]]]

#: Kinds of cells of PolyData in the order of the format; rods and tendons are lines.
CELLS = ("Vertices", "Lines", "Polygons", "Strips")

#: Layers by their numbers in the point data.
LAYERS = ("rods", "bodies", "tendons", "chambers", "magnets", "balls", "shapes", "obstacles")

#: Largest number of points at all times, some hundred bytes each, and smallest number of times.
MAX_POINTS, MIN_SHAPES = 1_000_000, 60


def timeline(result: MotionResult) -> bytes:
    """A motion over time: rods and tendons as polylines with point data, everything else as polygons."""
    if missing("h5py"):
        raise ImportError("files for ParaView need h5py: pip install 'lissom[files]'")
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    seen = view(result.model)
    if not seen.is_spatial:
        raise ValueError("path: .vtkhdf files show rods and bodies, and this model has none")
    # How many points a time has is known after one.
    first, _ = parts(seen, result.q[:1], result.v[:1], result.u[:1], result.t[:1])
    each = sum(len(part.centres[0] if part.layer in STRANDS else part.corners) for part in first)
    at = instants(len(result.t), min(MAX_SHAPES, max(MIN_SHAPES, MAX_POINTS // max(each, 1))))
    with np.errstate(over="ignore", invalid="ignore"):
        found, is_there = parts(seen, result.q[at], result.v[at], result.u[at], result.t[at])
    if not is_there.any():
        raise ValueError("result: none of its states is finite")
    at = at[is_there]
    t, q, v = result.t[at], result.q[at], result.v[at]
    drawn = [_of_rod(number, link, q, v, t) for number, link in enumerate(seen.links)]
    drawn += [_of_part(part, len(t)) for part in found if part.layer != "rods"]
    return _write(t, drawn)


class _Drawn:
    """Points (shapes, points, 3) with data (shapes, points), and lines or polygons between them."""

    def __init__(self, layer: str, points: Array, data: dict[str, Array], kind: str, cells: Cells) -> None:
        self.points, self.kind, self.cells = points, kind, cells
        shape = points.shape[:2]
        self.data = data | {"layer": np.full(shape, float(LAYERS.index(layer)))}


def _of_rod(number: int, link: Link, q: Array, v: Array, t: Array) -> _Drawn:
    """A rod as a line."""
    points = link.pose(q, link.stations, t)[..., :3, 3]
    shape = points.shape[:2]
    data = {"radius": np.broadcast_to(_radii(link), shape), "link": np.full(shape, float(number))}
    if link.strain is not None:
        strain = link.strain(q, link.stations)
        data |= {"curvature": np.hypot(strain[..., 1], strain[..., 2]), "stretch": strain[..., 3]}
    if link.velocity is not None:
        at_sections = [link.velocity(q, v, float(X), t)[..., 3:] for X in link.stations]
        data["speed"] = np.linalg.norm(np.stack(at_sections, axis=1), axis=-1)
    return _Drawn("rods", points, data, "Lines", [np.arange(shape[1])])


def _of_part(part: Part, shapes: int) -> _Drawn:
    """A tendon as a line, anything else as triangles."""
    if part.layer in STRANDS:
        radius = np.full(part.centres.shape[:2], np.abs(part.corners).max())
        return _Drawn(
            part.layer, part.centres, {"radius": radius}, "Lines", [np.arange(part.centres.shape[1])]
        )
    points = np.stack([part.vertices(k) for k in range(shapes)])
    return _Drawn(
        part.layer, points, {"radius": np.zeros(points.shape[:2])}, "Polygons", list(part.triangles)
    )


def _radii(link: Link) -> Array:
    """Mean of the half extents of the sections along y and z, metres."""
    ends = np.concatenate([[0.0], np.cumsum([segment.length for segment in link.segments])])
    found = []
    for X in link.stations:
        i = min(int(np.searchsorted(ends, X, side="right")) - 1, len(link.segments) - 1)
        segment = link.segments[i]
        x = min(max((X - ends[i]) / segment.length, 0.0), 1.0)
        found.append(float(np.mean(segment.section.half_extents(x))))
    return np.array(found)


def _write(t: Array, drawn: Sequence[_Drawn]) -> bytes:
    import h5py

    points = np.concatenate([each.points for each in drawn], axis=1)
    steps, per_step = points.shape[:2]
    names = dict.fromkeys(name for each in drawn for name in each.data)
    # Data of rods alone are not a number elsewhere.
    lacking = [np.full(each.points.shape[:2], np.nan) for each in drawn]
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        root["NumberOfPoints"] = np.full(steps, per_step)
        root.create_dataset("Points", data=points.reshape(-1, 3), compression="gzip")
        # Cells do not change: all steps refer to the same ones.
        for kind in CELLS:
            _write_cells(root.create_group(kind), kind, drawn, steps)
        fields = root.create_group("PointData")
        for name in names:
            values = [each.data.get(name, none) for each, none in zip(drawn, lacking, strict=True)]
            fields.create_dataset(name, data=np.concatenate(values, axis=1).reshape(-1), compression="gzip")
        times = root.create_group("Steps")
        times.attrs["NSteps"] = steps
        times["Values"] = t
        starts = np.arange(steps) * per_step
        times["PartOffsets"] = np.arange(steps)
        times["NumberOfParts"] = np.ones(steps, np.int64)
        times["PointOffsets"] = starts
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            times[name] = np.zeros((steps, len(CELLS)), np.int64)
        offsets = times.create_group("PointDataOffsets")
        for name in names:
            offsets[name] = starts
    return content.getvalue()


def _write_cells(group: Any, kind: str, drawn: Sequence[_Drawn], steps: int) -> None:
    """The cells of one kind, by the numbers of their points within a step."""
    begin = np.cumsum([0, *(each.points.shape[1] for each in drawn)])
    cells = [
        np.asarray(cell, np.int64) + start
        for each, start in zip(drawn, begin[:-1], strict=True)
        if each.kind == kind
        for cell in each.cells
    ]
    sizes = [len(cell) for cell in cells]
    group["NumberOfCells"] = np.full(steps, len(cells))
    group["NumberOfConnectivityIds"] = np.full(steps, sum(sizes))
    group["Offsets"] = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    group["Connectivity"] = np.concatenate([np.zeros(0, np.int64), *cells])
