"""What people type first who come from data sheets, drawings and other programs, and what they are told."""

import re

import numpy as np
import pytest

import lissom

MATERIAL = {"young_modulus": 3e5, "poisson_ratio": 0.45, "density": 1100.0}
HALF = r"It is half the diameter"


def segment(**others):
    return lissom.Segment(0.2, 0.01, modes={"bend_y": 3}, **MATERIAL, **others)


def pulled(offset=(0, 0.006), **others):
    pull = lissom.Tendon("pull", [lissom.Along(offset=offset)], tension=lissom.Input("pull", 0.0), **others)
    return lissom.Rod([segment()], actuators=[pull])


ORIGIN, UP = (0, 0, 0), (0, 0, 1)

#: Calls with a word or a value that belongs elsewhere, and what is said of it.
CALLS = {
    "diameter of a segment": (lambda: lissom.Segment(0.2, diameter=0.02), f"'radius'\\? {HALF}$"),
    "diameter of a rod": (lambda: lissom.Rod([], diameter=0.02), f"'radius' of lissom.Segment\\? {HALF}$"),
    "diameter of a sphere": (lambda: lissom.Sphere(ORIGIN, diameter=0.1), HALF),
    "diameter of a ball": (lambda: lissom.Ball("a", diameter=0.1), HALF),
    "diameter of a capsule": (lambda: lissom.Capsule(ORIGIN, UP, diameter=0.1), HALF),
    "diameter of a tube": (lambda: lissom.Tube([ORIGIN, UP], diameter=0.1), HALF),
    "d": (lambda: lissom.Segment(0.2, d=0.02), HALF),
    "diameter of a circle": (lambda: lissom.Section.circle(diameter=0.1), HALF),
    "diameters of a tube": (
        lambda: lissom.Section.hollow_circle(outer_diameter=0.1, inner_diameter=0.08),
        r"'outer_diameter' \(did you mean 'outer'\? .*half.*'inner_diameter' \(did you mean 'inner'\? .*half",
    ),
    "diameter of a given section": (
        lambda: lissom.Section.given((1,) * 6, diameter=0.1),
        r"a given section has no radius: .* whose radius r is half the diameter",
    ),
    "diameter of a chamber": (lambda: lissom.Chamber("c", [], diameter=0.1), r"'area'\? It is pi/4 diameter"),
    "diameter of a body": (lambda: lissom.Body(1.0, diameter=0.1), "a body has no surface: what touches"),
    "size of a box": (lambda: lissom.Box(ORIGIN, size=UP), r"'half_extents'\? They are half the lengths"),
    "words of a segment, given to a rod": (
        lambda: lissom.Rod(length=1.0, radius=0.1),
        r"'length' \(it belongs to lissom.Segment\), 'radius' \(it belongs to lissom.Segment\)",
    ),
    "all at once": (
        lambda: lissom.Segment(E=1e6, L=0.2, r=0.01, zzz=1),
        r"keyword arguments 'E' \(did you mean 'young_modulus'\?\), 'L' \(did you mean 'length'\?\), "
        r"'r' \(did you mean 'radius'\?\), 'zzz', expected length, ",
    ),
    "all of a function": (
        lambda: lissom.simulate(pulled(), 0.1, metod="radau", timestep=1e-3),
        r"'metod' \(did you mean 'method'\?\), 'timestep' \(did you mean 'dt'\?\), expected model",
    ),
    "all of a function of Python": (
        lambda: lissom.statics_many(pulled(), metod="newton", max_it=3),
        r"'metod' \(did you mean 'method'\?\), 'max_it' \(did you mean 'max_iter'\?\), expected u",
    ),
    "offset alone": (
        lambda: lissom.Along((0.004, 0)),
        r"mean offset=\(0.004, 0\)\? It is the offset \(y, z\)",
    ),
    "offset as two numbers": (lambda: lissom.Along(0.004, 0), r"mean offset=\(0.004, 0\)\? It is the offset"),
    "point alone": (lambda: lissom.Via((0, 0, 0.1)), r"did you mean point=\(0, 0, 0.1\)\?"),
    "offset of a tendon": (
        lambda: lissom.Tendon("t", offset=(0, 0.004)),
        r"did you mean 'path'\? .*along a rod with `offset` \(y, z\)",
    ),
    "offset as path": (
        lambda: lissom.Tendon("t", (0, 0.004), tension=1.0),
        r"path: expected a sequence of lissom.Along or Via, .*lissom.Along\(offset=\(0, 0.004\)\)",
    ),
    "offsets in a path": (
        lambda: lissom.Tendon("t", [(0, 0.004)], tension=1.0),
        r"path\[0\]: .*did you mean lissom.Along\(offset=\(0, 0.004\)\)",
    ),
    "points in a path": (
        lambda: lissom.Tendon("t", [(0, 0, 0.1), (0, 0, 0.2)], tension=1.0),
        r"path\[0\]: .*did you mean lissom.Via\(point=\(0, 0, 0.1\)\)",
    ),
    "no name of a tendon": (lambda: lissom.Tendon([lissom.Along()], tension=1.0), r"did you mean path=\["),
    "sphere without centre": (lambda: lissom.Sphere(0.1), r"centre: .*; did you mean radius=0.1\?"),
    "one moment of inertia": (
        lambda: lissom.Body(1.0, inertia=1e-3),
        r"equal ones are \(0.001,\) \* 3$",
    ),
    "com": (lambda: lissom.Body(1.0, com=ORIGIN), "did you mean 'centre'"),
    "lower and upper": (
        lambda: lissom.Revolute((0, 1, 0), lower=-1, upper=1),
        r"'limits'\? They are the pair \(lower, upper\), with the `limit_stiffness`",
    ),
    "max_torque": (
        lambda: lissom.Motor("a", max_torque=1.0),
        r"'limits'\? They are the pair of the lowest and the highest torque",
    ),
    "material by name": (
        lambda: lissom.Segment(0.2, 0.01, material="steel"),
        r"materials have no names, .*`young_modulus` in Pa, `poisson_ratio` .*`density` in kg/m\^3",
    ),
    "material in place of a modulus": (
        lambda: lissom.Segment(0.2, 0.01, "steel"),
        r"young_modulus: expected a real number, got str; materials have no names, ",
    ),
    "material of the package": (lambda: lissom.steel, r"no attribute 'steel'; materials have no names, "),
    "material of a segment": (
        lambda: lissom.Segment.steel,
        r"type object 'Segment' has no attribute 'steel'; materials have no names, ",
    ),
    "misspelt attribute of a part": (lambda: lissom.Segment.lenght, r"'lenght'; did you mean 'length'\?$"),
    "attribute that no part has": (lambda: lissom.Link.zzz, r"'Link' has no attribute 'zzz'$"),
    "world as an end of a loop": (
        lambda: lissom.Robot([link()], loops=[lissom.Loop("a", "world", lissom.Weld())]),
        r"loops\[0\].b.link: got 'world', .*; the world is no link: None in its place",
    ),
    "world as a parent": (
        lambda: lissom.Robot([lissom.Link("a", parent="world", body=lissom.Body(1.0))]),
        r"parent: got 'world', .*; the world is no link: leave `parent` out",
    ),
}


