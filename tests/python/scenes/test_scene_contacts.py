"""`[[contact]]` in scenes: resulting contacts, errors, and the command line."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import lissom
from lissom import (
    Ball,
    Body,
    Box,
    Capsule,
    Contact,
    ConvexMesh,
    Free,
    HalfSpace,
    Link,
    Revolute,
    Robot,
    Sphere,
)

SCENES = Path(__file__).parents[3] / "scenes"

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
{SEGMENT}
[[link]]
name = "block"
position = [0.3, 0, -0.1]
joint = {{ type = "free" }}
body = {{ mass = 0.2, inertia = [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]] }}
"""

END = """
[simulation]
t_end = 0.1
"""


def scene(contacts, settings="", links=LINKS):
    return lissom.Scene.loads(links + contacts + END + settings)


def segment():
    material = {"radius": 0.01, "young_modulus": 3e5, "poisson_ratio": 0.4, "density": 1070}
    return lissom.Segment(0.3, modes={"bend_y": 2, "bend_z": 1}, **material)


def robot(*contacts):
    links = [
        Link("arm", joint=Revolute((0, 1, 0)), rod=[segment()]),
        Link(
            "block",
            position=(0.3, 0, -0.1),
            joint=Free(),
            body=Body(0.2, inertia=np.diag([1e-3, 1e-3, 1e-3])),
        ),
    ]
    return Robot(links, contacts=contacts)


def command(*arguments, cwd):
    """Run the command line."""
    whole = [sys.executable, "-m", "lissom", *map(str, arguments)]
    return subprocess.run(whole, cwd=cwd, capture_output=True, text=True, timeout=100)


def test_scenes_make_the_contacts_of_python():
    text = """
[[contact]]
name = "floor"
a = "arm"
b = { kind = "half_space", point = [0, 0, -1], normal = [0, 0.1, 1] }
stiffness = 1e5
dissipation = 0.5
friction = [0.1, 0.2, 0.3]
slip_velocity = 1e-3
[[contact]]
a = "arm"
b = { kind = "half_space", point = [0, 0, -2] }
[[contact]]
name = "lid"
a = { link = "block", radius = 0.02 }
b = { kind = "half_space", normal = [0, 0, -1] }
stiffness = 1e4
[[contact]]
a = "arm"
b = "arm"
[[contact]]
a = "arm"
b = { link = "block", radius = 0.02 }
friction = 0.5
[[contact]]
a = { link = "block", radius = 0.02, position = [0, 0, 0.01] }
b = { kind = "box", centre = [5, 0, -5], half_extents = [1, 2, 3], orientation = [0.8, 0.6, 0, 0] }
stiffness = 1e4
[[contact]]
a = { link = "arm", at = 0.1, radius = 0.03 }
b = { kind = "capsule", start = [0, 0, -2], end = [0, 1, -2], radius = 0.2 }
stiffness = 1e4
[[contact]]
a = { link = "block", radius = 0.05 }
b = { kind = "sphere", centre = [0, 0, -3], radius = 0.5 }
stiffness = 1e4
"""
    constants = {"stiffness": 1e5, "dissipation": 0.5, "friction": (0.1, 0.2, 0.3), "slip_velocity": 1e-3}
    floor = Contact("arm", HalfSpace((0, 0, -1), (0, 0.1, 1)), name="floor", **constants)
    wanted = robot(
        floor,
        Contact("arm", HalfSpace((0, 0, -2))),
        Contact(Ball("block", 0.02), HalfSpace(normal=(0, 0, -1)), stiffness=1e4, name="lid"),
        Contact("arm", "arm"),
        Contact("arm", Ball("block", 0.02), friction=0.5),
        Contact(
            Ball("block", 0.02, position=(0, 0, 0.01)),
            Box((5, 0, -5), (1, 2, 3), (0.8, 0.6, 0, 0)),
            stiffness=1e4,
        ),
        Contact(Ball("arm", 0.03, at=0.1), Capsule((0, 0, -2), (0, 1, -2), 0.2), stiffness=1e4),
        Contact(Ball("block", 0.05), Sphere((0, 0, -3), 0.5), stiffness=1e4),
    )
    assert scene(text, links=LINKS).model.contacts == wanted.contacts


