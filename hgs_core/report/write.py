"""Making the report of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback
from hgs_core.check.findings import CaptureCheck
from hgs_core.native.machine import machine_facts
from hgs_core.report.check_section import PairPictures
from hgs_core.report.larger_pictures import LargerPictures, draw_larger_pictures
from hgs_core.report.page import PageContent, report_page
from hgs_core.report.pictures import CameraPictures, draw_pictures, picture_of
from hgs_core.report.scene_sizes import chunk_sizes
from hgs_core.report.sources import read_run

__all__ = ["write_report"]


def write_report(run: Path, out: Path, against: Sequence[Path], progress: ProgressCallback) -> None:
    """Write the page of a finished run to the file `out`; without its capture the page has no pictures.

    Runs that were not measured yet are measured first.

    Args:
        run: the run's folder.
        out: the HTML file; replaced if it is there.
        against: folders of finished runs to compare with.
        progress: told of measuring and drawing.

    Raises:
        InputError: a run is not finished, a file of it or of the capture is damaged, or `out` is a folder.
    """
    if out.is_dir():
        raise InputError(out, "is a folder", "give a file for --out")
    finished, *others = [read_run(path, progress) for path in (run, *against)]
    chunks = chunk_sizes(finished.folder, finished.manifest)
    cameras: list[CameraPictures] = []
    larger: list[LargerPictures] = []
    times: list[float] = []
    reason = ""
    check = CaptureCheck.load(finished.folder.check) if finished.folder.check.exists() else None
    checked: list[PairPictures] = []
    try:
        capture = finished.folder.open_capture(finished.spec)
    except InputError as error:
        reason = f"{error.where}: {error.problem}"
    else:
        times = [float(seconds) for seconds in capture.times]
        cameras = draw_pictures(finished, capture, progress)
        larger = draw_larger_pictures(finished, capture, [one.camera for one in cameras], progress)
        if check is not None:
            checked = [
                PairPictures(pair, *(picture_of(capture, name, pair.frame) for name in pair.cameras))
                for pair in check.shown
            ]
    content = PageContent(finished, others, cameras, reason, times, chunks, machine_facts(), check, checked, larger)
    write_bytes(out, report_page(content).encode())
