"""Import of rigid links and joints from URDF, the XML robot format of ROS.

Content that lissom does not support is never dropped silently: every element, attribute, text, processing
instruction and document type declaration that does not become part of a link, joint or body is listed with
its location and a reason. Children of a listed element belong to its entry. Comments are not listed.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from .._lissom import Link, Revolute, Robot
from ..common import disk
from ..common.arguments import flag, path_of, suggesting
from .imported import Imported, Left
from .pictures import Pictures
from .problems import UrdfError, UrdfProblem, UrdfWarning
from .reader import Reader

__all__ = [
    "Imported",
    "Left",
    "UrdfError",
    "UrdfProblem",
    "UrdfWarning",
    "imported_from",
    "read_urdf",
    "robot_from_urdf",
]


@suggesting
def read_urdf(
    path: str | os.PathLike[str],
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
    collisions: bool = False,
    visuals: bool = False,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
) -> Imported:
    """Read the links and joints of a URDF file.

    Every link of the file becomes a `Link` of the same name with the joint to its parent. A link without
    <inertial> is a frame. ``revolute`` and ``continuous`` become `Revolute`, ``prismatic`` `Prismatic`,
    ``fixed`` `Weld`, ``floating`` `Free`, ``planar`` `Planar`; damping and friction of <dynamics> and <mimic>
    are imported. ``loop_joint`` becomes a `Loop` between its ``link1`` and ``link2``, which have ``link``,
    ``xyz`` and ``rpy``. Referenced files are not opened, but for meshes of <visual> on request.

    Parameters
    ----------
    path : path-like
        The URDF file. Run xacro on a xacro file first.
    floating : bool
        Whether the root link moves freely; by default it is welded to the world.
    limit_stiffness : float, optional
        Stiffness of the stops at joint limits, newton metres per radian for revolute joints and newtons per
        metre for prismatic ones. URDF does not specify it; without it, limits are not imported but listed.
    mend_inertia : bool
        Whether to replace impossible moments of inertia (one larger than the sum of the other two, or a
        negative one) by the nearest possible ones, and list them. By default they are an error.
    collisions : bool
        Whether to read the boxes, spheres, cylinders and capsules of <collision> as `shapes` on their links.
        Cylinders become prisms with 24 sides and the same volume.
    visuals : bool
        Whether to read the meshes, boxes, spheres, cylinders and capsules of <visual> as `visuals` on their
        links, with the colours of their materials. Meshes are STL, OBJ or COLLADA files (extra `meshes`) of
        at most 64 MiB; those of more than 5000 triangles are simplified, and listed. COLLADA's unit is
        respected, its up axis is not, as in RViz.
    packages : mapping of str to path-like, optional
        Folders of packages, for files such as ``package://arm_description/meshes/hand.stl``. By default a
        folder of this name that contains the URDF file, or is beside a folder that does.

    Returns
    -------
    Imported
        The links; `not_taken` lists everything that was not imported.

    Raises
    ------
    UrdfError
        If the file is invalid; the message lists all problems with line and column.
    OSError
        If the file cannot be read.
    ValueError, TypeError
        If `limit_stiffness` is not positive.
    ImportError
        If what reads a mesh is not installed.

    Examples
    --------
    >>> import lissom.urdf
    >>> arm = lissom.urdf.read_urdf("arm.urdf")  # doctest: +SKIP
    >>> print(arm)  # doctest: +SKIP
    >>> robot = lissom.Robot(arm.links)  # doctest: +SKIP
    """
    _check_stiffness(limit_stiffness)
    file = path_of(path)
    return imported_from(
        str(file),
        disk.read(file, disk.LARGEST_DESCRIPTION),
        floating=floating,
        limit_stiffness=limit_stiffness,
        mend_inertia=mend_inertia,
        collisions=flag("collisions", collisions),
        loops=True,
        pictures=Pictures(file.parent, _folders(packages)) if flag("visuals", visuals) else None,
    )


def _folders(packages: Mapping[str, str | os.PathLike[str]] | None) -> dict[str, Path]:
    if packages is not None and not isinstance(packages, Mapping):
        raise TypeError(f"packages: expected a mapping of names to folders, got {type(packages).__name__}")
    return {name: path_of(folder, f"packages[{name!r}]") for name, folder in (packages or {}).items()}


def imported_from(
    file: str,
    content: bytes,
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
    collisions: bool = False,
    loops: bool = False,
    pictures: Pictures | None = None,
) -> Imported:
    """Read links and joints from the content of a URDF file.

    Parameters
    ----------
    file : str
        Name of the file in messages.
    content : bytes
        Content of the file.
    floating, limit_stiffness, mend_inertia, collisions
        As for `read_urdf`.
    loops : bool
        Whether to read loops; they are listed otherwise, as in scenes, whose loops are their own.
    pictures : Pictures, optional
        Where meshes lie, to read <visual>.

    Returns
    -------
    Imported

    Raises
    ------
    UrdfError, ValueError, TypeError
        As `read_urdf` does.
    """
    _check_stiffness(limit_stiffness)
    return Reader(file, content, limit_stiffness, mend_inertia, collisions, loops, pictures).imported(
        floating
    )


def _check_stiffness(limit_stiffness: float | None) -> None:
    if limit_stiffness is not None:
        # The joint validates the stiffness.
        Revolute((1.0, 0.0, 0.0), limits=(-1.0, 1.0), limit_stiffness=limit_stiffness)


@suggesting
def robot_from_urdf(
    path: str | os.PathLike[str],
    *,
    floating: bool = False,
    limit_stiffness: float | None = None,
    mend_inertia: bool = False,
    links: Iterable[Link] = (),
    gravity: ArrayLike = (0, 0, -9.81),
    **others: Any,
) -> Robot:
    """Create a robot from the links and loops of a URDF file and additional ones.

    Parameters
    ----------
    path, floating, limit_stiffness, mend_inertia
        As for `read_urdf`.
    links : iterable of Link
        Additional links, such as rods attached to links of the file.
    gravity, **others
        As for `Robot`; `loops` are additional ones.

    Returns
    -------
    Robot

    Warns
    -----
    UrdfWarning
        Once, with a summary of everything that was not imported; `read_urdf` returns the full list.

    Raises
    ------
    UrdfError, OSError
        As for `read_urdf`.
    ValueError, TypeError
        As for `Robot`, for example if a joint moves no mass.

    Examples
    --------
    >>> import lissom, lissom.urdf
    >>> soft = lissom.Segment(0.1, 8e-3, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    >>> finger = lissom.Link("finger", rod=[soft], parent="hand")
    >>> robot = lissom.urdf.robot_from_urdf("arm.urdf", links=[finger])  # doctest: +SKIP
    """
    imported = read_urdf(path, floating=floating, limit_stiffness=limit_stiffness, mend_inertia=mend_inertia)
    if imported.not_taken:
        warnings.warn(str(imported), UrdfWarning, stacklevel=3)
    if imported.loops:
        others["loops"] = [*imported.loops, *others.get("loops", ())]
    return Robot([*imported.links, *links], gravity=gravity, **others)
