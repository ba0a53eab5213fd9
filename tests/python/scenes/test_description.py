"""Parts that are described once, in the core: classes, stub and schema are views of the same tables."""

import copy
import dataclasses
import gc
import inspect
import json
import math
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lissom
import write_described
from lissom import (
    ActiveStrain,
    Along,
    Ball,
    BaseMotion,
    Body,
    Box,
    Capsule,
    Chamber,
    Contact,
    ConvexMesh,
    Cylindrical,
    Distance,
    DistanceGrid,
    Fluid,
    Free,
    Gear,
    HalfSpace,
    Harmonic,
    HeightField,
    Input,
    Link,
    Load,
    Loop,
    LoopEnd,
    Mesh,
    Mimic,
    Motor,
    Planar,
    Prismatic,
    Revolute,
    Section,
    Segment,
    Sphere,
    Spherical,
    Support,
    Tendon,
    Tube,
    Universal,
    Via,
    Weld,
    _lissom,
)
from lissom.results import records

SEGMENT = """length = 0.3
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.4
density = 1070
modes = { bend_y = 2, bend_z = 1 }
"""

LINKS = f"""version = 1
[[link]]
name = "arm"
joint = {{ type = "revolute", axis = [0, 1, 0] }}
[[link.rod.segment]]
{SEGMENT}[[link]]
name = "block"
position = [0.3, 0, -0.1]
joint = {{ type = "free" }}
body = {{ mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }}
"""

END = """
[simulation]
t_end = 0.1
"""

SOFT = Segment(0.3, 0.01, 3e5, poisson_ratio=0.4, density=1070, modes={"bend_y": 2})

#: A tetrahedron.
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]

EACH = [
    Section.circle(0.01),
    Section.hollow_circle((0.02, 0.01), 0),
    Section.rectangle(0.1, (0.2, 0.1), length=3),
    Section.ellipse(0.1, 0.2),
    Section.given((1, 2, 3, 4, 5, 6), 0.7),
    Section.given(np.eye(6) + 0.1, 0.7, np.diag([1, 2, 2.5]), (0.1, 0.2)),
    HalfSpace(),
    HalfSpace((0, 0, -1), (0, 1, 1), link="arm", at=0.1),
    Sphere((0, 0, -1), 0.5, link="block"),
    Capsule((0, 0, -1), (1, 0, -1), 0.5),
    Box((0, 0, -1), (0.1, 0.2, 0.3), (0.6, 0, 0.8, 0)),
    HeightField(np.arange(6.0).reshape(3, 2), (0.1, 0.2), (0, 0, -9)),
    ConvexMesh(CORNERS, FACES, 0.1),
    Tube([(0, 0, -1), (1, 0, -1), (2, 1, -1)], 0.2),
    DistanceGrid(np.arange(24.0).reshape(2, 3, 4) - 9.5, (0.1, 0.2, 0.3), (0, 0, -9)),
    Mesh(CORNERS, FACES),
    Mesh(CORNERS, FACES, 0.05, link="arm", at=0.1),
    Tube([(0, 0, -9), (1, 0, -9)], 0.2, wall=0.1, link="arm", at=0.1),
    Ball("block", 0.2, at=None, position=(1, 2, 3)),
    Contact("arm", HalfSpace(), friction=(0.1, 0.2, 0.3), name="floor"),
    Contact(Ball("block", 0.2), Sphere((0, 0, -1), 0.5), stiffness=1e4),
    Load(force=(0, 0, 1)),
    Load(moment=(0, 1, 0), along=(0.1, 0.2), frame="body", link="arm"),
    Body(0.1),
    Body(0.1, at=0.2, centre=(0, 0, 1), inertia=np.diag([1, 2, 2]), link="arm", volume=1, drag_coefficient=2),
    Support(),
    Support(stiffness=1, damping=(1, 2, 3), at=0.1, position=(1, 2, 3), orientation=(0, 1, 0, 0), link="arm"),
    Fluid(1000.0),
    Fluid(1.0, (1, 2, 3), viscous_drag=(1, 2), buoyancy=False),
    BaseMotion(),
    BaseMotion(translation=(0, 0, 1), axis=(0, 1, 0), angle=0.5),
    Along(),
    Along("arm", ((0.01, 0.02), ([0, 0.1, 0.3], [1, 2, 0])), (0.1, 0.2)),
    Via(None, (0, 0, 1)),
    Tendon("pull", [Via("arm", (0, 0, 1), 0.1), Along("arm")], tension=([0, 1], [1, 2])),
    Tendon("wire", [Along()], length=0.1, stiffness=10, damping=1, friction=0.1, sliding=Input("s", -1)),
    Chamber("left", [Along(offset=(0, 0.01))], 1e-4, Harmonic(1.0, 2.0, mean=1.5)),
    Motor("arm", 0.1),
    Motor("arm.angle", position=Input("q"), gains=(3, 0.1), limits=(-1, 1), name="servo"),
    ActiveStrain(None, "bend_y"),
    ActiveStrain("arm", "torsion", ([0, 0.1, 0.3], [1, 2, 0]), Input("muscle")),
    Weld(),
    Spherical(),
    Free(),
    Free(motion=BaseMotion(translation=Harmonic((0, 0, 0.1), 2.0))),
    Mimic("arm", multiplier=-2),
    Revolute((0, 1, 0), stiffness=1, limits=(-1, 1), limit_stiffness=10, mimic=Mimic("arm")),
    Prismatic((0, 1, 0), friction=0.1, motion=([0, 1], [0, 0.1], "linear")),
    Cylindrical((0, 0, 1)),
    Universal((0, 0, 1), (0, 1, 0)),
    Planar((0, 0, 1)),
    LoopEnd("arm", 0.1, (0, 0, 1)),
    Distance(0.1),
    Gear(-2, offset=0.1),
    Link("frame"),
    Link("hand", body=Body(0.2, inertia=(1, 1, 1)), joint=Free(), parent="arm", at=0.2),
    Link("tail", rod=[SOFT, SOFT], joint=Planar((0, 0, 1)), position=(0, 0, 1), orientation=(0, 1, 0, 0)),
    Link("wheel", body=Body(0.2, inertia=(1, 1, 1)), joint=Revolute((1, 0, 0), mimic=Mimic("arm", offset=1))),
    Loop("arm", None, Weld()),
    Loop(("arm", 0.1), {"position": (0, 0, 1)}, Distance(0.1), name="bar"),
    Loop("arm.angle", "block.x", Gear()),
]


