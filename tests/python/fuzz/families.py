"""Random robots as recipes (see `rendered`): trees, bodies on balls, cords, loops, lines on ground, floors.

Each family bounds the energy from below, so that each of its robots has an equilibrium.
"""

import numpy as np

from fuzz.balances import plan

#: Digits of numbers, so that cases are readable.
DIGITS = 4


def _round(value):
    array = np.asarray(value, float)
    with np.errstate(divide="ignore"):
        digits = DIGITS - 1 - np.floor(np.log10(np.where(array == 0, 1.0, np.abs(array))))
    return (np.round(array * 10.0**digits) / 10.0**digits).tolist()


def _vector(rng, size=1.0):
    return _round(size * rng.normal(size=3))


def _quaternion(rng):
    q = rng.normal(size=4)
    return (q / np.linalg.norm(q)).tolist()


def _rotation_vector(rng, far):
    """Of a length up to half a turn, or from there to beyond a full one."""
    axis = rng.normal(size=3)
    angle = rng.uniform(np.pi, 7.0) if far else rng.uniform(0, 2.0)
    return _round(axis / np.linalg.norm(axis) * angle)


def _body(rng, size=0.3, mass=None):
    """Any inertia that four masses can have."""
    mass = mass or _round(10 ** rng.uniform(-1, 0.5))
    points = size * rng.normal(size=(4, 3))
    points -= points.mean(axis=0)
    covariance = points.T @ points / 4
    inertia = mass * (np.trace(covariance) * np.eye(3) - covariance)
    return {
        "mass": mass,
        "centre": _vector(rng, size),
        "inertia": _round((inertia + inertia.T) / 2 + 0.01 * np.trace(inertia) * np.eye(3)),
    }


def _segment(rng, length=None, **modes):
    """Rubber, soft enough to sag and stiff enough not to curl up."""
    length = length or _round(rng.uniform(0.1, 0.4))
    modes = modes or {
        strain: int(rng.integers(1, 3))
        for strain in ("torsion", "bend_y", "bend_z", "stretch")
        if rng.random() < (0.7 if strain.startswith("bend") else 0.3)
    }
    return {
        "length": length,
        "radius": _round(length * rng.uniform(0.03, 0.06)),
        "young_modulus": _round(10 ** rng.uniform(6, 7)),
        "poisson_ratio": 0.45,
        "density": _round(rng.uniform(500, 2000)),
        "modes": modes or {"bend_y": 2},
    }


def _joint(rng, kinds):
    kind = str(rng.choice(kinds))
    joint = {"type": kind}
    if kind in ("revolute", "prismatic", "screw", "cylindrical"):
        joint["axis"] = _vector(rng)
    if kind == "screw":
        joint["lead"] = _round(0.1 * rng.normal())
    if kind == "universal":
        first = rng.normal(size=3)
        joint |= {"axis1": _round(first), "axis2": _round(np.cross(first, rng.normal(size=3)) + 0.2 * first)}
    if kind == "planar":
        joint["normal"] = _vector(rng)
    if kind in ("revolute", "screw"):
        joint |= {"stiffness": _round(rng.uniform(5, 30)), "rest": _round(rng.normal() * 0.3)}
    if kind == "prismatic":
        joint |= {"stiffness": _round(rng.uniform(100, 1000)), "rest": _round(rng.normal() * 0.1)}
    if kind in ("revolute", "prismatic") and rng.random() < 0.2:
        joint |= {"limits": [-0.2, 0.3], "limit_stiffness": 1e4}
    return joint


def _load(rng, size):
    load = {"force": _vector(rng, size)}
    if rng.random() < 0.2:
        load |= {"moment": _vector(rng, 0.1 * size), "frame": "body"}
    return load


#: Joints that gravity does not let go, and those that only supports hold.
HELD = ("revolute", "prismatic", "screw", "spherical", "universal", "weld")
LOOSE = ("free", "planar", "cylindrical")
FLOOR = {"kind": "half_space", "point": [0.0, 0.0, -0.5], "normal": [0.0, 0.0, 1.0]}


