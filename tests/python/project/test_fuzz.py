"""Fuzzing for some seconds; and tests that the fuzzer detects planted faults."""

import copy
import tomllib

import numpy as np
import pytest

import lissom
from fuzz import (
    api,
    damage,
    endings,
    files,
    judge,
    minimise,
    mutate,
    pages,
    pool,
    questions,
    rendered,
    robots,
    scenes,
    solvers,
    stores,
    transforms,
    values,
)
from fuzz.__main__ import Findings, found_before, known_faults, random_case

# Some seconds on an idle machine.
pytestmark = pytest.mark.timeout(600)

#: Random cases of each harness.
SOME = {
    "scenes": 15,
    "api": 200,
    "solvers": 20,
    "robots": 80,
    "files": 60,
    "stores": 3,
    "endings": 1,
    "pages": 4,
}
BY_NAME = {harness.NAME: harness for harness in (scenes, api, solvers, robots, files, stores, endings, pages)}


def findings_of(harness, some):
    """Faults of cases by signature, except known and open ones."""
    found = Findings(None)
    pool.run_all(harness, some, 1, judge.LIMIT, found.of(harness))
    return {signature: fault.outcome.detail for signature, fault in found.faults.items()}


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_NAME)
def test_random_cases_find_nothing_new(name):
    found = findings_of(BY_NAME[name], (random_case(BY_NAME[name], 0, k) for k in range(SOME[name])))
    assert {signature: found[signature] for signature in found.keys() - known_faults()} == {}


@pytest.mark.slow
def test_of_what_was_found_only_what_is_called_open_is_still_there():
    found = set()
    for harness in BY_NAME.values():
        found |= findings_of(harness, found_before(harness)).keys()
    assert found - known_faults() == set(), "found before, mended, and there again"
    assert known_faults() - found == set(), "mended: leave them out of corpus/open.txt"


def test_every_public_callable_is_tried():
    names = {name.partition(".")[0] for name in api.FUNCTIONS}
    assert names == {name for name in lissom.__all__ if callable(getattr(lissom, name))} | set(api.MODULES)
    assert set(api.RECIPES) == set(api.FUNCTIONS)
    for name, recipes in api.RECIPES.items():
        for recipe in recipes if isinstance(recipes, list) else [recipes]:
            assert set(recipe) - {"self"} <= set(api.FUNCTIONS[name].parameters), name


@pytest.mark.slow
def test_recipes_work_and_results_can_be_copied():
    with pool.Worker(judge.LIMIT) as worker:
        outcomes = {name: worker.run(api, text, ".py") for name, text in api.protocols().items()}
    assert {
        name: outcome.detail
        for name, outcome in outcomes.items()
        if outcome.verdict != "done" and outcome.signature not in known_faults()
    } == {}


@pytest.mark.slow
def test_scenes_of_the_corpus_run_and_set_every_key():
    names = {id(node): name for name, node in scenes.SCHEMA.root["definitions"].items()}
    unset = {
        (name, key)
        for name, node in scenes.SCHEMA.root["definitions"].items()
        for key in node.get("properties", ())
        # A case is one file.
        if name != "ArrayInFile"
    }
    with pool.Worker(judge.LIMIT) as worker:
        for path in sorted(scenes.CORPUS.iterdir()):
            for table, node in scenes.SCHEMA.tables(tomllib.loads(path.read_text())):
                unset -= {(names.get(id(node)), key) for key in table}
            outcome = worker.run(scenes, path.read_bytes(), ".toml")
            assert outcome.verdict == "done", (path.name, outcome)
    assert unset == set()


#: Processor time of a planted case, seconds.
LIMIT = 2.0

PLANTED = {
    "crash": "import os\ndef call():\n    os.abort()\n",
    "hang": "import signal as s\ndef call():\n    s.signal(s.SIGINT, s.SIG_IGN)\n    while True: pass\n",
    "memory": "import numpy as np\ndef call():\n    return np.ones(80_000_000)[:1]\n",
    "exception": "def call():\n    return {}['missing']\n",
    "panic": "def call():\n    raise type('PanicException', (BaseException,), {})('index out of bounds')\n",
    "nan": "import numpy as np\ndef call():\n    return np.array([1.0, np.nan])\n",
    "silent": "forbidden = 'x: text'\ndef call():\n    return 1.0\n",
    "swallowed": "from fuzz import values\ndef call():\n    values.happened.append('error')\n",
    "message": "def call():\n    raise ValueError('wrong ' * 100_000)\n",
}


@pytest.fixture(scope="module")
def worker():
    """A worker for several tests, because its start takes a second."""
    with pool.Worker(LIMIT) as one:
        yield one


@pytest.mark.slow
@pytest.mark.parametrize("verdict", PLANTED)
def test_planted_faults_of_calls_are_found(verdict, worker):
    # Allocating memory takes time.
    worker.limit = 20.0 if verdict == "memory" else LIMIT
    assert worker.run(api, PLANTED[verdict].encode(), ".py").verdict == verdict
    assert worker.run(api, b"def call():\n    raise ValueError('x: got 1')\n", ".py").verdict == "refused"


def test_another_layout_with_another_result_is_found(worker):
    text = "layouts = True\ndef call(array=None):\n    return 1.0 if array else 2.0\n"
    assert worker.run(api, text.encode(), ".py").verdict == "silent"


