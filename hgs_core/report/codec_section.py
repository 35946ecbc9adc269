"""The section on bytes and quality, measured by `hgs bench codec RUN --json RUN/codec.json`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.report.charts import Series, line_chart
from hgs_core.report.markup import chart, note, section

__all__ = ["codec_section"]


def codec_section(file: Path) -> str:
    """Return the section: loss of quality over kilobytes, from the file, or how to make it.

    Raises:
        InputError: the file is not what the benchmark writes.
    """
    if not file.is_file():
        return section("rate", "Bytes against loss", [note("hgs bench codec RUN --json RUN/codec.json measures it.")])
    try:
        report: dict[str, Any] = json.loads(file.read_bytes())
        points = sorted([*report["sweep"], *report["budgets"]], key=lambda point: float(point["coarseness"]))
        kilobytes = [(int(point["bytes_static"]) + int(point["bytes_dynamic"])) / 1e3 for point in points]
        seen = [float(point["loss"]) for point in points]
        unseen = [point["loss_held_out"] for point in points]
        splatv = int(report["bytes_splatv"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(file, f"unreadable ({error!r})", "measure it again with hgs bench codec") from error
    lines = [Series("training views", kilobytes, seen, 0)]
    if all(isinstance(loss, float) for loss in unseen):
        lines.append(Series("cameras held out", kilobytes, unseen, 1))
    svg = line_chart("Loss of PSNR by kilobytes", lines, "kB", "loss, dB", unit=" dB")
    words = f"Against the float32 scene, by coarseness; 1 kB is 1,000 bytes. As .splatv: {splatv / 1e3:,.0f} kB."
    return section("rate", "Bytes against loss", [f'<div class="charts">{chart("Loss of encoding", svg, words)}</div>'])
