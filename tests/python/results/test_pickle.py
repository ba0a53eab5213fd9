"""Objects of lissom can be copied, pickled and sent to other processes, and are immutable."""

import concurrent.futures
import copy
import importlib
import multiprocessing
import pickle
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import lissom

MOVED = Path(__file__).parents[2] / "data" / "moved.pickle"
SCENES = sorted((Path(__file__).parents[3] / "scenes").glob("*.toml"))
WIRE = lissom.Segment(0.4, 1e-3, 2e11, 8e10, 7800, {"bend_y": 3}, retardation_time=1e-4)
TEXT = """
version = 1
[[rod]]
[[rod.segment]]
length = 0.4
radius = 1e-3
young_modulus = 2e11
shear_modulus = 8e10
density = 7800.0
modes = { bend_y = 3 }
[simulation]
t_end = 0.05
[simulation.output]
quantities = ["velocity", "energy"]
"""


def swing(t):
    """A load that other processes find by name."""
    return (0.0, 0.0, 0.1 * np.sin(20.0 * t))


def decay(t, y):
    return -y


ROD = lissom.Rod([WIRE], loads=[lissom.Load(force=swing, at=0.2)])
COLUMN = lissom.Rod(
    [lissom.Segment(1.0, 0.01, 1e9, 4e8, 1000, {"bend_y": 3})], gravity=(0, 0, 0), tip_force=(-25.0, 0, 0)
)
PULLED = lissom.Rod(
    [lissom.Segment(0.2, 2e-3, 1e9, 4e8, 1200, {"bend_y": 2})],
    actuators=[lissom.Tendon("pull", [lissom.Along(offset=(0, 0.01))], tension=lissom.Input("pull", 1.0))],
)
RESULTS = {
    "simulate": lambda: lissom.simulate(ROD, 0.05),
    "simulate, radau": lambda: lissom.simulate(ROD, 0.05, method="radau"),
    "simulate, auto": lambda: lissom.simulate(ROD, 0.05, method="auto", rtol=1e-2),
    "simulate, controlled": lambda: lissom.simulate(
        lissom.Rod([WIRE], loads=[lissom.Load(force=lissom.Input("push", (0.0, 0.0, 0.1)))]),
        0.05,
        control=lambda t, q, v: [0.0, 0.0, t],
    ),
    "Simulation": lambda: stepped(lissom.Simulation(ROD, dt=1e-3)),
    "simulate, failed at once": lambda: lissom.simulate(ROD, 1.0, dt=1e-2, max_steps=0),
    "newmark": lambda: lissom.newmark(lambda t, q, v, a: a + q, (0.0, 1.0), [1.0], [0.0], dt=0.1),
    "Balance": lambda: lissom.simulate(ROD, 0.05).balance,
    "HardSteps": lambda: lissom.simulate(ROD, 0.05, method="radau").hard_steps,
    "Statistics": lambda: lissom.simulate(ROD, 0.05, method="auto", rtol=1e-2).stats,
    "solve_ivp": lambda: lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0, 2.0]),
    "solve_ivp, all": lambda: lissom.solve_ivp(
        lambda t, y: -y,
        (0.0, 1.0),
        [1.0, 2.0],
        dense_output=True,
        events=[lambda t, y: y[0] - 0.5, lambda t, y: 1.0],
    ),
    "solve_ivp, failed": lambda: lissom.solve_ivp(lambda t, y: -y, (0.0, 1.0), [1.0], max_steps=1),
    "root": lambda: lissom.root(lambda x: x**2 - 2.0, 1.0, history=True),
    "root of vectors": lambda: lissom.root(lambda x: x**2 - 2.0, [1.0, 2.0], history=True),
    "check_jacobian": lambda: lissom.check_jacobian(lambda x: x**2, lambda x: np.diag(2 * x), [1.0, 2.0]),
    "reach": lambda: ROD.reach("rod", [0.3, 0.0, -0.1]),
    "actuate": lambda: lissom.actuate(PULLED, (0.19, 0.0, 0.01)),
    "statics, slack": lambda: lissom.statics(PULLED, u=[-1.0]),
    "continuation of inputs": lambda: lissom.continuation(PULLED, inputs={"pull": (0.0, 2.0)}),
    "Target": lambda: lissom.Target("rod", np.eye(4)),
    "statics": lambda: lissom.statics(ROD),
    "statics, newton": lambda: lissom.statics(ROD, [0.1] * 3, method="newton"),
    "continuation": lambda: lissom.continuation(COLUMN),
    "EquilibriumPath": lambda: lissom.continuation(COLUMN).path,
    "CriticalPoint": lambda: lissom.continuation(COLUMN).path.critical_points[0],
    "modes": lambda: lissom.modes(ROD, [0.0] * 3),
    "modes, complex": lambda: lissom.modes(
        lissom.Rod([WIRE], supports=[lissom.Support(stiffness=1.0, damping=3.0)]), [0.0] * 3
    ),
    "Energy": lambda: ROD.energy([0.1] * 3, [0.2] * 3, t=0.0),
    "LinearModel": lambda: lissom.linearise(COLUMN, [0.0] * 3),
    "Scene": lambda: lissom.Scene.loads(TEXT, "wire.toml"),
    "SimulationSettings": lambda: lissom.Scene.loads(TEXT).simulation,
    "SceneProblem": lambda: problem_of("version = 1\nnothing = 1"),
    "DenseOutput": lambda: lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0, 2.0], dense_output=True).sol,
    "DenseOutput of DOP853": lambda: (
        lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0, 2.0], "dop853", dense_output=True).sol
    ),
    "DenseOutput of Radau": lambda: (
        lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0, 2.0], "radau", dense_output=True).sol
    ),
}
WAYS = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    **{
        f"pickle {protocol}": lambda x, protocol=protocol: pickle.loads(pickle.dumps(x, protocol))
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)
    },
}


