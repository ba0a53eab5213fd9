"""Numbers that no robot can have, such as millimetres in place of metres, are questioned where they act."""

import pickle
import re

import numpy as np
import pytest
from click.testing import CliRunner

import lissom
from lissom import cli

#: Some rods are loaded until their modes are too few.
pytestmark = pytest.mark.filterwarnings("ignore::lissom.AccuracyWarning")

MATERIAL = {"young_modulus": 3e5, "poisson_ratio": 0.45, "density": 1100.0}
LENGTH, RADIUS = 0.2, 0.01
AXIAL = MATERIAL["young_modulus"] * np.pi * RADIUS**2


def finger(*actuators, radius=RADIUS, **others):
    segment = lissom.Segment(LENGTH, radius, modes={"bend_y": 3}, **MATERIAL)
    return lissom.Rod([segment], actuators=actuators, **others)


def tendon(offset, name="pull"):
    return lissom.Tendon(name, [lissom.Along(offset=offset)], tension=lissom.Input(name, 0.0))


def chamber(area, offset=(0, 0.005)):
    return lissom.Chamber("air", [lissom.Along(offset=offset)], area, lissom.Input("air", 0.0))


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (
            lambda: finger(tendon((0, 6))),
            'The tendon "pull" runs 6 m beside the axis of "rod", which is 0.2 m',
        ),
        (lambda: finger(tendon((3, 4))), "runs 5 m beside"),
        # Offset by half a millimetre in a catheter of a metre's length: less than the length.
        (lambda: finger(tendon((0, 0.15)), radius=5e-4), "runs 0.15 m beside"),
        (
            lambda: finger(chamber(50.0)),
            'The chamber "air" has an area of 50 m², the section of "rod" 0.0003142',
        ),
        (lambda: finger(chamber(0.5)), "is it in square metres?"),
        (lambda: finger(chamber(1e-5, (0, 5.0))), 'The chamber "air" runs 5 m beside'),
        # Guide disks, and bellows beside a rod.
        (lambda: finger(tendon((0, 0.02)), radius=5e-4), None),
        (lambda: finger(tendon((0, 0.03))), None),
        (lambda: finger(chamber(1e-3)), None),
        (lambda: finger(gravity=(0, 0, -9.81e-3)), "its number in mm/ms²"),
        (lambda: finger(gravity=(0, 0, -1.62)), None),
        (lambda: finger(gravity=(0, 0, -1e-2)), None),
    ],
)
def test_advice_asks_for_the_units_of_actuators_and_gravity(model, said):
    asked = model().advice()
    if said is None:
        assert asked == []
    else:
        assert len(asked) == 1
        assert said in asked[0]


SCENE = """version = 1
[scene]
gravity = [0, 0, -9.81e-3]
[[rod]]
[[rod.segment]]
length = 200.0
section = { shape = "given", stiffness = [1e3, 1e3, 1e3, 1e5, 1e5, 1e5], mass = 0.06 }
modes = { bend_y = 3 }
[[tendon]]
name = "pull"
path = [{ offset = [0.0, 500.0] }]
tension = 1.0
[simulation]
t_end = 1000.0
"""


def test_check_asks_what_python_asks(tmp_path):
    """Millimetres, grams and milliseconds, of a section without modulus, density and width."""
    path = tmp_path / "mm.toml"
    path.write_text(SCENE, encoding="utf-8")
    asked = lissom.Scene.load(path).model.advice()
    assert len(asked) == 2
    done = CliRunner().invoke(cli.commands, ["check", str(path)], standalone_mode=False)
    assert done.return_value == 0
    for question in asked:
        assert f"  {question}\n" in done.output


def strain(tension, offset):
    """In the outermost fibre, by hand: pressed along the axis and bent."""
    bending = MATERIAL["young_modulus"] * np.pi * RADIUS**4 / 4
    return tension / AXIAL + tension * offset * RADIUS / bending


@pytest.mark.parametrize("tension", [1000, 100])
def test_absurd_tensions_are_named_in_place_of_nodes(tension):
    found = lissom.statics(finger(tendon((0, 0.006))), u=[tension])
    assert not found.success
    assert "nodes`" not in found.message
    percent = 100 * strain(tension, 0.006)
    assert f'The tendon "pull" pulls with {tension} N' in found.message
    assert f"strain it by {percent:.0f} %" in found.message
    assert f"E A = {AXIAL:.4g} N" in found.message


