"""A home, captures, and a run that was imported, so that it stands without the minutes of training."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.interchange import export_scene
from hgs_core.scene import HybridScene, Segment
from server.cli import main
from tests.synthetic import synthetic_scene, write_capture


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return path


@pytest.fixture(scope="session")
def splats(capture: Path) -> Path:
    """An STGS file of the capture's scene, with five frames from 0 to 1."""
    static, dynamic = synthetic_scene()
    scene = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    export_scene(scene, capture / "x.ply", cameras=[])
    return capture / "x.ply"


@pytest.fixture(scope="module")
def run(capture: Path, splats: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("runs") / "run"
    more = ["--capture", str(capture), "--hold-out", "2", "--duration", str(5 / 30)]
    assert main(["import", str(splats), "--out", str(out), *more]) == 0
    return out


CAMERAS, FRAMES = 3, 4  # size of the capture `n3dv`


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "home"
    monkeypatch.setenv("HGS_HOME", str(folder))
    for name in ("HGS_DATABASE_URL", "HGS_STORE_URL", "HGS_PIPELINE", "HGS_CAPTURES"):
        monkeypatch.delenv(name, raising=False)
    return folder


def write_video(path: Path, frames: int = FRAMES) -> None:
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for k in range(frames):
            picture = np.full((48, 64, 3), 40 * k, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())


@pytest.fixture
def n3dv(tmp_path: Path) -> Path:
    """Three cameras side by side, 4 frames each, in the N3DV layout."""
    folder = tmp_path / "n3dv"
    folder.mkdir()
    pose = np.zeros((CAMERAS, 3, 5))
    pose[:, :, :3] = [[0, 1, 0], [1, 0, 0], [0, 0, -1]]  # columns down, right, backwards
    pose[:, 0, 3] = range(CAMERAS)
    pose[:, :, 4] = (48, 64, 60)
    np.save(folder / "poses_bounds.npy", np.concatenate([pose.reshape(CAMERAS, 15), np.ones((CAMERAS, 2))], axis=1))
    for camera in range(CAMERAS):
        write_video(folder / f"cam{camera:02}.mp4")
    return folder


@pytest.fixture
def refused(tmp_path: Path, home: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Return a function that runs a command, checks that it is refused in order, and returns the line it printed."""

    def run(*arguments: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        assert main([str(argument) for argument in arguments]) == 2
        output = capsys.readouterr()
        assert output.out == ""
        assert output.err.startswith("hgs: ")
        assert output.err.count("\n") == 1
        written = [path for path in sorted(tmp_path.rglob("*")) if path not in before and home not in path.parents]
        assert written in ([], [home])
        assert not list(home.glob("runs/*"))
        return output.err

    return run
