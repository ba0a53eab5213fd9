"""What the package and the commands import: what is not used is not imported.

Every module costs time at each start. The tests compare names of modules, not times, to hold on any machine.
"""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import lissom

ROOT = Path(__file__).parents[3]
SCENE = ROOT / "scenes" / "lab-horizontal.toml"

#: Packages that take long to import, and modules of Python with which they begin.
HEAVY = {
    *("xarray", "pandas", "dask", "distributed", "zarr", "scipy", "matplotlib", "viser", "gymnasium"),
    *("jax", "torch", "numba", "tqdm", "asyncio", "concurrent", "multiprocessing", "email", "tempfile"),
    *("h5netcdf", "secrets", "importlib.metadata", "importlib.resources", "numpy.ma", "numpy.random"),
}
#: What only the commands that draw, write or differentiate need.
OF_OTHERS = {
    *(
        f"lissom.analysis.{name}"
        for name in (
            "equilibria",
            "fits",
            "linear",
            "materials",
            "measurements",
            "parameters",
            "sensitivities",
        )
    ),
    *(f"lissom.results.{name}" for name in ("io", "records", "studies")),
    *(f"lissom.{name}" for name in ("analysis.sweeps", "model.targets", "urdf", "gym", "sensors")),
    *(f"lissom.{name}" for name in ("drawing.pictures", "drawing.live", "cli.evidence")),
}
OF_DRAWINGS = {
    *("lissom.model.glyphs", "lissom.drawing.report"),
    *("h5py", "hashlib"),
}


def loaded(program, *arguments, cwd):
    """The modules that are loaded at the end of a program in a new process."""
    end = "import atexit, json, sys\n"
    end += "atexit.register(lambda: open('modules', 'w').write(json.dumps(sorted(sys.modules))))\n"
    command = [sys.executable, "-c", end + program, *map(str, arguments)]
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return set(json.loads((cwd / "modules").read_text()))


def command(*arguments, cwd):
    return loaded("from lissom.__main__ import main; main()", *arguments, cwd=cwd)


def of_package(modules):
    return {name for name in modules if name.partition(".")[0] == "lissom"}


def test_the_package_imports_nothing(tmp_path):
    found = loaded("import lissom", cwd=tmp_path)
    assert of_package(found) == {"lissom"}
    assert found & (HEAVY | {"numpy", "click", "dataclasses", "typing"}) == set()


@pytest.mark.parametrize(
    "name", ["Rod", "Robot", "Scene", "simulate", "statics", "solve_ivp", "MotionResult"]
)
def test_what_is_compiled_imports_no_other_module(name, tmp_path):
    found = loaded(f"import lissom; lissom.{name}", cwd=tmp_path)
    assert of_package(found) == {
        "lissom",
        *(
            f"lissom.{m}"
            for m in (
                "_lissom",
                "attached",
                "attached.missing",
                "attached.models",
                "attached.texts",
                "common",
                "common.arguments",
            )
        ),
        *(f"lissom.{m}" for m in ("analysis", "analysis.base")),
    }
    assert found & HEAVY == set()


def test_a_simulation_in_python_imports_no_drawings(tmp_path):
    program = "import lissom\n"
    program += "rod = lissom.Rod([lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000, {'bend_y': 2})])\n"
    program += "lissom.simulate(rod, 0.01, dt=0.01), lissom.statics(rod)\n"
    found = loaded(program, cwd=tmp_path)
    assert found & (HEAVY - {"numpy.ma"} | OF_OTHERS | OF_DRAWINGS) == set()


def test_help_and_listed_commands_import_neither_numpy_nor_the_compiled_module(tmp_path):
    for arguments in (["--help"], ["run", "--help"], ["check", "--help"]):
        found = command(*arguments, cwd=tmp_path)
        assert found & (HEAVY | OF_OTHERS | OF_DRAWINGS | {"numpy", "lissom._lissom"}) == set()
    commands = {name for name in found if name.startswith("lissom.cli.")}
    assert commands == {"lissom.cli.check", "lissom.cli.exits", "lissom.cli.scenes"}


@pytest.mark.parametrize(("given", "found"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "3"}, "3")])
def test_commands_start_no_threads_of_openblas_unless_they_are_asked_to(given, found, tmp_path):
    program = f"import os\nos.environ.pop('OPENBLAS_NUM_THREADS', None); os.environ.update({given!r})\n"
    program += "from lissom.__main__ import main\ntry:\n    main()\nfinally:\n"
    program += f"    assert os.environ['OPENBLAS_NUM_THREADS'] == {found!r}\n"
    loaded(program, "--version", cwd=tmp_path)


def test_commands_search_for_no_garbage_while_they_import(tmp_path):
    """Which takes a twentieth of a check."""
    program = "import atexit, gc, os, sys\n"
    program += "searches = lambda: sum(each['collections'] for each in gc.get_stats())\n"
    program += "atexit.register(lambda before: searches() < before + 5 or os._exit(9), searches())\n"
    program += "from lissom.__main__ import main; main()"
    loaded(program, "check", SCENE, cwd=tmp_path)


def test_the_version_needs_the_compiled_module_alone(tmp_path):
    found = command("--version", cwd=tmp_path)
    assert found & (HEAVY | OF_OTHERS | OF_DRAWINGS) == set()


def test_a_check_imports_no_drawings_and_no_other_commands(tmp_path):
    found = command("check", SCENE, cwd=tmp_path)
    others = {"lissom.cli.run", "lissom.results.folders", "lissom.results.files", "difflib", "shutil"}
    assert found & (HEAVY | OF_OTHERS | OF_DRAWINGS | others) == set()


@pytest.mark.parametrize("options", [["--no-report"], []], ids=["no-report", "report"])
def test_a_run_imports_neither_xarray_nor_other_studies(options, tmp_path):
    found = command("run", SCENE, *options, "-o", "out", cwd=tmp_path)
    assert (tmp_path / "out" / "trajectory.nc").exists()
    assert {"h5py", "lissom.model.views"} <= found
    other_reports = {
        f"lissom.drawing.report.{name}" for name in ("ensembles", "parameters", "studies", "sweeps")
    }
    assert found & (HEAVY | OF_OTHERS | other_reports) == set()


def test_public_names_are_imported_alike_for_types_and_at_run_time():
    """Type checkers read imports; Python reads a table."""
    tree = ast.parse((ROOT / "python/lissom/__init__.py").read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    typed = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    submodules = {name for name, module in typed.items() if module is None}
    assert {name: module for name, module in typed.items() if module} == lissom._MODULES
    assert all(
        alias.asname == alias.name
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    )
    assert set(lissom.__all__) == lissom._MODULES.keys() <= set(dir(lissom))
    for name in lissom.__all__:
        assert getattr(lissom, name) is getattr(sys.modules[f"lissom.{lissom._MODULES[name]}"], name)
    assert submodules == {"gym", "jax", "methods", "sensors", "torch", "urdf"}
    assert lissom.urdf is sys.modules["lissom.urdf"]
    with pytest.raises(AttributeError, match="module 'lissom' has no attribute 'rod'"):
        lissom.rod  # noqa: B018


def test_results_have_their_methods_whatever_is_imported_first(tmp_path):
    loaded("import lissom; assert lissom.MotionResult.save and lissom.FitResult.save", cwd=tmp_path)
    loaded("from lissom import StaticsResult; assert StaticsResult.plot", cwd=tmp_path)
    loaded("from lissom import *; assert Rod and EnsembleResult.report", cwd=tmp_path)
