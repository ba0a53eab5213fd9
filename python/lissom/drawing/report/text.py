"""Text about a run for reports and the command line."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._lissom import AccuracyWarning, MotionResult, Scene, Statistics, simulate
from ...analysis.limits import exceeded_by_motion
from ...model.starts import has_contacts, has_loops
from ...model.views import SECTIONS_PER_SEGMENT, Coordinate, view
from ...results.hard_steps import where_spent
from ...results.runs import COUNTERS, MAX_SHAPES, NO_ENERGIES, Made, Run, in_words_of_a_scene
from ...results.runs import statistics as numbers
from . import loops, motion

if TYPE_CHECKING:
    from ...model.glyphs.contacts import ContactGlyph
    from ...model.glyphs.loops import LoopGlyph

METHODS = {
    "newmark": "Newmark (implicit, β = 1/4, γ = 1/2)",
    "hht": "Hilber-Hughes-Taylor (implicit)",
    "generalised_alpha": "generalised alpha (implicit)",
    "rk45": "Dormand-Prince 5(4) (explicit)",
    "dop853": "Dormand-Prince 8(5,3) (explicit)",
    "radau": "Radau IIA of order 5 (implicit)",
    "quasi_static": "quasi-static (backward Euler without inertia)",
    "auto": "chosen for the accuracy",
}

#: Newmark's method for models with closed loops or contacts.
METHOD_THAT_DAMPS = "generalised alpha (implicit, ρ∞ = 0.8)"

#: Where the largest values say which.
BEYOND_LIMITS = "{what}, but beyond limits of segments."

#: Counters shown first.
SHOWN_COUNTERS = ("steps", "newton_iterations", "nfev")

#: Number of steps and of runs that `lissom explain` measures.
MEASURED_STEPS = 100
MEASURED_RUNS = 3

#: Methods with a fixed step from the scene.
NEWMARK = ("newmark", "hht", "generalised_alpha")
FIXED_STEP = (*NEWMARK, "quasi_static")

#: Methods that evaluate accelerations, but do not solve for them.
EXPLICIT = ("rk45", "dop853")


def quantity(value: float, unit: str = "", digits: int = 3) -> str:
    """Format a number with few digits and its unit; seconds and joules with a suitable prefix."""
    if unit in ("s", "J") and 0.0 < abs(value) < 1.0:
        for factor, prefix in ((1e3, "m"), (1e6, "µ"), (1e9, "n")):
            if abs(value) * factor >= 1.0:
                return f"{value * factor:.{digits}g} {prefix}{unit}"
    return f"{value:.{digits}g} {unit}".strip()


def pace(ratio: float) -> str:
    """Speed relative to real time, as text."""
    return f"{ratio:,.0f} ×" if ratio >= 10.0 else f"{ratio:.2g} ×"


def drift(run: Run | Made) -> str:
    """The energy drift as text."""
    if "energy" not in run.wants:
        return "not computed: the scene does not ask for energies"
    if not run.has_energies:
        return "NaN: energies are not finite"
    if isinstance(run, Run) and run.scene.simulation.method == "quasi_static":
        return "none: inertia is left out"
    if not run.balance.moves:
        return "none: nothing moves"
    moved = quantity(run.balance.scale, "J")
    return f"{quantity(run.balance.drift, digits=2)} of the {moved} exchanged"


def method_of(scene: Scene) -> str:
    """The time integrator of a scene, in words."""
    method = scene.simulation.method
    model = scene.model
    if method == "newmark" and (has_loops(model) or has_contacts(model)):
        return METHOD_THAT_DAMPS
    return METHODS[method]


def lead(run: Run) -> str:
    """One line under the title."""
    model, settings = run.scene.model, run.scene.simulation
    count = f"{model.n} generalised coordinates"
    time = f"{quantity(settings.t_end - settings.t0)} s simulated by {method_of(run.scene)}"
    return f"{run.view.title}, {count}, {time}."


def outcome(run: Run) -> tuple[str, bool]:
    """The outcome of a run, and whether it is good."""
    if run.interrupted:
        return f"Interrupted at {quantity(float(run.t[-1]))} s; what was computed until then is shown.", False
    if not run.motion.success:
        return f"Failed at {quantity(float(run.t[-1]))} s: {run.message}", False
    if not run.has_energies:
        return f"Finished. {NO_ENERGIES}", False
    settings, space_error = run.scene.simulation, run.motion.stats.space_error
    if settings.method == "auto" and space_error is not None and space_error > settings.rtol:
        return (
            f"Finished, but the modes are too few: the space error is {space_error:.0e} of the length, "
            f"{settings.rtol:g} was asked for.",
            False,
        )
    return finished(run.motion, "" if run.motion.doubt is None else in_words_of_a_scene(run.motion.doubt))


def finished(motion: MotionResult, doubt: str) -> tuple[str, bool]:
    """The outcome of a motion that came to its end: good without a doubt and within limits of segments."""
    is_within = not exceeded_by_motion(motion)
    ended = "Finished." if is_within else BEYOND_LIMITS.format(what="Finished")
    return f"{ended} {doubt}".rstrip(), is_within and not doubt


def tiles(run: Run) -> list[tuple[str, str]]:
    """The key facts of a run."""
    found = numbers(run)
    counters = found["counters"]
    tiles = [(quantity(run.motion.stats.wall_time, "s"), "run time")]
    if found["times_real_time"] is not None:
        tiles.append((pace(found["times_real_time"]), "as fast as real time"))
    tiles += [(f"{counters[name]:,}", COUNTERS[name]) for name in SHOWN_COUNTERS if counters[name]]
    if "energy" in run.wants and not run.has_energies:
        tiles.append(("NaN", "energy drift"))
    elif "energy" in run.wants and run.balance.moves:
        tiles.append((quantity(found["energy_drift"], digits=2), "energy drift, relative"))
    deepest = run.motion.deepest
    if deepest is not None:
        share = f"{quantity(100 * deepest.share, digits=2)} % of the thickness"
        tiles.append((quantity(deepest.depth, "m", digits=2), f"deepest overlap, {deepest.contact}: {share}"))
    return tiles


def statistics(run: Run) -> list[tuple[str, str]]:
    """Rows of the table of statistics."""
    found = numbers(run)
    settings = run.scene.simulation
    rows = [("method", method_of(run.scene))]
    if settings.method in FIXED_STEP:
        rows.append(("step", quantity(settings.dt, "s")))
    if settings.method in NEWMARK:
        rows.append(("Jacobian", settings.jac))
    rows += [
        tolerances(run),
        ("simulated", quantity(found["simulated_seconds"]) + " s"),
        ("states kept", f"{len(run.t):,}"),
        ("run time", quantity(run.motion.stats.wall_time, "s")),
    ]
    rows += [(COUNTERS[name], f"{count:,}") for name, count in found["counters"].items() if count]
    rows += hard_steps(run.motion)
    rows += [
        ("energy drift", drift(run)),
        ("message", found["message"]),
    ]
    return rows


def hard_steps(motion: MotionResult) -> list[tuple[str, str]]:
    """A row that says which steps take much of the work, if few do."""
    spent = where_spent(motion)
    return [] if spent is None else [("hard steps", spent)]


def tolerances(run: Run) -> tuple[str, str]:
    """Requested tolerances and estimated errors."""
    settings, stats = run.scene.simulation, run.motion.stats
    if settings.method != "auto":
        absolute = "" if settings.atol is None else f", absolute {settings.atol:g}"
        return "tolerances", f"relative {settings.rtol:g}{absolute}"
    errors = {"in time": stats.time_error, "in space": stats.space_error}
    reached = [f"{error:.0e} {where}" for where, error in errors.items() if error is not None]
    return "error of the tip", f"{', '.join(reached) or 'unknown'}; requested: {settings.rtol:g}"


def outputs(scene: Scene) -> list[tuple[str, str]]:
    """The output of a run, what it costs beyond the steps, and what is left out."""
    settings, wants = scene.simulation, scene.simulation.quantities
    is_explicit = settings.method in EXPLICIT
    kept = settings.output_dt or settings.dt
    costs = {
        "velocity": "at no cost",
        "acceleration": "one evaluation per time" if is_explicit else "at no cost: steps solve for it",
        "energy": "one evaluation per time, and the power of damping in every step",
        "shape": f"{SECTIONS_PER_SEGMENT} sections per segment, at {MAX_SHAPES} times at most",
    }
    if not view(scene.model).links:
        del costs["shape"]
    rows = [("coordinates", f"every {quantity(kept, 's')}")]
    rows += [(name, cost if name in wants else "not wanted") for name, cost in costs.items()]
    return rows


def cost_of_steps(scene: Scene) -> list[tuple[str, str]]:
    """Cost of the first steps of a scene on this machine: the fastest of several runs."""
    settings = scene.simulation
    # Methods with adaptive steps run the whole scene, because they may need few steps.
    is_fixed = settings.method in FIXED_STEP
    whole_time = settings.t_end - settings.t0
    duration = min(whole_time, MEASURED_STEPS * settings.dt) if is_fixed else whole_time
    runs = [_first_steps(scene, duration) for _ in range(MEASURED_RUNS)]
    stats = min(runs, key=lambda motion: motion.stats.wall_time).stats
    rows = [("method", method_of(scene)), *_loops(scene, runs[0])]
    if stats.steps == 0:
        return [*rows, ("message", in_words_of_a_scene(runs[0].message))]
    if is_fixed:
        rows += [
            ("step", f"{quantity(settings.dt, 's')}, {settings.jac} Jacobian"),
            ("Newton iterations", f"{stats.newton_iterations / stats.steps:.2f} a step"),
            ("Jacobians", f"{stats.njev / stats.steps:.2g} a step"),
        ]
    cost = stats.wall_time / stats.steps
    of_each = view(scene.model).multiplications() if is_fixed else None
    if of_each is not None:
        products = multiplications(of_each, stats) / stats.steps
        rows.append(("multiplications", f"{products:,.0f} a step, {1e-9 * products / cost:.2g} a nanosecond"))
    rows.append(
        ("cost", f"{quantity(cost, 's')} a step, {quantity(stats.wall_time, 's')} for {stats.steps} steps")
    )
    if is_fixed:
        whole = cost * np.ceil(whole_time / settings.dt)
        rows.append(("whole scene", f"about {quantity(whole, 's')}, without output and report"))
    return rows


def _loops(scene: Scene, motion: MotionResult) -> list[tuple[str, str]]:
    """Why closed loops and contacts change the default method, and redundant constraints at the start."""
    model = scene.model
    if not has_loops(model):
        if has_contacts(model) and scene.simulation.method == "newmark":
            why = "contact excites fast vibrations and needs numerical damping; average acceleration has none"
            return [("why", why)]
        return []
    rows = []
    if scene.simulation.method == "newmark":
        why = "closed loops need numerical damping of infinitely fast modes; average acceleration has none"
        rows.append(("why", why))
    if len(motion.q):
        found = view(model).redundant(motion.q[0])
        named = ", ".join(f"{number} of {name}" for name, number in found.items()) or "none"
        rows.append(("redundant", f"{named} of the constraints at the start, with loops closed"))
    return rows


def multiplications(one: Mapping[str, int], stats: Statistics) -> int:
    """Number of multiplications in the steps of a Newmark method: in residuals, Jacobians and linear systems.

    ``one`` contains the multiplications of one of each.
    """
    return (
        (stats.nfev + stats.nfev_jac) * one["residual"]
        + (stats.njev * one["tangent"] if stats.nfev_jac == 0 else 0)
        + stats.nlu * one["factorisation"]
        + stats.nfev * one["solution"]
    )


def _first_steps(scene: Scene, duration: float) -> MotionResult:
    settings = scene.simulation
    options: dict[str, Any] = {"jac": settings.jac} if settings.method in NEWMARK else {}
    if settings.atol is not None:
        options["atol"] = settings.atol
    with warnings.catch_warnings():
        # Only the cost of these steps matters; `check` and `run` report their accuracy.
        warnings.simplefilter("ignore", AccuracyWarning)
        return simulate(
            scene.model,
            settings.t0 + duration,
            t0=settings.t0,
            q0=scene.q0,
            v0=scene.v0,
            method=settings.method,
            dt=settings.dt,
            rtol=settings.rtol,
            **options,
        )


def summary(run: Run) -> list[tuple[str, str]]:
    """The summary that the command line prints."""
    found = numbers(run)
    settings, counters = run.scene.simulation, found["counters"]
    method = method_of(run.scene)
    if settings.method in FIXED_STEP:
        method += f", step {quantity(settings.dt, 's')}, {settings.jac} Jacobian"
    rows = [*(("advice", sentence) for sentence in run.advice), ("method", method)]
    if settings.method == "auto":
        rows.append(tolerances(run))
    rows += [(COUNTERS[name], f"{counters[name]:,}") for name in SHOWN_COUNTERS if counters[name]]
    rows += hard_steps(run.motion)
    pace_of = found["times_real_time"]
    time = quantity(run.motion.stats.wall_time, "s")
    rows.append(("run time", f"{time}, {pace(pace_of)} real time" if pace_of else time))
    rows.append(("energy drift", drift(run)))
    return rows


def animation(run: Run | Made) -> str:
    """Caption of the animation."""
    note = f"{run.view.caption}. Axes are to scale"
    sizes = [size for link in run.view.links for size in link.half_extents()]
    if sizes and min(sizes) < motion.LEAST_RADIUS * run.view.size:
        note += "; the rod itself is drawn thicker than it is"
    if run.view.glyphs.loads:
        note += ". Arrows and rings show loads over time; small ones are enlarged"
    return f"{note}. Use the legend to show and hide layers."


def coordinates(shown: Sequence[Coordinate]) -> str:
    """Caption of coordinates."""
    if all(coordinate.degree is None for coordinate in shown):
        return ""
    return (
        "Each strain is its value at rest plus the sum of these amplitudes times shifted Legendre "
        "polynomials P of degree 0, 1, 2, ... along the segment."
    )


def held(glyph: LoopGlyph) -> str:
    """Caption of the constraint forces of a loop."""
    if glyph.kind == "gear":
        return f"The generalised force on the first coordinate of {glyph.name}: {glyph.between}."
    return (
        f"Force and moment of the first end of {glyph.name} on the second one ({glyph.between}), in world "
        "axes; the moment is about the second end. If constraints are redundant, these are the smallest "
        "forces that hold all loops."
    )


def pressed(glyph: ContactGlyph) -> str:
    """Caption of a contact force."""
    return (
        f"Force that the second surface of {glyph.name} exerts on the first one ({glyph.between}), friction "
        "included, in world axes, at the output times; impacts can be shorter."
    )


def gaps(run: Run | Made) -> str:
    """Caption of the gaps of closed loops."""
    widest = quantity(float(np.nanmax(loops.widest(run), initial=0.0)), digits=2)
    return f"The largest constraint violation of each loop; at most {widest}. The exact value is zero."


def energy(run: Run | Made) -> str:
    """Caption of the energies."""
    work, who = "", ""
    if run.balance.work.any():
        work = " − work"
        who = (
            "Work is done by what has no potential: actuators, prescribed motions, moments, and forces that "
            "follow the model or vary in time. "
        )
    return (
        f"The total is kinetic + elastic + gravitational + loads + dissipated{work}. {who}An exact motion "
        f"keeps it constant. Energy drift here: {drift(run)}."
    )
