"""Pictures of strangers: their alpha, orientation and depth are heeded, and every fault is an InputError."""

from __future__ import annotations

import io
import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image, ImageOps

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture_file import PictureHeader, has_transparency, read_header, read_pixels

RANDOM = np.random.default_rng(0)
COLOURS = RANDOM.integers(0, 256, (6, 8, 3)).astype(np.uint8)
ALPHA = RANDOM.integers(0, 256, (6, 8)).astype(np.uint8)


def composited(image: Image.Image) -> np.ndarray:
    over = image.convert("RGBA")
    return np.array(Image.alpha_composite(Image.new("RGBA", over.size, (0, 0, 0, 255)), over).convert("RGB"))


def with_transparency(kind: str) -> Image.Image:
    if kind == "RGBA":
        return Image.fromarray(np.dstack([COLOURS, ALPHA]))
    if kind == "LA":
        return Image.merge("LA", (Image.fromarray(COLOURS[..., 0]), Image.fromarray(ALPHA)))
    palette = Image.fromarray(COLOURS).quantize(8)
    palette.info["transparency"] = bytes(range(0, 256, 32))
    return palette


@pytest.mark.parametrize("kind", ["RGBA", "LA", "P"])
@pytest.mark.parametrize("ending", ["png", "webp", "tif"])
def test_what_is_transparent_is_black(tmp_path: Path, kind: str, ending: str) -> None:
    if kind == "P" and ending == "tif":
        pytest.skip("TIFF has no transparent palettes")
    path = tmp_path / f"a.{ending}"
    image = with_transparency(kind).convert("RGBA") if ending == "webp" else with_transparency(kind)
    if ending == "webp":
        image.save(path, lossless=True, exact=True)
    else:
        image.save(path)
    with Image.open(path) as stored:
        expected = composited(stored)
    assert read_header(path).transparent
    assert has_transparency(path)
    np.testing.assert_array_equal(read_pixels(path), expected)


def chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(width: int, height: int, depth: int, kind: int, rows: bytes, *extra: bytes) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    chunks = chunk(b"IHDR", header) + b"".join(extra) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + chunks


@pytest.mark.parametrize(("kind", "channels"), [(6, 4), (4, 2)])
def test_transparency_of_16_bits(tmp_path: Path, kind: int, channels: int) -> None:
    values = RANDOM.integers(0, 65536, (6, 8, channels)).astype(">u2")
    rows = b"".join(b"\0" + row.tobytes() for row in values)
    (tmp_path / "a.png").write_bytes(png(8, 6, 16, kind, rows))
    with Image.open(tmp_path / "a.png") as stored:
        expected = composited(stored)
    np.testing.assert_array_equal(read_pixels(tmp_path / "a.png"), expected)


def test_one_colour_that_is_transparent(tmp_path: Path) -> None:
    for kind, depth, clear in ((2, 8, (10, 20, 30)), (0, 8, (10,)), (0, 16, (10,))):
        values = np.array([*clear, *[200] * len(clear)], ">u2" if depth == 16 else np.uint8)
        row = b"\0" + values.tobytes()
        mark = chunk(b"tRNS", struct.pack(f">{len(clear)}H", *clear))
        (tmp_path / "a.png").write_bytes(png(2, 1, depth, kind, row, mark))
        shown = read_pixels(tmp_path / "a.png")[0]
        assert shown[0].tolist() == [0, 0, 0]
        assert shown[1].tolist() == ([200] * 3 if depth == 8 else [1] * 3)


def test_a_full_alpha_channel_is_no_transparency(tmp_path: Path) -> None:
    Image.fromarray(np.dstack([COLOURS, np.full((6, 8), 255, np.uint8)])).save(tmp_path / "a.png")
    assert not has_transparency(tmp_path / "a.png")
    np.testing.assert_array_equal(read_pixels(tmp_path / "a.png"), COLOURS)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "webp"])