def test_tensions_that_rods_bear_are_not_questioned():
    model = finger(tendon((0, 0.006)))
    for tension in (0.0, 5.0, 0.99 / strain(1.0, 0.006)):
        assert "more than rods bear" not in lissom.statics(model, u=[tension]).message
    assert "more than rods bear" in lissom.statics(model, u=[1.01 / strain(1.0, 0.006)]).message


def test_failed_runs_name_absurd_tensions_too():
    model = finger(tendon((0, 0.006)))
    run = lissom.simulate(model, 0.1, dt=1e-3, u={"pull": 1000.0})
    rows = lissom.simulate_many(model, 0.1, dt=1e-3, u=[[1.0], [1000.0]])
    for status, message in ((run.status, run.message), (rows.status[1], rows.message[1])):
        assert status != "finished"
        assert 'The tendon "pull" pulls with 1000 N' in message
    assert "more than rods bear" not in rows.message[0]


def test_absurd_loads_of_all_kinds():
    pulled = finger(tip_force=(0, 0, -2000.0))
    assert f'A load pulls with 2000 N, which by the stiffness of the rod of "rod" (E A = {AXIAL:.4g} N)' in (
        lissom.statics(pulled).message
    )
    spread = finger(loads=[lissom.Load(force=(0, 0, -1e4), along=(0, 0.1))])
    assert "A load pulls with 1000 N" in lissom.statics(spread).message
    blown = finger(chamber(1e-4))
    assert "more than rods bear" not in lissom.statics(blown, u=[1e4]).message
    assert 'The chamber "air" presses with 1000 N' in lissom.statics(blown, u=[1e7]).message
    # Each row by itself.
    rows = lissom.statics_many(finger(tendon((0, 0.006))), {"pull": [1.0, 1000.0]})
    assert ["more than rods bear" in message for message in rows.message] == [False, True]


def test_numbers_in_other_units_are_questioned_also_where_the_search_fails():
    """The modulus of a rubber in megapascals; the search may take two steps."""
    rubber = lissom.Segment(0.2, 0.01, 0.3, 0.1, 1100.0, modes={"bend_y": 3})
    found = lissom.statics(lissom.Rod([rubber]), method="descent", max_iter=2)
    assert not found.success
    assert "A Young's modulus of 0.3 Pa is softer than any gel" in found.message


def gas():
    """80 m of a material of 0.3 Pa."""
    segment = lissom.Segment(80.0, 0.5, 0.3, 0.1, 1100.0, modes={"bend_y": 2}, retardation_time=1.0)
    return lissom.Rod([segment], gravity=(0, 0, 0), actuators=[tendon((0, 0.3))])


def messages_of_everything():
    """The message of each function that has one."""
    model = gas()
    run = lissom.simulate(model, 0.02, dt=0.01)
    yield "simulate", run.message
    yield "auto", lissom.simulate(model, 0.02, method="auto").message
    yield "simulate_many", lissom.simulate_many(model, 0.02, dt=0.01, q0=np.zeros((2, 2))).message[1]
    each = lissom.simulate_many([model, model], 0.02, dt=0.01)
    yield "simulate_many of models", each.message[1]
    rest = lissom.statics(model)
    yield "statics", rest.message
    yield "statics_many", lissom.statics_many(model, {"pull": [0.0]}).message[0]
    yield "modes", lissom.modes(model, rest.q).message
    yield "continuation", lissom.continuation(model).message
    yield "actuate", lissom.actuate(model, (80.0, 0, 0)).message
    yield "reach", model.reach({"rod": (80.0, 0, 0)}).message
    stepper = lissom.Simulation(model, dt=0.01)
    stepper.step()
    yield "Simulation", stepper.message
    yield "Simulations", lissom.Simulations(model, count=2, dt=0.01).message(1)


def test_every_message_asks_what_advice_asks():
    questions = gas().advice()
    assert len(questions) == 1
    for name, message in messages_of_everything():
        for question in questions:
            assert message.count(question) == 1, (name, message)


