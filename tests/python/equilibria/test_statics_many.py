"""Equilibria under many inputs, from many starts, of many models."""

import copy
import pickle
import warnings

import numpy as np
import pytest

import lissom
from lissom.analysis import many


def rod(young=3e5, modes=3):
    segment = lissom.Segment(
        0.2, 0.01, young, poisson_ratio=0.45, density=1100, modes={"bend_y": modes}, retardation_time=0.02
    )
    pull = lissom.Tendon("pull", [lissom.Along(offset=(0, 0.006))], tension=lissom.Input("pull", 0.0))
    return lissom.Rod([segment], actuators=[pull])


PULLS = np.linspace(0.0, 4.0, 13)[:, None]


@pytest.mark.parametrize("workers", [None, 1, 3])
def test_rows_are_those_of_statics(workers):
    found = lissom.statics_many(rod(), PULLS, workers=workers, tol=1e-9)
    each = [lissom.statics(rod(), u=u, tol=1e-9) for u in PULLS]
    np.testing.assert_array_equal(found.q, [one.q for one in each])
    assert found.message == tuple(one.message for one in each)
    assert list(found.status) == [one.status for one in each]
    assert found.is_stable == tuple(one.is_stable for one in each)
    np.testing.assert_array_equal(found.nit, [one.nit for one in each])
    np.testing.assert_array_equal(found.residual_norm, [one.residual_norm for one in each])
    assert found.success.all()
    assert len(found) == len(PULLS)
    assert repr(found) == "<EquilibriaResult: 13 of 13 equilibria found, n = 3>"
    assert rod().pose(found.q).shape == (13, 4, 4)


def test_models_and_starts_of_their_own():
    youngs = (2e5, 3e5, 5e5)
    found = lissom.statics_many([rod(young) for young in youngs], q0=np.eye(3))
    each = [lissom.statics(rod(young), start).q for young, start in zip(youngs, np.eye(3), strict=True)]
    np.testing.assert_array_equal(found.q, each)
    np.testing.assert_array_equal(
        lissom.statics_many(rod(), PULLS[:2], np.ones(3)).q,
        [lissom.statics(rod(), np.ones(3), u=u).q for u in PULLS[:2]],
    )
    assert len(lissom.statics_many(rod())) == 1


def test_followed_rows_stay_on_their_branch():
    """Pushed to one side beyond buckling, and then a little back: the column stays on that side."""
    segment = lissom.Segment(1.0, 0.01, 1e9, poisson_ratio=0.3, density=1000, modes={"bend_y": 4})
    load = lissom.Load(force=lissom.Input("force", (0.0, 0.0, 0.0)))
    column = lissom.Rod([segment], gravity=(0, 0, 0), loads=[load])
    critical = np.pi**2 * 1e9 * np.pi * 0.01**4 / 4 / 4.0
    down = np.r_[np.zeros(3), np.linspace(0.0, 1.5, 8), np.full(8, 1.5)] * critical
    aside = np.r_[np.linspace(0.0, 0.05, 3), np.full(8, 0.05), np.linspace(0.05, -0.02, 8)] * critical
    u = np.stack([-down, np.zeros_like(down), aside], axis=1)
    followed = lissom.statics_many(column, u, follow=True)
    assert followed.success.all()
    tips = column.pose(followed.q)[:, 2, 3]
    # The side of the first push, although the last push is to the other one.
    assert tips[-1] > 0.3
    alone = lissom.statics_many(column, u[-1:])
    assert column.pose(alone.q)[0, 2, 3] < -0.3
    last = None
    for row, one in zip(u, followed.q, strict=True):
        last = lissom.statics(column, last, u=row).q
        np.testing.assert_array_equal(last, one)


def test_rows_without_equilibrium_do_not_stop_the_others():
    found = lissom.statics_many(rod(), PULLS, max_iter=1, method="newton")
    assert not found.success.all()
    assert len(found.message) == len(PULLS)
    followed = lissom.statics_many(rod(), PULLS, max_iter=1, method="newton", follow=True)
    assert not followed.success.all()