def test_the_stub_is_that_of_the_tables():
    stub = write_described.STUB.read_text(encoding="utf-8")
    methods = write_described.METHODS.read_text(encoding="utf-8")
    both = [
        (stub, write_described.MARKS, _lissom._stub_of_parts()),
        (methods, write_described.MARKS, _lissom._stub_of_methods()),
        *((stub, marks, made) for marks, made in write_described.of_models()),
    ]
    for text, marks, made in both:
        _, inner, _ = write_described.between(text, marks)
        assert inner == made


@pytest.mark.parametrize("part", EACH, ids=str)
def test_copies_of_all_kinds_are_equal(part):
    again = eval(repr(part), vars(lissom))
    copies = [again, copy.copy(part), copy.deepcopy(part), dataclasses.replace(part)]
    copies += [pickle.loads(pickle.dumps(part, protocol)) for protocol in range(2, 6)]
    for other in copies:
        assert other == part
        assert hash(other) == hash(part)
        assert repr(other) == repr(part)
    assert len({*copies, part}) == 1
    assert part != HalfSpace((0, 0, 99))
    assert part != "arm"


@pytest.mark.parametrize("part", EACH, ids=str)
def test_parts_are_dataclasses_with_the_arguments_of_their_constructors(part):
    names = [field.name for field in dataclasses.fields(part)]
    assert names == list(inspect.signature(type(part)).parameters)
    required = [
        name
        for name, known in inspect.signature(type(part)).parameters.items()
        if known.default is known.empty
    ]
    for field in dataclasses.fields(part):
        assert (field.default is dataclasses.MISSING) == (field.name in required)
        with pytest.raises(dataclasses.FrozenInstanceError, match=field.name):
            setattr(part, field.name, getattr(part, field.name))
        with pytest.raises(dataclasses.FrozenInstanceError, match=field.name):
            delattr(part, field.name)
    with pytest.raises(AttributeError):
        part.colour = "red"
    assert {*type(part).__match_args__} <= {*names}


def test_replace_checks_again():
    contact = Contact("arm", HalfSpace(), friction=0.5)
    assert dataclasses.replace(contact, friction=0.1, name="") == Contact("arm", HalfSpace(), friction=0.1)
    with pytest.raises(ValueError, match=r"friction: got -1, expected a finite number >= 0"):
        dataclasses.replace(contact, friction=-1)


def test_all_problems_are_raised_at_once():
    with pytest.raises(ValueError, match="dissipation") as caught:
        Contact(HalfSpace(normal=(0, 0, 0)), Sphere((0, 0, math.nan), -1), dissipation=-1, slip_velocity=0)
    places = {line.split(":")[0] for line in str(caught.value).splitlines()}
    assert places == {
        *("a", "a.normal", "b.centre[2]", "b.radius"),
        *("dissipation", "slip_velocity", "stiffness"),
    }


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sphere((0, 0, 0)), r"Sphere\(\) missing required arguments: 'radius'"),
        (lambda: Sphere(), "'centre', 'radius'"),
        (lambda: Sphere((0, 0, 0), 1, "arm"), "takes 2 positional arguments but 3 were given"),
        (lambda: Sphere((0, 0, 0), centre=(0, 0, 0)), "multiple values for argument 'centre'"),
        (
            lambda: Sphere((0, 0, 0), radios=1),
            "unexpected keyword argument 'radios', expected centre, radius",
        ),
        (lambda: Sphere((0, 0, 0), "1"), "radius: expected a real number"),
        (lambda: Sphere((0, 0, 0), 1, link=3), "link: expected a str"),
        (lambda: Contact("arm", 3), "b: expected the name of a link with a rod, lissom.Ball, HalfSpace"),
        (lambda: Contact("arm", Contact("arm", "arm")), "b: expected the name of a link with a rod"),
    ],
)
def test_what_is_no_argument_is_refused(make, message):
    with pytest.raises(TypeError, match=message):
        make()


