"""The player's document: objects over time, camera and speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import theme
from .layers import Thing
from .numerals import typeset
from .packing import Numbers

Array = NDArray[np.float64]

#: Version of the document, increased when older players could not display it.
VERSION = 1

Kind = TypeVar("Kind", bound=Thing)


@dataclass(frozen=True)
class Scene:
    """A 3-D view of a sequence of shapes of a model."""

    #: Times at which shapes are shown, (shapes,), increasing; in seconds for runs.
    t: Array
    #: Text before and after the value of a label.
    label: tuple[str, str]
    #: Whether labels are seconds, which are played in real time.
    is_time: bool
    #: Index of the shape that is shown first.
    opens_at: int
    things: Sequence[Thing]
    #: Bounding box in metres, and the view direction.
    low: Array
    high: Array
    eye: Array
    #: Axis perpendicular to the ground, its position, and whether up is along the axis.
    ground: tuple[int, float, bool]
    #: Colours of the layers, in the order of the legend.
    legend: Mapping[str, str]
    #: Layers with different names in this scene.
    names: Mapping[str, str]
    #: Description of the surroundings, such as gravity.
    surroundings: Sequence[str] = ()
    #: Values of the labels, (shapes,); `t` by default. They need not increase.
    labels: Array | None = None

    def of(self, kind: type[Kind], layer: str | None = None) -> list[Kind]:
        """The objects of a kind, of all layers or of one."""
        return [thing for thing in self.things if isinstance(thing, kind) and layer in (None, thing.layer)]

    @property
    def layers(self) -> list[str]:
        """Non-empty layers, in the order of the legend."""
        shown = {thing.layer for thing in self.things} | {"floor"}
        return [layer for layer in self.legend if layer in shown]

    @property
    def in_words(self) -> str:
        """Text alternative of the view."""
        what = ", ".join(self.names.get(layer, layer) for layer in self.layers if layer != "floor")
        before, after = self.label
        labels = self.t if self.labels is None else self.labels
        low, high = f"{before}{labels[0]:.4g}{after}", f"{before}{labels[-1]:.4g}{after}"
        size = " by ".join(f"{side:.3g}" for side in self.high - self.low)
        return f"View in space with {what}, from {low} to {high}, in a box of {size} m."

    def document(self) -> dict[str, Any]:
        """The player's document, with arrays for `packing.pack`."""
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
            "words": typeset(self.in_words),
            "surroundings": [typeset(words) for words in self.surroundings],
            "layers": [
                {"layer": layer, "name": self.names.get(layer, layer), "colour": self.legend[layer]}
                for layer in self.layers
            ],
            "things": [
                {"kind": thing.kind, "layer": thing.layer, "name": typeset(thing.name), **thing.numbers}
                for thing in self.things
            ],
        }
