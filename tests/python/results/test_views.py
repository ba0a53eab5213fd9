"""Results and reports depend on the view of a model, for any kind of model."""

import ast
import copy
import inspect
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom.analysis import advice
from lissom.drawing import report
from lissom.model.paths import constructed
from lissom.model.views import View, view
from lissom.results.files import arrays, trajectory
from lissom.results.runs import Run

PACKAGE = Path(lissom.__file__).parent
SCENES = Path(__file__).parents[3] / "scenes"


ONE_ALONG_Y = np.broadcast_to([0.0, 1.0, 0.0], (301, 49, 3))


def run_of(name, **changes):
    """A run of a scene with another view of its model."""
    scene = lissom.Scene.load(SCENES / f"{name}.toml")
    run = Run(scene, scene.run())
    run.__dict__["view"] = replace(view(scene.model), **changes)
    return run


def titles(page):
    return [section.title for section in page.sections]


def test_nobody_else_asks_what_kind_of_model_it_is():
    kinds = {"Rod", "SpringPendulum"}
    asks = []
    for file in PACKAGE.rglob("*.py"):
        if file.name == "views.py" or "evidence" in file.relative_to(PACKAGE).parts:
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("isinstance", "type"):
                named = {
                    found.id
                    for argument in node.args
                    for found in ast.walk(argument)
                    if isinstance(found, ast.Name)
                }
                asks += [(file.name, node.lineno)] if named & kinds else []
    assert asks == []


def test_every_link_is_kept_and_drawn():
    left = view(lissom.Scene.load(SCENES / "tentacle.toml").model)
    (link,), (tip,) = left.links, left.frames
    run = run_of(
        "tentacle",
        links=[replace(link, name="left"), replace(link, name="right", pose=moved(link.pose))],
        frames=[replace(tip, name="hand"), replace(tip, name="foot")],
    )
    data = trajectory(run).variables
    assert data["position_left"].dimensions == ("shape_time", "X_left", "axis")
    np.testing.assert_allclose(
        data["position_right"].values - data["position_left"].values, ONE_ALONG_Y, atol=1e-15
    )
    np.testing.assert_array_equal(arrays(run)["position_right"], data["position_right"].values)
    page = report.build(run)
    assert titles(page)[:4] == ["Motion", "Hand", "Foot", "Coordinates"]
    shown = page.sections[0].parts[0].scene
    assert [thing.name for thing in shown.things[:5]] == [
        *("left", "right", "hand, foot", "paths of tips", "initial shape"),
    ]
    left, right, tips, paths, shapes = shown.things[:5]
    assert list(tips.names) == ["hand", "foot"]
    # Two lines in one, each followed by a break.
    points = paths.points[0]
    np.testing.assert_array_equal(
        np.flatnonzero(np.isnan(points[:, 0])), len(points) // 2 * np.array([1, 2]) - [1, 1]
    )
    y = shapes.points[0][:, 1]
    np.testing.assert_allclose(y[49 + 1 : -1], y[:49] + 1.0, rtol=1e-5)
    np.testing.assert_allclose(right.centres - left.centres, ONE_ALONG_Y[: len(shown.t)], atol=1e-12)
    np.testing.assert_array_equal(right.turns, left.turns)
    reported = shown.document()["things"]
    assert all(len(thing["centres"]) == len(shown.t) for thing in reported[:2])


def moved(pose):
    """The same, moved by one metre along y."""

    def there(q, X, t):
        found = pose(q, X, t).copy()
        found[..., 1, 3] += 1.0
        return found

    return there


def test_of_an_unknown_kind_of_model_the_numbers_are_left():
    unknown = view.dispatch(object)
    run = run_of("lab-hanging")
    run.__dict__["view"] = unknown(run.scene.model)
    assert run.view == View("Rod", run.view.coordinates)
    data = trajectory(run)
    assert list(data.coordinates["coordinate"].values) == ["q0", "q1", "q2"]
    assert "position" not in data.variables
    page = report.build(run)
    assert titles(page) == ["Coordinates", "Energy", "Solver", "Scene"]
    assert page.lead.startswith("Rod, 3 generalised coordinates")


