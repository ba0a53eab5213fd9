"""`[[loop]]` in scenes: resulting loops, errors, and the command line."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom import (
    Body,
    Distance,
    Gear,
    Link,
    Loop,
    LoopEnd,
    Planar,
    Revolute,
    Robot,
    Spherical,
    Universal,
    Weld,
)

SCENES = Path(__file__).parents[3] / "scenes"

BARS = """version = 1
[[link]]
name = "crank"
joint = { type = "revolute", axis = [0, 1, 0] }
body = { mass = 0.1, centre = [0.1, 0, 0], inertia = [[1e-5, 0, 0], [0, 4e-4, 0], [0, 0, 4e-4]] }
[[link]]
name = "coupler"
parent = "crank"
position = [0.2, 0, 0]
joint = { type = "revolute", axis = [0, 1, 0] }
body = { mass = 0.1, centre = [0.1, 0, 0], inertia = [[1e-5, 0, 0], [0, 4e-4, 0], [0, 0, 4e-4]] }
"""

END = """
[simulation]
t_end = 0.1
"""

PIN = """[[loop]]
kind = { type = "spherical" }
a = { link = "coupler", position = [0.2, 0, 0] }
b = { position = [0.3, 0, 0] }
"""


def scene(loops, settings=""):
    return lissom.Scene.loads(BARS + loops + END + settings)


def robot(*loops):
    hinge = Revolute((0, 1, 0))
    body = Body(0.1, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 4e-4, 4e-4]))
    links = [
        Link("crank", joint=hinge, body=body),
        Link("coupler", parent="crank", position=(0.2, 0, 0), joint=hinge, body=body),
    ]
    return Robot(links, loops=loops)


def command(*arguments, cwd):
    """Run the command line."""
    whole = [sys.executable, "-m", "lissom", *map(str, arguments)]
    return subprocess.run(whole, cwd=cwd, capture_output=True, text=True, timeout=100)


def test_scenes_make_the_loops_of_python():
    text = """