def test_every_orientation_as_stored_and_upright(tmp_path: Path, ending: str, orientation: int) -> None:
    exif = Image.Exif()
    exif[274] = orientation
    path = tmp_path / f"a.{ending}"
    Image.fromarray(COLOURS).save(path, exif=exif, lossless=True)
    header = read_header(path)
    assert (header.size, header.orientation) == ((8, 6), orientation)
    assert header.upright == ((6, 8) if orientation > 4 else (8, 6))
    stored, upright = read_pixels(path), read_pixels(path, upright=True)
    assert np.abs(stored.astype(int) - COLOURS).max() <= (255 if ending == "jpg" else 0)
    image = Image.fromarray(stored)
    image.getexif()[274] = orientation
    np.testing.assert_array_equal(upright, np.array(ImageOps.exif_transpose(image)))


@pytest.mark.parametrize("value", [0, 9, 65535])
def test_an_orientation_that_there_is_not_is_none(tmp_path: Path, value: int) -> None:
    exif = Image.Exif()
    exif[274] = value
    Image.fromarray(COLOURS).save(tmp_path / "a.jpg", exif=exif)
    assert read_header(tmp_path / "a.jpg") == PictureHeader((8, 6))


def test_damaged_tags_leave_a_picture_whole(tmp_path: Path) -> None:
    Image.fromarray(COLOURS).save(tmp_path / "a.jpg", exif=b"Exif\0\0MM\0*\0\0\0\x08\0\x05\x01\x12\0\x03\0\0\0\x01")
    assert read_header(tmp_path / "a.jpg") == PictureHeader((8, 6))
    assert read_pixels(tmp_path / "a.jpg", upright=True).shape == (6, 8, 3)


def test_colours_of_print_are_shown(tmp_path: Path) -> None:
    Image.fromarray(COLOURS).convert("CMYK").save(tmp_path / "a.jpg", quality=100)
    with Image.open(tmp_path / "a.jpg") as stored:
        expected = np.array(stored.convert("RGB"))
    np.testing.assert_array_equal(read_pixels(tmp_path / "a.jpg"), expected)


@pytest.mark.parametrize("side", [60_000, 2**31 - 1])
def test_a_header_that_announces_too_much_is_refused_before_decoding(tmp_path: Path, side: int) -> None:
    path = tmp_path / "a.png"
    path.write_bytes(png(side, side, 8, 2, b""))
    for look in (read_header, read_pixels):
        with pytest.raises(InputError, match=r"a\.png: the picture announces .*pixels.*; give one of at most"):
            look(path)


def test_other_formats_announce_too_much_in_vain(tmp_path: Path) -> None:
    (tmp_path / "a.bmp").write_bytes(
        b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + struct.pack("<IiiHHIIiiII", 40, 60_000, 60_000, 1, 24, *[0] * 6)
    )
    (tmp_path / "a.ppm").write_bytes(b"P6 60000 60000 255\n")
    (tmp_path / "a.tga").write_bytes(struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 60_000, 60_000, 24, 0))
    for path in tmp_path.iterdir():
        with pytest.raises(InputError, match="announces"):
            read_header(path)


