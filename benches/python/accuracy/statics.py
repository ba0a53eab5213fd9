"""The estimated error of equilibria due to the finite number of modes, beside the true one.

    python benches/python/accuracy/statics.py [--markdown]

Truth is the same robot with every segment divided into many. `reached` is the largest true error of any
section, relative to the length; `estimate` that of `StaticsResult.space_error`, by default and with
`space_error=True`; the cost is that of the estimate relative to a search without it. Nothing is written.
"""

import statistics
import sys
import time
import warnings
from itertools import pairwise

import numpy as np

import lissom

YOUNG, SHEAR = 1e9, 4e8
RUNS = 7
SECTIONS = 21
HINGE = lissom.Revolute((0, 1, 0))


def bending(radius):
    return YOUNG * np.pi / 4 * radius**4


def segments(modes, parts, length=1.0, radius=0.01, density=1000.0, first=1.0, **more):
    """A rod in equal segments, or with a ratio of the first one's length to the last one's."""
    strains = modes if isinstance(modes, dict) else {"bend_y": modes}
    ends = np.linspace(0, 1, parts + 1) if first == 1.0 else 1 - np.geomspace(1, 1 / first, parts + 1)
    ends = (ends - ends[0]) / (ends[-1] - ends[0])
    base, tip = radius if isinstance(radius, tuple) else (radius, radius)
    found = []
    for start, end in pairwise(ends):
        sizes = tuple(base + (tip - base) * x for x in (start, end))
        size = sizes[0] if base == tip else sizes
        found.append(lissom.Segment(length * (end - start), size, YOUNG, SHEAR, density, strains, **more))
    return found


def cantilever(load):
    def build(modes, parts):
        force = (0, 0, -load * bending(0.01))
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), tip_force=force)

    return build


def cone(ratio, load):
    def build(modes, parts):
        rod = segments(
            modes, parts, radius=(0.02, 0.02 / ratio), first=50.0 if parts > 1 and ratio > 20 else 1.0
        )
        return lissom.Rod(rod, gravity=(0, 0, 0), tip_force=(0, 0, -load * bending(0.02)))

    return build


def heavy_cone(ratio, load):
    """A cone bent by its weight."""

    def build(modes, parts):
        density = load * bending(0.02) / (9.81 * np.pi * 0.02**2)
        graded = 50.0 if parts > 1 and ratio > 20 else 1.0
        return lissom.Rod(segments(modes, parts, radius=(0.02, 0.02 / ratio), density=density, first=graded))

    return build


def helix(turns):
    def build(modes, parts):
        strains = {"torsion": modes, "bend_y": modes, "bend_z": modes}
        moment = 2 * np.pi * turns * bending(0.005) * np.array([0.5, 0, 0.2])
        return lissom.Rod(segments(strains, parts, radius=0.005), gravity=(0, 0, 0), tip_moment=moment)

    return build


def heavy(load):
    def build(modes, parts):
        return lissom.Rod(segments(modes, parts, density=load * bending(0.01) / (9.81 * np.pi * 1e-4)))

    return build


def at(where, **what):
    def build(modes, parts):
        load = lissom.Load(
            at=where, **{key: np.multiply(value, bending(0.01)) for key, value in what.items()}
        )
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), loads=[load])

    return build


def column(part):
    def build(modes, parts):
        critical = np.pi**2 / 4 * bending(0.01)
        force = (-part * critical, 0, -0.02 * critical)
        return lissom.Rod(segments(modes, parts), gravity=(0, 0, 0), tip_force=force)

    return build


def stiff_insert(modes, parts):
    rod = []
    for length, young in ((0.4, 1e9), (0.1, 1e12), (0.5, 1e9)):
        share = max(1, round(parts / 3))
        for _ in range(share):
            rod.append(lissom.Segment(length / share, 0.01, young, 0.4 * young, 1000.0, {"bend_y": modes}))
    return lissom.Rod(rod, gravity=(0, 0, 0), tip_force=(0, 0, -5 * bending(0.01)))


def insert_in_segment(modes, parts):
    """A thick and short place within one segment."""

    def radius(X):
        return 0.01 * (1 + 2 * np.exp(-(((X - 0.45) / 0.12) ** 2)))

    ends = np.linspace(0, 1, parts + 1)
    rod = [
        lissom.Segment(
            end - start, lambda X, start=start: radius(start + X), YOUNG, SHEAR, 1000.0, {"bend_y": modes}
        )
        for start, end in pairwise(ends)
    ]
    return lissom.Rod(rod, gravity=(0, 0, 0), tip_force=(0, 0, -3 * bending(0.01)))


def link(modes, parts, name="rod", **more):
    return lissom.Link(name, rod=segments(modes, parts), **more)