[[loop]]
name = "ball"
kind = { type = "spherical" }
a = "coupler"
b = { link = "crank", position = [0.1, 0, 0], orientation = [0.8, 0.6, 0, 0] }
[[loop]]
kind = { type = "distance", length = 0.3 }
a = { position = [0, 0, 1] }
b = "coupler"
[[loop]]
kind = { type = "gear", ratio = -2, offset = 0.5 }
a = "crank.angle"
b = "coupler.angle"
[[loop]]
name = "cross"
kind = { type = "universal", axis1 = [1, 0, 0], axis2 = [0, 0, 2] }
a = "crank"
b = "coupler"
[[loop]]
name = "ground"
kind = { type = "weld" }
a = "coupler"
[[loop]]
name = "table"
kind = { type = "planar", normal = [0, 1, 0] }
b = "coupler"
"""
    beside = LoopEnd("crank", position=(0.1, 0, 0), orientation=(0.8, 0.6, 0, 0))
    wanted = robot(
        Loop("coupler", beside, Spherical(), name="ball"),
        Loop((None, None, (0, 0, 1)), "coupler", Distance(0.3)),
        Loop("crank.angle", "coupler.angle", Gear(-2, offset=0.5)),
        Loop("crank", "coupler", Universal((1, 0, 0), (0, 0, 2)), name="cross"),
        Loop("coupler", None, Weld(), name="ground"),
        Loop(None, "coupler", Planar((0, 1, 0)), name="table"),
    )
    found = scene(text).model
    assert found.loops == wanted.loops
    q = [0.3, -0.7]
    np.testing.assert_array_equal(found.loop_gaps(q), wanted.loop_gaps(q))


def test_runs_are_those_of_python():
    made = scene(PIN)
    closed = robot(Loop(("coupler", None, (0.2, 0, 0)), (None, None, (0.3, 0, 0)), Spherical()))
    wanted = lissom.simulate(closed, 0.1)
    np.testing.assert_array_equal(made.run().q, wanted.q)
    assert "moved by" in made.run().message


@pytest.mark.parametrize(
    ("loop", "line", "message"),
    [
        ('kind = { type = "sphericl" }\na = "crank"', 1, 'did you mean "spherical"'),
        ('kind = { type = "weld" }\na = "couple"', 2, 'no link is called "couple"; did you mean "coupler"'),
        ('kind = { type = "weld" }\na = { link = "cranc" }', 2, 'loop[0].a.link: no link is called "cranc"'),
        ('kind = { type = "weld" }\na = { lnk = "crank" }', 2, "did you mean `link`"),
        ('kind = { type = "weld" }\na = 3', 2, "expected text in quotes or a table"),
        ('kind = "weld"\na = "crank"', 1, 'got the text "weld"; expected a table, such as { type = "weld" }'),
        ('kind = { type = "revolute" }\na = "crank"', 1, "axis is missing; add axis: direction"),
        ('kind = { type = "universal", axis1 = [1, 0, 0] }\na = "crank"', 1, "axis2 is missing"),
        ('kind = { type = "distance" }\na = "crank"', 1, "length is missing; add length: distance"),
        ('kind = { type = "distance", length = 0 }\na = "crank"', 1, "loop[0].kind.length: got 0"),
        ('kind = { type = "weld", axis = [0, 1, 0] }\na = "crank"', 1, "it takes nothing but its type"),
        ('kind = { type = "weld", ratio = 1 }\na = "crank"', 1, 'a joint of type "weld" does not take it'),
        (
            'kind = { type = "gear", length = 1 }\na = "crank.angle"\nb = "coupler.angle"',
            1,
            "it takes ratio, offset",
        ),
        (
            'kind = { type = "gear", ratio = 0 }\na = "crank.angle"\nb = "coupler.angle"',
            1,
            "other than zero",
        ),
        (
            'kind = { type = "gear" }\na = "crank.angel"\nb = "coupler.angle"',
            2,
            'did you mean "crank.angle"',
        ),
        ('kind = { type = "gear" }\na = "crank.angle"\nb = "crank.angle"', 3, "two different ones"),
        ('kind = { type = "gear" }\na = "crank.angle"', 0, "a gear ties two coordinates"),
        (
            'kind = { type = "gear" }\na = { link = "crank" }\nb = "crank.angle"',
            2,
            "a gear ties two coordinates",
        ),
        ('kind = { type = "weld" }\na = { link = "crank", at = 0.1 }', 2, "the link has no rod"),
        ('kind = { type = "weld" }\na = "crank"\nb = { at = 0.1 }', 3, "the world has no arc length"),
        ('kind = { type = "weld" }\nb = { position = [1, 0, 0] }', 2, "two points of the world"),
        ('kind = { type = "weld" }\na = "crank"\nb = "crank"', 3, "one and the same section"),
        ('kind = { type = "weld" }\na = { link = "crank", orientation = [2, 0, 0, 0] }', 2, "of norm 1"),
        (
            'kind = { type = "weld" }\na = { link = "crank", position = [nan, 0, 0] }',
            2,
            "loop[0].a.position",
        ),
        ('kind = { type = "planar", normal = [0, 0, 0] }\na = "crank"', 1, "not all of them zero"),
        ('name = ""\nkind = { type = "weld" }\na = "crank"', 1, "loop[0].name: got ''"),
        ('a = "crank"', 0, "loop[0].kind: missing"),
    ],
)
def test_what_makes_no_sense_is_refused_at_its_line(loop, line, message):
    with pytest.raises(lissom.SceneError) as refused:
        scene(f"[[loop]]\n{loop}\n")
    (problem,) = refused.value.problems
    assert message in str(problem)
    # Line numbers relative to [[loop]].
    assert problem.line == len(BARS.splitlines()) + 1 + line, str(refused.value)


def test_names_of_loops_are_their_own():
    twice = '[[loop]]\nname = "pin"\nkind = { type = "weld" }\na = "crank"\n'
    with pytest.raises(lissom.SceneError, match=r'loop\[1\].name: got "pin", the name of another loop'):
        scene(twice + twice.replace('"crank"', '"coupler"'))
    unnamed = '[[loop]]\nkind = { type = "weld" }\na = "crank"\n'
    names = [each.name for each in scene(unnamed + unnamed).model.loops]
    assert names == ["crank to the world", "crank to the world 2"]


def test_all_problems_of_many_coordinates_are_short():
    """The message about a misspelt coordinate does not list all of many coordinates."""
    rod = "[[link.rod.segment]]\nlength = 1\nradius = 0.01\nyoung_modulus = 1e6\nshear_modulus = 4e5\n"
    text = f'version = 1\n[[link]]\nname = "rod"\n{rod}density = 1000\nmodes = {{ bend_y = 20 }}\n'
    loop = '[[loop]]\nkind = { type = "gear" }\na = "rod.bend_y[3"\nb = "x"\n'
    with pytest.raises(lissom.SceneError) as refused:
        lissom.Scene.loads(text + loop + END)
    first, second = refused.value.problems
    assert 'did you mean "rod.bend_y[3]"?' in str(first)
    assert 'expected one of 20 coordinates, such as "rod.bend_y[0]"' in str(second)


def test_differences_do_not_hold_loops():
    with pytest.raises(lissom.SceneError) as refused:
        scene(PIN, 'jac = "forward"\n')
    (problem,) = refused.value.problems
    assert problem.key == "simulation.jac"
    assert "closed loops" in str(problem)
    assert "expected" in problem.right


@pytest.mark.parametrize("method", ["radau", "auto", "dop853"])
def test_scenes_with_loops_run_with_adaptive_methods(method):
    made = scene(PIN, f'method = "{method}"\n')
    run = made.run()
    assert run.success, run.message
    assert "moved by" in run.message
    assert np.abs(made.model.loop_gaps(run.q)).max() < 1e-9


def test_loops_belong_to_robots():
    loop = '[[loop]]\nkind = { type = "weld" }\n'
    rod = "[[rod]]\n[[rod.segment]]\nlength = 1\nradius = 0.01\nyoung_modulus = 1e6\nshear_modulus = 4e5\n"
    for model in ("[pendulum]\n", f"{rod}density = 1000\nmodes = {{ bend_y = 1 }}\n"):
        with pytest.raises(lissom.SceneError, match="it ties links of a robot"):
            lissom.Scene.loads(f"version = 1\n{model}{loop}{END}")
    with pytest.raises(lissom.SceneError, match=r"double brackets: \[\[loop\]\]"):
        scene(loop.replace("[[loop]]", "[loop]"))


def test_loops_hold_bases_that_move_to_the_world():
    moving = "[base_motion]\ntranslation = { amplitude = [0.02, 0, 0], frequency = 1 }\n"
    made = lissom.Scene.loads(BARS + PIN + moving + END)
    run = made.run()
    assert run.success, run.message
    assert np.abs(made.model.loop_gaps(run.q, t=run.t)).max() < 1e-9


def test_the_command_line_refuses_loops_that_cannot_be_closed(tmp_path):
    far = tmp_path / "far.toml"
    far.write_text(BARS + PIN.replace("[0.3, 0, 0]", "[1.3, 0, 0]") + END)
    for asked in (["check"], ["run", "-o", "a"], ["statics", "-o", "b"], ["modes", "-o", "c"], ["explain"]):
        done = command(*asked, far, cwd=tmp_path)
        assert done.returncode == 2, done
        assert "open loop: loops[0] misses by 0.9" in done.stderr
        assert "Traceback" not in done.stderr


def test_explain_tells_loops(tmp_path):
    text = BARS + PIN.replace("spherical", "revolute").replace('" }', '", axis = [0, 1, 0] }') + END
    (tmp_path / "bars.toml").write_text(text.replace("0.3, 0, 0", "0.4, 0, 0"))
    explained = command("explain", tmp_path / "bars.toml", cwd=tmp_path).stdout
    for line in (
        "loop coupler to the world +5 constraints: revolute joint, coupler to the world",
        "closed loops +5 constraints held by multipliers: 7 unknowns of a step",
        "redundant constraints +4 of coupler to the world",
        "coupler to the world +.* of the residual, .* of the Jacobian: 2 coordinates",
        "method +generalised alpha .*0.8",
        "why +closed loops need numerical damping",
    ):
        assert any(re.search(line, found) for found in explained.splitlines()), (line, explained)


@pytest.mark.parametrize(("name", "constraints"), [("hoop", 6), ("six_wires", 30)])
def test_the_examples_stay_closed(name, constraints):
    made = lissom.Scene.load(SCENES / f"{name}.toml")
    assert made.model.constraints == constraints
    motion = made.run()
    assert motion.success, motion.message
    assert np.abs(made.model.loop_gaps(motion.q, t=motion.t)).max() < 1e-9