def test_pictures_of_up_to_160_million_pixels_are_read_without_a_warning(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(png(12_000, 12_000, 1, 0, b""))
    assert read_header(tmp_path / "a.png").size == (12_000, 12_000)


@pytest.mark.parametrize("ending", ["png", "webp"])
def test_animations_are_refused_with_the_command_that_takes_them_apart(tmp_path: Path, ending: str) -> None:
    pictures = [Image.new("RGB", (32, 32), (level, 0, 0)) for level in (0, 90, 180)]
    pictures[0].save(tmp_path / f"a.{ending}", save_all=True, append_images=pictures[1:])
    with pytest.raises(InputError, match=r"an animation of 3 pictures; store each as a picture of its own, .*%04d"):
        read_header(tmp_path / f"a.{ending}")


def test_pages_are_counted_and_the_first_is_read(tmp_path: Path) -> None:
    pictures = [Image.new("RGB", (32, 32), (level, 0, 0)) for level in (90, 180)]
    pictures[0].save(tmp_path / "a.tif", save_all=True, append_images=pictures[1:])
    assert read_header(tmp_path / "a.tif").pictures == 2
    assert read_pixels(tmp_path / "a.tif")[0, 0].tolist() == [90, 0, 0]


@pytest.mark.parametrize(
    ("head", "kind"),
    [
        (b"\0\0\0\x18ftypheic\0\0\0\0mif1heic", "HEIC"),
        (b"\0\0\0\x18ftypavif\0\0\0\0mif1avif", "AVIF"),
        (b"GIF89a\1\0\1\0", "GIF"),
    ],
)
@pytest.mark.parametrize(("ending", "into"), [("png", "png"), ("JPG", "jpg"), ("heic", "png")])
def test_other_kinds_of_picture_are_called_by_name_with_the_command_that_converts(
    tmp_path: Path, head: bytes, kind: str, ending: str, into: str
) -> None:
    (tmp_path / f"a.{ending}").write_bytes(head + bytes(200))
    with pytest.raises(InputError, match=rf"is {kind}, and PNG, .*; .*: mogrify -format {into} \*\.{ending}"):
        read_header(tmp_path / f"a.{ending}")


def test_no_file_is_given_to_ghostscript(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from PIL import EpsImagePlugin

    def run(*_: object, **__: object) -> None:
        raise AssertionError("Ghostscript was called")

    monkeypatch.setattr(EpsImagePlugin, "Ghostscript", run)
    (tmp_path / "a.png").write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 6\n%%EndComments\n")
    with pytest.raises(InputError, match="of no known kind"):
        read_pixels(tmp_path / "a.png")


def test_damaged_pictures_are_called_unreadable(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    with pytest.raises(InputError, match="is missing"):
        read_header(path)
    for data in (b"", b"\x89PNG\r\n\x1a\n", b"\0" * 100):
        path.write_bytes(data)
        with pytest.raises(InputError):
            read_header(path)
    noise = Image.fromarray(RANDOM.integers(0, 256, (60, 80, 3)).astype(np.uint8))
    noise.save(path)
    path.write_bytes(path.read_bytes()[:5_000])
    with pytest.raises(InputError, match="unreadable"):
        read_pixels(path)


def stored(ending: str, mode: str) -> bytes:
    file = io.BytesIO()
    exif = Image.Exif()
    exif[274] = 6
    Image.fromarray(COLOURS).convert(mode).save(file, ending, exif=exif)
    return file.getvalue()


FILES: dict[str, Callable[[], bytes]] = {
    "PNG": lambda: stored("PNG", "RGBA"),
    "JPEG": lambda: stored("JPEG", "RGB"),
    "TIFF": lambda: stored("TIFF", "RGB"),
    "WEBP": lambda: stored("WEBP", "RGBA"),
    "BMP": lambda: stored("BMP", "RGB"),
    "PPM": lambda: stored("PPM", "RGB"),
    "TGA": lambda: stored("TGA", "RGBA"),
    "JPEG2000": lambda: stored("JPEG2000", "RGB"),
}


@settings(max_examples=150, deadline=None)
@given(kind=st.sampled_from(sorted(FILES)), seed=st.integers(0, 2**32), cut=st.booleans())
def test_no_damage_does_more_than_make_a_picture_unreadable(
    tmp_path_factory: pytest.TempPathFactory, kind: str, seed: int, cut: bool
) -> None:
    chance = random.Random(seed)
    data = bytearray(FILES[kind]())
    for _ in range(chance.randint(1, 8)):
        data[chance.randrange(len(data))] = chance.choice((0, 1, 127, 128, 255, chance.randrange(256)))
    if cut:
        del data[chance.randrange(len(data)) :]
    path = tmp_path_factory.mktemp("damaged") / "a.png"
    path.write_bytes(data)
    for look in (read_header, read_pixels, has_transparency):
        try:
            look(path)
        except InputError as error:
            assert error.cure  # noqa: PT017
