"""Motions for ParaView: one file in the format VTKHDF, which is opened as a time series.

The format is HDF5 with names defined by VTK (VTK File Formats, "VTKHDF", version 2.0, transient PolyData). It
is written by h5py, which NetCDF needs anyway. Alternatives need VTK itself, a large package for a file of
polylines, or one file per time.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..model.views import Link, view
from .runs import MAX_SHAPES, instants

if TYPE_CHECKING:
    from .._lissom import MotionResult

Array = NDArray[np.float64]

#: Kinds of cells of PolyData in the order of the format; rods are lines.
CELLS = ("Vertices", "Lines", "Polygons", "Strips")


def timeline(result: MotionResult) -> bytes:
    """The rods of a motion as polylines over time; radius, curvature, stretch, speed, link are point data."""
    if result.model is None:
        raise ValueError("result: its model is not known; it has to be one of `simulate`, not of `newmark`")
    if len(result.t) == 0:
        raise ValueError(f"result: it has no states to show; {result.message}")
    links = view(result.model).links
    if not links:
        raise ValueError("path: .vtkhdf files show rods, and this model has none")
    at = instants(len(result.t), MAX_SHAPES)
    t, q, v = result.t[at], result.q[at], result.v[at]
    points = [link.pose(q, link.stations, t)[..., :3, 3] for link in links]
    data: dict[str, list[Array]] = {name: [] for name in ("radius", "curvature", "stretch", "speed", "link")}
    for number, link in enumerate(links):
        shape = (len(at), len(link.stations))
        data["radius"].append(np.broadcast_to(_radii(link), shape))
        data["link"].append(np.full(shape, float(number)))
        if link.strain is not None:
            strain = link.strain(q, link.stations)
            data["curvature"].append(np.hypot(strain[..., 1], strain[..., 2]))
            data["stretch"].append(strain[..., 3])
        if link.velocity is not None:
            at_sections = [link.velocity(q, v, float(X), t)[..., 3:] for X in link.stations]
            data["speed"].append(np.linalg.norm(np.stack(at_sections, axis=1), axis=-1))
    whole = {name: np.concatenate(parts, axis=1) for name, parts in data.items() if len(parts) == len(links)}
    return _write(t, np.concatenate(points, axis=1), whole, [len(link.stations) for link in links])


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


def _write(t: Array, points: Array, data: dict[str, Array], counts: list[int]) -> bytes:
    import h5py

    steps, per_step = points.shape[:2]
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = (2, 0)
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        root["NumberOfPoints"] = np.full(steps, per_step)
        root["Points"] = points.reshape(-1, 3)
        # Lines do not change: all steps refer to the same ones.
        for cells in CELLS:
            group = root.create_group(cells)
            own = counts if cells == "Lines" else []
            group["NumberOfCells"] = np.full(steps, len(own))
            group["NumberOfConnectivityIds"] = np.full(steps, sum(own))
            group["Offsets"] = np.concatenate([[0], np.cumsum(own)]).astype(np.int64)
            group["Connectivity"] = np.arange(sum(own))
        fields = root.create_group("PointData")
        for name, values in data.items():
            fields[name] = values.reshape(-1)
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
        for name in data:
            offsets[name] = starts
    return content.getvalue()
