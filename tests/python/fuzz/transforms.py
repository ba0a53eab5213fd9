"""Changes of a robot that must not change what it does: other units, axes, names and orders, unrelated parts.

A transformation maps a recipe to a `Changed`, which says how coordinates and quantities of the new robot
follow from those of the old one.
"""

import copy
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from fuzz.balances import plan


@dataclass
class Changed:
    """A changed robot: its coordinate `place[i]` is `scale[i]` times coordinate i of the robot before."""

    recipe: dict
    place: np.ndarray
    scale: np.ndarray
    #: The units of the new numbers: lengths are multiplied by the first, masses and times by the others.
    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    @property
    def energy(self) -> float:
        return self.mass * self.length**2 / self.time**2


def _same(recipe: dict, changed: dict, names=lambda name: name) -> Changed:
    """The transformation of coordinates that keep their numbers and may have other places and names."""
    places = {(link, number): i for i, (link, number, _) in enumerate(plan(changed))}
    place = [places[names(link), number] for link, number, _ in plan(recipe)]
    return Changed(changed, np.array(place, int), np.ones(len(place)))


# Units.

#: Exponents of length, mass and time.
PLACE, FORCE, MOMENT = (1, 0, 0), (1, 1, -2), (2, 1, -2)
PER_LENGTH = np.array([-1, 0, 0])
UNITS = {
    "scene": {"gravity": (1, 0, -2)},
    "link": {"position": PLACE, "at": PLACE},
    "body": {"mass": (0, 1, 0), "centre": PLACE, "inertia": (2, 1, 0)},
    "segment": {
        "length": PLACE,
        "radius": PLACE,
        "young_modulus": (-1, 1, -2),
        "shear_modulus": (-1, 1, -2),
        "density": (-3, 1, 0),
        "retardation_time": (0, 0, 1),
    },
    "load": {"force": FORCE, "moment": MOMENT, "at": PLACE, "along": PLACE},
    "support": {"stiffness": (0, 1, -2), "damping": (0, 1, -1), "at": PLACE, "position": PLACE},
    "end": {"at": PLACE, "position": PLACE},
    "kind": {"length": PLACE},
    "surface": {"radius": PLACE, "at": PLACE, "position": PLACE, "point": PLACE},
    "contact": {
        "dissipation": (-1, 0, 1),
        "slip_velocity": (1, 0, -1),
        "stribeck_velocity": (1, 0, -1),
        "patch_radius": PLACE,
    },
    "tendon": {"length": PLACE, "stiffness": (0, 1, -2), "tension": FORCE},
    "part": {"point": PLACE, "at": PLACE},
}
#: Joints measure in radians or metres: the exponents of length that a rotation adds are those of a moment.
JOINT = {
    "stiffness": (0, 1, -2),
    "rest": (0, 0, 0),
    "damping": (0, 1, -1),
    "limits": (0, 0, 0),
    "limit_stiffness": (0, 1, -2),
    "armature": (0, 1, 0),
}


