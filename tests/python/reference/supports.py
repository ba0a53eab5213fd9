"""Independent elastic supports: wrenches of springs and dampers in the axes of the section.

The potential of rotation is tr(G (1 - R0^T R)), G diagonal (Koditschek 1989); its gradient in the axes of the
section is the axial vector of G R0^T R - (G R0^T R)^T.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from reference import rod


@dataclass(frozen=True)
class Support:
    """Same arguments as `lissom.Support`, all of them arrays."""

    stiffness: Sequence[float] = (0, 0, 0)
    rotational_stiffness: Sequence[float] = (0, 0, 0)
    damping: Sequence[float] = (0, 0, 0)
    rotational_damping: Sequence[float] = (0, 0, 0)
    at: float | None = None
    position: Sequence[float] | None = None
    orientation: Sequence[float] | None = None

    def wrench(self, anchor, R, p, eta):
        """Moment and force on a section at p with rotation R, which moves with the body twist eta."""
        turned = anchor[:3, :3].T @ R
        along = anchor[:3, :3].T @ (p - anchor[:3, 3])
        velocity, spin = turned @ eta[3:], turned @ eta[:3]
        force = -np.multiply(self.stiffness, along) - np.multiply(self.damping, velocity)
        G = np.diag(np.sum(self.rotational_stiffness) / 2 - np.array(self.rotational_stiffness, float))
        skew = G @ turned - (G @ turned).T
        moment = -np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        moment -= turned.T @ np.multiply(self.rotational_damping, spin)
        return np.concatenate([moment, turned.T @ force])


class Rod(rod.Rod):
    """A rod with supports."""

    def __init__(self, segments, *, supports=(), **arguments):
        # A body without mass makes the integration stop at each support.
        holders = [rod.Body(0.0, at=support.at) for support in supports]
        super().__init__(segments, bodies=[*arguments.pop("bodies", ()), *holders], **arguments)
        places = [self.starts[-1] if support.at is None else support.at for support in supports]
        poses = self.poses(np.zeros(self.n), places)
        self.supports = []
        for support, pose in zip(supports, poses, strict=True):
            anchor = pose.copy()
            if support.position is not None:
                anchor[:3, 3] = support.position
            if support.orientation is not None:
                w, x, y, z = support.orientation
                anchor[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
            self.supports.append((support, anchor))

    def _at_point(self, i, X, y):
        wrench = super()._at_point(i, X, y)
        R, p, eta, _ = rod.unpack(y)
        here = self._there([support for support, _ in self.supports], i, X)
        for support, anchor in self.supports:
            if any(support is other for other in here):
                wrench = wrench - support.wrench(anchor, R, p, eta)[:, None]
        return wrench
