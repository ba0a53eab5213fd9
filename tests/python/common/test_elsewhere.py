"""Names that lissom does not have are answered with what it has."""

import copy
import pickle

import pytest

import lissom
from lissom.attached.missing import INSTEAD
from lissom.common.elsewhere import NAMES


@pytest.mark.parametrize("name", NAMES)
def test_names_of_other_programs_lead_to_names_that_exist(name):
    assert not hasattr(lissom, name)
    assert hasattr(lissom, NAMES[name])
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; use lissom.{NAMES[name]}$"):
        getattr(lissom, name)


def test_misspelt_names_are_answered_with_the_right_ones():
    for name, right in (("simulte", "simulate"), ("Segmnt", "Segment"), ("robot", "Robot")):
        with pytest.raises(AttributeError, match=f"no attribute '{name}'; did you mean '{right}'"):
            getattr(lissom, name)
    for name in ("zzzz", "__wrapped__", "_simulate"):
        with pytest.raises(AttributeError, match=f"no attribute '{name}'$"):
            getattr(lissom, name)


def rod():
    return lissom.Rod([lissom.Segment(0.2, 0.01, 1e6, 4e5, 1000.0, modes={"bend_y": 2})])


MADE = {
    lissom.MotionResult: lambda: lissom.simulate(rod(), 0.02),
    lissom.StaticsResult: lambda: lissom.statics(rod()),
    lissom.ModesResult: lambda: lissom.modes(rod(), [0.0, 0.0]),
    lissom.Simulation: lambda: lissom.Simulation(rod(), dt=1e-2),
}


@pytest.mark.parametrize("kind", INSTEAD)
def test_missing_attributes_say_what_to_use(kind):
    made = MADE[kind]()
    assert isinstance(made, kind)
    for name, hint in INSTEAD[kind].items():
        with pytest.raises(AttributeError) as caught:
            getattr(made, name)
        assert str(caught.value) == f"'lissom.{kind.__name__}' object has no attribute {name!r}: {hint}"
        assert caught.value.name == name
    with pytest.raises(AttributeError, match=r"no attribute 'zzzz'$"):
        _ = made.zzzz
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
    simulation = MADE[lissom.Simulation]()
    simulation.step(None, 0.02)
    assert simulation.model.pose(simulation.q, t=simulation.t).shape == (4, 4)
