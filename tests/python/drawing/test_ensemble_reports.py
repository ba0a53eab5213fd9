"""Ensembles as datasets, pictures and reports."""

import matplotlib as mpl
import numpy as np
import pytest

import lissom
from lissom.analysis.quantiles import quantiles
from lissom.drawing.report import page, plots
from lissom.drawing.report.ensembles import build

mpl.use("Agg")


def rod():
    segment = lissom.Segment(
        0.3, 0.01, 3e5, 1.2e5, 1100, modes={"bend_y": 2, "stretch": 1}, retardation_time=0.02
    )
    return lissom.Rod([segment])


def many(keep="states", count=21, **options):
    q0 = np.zeros((count, 3))
    q0[:, 0] = np.linspace(0.0, 2.0, count)
    return lissom.simulate_many(rod(), 0.2, q0=q0, keep=keep, places=[0.3], dt=0.01, **options)


def with_failures():
    """Two of three runs fail because of their tip force."""
    wild = lissom.Rod(rod().segments, tip_force=(0, 0, 1e300))
    return lissom.simulate_many([rod(), wild, wild], 0.2, dt=0.01)


def test_quantiles_are_those_of_the_rows():
    result = many()
    found = quantiles(result)
    assert found.shape == (3, 21, 3)
    # At the start the rows are ordered: the middle one of 21, and the second from either end.
    np.testing.assert_allclose(found[:, 0, 0], [0.1, 1.0, 1.9], rtol=1e-12)
    with pytest.raises(ValueError, match="it has kept 'final'"):
        quantiles(many("final"))


@pytest.mark.parametrize("keep", ["states", "final", "summary"])
def test_datasets_hold_all_numbers(keep, tmp_path):
    result = many(keep)
    data = result.to_xarray(rod())
    assert dict(data.sizes)["row"] == 21
    assert data.sizes["coordinate"] == 3
    np.testing.assert_array_equal(data.q.values, result.q)
    np.testing.assert_array_equal(data.reached.values, result.reached)
    np.testing.assert_array_equal(data.stats_steps.values, result.stats["steps"])
    if keep == "summary":
        np.testing.assert_array_equal(data.position_mean.values, result.mean)
        np.testing.assert_array_equal(data.highest.values, result.highest)
    else:
        np.testing.assert_array_equal(data.position.values, result.poses[..., :3, 3])
    data.to_netcdf(tmp_path / "many.nc")


@pytest.mark.parametrize("keep", ["states", "final", "summary"])
def test_plots_show_every_kind_of_coordinate(keep):
    result = many(keep)
    axes = result.plot(rod())
    assert len(axes) == 2
    line = axes[0].lines[0]
    expected = quantiles(result)[1, :, 0] if keep == "states" else result.q[:, 0]
    np.testing.assert_array_equal(line.get_ydata(), expected)
    mpl.pyplot.close("all")


@pytest.mark.parametrize("keep", ["states", "final", "summary"])
def test_reports_say_how_the_runs_spread(keep, tmp_path):
    result = many(keep)
    result.report(tmp_path / "many.html", rod(), title="A rod, let go")
    text = (tmp_path / "many.html").read_text(encoding="utf-8")
    assert "A rod, let go" in text
    assert "21 of 21 runs came to their end" in text
    built = build(result, "x", None)
    figures = [part for section in built.sections for part in section.parts if isinstance(part, page.Figure)]
    assert len(figures) == (1 if keep == "final" else 2)
    shown = [plot for row in figures[0].figure.rows for plot in row]
    assert len(shown) == 3
    assert all(isinstance(plot, plots.Plot) for plot in shown)
    extremes = built.sections[0].parts[1]
    assert [float(x) for x in extremes.rows[1][1:]] == pytest.approx(
        [result.q[..., 1].min(), result.q[..., 1].max()]
        if keep != "summary"
        else [result.lowest[:, 1].min(), result.highest[:, 1].max()],
        rel=1e-5,
    )


def test_reports_show_where_places_are(tmp_path):
    result = many("states")
    [places] = [
        section.parts[0] for section in build(result, "x", rod()).sections if section.title == "Places"
    ]
    curves = places.figure.rows[0][0].curves
    positions = result.poses[:, :, 0, :3, 3]
    np.testing.assert_array_equal(curves[0].y, np.median(positions[..., 0], axis=0))
    np.testing.assert_array_equal(curves[8].y, np.quantile(positions[..., 2], 0.95, axis=0))


def test_runs_that_failed_are_named(tmp_path):
    result = with_failures()
    assert list(result.success) == [True, False, False]
    built = build(result, "x", rod())
    assert built.outcome == ("1 of 3 runs came to their end", False)
    [parts] = [section.parts for section in built.sections if section.title == "Runs that failed"]
    counts, failed = parts
    assert counts.rows == [(result.status[1], "2"), ("finished", "1")]
    assert [row[0] for row in failed.rows] == ["1", "2"]
    assert failed.rows[0][1] == result.status[1]
    result.plot()
    mpl.pyplot.close("all")


def test_nothing_to_show_is_said(tmp_path):
    wild = lissom.Rod(rod().segments, tip_force=(0, 0, 1e300))
    result = lissom.simulate_many(wild, 0.2, q0=np.zeros((2, 3)), dt=0.01)
    with pytest.raises(ValueError, match="no run came to its end"):
        result.plot()
    result.report(tmp_path / "none.html")
    assert "0 of 2 runs came to their end" in (tmp_path / "none.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match="the result has 3"):
        result.report(tmp_path / "none.html", lissom.SpringPendulum())
