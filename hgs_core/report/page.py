"""The whole page: header, sections, and the style and script inside it. It asks no server for anything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from hgs_core.base.wording import counted
from hgs_core.check.findings import CaptureCheck
from hgs_core.report.chart_sections import (
    comparison_section,
    decomposition_section,
    quality_section,
    training_section,
)
from hgs_core.report.check_section import PairPictures, check_section
from hgs_core.report.codec_section import codec_section
from hgs_core.report.key_figures import config_changes, key_figures
from hgs_core.report.larger_pictures import LargerPictures
from hgs_core.report.larger_section import larger_section
from hgs_core.report.markup import note, pairs, section, table
from hgs_core.report.picture_section import picture_section
from hgs_core.report.pictures import CameraPictures
from hgs_core.report.scene_sizes import ChunkSize
from hgs_core.report.size_section import size_section
from hgs_core.report.sources import FinishedRun

__all__ = ["PageContent", "report_page"]

_SECTIONS = {
    "check": "The capture",
    "pictures": "Pictures",
    "larger": "Larger screens",
    "quality": "Quality",
    "training": "Training",
    "decomposition": "What moves",
    "size": "Size",
    "rate": "Bytes against loss",
    "comparison": "Other runs",
    "settings": "Settings",
}
# No request leaves the page, whatever its parts may hold.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"


@dataclass(frozen=True)
class PageContent:
    """All that a page shows."""

    run: FinishedRun
    others: Sequence[FinishedRun]
    cameras: Sequence[CameraPictures]
    no_pictures: str  # why there are none
    times: Sequence[float]  # seconds of the capture's frames; empty if the capture is gone
    chunks: Sequence[ChunkSize]
    machine: Mapping[str, object]  # the machine of this page, with the version of this software
    check: CaptureCheck | None = None  # check of the capture, before the training
    checked: Sequence[PairPictures] = ()
    larger: Sequence[LargerPictures] = ()


def report_page(content: PageContent) -> str:
    """Return the HTML document."""
    run = content.run
    here = Path(__file__)
    style, script = here.with_name("page.css").read_text(), here.with_name("page.js").read_text()
    sections = [
        check_section(content.check, content.checked),
        picture_section(run, content.cameras, content.no_pictures),
        larger_section(run, content.larger),
        quality_section(run, content.cameras, content.times),
        training_section(run),
        decomposition_section(run, content.cameras),
        size_section(run, content.chunks),
        codec_section(run.folder.path / "codec.json"),
        comparison_section(run, content.others),
        _settings(content),
    ]
    title = escape(f"{run.name}: {run.manifest.title}")
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f'<title>{title}</title><link rel="icon" href="data:,">',
            f"<style>{style}</style></head><body>",
            _header(content),
            "<main>",
            *sections,
            f"</main><script>{script}</script></body></html>\n",
        ]
    )


def _header(content: PageContent) -> str:
    run = content.run
    cameras = run.manifest.cameras
    sizes = sorted({f"{camera.width}x{camera.height}" for camera in cameras})
    frames = run.scores.get("frames") or len(content.times)
    held_out = ", ".join(run.spec.config.capture.hold_out) or "none"
    changed = len(config_changes(run.spec.config))
    facts = [
        f"{run.manifest.title}: {counted(len(cameras), 'camera')}, {', '.join(sizes)}"
        + (f", {counted(frames, 'frame')}" if frames else "")
        + f", {run.manifest.end - run.manifest.start:.2f} s; held out: {held_out}.",
        f"Preset {run.spec.config.preset}"
        + (f", {changed} setting{'s' * (changed > 1)} changed." if changed else ", unchanged."),
        *([f"Trained by {_summary(run.machine)}."] if run.machine else []),
        f"This page: {_summary(content.machine)}.",
    ]
    tiles = "".join(
        f'<div data-figure="{figure.key}"><dt>{escape(figure.label)}</dt>'
        f'<dd class="value">{escape(figure.value)}<small>{escape(figure.unit)}</small></dd>'
        + (f'<dd class="remark">{escape(figure.note)}</dd>' if figure.note else "")
        + "</div>"
        for figure in key_figures(run)
    )
    links = "".join(f'<a href="#{anchor}">{title}</a>' for anchor, title in _SECTIONS.items())
    scored = ", ".join(map(str, run.scores.get("cameras", [])))
    which = f"Scores are means over all frames of {scored}." if scored else "Nothing was scored."
    if "lens_falloff" in run.scores and not run.learned_lens:
        which += " Training learned no lens falloff, so the scores through the mean lens are the same."
    if run.seen:
        which += f" Training saw {', '.join(sorted(run.seen))}."
    if run.unscored:
        which += f" {run.unscored}."
    return (
        f"<header><h1>{escape(run.name)}</h1>"
        + "".join(f'<p class="facts">{escape(words)}</p>' for words in facts)
        + f'<dl class="figures">{tiles}</dl>{note(which)}<nav aria-label="Sections">{links}</nav></header>'
    )


def _summary(machine: Mapping[str, object]) -> str:
    """Return a machine in words; fields that a damaged file lacks are unknown."""
    version, cpu, cores = (machine.get(name, "unknown") for name in ("hgs", "cpu", "cores"))
    return f"HGS {version} on {cpu}, {cores} cores"


def _settings(content: PageContent) -> str:
    run = content.run
    changes = config_changes(run.spec.config)
    facts: dict[str, object] = {"capture": run.spec.capture, "fingerprint": run.spec.fingerprint}
    for what, machine in (("trained by", run.machine), ("this page by", content.machine)):
        facts |= {f"{what}, {name.replace('_', ' ')}": value for name, value in machine.items() if value}
    parts = [pairs({name: str(value) for name, value in facts.items()})]
    if changes:
        head = ("setting", f"preset {run.spec.config.preset}", "this run")
        parts.append(table("Settings that differ from the preset", head, changes))
    else:
        parts.append(note(f"All settings are those of the preset {run.spec.config.preset}."))
    if not run.machine:
        parts.append(note("This run did not record the machine it was trained on."))
    return section("settings", "Settings", parts)