def link():
    return lissom.Link("a", joint=lissom.Free(), body=lissom.Body(0.1, inertia=(1e-5,) * 3))


@pytest.mark.parametrize("what", CALLS)
def test_what_is_meant_is_named(what):
    call, said = CALLS[what]
    with pytest.raises((TypeError, ValueError, AttributeError)) as caught:
        call()
    assert re.search(said, str(caught.value)), str(caught.value)


def test_what_is_advised_is_accepted():
    """Each piece of advice of the table above that can be followed, followed."""
    made = lissom.Tendon("t", [lissom.Along(offset=(0, 0.004))], tension=1.0)
    assert made.path[0].offset == (0, 0.004)
    lissom.Tendon("t", [lissom.Via(None, point=(0, 0, 0.1)), lissom.Along()], tension=1.0)
    assert lissom.Sphere(centre=ORIGIN, radius=0.1).radius == 0.1
    assert lissom.Body(1.0, inertia=(0.001, 0.001, 0.001)).inertia[1, 1] == 0.001
    assert lissom.Revolute((0, 1, 0), limits=(-1, 1), limit_stiffness=10.0).limits == (-1, 1)
    assert lissom.Motor("a", torque=1.0, limits=(-1, 1)).limits == (-1, 1)
    assert lissom.Robot([link()], loops=[lissom.Loop("a", None, lissom.Weld())]).loops[0].b.link is None
    steel = {"young_modulus": 2.1e11, "poisson_ratio": 0.3, "density": 7850}
    assert lissom.Segment(0.2, 0.01, modes={"bend_y": 1}, **steel).shear_modulus == pytest.approx(
        2.1e11 / 2.6
    )
    # A circle of radius r and mass m per length is that of a round section of one material.
    r, m = 0.01, 0.5
    given = lissom.Section.given((1,) * 6, m, inertia=(m * r**2 / 2, m * r**2 / 4, m * r**2 / 4))
    round_one = lissom.Segment(1.0, r, 1e6, 4e5, m / (np.pi * r**2), modes={"bend_y": 1})
    of_given = lissom.Segment(1.0, section=given, modes={"bend_y": 1})
    np.testing.assert_allclose(of_given.inertia(0.5), round_one.inertia(0.5), rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        *(("bend", "bend_y"), ("bending", "bend_y"), ("twist", "torsion"), ("stretching", "stretch")),
        *(("extension", "stretch"), ("shear", "shear_z"), ("Bend_y", "bend_y"), ("torsoin", "torsion")),
    ],
)
def test_names_of_strains_by_other_words(word, meant):
    with pytest.raises(ValueError, match=rf"modes\.{word}: .*; did you mean '{meant}'\?"):
        lissom.Segment(0.2, 0.01, modes={word: 3}, **MATERIAL)
    text = SCENE.replace("bend_y = 2", f"{word} = 2")
    (problem,) = problems(text)
    assert f"did you mean `{meant}`?" in problem.right