def test_a_wrong_success_of_a_solver_is_found(monkeypatch):
    """A solver that solves other equations."""
    problem = {
        "fun": lambda t, y: -y,
        "t_span": (0.0, 1.0),
        "y0": [1.0],
        "method": "rk45",
        "rtol": 1e-6,
        "atol": 1e-9,
    }
    assert solvers._run_ivp(problem, "here").verdict == "done"
    right = lissom.solve_ivp
    monkeypatch.setattr(
        lissom, "solve_ivp", lambda fun, *a, **k: right(lambda t, y: 0.999 * fun(t, y), *a, **k)
    )
    assert solvers._run_ivp(problem, "here").verdict == "wrong"


def test_a_wrong_success_of_a_scene_is_found(monkeypatch):
    scene = lissom.Scene.load(scenes.CORPUS / "pendulum.toml")
    assert scenes.tighter(scene).verdict == "done"
    monkeypatch.setattr(scenes, "LOCAL_FACTOR", 1e-2)
    assert scenes.tighter(scene).verdict == "wrong"


#: A sagging rod on a spring hinge that carries a body.
SOFT = {"length": 0.3, "radius": 0.01, "young_modulus": 1e7, "poisson_ratio": 0.4, "density": 1000.0}
SAGGING = {
    "scene": {"gravity": [0.0, 1.0, -9.0]},
    "link": [
        {
            "name": "rod",
            "joint": {"type": "revolute", "axis": [0.0, 1.0, 0.2], "stiffness": 10.0},
            "rod": {"segment": [SOFT | {"modes": {"bend_y": 2, "bend_z": 1}}]},
            "q0": [0.1, 0.2, 0.3, -0.1],
            "v0": [0.3, 0.1, 0.2, 0.4],
        },
        {
            "name": "body",
            "parent": "rod",
            "body": {
                "mass": 0.1,
                "centre": [0.0, 0.01, 0.0],
                "inertia": [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]],
            },
        },
    ],
}


@pytest.mark.parametrize(
    ("ask", "what", "factor"),
    [
        ("balance", "mass", 1.01),
        ("frequencies", "inertia", 3.0),
        ("forces", "mass", 1.01),
        ("inertia", "inertia", 3.0),
        ("cut", "mass", 1.01),
    ],
)
def test_a_robot_other_than_that_of_its_recipe_is_found(ask, what, factor):
    other = copy.deepcopy(SAGGING)
    other["link"][1]["body"][what] = (np.array(other["link"][1]["body"][what]) * factor).tolist()
    right, wrong = (questions.Robot(SAGGING, {"ask": ask, "seed": 1}) for _ in range(2))
    wrong.model = rendered.by_api(other)
    assert questions.QUESTIONS[ask](right) is None
    assert "off by" in questions.QUESTIONS[ask](wrong).replace("out of balance by", "off by")


@pytest.mark.parametrize(("kind", "change"), [(k, c) for k, some in questions.CHANGES.items() for c in some])
def test_forces_are_the_same_in_other_words(kind, change):
    same = questions.Robot(SAGGING, {"change": [kind, change], "seed": 1})
    assert questions.same_forces(same) is None


def test_wrong_units_are_found(monkeypatch):
    monkeypatch.setitem(transforms.UNITS["body"], "mass", (0, 2, 0))
    assert questions.same_forces(questions.Robot(SAGGING, {"change": ["units", "in grams"], "seed": 1}))


def test_cases_depend_on_their_seed_alone():
    for harness in BY_NAME.values():
        texts = [random_case(harness, 3, number).text for number in range(20)]
        assert texts == [random_case(harness, 3, number).text for number in range(20)]
        assert len(set(texts)) > 15


def test_scenes_are_written_as_they_are_read():
    for tree in scenes.SEEDS:
        assert tomllib.loads(mutate.write(tree)) == tree


def test_layouts_keep_the_numbers():
    for name in values.LAYOUTS:
        for numbers in ([1.0, 2.0, 3.0], [[1.0, 2.0], [3.0, 4.0]], [2.0, 2.0]):
            assert values.difference(values.array(numbers, name), numbers) is None


def test_fewer_lines_keep_the_fault():
    text = b"\n".join(b"line %d" % number for number in range(32))
    assert minimise.fewer_lines(
        text, lambda less: b"line 7\n" in less + b"\n" and b"line 20" in less
    ).split() == [
        b"line",
        b"7",
        b"line",
        b"20",
    ]


def test_damage_is_what_its_lines_say():
    content = bytes(range(100))
    assert damage.damaged(content, []) == content
    assert damage.damaged(content, ["flip 500000 0 3"]) == content[:50] + bytes([50 ^ 8]) + content[51:]
    assert damage.damaged(content, ["cut 250000 0 0"]) == content[:25]
    assert damage.damaged(b"", ["flip 1 2 3", "delete 0 9 9", "cut 0 0 0"]) == b""
    assert len(damage.damaged(content, ["many 0 0 0"])) == 100 + damage.MANY


def test_a_loader_that_overlooks_damage_is_found(monkeypatch, tmp_path):
    monkeypatch.setattr(files.result_files, "_checksum", lambda content: b"00000000")
    content = files.saved(0, ".lissom")
    at = content.index(np.ascontiguousarray(files.results()[0].q).tobytes()) + 30
    case = f'{{"kind": "record", "number": 0, "seed": 0}}\nflip {-(-at * 10**6 // len(content))} 0 0'
    path = tmp_path / "x.case"
    path.write_text(case, encoding="utf-8")
    assert files.run(path, None).verdict == "silent"
    monkeypatch.undo()
    files.saved.cache_clear()
    assert files.run(path, None).verdict == "refused"


def test_another_page_is_not_answered():
    page, own = pages.view()
    head = {"kind": "request", "host": "evil.example", "origin": "http://evil.example"}
    assert pages._request(own, head) is None
    assert pages._request(own, head | {"host": "{own}", "origin": "http://{own}"}) is None
    page.stop()
    pages.view.cache_clear()