def test_scenes_fix_shapes_to_links():
    text = """
[[contact]]
a = "arm"
b = { kind = "box", link = "block", centre = [0, 0, -1], half_extents = [0.1, 0.2, 0.3] }
[[contact]]
name = "corners"
a = { kind = "convex_mesh", link = "arm", at = 0.2, points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
      faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]], radius = 0.01 }
b = { kind = "half_space", point = [0, 0, -9] }
stiffness = 1e4
[[contact]]
a = { kind = "half_space", link = "block" }
b = { kind = "sphere", centre = [0, 0, 5], radius = 0.5 }
stiffness = 1e4
"""
    faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]
    mesh = ConvexMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], faces, 0.01, link="arm", at=0.2)
    wanted = robot(
        Contact("arm", Box((0, 0, -1), (0.1, 0.2, 0.3), link="block")),
        Contact(mesh, HalfSpace((0, 0, -9)), stiffness=1e4, name="corners"),
        Contact(HalfSpace(link="block"), Sphere((0, 0, 5), 0.5), stiffness=1e4),
    )
    found = scene(text).model
    assert [str(contact) for contact in found.contacts] == [str(contact) for contact in wanted.contacts]
    assert found.contacts[0].name == "arm on block"


@pytest.mark.filterwarnings("ignore:Impacts are shorter:lissom.AccuracyWarning")
def test_a_rod_is_called_rod():
    rods = f"version = 1\n[[rod]]\n[[rod.segment]]\n{SEGMENT}"
    text = '[[contact]]\na = "rod"\nb = { kind = "half_space", point = [0, 0, -0.05] }\nfriction = 0.3\n'
    contact = Contact("rod", HalfSpace((0, 0, -0.05)), friction=0.3)
    rod = lissom.Rod([segment()], contacts=[contact])
    made = scene(text, links=rods)
    assert made.model.contacts == rod.contacts == (contact,)
    # The simulated contact equals that of Python with the same method.
    found, wanted = made.run(t_end=0.3), lissom.simulate(rod, 0.3)
    np.testing.assert_array_equal(found.q, wanted.q)
    assert np.abs(rod.contact_forces(found.q, found.v)).max() > 0.0


GROUND = 'b = { kind = "half_space" }\n'


@pytest.mark.parametrize(
    ("text", "key", "wrong", "right"),
    [
        ('a = "arn"\n' + GROUND, "contact[0].a", 'no link is called "arn"', 'did you mean "arm"?'),
        ('a = "block"\n' + GROUND, "contact[0].a", "got a link without a rod", "a Ball on it"),
        (GROUND, "contact[0].a", "missing", "add a"),
        ('a = "arm"\n', "contact[0].b", "missing", "add b"),
        ('a = { kind = "half_space" }\nb = "arm"\n', "contact[0].a", "got an obstacle", "what moves"),
        ('a = "arm"\nb = { radius = 0.1 }\n', "contact[0].b", "neither link nor kind", '"capsule"'),
        ('a = "arm"\nb = { kind = "ball" }\n', "contact[0].b.kind", 'got "ball"', '"sphere"'),
        ('a = "arm"\nb = { kind = "sphere", centre = [0, 0, 0] }\n', "contact[0].b", "radius is", "metres"),
        (
            'a = "arm"\nb = { kind = "sphere", centre = [0, 0, 0], radius = 1, normal = [0, 0, 1] }\n',
            "contact[0].b.normal",
            'an obstacle of kind "sphere" does not take it',
            "it takes centre, radius",
        ),
        (
            'a = "arm"\nb = { kind = "half_space", at = 0.1 }\n',
            "contact[0].b.at",
            'an obstacle of kind "half_space" does not take it',
            "it takes point, normal, link",
        ),
        ('a = "arm"\nb = { kind = "half_space", link = "blok" }\n', "contact[0].b.link", "blok", "block"),
        (
            'a = { kind = "half_space", link = "block" }\nstiffness = 1\n' + GROUND,
            "contact[0].b",
            "a half-space for a half-space",
            "balls",
        ),
        (
            'a = "arm"\nb = { kind = "half_space", normal = [0, 0, 0] }\n',
            "contact[0].b.normal",
            "got (0, 0, 0)",
            "a direction",
        ),
        (
            'a = "arm"\nb = { link = "block", radius = -1 }\n',
            "contact[0].b.radius",
            "got -1",
            "> 0",
        ),
        (
            'a = { link = "arm", at = 1, radius = 0.1 }\nstiffness = 1\n' + GROUND,
            "contact[0].a.at",
            "got 1",
            "0.3",
        ),
        (
            'a = { link = "block", radius = 0.1 }\n' + GROUND,
            "contact[0]",
            "stiffness is missing",
            "add stiffness in N/m",
        ),
        ('a = "arm"\nfriction = [0.1, -1, 0]\n' + GROUND, "contact[0].friction[1]", "got -1", ">= 0"),
        ('a = "arm"\nfriction = -1\n' + GROUND, "contact[0].friction", "got -1", ">= 0"),
        ('a = "arm"\nstiffness = 0\n' + GROUND, "contact[0].stiffness", "got 0", "N/m^2"),
        ('a = "arm"\nslip_velocity = 0\n' + GROUND, "contact[0].slip_velocity", "got 0", "m/s"),
        ('a = "arm"\ndissipation = -1\n' + GROUND, "contact[0].dissipation", "got -1", "s/m"),
        ('a = "arm"\nname = ""\n' + GROUND, "contact[0].name", "got ''", "a name"),
        (
            'a = "arm"\nname = "x"\n' + GROUND + '[[contact]]\na = "arm"\nname = "x"\n' + GROUND,
            "contact[1].name",
            "another contact",
            "a different name",
        ),
        ('a = "arm"\nstifness = 1\n' + GROUND, "contact[0].stifness", "unknown key", "stiffness"),
    ],
)
def test_what_is_wrong_is_said_where_it_is(text, key, wrong, right):
    with pytest.raises(lissom.SceneError) as caught:
        scene("[[contact]]\n" + text)
    problems = {problem.key: problem for problem in caught.value.problems}
    assert key in problems, str(caught.value)
    found = problems[key]
    assert wrong in found.wrong
    assert right in found.right
    assert found.line > LINKS.count("\n")


