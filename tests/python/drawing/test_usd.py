"""Universal Scene Description: files read back by OpenUSD itself, which `make test-torch` installs."""

import subprocess
import sys

import numpy as np
import pytest

import lissom

MATERIAL = {"young_modulus": 2e6, "poisson_ratio": 0.4, "density": 1000.0}


@pytest.fixture(scope="module")
def pxr():
    return pytest.importorskip("pxr", reason="OpenUSD is only installed by `make test-torch`")


def robot(**more):
    soft = lissom.Segment(0.3, 0.01, modes={"bend_y": 2, "bend_z": 1}, retardation_time=0.02, **MATERIAL)
    hand = lissom.Link("end-effector 1", parent="arm", body=lissom.Body(0.01, inertia=np.diag([1e-6] * 3)))
    floor = lissom.Contact("arm", lissom.Sphere((0.2, 0.2, -0.3), 0.05), stiffness=1e4, name="ball")
    return lissom.Robot([lissom.Link("arm", rod=[soft]), hand], contacts=[floor], **more)


@pytest.fixture(scope="module")
def motion():
    return lissom.simulate(robot(), 0.5, dt=2e-3)


def mesh_of(stage, name):
    from pxr import UsdGeom

    (found,) = [prim for prim in stage.Traverse() if prim.GetDisplayName() == name]
    return UsdGeom.Mesh(found)


def points_at(mesh, code):
    """Vertices in the world at a time code, metres."""
    from pxr import UsdGeom

    points = np.array(mesh.GetPointsAttr().Get(code), float)
    pose = np.array(UsdGeom.Imageable(mesh).ComputeLocalToWorldTransform(code))
    return points @ pose[:3, :3] + pose[3, :3]


@pytest.mark.parametrize("suffix", [".usd", ".usda", ".usdc"])
def test_rods_and_bodies_move_as_in_the_result(suffix, motion, pxr, tmp_path):
    from pxr import Usd, UsdGeom

    motion.save(tmp_path / f"motion{suffix}")
    stage = Usd.Stage.Open(str(tmp_path / f"motion{suffix}"))
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    rate = stage.GetTimeCodesPerSecond()
    assert stage.GetEndTimeCode() == pytest.approx(0.5 * rate)
    rod, body = mesh_of(stage, "arm"), mesh_of(stage, "end-effector 1")
    codes = rod.GetPointsAttr().GetTimeSamples()
    assert len(codes) > 20
    for code in (codes[0], codes[len(codes) // 2], codes[-1]):
        k = int(np.argmin(np.abs(motion.t - code / rate)))
        assert motion.t[k] == pytest.approx(code / rate, abs=1e-9)
        tip = motion.model.pose(motion.q[k], link="arm")[:3, 3]
        # The ring at the end of the rod has its centre at the tip.
        points = points_at(rod, code)
        ring = points[np.argsort(np.linalg.norm(points - tip, axis=1))[:24]]
        np.testing.assert_allclose(ring.mean(axis=0), tip, atol=1e-6)
        np.testing.assert_allclose(points_at(body, code).mean(axis=0), tip, atol=1e-4)
    across = np.array(rod.GetNormalsAttr().Get(codes[-1]))
    np.testing.assert_allclose(np.linalg.norm(across, axis=1), 1.0, atol=1e-5)
    # What does not move has no samples.
    assert mesh_of(stage, "ball").GetPointsAttr().GetTimeSamples() == []


def test_surfaces_are_closed_and_have_their_volume(motion, pxr, tmp_path):
    import trimesh
    from pxr import Usd

    motion.save(tmp_path / "shape.usda", t=0.1)
    stage = Usd.Stage.Open(str(tmp_path / "shape.usda"))
    assert not stage.HasAuthoredTimeCodeRange()
    ball = mesh_of(stage, "ball")
    faces = np.array(ball.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    shown = trimesh.Trimesh(points_at(ball, 0), faces)
    assert shown.volume == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=0.05)
    assert shown.centroid == pytest.approx([0.2, 0.2, -0.3], abs=1e-6)


def test_what_is_up_stays_up(pxr, tmp_path):
    """Where weight pulls along x, the file is turned: what falls, falls along -y."""
    from pxr import Usd, UsdGeom

    result = lissom.simulate(robot(gravity=(9.81, 0, 0)), 0.2, q0=None)
    result.save(tmp_path / "x.usd")
    stage = Usd.Stage.Open(str(tmp_path / "x.usd"))
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    centre = points_at(mesh_of(stage, "ball"), 0).mean(axis=0)
    assert centre[1] == pytest.approx(-0.2, abs=1e-6)
    assert np.sort(np.abs(centre)) == pytest.approx([0.2, 0.2, 0.3], abs=1e-6)


def test_equilibria_too(pxr, tmp_path):
    from pxr import Usd

    model = robot()
    found = lissom.statics(model, space_error=False)
    found.save(tmp_path / "rest.usdc", model)
    stage = Usd.Stage.Open(str(tmp_path / "rest.usdc"))
    tip = model.pose(found.q, link="arm")[:3, 3]
    assert points_at(mesh_of(stage, "end-effector 1"), 0).mean(axis=0) == pytest.approx(tip, abs=1e-4)


def test_without_openusd_the_message_says_what_to_install(tmp_path):
    code = "import sys; sys.modules['pxr'] = None\nimport lissom\n"
    code += "soft = lissom.Segment(0.3, 0.01, 1e6, 4e5, 1000.0, {'bend_y': 2})\n"
    code += "lissom.simulate(lissom.Rod([soft]), 0.1).save('x.usd')"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert "ImportError: .usd files need OpenUSD: pip install 'lissom[usd]'" in run.stderr
    assert not list(tmp_path.iterdir())