def stepped(simulation):
    simulation.step(duration=5.5e-3)
    return simulation


def problem_of(text):
    with pytest.raises(lissom.SceneError) as caught:
        lissom.Scene.loads(text)
    return caught.value.problems[0]


def attributes(thing):
    """Public attributes that are not methods."""
    with warnings.catch_warnings():
        # Old names warn.
        warnings.simplefilter("ignore", FutureWarning)
        found = {name: getattr(thing, name) for name in dir(thing) if not name.startswith("_")}
    return {name: value for name, value in found.items() if not callable(value)}


def assert_same(one, other):
    """Compares type and attributes, bitwise."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    elif isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            assert_same(one[key], other[key])
    elif isinstance(one, list | tuple):
        assert len(one) == len(other)
        for left, right in zip(one, other, strict=True):
            assert_same(left, right)
    elif isinstance(one, float):
        assert one == other or (np.isnan(one) and np.isnan(other))
    elif isinstance(one, lissom.LinearModel):
        assert_same(vars(one), vars(other))
    elif type(one).__module__.startswith("lissom") and type(one).__eq__ is object.__eq__:
        assert str(one) == str(other)
        assert_same(attributes(one), attributes(other))
    else:
        assert one == other


def arrays(thing, seen=()):
    """All arrays within a result, with their places."""
    if isinstance(thing, np.ndarray):
        yield thing
    elif isinstance(thing, list | tuple):
        for item in thing:
            yield from arrays(item)
    elif isinstance(thing, dict):
        for item in thing.values():
            yield from arrays(item)
    elif type(thing).__module__.startswith("lissom") and not isinstance(thing, lissom.Model):
        yield from arrays(attributes(thing))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kind", RESULTS)
def test_results_survive_copies_and_pickles(kind, way):
    result = RESULTS[kind]()
    twin = WAYS[way](result)
    assert_same(twin, result)
    if isinstance(result, lissom.DenseOutput):
        times = np.linspace(-0.5, 1.5, 23)
        np.testing.assert_array_equal(twin(times), result(times))


@pytest.mark.parametrize("way", [None, *WAYS])
@pytest.mark.parametrize("kind", [kind for kind in RESULTS if kind != "LinearModel"])
def test_arrays_of_results_are_copies_or_read_only(kind, way):
    result = RESULTS[kind]()
    if way is not None:
        result = WAYS[way](result)
    before = [x.copy() for x in arrays(result)]
    for found in arrays(result):
        while isinstance(found, np.ndarray):
            if found.size and not found.flags.writeable:
                with pytest.raises(ValueError, match="read-only"):
                    found[...] = 7.0
            elif found.size:
                found[...] = 7.0
            found = found.base
    for one, other in zip(before, arrays(result), strict=True):
        np.testing.assert_array_equal(one, other)


def test_nobody_changes_a_balance_that_is_computed_later():
    result = lissom.simulate(ROD, 0.05)
    expected = lissom.simulate(ROD, 0.05).balance.total
    for name in ("t", "q", "v", "a"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(result, name)[-1] = 1.0
    np.testing.assert_array_equal(result.balance.total, expected)


@pytest.mark.parametrize("method", ["rk45", "newmark"])
def test_a_copied_result_still_computes_what_nobody_had_asked_for(method):
    result = lissom.simulate(ROD, 0.02, method=method)
    twin = pickle.loads(pickle.dumps(result))
    np.testing.assert_array_equal(twin.balance.total, result.balance.total)
    np.testing.assert_array_equal(twin.a, result.a)


def test_exceptions_keep_what_they_carry():
    with pytest.raises(lissom.SceneError) as refused:
        lissom.Scene.loads("version = 1\nnothing = 1", "a.toml")
    with pytest.raises(lissom.ConvergenceError) as failed:
        lissom.root(lambda x: x**2 + 1.0, 1.0, raise_on_failure=True)
    for error in (refused.value, failed.value):
        for way in WAYS.values():
            twin = way(error)
            assert type(twin) is type(error)
            assert str(twin) == str(error)
    twin = pickle.loads(pickle.dumps(refused.value))
    assert [str(problem) for problem in twin.problems] == [str(p) for p in refused.value.problems]
    assert pickle.loads(pickle.dumps(failed.value)).result.status == failed.value.result.status


@pytest.mark.filterwarnings("ignore::lissom.urdf.UrdfWarning")
@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_scenes_and_their_models_move_alike_after_a_pickle(path):
    scene = lissom.Scene.load(path)
    twin = pickle.loads(pickle.dumps(scene))
    assert (twin.name, twin.text, twin.simulation) == (scene.name, scene.text, scene.simulation)
    for model in (twin.model, pickle.loads(pickle.dumps(scene.model)), copy.deepcopy(scene.model)):
        q = np.linspace(0.1, 0.2, model.n)
        expected = scene.model.inverse_dynamics(q, -q, q[::-1], t=0.25)
        np.testing.assert_array_equal(model.inverse_dynamics(q, -q, q[::-1], t=0.25), expected)
        if isinstance(model, lissom.Rod):
            assert model.segments == scene.model.segments
            assert model.loads == scene.model.loads
        if isinstance(model, lissom.Robot):
            assert model.links == scene.model.links
    np.testing.assert_array_equal(twin.q0, scene.q0)
    np.testing.assert_array_equal(twin.v0, scene.v0)


def test_modes_that_a_scene_left_open_are_not_chosen_again():
    text = TEXT.replace("modes = { bend_y = 3 }", 'modes = "auto"').replace(
        "t_end = 0.05", 't_end = 0.05\nmethod = "auto"\nrtol = 1e-2'
    )
    scene = lissom.Scene.loads(text)
    twin = pickle.loads(pickle.dumps(scene))
    assert twin.model.segments == scene.model.segments
    assert len(twin.q0) == scene.model.n


def test_nonsense_is_not_restored():
    result = lissom.simulate(ROD, 0.05)
    restore, (states, flow, outcome, model, deepest, evaluations, hard) = result.__reduce__()
    assert deepest is None
    assert list(evaluations) == list(result.evaluations)
    # Records of older versions have no deepest overlap.
    assert restore(states, flow, outcome, model).deepest is None
    assert restore(states, flow, outcome, model, deepest).evaluations is None
    assert restore(states, flow, outcome, model, deepest, evaluations).hard_steps is None
    assert len(restore(states, flow, outcome, model, deepest, evaluations, hard).hard_steps) == 0
    with pytest.raises(ValueError, match="evaluations: got 2, expected one for each time"):
        restore(states, flow, outcome, model, deepest, [1, 2])
    t, q, v, u, a = states
    pendulum = lissom.SpringPendulum()
    wrong = [
        ((t[:-1], q, v, u, a), flow, outcome, model),
        ((t, q, v[:, :-1], u, a), flow, outcome, model),
        ((t, q, v, u, a[1:]), flow, outcome, model),
        ((t, "q", v, u, a), flow, outcome, model),
        ((t, q, v, u[1:], a), flow, outcome, model),
        ((t, q, v, q, a), flow, outcome, model),
        (states, ([0.0], flow[1]), outcome, model),
        (states, flow, outcome, pendulum),
        (states, flow, outcome, model, 0.1),
        (states, flow, outcome, model, deepest, evaluations, [0.1]),
    ]
    for arguments in wrong:
        with pytest.raises((ValueError, TypeError)):
            restore(*arguments)
    sol = lissom.solve_ivp(lambda t, y: -y, (0, 1), [1.0], dense_output=True).sol
    restore, (nested, vectors, n, times, end, coefficients) = sol.__reduce__()
    for arguments in (
        (nested, 0, n, times, end, coefficients),
        (nested, vectors, n, times[:1], end, coefficients[:0]),
        (nested, vectors, n, times, end, coefficients[1:]),
        (nested, 2**62, n, times, end, coefficients),
    ):
        with pytest.raises(ValueError, match=r"vectors|times|coefficients"):
            restore(*arguments)


def test_what_cannot_be_pickled_says_so():
    rod = lissom.Rod([WIRE], loads=[lissom.Load(force=lambda t: (0.0, 0.0, t))])
    for thing in (
        rod,
        rod.loads[0],
        lissom.simulate(rod, 0.02),
        lissom.BaseMotion(translation=lambda t: [t] * 3),
    ):
        with pytest.raises((pickle.PicklingError, AttributeError), match="lambda"):
            pickle.dumps(thing)
        copy.copy(thing)
        copy.deepcopy(thing)
    with pytest.raises(TypeError, match=r"cannot pickle 'lissom.RK45'|cannot pickle 'RK45'"):
        pickle.dumps(lissom.RK45(decay, 0.0, [1.0], 1.0))


def run(stiffness):
    rod = lissom.Rod([WIRE], loads=ROD.loads, tip_mass=stiffness)
    return lissom.simulate(rod, 0.05)


def run_scene(scene):
    if scene is None:
        return lissom.Scene.loads("version = 2")
    return scene.run()


def test_process_pools_work():
    masses = [0.0, 0.01, 0.02]
    context = multiprocessing.get_context("spawn")
    scene = lissom.Scene.loads(TEXT)
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        found = list(pool.map(run, masses))
        moved = pool.submit(run_scene, scene).result()
        refused = pool.submit(run_scene, None).exception()
    for mass, result in zip(masses, found, strict=True):
        np.testing.assert_array_equal(result.q, run(mass).q)
        assert result.model.tip_mass == mass
    np.testing.assert_array_equal(moved.q, scene.run().q)
    assert isinstance(refused, lissom.SceneError)
    assert refused.problems


def test_pickles_name_the_package_whatever_moves_in_it():
    public = {name: getattr(lissom, name) for name in lissom.__all__}
    homes = {name: kind.__module__ for name, kind in public.items() if isinstance(kind, type)}
    assert {name: home for name, home in homes.items() if home not in ("lissom", "lissom._lissom")} == {}


def test_pickles_that_name_modules_which_moved_are_read():
    """Written when `Target` was in `lissom.targets`, parameters in `lissom.parameters`, and so on."""
    found = pickle.loads(MOVED.read_bytes())
    for name, thing in found.items():
        assert type(thing) is getattr(lissom, name), name
    assert found["Target"] == lissom.Target("rod", [0.3, 0.0, -0.1])
    rod = lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000, {"bend_y": 2})])
    names = ["q0", "segments[0].young_modulus", "gravity[2]", "segments[0].length"]
    again = lissom.sensitivity(rod, 0.02, names)
    np.testing.assert_allclose(found["SensitivityResult"].dq, again.dq, rtol=1e-9, atol=1e-12)
    # Lengths move places directly, which the parameters of the result say.
    np.testing.assert_allclose(
        found["SensitivityResult"].position()[1], again.position()[1], rtol=1e-9, atol=1e-12
    )
    assert found["ContactEvent"].kind == "touch"
    assert found["LinearModel"].A.shape == (4, 4)


def test_modules_have_their_old_names_without_a_copy():
    assert sorted(lissom._MOVED) == [
        *("contact_events", "contacts", "equilibria", "fits", "keeping", "linear", "live", "materials"),
        *("measurements", "parameters", "report", "sensitivities", "sweeps", "targets"),
    ]
    for old, new in lissom._MOVED.items():
        assert importlib.import_module(f"lissom.{old}") is importlib.import_module(f"lissom.{new}")
        assert getattr(lissom, old) is sys.modules[f"lissom.{new}"]
    old, new = (importlib.import_module(f"lissom.{name}.scene") for name in ("report", "drawing.report"))
    assert old is new
    with pytest.raises(ModuleNotFoundError, match=r"lissom\.nothing"):
        importlib.import_module("lissom.nothing")
