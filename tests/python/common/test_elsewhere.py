"""Names that lissom does not have are answered with what it has."""

import copy
import pickle

import numpy as np
import pytest

import lissom
from lissom import sensors
from lissom.analysis import linear, many
from lissom.attached.missing import INSTEAD
from lissom.common.elsewhere import NAMES, OTHERS, READ, WRITTEN


@pytest.mark.parametrize("name", NAMES)
def test_names_of_other_programs_lead_to_names_that_exist(name):
    assert not hasattr(lissom, name)
    assert hasattr(lissom, NAMES[name])
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; use lissom.{NAMES[name]}$"):
        getattr(lissom, name)


@pytest.mark.parametrize("name", OTHERS)
def test_names_of_other_programs_lead_to_calls(name):
    with pytest.raises(AttributeError) as caught:
        getattr(lissom, name)
    assert str(caught.value) == f"module 'lissom' has no attribute {name!r}; {OTHERS[name]}"


def test_misspelt_names_are_answered_with_the_right_ones():
    for name, right in (("simulte", "simulate"), ("Segmnt", "Segment"), ("robot", "Robot")):
        with pytest.raises(AttributeError, match=f"no attribute '{name}'; did you mean '{right}'"):
            getattr(lissom, name)
    for name in ("zzzz", "__wrapped__", "_simulate"):
        with pytest.raises(AttributeError, match=f"no attribute '{name}'$"):
            getattr(lissom, name)


@pytest.mark.parametrize("name", sensors.INSTEAD)
def test_instruments_of_other_programs_lead_to_sensors(name):
    assert name not in vars(sensors)
    assert sensors.INSTEAD[name] in sensors.__all__
    with pytest.raises(
        AttributeError, match=f"no attribute '{name}'; use lissom.sensors.{sensors.INSTEAD[name]}$"
    ):
        getattr(sensors, name)
    for misspelt, right in (("imu", "Imu"), ("Gyroscop", "Gyroscope")):
        with pytest.raises(AttributeError, match=f"did you mean '{right}'"):
            getattr(sensors, misspelt)
    with pytest.raises(AttributeError, match=r"no attribute '__path_of_it__'$"):
        _ = sensors.__path_of_it__


def rod():
    return lissom.Rod([lissom.Segment(0.2, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})])


def arm():
    return lissom.Robot([lissom.Link("arm", rod=[rod().segments[0]])])


MADE = {
    lissom.Rod: rod,
    lissom.Robot: arm,
    lissom.LinearModel: lambda: lissom.linearise(
        rod(), [0.0, 0.0], "tip_force_z", "tip_position_z", held=True
    ),
    lissom.MotionResult: lambda: lissom.simulate(rod(), 0.02),
    lissom.StaticsResult: lambda: lissom.statics(rod()),
    lissom.ModesResult: lambda: lissom.modes(rod(), [0.0, 0.0]),
    lissom.OdeResult: lambda: lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0]),
    lissom.RootResult: lambda: lissom.root(lambda x: x - 1.0, 0.5),
    lissom.Scene: lambda: rod().to_scene(t_end=0.02),
    lissom.Simulation: lambda: lissom.Simulation(rod(), dt=1e-2),
    lissom.EquilibriaResult: lambda: lissom.statics_many(rod(), q0=[[0, 0], [0.1, 0]]),
}


#: What to use, also of classes that are written in Python.
ALL = {**INSTEAD, lissom.EquilibriaResult: many.INSTEAD, lissom.LinearModel: linear.INSTEAD}


@pytest.mark.parametrize("kind", ALL)
def test_missing_attributes_say_what_to_use(kind):
    made = MADE[kind]()
    assert isinstance(made, kind)
    for name, hint in ALL[kind].items():
        with pytest.raises(AttributeError) as caught:
            getattr(made, name)
        assert str(caught.value) == f"'lissom.{kind.__name__}' object has no attribute {name!r}: {hint}"
        assert caught.value.name == name
    with pytest.raises(AttributeError, match=r"no attribute 'zzzz'$"):
        _ = made.zzzz
    known = next(each for each in dir(made) if not each.startswith("_") and len(each) > 4)
    with pytest.raises(AttributeError, match=rf"did you mean '{known}'\?$"):
        getattr(made, f"{known}_")
    # What copies and pickles look for is not there, as before.
    assert isinstance(copy.deepcopy(made), kind)
    assert isinstance(pickle.loads(pickle.dumps(made)), kind)
    assert not hasattr(made, "__array__")


def test_what_is_advised_works():
    motion, rest = MADE[lissom.MotionResult](), MADE[lissom.StaticsResult]()
    assert motion.pose()[:, :3, 3].shape == (len(motion.t), 3)
    assert len(motion.balance.total) == len(motion.balance.kinetic) == len(motion.t)
    assert rod().pose(rest.q)[:3, 3].shape == (3,)
    assert rod().energy(rest.q, 0 * rest.q).total == pytest.approx(rod().energy(rest.q, 0 * rest.q).total)
    line = rod().pose(rest.q, np.linspace(0.0, 0.2, 50))[:, :3, 3]
    assert line.shape == (50, 3)
    assert len(rod().forward_dynamics(rest.q, 0 * rest.q)) == rod().n
    assert lissom.solve_ivp(rod(), (0.0, 0.01), np.zeros(2 * rod().n)).success
    assert len(np.linalg.eigvals(MADE[lissom.LinearModel]().A)) == 4
    many_rests = MADE[lissom.EquilibriaResult]()
    assert rod().pose(many_rests.q)[:, :3, 3].shape == (2, 3)
    assert many_rests[1].to_xarray().sizes
    for hint in ("slack", "stability", "lowest_eigenvalue", "space_error", "peaks", "path"):
        assert hasattr(many_rests[0], hint)
    scene = MADE[lissom.Scene]()
    assert scene.run().success
    assert lissom.statics(scene.model).success
    simulation = MADE[lissom.Simulation]()
    simulation.step(None, 0.02)
    assert simulation.model.pose(simulation.q, t=simulation.t).shape == (4, 4)


#: Methods that write or read files, what they say of other kinds, and the suffixes that they take.
FILES = {
    "save": (lambda path: MADE[lissom.MotionResult]().save(path), WRITTEN, ()),
    "animate": (lambda path: MADE[lissom.MotionResult]().animate(path), WRITTEN, (".gif", ".mp4", ".webm")),
    "picture": (lambda path: MADE[lissom.MotionResult]().picture(path), WRITTEN, (".png", ".pdf", ".svg")),
    "report": (lambda path: MADE[lissom.MotionResult]().report(path), WRITTEN, (".html", ".htm")),
    "load": (lissom.load, READ, ()),
}


@pytest.mark.parametrize("method", FILES)
def test_files_of_other_kinds_are_answered_with_what_writes_them(method, tmp_path):
    call, hints, taken = FILES[method]
    for suffix in hints.keys() - set(taken):
        with pytest.raises(ValueError, match="has to end with") as caught:
            call(tmp_path / f"run{suffix}")
        # A method is not answered with itself.
        is_answered = str(caught.value).endswith(f"; {hints[suffix]}")
        assert is_answered == (f"`{method}(" not in hints[suffix])


def test_tables_are_made_as_advised(tmp_path):
    MADE[lissom.MotionResult]().to_xarray().to_dataframe().to_csv(tmp_path / "run.csv")
    assert (tmp_path / "run.csv").stat().st_size > 100