def test_a_pendulum_touches_nothing():
    with pytest.raises(lissom.SceneError, match="a pendulum touches nothing"):
        scene('[[contact]]\na = "rod"\n' + GROUND, links="version = 1\n[pendulum]\n")


def test_a_start_in_the_floor_is_refused():
    with pytest.raises(lissom.SceneError, match=r"contact\[0\]: its surfaces overlap by 1.010 m"):
        scene('[[contact]]\na = "arm"\nb = { kind = "half_space", point = [0, 0, 1] }\n')


@pytest.mark.parametrize("name", ["falling_rod"])
def test_shipped_scenes_touch_and_lose_energy(name):
    made = lissom.Scene.load(SCENES / f"{name}.toml")
    motion = made.run()
    assert motion.success
    assert all(
        np.abs(made.model.contact_forces(motion.q, motion.v, name=contact.name)).max() > 0.0
        for contact in made.model.contacts
    )
    first, last = (made.model.energy(motion.q[i], motion.v[i]).total for i in (0, -1))
    assert last < first


def test_the_command_line_tells_contacts(tmp_path):
    path = SCENES / "falling_rod.toml"
    checked = command("check", path, cwd=tmp_path)
    assert checked.returncode == 0, checked.stderr
    explained = command("explain", path, cwd=tmp_path)
    assert explained.returncode == 0, explained.stderr
    assert "contact floor" in explained.stdout
    assert "friction 0.5" in explained.stdout
    assert "generalised alpha (implicit" in explained.stdout


def test_default_names_of_scenes_do_not_collide():
    text = """version = 1
[[link]]
name = "b"
joint = { type = "revolute", axis = [0, 1, 0] }
body = { mass = 1.0, centre = [0.1, 0, 0] }
[[contact]]
a = { link = "b", radius = 0.1 }
b = { kind = "half_space", point = [0, 0, -1] }
stiffness = 1e3
[[contact]]
a = { link = "b", radius = 0.1 }
b = { kind = "half_space", point = [0, 0, -2] }
stiffness = 1e3
[[motor]]
joint = "b"
torque = 1.0
[[motor]]
joint = "b"
torque = 2.0
[simulation]
t_end = 0.1
"""
    model = lissom.Scene.loads(text).model
    assert [contact.name for contact in model.contacts] == ["b on halfspace", "b on halfspace 2"]
    assert [motor.name for motor in model.actuators] == ["b", "b 2"]
