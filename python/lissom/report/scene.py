"""The document of a player: objects over time, camera and speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import theme
from .layers import LEGEND, Thing
from .packing import Numbers

Array = NDArray[np.float64]

#: Version of the document: raised when a player that knows the one before would show nonsense.
VERSION = 1

Kind = TypeVar("Kind", bound=Thing)


@dataclass(frozen=True)
class Scene:
    """A view in space of a model in one shape after the other."""

    #: When the shapes are shown, (shapes,), rising; for runs times in seconds.
    t: Array
    #: What stands around a label.
    label: tuple[str, str]
    #: Whether the labels are seconds, which are played in real time.
    is_time: bool
    #: Index of the shape that is shown first.
    opens_at: int
    things: Sequence[Thing]
    #: The box around it all, metres, and the direction from which it is seen.
    low: Array
    high: Array
    eye: Array
    #: Axis across the ground, where it is, and whether up is the axis' direction.
    ground: tuple[int, float, bool]
    #: Layers that are called otherwise here.
    names: Mapping[str, str]
    #: What surrounds the model, in words: gravity, the current.
    surroundings: Sequence[str] = ()
    #: What the labels say, (shapes,); `t` unless given. It need not rise.
    labels: Array | None = None

    def of(self, kind: type[Kind], layer: str | None = None) -> list[Kind]:
        """The things of a kind, of all layers or of one."""
        return [thing for thing in self.things if isinstance(thing, kind) and layer in (None, thing.layer)]

    @property
    def layers(self) -> list[str]:
        """The layers that show something, in the order of the legend."""
        shown = {thing.layer for thing in self.things} | {"floor"}
        return [layer for layer in LEGEND if layer in shown]

    @property
    def in_words(self) -> str:
        """The view for those who cannot see it."""
        what = ", ".join(self.names.get(layer, layer) for layer in self.layers if layer != "floor")
        before, after = self.label
        labels = self.t if self.labels is None else self.labels
        low, high = f"{before}{labels[0]:.4g}{after}", f"{before}{labels[-1]:.4g}{after}"
        size = " by ".join(f"{side:.3g}" for side in self.high - self.low)
        return f"View in space with {what}, from {low} to {high}, in a box of {size} m."

    def document(self) -> dict[str, Any]:
        """The document of the player, with arrays for `packing.pack`."""
        axis, place, is_up = self.ground
        return {
            "version": VERSION,
            "times": Numbers(np.asarray(self.t, float), "f4"),
            "label": list(self.label),
            **({} if self.labels is None else {"labels": Numbers(np.asarray(self.labels, float), "f4")}),
            "isTime": self.is_time,
            "opensAt": self.opens_at,
            "low": self.low.tolist(),
            "high": self.high.tolist(),
            "eye": self.eye.tolist(),
            "ground": {"axis": axis, "place": place, "sign": 1 if is_up else -1},
            "scale": [list(stop) for stop in theme.ROD_SCALE],
            "words": self.in_words,
            "surroundings": list(self.surroundings),
            "layers": [
                {"layer": layer, "name": self.names.get(layer, layer), "colour": LEGEND[layer]}
                for layer in self.layers
            ],
            "things": [
                {"kind": thing.kind, "layer": thing.layer, "name": thing.name, **thing.numbers}
                for thing in self.things
            ],
        }
