"""Drawing with viser: each object is a node of the scene, which moves from frame to frame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from .. import meshes
from ..report import theme
from ..report.layers import Arrows, Dots, Line, Mesh, Solid, Strand, Thing, Tube, rotations
from ..report.symbols import LEGEND
from .shape import SHADE, Stage

Array = NDArray[np.float64]

#: Vertical field of view in radians, and camera distance relative to the smallest one that shows everything.
FIELD, DISTANCE = 0.7, 1.1

#: Width of lines, pixels.
LINE = 2.0

#: Ground planes by the axis perpendicular to them.
PLANES = ("yz", "xz", "xy")


class Canvas:
    """The scene of a server."""

    def __init__(self, server: viser.ViserServer, stage: Stage) -> None:
        self._scene = server.scene
        #: Nodes by name, and the objects that they show.
        self._nodes: dict[str, Any] = {}
        self._shown: dict[str, list[Array]] = {}
        self._colours: dict[str, str] = {}
        self._skins: dict[str, meshes.TubeSkin] = {}
        self._names: Counter[str] = Counter()
        self._begin(server, stage)

    def _begin(self, server: viser.ViserServer, stage: Stage) -> None:
        axis, place, is_up = stage.ground
        up = np.zeros(3)
        up[axis] = 1.0 if is_up else -1.0
        self._scene.set_up_direction(up)
        centre = 0.5 * (stage.low + stage.high)
        away = DISTANCE * 0.5 * stage.size / np.tan(0.5 * FIELD)
        camera = server.initial_camera
        camera.fov = FIELD
        camera.near, camera.far = 1e-3 * stage.size, 1e3 * stage.size
        camera.up = up
        camera.look_at = centre
        camera.position = centre + away * stage.eye / np.linalg.norm(stage.eye)
        on_ground = centre.copy()
        on_ground[axis] = place
        cell = 10.0 ** np.floor(np.log10(stage.size)) / 5.0
        self._scene.add_grid(
            "/floor",
            plane=PLANES[axis],  # type: ignore[arg-type]
            infinite_grid=True,
            cell_size=cell,
            section_size=5.0 * cell,
            fade_distance=4.0 * stage.size,
            position=on_ground,
        )
        self.draw(stage.around)
        # Static objects remain.
        self._nodes.clear()

    def draw(self, things: Sequence[Thing]) -> None:
        """Show exactly these objects, each in its first shape."""
        self._names.clear()
        seen: set[str] = set()
        for thing in things:
            name = self._name(thing)
            match thing:
                case Tube():
                    seen |= self._tube(name, thing)
                case Solid():
                    seen |= self._solid(name, thing)
                case Mesh():
                    seen |= self._visual(name, thing)
                case Strand():
                    seen |= self._strand(name, thing)
                case Arrows():
                    seen |= self._arrows(name, thing)
                case Dots():
                    seen |= self._dots(name, thing)
                case Line():
                    seen |= self._line(name, thing)
        for name, node in self._nodes.items():
            if node.visible != (name in seen):
                node.visible = name in seen

    def _name(self, thing: Thing) -> str:
        """A unique name in the tree of nodes."""
        name = f"/{thing.layer}/{thing.name.partition(',')[0].replace('/', '-')}"
        self._names[name] += 1
        return name if self._names[name] == 1 else f"{name} ({self._names[name]})"

    def _is_new(self, name: str, *values: Array) -> bool:
        """Whether the values of a node have changed; remembers them."""
        old = self._shown.get(name)
        self._shown[name] = list(values)
        return old is None or not all(map(np.array_equal, old, values))

    def _tube(self, name: str, thing: Tube) -> set[str]:
        turns = rotations(thing.turns[0])
        if not (np.isfinite(thing.centres[0]).all() and np.isfinite(turns).all()):
            return set()
        skin = self._skins.get(name)
        if skin is None:
            skin = self._skins[name] = meshes.TubeSkin(thing)
        shade = thing.quantities.get(SHADE)
        colours = theme.sample(theme.ROD_SCALE, skin.middles if shade is None else skin.means(shade[0]))
        opacity = _translucent(thing.opacity)
        seen = set()
        for i, vertices in enumerate(skin.vertices(thing.centres[0], turns)):
            of_band = f"{name}/{i + 1}"
            seen.add(of_band)
            self._mesh(of_band, vertices, skin.triangles[i], colours[i], opacity)
        return seen

    def _strand(self, name: str, thing: Strand) -> set[str]:
        vertices, triangles = meshes.strand(thing)
        if len(vertices) == 0:
            return set()
        self._mesh(name, vertices, triangles, LEGEND[thing.layer], _translucent(thing.opacity))
        return {name}

    def _mesh(
        self, name: str, vertices: Array, triangles: meshes.Triangles, colour: str, opacity: float | None
    ) -> None:
        node = self._nodes.get(name)
        if node is not None and self._colours[name] != colour:
            node.color = _rgb(colour)
        self._colours[name] = colour
        if not self._is_new(name, vertices):
            return
        if node is None or node.faces.shape != triangles.shape:
            self._nodes[name] = self._scene.add_mesh_simple(
                name, vertices, triangles, color=_rgb(colour), opacity=opacity
            )
        else:
            node.vertices = vertices.astype(np.float32)

    def _solid(self, name: str, thing: Solid) -> set[str]:
        centre, turn = thing.centres[0], rotations(thing.turns[0])
        if not (np.isfinite(centre).all() and np.isfinite(turn).all()):
            return set()
        unit, triangles = meshes.BOX if thing.form == "box" else meshes.BALL
        # Not a moving node: viser shows those earlier than changed meshes, and bodies would run ahead of
        # rods.
        vertices = (unit * np.asarray(thing.size)) @ turn.T + centre
        self._mesh(name, vertices, triangles, LEGEND[thing.layer], _translucent(thing.opacity))
        return {name}

    def _visual(self, name: str, thing: Mesh) -> set[str]:
        pose = [thing.centres[0], thing.turns[0]]
        if not all(np.isfinite(part).all() for part in pose):
            return set()
        node = self._nodes.get(name)
        if node is None:
            colour = _rgb(thing.colour or LEGEND[thing.layer])
            node = self._nodes[name] = self._scene.add_mesh_simple(
                name,
                thing.corners,
                thing.faces,
                color=colour,
                opacity=_translucent(thing.opacity),
                side="double" if thing.is_open else "front",
            )
        # A moving node, other than bodies: its corners are too many to be sent for each frame.
        if self._is_new(name, *pose):
            node.position, node.wxyz = pose
        return {name}

    def _dots(self, name: str, thing: Dots) -> set[str]:
        points = thing.points[0]
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) == 0:
            return set()
        vertices, triangles = meshes.balls(points, thing.radius)
        self._mesh(name, vertices, triangles, LEGEND[thing.layer], _translucent(thing.opacity))
        return {name}

    def _line(self, name: str, thing: Line) -> set[str]:
        points = thing.points[0]
        pairs = np.stack([points[:-1], points[1:]], axis=1)
        pairs = pairs[np.isfinite(pairs).all(axis=(1, 2))]
        if len(pairs) == 0:
            return set()
        if self._is_new(name, pairs):
            node = self._nodes.get(name)
            if node is None or node.points.shape != pairs.shape:
                colour = _rgb(LEGEND[thing.layer])
                self._nodes[name] = self._scene.add_line_segments(
                    name, pairs, colour, thickness=LINE, thickness_units="screen"
                )
            else:
                node.points = pairs.astype(np.float32)
        return {name}

    def _arrows(self, name: str, thing: Arrows) -> set[str]:
        tails, vectors = thing.tails[0], thing.vectors[0]
        lengths = np.linalg.norm(vectors, axis=-1)
        is_there = np.isfinite(tails).all(axis=-1) & np.isfinite(lengths) & (lengths > 0.0)
        if not is_there.any():
            return set()
        points = np.stack([tails, tails + vectors], axis=1)[is_there]
        if self._is_new(name, points):
            # No head exceeds its fraction of the shortest arrow.
            head = min(thing.head, thing.most * float(lengths[is_there].min()))
            self._nodes[name] = self._scene.add_arrows(
                name,
                points,
                _rgb(LEGEND[thing.layer]),
                shaft_radius=thing.radius,
                head_radius=thing.head_radius * head / thing.head,
                head_length=head,
            )
        return {name}


def _translucent(opacity: float) -> float | None:
    """The opacity as viser wants it: none for what is solid, which is drawn without sorting."""
    return opacity if opacity < 1.0 else None


def _rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue of a hexadecimal colour."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