def tree(rng) -> dict:
    """One to four links with any joints; springs to the world hold what gravity would let go."""
    links: list[dict] = []
    for number in range(int(rng.integers(1, 5))):
        name = "abcd"[number]
        loose = rng.random() < 0.25
        joint = _joint(rng, LOOSE if loose else HELD)
        link = {"name": name, "joint": joint}
        if rng.random() < 0.5:
            link["rod"] = {"segment": [_segment(rng) for _ in range(int(rng.integers(1, 3)))]}
        else:
            link["body"] = _body(rng)
        link["position"], link["orientation"] = _vector(rng, 0.3), _quaternion(rng)
        if links and rng.random() < 0.7:
            parent = links[int(rng.integers(len(links)))]
            link["parent"] = parent["name"]
            if "rod" in parent and rng.random() < 0.5:
                link["at"] = _round(0.5 * parent["rod"]["segment"][0]["length"])
        if loose or rng.random() < 0.2:
            link["support"] = [
                {"stiffness": _round(rng.uniform(50, 500)), "position": _vector(rng, 0.3)} for _ in range(2)
            ]
        if rng.random() < 0.3:
            link["load"] = [_load(rng, 3.0)]
        links.append(link)
    recipe = {"scene": {"gravity": _vector(rng, 6.0) if rng.random() < 0.8 else [0.0] * 3}, "link": links}
    if not plan(recipe):
        links[-1]["joint"] = {"type": "spherical"}
    if rng.random() < 0.25:
        ball = {"link": plan(recipe)[-1][0], "radius": 0.05}
        recipe["contact"] = [{"name": "floor", "a": ball, "b": dict(FLOOR), "stiffness": 1e4}]
    return recipe


def balls(rng) -> dict:
    """One or two bodies on ball joints with loads, supports and contacts."""
    links = []
    for number in range(int(rng.integers(1, 3))):
        link = {
            "name": "ab"[number],
            "joint": {"type": "spherical"},
            "body": _body(rng, 10 ** rng.uniform(-2, 0)),
        }
        if number and rng.random() < 0.7:
            link |= {"parent": "a", "position": _vector(rng, 0.3)}
        if rng.random() < 0.5:
            link["load"] = [{"force": _vector(rng, 10.0)}]
        if rng.random() < 0.3:
            link["support"] = [{"stiffness": _round(rng.uniform(5, 50)), "position": _vector(rng)}]
        links.append(link)
    recipe = {"scene": {"gravity": [0.0, 0.0, -9.81]}, "link": links}
    if rng.random() < 0.3:
        far = dict(FLOOR, point=[0.0, 0.0, -50.0])
        ball = {"link": "a", "radius": 0.01}
        recipe["contact"] = [{"name": "floor", "a": ball, "b": far, "stiffness": 1e4}]
    return recipe


def _small(rng):
    """A length that hardly matters, or does."""
    return float(rng.choice([0.0, 1e-6, 1e-4, 1e-3, 5e-3, 1e-2, 0.1]))


def cords(rng) -> dict:
    """A carriage on a rail below a cord, or a box on one to four cords; centres of mass are a little off."""
    off = _small(rng)
    if rng.random() < 0.5:
        carriage = {
            "name": "a",
            "joint": {"type": "prismatic", "axis": [0.0, 0.0, 1.0]},
            "position": [0.0, 0.0, 3.0],
            "body": {"mass": _round(10 ** rng.uniform(-1, 1)), "centre": [0.0, 0.0, off]},
        }
        links, corners, length = [carriage], [(0.0, 0.0)], _round(rng.uniform(0.5, 1.5))
    else:
        inertia = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.15]]
        box = {"mass": 1.0, "centre": [0.0, 0.0, -off], "inertia": inertia}
        links = [{"name": "a", "joint": {"type": "free"}, "body": box}]
        links[0]["q0"] = _round(
            [*(0.2 * rng.normal(size=2)), rng.uniform(-1, 1.5), *(0.3 * rng.normal(size=3))]
        )
        corners = [(0.5, 0.5), (-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5)][: int(rng.integers(1, 5))]
        length = 2.0
    stiffness = float(10.0 ** rng.integers(3, 6))
    tendons = [
        {
            "name": f"t{i}",
            "path": [{"point": [2 * x, 2 * y, 5.0]}, {"link": "a", "point": [x, y, 0.0]}],
            "length": length,
            "stiffness": stiffness,
        }
        for i, (x, y) in enumerate(corners)
    ]
    return {"scene": {"gravity": [0.0, 0.0, -9.81]}, "link": links, "tendon": tendons}


