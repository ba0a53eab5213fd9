"""Objects drawn at one time of a motion: the same as in reports, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...model import fibres
from ...model.views import View
from ..report import contacts, layers, quantities, solids, symbols, visuals
from ..report import motion as drawing
from ..report.layers import DrawnStates, Largest, Mesh, Thing, Tube, quaternions

Array = NDArray[np.float64]

#: Margins around a model, relative to its reach: for clamped models, and for models that can move away.
ROOM, FREE_ROOM = 0.1, 0.5

#: Size of the scene for a mass on a line, relative to the initial length of the line.
SWING = 1.3


@dataclass(frozen=True)
class Stage:
    """The region in which a model moves: its bounding box, and static objects."""

    low: Array
    high: Array
    #: View direction.
    eye: Array
    #: Axis perpendicular to the ground, its position, and whether up is along the axis.
    ground: tuple[int, float, bool]
    around: list[Thing]

    @property
    def size(self) -> float:
        """Length of the diagonal, metres."""
        return float(np.linalg.norm(self.high - self.low))


#: Name of the quantity for colours: positions on the colour scale, from 0 to 1.
SHADE = "shade"


class Shape:
    """Draws a model shape by shape, with scales that follow from all shapes drawn so far."""

    #: Quantity of `quantities` for the colours of rods; None colours by the position along them.
    colour: str | None = None

    def __init__(self, view: View, q: Array, v: Array, t: float, u: Array) -> None:
        self.view = view
        self._largest = Largest()
        self._tubes: list[Tube] = []
        self._meshes: list[Mesh] | None = None
        if view.is_spatial:
            # Sections are the same in all shapes.
            self._tubes = [
                replace(tube, quantities={})
                for tube in drawing.tubes(view, q[None], v[None], np.array([t]), u[None])
            ]
            self._radius, self._half_axis = drawing.widest(view), drawing.half_axis(view, view.size)
        self._at = [fibres.segments(link, link.stations) for link in view.links]
        self._half = [
            solids.sections(link, at, 0.0)[0] for link, at in zip(view.links, self._at, strict=True)
        ]
        self._reach = view.size
        if view.sketch is not None:
            self._reach = SWING * float(np.linalg.norm(view.sketch.mass(q[None]))) or 1.0
        self.stage = self._stage(q, v, t, u)

    def _stage(self, q: Array, v: Array, t: float, u: Array) -> Stage:
        # Contacts are drawn within the box, which is not known yet.
        self._box = (np.full(3, -self._reach), np.full(3, self._reach))
        low, high = self._box
        if not self.view.is_spatial:
            return Stage(low, high, np.array([0.0, 0.0, 1.0]), (1, float(low[1]), True), [])
        drawn = self.things(q, v, t, u)
        low, high = layers.extent([thing for thing in drawn if thing.layer != "obstacles"])
        # A model that hangs or swings stays around its start.
        room = (ROOM if self.view.glyphs.clamps else FREE_ROOM) * self.view.size
        low, high = drawing.box(low, high, room)
        # Half spaces are drawn within the box.
        self._box = (low, high)
        low, high = layers.extent(self.things(q, v, t, u))
        low, high = np.minimum(low, self._box[0]), np.maximum(high, self._box[1])
        eye = drawing.eye_of(high - low)
        around = symbols.around(self.view.glyphs, low, high, eye)
        return Stage(low, high, eye, symbols.floor(self.view.glyphs.gravity, low, high), around)

    def things(self, q: Array, v: Array, t: float, u: Array) -> list[Thing]:
        """All objects of the model in this shape."""
        if self.view.sketch is not None and not self.view.is_spatial:
            return drawing.in_plane(self.view.sketch, q[None], self._reach)
        if not self.view.is_spatial:
            return []
        at, one = np.array([t]), np.ones(1)
        shown = DrawnStates(
            q[None], v[None], u[None], at, one, self.view.size, self._radius, self._half_axis, self._largest
        )
        bodies = drawing.bodies(self.view, q[None], at)
        return [
            *self._shaded([self._moved(i, q, at) for i in range(len(self._tubes))], q, v, at, u),
            *bodies,
            *self._visuals(q, at),
            *symbols.symbols(self.view.glyphs, shown),
            *contacts.contacts(self.view.glyphs.contacts, shown, *self._box, bodies),
        ]

    def _visuals(self, q: Array, t: Array) -> list[Mesh]:
        """Visuals, with corners and normals that are found once."""
        if self._meshes is None:
            self._meshes = visuals.meshes(self.view.visuals, q[None], t)
        return [
            visuals.moved(mesh, carried, q[None], t)
            for mesh, carried in zip(self._meshes, self.view.visuals, strict=True)
        ]

    def _moved(self, number: int, q: Array, t: Array) -> Tube:
        link = self.view.links[number]
        poses = link.pose(q[None], link.stations, t)
        return replace(self._tubes[number], centres=poses[..., :3, 3], turns=quaternions(poses[..., :3, :3]))

    @property
    def colours(self) -> list[str]:
        """Quantities available for the colours of the model's rods."""
        links = self.view.links
        has_moduli = any(all(part.young_modulus is not None for part in link.segments) for link in links)
        has_strain = any(link.strain is not None for link in links)
        is_there = {
            quantities.CURVATURE: has_strain,
            quantities.STRESS: has_strain and has_moduli,
            quantities.SPEED: any(link.velocity is not None for link in links),
        }
        return [name for name, there in is_there.items() if there]

    @property
    def largest(self) -> float:
        """End of the colour scale: the largest value so far."""
        return 0.0 if self.colour is None else float(self._largest.of(self.colour, 0.0))

    def _shaded(self, tubes: list[Tube], q: Array, v: Array, t: Array, u: Array) -> list[Tube]:
        """Tubes with their positions on the colour scale."""
        if self.colour is None:
            return tubes
        values = [
            # Models at rest have no speeds, and given sections no stress.
            quantities.along(link, q[None], v[None], t, u[None], half, at).get(
                self.colour, np.zeros((1, len(link.stations)))
            )
            for link, half, at in zip(self.view.links, self._half, self._at, strict=True)
        ]
        largest = float(self._largest.of(self.colour, max(float(each.max()) for each in values)))
        return [
            replace(tube, quantities={SHADE: each / (largest or 1.0)})
            for tube, each in zip(tubes, values, strict=True)
        ]