numbers = st.floats(-0.5, 0.5)
sizes = st.floats(1e-3, 0.5)
vectors = st.tuples(numbers, numbers, numbers)
#: Positions far below the robot, which nothing touches at the start.
places = st.tuples(numbers, numbers, st.floats(-60, -50))
turns = st.floats(0, math.pi).map(lambda angle: (math.cos(angle), 0.0, 0.0, math.sin(angle)))
#: So wide that fields stay below the robot, which is beside them.
steps = st.floats(2, 3)
on_links = st.sampled_from([{}, {"link": "block"}])
rows = st.integers(2, 4).flatmap(
    lambda count: st.lists(st.lists(numbers, min_size=count, max_size=count), min_size=2, max_size=4)
)
#: Of both signs.
layers = st.lists(numbers, min_size=12, max_size=12).map(
    lambda found: np.reshape([-0.5, 0.5, *found[2:]], (2, 3, 2)).tolist()
)
shapes = on_links.flatmap(
    lambda more: st.one_of(
        st.builds(
            lambda point, slope: HalfSpace(point, (*slope, 1.0), **more), places, st.tuples(numbers, numbers)
        ),
        st.builds(lambda centre, radius: Sphere(centre, radius, **more), places, sizes),
        st.builds(
            lambda start, end, radius: Capsule(start, (end[0] + 2, *end[1:]), radius, **more),
            places,
            places,
            sizes,
        ),
        st.builds(
            lambda centre, half, turn: Box(centre, half, turn, **more),
            places,
            st.tuples(sizes, sizes, sizes),
            turns,
        ),
        st.builds(
            lambda heights, spacing, corner, turn: HeightField(heights, spacing, corner, turn, **more),
            rows,
            steps | st.tuples(steps, steps),
            places,
            turns,
        ),
        st.builds(
            lambda place, radius: ConvexMesh(np.add(CORNERS, place), FACES, radius, **more),
            places,
            sizes,
        ),
        st.builds(
            lambda values, spacing, corner, turn: DistanceGrid(values, spacing, corner, turn, **more),
            layers,
            steps | st.tuples(steps, steps, steps),
            places,
            turns,
        ),
        st.builds(lambda place: Mesh(np.add(CORNERS, place), FACES, **more), places),
        st.builds(
            lambda place, radius, wall: Tube(
                np.add([(0, 0, 0), (4, 0, 0), (8, 1, 0)], place), 1.0 + radius, wall=wall, **more
            ),
            places,
            sizes,
            st.none() | sizes,
        ),
    )
)
names = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
constants = st.fixed_dictionaries(
    {"stiffness": st.floats(1e-3, 1e6)},
    optional={
        "dissipation": st.floats(0, 2),
        "slip_velocity": st.floats(1e-9, 1),
        "patch_radius": st.floats(0, 1),
        "name": names,
    },
)
contacts = st.one_of(
    st.builds(
        lambda shape, friction, more: Contact("arm", shape, friction=friction, **more),
        shapes,
        st.floats(0, 2)
        | st.tuples(*[st.floats(0, 2)] * 3)
        | st.lists(st.floats(0, 2), min_size=3, max_size=3).map(lambda mu: ([0, 0.1, 0.3], mu)),
        constants,
    ),
    st.builds(
        lambda shape, place, radius, at, more: Contact(
            Ball("arm", radius, at=at, position=place), shape, friction=0.5, **more
        ),
        shapes,
        vectors,
        sizes,
        st.none() | st.floats(0.1, 0.3),
        constants,
    ),
)


@settings(max_examples=80, deadline=None)
@given(contact=contacts)
def test_contacts_are_written_to_scenes_and_back(contact):
    text = f"{LINKS}[[contact]]\n{contact.to_toml()}{END}"
    assert lissom.Scene.loads(text).model.contacts == (contact,)


ROD = f"""
[[rod.segment]]
{SEGMENT}[simulation]
t_end = 0.1
dt = 0.001
"""


@pytest.mark.parametrize(
    ("key", "part"),
    [
        ("load", Load(force=(1, 2, 3), at=0.1)),
        ("load", Load(moment=(1, 2, 3), along=(0.1, 0.2), frame="body")),
        ("load", Load(force=Harmonic((1, 2, 3), 0.5), moment=Harmonic(mean=(1, 0, 0), rate=(0, 1, 0)))),
        ("load", Load(force=Harmonic((1, 2, 3), 0.5, phase=-1, mean=(1, 0, 0)))),
        ("load", Load(force=([0, 0.5], [[1, 2, 3], [4, 5, 6]]), moment=Input("push", (0, 0.1, 0)))),
        ("body", Body(0.1)),
        ("body", Body(0.1, at=0.2, centre=(0, 0, 1), inertia=(1, 2, 2))),
        ("body", Body(0, volume=1e-4, centre_of_volume=(0, 1, 0), viscous_drag=1, drag_coefficient=2)),
        ("support", Support(stiffness=1, rotational_damping=(1, 2, 3), at=0.1)),
        ("support", Support(position=(1, 2, 3), orientation=(0, 1, 0, 0))),
        ("fluid", Fluid(1000.0)),
        ("fluid", Fluid(1.0, (1, 2, 3), drag_coefficients=(1, 2), buoyancy=False)),
        ("base_motion", BaseMotion(translation=Harmonic((0, 0, 0.1), 2.0))),
        ("base_motion", BaseMotion(translation=([0, 1], [[0, 0, 0], [0, 0, 1]], "linear"))),
        ("base_motion", BaseMotion(axis=(0, 0, 1), angle=([0, 1, 2], [0, 1, 1], "monotone"))),
        ("base_motion", BaseMotion(axis=(0, 0, 1), angle=Harmonic(0.1, 2.0, phase=1.0))),
        ("base_motion", BaseMotion(rotation=([0, 1], [[1, 0, 0, 0], [0.8, 0.6, 0, 0]]))),
    ],
)
def test_parts_of_rods_are_written_to_scenes_and_back(key, part):
    lists = {"load": "loads", "body": "bodies", "support": "supports"}
    header = f"[[rod.{key}]]" if key in lists else f"[rod.{key}]"
    model = lissom.Scene.loads(f"version = 1\n[[rod]]\n{header}\n{part.to_toml()}{ROD}").model
    assert getattr(model, lists.get(key, key)) == ((part,) if key in lists else part)


