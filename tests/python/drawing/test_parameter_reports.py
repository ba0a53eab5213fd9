"""Derivatives and identifications as files, datasets, pictures and reports."""

import copy
import dataclasses
import pickle
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

import lissom
from lissom.drawing.report import page
from lissom.drawing.report.parameters import build

mpl.use("Agg")

# Two modes of bending are few: the data are shapes of the same rod.
pytestmark = pytest.mark.filterwarnings("ignore:The finite number of modes:lissom.AccuracyWarning")

MODULUS, TIME = "segments[0].young_modulus", "segments[0].retardation_time"


def rod():
    return lissom.Rod([lissom.Segment(0.3, 0.01, 3e5, 5e5, 1100, modes={"bend_y": 2}, retardation_time=0.02)])


def objective(t, q, v):
    return float(q.sum()), np.ones_like(q), np.zeros_like(q)


def motion():
    run = lissom.simulate(rod(), 0.3)
    noise = 1e-4 * np.random.default_rng(5).standard_normal((30, 2, 3))
    places = np.array([[rod().pose(q, X)[:3, 3] for X in (0.15, 0.3)] for q in run.q[1:]])
    return run.t[1:], places + noise


def fitted():
    return lissom.fit(
        rod(), motion(), {MODULUS: (1e5, 4e5, 1e6), TIME: (1e-3, 0.01, 0.1)}, places=[0.15, 0.3]
    )


def shapes():
    shape = lissom.statics(rod(), space_error=False).q
    return lissom.fit(rod(), lissom.StaticShapes([rod().pose(shape)[:3, 3]]), {MODULUS: (1e5, 4e5, 1e6)})


def frequencies():
    own = lissom.equilibrium_sensitivity(rod(), ["gravity[2]"], frequencies=2).frequencies
    return lissom.fit(rod(), lissom.NaturalFrequencies(own), {"segments[0].density": (500, 900, 2000)})


def several():
    shape = lissom.statics(rod(), space_error=False).q
    positions = rod().pose(shape)[:3, 3] + [[0.0, 0.0, 1e-4], [0.0, 0.0, -1e-4]]
    own = lissom.equilibrium_sensitivity(rod(), ["gravity[2]"], frequencies=2).frequencies
    run = lissom.simulate(rod(), 0.1)
    data = [
        lissom.RecordedMotion(run.t[1:], [rod().pose(q)[:3, 3] for q in run.q[1:]], noise=1e-3),
        lissom.StaticShapes(positions, noise=1e-3),
        lissom.NaturalFrequencies(own, noise=0.1),
    ]
    return lissom.fit(rod(), data, {MODULUS: (1e5, 4e5, 1e6), TIME: (1e-3, 0.01, 0.1)})


