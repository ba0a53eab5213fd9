"""Files as a whole: what is read, and what is left of a file that could not be replaced."""

import errno
import os
import stat
import threading

import pytest

from lissom.common import disk


def test_files_are_replaced_as_a_whole(tmp_path):
    path = tmp_path / "x.txt"
    disk.write(path, "old")
    path.chmod(0o640)
    disk.write(path, "nëw")
    assert path.read_bytes() == "nëw".encode()
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert [entry.name for entry in tmp_path.iterdir()] == ["x.txt"]


def test_a_failure_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "x.bin"
    disk.write(path, b"old")

    def full(handle):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        disk.write(path, b"new")
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["x.bin"]


def test_an_exception_while_writing_leaves_the_old_file(tmp_path):
    path = tmp_path / "film.gif"
    path.write_bytes(b"old")

    def write():
        with disk.replacing(path) as partial:
            assert partial.suffix == ".gif"
            partial.write_bytes(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write()
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["film.gif"]


def test_private_files_stay_private_while_they_are_written(tmp_path):
    path = tmp_path / "x.txt"
    path.write_bytes(b"old")
    path.chmod(0o600)
    with disk.replacing(path) as partial:
        assert stat.S_IMODE(partial.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_errors_name_the_file(tmp_path):
    """Also those of a write, which know no name."""
    path = tmp_path / "x.txt"

    def write():
        with disk.replacing(path):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(OSError, match=r"No space left.*x\.txt"):
        write()
    assert list(tmp_path.iterdir()) == []


def test_links_in_a_circle_are_left_alone(tmp_path):
    (tmp_path / "x").symlink_to("x")
    with pytest.raises(OSError, match="symbolic links"):
        disk.write(tmp_path / "x", b"new")
    assert (tmp_path / "x").is_symlink()


def test_names_may_be_as_long_as_the_system_allows(tmp_path):
    path = tmp_path / ("x." + "y" * 253)
    disk.write(path, b"new")
    assert path.read_bytes() == b"new"


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="nowhere"):
        disk.write(tmp_path / "nowhere" / "x", b"")


def test_links_stay_links(tmp_path):
    (tmp_path / "x").write_bytes(b"old")
    (tmp_path / "link").symlink_to("x")
    disk.write(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "x").read_bytes() == b"new"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no FIFOs")
def test_a_pipe_is_written_to(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    heard = []
    reader = threading.Thread(target=lambda: heard.append((tmp_path / "pipe").read_bytes()))
    reader.start()
    disk.write(tmp_path / "pipe", b"said")
    reader.join(timeout=20)
    assert heard == [b"said"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no FIFOs")
@pytest.mark.timeout(20)
def test_only_regular_files_of_bounded_size_are_read(tmp_path):
    (tmp_path / "x").write_bytes(b"12345")
    assert disk.read(tmp_path / "x") == disk.read(tmp_path / "x", 5) == b"12345"
    with pytest.raises(OSError, match="larger"):
        disk.read(tmp_path / "x", 4)
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero"):
        with pytest.raises(OSError, match="not a regular file"):
            disk.read(path)
    with pytest.raises(IsADirectoryError):
        disk.read(tmp_path)


def test_a_description_names_files_of_its_folder(tmp_path):
    home = tmp_path / "home"
    (home / "deep").mkdir(parents=True)
    (home / "deep" / "arm.urdf").write_bytes(b"inside")
    (tmp_path / "other.urdf").write_bytes(b"outside")
    (home / "link.urdf").symlink_to(tmp_path / "other.urdf")
    assert disk.read_beside(home, "deep/arm.urdf", anywhere=False) == b"inside"
    assert disk.read_beside(home, "deep/../deep/arm.urdf", anywhere=False) == b"inside"
    for name in ("../other.urdf", str(tmp_path / "other.urdf"), "link.urdf", "/dev/zero"):
        with pytest.raises(ValueError, match="leads out of the folder"):
            disk.read_beside(home, name, anywhere=False)
    assert disk.read_beside(home, "../other.urdf", anywhere=True) == b"outside"
    assert disk.read_beside(home, "link.urdf", anywhere=True) == b"outside"
    with pytest.raises(OSError, match="not a regular file"):
        disk.read_beside(home, "/dev/zero", anywhere=True)