@pytest.mark.parametrize(
    ("key", "part"),
    [
        ("tendon", Tendon("pull", [Via("rod", (0, 0, 1), 0.1), Along("rod")], tension=([0, 1], [1, 2]))),
        (
            "tendon",
            Tendon("wire", [Along("rod")], length=0.1, stiffness=10, damping=1, sliding=Input("s", -1)),
        ),
        ("chamber", Chamber("left", [Along("rod", (0, (0.01, 0.02)), (0, 0.1))], 1e-4, Harmonic(1.0, 2.0))),
        ("active_strain", ActiveStrain("rod", "bend_y", ([0, 0.1, 0.3], [1, 2, 0]), Input("muscle"))),
    ],
)
def test_actuators_are_written_to_scenes_and_back(key, part):
    def read(part):
        return lissom.Scene.loads(f"version = 1\n[[rod]]\n{ROD}[[{key}]]\n{part.to_toml()}").model.actuators

    (found,) = read(part)
    if not isinstance(part, Chamber):
        # Two numbers at the ends of a part are a table along the whole rod.
        assert found == part
    assert read(found) == (found,)
    assert read(dataclasses.replace(part, name="other"))[0].name == "other"


@pytest.mark.parametrize(
    "joint",
    [
        Free(motion=BaseMotion(translation=Harmonic((0, 0, 0.1), 2.0))),
        Revolute((0, 1, 0), stiffness=1, limits=(-math.inf, 1), limit_stiffness=10, mimic=Mimic("arm")),
        Prismatic((0, 1, 0), friction=0.1, motion=([0, 1], [0, 0.1], "linear")),
        Universal((0, 0, 1), (0, 1, 0)),
        Planar((0, 0, 1)),
    ],
)
def test_joints_are_written_to_scenes_and_back(joint):
    keys = joint.to_toml().replace("\n", ", ")
    table = f'{{ type = "{type(joint).__name__.lower()}", {keys} }}'
    text = LINKS.replace('{ type = "free" }', table)
    assert lissom.Scene.loads(f"{text}{END}").model.links[1].joint == joint


@pytest.mark.parametrize(
    "loop",
    [
        Loop("arm", None, Spherical()),
        Loop(
            ("arm", 0.1, (0, 0, 0.1)), ("block", None, (0, 1, 0), (0.8, 0.6, 0, 0)), Distance(0.1), name="bar"
        ),
        Loop({"link": "arm"}, {"position": (0, 0, 1)}, Universal((1, 0, 0), (0, 1, 0))),
        Loop("arm.angle", "block.x", Gear(-2, offset=0.1)),
    ],
)
def test_loops_are_written_to_scenes_and_back(loop):
    text = f"{LINKS}[[loop]]\n{loop.to_toml()}{END}"
    assert lissom.Scene.loads(text).model.loops == (loop,)


def test_ends_of_loops_have_short_forms():
    end = LoopEnd("arm", 0.1, (0, 0, 1))
    for form in (end, ("arm", 0.1, (0, 0, 1)), {"link": "arm", "at": 0.1, "position": [0, 0, 1]}):
        assert Loop(form, None, Weld()).a == end
    assert Loop("arm", None, Weld()) == Loop(LoopEnd("arm"), LoopEnd(), Weld(), name="arm to the world")
    for form, message in [
        ((None,) * 5, r"a: LoopEnd\(\) takes 4 positional arguments but 5 were given"),
        ({"lnk": "arm"}, r"a: LoopEnd\(\) got an unexpected keyword argument 'lnk'"),
        (("arm", "tip"), "a.at: expected a real number, got str"),
        (3.0, "a: expected a name, lissom.LoopEnd, got float"),
    ]:
        with pytest.raises(TypeError, match=message):
            Loop(form, None, Weld())


def test_all_problems_of_a_loop_come_at_once():
    with pytest.raises(ValueError, match="at") as caught:
        Loop(("arm", -1), (None, 0.1, (0, 0, math.nan)), Revolute((0, 1, 0), damping=1, motion=0.1))
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["a.at", "b.position[2]", "b.at", "kind", "kind.motion"]
    links = [lissom.Link("arm", body=Body(1), joint=Revolute((0, 1, 0)))]
    with pytest.raises(ValueError, match="link") as caught:
        lissom.Robot(links, loops=[Loop("arn", None, Weld()), Loop("arm.angel", "x", Gear())])
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["loops[0].a.link", "loops[1].a", "loops[1].b"]