RESULTS = {
    "run": lambda: lissom.sensitivity(rod(), 0.2, [MODULUS, "segments[0].length", "q0"]),
    "gradient": lambda: lissom.sensitivity(rod(), 0.2, [MODULUS, "v0[1]"], objective=objective),
    "pendulum": lambda: lissom.sensitivity(lissom.SpringPendulum(), 0.2, ["mass", "stiffness"]),
    "equilibrium": lambda: lissom.equilibrium_sensitivity(rod(), [MODULUS, "gravity[2]"], frequencies=2),
    "gradient of an equilibrium": lambda: lissom.equilibrium_sensitivity(
        rod(), [MODULUS], objective=lambda q: (q[0], [1.0, 0.0])
    ),
    "motion": fitted,
    "shapes": shapes,
    "frequencies": frequencies,
    "several": several,
}
WAYS = {"copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda x: pickle.loads(pickle.dumps(x))}


def assert_same(one, other):
    for name, value in vars(one).items():
        if name == "data":
            for mine, others in zip(value, other.data, strict=True):
                assert_same(mine, others)
        elif isinstance(value, np.ndarray):
            np.testing.assert_array_equal(getattr(other, name), value)
            assert not getattr(other, name).flags.writeable
        elif isinstance(value, str | float | tuple | int | None) and not name.startswith("_"):
            assert getattr(other, name) == value
    assert repr(one) == repr(other)
    # Comparisons of arrays have no single truth value.
    assert one != other or one is other


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", RESULTS)
def test_copies_and_pickles(kind, way):
    result = RESULTS[kind]()
    twin = WAYS[way](result)
    assert_same(result, twin)
    if getattr(result, "dq", None) is not None and kind != "pendulum":
        np.testing.assert_array_equal(twin.position()[1], result.position()[1])
    with pytest.raises(ValueError, match="read-only"):
        next(value for value in vars(twin).values() if isinstance(value, np.ndarray))[...] = 0.0


@pytest.mark.parametrize("suffix", [".lissom", ".npz", ".nc"])
@pytest.mark.parametrize("kind", RESULTS)
def test_files_give_them_back(kind, suffix, tmp_path):
    result = RESULTS[kind]()
    # Also after requests for places, which create cached models.
    if getattr(result, "dq", None) is not None and kind != "pendulum":
        result.position()
    path = tmp_path / f"result{suffix}"
    result.save(path)
    assert_same(result, lissom.load(path))


@pytest.mark.parametrize("kind", RESULTS)
def test_datasets_pictures_and_reports(kind, tmp_path):
    result = RESULTS[kind]()
    data = result.to_xarray()
    assert list(data.parameter.values) == list(result.names)
    axes = result.plot()
    assert all(one.lines or one.patches for one in axes)
    mpl.pyplot.close("all")
    result.report(tmp_path / "report.html", title="A title of its own")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "A title of its own" in text
    # Names may break on narrow screens.
    assert all(name in text.replace("<wbr>", "") for name in result.names)
    with pytest.raises(TypeError, match="title"):
        result.report(tmp_path / "report.html", title=3)


def test_datasets_hold_the_numbers():
    found = RESULTS["run"]()
    data = found.to_xarray()
    np.testing.assert_array_equal(data.dq.sel(parameter="q0[1]"), found.dq[:, :, 3])
    np.testing.assert_array_equal(data.dposition, found.position()[1])
    fit = fitted()
    data = fit.to_xarray()
    np.testing.assert_array_equal(data.value.sel(parameter=MODULUS), fit.values[0])
    np.testing.assert_array_equal(data.low, fit.intervals[:, 0])
    assert data.residual.dims == ("time", "place", "axis")
    assert list(data.place.values) == ["rod, 0.15 m", "rod, 0.3 m"]


def parts(built, kind):
    return [part for section in built.sections for part in section.parts if isinstance(part, kind)]


def test_the_report_of_a_fit_says_values_correlations_and_residuals():
    found = fitted()
    built = build(found, None)
    values, correlations, *_ = parts(built, page.Table)
    low, high = found.intervals[0]
    assert values.rows[0] == (f"{MODULUS} (Pa)", f"{found.values[0]:.6g}", f"{low:.6g}", f"{high:.6g}")
    both = found.covariance[0, 1] / np.sqrt(found.covariance[0, 0] * found.covariance[1, 1])
    assert correlations.rows[0] == (MODULUS, "1.000", f"{both:.3f}")
    (figure,) = parts(built, page.Figure)
    measured, residual = figure.figure.rows[1]
    np.testing.assert_array_equal(residual.curves[2].y, found.residuals[:, 1, 2])
    np.testing.assert_allclose(measured.curves[5].y, motion()[1][:, 1, 2])
    # White noise causes no advice, but the doubt of the message does; the colour follows.
    said, _, doubt = found.message.partition(". ")
    assert (list(built.advice), built.outcome[1]) == ([doubt], False)
    clean = build(dataclasses.replace(found, message=f"{said}."), None)
    assert (clean.advice, clean.outcome) == ([], ("Converged.", True))
    # So does an incomplete model.
    stiff = lissom.fit(rod(), motion(), {TIME: (1e-3, 0.01, 0.1)}, places=[0.15, 0.3], q0=[0.3, 0.0])
    assert "correlated" in build(stiff, None).advice[0]


def test_every_recording_has_its_part_of_the_report():
    found = several()
    built = build(found, None)
    titles = [section.title for section in built.sections]
    assert titles == [
        "Parameters",
        *(
            f"Measured and fitted: data[{i}], {kind}"
            for i, kind in enumerate(("motion", "shapes", "frequencies"))
        ),
        "Result",
    ]
    assert len(parts(built, page.Figure)) == 2
    names = [row[0] for row in parts(built, page.Table)[-1].rows]
    assert "data[2], frequencies: root mean square of the residuals" in names
    data = found.to_xarray()
    np.testing.assert_array_equal(data.residual_2, found.data[2].residuals)
    assert data.measured_0.dims == ("time_0", "place_0", "axis")
    assert data.noise_2.attrs["units"] == "Hz"
    assert len(found.plot()) == 6
    mpl.pyplot.close("all")


def test_the_report_says_what_is_not_determined():
    bare = lissom.Rod([lissom.Segment(0.3, 0.01, 3e5, 5e5, 1100, modes={"bend_y": 2})], gravity=(0, 0, -9.81))
    shape = lissom.StaticShapes([bare.pose(lissom.statics(bare, space_error=False).q)[:3, 3]])
    bounds = {MODULUS: (1e5, 3e5, 1e6), "segments[0].density": (500, 1100, 2000)}
    built = build(lissom.fit(bare, shape, bounds), None)
    values = parts(built, page.Table)[0]
    assert values.columns[-1] == "note"
    assert [row[-1] for row in values.rows] == ["not determined"] * 2
    assert any("do not determine" in each and "other values fit as well" in each for each in built.advice)


def test_pickles_have_their_methods_in_a_new_process(tmp_path):
    (tmp_path / "found.pickle").write_bytes(pickle.dumps(RESULTS["run"]()))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).to_xarray().sizes['parameter'])"
    command = [sys.executable, "-c", code, tmp_path / "found.pickle"]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "4\n"
