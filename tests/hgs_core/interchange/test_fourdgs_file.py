""".4dgs files against the library of the format's makers, which reads ours, and we its."""

from __future__ import annotations

import builtins
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.fourdgs_file import FOURDGS, fourdgs_file, read_fourdgs
from hgs_core.interchange.import_scene import import_scene
from hgs_core.interchange.still_moment import scene_at
from hgs_core.scene import HybridScene, Segment
from hgs_core.scene.temporal import evaluate
from tests.hgs_core.interchange.scenes import Write, axes_of, counted, dynamics, export, plain, statics

fourdgs = pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")


@pytest.fixture(scope="module")
def moving() -> HybridScene[np.ndarray]:
    return HybridScene(statics(40), (Segment(2.0, 3.0, dynamics(20, 1)), Segment(3.0, 5.0, dynamics(25, 2))))


def state(data: bytes, seconds: float) -> tuple[Any, dict[str, np.ndarray]]:
    """The gaussians of a file, and their state at a second in the library."""
    found = fourdgs.read(data)
    return found.gaussians, found.gaussians.state_at(seconds, cutoff=found.header.cutoff)


def test_another_reader_sees_every_splat_where_it_is_and_as_opaque(moving: HybridScene[np.ndarray]) -> None:
    """Within the bounds that the file states, and for places half of a middle axis of at most a third."""
    data = fourdgs_file(moving).data
    for seconds in (2.0, 2.3, 2.99, 3.2, 4.4, 5.0):
        gaussians, found = state(data, seconds - 2.0)
        expected = scene_at(moving, seconds)
        rows = found["indices"]
        opaque = found["opacity"] > 0.02
        near = np.abs(found["centers"][:, None] - expected.means[None]).max(axis=2)
        nearest = near.argmin(axis=1)
        assert (near.min(axis=1)[opaque] < 0.12).all()
        assert len(set(nearest[opaque].tolist())) == opaque.sum()
        shares = 1 / (1 + np.exp(-expected.opacity_logits.astype(np.float64)))
        np.testing.assert_allclose(found["opacity"][opaque], shares[nearest[opaque]], atol=0.02)
        assert (shares > 0.03).sum() <= len(set(nearest.tolist()))
        np.testing.assert_allclose(gaussians.colors[rows, :3], expected.rgb[nearest], atol=0.003)
        np.testing.assert_allclose(gaussians.scales[rows], np.exp(expected.log_scales[nearest]), rtol=0.01)


def test_statics_are_shown_always_and_the_file_tells_axes_colours_and_length(moving: HybridScene[np.ndarray]) -> None:
    found = fourdgs.read(fourdgs_file(moving).data)
    still = np.isinf(found.gaussians.sigma_t) & (found.gaussians.win_lo == 0) & (found.gaussians.win_hi >= 3)
    still &= ~found.gaussians.motions.any(axis=1)
    assert still.sum() >= 40
    assert found.duration_sec == 3.0
    frame = found.provenance.frame
    assert (frame.handedness, frame.up_axis, frame.forward_axis) == (1, 4, 2)  # right-handed, -y, +z
    assert found.header.attributes["color_space"] == "srgb-rec709-display"
    order = np.abs(found.gaussians.positions[still][:, None] - moving.static.means[None]).max(axis=2).argmin(axis=0)
    xyzw = found.gaussians.rotations[still][order]
    np.testing.assert_allclose(axes_of(xyzw[:, [3, 0, 1, 2]]), axes_of(moving.static.quats), atol=0.005)


def test_what_is_written_is_read_back_at_any_time(moving: HybridScene[np.ndarray], tmp_path: Path) -> None:
    changes = export(moving, tmp_path / "x.4dgs")
    assert {("replaced", "motion and turning"), ("rounded", "numbers")} <= set(counted(changes))
    imported = import_scene(tmp_path / "x.4dgs")
    assert (imported.scene.start, imported.scene.end) == (0.0, 3.0)
    assert len(imported.scene.static) >= 40
    assert [change.what for change in imported.changes] == ["windows"]
    for seconds in (0.0, 0.7, 1.5, 3.0):
        _, expected = state((tmp_path / "x.4dgs").read_bytes(), seconds)
        found = scene_at(imported.scene, seconds)
        near = np.abs(found.means[:, None] - expected["centers"][None]).max(axis=2)
        shares = 1 / (1 + np.exp(-found.opacity_logits.astype(np.float64)))
        assert (near.min(axis=1)[shares > 0.01] < 1e-4).all()
        np.testing.assert_allclose(
            np.sort(shares[shares > 0.01]), np.sort(expected["opacity"][expected["opacity"] > 0.01]), atol=1e-5
        )


def set_of(count: int = 6, **changed: object) -> Any:
    rng = np.random.default_rng(0)
    columns = {
        "positions": rng.normal(size=(count, 3)),
        "scales": np.full((count, 3), 0.1),
        "rotations": np.tile([0, 0, 0, 1.0], (count, 1)),
        "colors": np.full((count, 4), 0.5),
        "motions": rng.normal(size=(count, 3)),
        "mu_t": np.full(count, 0.8),
        "sigma_t": np.full(count, 0.4),
        "win_lo": np.zeros(count),
        "win_hi": np.full(count, 2.0),
    }
    return fourdgs.GaussianSet(**columns | changed)