SCENE = """version = 1
[[rod]]
[[rod.segment]]
length = 0.2
radius = 0.01
young_modulus = 3e5
poisson_ratio = 0.45
density = 1100
modes = { bend_y = 2 }
[simulation]
t_end = 0.1
"""


def problems(text):
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(text)
    return caught.value.problems


def test_scenes_say_the_same():
    (problem,) = problems(SCENE.replace("radius = 0.01", "diameter = 0.02"))
    assert problem.right == "did you mean `radius`? It is half the diameter"
    found = problems(SCENE.replace("young_modulus", "E").replace("radius", "d"))
    assert sorted(each.key for each in found) == ["rod[0].segment[0].E", "rod[0].segment[0].d"]


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        *(("continuous", "Revolute"), ("hinge", "Revolute"), ("revolute", "Revolute")),
        *(("prismatic", "Prismatic"), ("slide", "Prismatic"), ("slider", "Prismatic")),
        *(("fixed", "Weld"), ("ball", "Spherical"), ("floating", "Free")),
    ],
)
def test_joints_by_words_of_other_programs(word, meant):
    with pytest.raises(TypeError, match=rf"did you mean lissom\.{meant}\(...\)\?"):
        lissom.Link("a", joint=word, body=lissom.Body(1.0))
    joint = f'joint = {{ type = "{word}", axis = [0, 1, 0] }}'
    text = f'version = 1\n[[link]]\nname = "a"\nbody = {{ mass = 1 }}\n{joint}'
    if word.capitalize() != meant:
        (problem,) = problems(f"{text}\n[simulation]\nt_end = 1\n")
        assert f'did you mean "{meant.lower()}"?' in problem.right


def test_files_of_other_kinds_say_what_reads_them(tmp_path):
    for name, reader in (
        ("arm.urdf", "Robot.from_urdf"),
        ("arm.toml", "Scene.load"),
        ("x.csv", "RecordedMotion"),
    ):
        with pytest.raises(ValueError, match=rf"has to end with one of .*lissom\.{reader}"):
            lissom.load(tmp_path / name)
        assert eval(f"lissom.{reader}")
    with pytest.raises(ValueError, match=r"\.nc$"):
        lissom.load(tmp_path / "x.jpg")