def units(recipe: dict, length: float, mass: float, time: float) -> Changed:
    """The same robot in other units: the numbers of lengths, masses and times are multiplied."""

    def times(value, exponents):
        factor = length ** exponents[0] * mass ** exponents[1] * time ** exponents[2]
        return (np.array(value, float) * factor).tolist()

    def table(kind, given):
        return {k: times(v, UNITS[kind][k]) if k in UNITS[kind] else v for k, v in given.items()}

    def joint(given):
        turns = given["type"] == "revolute"
        found = dict(given)
        for key, exponents in JOINT.items():
            if key in given:
                extra = (2, 0, 0) if turns else (1, 0, 0)
                extra = extra if key in ("rest", "limits") or turns else (0, 0, 0)
                if turns and key in ("rest", "limits"):
                    extra = (0, 0, 0)
                found[key] = times(given[key], np.add(exponents, extra))
        return found

    factors = {"angle": 1.0, "shift": length, "curvature": 1 / length, "strain": 1.0}
    changed = {"scene": table("scene", recipe["scene"]), "link": []}
    for link in recipe["link"]:
        new = table("link", link)
        kinds = [kind for name, _, kind in plan(recipe) if name == link["name"]]
        for key, rate in (("q0", 1.0), ("v0", 1 / time)):
            if key in link:
                new[key] = [float(x * factors[kind] * rate) for x, kind in zip(link[key], kinds, strict=True)]
        if "joint" in link:
            new["joint"] = joint(link["joint"])
        if "body" in link:
            new["body"] = table("body", link["body"])
        if "rod" in link:
            new["rod"] = {"segment": [table("segment", part) for part in link["rod"]["segment"]]}
        if "load" in link:
            new["load"] = [
                table("load", load)
                if "along" not in load
                else table("load", load)
                | {
                    k: times(load[k], np.add(UNITS["load"][k], PER_LENGTH))
                    for k in ("force", "moment")
                    if k in load
                }
                for load in link["load"]
            ]
        if "support" in link:
            new["support"] = [table("support", each) for each in link["support"]]
        changed["link"].append(new)
    for loop in recipe.get("loop", ()):
        ends = {end: table("end", loop[end]) for end in ("a", "b") if end in loop}
        changed.setdefault("loop", []).append(loop | {"kind": table("kind", loop["kind"])} | ends)
    for tendon in recipe.get("tendon", ()):
        path = [table("part", part) for part in tendon["path"]]
        changed.setdefault("tendon", []).append(table("tendon", tendon) | {"path": path})
    for contact in recipe.get("contact", ()):
        new = table("contact", {"dissipation": 1.0, "slip_velocity": 1e-4} | contact)
        along_rod = isinstance(contact["a"], str)
        new["stiffness"] = times(contact["stiffness"], (-1, 1, -2) if along_rod else (0, 1, -2))
        for side in ("a", "b"):
            if isinstance(contact[side], dict):
                new[side] = table("surface", contact[side])
        changed.setdefault("contact", []).append(new)
    found = _same(recipe, changed)
    found.scale = np.array([factors[kind] for _, _, kind in plan(recipe)])
    found.length, found.mass, found.time = length, mass, time
    return found


# Places and axes.


def moved(recipe: dict, rotation: Rotation, shift) -> Changed:
    """The world, gravity with it, rotated and shifted."""

    def vector(value):
        return rotation.apply(value).tolist()

    def place(value):
        return (rotation.apply(value) + shift).tolist()

    def orientation(value):
        turned = rotation * Rotation.from_quat(np.roll(value, -1))
        return np.roll(turned.as_quat(), 1).tolist()

    def frame(given):
        return given | {
            "position": place(given.get("position", (0, 0, 0))),
            "orientation": orientation(given.get("orientation", (1, 0, 0, 0))),
        }

    changed = copy.deepcopy(recipe)
    changed["scene"]["gravity"] = vector(recipe["scene"]["gravity"])
    for i, link in enumerate(changed["link"]):
        if "parent" not in link:
            changed["link"][i] = link = frame(link)
        for load in link.get("load", ()):
            if load.get("frame") != "body":
                load |= {key: vector(load[key]) for key in ("force", "moment") if key in load}
        if "support" in link:
            link["support"] = [frame(support) for support in link["support"]]
    for loop in changed.get("loop", ()):
        loop |= {end: frame(loop.get(end, {})) for end in ("a", "b") if "link" not in loop.get(end, {})}
    for tendon in changed.get("tendon", ()):
        for part in tendon["path"]:
            if "link" not in part:
                part["point"] = place(part["point"])
    for contact in changed.get("contact", ()):
        plane = contact["b"]
        plane |= {
            "point": place(plane.get("point", (0, 0, 0))),
            "normal": vector(plane.get("normal", (0, 0, 1))),
        }
    return _same(recipe, changed)


# Names and orders.


def _renaming(recipe: dict, names) -> dict:
    """A copy in which `names` maps the names of links."""
    changed = copy.deepcopy(recipe)
    for link in changed["link"]:
        link["name"] = names(link["name"])
        if "parent" in link:
            link["parent"] = names(link["parent"])
    ends = [loop[end] for loop in changed.get("loop", ()) for end in ("a", "b") if end in loop]
    parts = [part for tendon in changed.get("tendon", ()) for part in tendon["path"]]
    for contact in changed.get("contact", ()):
        if isinstance(contact["a"], str):
            contact["a"] = names(contact["a"])
        else:
            parts.append(contact["a"])
    for place in ends + parts:
        if "link" in place:
            place["link"] = names(place["link"])
    return changed


