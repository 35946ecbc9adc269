"""Given masks: moving values, matching cameras, and faults of a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from tests.hgs_core.capture import layouts
from tests.hgs_core.capture.conftest import write_masks


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "RGB", "RGBA", "I;16"])
def test_every_value_but_0_moves_in_every_kind_of_png(n3dv: Path, tmp_path: Path, mode: str) -> None:
    masks = write_masks(tmp_path / "masks" / "cam01")
    for path in (masks / "cam01").iterdir():
        with Image.open(path) as stored:
            values = np.array(stored)
        if mode == "P":
            image = Image.fromarray(values)
            image.putpalette([0, 0, 0] * 4)  # object numbers, whatever colours the palette gives them
        elif mode == "I;16":
            image = Image.fromarray(values.astype(np.uint16) * 100)
        else:
            image = Image.fromarray(np.minimum(values, 1) * 255).convert(mode)
        image.save(path)
    given = open_capture(n3dv, masks=masks).mask(1, 4)
    assert given is not None
    assert np.unique(np.argwhere(given)[:, 1]).tolist() == [8, 9, 10, 11]


@pytest.mark.parametrize("suffix", [".jpg", ".JPEG", ".PNG", ".jpg.png"])
def test_masks_called_otherwise_are_read(n3dv: Path, tmp_path: Path, suffix: str) -> None:
    """JPEG keeps no value exactly: dark moves no more than black."""
    masks = write_masks(tmp_path / "masks" / "cam01")
    truth = []
    for path in sorted((masks / "cam01").iterdir()):
        with Image.open(path) as stored:
            values = np.where(np.asarray(stored) > 0, 255, 20).astype(np.uint8)
        if suffix.lower().endswith(".png"):
            values[values == 20] = 0
        truth.append(values == 255)
        path.unlink()
        Image.fromarray(values).save(path.with_suffix(suffix), quality=100)
    capture = open_capture(n3dv, masks=masks)
    for frame, right in enumerate(truth):
        np.testing.assert_array_equal(capture.mask(capture.camera_index("cam01"), frame), right)


def test_cameras_without_a_folder_get_automatic_masks_and_a_note_says_so(n3dv: Path, tmp_path: Path) -> None:
    capture = open_capture(n3dv, masks=write_masks(tmp_path / "masks" / "cam01"))
    assert capture.mask(0, 0) is None
    masks = motion_masks(capture, [0, 1], progress=silent)
    assert masks.mask(0, 5).shape == (48, 64)
    assert masks.mask(1, 5).sum() == 5 * 48
    assert capture.notes == (f"the masks of cam01 are given, in {tmp_path / 'masks'}; those of cam00 are computed",)


@pytest.mark.parametrize("layout", ["n3dv", "panoptic"])
def test_a_folder_of_masks_replaces_the_capture_s_own(
    layout: str, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    root: Path = request.getfixturevalue(layout)
    name = open_capture(root).cameras[1].name
    write_masks(root / "masks" / "cam00")  # the N3DV capture's own
    before = open_capture(root)
    capture = open_capture(root, masks=write_masks(tmp_path / "other" / name))
    assert before.mask(0, 2) is not None
    assert capture.mask(0, 2) is None
    mask = capture.mask(1, 2)
    assert mask is not None
    assert mask.sum() == 2 * 48
    assert capture.fingerprint() != before.fingerprint()


def test_masks_are_part_of_the_fingerprint(n3dv: Path) -> None:
    plain = open_capture(n3dv).fingerprint()
    masks = write_masks(n3dv / "masks" / "cam00")
    given = open_capture(n3dv).fingerprint()
    assert given == open_capture(n3dv, masks=masks).fingerprint() != plain
    Image.new("L", (64, 48), 1).save(masks / "cam00" / "00003.png", compress_level=0)
    assert open_capture(n3dv).fingerprint() not in (given, plain)


def test_a_missing_frame_is_told_with_the_cure(n3dv: Path, tmp_path: Path) -> None:
    masks = write_masks(tmp_path / "masks" / "cam00", frames=range(1, 7))
    with pytest.raises(InputError, match=r"cam00: the mask of frame 0 is missing; call masks like the pictures or"):
        open_capture(n3dv, masks=masks)


def test_masks_are_called_like_their_pictures_or_numbered_from_0(panoptic: Path, tmp_path: Path) -> None:
    """Pictures that are numbered from 1 have masks of the same names; those that `hgs masks` writes begin at 0."""
    meta = (panoptic / "train_meta.json").read_text()
    for frame in reversed(range(6)):
        for folder, ending in (("ims/3", "jpg"), ("seg/3", "png")):
            path = panoptic / folder / f"{frame:06d}.{ending}"
            path.rename(path.with_stem(f"{frame + 1:06d}"))
            meta = meta.replace(f"3/{frame:06d}.jpg", f"3/{frame + 1:06d}.jpg")
    (panoptic / "train_meta.json").write_text(meta)
    own = open_capture(panoptic).mask(0, 2)
    assert own is not None
    assert np.argwhere(own)[0].tolist() == [10, 2]
    written = open_capture(panoptic, masks=write_masks(tmp_path / "masks" / "3")).mask(0, 2)
    assert written is not None
    assert written.sum() == 2 * 48


def test_masks_of_straight_pictures_are_taken_as_they_are(tmp_path: Path) -> None:
    """As `hgs masks` writes them; those of the pictures on disk are straightened."""
    layouts.colmap(True, model="OPENCV", bends=(0.15, 0.0, 0.0, 0.0))(tmp_path)
    layouts.PICTURES["videos"](tmp_path)
    camera = open_capture(tmp_path).cameras[0]
    assert (camera.width, camera.height) != (layouts.WIDTH, layouts.HEIGHT)
    for size, columns in (((camera.width, camera.height), 5), ((layouts.WIDTH, layouts.HEIGHT), 4)):
        for frame in range(layouts.FRAMES):
            values = np.zeros((size[1], size[0]), np.uint8)
            values[:, :5] = 255
            path = tmp_path / "masks" / "cam01" / f"{frame:04d}.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            Image.fromarray(values).save(path)
        mask = open_capture(tmp_path).mask(0, 1)
        assert mask is not None
        assert mask.shape == (camera.height, camera.width)
        assert mask[camera.height // 2].sum() == columns


def test_a_mask_of_another_size_is_named(n3dv: Path, tmp_path: Path) -> None:
    masks = write_masks(tmp_path / "masks" / "cam00", size=(32, 24))
    resize = r"mogrify -filter point -resize '64x48!' \S+masks/cam00/\*\.png \(ImageMagick\)$"
    with pytest.raises(InputError, match=rf"00000\.png: the mask is 32x24; camera cam00 needs 64x48; {resize}"):
        open_capture(n3dv, masks=masks)
    Image.new("L", (64, 48)).save(masks / "cam00" / "00000.png")
    with pytest.raises(InputError, match=r"00001\.png: the mask is 32x24"):
        open_capture(n3dv, masks=masks)
    Image.new("L", (64, 64)).save(masks / "cam00" / "00001.png")
    with pytest.raises(InputError, match=r"00001\.png: the mask is 64x64; .*; make masks of these pictures$"):
        open_capture(n3dv, masks=masks)


def test_an_unreadable_mask_is_named(n3dv: Path, tmp_path: Path) -> None:
    masks = write_masks(tmp_path / "masks" / "cam00")
    whole = (masks / "cam00" / "00004.png").read_bytes()
    (masks / "cam00" / "00004.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"00004\.png: the picture is unreadable"):
        open_capture(n3dv, masks=masks).mask(0, 4)


def test_a_folder_without_masks_of_the_capture_is_refused(n3dv: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere: the folder does not exist"):
        open_capture(n3dv, masks=tmp_path / "nowhere")
    masks = write_masks(tmp_path / "masks" / "camera0")
    with pytest.raises(InputError, match=r"no masks of this capture; .* each camera of cam00, cam01"):
        open_capture(n3dv, masks=masks)


@pytest.mark.parametrize(
    ("called", "shown"),
    [
        ([0, 1, 2, 5, 6], [0, 1, 2, 5, 6]),  # the pictures' numbers
        (range(8), [0, 1, 2, 5, 6]),  # the same, and two of no picture
        (range(5), [0, 1, 2, 3, 4]),  # places, the form of hgs masks
    ],
)
def test_masks_follow_the_numbers_of_pictures_that_have_a_gap(
    tmp_path: Path, called: Sequence[int], shown: list[int]
) -> None:
    layouts.easymocap(tmp_path)
    size = (layouts.WIDTH, layouts.HEIGHT)
    for name in layouts.NAMES:
        (tmp_path / "images" / name).mkdir(parents=True)
        for number in (0, 1, 2, 5, 6) if name == layouts.NAMES[1] else range(8):
            Image.new("RGB", size).save(tmp_path / "images" / name / f"frame_{number:04d}.png")
    write_masks(tmp_path / "masks" / layouts.NAMES[1], frames=called, size=size)
    capture = open_capture(tmp_path)
    masks = [capture.mask(1, tick) for tick in range(len(capture.times))]
    assert [int(mask.sum()) // layouts.HEIGHT for mask in masks if mask is not None] == shown
