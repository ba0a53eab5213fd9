"""The examples of the documentation work as shown."""

import doctest
import re
from pathlib import Path

import pytest

import lissom
from lissom import gym, sensors

ROOT = Path(__file__).parents[3]
PAGES = sorted(ROOT.glob("docs/**/*.md"))
PAGES_WITH_EXAMPLES = [page for page in PAGES if ">>>" in page.read_text()]
PUBLIC = {name: getattr(lissom, name) for name in lissom.__all__} | {
    f"{short}.{name}": getattr(module, name)
    for short, module in (("gym", gym), ("sensors", sensors))
    for name in module.__all__
}
DOCUMENTED = [name for name, value in PUBLIC.items() if ">>>" in (value.__doc__ or "")]


@pytest.mark.parametrize("page", PAGES_WITH_EXAMPLES, ids=lambda page: str(page.relative_to(ROOT)))
def test_examples_of_a_page(page):
    assert doctest.testfile(str(page), module_relative=False).failed == 0


@pytest.mark.parametrize("name", DOCUMENTED)
def test_examples_of_a_docstring(name):
    example = doctest.DocTestParser().get_doctest(PUBLIC[name].__doc__, {}, name, None, None)
    assert doctest.DocTestRunner().run(example).failed == 0


def test_there_are_examples():
    assert {"ode.md", "rod.md", "roots.md"} <= {page.name for page in PAGES_WITH_EXAMPLES}
    assert {"root", "solve_ivp", "sensors.Imu"} <= set(DOCUMENTED)


@pytest.mark.parametrize(
    "page",
    [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *PAGES],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text()):
        assert (page.parent / target).exists(), target


#: English that readers stumble over, and what to write instead.
STUMBLES = {
    r"\d ?(?:µs|ms|s|%)? an? (?:step|call|second|minute|point|inch|row|segment|strain|turn|run)\b": "per",
    r"\b(?:iterations|evaluations|residuals|modes|nodes|numbers|frames) an? "
    r"(?:step|call|second|segment|strain|turn|row)\b": "per",
    r"\bsome (?:\d|ten\b|tens\b|hundred|thousand|microseconds|seconds|minutes)": "about, a few",
    r"\[[\w/.-]+\.md\]\(": "words as the text of a link",
    r"\b(?:hangs? on|takes? over|stands? before|dearer|jolted|flawed|sunken)\b": "a word of the field",
    r"\b(?:is|are|be) told\b|\btells? (?:apart|how|what|which)\b": "report, distinguish, determine",
}
#: Written by commands, from texts elsewhere.
WRITTEN = {"work_precision.md", "validation.md", "gallery.md", "benchmarks.md", "peers.md"}


@pytest.mark.parametrize(
    "page",
    [ROOT / "README.md", *(page for page in PAGES if page.name not in WRITTEN)],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_pages_are_easy_to_read(page):
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.S)
    found = [
        f"{match[0]!r}: write {better}"
        for pattern, better in STUMBLES.items()
        for match in re.finditer(pattern, text)
    ]
    assert found == []