def renamed(recipe: dict) -> Changed:
    """Links have other names, whose alphabetical order is reversed."""
    order = sorted(link["name"] for link in recipe["link"])
    names = {name: f"n{len(order) - i:02}" for i, name in enumerate(order)}
    return _same(recipe, _renaming(recipe, names.__getitem__), names.__getitem__)


def reordered(recipe: dict, rng) -> Changed:
    """Links, parents before their children, and effects in another order."""
    changed = copy.deepcopy(recipe)
    left, links = list(changed["link"]), []
    while left:
        ready = [link for link in left if link.get("parent") not in {each["name"] for each in left}]
        links.append(ready[rng.integers(len(ready))])
        left.remove(links[-1])
    changed["link"] = links
    for key in ("tendon", "contact", "loop"):
        if key in changed:
            changed[key] = [changed[key][i] for i in rng.permutation(len(changed[key]))]
    return _same(recipe, changed)


# Unrelated parts.


def _extent(recipe: dict) -> float:
    """A length that no part of the robot reaches."""
    lengths = [1.0]
    for link in recipe["link"]:
        lengths.append(np.linalg.norm(link.get("position", 0.0)))
        lengths += [part["length"] for part in link.get("rod", {}).get("segment", ())]
        lengths += np.abs(link.get("q0", [0.0])).tolist()
    return 3.0 * float(sum(lengths))


def beside_a_rod(recipe: dict, rng) -> Changed:
    """A light rod that hangs elsewhere, one to a hundred metres of soft rubber."""
    length = float(10 ** rng.integers(3))
    segment = {"length": length, "radius": 0.05 * length, "young_modulus": 1e6, "shear_modulus": 4e5}
    other = {
        "name": "other",
        "position": [0.0, _extent(recipe), 0.0],
        "rod": {"segment": [segment | {"density": 1e-6, "modes": {"bend_y": 2}}]},
    }
    return _same(recipe, copy.deepcopy(recipe) | {"link": [*copy.deepcopy(recipe["link"]), other]})


def beside_a_body(recipe: dict) -> Changed:
    """A heavy body on a stiff spring elsewhere."""
    joint = {"type": "prismatic", "axis": [0.0, 1.0, 0.0], "stiffness": 1e6}
    other = {
        "name": "other",
        "position": [_extent(recipe), 0.0, 0.0],
        "joint": joint,
        "body": {"mass": 100.0},
    }
    return _same(recipe, copy.deepcopy(recipe) | {"link": [other, *copy.deepcopy(recipe["link"])]})


def with_a_far_floor(recipe: dict) -> Changed:
    """A contact that nothing ever touches."""
    plane = {"kind": "half_space", "point": [0.0, 0.0, -_extent(recipe)], "normal": [0.0, 0.0, 1.0]}
    name, _, _ = plan(recipe)[0]
    far = {"name": "far", "a": {"link": name, "radius": 0.01}, "b": plane, "stiffness": 1e4}
    changed = copy.deepcopy(recipe)
    return _same(recipe, changed | {"contact": [*changed.get("contact", ()), far]})


# Parameters on which no equilibrium depends.


def slides_only(recipe: dict, link: dict) -> bool:
    """Whether a link never rotates."""
    by_name = {each["name"]: each for each in recipe["link"]}
    while link is not None:
        if link.get("joint", {"type": "weld"})["type"] not in ("weld", "prismatic") or "rod" in link:
            return False
        link = by_name.get(link.get("parent"))
    return True


def idle(recipe: dict, factor: float) -> Changed:
    """Inertia, centres of mass of what only slides, and without gravity all masses, times a factor."""
    changed = copy.deepcopy(recipe)
    weightless = not np.any(recipe["scene"]["gravity"])
    for link in changed["link"]:
        body = link.get("body", {})
        for key in ("inertia", "mass") if weightless else ("inertia",):
            if key in body:
                body[key] = (np.array(body[key]) * factor).tolist()
        if "centre" in body and slides_only(changed, link):
            body["centre"] = (np.array(body["centre"]) * min(factor, 1 / factor)).tolist()
        for segment in link.get("rod", {}).get("segment", ()):
            segment["density"] *= factor if weightless else 1.0
    return _same(recipe, changed)
