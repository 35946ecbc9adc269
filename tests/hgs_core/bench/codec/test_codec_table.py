from __future__ import annotations

from hgs_core.bench.codec.codec_bench import CodecPoint, CodecReport
from hgs_core.bench.codec.codec_errors import StaticErrors
from hgs_core.bench.codec.codec_table import codec_text

MACHINE = {"cpu": "Fast One", "cores": 4, "load": 0.5}
DEFAULT = CodecPoint("default", 0.7071, 0.5, 12_000, 3_000, 1_000, 100, 0.0987, 0.0911, 0.1234, 2.0)
STILL = CodecPoint("", 2.8, 1.0, 900, 0, 300, 0, 0.5, None, None, 0.04)
ERRORS = {"spz 3": StaticErrors(7.05e-5, 0.018, 0.001, 0.0011, 0.0021)}
REPORT = CodecReport(
    MACHINE,
    "studio",
    1_234,
    567,
    (DEFAULT,),
    (STILL,),
    0.25,
    3.5,
    {"static": 2.34e7},
    65_536,
    {"spz 3": 20_480},
    ERRORS,
)


def line(text: str, start: str) -> str:
    (found,) = [line for line in text.splitlines() if line.startswith(start)]
    return found


def test_an_encoding_has_its_bytes_by_kind_and_by_splat_kept() -> None:
    assert line(codec_text(REPORT), "default").split() == [
        "default",
        "0.707",
        "0.354",
        "1,000",
        "12,000",
        "12.0",
        "100",
        "3,000",
        "30.0",
        "15,000",
        "0.099",
        "0.091",
        "0.123",
        "2.0",
    ]


def test_what_there_is_none_of_is_a_dash() -> None:
    assert line(codec_text(REPORT), "-").split() == [
        "-",
        "2.8",
        "2.8",
        "300",
        "900",
        "3.0",
        "0",
        "0",
        "-",
        "900",
        "0.500",
        "-",
        "-",
        "0.0",
    ]


def test_other_formats_errors_prefixes_and_rates_are_said() -> None:
    text = codec_text(REPORT)
    assert line(text, "Fast One") == "Fast One, 4 cores, load 0.5"
    assert line(text, "studio") == "studio: 1,234 static and 567 dynamic splats"
    assert line(text, ".splatv").endswith("65,536 bytes")
    assert line(text, "spz 3:") == "spz 3: 20,480 bytes"
    assert line(text, "spz 3  ").split() == ["spz", "3", "7.05e-05", "0.018", "0.001", "0.0011", "0.0021"]
    assert "0.25 dB lost in order of the manifest, 3.50 dB shuffled" in line(text, "a quarter")
    assert line(text, "decoding") == "decoding by one core: static 23.4 M splats/s"