def file_of(gaussians: Any, **options: object) -> bytes:
    buffer = io.BytesIO()
    frame = fourdgs.CoordinateFrame(handedness=1, up_axis=4, forward_axis=2)
    chosen = {"profile": "fine", "cutoff": 1 / 255, "provenance": fourdgs.Provenance(frames=[frame])} | options
    fourdgs.write(buffer, gaussians, 2.0, options=fourdgs.WriteOptions(**chosen))
    return buffer.getvalue()


def test_a_file_of_the_makers_moves_and_fades_as_their_library_says(written: Write) -> None:
    """The first one is gone after 0.5 s, of its own; the second never fades."""
    given = set_of(
        mu_t=np.float64([0.2, *[0.8] * 5]),
        sigma_t=np.float64([0.05, np.inf, *[0.4] * 4]),
        win_lo=np.float64([0, 0, 0, 0.5, 0.5, 0]),
        win_hi=np.float64([2, 2, 2, 2, 1.5, 1.0]),
    )
    data = file_of(given)
    found = read_fourdgs(written("x.4dgs", data))
    assert found.ends == (0.5, 1.0, 1.5, 2.0)
    assert [len(part) for part in found.dynamic] == [4, 5, 4, 3]
    scene = import_scene(written("x.4dgs", data)).scene
    for seconds in (0.1, 0.6, 1.2, 1.9):
        _, expected = state(data, seconds)
        segment = scene.segment_at(seconds)
        places, _, opacities = evaluate(segment.dynamic, segment.normalised(seconds))
        np.testing.assert_allclose(places[opacities >= 1 / 255], expected["centers"], atol=1e-5)
        np.testing.assert_allclose(opacities[opacities >= 1 / 255], expected["opacity"], atol=1e-5)


def test_what_is_beside_the_splats_is_told(written: Write) -> None:
    sh = np.full((6, 9), 128, np.uint8)
    sh[:2] = 200
    gaussians = set_of(sh=sh, sh_degree=1)
    data = file_of(gaussians, provenance=None, cutoff=0.05, metadata={"color_space": "linear-rec709-display"})
    found = read_fourdgs(written("x.4dgs", data))
    assert counted(found.changes) == {
        ("replaced", "axes"): None,
        ("replaced", "ends of lives"): None,
        ("replaced", "colour"): 6,
        ("left out", "view-dependent colour"): 2,
        ("replaced", "windows"): None,
    }
    np.testing.assert_allclose(found.dynamic[0].rgb, 0.735, atol=0.003)  # light of a half


def test_a_still_scene_comes_back_still(tmp_path: Path, still: HybridScene[np.ndarray]) -> None:
    export(still, tmp_path / "x.4dgs")
    found = import_scene(tmp_path / "x.4dgs").scene
    assert (found.start, found.end, found.dynamic_splats, len(found.static)) == (0.0, 0.0, 0, 50)


TRACK = fourdgs.ObjectTrack(
    1, times=[0.0, 1.0], rotations=[[0, 0, 0, 1.0]] * 2, translations=[[0, 0, 0.0], [1, 0, 0.0]]
)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"temporal_model": "deformation-field"}, "is no .4dgs file that is read here"),
        ({"objects": fourdgs.ObjectLayer(tracks=[TRACK])}, "moves splats by tracks of objects; bake them"),
        ({"metadata": {"color_space": "aces"}}, "has colours in aces; export it in srgb-rec709-display"),
        (
            {
                "provenance": fourdgs.Provenance(
                    frames=[fourdgs.CoordinateFrame(handedness=1, up_axis=1, forward_axis=5)]
                )
            },
            "has up along +y and forward along -z; turn it",
        ),
    ],
)
def test_what_would_have_to_be_guessed_is_refused(written: Write, options: dict[str, Any], problem: str) -> None:
    path = written("x.4dgs", file_of(set_of(), **options))
    with pytest.raises(InputError) as caught:
        read_fourdgs(path)
    assert str(caught.value).startswith(f"{path}: {problem}")


def test_a_file_that_is_cut_short_or_another_is_refused(written: Write) -> None:
    for data in (b"ply\n", file_of(set_of())[:200]):
        with pytest.raises(InputError, match=r"is no \.4dgs file that is read here"):
            read_fourdgs(written("x.4dgs", data))


def test_without_the_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def none(name: str, *more: Any, **options: Any) -> Any:
        if name == "fourdgs":
            raise ImportError(name)
        return real(name, *more, **options)

    monkeypatch.setattr(builtins, "__import__", none)
    with pytest.raises(InputError, match=r"needs the package fourdgs; pip install 'hgs\[4dgs\]'"):
        fourdgs_file(HybridScene(plain(), (Segment(0.0, 0.0, dynamics(0)),)))


def test_a_segment_or_a_moment_cannot_be_chosen(moving: HybridScene[np.ndarray], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--segment: is not for .4dgs, which holds all of them"):
        export(moving, tmp_path / "x.4dgs", segment=1)
    with pytest.raises(InputError, match=r"--time: is not for .4dgs, which holds all times"):
        export(moving, tmp_path / "x.4dgs", time=3.0)
    assert FOURDGS.suffix == ".4dgs"