@pytest.mark.parametrize(
    "section",
    [
        Section.hollow_circle(([0, 0.1, 0.3], [0.02, 0.03, 0.02]), (0.01, 0)),
        Section.rectangle(0.1, (0.2, 0.1)),
        Section.given(
            ([0, 0.3], [np.eye(6), np.eye(6) + 0.1]), 0.7, (1, 2, 2.5), ([0, 0.3], [[0, 0], [0, 1]])
        ),
        Section.given((1, 2, 3, 4, 5, 6), ([0, 0.3], [0.7, 0.8]), ([0, 0.3], [[1, 2, 2], [2, 2, 2]])),
    ],
    ids=str,
)
def test_sections_are_written_to_scenes_and_back(section):
    written = f'length = 0.3\nmodes = {{ bend_y = 2 }}\n[rod.segment.section]\nshape = "{section.shape}"\n'
    material = (
        "" if section.shape == "given" else "young_modulus = 3e5\npoisson_ratio = 0.4\ndensity = 1070\n"
    )
    scene = lissom.Scene.loads(
        f"version = 1\n[[rod]]\n[[rod.segment]]\n{material}{written}{section.to_toml()}{END}"
    )
    (segment,) = scene.model.segments
    assert segment.section == section
    assert dataclasses.replace(segment.section) == section


RUBBER = {"young_modulus": 3e5, "density": 1070}

SEGMENTS = [
    Segment(0.3, 0.01, 3e5, 1.1e5, 1070, {"bend_y": 2}),
    Segment(
        0.3, (0.02, 0.01), 3e5, density=1070, modes={"bend_z": 2, "torsion": 1}, poisson_ratio=0.4, nodes=8
    ),
    Segment(0.3, ([0, 0.1, 0.3], [1e-2, 2e-2, 1e-2]), **RUBBER, modes={"shear_y": 2}, poisson_ratio=0.5),
    Segment(0.3, section=Section.rectangle(0.1, (0.2, 0.1)), **RUBBER, poisson_ratio=0, modes={"stretch": 1}),
    Segment(0.3, section=Section.given((1, 2, 3, 4, 5, 6), 0.7), modes={"shear_z": 2}, basis="hermite"),
    Segment(0.3, 0.01, **RUBBER, shear_modulus=1e5, modes={"bend_y": 1}, shear_correction="cowper"),
    Segment(0.3, 0.01, **RUBBER, shear_modulus=1e5, modes={"bend_y": 1}, shear_correction=(0.8, 0.9)),
    Segment(0.3, 0.01, 3e5, 1e5, 1070, {"bend_y": 1}, 0.1, (0, 1, 0, 1.1, 0, 0), basis="monomial"),
    Segment(
        0.3,
        0.01,
        *(3e5, 1e5, 1070, {"bend_y": 1}),
        reference_strain=([0, 0.3], [[0, 0, 0, 1, 0, 0], [0, 2, 0, 1, 0, 0]]),
    ),
]


@pytest.mark.parametrize("segment", SEGMENTS, ids=str)
def test_segments_are_written_to_scenes_and_back(segment):
    scene = lissom.Scene.loads(f"version = 1\n[[rod]]\n[[rod.segment]]\n{segment.to_toml()}{END}")
    assert scene.model.segments == (segment,)
    assert "auto" not in segment.to_toml()


@pytest.mark.parametrize("segment", SEGMENTS, ids=str)
def test_copies_of_segments_are_equal(segment):
    copies = [copy.copy(segment), copy.deepcopy(segment), dataclasses.replace(segment)]
    copies += [pickle.loads(pickle.dumps(segment, protocol)) for protocol in range(2, 6)]
    copies += lissom.Rod([segment]).segments
    for other in copies:
        assert other == segment
        assert hash(other) == hash(segment)
        assert repr(other) == repr(segment)
    if "Profile" not in repr(segment):
        assert eval(repr(segment), vars(lissom)) == segment


def test_what_follows_from_a_segment_is_not_given():
    by_ratio, by_modulus = SEGMENTS[1], SEGMENTS[0]
    assert by_ratio.shear_modulus == 3e5 / (2 * 1.4)
    assert dataclasses.replace(by_ratio, young_modulus=6e5).shear_modulus == 6e5 / (2 * 1.4)
    assert by_modulus.poisson_ratio == 3e5 / 2.2e5 - 1
    assert dataclasses.replace(by_modulus, young_modulus=2.5e5).shear_modulus == 1.1e5
    assert by_modulus.section == Section.circle(0.01)
    assert dataclasses.replace(by_modulus, radius=None, section=Section.circle(0.02)).radius == (0.02, 0.02)
    assert [field.name for field in dataclasses.fields(Segment)] == list(
        inspect.signature(Segment).parameters
    )
    assert "section" not in [field.name for field in dataclasses.fields(by_modulus)]
    with pytest.raises(dataclasses.FrozenInstanceError, match="section"):
        by_modulus.section = None


def test_all_problems_of_a_segment_come_at_once():
    with pytest.raises(ValueError, match="length") as caught:
        Segment(-1, (0.1, math.nan), 0, 1e5, modes={"bend": 1, "bend_y": -1}, basis="hermite")
    places = {line.split(":")[0] for line in str(caught.value).splitlines()}
    assert places == {"length", "radius[1]", "young_modulus", "modes.bend", "modes.bend_y"}
    with pytest.raises(ValueError, match="length") as caught:
        Segment(-1, (0.1, math.nan), 0, retardation_time=-1, nodes=0)
    places = {line.split(":")[0] for line in str(caught.value).splitlines()}
    assert places == {
        *("length", "radius[1]", "young_modulus", "shear_modulus", "density", "modes"),
        *("retardation_time", "nodes"),
    }


