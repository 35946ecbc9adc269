from __future__ import annotations

import contextlib
import dataclasses
import gzip
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.formats import FORMATS, IMPORTED, format_of
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.scenes import axes_of, export, plain, statics

SMALL = HybridScene(plain(), (Segment(0.0, 0.0, DynamicSplats.empty()),))


def test_a_files_format_goes_by_its_suffix() -> None:
    names = [".ply", ".splat", ".splatv", ".spz", ".glb", ".4dgs", ".sog"]
    assert [format_of(Path(f"folder.obj/x{name}"), lambda one: True).suffix for name in names] == names


@pytest.mark.parametrize(("name", "suffix"), [("x.obj", "'.obj'"), ("x", "'none'"), ("x.splatv", "'.splatv'")])
def test_a_suffix_that_does_not_fit_is_told_those_that_do(name: str, suffix: str) -> None:
    with pytest.raises(InputError) as caught:
        format_of(Path(name), lambda one: one.read is not None)
    assert str(caught.value) == f"{name}: has the suffix {suffix}; give one of .ply, .splat, .spz, .glb, .4dgs, .sog"


def test_no_suffix_is_taken_twice_and_those_imported_can_be_read() -> None:
    assert len({one.suffix for one in FORMATS}) == len(FORMATS)
    assert IMPORTED == (".ply", ".splat", ".spz", ".glb", ".4dgs", ".sog")


STEPS = {  # steps of stored numbers: log-scale, colour, entry of a rotation's matrix, opacity
    "x.glb": (3e-6, 1e-6, 1e-6, 1e-6),
    "2.spz": (0.5 / 16 + 1e-6, 0.0037, 0.25, 0.5 / 255 + 1e-6),
    "3.spz": (0.5 / 16 + 1e-6, 0.0037, 0.006, 0.5 / 255 + 1e-6),
    "4.spz": (0.5 / 16 + 1e-6, 0.0037, 0.006, 0.5 / 255 + 1e-6),
}


@pytest.mark.parametrize("name", list(STEPS))
@given(seed=st.integers(0, 2**32 - 1), reach=st.floats(-4, 6))
@settings(max_examples=25, deadline=None)
def test_any_still_scene_comes_back_within_a_formats_steps(name: str, seed: int, reach: float) -> None:
    """Places too, at any distance: floats are kept, and fixed point is within half a step of 24 bits."""
    splats = statics(20, seed)
    splats = dataclasses.replace(splats, means=splats.means * np.float32(10**reach))
    scene = HybridScene(splats, (Segment(0.0, 0.0, DynamicSplats.empty()),))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        export(scene, path, version=int(name[0]) if name.endswith(".spz") else None)
        found = import_scene(path).scene.static
    scale, colour, turn, opacity = STEPS[name]
    largest = float(np.abs(splats.means).max())
    place = 0 if name == "x.glb" else max(0.5 / 4096, 1.01 * largest / 2**23)
    np.testing.assert_allclose(found.means, splats.means, rtol=1e-6, atol=place)
    np.testing.assert_allclose(found.log_scales, splats.log_scales, atol=scale)
    np.testing.assert_allclose(found.rgb, splats.rgb, atol=colour)
    np.testing.assert_allclose(axes_of(found.quats), axes_of(splats.quats), atol=turn)
    np.testing.assert_allclose(opacities_of(found.opacity_logits), opacities_of(splats.opacity_logits), atol=opacity)


@pytest.mark.parametrize("name", [*STEPS, "x.4dgs"])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_a_damaged_file_is_refused_or_read_and_nothing_else(name: str, seed: int) -> None:
    """One to four bytes replaced, or an end cut off."""
    if name.endswith(".4dgs"):
        pytest.importorskip("fourdgs", reason="fourdgs is not installed (extra 4dgs)")
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        export(SMALL, path, version=int(name[0]) if name.endswith(".spz") else None)
        data = bytearray(path.read_bytes())
        for at in rng.integers(0, min(len(data), 1500), rng.integers(0, 5)):
            data[at] = rng.integers(256)
        path.write_bytes(data[: rng.integers(len(data) // 2, 2 * len(data))])
        with contextlib.suppress(InputError):
            import_scene(path)


@pytest.mark.parametrize("suffix", [".ksplat", ".lcc", ".lcc2"])
def test_a_kind_that_another_program_reads_has_the_command_in_the_line(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"statue{suffix}"
    path.write_bytes(b"\0" * 64)
    with pytest.raises(InputError, match=rf"npx @playcanvas/splat-transform statue\{suffix} statue\.ply, and import"):
        import_scene(path)


@pytest.mark.parametrize(
    ("name", "data", "right"),
    [
        ("x.splat", b"ply\nformat ascii 1.0\n", ".ply"),
        ("x.ply", b"\x1f\x8b\x08\x00", ".spz"),
        ("x.ply", b"glTF\x02\0\0\0", ".glb"),
        ("x", b"ply\r\n", ".ply"),
    ],
)
def test_a_file_of_another_suffix_is_told_its_own(tmp_path: Path, name: str, data: bytes, right: str) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=rf"begins as a \{right} file; rename it to x\{right}$"):
        import_scene(tmp_path / name)


def test_an_archive_is_unpacked_by_the_command_in_the_line(tmp_path: Path) -> None:
    """Both commands were tried; an archive of pictures is a scene."""
    (tmp_path / "a statue.ply.gz").write_bytes(gzip.compress(b"ply"))
    with pytest.raises(InputError, match=r"is compressed; gunzip 'a statue\.ply\.gz', and import a statue\.ply$"):
        import_scene(tmp_path / "a statue.ply.gz")
    for held, line in (("statue.ply", r"unzip x\.zip, and import the file"), ("x/meta.json", r"rename it to x\.sog")):
        with zipfile.ZipFile(tmp_path / "x.zip", "w") as archive:
            archive.writestr(held, "{}")
        with pytest.raises(InputError, match=line):
            import_scene(tmp_path / "x.zip")


@pytest.mark.parametrize("name", ["X.PLY", "x.Splat", "x.SPZ"])
def test_suffixes_in_capitals_are_known(tmp_path: Path, name: str) -> None:
    export(SMALL, tmp_path / name)
    assert len(import_scene(tmp_path / name).scene.static) == 20