def tendon(end, tension):
    def build(modes, parts):
        path = lissom.Along("rod", (0, 0.008), along=(0.0, end))
        actuator = lissom.Tendon("tendon", [path], tension=tension * bending(0.01) / 0.008)
        return lissom.Robot([link(modes, parts)], gravity=(0, 0, -9.81), actuators=[actuator])

    return build


def free_tendon(modes, parts):
    """A tendon that runs straight from the base to the tip."""
    path = [lissom.Via("rod", (0, 0, 0.02), at=0.0), lissom.Via("rod", (0, 0, 0.02), at=1.0)]
    actuator = lissom.Tendon("tendon", path, tension=2 * bending(0.01))
    return lissom.Robot([link(modes, parts)], gravity=(0, 0, -9.81), actuators=[actuator])


def chamber(end):
    def build(modes, parts):
        path = lissom.Along("rod", (0, 0.005), along=(0.0, end))
        actuator = lissom.Chamber("chamber", [path], area=2e-5, pressure=2 * bending(0.01) / (2e-5 * 0.005))
        return lissom.Robot([link(modes, parts)], gravity=(0, 0, -9.81), actuators=[actuator])

    return build


def on_plane(modes, parts):
    contact = lissom.Contact("rod", lissom.HalfSpace((0, 0, -0.05), (0, 0, 1)), stiffness=1e5)
    density = 30 * bending(0.01) / (9.81 * np.pi * 1e-4)
    rod = lissom.Link("rod", rod=segments(modes, parts, density=density))
    return lissom.Robot([rod], contacts=[contact])


def clamped(modes, parts):
    density = 50 * bending(0.01) / (9.81 * np.pi * 1e-4)
    rod = lissom.Link("rod", rod=segments(modes, parts, density=density))
    return lissom.Robot([rod], loops=[lissom.Loop(("rod",), (None, None, (0.8, 0, 0)), lissom.Weld())])


def pinned(sag, load):
    """A cable between two pins."""

    def build(modes, parts):
        density = load * bending(0.01) / (9.81 * np.pi * 1e-4)
        rod = lissom.Link("rod", joint=HINGE, rod=segments(modes, parts, density=density))
        return lissom.Robot([rod], loops=[lissom.Loop(("rod",), (None, None, (sag, 0, 0)), HINGE)])

    return build


def four_bar(modes, parts):
    spring = lissom.Revolute((0, 1, 0), stiffness=2.0, rest=-1.2)
    links = [
        lissom.Link("crank", joint=spring, rod=segments(modes, parts, length=0.3)),
        lissom.Link("coupler", parent="crank", joint=HINGE, rod=segments(modes, parts, length=0.6)),
        lissom.Link("rocker", parent="coupler", joint=HINGE, rod=segments(modes, parts, length=0.3)),
    ]
    return lissom.Robot(links, loops=[lissom.Loop(("rocker",), (None, None, (0.5, 0, 0)), HINGE)])


def tree(modes, parts):
    strains = {"torsion": modes, "bend_y": modes, "bend_z": modes}
    turned = [np.cos(0.5), 0, 0, np.sin(0.5)]
    links = [
        lissom.Link("trunk", rod=segments(strains, 2 * parts, density=4000.0)),
        lissom.Link(
            "left", parent="trunk", orientation=turned, rod=segments(strains, parts, 0.5, density=4000.0)
        ),
        lissom.Link("right", parent="trunk", at=0.4, orientation=turned, rod=segments(strains, parts, 0.7)),
    ]
    return lissom.Robot(links)


#: Names, robots by modes and parts of a segment, modes, and the parts that tell the truth.
CASES = [
    ("cantilever, P L2/EI = 1", cantilever(1.0), (1, 2, 3, 6), 12),
    ("cantilever, P L2/EI = 20", cantilever(20.0), (1, 2, 3, 4, 6), 12),
    ("cone 1:2", cone(2, 3.0), (2, 4, 6), 24),
    ("cone 1:10", cone(10, 0.05), (2, 4, 6, 10), 24),
    ("cone 1:100", cone(100, 3e-4), (4, 6, 10), 48),
    ("heavy cone 1:10", heavy_cone(10, 20.0), (2, 4, 6, 10), 24),
    ("heavy cone 1:100", heavy_cone(100, 2.0), (4, 6, 10, 16), 48),
    ("helix of five turns", helix(5), (4, 6, 8, 12), 24),
    ("helix of ten turns", helix(10), (8, 12, 16), 48),
    ("hanging cable, w L3/EI = 1e2", heavy(1e2), (2, 3, 6, 10), 24),
    ("hanging cable, w L3/EI = 1e4", heavy(1e4), (3, 6, 10, 16), 48),
    ("hanging cable, w L3/EI = 1e6", heavy(1e6), (6, 16), 96),
    ("force in a segment", at(0.3, force=(0, 0, -10.0)), (2, 3, 6), 10),
    ("moment in a segment", at(0.3, moment=(0, 3.0, 0)), (2, 3, 6), 10),
    ("column at 0.8 of its load", column(0.8), (1, 2, 3), 12),
    ("column at 0.95 of its load", column(0.95), (1, 2, 3), 12),
    ("column at 1.2 of its load", column(1.2), (1, 2, 3), 12),
    ("stiff insert, own segment", stiff_insert, (1, 2, 3), 12),
    ("stiff insert in a segment", insert_in_segment, (3, 6, 12), 20),
    ("tendon", tendon(1.0, 2.0), (1, 2, 3), 12),
    ("tendon that ends in a segment", tendon(0.35, 3.0), (2, 3, 6), 20),
    ("tendon beside the rod", free_tendon, (1, 2, 3), 12),
    ("chamber that ends in a segment", chamber(0.35), (2, 3, 6), 20),
    ("rod on a plane", on_plane, (2, 3, 6, 10), 24),
    ("clamped at both ends", clamped, (4, 6, 10), 24),
    ("cable between pins, w L3/EI = 1e3", pinned(0.8, 1e3), (4, 6, 10), 48),
    ("four-bar linkage of rods", four_bar, (1, 2, 3), 8),
    ("tree of rods", tree, (1, 2, 3), 8),
]


