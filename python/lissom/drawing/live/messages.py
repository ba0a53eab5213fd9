"""Messages that pages may send: those of the controls and the camera, with values of the right type.

viser sets every attribute of its objects that a message names, and sends to all pages what one has sent. Here
other messages are dropped before viser reads them.
"""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta, Struct

#: Largest number in a message: that of single precision, in which pages draw.
LARGEST_NUMBER = 3.4028234663852886e38

#: Longest text in a message, characters: names of parts and options.
LONGEST_TEXT = 2**12

# Comparisons with the bounds also refuse NaN.
Number = Annotated[float, Meta(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
Text = Annotated[str, Meta(max_length=LONGEST_TEXT)]
Vector = tuple[Number, Number, Number]
Quaternion = tuple[Number, Number, Number, Number]


class Value(Struct, forbid_unknown_fields=True):
    """The new value of a control; buttons send true."""

    value: bool | Number | Text


class GuiUpdateMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """A control was used."""

    uuid: Text
    updates: Value


class TransformControlsDragStartMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """The handle was taken."""

    name: Text
    owner: Text = ""


class TransformControlsUpdateMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """The handle was moved."""

    name: Text
    wxyz: Quaternion
    position: Vector
    owner: Text = ""


class TransformControlsDragEndMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """The handle was released."""

    name: Text
    owner: Text = ""


class ViewerCameraMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True):
    """The camera was moved; the first one says that the page is ready."""

    wxyz: Quaternion
    position: Vector
    fov: Number
    near: Number
    far: Number
    image_height: Number
    image_width: Number
    look_at: Vector
    up_direction: Vector


_DECODER = msgspec.msgpack.Decoder(
    GuiUpdateMessage
    | TransformControlsDragStartMessage
    | TransformControlsUpdateMessage
    | TransformControlsDragEndMessage
    | ViewerCameraMessage
)


def is_message(raw: object) -> bool:
    """Whether this is a message that pages of a view send."""
    if not isinstance(raw, bytes):
        return False
    try:
        _DECODER.decode(raw)
    except (msgspec.MsgspecError, RecursionError, UnicodeError):
        return False
    return True