def test_messages_of_copies_ask_once(tmp_path):
    run = lissom.simulate(gas(), 0.02, dt=0.01)
    run.save(tmp_path / "x.lissom")
    assert lissom.load(tmp_path / "x.lissom").message == run.message
    rest = lissom.statics(gas())
    assert pickle.loads(pickle.dumps(rest)).message == rest.message
    sane = finger(gravity=(0, 0, 0))
    assert lissom.simulate(sane, 0.01, dt=1e-3).message.count("?") == 0


SLENDER = {"young_modulus": 1e9, "poisson_ratio": 0.4, "density": 1100.0, "modes": {"bend_y": 2}}
BOX = lissom.Box((100, 0, -30), (30, 50, 5))


def among(obstacle, joint=None, a="rod", **others):
    link = lissom.Link("rod", rod=[lissom.Segment(0.2, 1e-3, **SLENDER)], joint=joint or lissom.Weld())
    contacts = [lissom.Contact(a, obstacle, stiffness=1e4, name="touch")]
    return lissom.Robot([link], contacts=contacts, **others)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        # What is written in millimetres.
        (lambda: among(lissom.Capsule((50, 0, -20), (120, 0, -20), 5)), "lies 48.85 m from the base of"),
        (lambda: among(BOX), "a box lies 74.33 m from"),
        (lambda: among(lissom.HalfSpace((0, 0, -50))), "a half space lies 50 m from the base of"),
        (lambda: among(lissom.Sphere((100, 0, 0), 20)), "a sphere of 20 m lies 80 m from"),
        (lambda: among(lissom.Tube([(-10, 0, 0), (100, 0, 0), (200, 0, 50)], 3)), "which is 0.002 m wide"),
        (lambda: among(lissom.HalfSpace((0, 0, -1)), a=lissom.Ball("rod", 30.0)), "a ball on"),
        # The robot in millimetres, the obstacle in metres.
        (
            lambda: lissom.Robot(
                [lissom.Link("rod", rod=[lissom.Segment(500.0, 0.5, **SLENDER)])],
                contacts=[lissom.Contact("rod", lissom.Sphere((0.3, 0, -0.05), 0.01), stiffness=1e4)],
            ),
            "is 0.02 m large, and",
        ),
        # Far, but it may come: what moves along an axis, or freely, or with the base.
        (lambda: among(lissom.HalfSpace((0, 0, -50)), lissom.Free()), None),
        (lambda: among(lissom.HalfSpace((0, 0, -50)), lissom.Prismatic((0, 0, 1))), None),
        (lambda: among(lissom.HalfSpace((0, 0, -1.9))), None),
        (lambda: among(lissom.HalfSpace((0, 0, -2.1))), "they never touch; are all lengths in metres?"),
        (lambda: among(lissom.Capsule((0.05, 0, -0.02), (0.12, 0, -0.02), 5e-3)), None),
        (lambda: among(lissom.Tube([(-0.01, 0, 0), (0.3, 0, 0)], 0.1)), None),
        # A bump of a tenth of a millimetre under a catheter.
        (lambda: among(lissom.Sphere((0.1, 0, -2e-3), 1e-4)), None),
        (lambda: among(lissom.Sphere((0, 0, -100), 99.0)), None),
    ],
)
def test_obstacles_in_other_units_than_the_robot(model, said):
    asked = model().advice()
    if said is None:
        assert asked == []
    else:
        assert len(asked) == 1, asked
        assert said in asked[0]
        assert asked[0].endswith("are all lengths in metres?")


def test_links_of_a_chain_reach_together():
    """The floor of the second test is 10 times as far as the first link reaches, not as both do."""
    rod = [lissom.Segment(0.2, 1e-3, **SLENDER)]
    links = [
        lissom.Link("rod", rod=rod),
        lissom.Link("next", parent="rod", joint=lissom.Revolute((0, 1, 0)), rod=rod),
    ]

    def asked(height, a):
        return lissom.Robot(links, contacts=[lissom.Contact(a, lissom.HalfSpace((0, 0, -height)))]).advice()

    assert len(asked(3.0, "rod")) == 1
    assert asked(3.0, "next") == []
    assert len(asked(5.0, "next")) == 1