def test_shapes_are_classes_of_sections():
    assert isinstance(Section.circle(0.01), Section)
    assert Section.rectangle(0.1, (0.2, 0.1)).height == (0.2, 0.1)
    assert Section.circle(lambda X: 0.1 + X**2, length=0.5).length == 0.5
    with pytest.raises(TypeError, match="Section is the base of other classes"):
        Section()
    with pytest.raises(ValueError, match=r"(?s)outer: got -1.*inner: got NaN"):
        Section.hollow_circle(-1, math.nan)
    with pytest.raises(ValueError, match="a function of Python cannot be written"):
        Section.circle(lambda X: 0.1 + X**2, length=0.5).to_toml()


def test_joints_share_a_base():
    assert issubclass(Weld, lissom.Joint)
    assert isinstance(Revolute((0, 1, 0)), lissom.Joint)
    assert not isinstance(Mimic("arm"), lissom.Joint)
    with pytest.raises(TypeError, match="Joint is the base of other classes"):
        lissom.Joint()


def test_all_problems_of_a_link_come_at_once():
    with pytest.raises(ValueError, match="name") as caught:
        Link(
            "",
            rod=[],
            body=Body(1, at=0.1, link="arm"),
            at=-1,
            position=(0, math.nan, 0),
            orientation=(2, 0, 0, 0),
        )
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["at", "position[1]", "name", "rod", "body", "body.at", "body.link", "orientation"]
    with pytest.raises(TypeError, match=r"rod\[1\]: expected lissom.Segment, got int"):
        Link("arm", rod=[SOFT, 3])
    with pytest.raises(TypeError, match="takes 1 positional arguments but 2 were given"):
        Link("arm", [SOFT])


def test_the_joint_of_a_link_is_a_weld_by_default():
    parameters = inspect.signature(Link).parameters
    assert parameters["joint"].default == Weld() == Link("frame").joint
    assert str(inspect.signature(Link)).startswith("(name, *, rod=None, body=None, joint=Weld(), parent=None")
    assert repr(Link("frame", parent="arm")) == "Link(name='frame', parent='arm')"
    assert Link("arm", rod=iter([SOFT, SOFT])).rod == (SOFT, SOFT)
    # Of a robot, too.
    assert lissom.Robot([Link("arm", rod=[SOFT])]).links == (Link("arm", rod=[SOFT]),)


@pytest.mark.parametrize("link", [part for part in EACH if isinstance(part, Link)], ids=str)
def test_links_are_written_to_scenes_and_back(link):
    scene = lissom.Scene.loads(f"{LINKS}[[link]]\n{link.to_toml()}{END}")
    assert scene.model.links[-1] == link


def test_links_hold_what_their_joints_and_scenes_cannot():
    links = (Link("cart", body=Body(1), joint=Prismatic((1, 0, 0), motion=lambda t: t**3)) for _ in range(1))
    robot = lissom.Robot([*links, Link("bob", body=Body(0.1), joint=Prismatic((0, 0, 1)), parent="cart")])
    gc.collect()
    assert robot.links[0].joint.motion(2.0) == 8.0
    assert robot.pose([0.0], t=2.0, link="bob")[0, 3] == 8.0
    with pytest.raises(ValueError, match="a function of Python cannot be written to a scene"):
        robot.links[0].to_toml()


def test_robots_report_all_names_that_no_link_has():
    wheel = Link("wheel", body=Body(0.2), joint=Prismatic((1, 0, 0), mimic=Mimic("arn")))
    with pytest.raises(ValueError, match="parent") as caught:
        lissom.Robot([Link("arm", rod=[SOFT]), wheel, Link("a", parent="arn"), Link("b", parent="b")])
    before = "expected the name of a link that stands before this one"
    assert str(caught.value).splitlines() == [
        "links[1].joint.mimic.link: got 'arn', expected one of the links: 'arm', 'wheel', 'a', 'b'; "
        "did you mean 'arm'?",
        f"links[2].parent: got 'arn', {before}; did you mean 'arm'?",
        f"links[3].parent: got 'b', {before}",
    ]


def robot_with_everything():
    links = [
        Link("arm", rod=[SOFT], joint=Revolute((0, 1, 0))),
        Link("hand", body=Body(0.2, inertia=(1, 1, 1)), joint=Free(), parent="arm"),
    ]
    return lissom.Robot(
        links,
        gravity=(0, 0, -1.62),
        loads=[Load(force=Harmonic((0, 0, 1), 2.0), link="hand")],
        bodies=[Body(0.1, link="arm", at=0.1)],
        supports=[Support(stiffness=10, link="arm")],
        fluid=Fluid(1000),
        base_motion=BaseMotion(translation=Harmonic((0, 0, 0.1), 2.0)),
        actuators=[Motor("arm.angle", torque=0.1), ActiveStrain("arm", "bend_y")],
        loops=[Loop("arm", "hand", Spherical()), Loop("arm", "hand", Spherical())],
        contacts=[Contact("arm", HalfSpace()), Contact("arm", HalfSpace())],
    )


def everything_of(model):
    return {name: getattr(model, name) for name in inspect.signature(type(model)).parameters}