def loops(rng) -> dict:
    """A pinned finger, a buckled arc between hinges, a body on a pin."""
    kind = int(rng.integers(3))
    hinge = {"type": "revolute", "axis": [0.0, 1.0, 0.0]}
    gravity = [0.0, 0.0, -9.81]
    if kind == 0:
        length = float(rng.choice([0.03, 0.1, 0.5]))
        finger = _segment(rng, length, bend_y=4) | {"radius": 0.05 * length}
        links = [{"name": "a", "rod": {"segment": [finger]}}]
        pin = {"kind": {"type": "spherical"}, "b": {"position": [0.5 * length, 0.0, _round(0.6 * length)]}}
    elif kind == 1:
        length = float(rng.choice([1.0, 100.0]))
        segment = _segment(rng, length / 3, bend_y=3) | {"radius": _round(10 ** rng.uniform(-3, -2) * length)}
        links = [{"name": "a", "joint": hinge, "rod": {"segment": [dict(segment) for _ in range(3)]}}]
        angle, chord = rng.uniform(-0.5, 0.5), rng.uniform(0.9, 0.99) * length
        pin = {
            "kind": dict(hinge),
            "b": {"position": _round([chord * np.cos(angle), 0.0, chord * np.sin(angle)])},
        }
        gravity = [0.0, 0.0, 0.0] if rng.random() < 0.7 else _round([0.0, 0.0, -0.01 / length])
    else:
        inertia = _round(rng.uniform(0.05, 0.3))
        centre = [0.0, 0.0, _small(rng)]
        body = {"mass": 1.0, "centre": centre, "inertia": (inertia * np.eye(3)).tolist()}
        links = [{"name": "a", "joint": {"type": "free"}, "body": body}]
        arm = [0.0, 0.0, float(rng.choice([0.1, 1.0]))]
        pin = {"kind": {"type": "spherical"}, "b": {"position": [0.0, 0.0, 2.0]}}
        # Anywhere, or hung up and turned about the vertical.
        hung = [0.0, 0.0, 2.0 - arm[2], 0.0, 0.0, _round(rng.normal())]
        links[0]["q0"] = hung if rng.random() < 0.5 else [0.0, 0.0, 1.0, *_rotation_vector(rng, False)]
        if links[0]["q0"] is hung:
            body["centre"][2] *= -1
        return _with(links, gravity, [pin | {"name": "pin", "a": {"link": "a", "position": arm}}])
    return _with(links, gravity, [pin | {"name": "pin", "a": {"link": "a"}}])


def _with(links, gravity, pins) -> dict:
    return {"scene": {"gravity": gravity}, "link": links, "loop": pins}


