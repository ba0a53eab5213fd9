"""Motions in Universal Scene Description (.usd, .usda, .usdc), for Blender, Houdini, Omniverse and others.

Bodies are meshes that move; rods and tendons are meshes whose points move with their sections. Needs the
package `pxr` of OpenUSD.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._lissom import __version__
from ..common.extras import missing
from .gltf import ROUGHNESS, UP, linear
from .parts import Part, named, normals

Array = NDArray[np.float64]

#: Time codes per second; samples lie between them where the times of a motion do.
RATE = 60.0

#: Name of the root of all parts, and of the group of materials.
ROOT, MATERIALS = "/lissom", "/lissom/materials"

SUFFIXES = (".usd", ".usda", ".usdc")


def write(parts: Sequence[Part], t: Array, up: tuple[int, bool], suffix: str) -> bytes:
    """The file of parts over times (shapes,), seconds; with samples over time if there are several.

    `up` is the axis of the world that is up, and whether it is so along its own direction.

    Raises
    ------
    ImportError
        Without OpenUSD.
    """
    if missing("pxr"):
        raise ImportError(f"{suffix} files need OpenUSD: pip install 'lissom[usd]'")
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    _Document(stage, np.asarray(t, float), up).add(parts)
    if suffix == ".usda":
        return str(stage.GetRootLayer().ExportToString()).encode()
    # Binary layers are exported to files only.
    with tempfile.TemporaryDirectory(prefix="lissom-") as folder:
        path = Path(folder) / f"stage{suffix}"
        stage.GetRootLayer().Export(str(path))
        return path.read_bytes()


class _Document:
    """A stage to which parts are added."""

    def __init__(self, stage: Any, t: Array, up: tuple[int, bool]) -> None:
        from pxr import Gf, UsdGeom

        self._stage = stage
        #: Time codes of the shapes; None for files of one instant.
        self._codes = ((t - t[0]) * RATE).tolist() if len(t) > 1 else None
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        # USD knows y and z as upwards: other axes are turned to y, as in glTF.
        is_z = up == (2, True)
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z if is_z else UsdGeom.Tokens.y)
        root = UsdGeom.Xform.Define(stage, ROOT)
        if not is_z:
            turn = np.eye(4)
            # Rows are vectors in USD.
            turn[:3, :3] = np.array(UP[up], float).T
            root.AddTransformOp().Set(Gf.Matrix4d(turn.tolist()))
        stage.SetDefaultPrim(root.GetPrim())
        stage.GetRootLayer().comment = f"lissom {__version__}, starts at {t[0]:.17g} s"
        if self._codes is not None:
            stage.SetTimeCodesPerSecond(RATE)
            stage.SetFramesPerSecond(RATE)
            stage.SetStartTimeCode(0.0)
            stage.SetEndTimeCode(self._codes[-1])
        self._materials: dict[tuple[str, str, float], Any] = {}

    def add(self, parts: Sequence[Part]) -> None:
        """Each part as a mesh; the names that USD does not allow remain as names to display."""
        from pxr import Tf

        used = {"materials"}
        for name, part in zip(named(parts), parts, strict=True):
            own = base = Tf.MakeValidIdentifier(name)
            count = 1
            while own in used:
                count += 1
                own = f"{base}_{count}"
            used.add(own)
            self._mesh(f"{ROOT}/{own}", name, part)

    def _mesh(self, path: str, name: str, part: Part) -> None:
        from pxr import Gf, UsdGeom, UsdShade, Vt

        mesh = UsdGeom.Mesh.Define(self._stage, path)
        mesh.GetPrim().SetDisplayName(name)
        mesh.CreateFaceVertexCountsAttr([3] * len(part.triangles))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(part.triangles.reshape(-1).astype(np.int32)))
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(part.is_open)
        mesh.CreateDisplayColorAttr([Gf.Vec3f(*linear(part.colour))])
        mesh.CreateDisplayOpacityAttr([part.opacity])
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        if len(part.turns[0]) == 1:
            self._place(mesh, part)
            shapes = [part.corners]
        else:
            shapes = [part.vertices(k) for k in range(len(part.centres))]
        points, across = mesh.CreatePointsAttr(), mesh.CreateNormalsAttr()
        self._sample(points, [_vectors(each) for each in shapes])
        self._sample(across, [_vectors(normals(each, part.triangles)) for each in shapes])
        self._sample(
            mesh.CreateExtentAttr(),
            [_vectors(np.stack([each.min(axis=0), each.max(axis=0)])) for each in shapes],
        )
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(self._material(part))

    def _place(self, mesh: Any, part: Part) -> None:
        """A rigid part: its place and rotation over time."""
        from pxr import Gf, UsdGeom

        places = [Gf.Vec3d(*place.tolist()) for place in part.centres[:, 0]]
        turns = [Gf.Quatf(*turn.tolist()) for turn in part.turns[:, 0]]
        self._sample(mesh.AddTranslateOp().GetAttr(), places)
        self._sample(mesh.AddOrientOp(UsdGeom.XformOp.PrecisionFloat).GetAttr(), turns)

    def _sample(self, attribute: Any, values: Sequence[Any]) -> None:
        """One value, or one for each time."""
        if self._codes is None or all(value == values[0] for value in values):
            attribute.Set(values[0])
            return
        for code, value in zip(self._codes, values, strict=True):
            attribute.Set(value, code)

    def _material(self, part: Part) -> Any:
        from pxr import Gf, Sdf, UsdShade

        key = (part.layer, part.colour, part.opacity)
        if key not in self._materials:
            path = f"{MATERIALS}/{part.layer}_{len(self._materials)}"
            material = UsdShade.Material.Define(self._stage, path)
            shader = UsdShade.Shader.Define(self._stage, f"{path}/surface")
            shader.CreateIdAttr("UsdPreviewSurface")
            colour = Gf.Vec3f(*linear(part.colour))
            shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(colour)
            shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(part.opacity)
            shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(ROUGHNESS)
            material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
            self._materials[key] = material
        return self._materials[key]


def _vectors(values: Array) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))