@pytest.mark.parametrize("workers", [1, 3])
def test_doubts_of_all_rows_are_one_warning(workers):
    """That of the row whose modes lack most, which is another one than the first."""
    coarse = rod(modes=1)
    with pytest.warns(lissom.AccuracyWarning) as caught:
        found = lissom.statics_many(coarse, PULLS, workers=workers)
    (warned,) = caught
    assert warned.filename == __file__
    errors = [one.space_error.relative for one in found]
    row = int(np.argmax(errors))
    assert row > 0
    count, said = str(warned.message).split(": ", 1)
    assert said in found.message[row]
    assert said not in found.message[0]
    assert count == f"{sum('number of modes' in message for message in found.message)} of 13 rows"


def test_a_warning_that_is_an_error_keeps_the_rows():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(lissom.AccuracyWarning) as caught:
            lissom.statics_many(rod(modes=1), PULLS)
    assert caught.value.result.success.all()


def test_rows_are_results(tmp_path):
    found = lissom.statics_many(rod(), PULLS)
    assert len(list(found)) == 13
    np.testing.assert_array_equal(found[-1].q, found.q[-1])
    assert found[2].status == found.status[2]
    found[3].report(tmp_path / "row.html", rod(), u=PULLS[3])
    assert (tmp_path / "row.html").exists()
    with pytest.raises(IndexError, match="row: got 13, expected one of 13 rows"):
        found[13]
    with pytest.raises(TypeError, match="row: expected a whole number, got str"):
        found["3"]


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda: lissom.statics_many("rod"), TypeError, "model: expected a Model .*, got str"),
        (lambda: lissom.statics_many(3), TypeError, "model: expected a Model .*, got int"),
        (lambda: lissom.statics_many([rod(), rod(modes=2)]), ValueError, r"model\[1\]: got one with 2 coord"),
        (
            lambda: lissom.statics_many(rod(), [1.0, 2.0]),
            ValueError,
            r"u: got shape \(2,\), expected \(k, 1\)",
        ),
        (lambda: lissom.statics_many(rod(), PULLS, np.zeros((2, 3))), ValueError, "q0: got 13 of u, 2 of q0"),
        (
            lambda: lissom.statics_many(rod(), q0=[0.0]),
            ValueError,
            r"q0: got shape \(1,\), expected \(3,\) or",
        ),
        (
            lambda: lissom.statics_many(rod(), PULLS, workers=0),
            ValueError,
            "workers: got 0, expected a whole",
        ),
        (lambda: lissom.statics_many(rod(), PULLS, max_itr=3), TypeError, "did you mean 'max_iter'"),
        (lambda: lissom.statics_many(rod(), PULLS, tol=-1.0), ValueError, "row 0: tol: "),
    ],
)
def test_bad_arguments_are_refused(call, kind, message):
    with pytest.raises(kind, match=message):
        call()


@pytest.mark.parametrize("follow", [False, True])
def test_ctrl_c_keeps_the_rows_until_then(follow, monkeypatch):
    real, rows = many.statics, []

    def interrupting(*arguments, **options):
        rows.append(None)
        if len(rows) == 5:
            raise KeyboardInterrupt
        return real(*arguments, **options)

    monkeypatch.setattr(many, "statics", interrupting)
    with pytest.raises(KeyboardInterrupt) as caught:
        lissom.statics_many(rod(), PULLS, follow=follow, workers=1)
    found = caught.value.result
    assert list(found.status[4:]) == ["not_run"] * 9
    assert found.success[:4].all()
    assert np.isnan(found.q[4:]).all()
    with pytest.raises(LookupError, match="row: 5 was not run"):
        found[5]


@pytest.mark.parametrize("way", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_copies(way):
    found = lissom.statics_many(rod(), PULLS[:3])
    twin = way(found)
    np.testing.assert_array_equal(twin.q, found.q)
    assert not twin.q.flags.writeable
    assert twin.message == found.message
    np.testing.assert_array_equal(twin[1].q, found[1].q)
