"""Reports say what a result is worth: colours of outcomes, layers, units and values that have no time."""

import re

import numpy as np
import pytest

import lissom
from lissom.drawing.oscillation import frequency
from lissom.drawing.report import build_result, contacts, layers, page
from lissom.drawing.report.motion import scene_of
from lissom.drawing.report.studies import equilibrium, table, vibrations
from lissom.model.views import view
from lissom.results.runs import Made
from lissom.results.studies import setting_for


def segment(**more):
    return lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3}, **more)


def tendon_rod():
    path = [lissom.Along(offset=(0, 0.008))]
    return lissom.Rod([segment(retardation_time=0.02)], actuators=[lissom.Tendon("pull", path, tension=2.0)])


def ball_on_a_floor(radius=0.05, inertia=2 / 5 * 0.05**2, contacts=1):
    link = lissom.Link(
        "ball", joint=lissom.Free(), position=(0, 0, 0.2), body=lissom.Body(1.0, inertia=inertia * np.eye(3))
    )
    pairs = [
        lissom.Contact(
            lissom.Ball("ball", radius), lissom.HalfSpace((0, 0, -k)), stiffness=1e5, name=f"floor {k}"
        )
        for k in range(contacts)
    ]
    return lissom.Robot([link], contacts=pairs)


def test_a_doubt_makes_an_outcome_red():
    stiff = lissom.Rod([lissom.Segment(0.5, 5e-3, 2.4e10, 1e10, 1200.0, {"bend_y": 2})], gravity=(0, 0, 0))
    with pytest.warns(lissom.AccuracyWarning):
        doubted = lissom.simulate(stiff, 0.2, q0=[0.4, 0.0])
    words, is_good = build_result(doubted, "x").outcome
    assert (is_good, words) == (False, f"Finished. {doubted.doubt}")
    assert build_result(lissom.simulate(stiff, 0.2, q0=[0.004, 0.0]), "x").outcome == ("Finished.", True)


@pytest.mark.parametrize(
    ("robot", "count"),
    [
        (ball_on_a_floor(), 0),
        (ball_on_a_floor(contacts=2), 0),
        (ball_on_a_floor(radius=0.06), 1),
        (ball_on_a_floor(radius=0.06, contacts=2), 1),
    ],
)
def test_balls_are_drawn_once(robot, count):
    motion = lissom.simulate(robot, 0.05, dt=1e-3)
    drawn = scene_of(Made(motion, robot)).things
    assert len([thing for thing in drawn if thing.layer == "balls"]) == count
    assert len([thing for thing in drawn if thing.layer == "bodies"]) == 1


def test_balls_of_other_places_are_all_drawn():
    robot = ball_on_a_floor()
    q = np.zeros((2, robot.n))
    assert len(contacts.balls(view(robot).glyphs.contacts, q, np.zeros(2), [far_away(q)])) == 1


def far_away(q):
    places = np.full((len(q), 3), 7.0)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(q), 1))
    return layers.Solid("other", "bodies", "ellipsoid", np.full(3, 0.05), places, turns)


def test_legends_say_what_is_drawn():
    rod = tendon_rod()
    names = scene_of(Made(lissom.simulate(rod, 0.02), rod)).names
    assert (names["floor"], names["supports"]) == ("grid", "clamp")
    assert names["tendons"] == "tendons, thicker with more tension"
    held = lissom.Rod(
        [segment()], supports=[lissom.Support(position=(0.3, 0, 0), stiffness=(10.0, 10.0, 10.0))]
    )
    assert "supports" not in scene_of(Made(lissom.simulate(held, 0.02), held)).names


def test_tensions_of_rods_and_tendons_have_names_of_their_own():
    rod = tendon_rod()
    found = lissom.statics(rod)
    page_of_it = equilibrium(setting_for(found, rod), found, "x")
    rows = (
        next(section for section in page_of_it.sections if section.title == "Largest values").parts[-1].rows
    )
    names = [row[0] for row in rows]
    assert {"tension in a section", "tension of an actuator"} <= set(names)
    assert len(names) == len(set(names))


def test_peaks_of_equilibria_have_no_time():
    rod = tendon_rod()
    peak = lissom.statics(rod).peaks(rod)[0]
    assert (peak.t, peak.is_at_rest) == (0.0, True)
    assert re.fullmatch(r"curvature of rod: .* at X = [\d.]+ m", str(peak))
    moving = lissom.simulate(rod, 0.02).peaks()[0]
    assert str(moving).endswith(f", t = {moving.t:.6g} s")


def test_a_start_and_its_equilibrium_are_labelled_in_words():
    rod = tendon_rod()
    found = lissom.statics(rod, np.full(3, 0.1))
    (player,) = equilibrium(setting_for(found, rod), found, "x", np.full(3, 0.1)).sections[0].parts
    assert player.scene.label[0] == "way from start to equilibrium: "


def test_overdamped_modes_have_no_frequency():
    rod = lissom.Rod([segment(retardation_time=0.05)])
    found = lissom.modes(rod, [0, 0, 0])
    overdamped = found.eigenvalues.imag == 0.0
    assert 0 < overdamped.sum() < len(overdamped)
    for k, (row, is_real) in enumerate(zip(table(found), overdamped, strict=True)):
        assert (row[1] == "overdamped") == is_real
        assert ("Hz" in frequency(found, k)) != is_real
    titles = [each.title for each in vibrations(setting_for(found, rod), np.zeros(3), found, "x").sections]
    assert any("overdamped" in title for title in titles)


def test_paths_in_tables_may_break_and_numbers_may_not():
    rendered = page.render(
        page.Page(
            "x", "x", [page.Section("x", [page.Table(("a", "b"), [("segments[0].young_modulus", "1.25 m")])])]
        )
    )
    assert "segments[0].<wbr>young_<wbr>modulus" in rendered
    assert "<td>1.25 m</td>" in rendered


def limited():
    bent = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 3}, min_bend_radius=0.5)
    return lissom.Rod([bent])


def test_limits_that_are_exceeded_make_outcomes_red():
    rod = limited()
    motion = lissom.simulate(rod, 0.2, dt=2e-3)
    rest = lissom.statics(rod)
    setting = setting_for(rest, rod)
    for built in (build_result(motion, "x"), equilibrium(setting, rest, "x")):
        words, is_good = built.outcome
        assert not is_good
        assert "beyond limits of segments" in words
    free = lissom.Rod([segment()])
    assert build_result(lissom.simulate(free, 0.2, dt=2e-3), "x").outcome == ("Finished.", True)


def test_reports_of_modes_name_frequencies_that_the_rods_do_not_resolve():
    rod = lissom.Rod([segment()], gravity=(0, 0, 0))
    found = lissom.modes(rod, np.zeros(3))
    built = vibrations(setting_for(found, rod), np.zeros(3), found, "x")
    html = page.render(built)
    assert "with more modes (Hz)" in html
    assert f"{found.refined_frequency[2]:.4g}" in html
    assert built.outcome == ("Stable", True)
    one = lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 1})], gravity=(0, 0, 0))
    found = lissom.modes(one, [0.0])
    words, is_good = vibrations(setting_for(found, one), np.zeros(1), found, "x").outcome
    assert (is_good, words) == (False, "Stable, but the rods have too few modes for the first frequency")