@pytest.mark.parametrize(
    "call",
    [
        lambda name: lissom.sensitivity(rod(), 0.1, [name]),
        lambda name: lissom.equilibrium_sensitivity(rod(), [name]),
        lambda name: lissom.sweep(rod(), {name: [1e5]}, t_end=0.1),
        lambda name: lissom.fit(rod(), ([0.0, 0.01], np.zeros((2, 1, 3))), {name: 1e5}),
    ],
)
def test_parameters_of_segments_are_named_by_their_paths(call):
    for name in ("young_modulus", "E", "youngs_modulus"):
        with pytest.raises(ValueError, match=r"did you mean 'segments\[\*\]\.young_modulus'\?"):
            call(name)
    with pytest.raises(ValueError, match="did you mean 'gravity'"):
        call("gravty")


def rod():
    return lissom.Rod([segment()])


def test_paths_lead_to_parts_of_parts():
    robot = lissom.Robot([lissom.Link("arm", joint=lissom.Revolute((0, 1, 0), damping=0.1), rod=[segment()])])
    for name, path in (("density", "links[*].rod[*].density"), ("damping", "links[*].joint.damping")):
        with pytest.raises(ValueError, match=rf"did you mean '{re.escape(path)}'\?"):
            lissom.sensitivity(robot, 0.1, [name])
        assert lissom.sensitivity(robot, 0.02, [path], dt=0.01).names == (path,)
    with pytest.raises(ValueError, match=r"did you mean 'links\[0\]\.rod\[\*\]\.density'\?"):
        lissom.sensitivity(robot, 0.1, ["links[0].density"])
    scene = lissom.Scene.loads(SCENE)
    with pytest.raises(ValueError, match=r"did you mean 'rod\[\*\]\.segment\[\*\]\.density'\?"):
        lissom.sweep(scene, {"density": [1000.0]})


def test_rows_of_inputs_say_their_shape():
    model = pulled()
    for u in ([1, 2, 3], np.linspace(0, 1, 3)):
        with pytest.raises(
            ValueError,
            match=r"u: got shape \(3,\), expected \(k, 1\): a row of the input 'pull' for each of k .*"
            r"numpy.reshape\(u, \(-1, 1\)\) or \{'pull': u\}",
        ):
            lissom.statics_many(model, u)
    with pytest.raises(ValueError, match=r"got shape \(1, 3\), expected \(k, 1\)"):
        lissom.statics_many(model, [[1, 2, 3]])
    with pytest.raises(ValueError, match=r"u: the model has no inputs: leave `u` out"):
        lissom.statics_many(rod(), [[1.0]])
    # What is advised is one thing.
    numbers = [0.0, 0.5, 1.0]
    found = lissom.statics_many(model, np.reshape(numbers, (-1, 1)))
    np.testing.assert_array_equal(found.q, lissom.statics_many(model, {"pull": numbers}).q)


def test_one_row_of_inputs_is_for_all_rows():
    model = pulled()
    found = lissom.statics_many(model, [0.5], q0=np.zeros((2, model.n)))
    assert found.u.tolist() == [[0.5], [0.5]]
    assert len(lissom.statics_many(model, [0.5])) == 1
    np.testing.assert_array_equal(found.q[0], lissom.statics(model, np.zeros(model.n), u=[0.5]).q)


def test_friction_that_is_left_out_is_said_of_each_row():
    found = lissom.statics_many(pulled(friction=0.2), {"pull": [0.5, 1.0]})
    for message in found.message:
        assert "friction is left out of 'pull'" in message


def test_results_without_a_model_ask_for_it(tmp_path):
    model = pulled()
    rest, path = lissom.statics(model), tmp_path / "x.html"
    for call in (rest.plot, rest.peaks, lambda: rest.report(path), lambda: rest.picture(path)):
        with pytest.raises(TypeError, match=r"missing required argument 'model': .*give that of the search"):
            call()
    with pytest.raises(
        TypeError, match=r"missing required argument 'q': the shape about which the modes are"
    ):
        lissom.modes(model, rest.q).report(path, model)
    rest.report(path, model)
    assert path.stat().st_size > 1000
