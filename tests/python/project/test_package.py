"""The installed package as a whole."""

import re
import subprocess
import tomllib
from importlib.metadata import requires, version
from pathlib import Path

import yaml

import lissom

ROOT = Path(__file__).parents[3]
CARGO = tomllib.loads((ROOT / "Cargo.toml").read_text())
PYTHON = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
# Heading of a release in the changelog.
HEADING = re.compile(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d{2}-\d{2})$", re.M)


def recipe() -> dict:
    """The conda-forge recipe in the packaging documentation."""
    (text,) = re.findall(r"```yaml\n(.*?)```", (ROOT / "docs/packaging.md").read_text(), re.S)
    return yaml.safe_load(text)


def test_everything_that_shows_a_version_agrees():
    shown = CARGO["workspace"]["package"]["version"]
    locked = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    releases = HEADING.findall((ROOT / "CHANGELOG.md").read_text())
    assert lissom.__version__ == shown
    for name in ("lissom", "lissom-core", "lissom-derive"):
        assert [package["version"] for package in locked if package["name"] == name] == [shown]
    for name, folder in (("lissom-core", "src/core"), ("lissom-derive", "derive")):
        assert CARGO["workspace"]["dependencies"][name] == {"path": folder, "version": f"={shown}"}
    assert releases[0] == (citation["version"], str(citation["date-released"]))
    assert citation["version"] == shown
    assert recipe()["context"]["version"] == shown
    assert f"lissom-{shown}.tar.gz" in recipe()["source"]["url"]


def test_the_changelog_has_releases_newest_first_and_notes_for_each():
    text = (ROOT / "CHANGELOG.md").read_text()
    headings = re.findall(r"^## .*$", text, re.M)
    releases = HEADING.findall(text)
    assert headings[0] == "## [Unreleased]"
    assert len(releases) == len(headings) - 1
    assert [date for _, date in releases] == sorted((date for _, date in releases), reverse=True)
    for release, _ in releases:
        notes = subprocess.run(
            [ROOT / ".ci/release-notes", release], capture_output=True, text=True, check=True
        )
        assert "\n- " in notes.stdout
        assert not re.search(r"^## ", notes.stdout, re.M)
    assert subprocess.run([ROOT / ".ci/release-notes", "0.0.0"], check=False).returncode == 1


def test_the_recipe_needs_what_the_package_needs():
    needed = {re.sub(r"(?=[<>=])", " ", line, count=1) for line in PYTHON["dependencies"]}
    assert set(recipe()["requirements"]["run"]) == needed | {"python"}
    (script,) = recipe()["build"]["python"]["entry_points"]
    assert script == "lissom = " + PYTHON["scripts"]["lissom"]
    assert recipe()["about"]["license"] == PYTHON["license"] == CARGO["workspace"]["package"]["license"]


def test_the_oldest_rust_is_the_same_everywhere():
    oldest = CARGO["workspace"]["package"]["rust-version"]
    assert f"Rust {oldest}," in (ROOT / "CHANGELOG.md").read_text()
    packaging = (ROOT / "docs/packaging.md").read_text()
    assert f"| Rust | {oldest} |" in packaging
    assert f"rustup toolchain install {oldest}`" in packaging


def test_the_crate_has_sources_and_tests_only():
    command = ["cargo", "package", "--list", "--package", "lissom", "--allow-dirty", "--offline"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
    documents = {"CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "SECURITY.md"}
    manifests = {
        ".cargo_vcs_info.json",
        "Cargo.lock",
        "Cargo.toml",
        "Cargo.toml.orig",
        "pyproject.toml",
    }
    folders = {"src", "tests", "benches", "examples"}
    assert {path.split("/")[0] for path in listed} == documents | manifests | folders
    assert not [path for path in listed if path.endswith((".py", ".pyc", ".so"))]


def test_the_version_is_that_of_the_distribution():
    assert lissom.__version__ == version("lissom")


def test_only_three_packages_are_needed_at_run_time():
    unconditional = [line for line in requires("lissom") or [] if "extra ==" not in line]
    assert {re.match(r"[\w-]+", line)[0] for line in unconditional} == {"numpy", "click", "tqdm"}


def test_the_extra_all_has_what_fit_needs():
    extras = PYTHON["optional-dependencies"]
    assert any(need.startswith("scipy") for need in extras["fit"])
    (everything,) = extras["all"]
    named = set(everything.removeprefix("lissom[").removesuffix("]").split(","))
    assert named == extras.keys() - {"all", "jax", "torch", "learning", "usd", "cosseratbench"}