def test_models_are_made_again_from_their_attributes():
    robot = robot_with_everything()
    rod = lissom.Rod(
        [SOFT], (0, 0, 1), (0, 1, 0, 0), (0, 0, 1), (0, 0, 2), (0, 0, 3), 0.4, bodies=[Body(0.1)]
    )
    for model in (robot, rod):
        given = everything_of(model)
        copies = [pickle.loads(pickle.dumps(model)), copy.copy(model), dataclasses.replace(model)]
        for again in [type(model)(**given), *copies]:
            assert everything_of(again) == given
    assert [loop.name for loop in robot.loops] == ["arm to hand", "arm to hand 2"]
    assert [contact.name for contact in robot.contacts] == ["arm on halfspace", "arm on halfspace 2"]
    lighter = dataclasses.replace(robot, gravity=(0, 0, 0), fluid=None)
    assert everything_of(lighter) == everything_of(robot) | {"gravity": (0, 0, 0), "fluid": None}
    assert dataclasses.replace(rod, tip_mass=0.5).tip_mass == 0.5
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign to field 'gravity'"):
        robot.gravity = (0, 0, 0)


def test_attributes_of_models_are_those_of_their_docstrings():
    for kind in (lissom.Robot, lissom.Rod):
        parameters = kind.__doc__.split("Parameters\n----------\n")[1].split("\n\n")[0]
        documented = [
            line.split(" : ")[0] for line in parameters.split("\n") if " : " in line[:40] and line[0] != " "
        ]
        assert documented == list(inspect.signature(kind).parameters)
        assert all(inspect.isdatadescriptor(getattr(kind, name)) for name in documented)


def test_robots_report_unknown_names_of_all_lists_at_once():
    link = Link("arm", rod=[SOFT], joint=Revolute((0, 1, 0)))
    with pytest.raises(ValueError, match="amr") as raised:
        lissom.Robot(
            [link, Link("other", body=Body(1.0), joint=Free(), parent="amr")],
            loads=[Load(force=(0, 0, 1), link="amr")],
            supports=[Support(stiffness=10, link="hand")],
            actuators=[Motor("elbow", torque=0.1)],
            loops=[Loop("arm", "rod", Weld())],
            contacts=[Contact("leg", HalfSpace())],
        )
    places = [line.split(":")[0] for line in str(raised.value).split("\n")]
    assert places == [
        "links[1].parent",
        "loads[0].link",
        "supports[0].link",
        "actuators[0].joint",
        "loops[0].b.link",
        "contacts[0].a",
    ]


def test_keywords_that_do_not_exist_are_refused_with_the_one_that_was_meant():
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'orientation'.*'base_orientation'"):
        lissom.Rod([SOFT], orientation=(1, 0, 0, 0))
    with pytest.raises(TypeError, match="did you mean 'contacts'"):
        lissom.Robot([Link("arm", rod=[SOFT])], contact=[])


def test_scenes_report_all_problems_of_a_link_with_their_keys():
    table = """
[[link]]
name = "hand"
parent = "am"
at = -1
position = [0, nan, 0]
orientation = [2, 0, 0, 0]
joint = { type = "revolute", axis = [0, 0, 0], mimic = { link = "arn" } }
body = { mass = -1, at = 0.1 }
fixed_body = [{ mass = -1 }]
[[link.rod.segment]]
length = 0.1
section = { shape = "circle", radius = -1 }
young_modulus = 3e5
poisson_ratio = 0.4
density = -1
modes = { bend_y = 2 }
[[link.rod.segment]]
length = 0.1
q1 = 3
[[link]]
name = "tool"
parent = "hand"
at = 0.3
mass = 1
[[contact]]
a = "hand"
b = { kind = "half_space" }
"""
    text = LINKS + table + END
    with pytest.raises(lissom.SceneError) as refused:
        lissom.Scene.loads(text)
    problems = {problem.key: problem for problem in refused.value.problems}
    here = "link[2]"
    assert problems.keys() == {
        *(f"{here}.{key}" for key in ("parent", "at", "position[1]", "orientation", "joint.axis", "body")),
        *(f"{here}.{key}" for key in ("body.mass", "body.at", "fixed_body[0].mass")),
        *(f"{here}.rod.segment[0].{key}" for key in ("section.radius", "density")),
        *(f"{here}.rod.segment[1]", f"{here}.rod.segment[1].q1"),
        *("link[3].at", "link[3].mass"),
    }
    assert text.splitlines()[problems["link[3].at"].line - 1] == "at = 0.3"
    assert 'one of the links before: "arm", "block"' in problems[f"{here}.parent"].right


def test_dates_are_no_texts():
    text = LINKS.replace(
        '{ type = "free" }', '{ type = "prismatic", axis = [0, 0, 1], mimic = { link = 1979-05-27 } }'
    )
    with pytest.raises(lissom.SceneError, match=r"link\[1\].joint.mimic.link: got a date"):
        lissom.Scene.loads(f"{text}[[link]]\nname = '1979-05-27'\n{END}")


