"""Pictures are turned and stretched to the calibration's size, with a note."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image, ImageOps

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.layouts import HEIGHT, NAMES, WIDTH

RAMP = np.stack(
    np.broadcast_arrays(np.arange(WIDTH)[None] * 5, np.arange(HEIGHT)[:, None] * 7, np.array([[40]])), axis=2
).astype(np.uint8)
BACK = {
    1: None,
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_90,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_270,
}


def write_turned(root: Path, orientations: dict[str, int], upright: np.ndarray = RAMP) -> None:
    """Write two pictures for each camera, stored as a camera in that position would, with the tag that says so."""
    for name in NAMES:
        folder = root / "images" / name
        folder.mkdir(parents=True, exist_ok=True)
        orientation = orientations.get(name, 1)
        turn = BACK[orientation]
        image = Image.fromarray(upright)
        image = image if turn is None else image.transpose(turn)
        exif = Image.Exif()
        exif[274] = orientation
        for frame in range(2):
            image.save(folder / f"{frame}.png", exif=exif)


def write_cameras(root: Path, size: tuple[int, int]) -> None:
    text = layouts.calibration_tables("cameras.").replace(f"[{WIDTH}, {HEIGHT}]", f"[{size[0]}, {size[1]}]")
    (root / "camera_array.toml").write_text(text)


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_pictures_on_their_side_are_turned_if_upright_ones_were_calibrated(tmp_path: Path, orientation: int) -> None:
    write_cameras(tmp_path, (WIDTH, HEIGHT))
    write_turned(tmp_path, {NAMES[1]: orientation})
    capture = open_capture(tmp_path)
    np.testing.assert_array_equal(capture.frame(1, 1), RAMP)
    said = f"{NAMES[1]}: pictures are turned as EXIF says (orientation {orientation}): so they were calibrated"
    assert said in capture.notes


@pytest.mark.parametrize("orientation", [5, 6, 7, 8])
def test_pictures_on_their_side_stay_so_if_they_were_calibrated_so(tmp_path: Path, orientation: int) -> None:
    write_cameras(tmp_path, (HEIGHT, WIDTH))
    write_turned(tmp_path, dict.fromkeys(NAMES, orientation))
    capture = open_capture(tmp_path)
    assert capture.frame(0, 0).shape == (WIDTH, HEIGHT, 3)
    np.testing.assert_array_equal(
        np.array(ImageOps.exif_transpose(Image.open(tmp_path / "images" / NAMES[0] / "0.png"))), RAMP
    )
    assert (
        f"{', '.join(NAMES)}: EXIF's orientation {orientation} is left aside: pictures were calibrated as stored"
        in (capture.notes)
    )


@pytest.mark.parametrize("orientation", [2, 3, 4])
def test_where_no_size_tells_pictures_stay_as_stored_and_a_line_says_how_to_turn_them(
    tmp_path: Path, orientation: int
) -> None:
    write_cameras(tmp_path, (WIDTH, HEIGHT))
    write_turned(tmp_path, {NAMES[2]: orientation})
    capture = open_capture(tmp_path)
    with Image.open(tmp_path / "images" / NAMES[2] / "0.png") as stored:
        np.testing.assert_array_equal(capture.frame(2, 0), np.array(stored))
    (said,) = [note for note in capture.notes if "orientation" in note]
    assert said.startswith(f"{NAMES[2]}: pictures are taken as stored, though EXIF says orientation {orientation}")
    assert "mogrify -auto-orient" in said


def test_one_camera_whose_size_tells_speaks_for_the_others(tmp_path: Path) -> None:
    write_cameras(tmp_path, (WIDTH, HEIGHT))
    write_turned(tmp_path, {NAMES[1]: 6, NAMES[2]: 3})
    capture = open_capture(tmp_path)
    np.testing.assert_array_equal(capture.frame(2, 0), RAMP)
    np.testing.assert_array_equal(capture.frame(1, 0), RAMP)


def test_square_pictures_stay_as_stored(tmp_path: Path) -> None:
    write_cameras(tmp_path, (HEIGHT, HEIGHT))
    write_turned(tmp_path, {NAMES[0]: 6}, RAMP[:, :HEIGHT])
    assert any("taken as stored" in note for note in open_capture(tmp_path).notes)


def test_masks_of_turned_pictures_are_upright(tmp_path: Path) -> None:
    write_cameras(tmp_path, (WIDTH, HEIGHT))
    write_turned(tmp_path, {NAMES[1]: 6})
    (tmp_path / "masks" / NAMES[1]).mkdir(parents=True)
    for frame in range(2):
        Image.fromarray((RAMP[..., 0] > 100).astype(np.uint8)).save(tmp_path / "masks" / NAMES[1] / f"{frame}.png")
    mask = open_capture(tmp_path).mask(1, 0)
    assert mask is not None
    np.testing.assert_array_equal(mask, RAMP[..., 0] > 100)


def write_anamorphic(root: Path, aspect: Fraction, width: int) -> None:
    for name in NAMES:
        with av.open(str(root / f"{name}.mp4"), "w") as container:
            stream = container.add_stream("libx264", rate=30, options={"crf": "0"})
            stream.width, stream.height, stream.pix_fmt = width, HEIGHT, "yuv444p"
            stream.codec_context.sample_aspect_ratio = aspect
            picture = np.array(Image.fromarray(RAMP).resize((width, HEIGHT), Image.Resampling.BOX))
            for _ in range(3):
                container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
            container.mux(stream.encode())


def test_pixels_that_are_not_square_are_stretched_if_square_ones_were_calibrated(tmp_path: Path) -> None:
    write_cameras(tmp_path, (WIDTH, HEIGHT))
    write_anamorphic(tmp_path, Fraction(4, 3), 36)
    capture = open_capture(tmp_path)
    assert np.abs(capture.frame(0, 0).astype(int) - RAMP)[2:-2, 2:-2].mean() < 4
    assert f"{', '.join(NAMES)}: pixels of 4/3 are stretched to {WIDTH}x{HEIGHT} square ones" in capture.notes


def test_pixels_that_are_not_square_stay_if_they_were_calibrated_so(tmp_path: Path) -> None:
    write_cameras(tmp_path, (36, HEIGHT))
    write_anamorphic(tmp_path, Fraction(4, 3), 36)
    capture = open_capture(tmp_path)
    assert capture.frame(0, 0).shape == (HEIGHT, 36, 3)
    assert not any("pixels" in note for note in capture.notes)


def test_a_shape_that_is_neither_is_refused(tmp_path: Path) -> None:
    write_cameras(tmp_path, (WIDTH * 2, HEIGHT))
    write_anamorphic(tmp_path, Fraction(4, 3), 36)
    with pytest.raises(InputError, match="scale pictures without cropping"):
        open_capture(tmp_path)