def ground(rng) -> dict:
    """A hinged line on stiff ground; or a pendulum close to critical beside a ball on stiff ground."""
    k = float(10.0 ** rng.integers(0, 14))
    if rng.random() < 0.5:
        length, rigidity, radius = 100.0, 1e5, 0.05
        k *= rigidity / length**4
        weight = min(1e3, 0.01 * k)
        segment = {
            "length": length / 4,
            "radius": radius,
            "young_modulus": rigidity / (np.pi / 4 * radius**4),
            "poisson_ratio": 0.5,
            "density": weight / 9.81 / (np.pi * radius**2),
            "modes": {"bend_y": 2},
        }
        hinge = {"type": "revolute", "axis": [0.0, 1.0, 0.0]}
        links = [{"name": "a", "joint": hinge, "rod": {"segment": [dict(segment) for _ in range(4)]}}]
        plane = {"kind": "half_space", "point": [0.0, 0.0, weight / k - radius]}
        contact = {"name": "ground", "a": "a", "b": plane, "stiffness": k}
    else:
        k = max(k, 1e3)
        factor = float(rng.choice([1.0001, 0.9999, 1.01, 0.99, 2.0]))
        joint = {"type": "revolute", "axis": [0.0, 1.0, 0.0], "stiffness": factor * 9.81 * 0.5}
        body = {"mass": 1.0, "centre": [0.0, 0.0, 0.5], "inertia": (0.01 * np.eye(3)).tolist()}
        slide = {"type": "prismatic", "axis": [0.0, 0.0, 1.0]}
        rests = {"name": "b", "joint": slide, "position": [3.0, 0.0, 0.1 - 9.81 / k], "body": {"mass": 1.0}}
        links = [{"name": "a", "joint": joint, "body": body}, rests]
        ball = {"link": "b", "radius": 0.1}
        contact = {"name": "ground", "a": ball, "b": {"kind": "half_space"}, "stiffness": k}
    return {"scene": {"gravity": [0.0, 0.0, -9.81]}, "link": links, "contact": [contact]}


def floors(rng) -> dict:
    """A rod on a floor that rubs, hinged or held by springs."""
    segment = _segment(rng, bend_y=2, **({"bend_z": 1} if rng.random() < 0.5 else {}))
    rod = {"name": "a", "rod": {"segment": [dict(segment) for _ in range(int(rng.integers(1, 3)))]}}
    length = sum(part["length"] for part in rod["rod"]["segment"])
    if rng.random() < 0.7:
        rod["joint"] = {"type": "revolute", "axis": [0.0, 1.0, 0.0], "stiffness": 1.0}
    depth = _round(0.1 * segment["radius"])
    plane = {"kind": "half_space", "point": [0.0, 0.0, depth - segment["radius"]], "normal": [0.0, 0.0, 1.0]}
    contact = {"name": "floor", "a": "a", "b": plane, "stiffness": _round(10 ** rng.uniform(4, 6))}
    if rng.random() < 0.5:
        contact |= {"friction": 0.5, "slip_velocity": 1e-2}
    links = [rod]
    if rng.random() < 0.3:
        links.append({"name": "b", "parent": "a", "body": _body(rng, 0.02, 0.1), "at": _round(0.6 * length)})
    return {"scene": {"gravity": [0.0, 0.0, -9.81]}, "link": links, "contact": [contact]}


FAMILIES = (tree, balls, cords, loops, ground, floors)
#: Sizes of states, where they are not those of large motions: surfaces must not be deep in each other.
STATES = {"ground": 0.0, "floors": 0.01}


def with_state(recipe: dict, rng, size: float = 1.0) -> dict:
    """The recipe with initial coordinates and velocities where it has none; rotation vectors may be far."""
    lengths = {
        link["name"]: sum(s["length"] for s in link.get("rod", {}).get("segment", ()))
        for link in recipe["link"]
    }
    for link in recipe["link"]:
        kinds = [kind for name, _, kind in plan(recipe) if name == link["name"]]
        if not kinds:
            continue
        sizes = {
            "angle": 0.5,
            "shift": 0.1,
            "curvature": 0.5 / (lengths[link["name"]] or 1.0),
            "strain": 0.02,
        }
        scale = size * np.array([sizes[kind] for kind in kinds])
        q0 = scale * rng.normal(size=len(kinds))
        joint = link.get("joint", {"type": "weld"})["type"]
        first = {"spherical": 0, "free": 3}.get(joint)
        if first is not None:
            q0[first : first + 3] = _rotation_vector(rng, rng.random() < 0.5)
        link.setdefault("q0", _round(q0))
        link.setdefault("v0", _round(scale * rng.normal(size=len(kinds))))
    return recipe