def test_all_problems_of_a_joint_come_at_once():
    with pytest.raises(ValueError, match="axis") as caught:
        Revolute((0, 0, 0), stiffness=-1, limits=(1, -1), armature=math.nan)
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["stiffness", "armature", "axis", "limits", "limit_stiffness"]
    text = LINKS.replace(
        '{ type = "free" }', '{ type = "revolute", axis = [0, 0, 0], damping = -1, rst = 1 }'
    )
    with pytest.raises(lissom.SceneError) as refused:
        lissom.Scene.loads(text.replace("mass = 0.2", "mass = -1") + END)
    keys = {problem.key for problem in refused.value.problems}
    assert keys == {"link[1].joint.damping", "link[1].joint.axis", "link[1].joint.rst", "link[1].body.mass"}


def test_motors_are_written_to_scenes_and_back():
    motor = Motor("arm.angle", position=Input("q"), gains=(3, 0.1), limits=(-1, 1), name="servo")
    assert lissom.Scene.loads(f"{LINKS}[[motor]]\n{motor.to_toml()}{END}").model.actuators == (motor,)


def test_functions_of_parts_from_iterators_live_as_long_as_their_robot():
    segment = lissom.Segment(0.3, 0.01, 3e5, poisson_ratio=0.4, density=1070, modes={"bend_y": 2})
    loads = (Load(force=lambda t: (0, 0, 1)) for _ in range(2))
    tendons = (Tendon(f"t{i}", [Along(None, (0, lambda X: X))], tension=lambda t: 1.0) for i in range(2))
    rod = lissom.Rod([segment], loads=loads, actuators=tendons)
    assert rod.actuators[1].tension(0.0) == 1.0
    assert lissom.statics(rod, space_error=False).success


def test_all_problems_of_all_actuators_come_at_once():
    segment = lissom.Segment(0.3, 0.01, 3e5, poisson_ratio=0.4, density=1070, modes={"bend_y": 2})
    links = [lissom.Link("arm", rod=[segment]), lissom.Link("hand", rod=[segment])]
    wrong = [Tendon("t", [Along("arn"), Via("hnd", (0, 0, 0))], tension=1), Motor("hand", 1), Motor("x", 1)]
    with pytest.raises(ValueError, match="path") as caught:
        lissom.Robot(links, actuators=wrong)
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["actuators[0].path[0].link", "actuators[0].path[1].link", "actuators[2].joint"]


def test_functions_cannot_be_written_to_scenes():
    with pytest.raises(ValueError, match="a function of Python cannot be written to a scene"):
        Load(force=lambda t: (0, 0, t)).to_toml()


def test_scenes_report_all_problems_of_loads_with_their_keys():
    tables = """
[[rod.load]]
force = { amplitude = [0, 0, 1], frequency = -1 }
moment = { times = [0, 1] }
at = -1
[[rod.load]]
force = [0, 0, 1]
at = 2
[[rod.load]]
force = { tmes = [0, 1], values = [[0, 0, 0], [0, 0, 1]] }
link = "rod"
[[rod.body]]
mass = 1
at = 3
"""
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(f"version = 1\n[[rod]]{tables}{ROD}")
    assert {(problem.key, problem.line) for problem in caught.value.problems} == {
        ("rod[0].load[0].force.frequency", 4),
        ("rod[0].load[0].moment", 5),
        ("rod[0].load[0].at", 6),
        ("rod[0].load[1].at", 9),
        ("rod[0].load[2].force.tmes", 11),
        ("rod[0].load[2].link", 12),
        ("rod[0].body[0].at", 15),
    }


def test_python_reports_all_problems_of_loads_and_bodies():
    with pytest.raises(ValueError, match="force") as caught:
        Load(force=(0, 0, math.nan), moment=Harmonic((0, 0, 1), 1.0), at=-1, along=(0.2, 0.1))
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["force[2]", "at", "along", "along[1]"]
    with pytest.raises(ValueError, match="mass") as caught:
        Body(-1, inertia=(1, 1, 3), volume=-1)
    places = [line.split(":")[0] for line in str(caught.value).splitlines()]
    assert places == ["mass", "volume", "inertia"]


def test_a_link_is_where_its_body_is():
    text = f"{LINKS.replace('body = {', 'body = { at = 0.1,')}{END}"
    with pytest.raises(lissom.SceneError, match=r"link\[1\]\.body\.at: the body of a link is at its base"):
        lissom.Scene.loads(text)


def test_records_of_versions_in_which_parts_had_other_constructors_are_read():
    frame = {"name": "frame", "rod": None, "body": None, "joint": {"made": ["Weld", None, [], {}]}}
    place = {
        "parent": "arm",
        "at": 0.1,
        "position": {"tuple": [0, 0, 1]},
        "orientation": {"tuple": [1, 0, 0, 0]},
    }
    for node, part in (
        (
            {"made": ["Body", None, [0.5], {"at": 0.1, "centre": {"tuple": [0, 0, 1]}}]},
            Body(0.5, at=0.1, centre=(0, 0, 1)),
        ),
        ({"fields": ["Link", frame | place]}, Link("frame", parent="arm", at=0.1, position=(0, 0, 1))),
    ):
        tree = json.dumps(node).encode()
        assert records.read(len(tree).to_bytes(8, "little") + tree) == part


def test_tables_leave_out_what_is_the_default():
    contact = Contact("arm", HalfSpace((0, 0, -1)), friction=0.5)
    assert contact.to_toml() == (
        'a = "arm"\n'
        'b = { kind = "half_space", point = [0.0, 0.0, -1.0] }\n'
        "friction = [0.5, 0.5, 0.5]\n"
        'name = "arm on halfspace"\n'
    )
