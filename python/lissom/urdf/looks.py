"""<visual> and <material>: what links look like."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from ..model.visual_files import MeshRead
from ..model.visuals import Visual
from .document import Element
from .elements import Elements
from .inertia import rotation
from .pictures import MeshRefused, Pictures, solid_of
from .reasons import NO_TEXTURE, SIMPLIFIED

#: Colour and opacity of a material, and those of a robot by name.
Material: TypeAlias = tuple[str | None, float]
Materials: TypeAlias = Mapping[str, Material]

#: Materials that cannot be seen are seen a little.
LEAST_OPACITY = 0.05


def visuals_of(
    read: Elements, element: Element, link: str, pictures: Pictures, materials: Materials
) -> list[Visual]:
    """The visuals of a <visual>: a mesh of a file, one for each of its colours, or a shape."""
    parts = read.open(element, ("name",), ("origin", "geometry", "material"))
    position, orientation = read.pose(parts.get("origin"))
    colour, opacity = colour_of(read, parts.get("material"), materials)
    found = read.geometry(element, parts.get("geometry"), ("mesh",))
    if found is None:
        return []
    tag, shape = found
    if tag is None:
        return []
    if tag == "mesh":
        meshes = _mesh(read, shape, pictures)
    else:
        sizes = read.sizes(tag, shape)
        meshes = [] if sizes is None else [MeshRead(*solid_of(tag, sizes), None, 0)]
    turn, place = rotation(orientation), np.asarray(position)
    return [
        Visual(
            link,
            mesh.points @ turn.T + place,
            mesh.faces,
            name=element.attributes.get("name") or link,
            colour=colour or mesh.colour,
            opacity=opacity,
        )
        for mesh in meshes
    ]


def _mesh(read: Elements, element: Element, pictures: Pictures) -> list[MeshRead]:
    """The meshes of a file."""
    read.open(element, ("filename", "scale"))
    name = read.text(element, "filename", "the name of a file")
    scale = read.numbers(element, "scale", (1.0, 1.0, 1.0))
    if scale is not None and 0.0 in scale:
        shown = element.attributes["scale"]
        read.problem(element, "scale", f'got "{shown}"', "expected factors other than zero")
        return []
    if name is None or scale is None:
        return []
    try:
        meshes = pictures.meshes(name, scale)
    except MeshRefused as refused:
        read.problem(element, "filename", f'got "{name}", {refused.wrong}', refused.right)
        return []
    triangles, kept = (
        sum(count) for count in ([m.triangles for m in meshes], [len(m.faces) for m in meshes])
    )
    if kept < triangles:
        read.leave(element, SIMPLIFIED.format(most=kept, triangles=triangles))
    return meshes


def colour_of(read: Elements, material: Element | None, materials: Materials) -> Material:
    """Colour and opacity of a material; one without a colour refers to one of the robot by name."""
    if material is None:
        return None, 1.0
    parts = read.open(material, ("name",), ("color", "texture"))
    if "texture" in parts:
        read.leave(parts["texture"], NO_TEXTURE)
    if "color" not in parts:
        return materials.get(material.attributes.get("name", ""), (None, 1.0))
    read.open(parts["color"], ("rgba",))
    rgba = read.numbers(parts["color"], "rgba", None, 4)
    if rgba is None:
        return None, 1.0
    if not all(0.0 <= part <= 1.0 for part in rgba):
        shown = parts["color"].attributes["rgba"]
        read.problem(parts["color"], "rgba", f'got "{shown}"', "expected four numbers from 0 to 1")
        return None, 1.0
    red, green, blue = (round(255.0 * part) for part in rgba[:3])
    return f"#{red:02x}{green:02x}{blue:02x}", max(rgba[3], LEAST_OPACITY)
