"""Robots as plain data, rendered as scene text and as calls of the Python API.

A recipe is the tree of a scene ([[link]], [[loop]], [[tendon]], [[contact]]), so that its scene is the tree
itself. Initial coordinates and velocities are keys of the links, as in scenes.
"""

import numpy as np

import lissom
from fuzz import mutate


def toml(recipe: dict) -> str:
    """The scene; the run has settings that nothing depends on."""
    return mutate.write({"version": 1} | recipe | {"simulation": {"t_end": 1.0, "dt": 1e-3}})


def code(recipe: dict) -> str:
    """The robot as an expression of the Python API."""
    links = recipe["link"]
    parts = {
        "gravity": repr(recipe["scene"]["gravity"]),
        "loads": _list(
            _call("Load", each, link=link["name"]) for link in links for each in link.get("load", ())
        ),
        "supports": _list(
            _call("Support", each, link=link["name"]) for link in links for each in link.get("support", ())
        ),
        "actuators": _list(_tendon(each) for each in recipe.get("tendon", ())),
        "loops": _list(_loop(each) for each in recipe.get("loop", ())),
        "contacts": _list(_contact(each) for each in recipe.get("contact", ())),
    }
    given = "".join(f", {name}={text}" for name, text in parts.items() if text != "[]")
    return f"lissom.Robot({_list(map(_link, links))}{given})"


def by_api(recipe: dict) -> lissom.Robot:
    return eval(code(recipe), {"lissom": lissom, "np": np})


def by_scene(recipe: dict) -> lissom.Robot:
    return lissom.Scene.loads(toml(recipe)).model


def state(recipe: dict, model: lissom.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Initial coordinates and velocities."""
    q, v = np.zeros(model.n), np.zeros(model.n)
    for link in recipe["link"]:
        part = model.slice(link["name"])
        q[part], v[part] = link.get("q0", 0.0), link.get("v0", 0.0)
    return q, v


def _list(texts) -> str:
    return "[" + ", ".join(texts) + "]"


def _call(name: str, arguments: dict, *texts: str, **more) -> str:
    given = [*texts, *(f"{key}={value!r}" for key, value in (arguments | more).items())]
    return f"lissom.{name}({', '.join(given)})"


def _typed(arguments: dict, key: str) -> str:
    """The object whose class is the value of `key`: "half_space" is `HalfSpace`."""
    arguments = dict(arguments)
    return _call(arguments.pop(key).title().replace("_", ""), arguments)


def _link(link: dict) -> str:
    link = {key: value for key, value in link.items() if key not in ("load", "support", "q0", "v0")}
    parts = [repr(link.pop("name"))]
    if "joint" in link:
        parts.append(f"joint={_typed(link.pop('joint'), 'type')}")
    if "rod" in link:
        segments = [_call("Segment", segment) for segment in link.pop("rod")["segment"]]
        parts.append(f"rod={_list(segments)}")
    if "body" in link:
        parts.append(f"body={_call('Body', link.pop('body'))}")
    return _call("Link", link, *parts)


def _loop(loop: dict) -> str:
    loop = dict(loop)
    ends = [_call("LoopEnd", loop.pop(end, {})) for end in ("a", "b")]
    return _call("Loop", loop, *ends, _typed(loop.pop("kind"), "type"))


def _contact(contact: dict) -> str:
    contact = dict(contact)
    return _call("Contact", contact, *(_surface(contact.pop(side)) for side in ("a", "b")))


def _surface(surface) -> str:
    if isinstance(surface, str):
        return repr(surface)
    return _typed(surface, "kind") if "kind" in surface else _call("Ball", surface)


def _tendon(tendon: dict) -> str:
    tendon = dict(tendon)
    path = _list(
        _call("Via", {"link": None} | part) if "point" in part else _call("Along", part)
        for part in tendon.pop("path")
    )
    return _call("Tendon", tendon, f"path={path}")
