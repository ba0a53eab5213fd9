"""Tables and plots of the benchmark suite, and the sections of docs/benchmarks.md that contain them."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

#: The goal for the distance to the limit.
LIMIT_GOAL = 4.0

#: Published by the authors of CROSP, a C++ library, on another machine: seconds by number of coordinates.
CROSP_RESIDUAL = {18: 0.28e-3}
CROSP_TANGENT = {18: 5.4e-3}

Row = Mapping[str, Any]


def time(seconds: float | None) -> str:
    """A time with three digits in a suitable unit; a dash for None."""
    if seconds is None:
        return "–"
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def table(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def order(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Exponent p of time ~ size^p, by least squares in logarithms."""
    x, y = ([math.log(value) for value in values] for values in (sizes, times))
    x_mean, y_mean = sum(x) / len(x), sum(y) / len(y)
    spread = sum((a - x_mean) ** 2 for a in x)
    return sum((a - x_mean) * (b - y_mean) for a, b in zip(x, y, strict=True)) / spread


def lab(data: Row) -> str:
    rows = [
        (
            row["case"],
            "never ends" if row["report"] is None else f"{row['report']:.4g} s",
            time(row["seconds"]),
            row["end"],
        )
        for row in data["rows"]
    ]
    return table(("", "the lab's report", "lissom", ""), rows)


def kernels(data: Row) -> str:
    rows = []
    for row in data["rows"]:
        cells = [time(row[kind]) for kind in ("residual", "forward", "tangent", "step")]
        numpy = [time(row["numpy"].get(kind)) for kind in ("residual", "forward")]
        published = [time(figures.get(row["coordinates"])) for figures in (CROSP_RESIDUAL, CROSP_TANGENT)]
        rows.append((row["rod"], row["coordinates"], *cells, *numpy, *published))
    columns = (
        "rod",
        "coordinates",
        "inverse dynamics",
        "forward dynamics",
        "tangent",
        "Newmark step",
        "NumPy reference, inverse",
        "NumPy reference, forward",
        "CROSP, inverse*",
        "CROSP, Jacobian*",
    )
    return table(columns, rows)


#: Measured quantities for growing rods; the last one for segments only.
GROWING = {
    "residual": "inverse dynamics",
    "tangent": "tangent",
    "step": "Newmark step",
    "dense_step": "Newmark step with dense solves",
}


def scaling(data: Row) -> str:
    parts = []
    for kind, rows in data["rows"].items():
        names = {key: name for key, name in GROWING.items() if key in rows[0]}
        cells = [(row[kind], row["coordinates"], *(time(row[key]) for key in names)) for row in rows]
        # Fitted over the larger half of the sizes.
        large = rows[len(rows) // 2 :]
        sizes = [row[kind] for row in large]
        orders = [f"{name} {order(sizes, [row[key] for row in large]):.2f}" for key, name in names.items()]
        found = table((kind, "coordinates", *names.values()), cells)
        parts.append(f"{found}\n\nExponent of the growth over the larger half of these: {', '.join(orders)}.")
    return "\n\n".join(parts)


def limit(data: Row) -> str:
    rows = []
    for row in data["rows"]:
        for kind, name in (
            ("residual", "inverse dynamics"),
            ("tangent", "tangent"),
            ("step", "Newmark step"),
        ):
            products, seconds = row["products"][kind], row["seconds"][kind]
            least = products / data["products_per_second"]
            ratio = seconds / least
            reached = "reached" if ratio <= LIMIT_GOAL else "not reached"
            rows.append(
                (row["rod"], name, f"{products:,.0f}", time(least), time(seconds), f"{ratio:.1f}", reached)
            )
    columns = ("rod", "", "multiplications", "limit", "measured", "measured / limit", f"goal: {LIMIT_GOAL:g}")
    widths = " and ".join(f"{1e-9 * rate:.1f} by {width}" for width, rate in data["rates"].items())
    rate = (
        f"This machine multiplies and adds {1e-9 * data['products_per_second']:.1f} doubles a nanosecond at "
        f"most ({widths} in one register; lissom computes with registers of 4)."
    )
    return f"{rate}\n\n{table(columns, rows)}"


def with_section(page: str, name: str, text: str) -> str:
    """The page with the text between the marks ``<!-- name -->`` and ``<!-- /name -->``.

    Raises
    ------
    ValueError
        If the page does not contain these marks, once and in this order.
    """
    start, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    found = re.findall(f"{re.escape(start)}.*?{re.escape(end)}", page, re.DOTALL)
    if len(found) != 1 or page.count(start) != 1 or page.count(end) != 1:
        raise ValueError(f"expected {start} and then {end}, each once")
    return page.replace(found[0], f"{start}\n{text.strip()}\n{end}")


def section(text: str, data: Row) -> str:
    """A table below the description of the machine."""
    return f"{data['machine']}; `{data['command']}`.\n\n{text}"


def plot(parts: Mapping[str, Row], path: Path) -> None:
    """Plots the kernels with the machine's limit, and the scaling."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(16, 4.8))
    for color, (kind, name) in enumerate(GROWING.items()):
        style = {"color": f"C{color}"}
        if "limit" in parts and kind in parts["limit"]["rows"][0]["products"]:
            rows = parts["limit"]["rows"]
            sizes = [row["coordinates"] for row in rows]
            rate = parts["limit"]["products_per_second"]
            axes[0].loglog(sizes, [row["seconds"][kind] for row in rows], "o-", label=name, **style)
            least = [row["products"][kind] / rate for row in rows]
            axes[0].loglog(sizes, least, ":", label=f"{name}, limit", **style)
        if "scaling" in parts:
            for axis, (size, rows) in zip(axes[1:], parts["scaling"]["rows"].items(), strict=True):
                if kind in rows[0]:
                    times = [row[kind] for row in rows]
                    axis.loglog([row[size] for row in rows], times, "o-", label=name, **style)
                axis.set(xlabel=size, ylabel="seconds")
    axes[0].set(title="Kernels, and what the machine allows", xlabel="coordinates", ylabel="seconds")
    axes[1].set_title("One metre in many segments, three coordinates each")
    axes[2].set_title("One segment, many modes of torsion and both bends")
    for axis in axes:
        axis.grid(alpha=0.3)
        if axis.lines:
            sizes = axis.lines[0].get_xdata()
            axis.set_xticks(sizes, [f"{size:g}" for size in sizes])
            axis.minorticks_off()
            axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
