"""Advice of `lissom check`: computed correctly, and given only if it applies."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.testing import assert_allclose

import lissom
from lissom import cli
from lissom.analysis import advice as words
from lissom.analysis.advice import advice

SCENES = Path(__file__).parents[3] / "scenes"


def scene(simulation="t_end = 1.0\ndt = 1e-3", modes="bend_y = 8", radius=1e-3, **segment):
    material = {"young_modulus": 210e9, "shear_modulus": 80e9, "density": 7800.0} | segment
    lines = "\n".join(f"{name} = {value}" for name, value in material.items())
    return lissom.Scene.loads(
        f"version = 1\n[[rod]]\n[[rod.segment]]\nlength = 1.0\nradius = {radius}\n{lines}\n"
        f"modes = {{ {modes} }}\n[simulation]\n{simulation}\n"
    )


def advice_with(text, scene):
    """The sentence that contains a text; None if there is none."""
    found = [sentence for sentence in advice(scene) if text in sentence]
    assert len(found) < 2
    return found[0] if found else None


def frequencies(scene):
    return lissom.modes(scene.model, lissom.statics(scene.model).q).frequency


def test_which_frequencies_a_step_resolves():
    lab = lissom.Scene.load(SCENES / "lab-horizontal.toml")
    assert_allclose(frequencies(lab)[2], 48.5, atol=0.05)
    assert advice_with("The step", lab) == (
        "The step of 0.01 s resolves the first 2 of 3 natural frequencies; "
        "the next, 48.5 Hz, needs steps of 0.0021 s (10 per period)."
    )


@pytest.mark.parametrize("number", [0, 1, 2])
def test_the_step_that_is_needed_is_enough(number):
    """With a step of a tenth of the period, the frequency is resolved."""
    hertz = frequencies(scene(modes="bend_y = 3"))
    for factor, resolved in ((0.999, number + 1), (1.001, number)):
        simulation = f"t_end = 1.0\ndt = {factor / (10 * hertz[number]):.17g}"
        said = advice_with("The step", scene(simulation, modes="bend_y = 3"))
        which = f"resolves the first {resolved} of 3" if resolved else "resolves none of 3"
        assert said is None if resolved == 3 else which in said


@pytest.mark.parametrize("how", ['method = "rk45"', 'method = "radau"', 'method = "auto"'])
def test_nothing_about_the_step_of_adaptive_methods(how):
    assert advice_with("The step", scene(f"t_end = 1.0\n{how}")) is None


def test_creeping_motions_need_no_step():
    assert advice_with("The step", scene("t_end = 1.0", modes="bend_y = 1", retardation_time=10.0)) is None


def test_how_right_the_frequencies_are():
    lab = lissom.Scene.load(SCENES / "lab-horizontal.toml")
    said = advice_with("natural frequencies are accurate", lab)
    assert said.startswith(
        "2 of 3 natural frequencies are accurate to 1%: with more modes of every strain the first"
    )
    assert "number 3, 48.5 Hz, becomes 25.3 Hz (92% off)" in said
    assert advice_with("natural frequencies are accurate", scene(modes="bend_y = 8")) is None


@pytest.mark.parametrize(
    ("radius", "modes", "said"),
    [
        (0.15, "bend_y = 2", "is only 6.7 times its radius, and shear_z has no modes: shear would add"),
        (0.15, "bend_y = 2, bend_z = 2, shear_z = 1", "and shear_y has no modes"),
        (0.15, "bend_y = 2, bend_z = 2", "and shear_y and shear_z have no modes"),
        (0.15, "bend_y = 2, shear_z = 2", None),
        (0.15, "torsion = 2", None),
        (0.09, "bend_y = 2", None),
    ],
)
def test_thick_rods_without_shear(radius, modes, said):
    found = advice_with("shear would add", scene(radius=radius, modes=modes))
    assert found is None if said is None else said in found


def test_what_shear_would_add_is_what_it_adds():
    """The deflections of the rods themselves, under a small force at the tip."""
    deflections = []
    for modes in ({"bend_y": 3}, {"bend_y": 3, "shear_z": 1}):
        segment = lissom.Segment(1.0, 0.15, 1e9, 4e8, 1e3, modes, shear_correction=0.9)
        rod = lissom.Rod([segment], gravity=(0, 0, 0), tip_force=(0, 0, 1.0))
        deflections.append(rod.pose(lissom.statics(rod).q, 1.0)[2, 3])
    added = deflections[1] / deflections[0] - 1
    assert_allclose(words.shear_deflection(segment, 1.0), added, rtol=1e-4)
    assert 0.04 < added < 0.06


STIFF = {"modes": "bend_y = 2, stretch = 2, shear_z = 2", "young_modulus": 5e6, "shear_modulus": 2e6}


@pytest.mark.parametrize("method", ["rk45", "dop853"])
def test_explicit_methods_on_stiff_scenes(method):
    stiff = scene(f't_end = 1.0\nmethod = "{method}"', radius=0.02, **STIFF)
    said = advice_with("is stable with steps below", stiff)
    assert said.startswith(f'Method "{method}" is stable')
    assert advice_with("is stable", scene(f't_end = 1.0\nmethod = "{method}"', modes="bend_y = 2")) is None
    assert advice_with("is stable", scene('t_end = 1.0\nmethod = "radau"', radius=0.02, **STIFF)) is None


@pytest.mark.parametrize("eigenvalue", [-50.0, -20.0 + 40.0j, -1.0 + 50.0j])
@pytest.mark.parametrize("method", [lissom.RK45, lissom.DOP853])
def test_the_stable_step_is_the_largest_stable_one(method, eigenvalue):
    """Steps of a fixed size for y' = eigenvalue y, as a real system."""
    a, b = eigenvalue.real, eigenvalue.imag
    matrix = np.array([[a, -b], [b, a]])
    stable = words.stable_step(method, complex(eigenvalue))

    def after(h):
        found = lissom.solve_ivp(
            lambda t, y: matrix @ y,
            (0, 200 * h),
            [1.0, 0.0],
            method,
            first_step=h,
            max_step=h,
            rtol=0.1,
            atol=1e300,
        )
        return np.linalg.norm(found.y[:, -1])

    most = (1 + words.STABLE_GROWTH) ** 200
    assert after(0.98 * stable) < most < after(1.02 * stable)


