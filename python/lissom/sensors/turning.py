"""Rotations of many states, entry by entry: results do not depend on the number of states, bit for bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turned(rotations: Array, vectors: Array) -> Array:
    """``R x`` for rotations (k, 3, 3) and vectors (k, 3), or a single one of either."""
    return _sum(rotations * vectors[..., None, :], -1)


def turned_back(rotations: Array, vectors: Array) -> Array:
    """``R.T x`` for the same shapes."""
    return _sum(rotations * vectors[..., :, None], -2)


def _sum(terms: Array, axis: int) -> Array:
    """Sum in a fixed order of terms."""
    total: Array = terms.sum(axis=axis)
    return total


def cross(first: Array, second: Array) -> Array:
    """Cross products of vectors (k, 3)."""
    ax, ay, az = first.T
    bx, by, bz = second.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def matrix_of(quaternion: tuple[float, ...]) -> Array:
    """The rotation matrix of a quaternion (w, x, y, z) of norm one."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternions_of(rotations: Array) -> Array:
    """Quaternions (w, x, y, z), w >= 0, of rotation matrices (k, 3, 3).

    ``4 p p.T`` of the quaternion p is linear in the matrix; p is the normalised row with the largest diagonal
    entry (Shepperd 1978).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.moveaxis(rotations, 0, -1)
    products = np.stack(
        [
            np.stack([1 + xx + yy + zz, zy - yz, xz - zx, yx - xy], axis=-1),
            np.stack([zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx], axis=-1),
            np.stack([xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy], axis=-1),
            np.stack([yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz], axis=-1),
        ],
        axis=-2,
    )
    largest = np.diagonal(products, axis1=-2, axis2=-1).argmax(axis=-1)
    rows = np.take_along_axis(products, largest[:, None, None], axis=-2)[:, 0]
    return upright(rows)


def upright(quaternions: Array) -> Array:
    """Normalised quaternions (k, 4) of the same rotations with w >= 0."""
    norms = np.sqrt(_sum(quaternions * quaternions, -1))
    normalised: Array = quaternions / np.where(quaternions[:, 0] < 0, -norms, norms)[:, None]
    return normalised


def products(first: Array, second: Array) -> Array:
    """Products of quaternions (k, 4): the second rotation is about axes rotated by the first one."""
    a, b, c, d = np.moveaxis(first, -1, 0)
    w, x, y, z = np.moveaxis(second, -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def exponentials(vectors: Array) -> Array:
    """Quaternions of rotation vectors (k, 3)."""
    half = np.sqrt((vectors * vectors).sum(axis=-1)) / 2
    # sin(x) / x, valid at zero; NumPy's sinc contains a factor pi.
    return np.concatenate([np.cos(half)[:, None], vectors / 2 * np.sinc(half / np.pi)[:, None]], axis=-1)