@pytest.mark.parametrize("name", ["lab-pendulum", "lab-hanging"])
def test_advice_takes_any_view(name, monkeypatch):
    scene = lissom.Scene.load(SCENES / f"{name}.toml")
    plain = view.dispatch(object)
    monkeypatch.setattr(advice, "view", plain)
    assert not any("shear would add" in sentence for sentence in advice.advice(scene))


def every_argument_of_a_rod():
    segment = lissom.Segment(
        0.5, 0.01, modes={"bend_y": 2, "stretch": 1}, young_modulus=1e6, poisson_ratio=0.4, density=1000.0
    )
    return {
        "segments": [segment],
        "base_position": (0.1, 0.2, 0.3),
        "base_orientation": (0.6, 0.8, 0.0, 0.0),
        "gravity": (0.0, 1.0, -2.0),
        "tip_force": (0.1, 0.2, 0.3),
        "tip_moment": (0.01, 0.02, 0.03),
        "tip_mass": 0.1,
        "loads": [lissom.Load(force=(0.0, 0.0, 1.0))],
        "bodies": [lissom.Body(0.2, at=0.25)],
        "base_motion": lissom.BaseMotion(axis=(0, 0, 1), angle=lambda t: t),
        "supports": [lissom.Support(at=0.3, stiffness=10.0)],
        "fluid": lissom.Fluid(10.0),
        "actuators": [lissom.Tendon("tendon", [lissom.Along("rod", offset=(0.005, 0.0))], tension=1.0)],
        "contacts": [lissom.Contact("rod", lissom.HalfSpace((0, 0, -5)), friction=0.3)],
        "magnets": [lissom.Magnet((0.1, 0.0, 0.0), at=0.2)],
        "field": (0.0, 0.0, 0.01),
    }


def every_argument_of_a_robot():
    arguments = every_argument_of_a_rod()
    arm = lissom.Link("arm", joint=lissom.Revolute((0, 0, 1)), body=lissom.Body(1.0, centre=(0.1, 0, 0)))
    links = [lissom.Link("rod", rod=arguments["segments"]), arm]
    names = ("gravity", "fluid", "base_motion", "actuators", "contacts", "field")
    shared = {name: arguments[name] for name in names}
    on_rod = {
        "loads": [lissom.Load(link="rod", force=(0.0, 0.0, 1.0))],
        "bodies": [lissom.Body(0.2, link="rod", at=0.25)],
        "supports": [lissom.Support(link="rod", at=0.3, stiffness=10.0)],
        "magnets": [lissom.Magnet((0.1, 0.0, 0.0), link="rod", at=0.2)],
        "loops": [lissom.Loop(("rod",), (None, None, (0.5, 0.0, 0.0)), lissom.Spherical())],
    }
    return {"links": links} | shared | on_rod


def rebuilt_with_loads(model):
    return view(model).with_loads([])


def rebuilt_by_a_path(model):
    return type(model)(**constructed(model))


REBUILT = [copy.copy, copy.deepcopy, rebuilt_with_loads, rebuilt_by_a_path]


@pytest.mark.parametrize(
    ("kind", "arguments", "rebuild"),
    [(lissom.Rod, every_argument_of_a_rod, rebuild) for rebuild in REBUILT]
    + [(lissom.Robot, every_argument_of_a_robot, rebuild) for rebuild in REBUILT],
)
def test_no_argument_is_lost_where_a_model_is_rebuilt(kind, arguments, rebuild):
    given = arguments()
    # A new argument must be entered above.
    assert set(given) == set(inspect.signature(kind).parameters)
    model = kind(**given)
    found = rebuild(model)
    assert type(found) is kind
    for name in given:
        wanted, value = getattr(model, name), getattr(found, name)
        if name == "base_motion":
            assert value.angle is wanted.angle
            assert value.axis == wanted.axis
        else:
            assert repr(value) == repr(wanted), name
            assert value == wanted or not isinstance(value, tuple), name