def test_known_stability_limits():
    """On the real axis: Hairer and Wanner (1996), section IV.2; their DOP853 has the stiffness limit 6.1."""
    assert_allclose(words.stable_step(lissom.RK45, -1.0 + 0j), 3.3, atol=0.05)
    assert 6.1 < words.stable_step(lissom.DOP853, -1.0 + 0j) < 6.5


def test_what_cannot_be_looked_at_is_left_out():
    large = scene(modes="bend_y = 51, bend_z = 50")
    assert large.model.n == words.MOST_COORDINATES + 1
    assert advice(large) == []


def test_the_pendulum():
    assert advice(lissom.Scene.load(SCENES / "lab-pendulum.toml")) == []


def test_check_prints_it_after_the_verdict(tmp_path):
    path = SCENES / "lab-horizontal.toml"
    done = CliRunner().invoke(cli.commands, ["check", str(path)], standalone_mode=False)
    assert done.return_value == 0
    lines = done.output.splitlines()
    assert lines[0] == f"{path}: good, 3 generalised coordinates"
    assert lines[1:] == [f"  {sentence}" for sentence in advice(lissom.Scene.load(path))]
    assert len(lines) == 3


def test_models_made_in_python_are_asked_too(tmp_path):
    """A rod in millimetres, megapascals and tonnes: each number is questioned, in the report as well."""
    lab = lissom.Scene.load(SCENES / "lab-horizontal.toml")
    assert lab.advice() == advice(lab)
    assert lab.model.advice() == []
    segment = lissom.Segment(80.0, 4.0, 0.3, 0.1, 1e-6, modes={"bend_y": 3})
    rod = lissom.Rod([segment])
    asked = rod.advice()
    for word in ("0.3 Pa", "1e-6 kg/m³", "8 m wide"):
        assert any(word in sentence for sentence in asked), (word, asked)
    at_rest = lissom.Rod([segment], gravity=(0.0, 0.0, 0.0))
    lissom.statics(at_rest).report(tmp_path / "rest.html", at_rest)
    lissom.simulate(at_rest, 1e-2, dt=1e-2).report(tmp_path / "motion.html")
    for page in ("rest.html", "motion.html"):
        assert "softer than any gel" in (tmp_path / page).read_text(encoding="utf-8")


def test_an_equilibrium_in_other_units_says_so():
    """Numbers in any units are in equilibrium: the message asks about them."""
    jelly, gel = (
        lissom.statics(
            lissom.Rod([lissom.Segment(1.0, 0.05, E, E / 3, 1e3, {"bend_y": 3})]), space_error=False
        )
        for E in (0.3e6, 0.3)
    )
    assert "any gel" not in jelly.message
    assert "A Young's modulus of 0.3 Pa is softer than any gel" in gel.message


def test_implausible_sizes_of_all_kinds():
    """Stiff, heavy and wide beyond everything; a given section has neither a modulus nor a density."""
    odd = lissom.Segment(1.0, (0.5, 3.0), 3e12, 1e12, 3e4, {"bend_y": 2})
    asked = lissom.Rod([odd], gravity=(0.0, 0.0, -9810.0)).advice()
    for words_of in ("3e12 Pa is stiffer than diamond", "30000 kg/m³ is heavier", "6 m wide", "9810 m/s²"):
        assert any(words_of in sentence for sentence in asked), (words_of, asked)
    section = lissom.Section.given(stiffness=[1, 1, 1, 1, 1, 1], inertia=[1e-3] * 3, mass=1.0)
    given = lissom.Segment(1.0, section=section, modes={"bend_y": 2})
    assert lissom.Rod([given]).advice() == []