def given(stretch, bending, modes, length=0.2):
    section = lissom.Section.given((bending,) * 3 + (stretch,) * 3, 0.1)
    return lissom.Rod([lissom.Segment(length, section=section, modes=modes)])


@pytest.mark.parametrize(
    ("model", "said"),
    [
        # 5 mm and 20 mm, written as such; and half a metre in a fifth of one.
        (lambda: finger(radius=5), '"rod" is 10 m wide'),
        (lambda: finger(radius=0.5), '"rod" is 1 m wide and 0.2 m long; are both in metres?'),
        (lambda: finger(radius=0.25), None),
        # A round section of 2 mm of steel: E A = 2.6e6 N, E I = 2.6 N m² or 2.6e6 N mm².
        (lambda: given(2.6e6, 2.6, {"bend_y": 2, "stretch": 1}), None),
        (
            lambda: given(2.6e6, 2.6e6, {"bend_y": 2, "stretch": 1}),
            "those of a rod that is 4 m wide, and it is 0.2 m",
        ),
        (lambda: given(2.6e6, 5e4, {"bend_y": 2, "stretch": 1}, 0.1), "is bending in N m²?"),
        # Stiffness of strains without modes does not matter.
        (lambda: given(1.0, 1.0, {"bend_y": 2}), None),
        (lambda: given(1.0, 1.0, {"stretch": 2}), None),
    ],
)
def test_sections_in_millimetres(model, said):
    asked = [question for question in model().advice() if "shear would add" not in question]
    if said is None:
        assert asked == []
    else:
        assert len(asked) == 1, asked
        assert said in asked[0]


def test_targets_far_from_the_robot():
    model = finger(tendon((0, 0.006)))
    far = lissom.actuate(model, (150.0, 0, -50.0))
    assert far.message.endswith("The robot is 0.200 m long: are the targets in metres?")
    near = lissom.actuate(model, (0.1, 0, -0.5))
    assert not near.success
    assert "in metres" not in near.message
    reached = model.reach("rod", (150.0, 0, -50.0), restarts=0)
    assert reached.message.endswith("The robot is 0.200 m long: are the targets in metres?")
    assert "in metres" not in model.reach("rod", (0.1, 0, -0.5), restarts=0).message


def cable(length, span, **modes):
    segment = lissom.Segment(length, 2e-3, 2e10, poisson_ratio=0.3, density=4000, modes={"bend_y": 6} | modes)
    hinge = lissom.Revolute((0, 1, 0))
    pin = lissom.Loop("cable", (None, None, (span, 0, 0)), hinge)
    return lissom.Robot([lissom.Link("cable", joint=hinge, rod=[segment])], loops=[pin])


def test_spans_longer_than_the_cable_say_both_lengths():
    said = r"between \"cable\" and the world \(0\.8 m apart, and what joins them is only 0\.6 m long\)"
    for call in (lissom.statics, lambda model: lissom.simulate(model, 0.1)):
        with pytest.raises(ValueError, match=said):
            call(cable(0.6, 0.8))
    # What stretches is not too short, and what is long enough neither.
    assert lissom.statics(cable(0.6, 0.8, stretch=1), space_error=False).success
    assert lissom.statics(cable(0.82, 0.8), space_error=False).success
    # A bar at its end makes it longer, a base that slides likewise.
    far = lissom.Loop("cable", (None, None, (0.8, 0, 0)), lissom.Distance(0.1))
    links = cable(0.6, 0.8).links
    with pytest.raises(ValueError, match=r"0\.8 m apart, and what joins them is only 0\.7 m long"):
        lissom.statics(lissom.Robot(links, loops=[far]))
    away = lissom.Link("slide", joint=lissom.Prismatic((0, 1, 0)), body=lissom.Body(1.0))
    on_it = lissom.Link("cable", parent="slide", joint=links[0].joint, rod=links[0].rod)
    with pytest.raises(ValueError, match="misses by") as caught:
        lissom.statics(lissom.Robot([away, on_it], loops=cable(0.6, 0.8).loops))
    assert not re.search("apart", str(caught.value))
