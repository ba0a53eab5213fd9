"""Measures of the source: lines, methods of traits, files that know an effect, large files, circles of files.

python benches/python/house.py       # or `make measure-house`
"""

import ast
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests" / "python" / "project"))

#: Traits whose methods every implementation must know, by the file that defines them.
TRAITS = {
    "model": "src/core/model",
    "second-order systems": "src/integrators/second_order/system.rs",
    "effects": "src/core/robot/effects/kinds.rs",
}
#: Effects, and the words by which files know them.
EFFECTS = {
    "fluid": r"fluid|immersion|immersed",
    "contact": r"contact",
    "tendons": r"tendon|routing_segment|guide_exit",
    "supports": r"support|anchor",
}
LARGE_FILE, LARGE_FUNCTION, SHOWN = 800, 80, 8


def files(*folders: str, suffix: str) -> list[Path]:
    found = (path for folder in folders for path in sorted((ROOT / folder).rglob(f"*{suffix}")))
    return [path for path in found if "target" not in path.parts]


def lines(path: Path) -> int:
    return path.read_text(encoding="utf-8").count("\n")


def methods(path: Path) -> list[tuple[int, int]]:
    """Functions declared in each trait of a file or folder, and those of them that have a default."""
    text = "".join(file.read_text(encoding="utf-8") for file in sorted(path.rglob("*.rs")) or [path])
    traits = re.findall(r"^pub(?:\([^)]*\))? trait [^{]*\{\n(.*?)^\}", text, re.MULTILINE | re.DOTALL)
    declared = (re.findall(r"^    fn (?:[^{;]|; \d)*[{;]", trait, re.MULTILINE) for trait in traits)
    return [(len(heads), sum(head.endswith("{") for head in heads)) for heads in declared]


def functions(path: Path) -> list[int]:
    """Lines of each function, from its head to the brace that closes it."""
    text = path.read_text(encoding="utf-8").split("#[cfg(test)]\nmod tests")[0]
    # A declaration in a trait ends with a semicolon, as do sizes of arrays.
    heads = r"^( *)(?:pub(?:\([^)]*\))? )?(?:const )?fn (?:[^{;]|; [\w:]+\])*\{(?:[^\n]*\}$|.*?^\1\})"
    return [head.group().count("\n") + 1 for head in re.finditer(heads, text, re.MULTILINE | re.DOTALL)]


def python_functions(path: Path) -> list[int]:
    """Lines of each function without its docstring."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[1] if ast.get_docstring(node) and len(node.body) > 1 else node.body[0]
            found.append(node.body[0].lineno - node.lineno + (node.end_lineno or 0) - first.lineno + 1)
    return found


def main() -> None:
    rust, python = files("src", suffix=".rs"), files("python", suffix=".py")
    tests = [*files("tests", suffix=".py"), *files("tests", suffix=".rs")]
    for name, group in (("Rust", rust), ("Python package", python), ("tests", tests)):
        print(f"{name:<38} {sum(map(lines, group)):>7} lines in {len(group)} files")
    for name, place in TRAITS.items():
        traits = methods(ROOT / place)
        total, defaults = (sum(column) for column in zip(*traits, strict=True))
        most = max(number for number, _ in traits)
        print(f"{'methods of traits of ' + name:<38} {total:>7}, {defaults} with a default, {most} in one")
    for effect, words in EFFECTS.items():
        know = [
            path
            for path in [*rust, *python]
            if re.search(words, path.read_text(encoding="utf-8"), re.IGNORECASE)
        ]
        print(f"{'files that know ' + effect:<38} {len(know):>7}")
    for folder in ("src", "src/core"):
        print(f"{'entries of ' + folder:<38} {len(list((ROOT / folder).iterdir())):>7}")
    print(f"{'entries of python/lissom':<38} {len(list((ROOT / 'python' / 'lissom').glob('[a-z]*'))):>7}")
    folder, number = Counter(path.parent for path in tests).most_common(1)[0]
    print(f"{'files in ' + str(folder.relative_to(ROOT)):<38} {number:>7}")
    large = sorted((path for path in [*rust, *python] if lines(path) > LARGE_FILE), key=lines, reverse=True)
    print(f"{f'files above {LARGE_FILE} lines':<38} {len(large):>7}")
    for path in large[:SHOWN]:
        print(f"    {lines(path):>6} {path.relative_to(ROOT)}")
    for language, lengths in (("Rust", map(functions, rust)), ("Python", map(python_functions, python))):
        long = [length for of_file in lengths for length in of_file if length > LARGE_FUNCTION]
        name = f"functions of {language} above {LARGE_FUNCTION} lines"
        print(f"{name:<38} {len(long):>7}, the longest {max(long, default=0)}")
    from test_rooms import House, modules

    circles = [circle for circle in House(modules()).circles() if len(circle) > 1]
    print(f"{'circles of files':<38} {len(circles):>7}")
    for circle in circles:
        print("    " + ", ".join("/".join(module) for module in circle))


if __name__ == "__main__":
    main()
