"""Results and reports depend on the view of a model, for any kind of model."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom import advice, report
from lissom.files import arrays, dataset
from lissom.results import Run
from lissom.views import View, view

PACKAGE = Path(lissom.__file__).parent
SCENES = Path(__file__).parents[2] / "scenes"


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
    data = dataset(run)
    assert data["position_left"].dims == ("shape_time", "X_left", "axis")
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
    told = shown.document()["things"]
    assert all(len(thing["centres"]) == len(shown.t) for thing in told[:2])


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
    assert list(dataset(run).coordinate.values) == ["q0", "q1", "q2"]
    assert "position" not in dataset(run)
    page = report.build(run)
    assert titles(page) == ["Coordinates", "Energy", "Solver", "Scene"]
    assert page.lead.startswith("Rod, 3 generalised coordinates")


@pytest.mark.parametrize("name", ["lab-pendulum", "lab-hanging"])
def test_advice_takes_any_view(name, monkeypatch):
    scene = lissom.Scene.load(SCENES / f"{name}.toml")
    plain = view.dispatch(object)
    monkeypatch.setattr(advice, "view", plain)
    assert not any("modes" in sentence for sentence in advice.advice(scene))