def sections(model, q):
    """Places of sections of all rods, at the same fractions of their lengths."""
    fractions = np.linspace(0, 1, SECTIONS)
    if isinstance(model, lissom.Rod):
        return [model.pose(q, fractions * model.length)[:, :3, 3]]
    found = []
    for part in model.links:
        length = sum(segment.length for segment in part.rod)
        found.append(model.pose(q, fractions * length * (1 - 1e-12), link=part.name)[:, :3, 3])
    return found


def median(function):
    """Processor time of a call, in seconds."""
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return statistics.median(times)


def rows():
    for name, build, numbers, parts in CASES:
        try:
            fine = build(5, parts)
            exact = lissom.statics(fine, space_error=False, stability=False)
            if not exact.success:
                raise RuntimeError(exact.message)
        except Exception as error:  # a benchmark goes on
            print(f"{name}: no truth: {error}", file=sys.stderr)
            continue
        truth = sections(fine, exact.q)
        for modes in numbers:
            model = build(modes, 1)
            found = lissom.statics(model)
            if not found.success:
                print(f"{name}, {modes} modes: {found.status}", file=sys.stderr)
                continue
            pairs = list(zip(sections(model, found.q), truth, strict=True))
            apart = [np.linalg.norm(a - b, axis=1) for a, b in pairs]
            length = model.length if hasattr(model, "length") else None
            estimate, full = found.space_error, lissom.statics(model, space_error=True).space_error
            scale = estimate.shape / estimate.relative if estimate.relative > 0 else length
            reached = max(x.max() for x in apart) / scale
            tip = max(x[-1] for x in apart) / scale
            alone = median(lambda model=model: lissom.statics(model, space_error=False))
            costs = [
                median(lambda model=model, value=value: lissom.statics(model, space_error=value)) / alone - 1
                for value in (None, True)
            ]
            yield name, modes, reached, tip, estimate, full, scale, costs, alone


def main(markdown):
    form = "| {0} | {1} | {2:.1e} | {5:.1e} | {4} | {6:.1e} | {10:.2f} | {8:.0%} | {9:.0%} |"
    if not markdown:
        form = "{:36} {:2d} {:8.1e} {:8.1e} {:10} {:8.1e} {:8.1e} {:8.1e} {:5.0%} {:5.0%} {:7.2f}  {:6.2f} {}"
    outside, hidden, count = [], [], 0
    for name, modes, reached, tip, estimate, full, scale, costs, alone in rows():
        ratio = estimate.relative / reached if reached > 0 else np.nan
        count += 1
        if reached > 1e-2 and estimate.relative < 1e-3:
            hidden.append((name, modes))
        if 1e-6 < reached < 0.5 and not 0.3 <= ratio <= 3:
            outside.append((name, modes, ratio))
        is_near = 0.3 <= ratio <= 3 or reached < 1e-6
        flag = "" if is_near else "<-"
        if (reached > 1e-2) != (estimate.relative > 1e-2) and not 0.5 <= ratio <= 2:
            flag = "<- wrong about a warning"
        print(
            form.format(
                name, modes, reached, tip, estimate.method, estimate.relative, full.relative,
                full.tip / scale, *costs, alone * 1e3, ratio, flag,
            )
        )  # fmt: skip
    print(f"{count} equilibria; outside of 0.3 to 3: {len(outside)}; small although large: {len(hidden)}")


if __name__ == "__main__":
    warnings.simplefilter("ignore", lissom.AccuracyWarning)
    main("--markdown" in sys.argv)
