"""A browser for tests of reports, run only by `make test-browser`."""

import os

import numpy as np
import pytest
from playwright.sync_api import sync_playwright

import lissom
from lissom.drawing import report
from lissom.drawing.report import studies as study_reports
from lissom.results import studies
from lissom.results.runs import Run
from lissom.urdf.pictures import solid_of

#: Software rendering, the same on all machines, and options that containers need.
ARGUMENTS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]

#: Timeout in milliseconds: drawing without a graphics card is slow on a busy machine.
PATIENCE = 90_000

ROD = """version = 1
[scene]
name = "Whip"
[[rod]]
tip_force = [0, 0.02, 0]
tip_moment = [0, 0, 2e-3]
fluid = { density = 1, velocity = [0.3, 0, 0], viscous_drag = [0.1, 0.1] }
[[rod.segment]]
length = 0.2
section = { shape = "hollow_circle", outer = 0.012, inner = 0.008 }
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
retardation_time = 0.01
modes = { torsion = 1, bend_y = 2, bend_z = 2 }
[[rod.segment]]
length = 0.1
section = { shape = "rectangle", width = 0.02, height = 0.01 }
young_modulus = 3e5
poisson_ratio = 0.5
density = 1070
retardation_time = 0.01
modes = { bend_y = 1, bend_z = 1 }
[simulation]
t_end = 3
dt = 5e-3
"""


@pytest.fixture(scope="session")
def browser():
    with sync_playwright() as playwright:
        # Path of an installed browser, if playwright has installed none.
        path = os.environ.get("LISSOM_CHROMIUM")
        opened = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Reports of a rod's motion, equilibrium and modes, and of a path of equilibria with a limit point."""
    made = tmp_path_factory.mktemp("reports")
    scene = lissom.Scene.loads(ROD)
    report.write(Run(scene, scene.run()), made / "motion.html")
    rest = studies.study_statics(scene)
    assert rest.found.success
    study_reports.write(rest, made / "statics.html")
    study_reports.write(studies.study_modes(scene, rest), made / "modes.html")
    column, path = turning_path()
    path.report(made / "path.html", column)
    inside_a_sphere().report(made / "inside.html")
    report_with_visuals(made / "visuals.html")
    return made


def report_with_visuals(path):
    """A bar on a hinge, drawn as a red box over a green sheet that is seen through."""
    bar = lissom.Body(0.2, centre=(0.1, 0, 0), inertia=np.diag([1e-5, 7e-4, 7e-4]))
    robot = lissom.Robot([lissom.Link("bar", body=bar, joint=lissom.Revolute((0, 1, 0)))])
    points, faces = solid_of("box", (0.2, 0.02, 0.04))
    box = lissom.Visual("bar", points + np.array([0.1, 0, 0]), faces, colour="#ff0000")
    sheet = [(0, 0, 0), (0.2, 0, 0), (0.2, 0, -0.1), (0, 0, -0.1)]
    sheet = lissom.Visual("bar", sheet, [(0, 1, 2), (0, 2, 3)], name="sheet", colour="#00ff00", opacity=0.5)
    lissom.simulate(robot, 0.4, dt=5e-3).report(path, visuals=[box, sheet])


def inside_a_sphere():
    """A rod whose tip is in a sphere, which touches only a ball near its base."""
    segment = lissom.Segment(0.2, 0.008, 1e6, poisson_ratio=0.5, density=1000, modes={"bend_y": 1})
    around = lissom.Contact(
        lissom.Ball("rod", 0.001, at=0.05), lissom.Sphere((0.2, 0.0, 0.0), 0.05), stiffness=1.0
    )
    rod = lissom.Robot([lissom.Link("rod", rod=[segment])], gravity=(0, 0, 0), contacts=[around])
    return lissom.simulate(rod, 0.01, dt=1e-3)


def turning_path():
    """A column bent to the wrong side: its load decreases to a limit point and increases again."""
    length, radius, young = 0.2, 0.01, 1e6
    euler = np.pi**3 / 16 * young * radius**4 / length**2
    segment = lissom.Segment(length, radius, young, poisson_ratio=0.5, density=1000, modes={"bend_y": 3})
    column = lissom.Rod([segment], gravity=(0, 0, 0), tip_force=(-2 * euler, 0, 0.02 * euler))
    wrong = lissom.statics(column, q0=[0.5 / length, 0, 0])
    path = lissom.continuation(column, wrong.q, load_factor=1.0, direction=-wrong.q)
    assert path.path.load_factor[0] == path.path.load_factor[-1] == 1.0
    return column, path


class Opened:
    """A page with the errors of its scripts."""

    def __init__(self, page, path):
        self.page, self.problems = page, []
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.on(
            "console",
            lambda message: (
                self.problems.append(message.text)
                if message.type in ("error", "warning") and "GPU stall" not in message.text
                else None
            ),
        )
        page.on("request", self._requested)
        page.goto(path.as_uri(), wait_until="load", timeout=PATIENCE)
        page.wait_for_selector(".player[data-state]")

    def _requested(self, request):
        if not request.url.startswith(("file:", "data:", "blob:")):
            self.problems.append(f"asked for {request.url}")

    def run(self, script):
        """The value of a script in which ``player`` is the first player and ``clock`` its clock."""
        start = "const player = document.querySelector('.player').player, clock = player.clock;"
        return self.page.evaluate(f"async () => {{ {start} {script} }}")


@pytest.fixture
def opened(browser, folder):
    """Opens a report of `folder`; fails if its scripts report errors."""
    contexts, pages = [], []

    def at(name, width=1000, height=900, scheme="light", touch=False):
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme=scheme,
            is_mobile=touch,
            has_touch=touch,
            accept_downloads=True,
        )
        contexts.append(context)
        pages.append(Opened(context.new_page(), folder / f"{name}.html"))
        return pages[-1]

    yield at
    problems = [page.problems for page in pages]
    for context in contexts:
        context.close()
    assert problems == [[] for _ in pages]


def pytest_addoption(parser):
    parser.addoption(
        "--new-pictures", action="store_true", help="Keep the views as they look now, for later comparisons."
    )
