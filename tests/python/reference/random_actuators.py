"""Actuators for the robots drawn by `random_robots`, as descriptions: ("Tendon", arguments), ...

`make` builds them with this reference or with another package whose classes have the same names.
"""

import numpy as np

from reference import actuation
from reference.random_robots import length


def make(description, package=actuation):
    """An actuator; parts of paths are descriptions, too."""
    kind, arguments = description
    arguments = dict(arguments)
    if "path" in arguments:
        arguments["path"] = [make(part, package) for part in arguments["path"]]
    return getattr(package, kind)(**arguments)


def random_offset(rng, full, most=0.03):
    """A constant or converging offset, a table or a helix."""
    kind = rng.integers(4)
    y, z = rng.uniform(-most, most, 2)
    if kind == 0:
        return y, z
    if kind == 1:
        return (y, z), (z, 0.0)
    if kind == 2:
        stations = [0.0, 0.4 * full, full]
        return (stations, rng.uniform(-most, most, 3).tolist()), z
    start, turns = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.5)
    angle = 2 * np.pi * turns / full

    def helix_y(X):
        return most * np.cos(start + angle * X)

    def helix_z(X):
        return most * np.sin(start + angle * X)

    return helix_y, helix_z


def random_along(rng, link):
    full = length(link)
    part = {"link": link["name"], "offset": random_offset(rng, full)}
    if rng.integers(2):
        part["along"] = (rng.uniform(0, 0.3) * full, rng.uniform(0.6, 1.0) * full)
    return "Along", part


def random_via(rng, links):
    link = links[rng.integers(len(links) + 1) - 1] if rng.integers(5) else None
    part = {"link": link and link["name"], "point": rng.uniform(-0.1, 0.1, 3).tolist()}
    if link and "rod" in link and rng.integers(2):
        part["at"] = rng.uniform(0, 1) * length(link)
    return "Via", part


def random_path(rng, links, most=4):
    """Parts along rods and points, in any order, with a path of nonzero length."""
    rods = [link for link in links if "rod" in link]
    path = []
    for _ in range(rng.integers(1, most + 1)):
        embedded = rods and rng.integers(2)
        path.append(random_along(rng, rng.choice(rods)) if embedded else random_via(rng, links))
    places = {carrier(links, part["link"], part.get("at")) for kind, part in path if kind == "Via"}
    if any(kind == "Along" for kind, _ in path) or len(places) > 1:
        return path
    # Points on what is rigid keep their distance in any motion.
    while True:
        kind, part = random_via(rng, links)
        if carrier(links, part["link"], part.get("at")) not in places:
            return [*path, (kind, part)]


def carrier(links, name, at=None):
    """What a place moves with: a body and all that is welded to it, or a section of a rod (its tip)."""
    if name is None:
        return None
    link = next(link for link in links if link["name"] == name)
    if "rod" in link:
        ends = np.cumsum([0.0, *(segment["length"] for segment in link["rod"])])
        place = ends[-1] if at is None else at
        # Segments without modes move with the section at which they begin.
        for segment, start in reversed(list(zip(link["rod"], ends[:-1], strict=True))):
            if start < place and segment["modes"]:
                break
            place = min(place, start)
        if place > 0.0:
            return name, place
    is_welded = link.get("joint", {"type": "weld"})["type"] == "weld"
    return carrier(links, link.get("parent"), link.get("at")) if is_welded else (name, None)


def random_tendons(seed, links, *, points=False, friction=False):
    """Some tendons: embedded in one rod, or through points and rods; with friction, or with every drive."""
    rng = np.random.default_rng(seed)
    rods = [link for link in links if "rod" in link]
    drives = [
        {"tension": rng.uniform(0.1, 5)},
        {"length": rng.uniform(0.0, 0.3), "stiffness": rng.uniform(1, 20), "damping": rng.uniform(0, 2)},
        {"length": 10.0, "stiffness": 5.0},  # slack
    ]
    if friction:
        ways = [{"friction_velocity": 0.1}, {"sliding": rng.uniform(-1, 1)}, {"sliding": 1.0}]
        drives = [drives[i % 2] | {"friction": rng.uniform(0.05, 0.5), **way} for i, way in enumerate(ways)]
    if not (points or rods):
        return []
    paths = [random_path(rng, links) if points else [random_along(rng, rng.choice(rods))] for _ in drives]
    return [
        ("Tendon", {"name": f"tendon{i}", "path": path, **drive})
        for i, (path, drive) in enumerate(zip(paths, drives, strict=True))
    ]


def random_others(seed, links):
    """Chambers, motors and active strains, if the robot has a place for them."""
    rng = np.random.default_rng(seed)
    made = []
    for i, link in enumerate(links):
        if "rod" in link:
            path = [random_along(rng, link)]
            arguments = {"path": path, "area": rng.uniform(1e-5, 3e-4), "pressure": rng.uniform(-1e4, 3e4)}
            made.append(("Chamber", {"name": f"chamber{i}", **arguments}))
            strains = sorted({strain for segment in link["rod"] for strain in segment["modes"]})
            if strains and all(strains[0] in segment["modes"] for segment in link["rod"]):
                made.append(("ActiveStrain", random_active(rng, link, strains[0])))
        if link.get("joint", {}).get("type") in ("revolute", "prismatic", "screw"):
            servo = {"position": rng.uniform(-1, 1), "gains": rng.uniform(0, 3, 2).tolist()}
            drive = servo if rng.integers(2) else {"torque": rng.uniform(-1, 1)}
            made.append(("Motor", {"joint": link["name"], **drive}))
    return made


def random_active(rng, link, strain):
    full = length(link)
    shapes = (1.0, (0.2, 1.0), ([0.0, 0.3 * full, full], [0.0, 1.0, -0.5]), lambda X: np.sin(4 * X / full))
    shape = shapes[rng.integers(len(shapes))]
    return {"link": link["name"], "strain": strain, "shape": shape, "amount": rng.uniform(-1, 1)}
