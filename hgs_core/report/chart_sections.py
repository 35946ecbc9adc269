"""The sections made of charts: quality over time, training, motion, time and other runs."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hgs_core.report.charts import Bar, Part, Point, Series, TopAxis, bar_chart, line_chart, scatter_chart
from hgs_core.report.key_figures import megabytes, per_frames
from hgs_core.report.markup import chart, note, section, table
from hgs_core.report.pictures import CameraPictures
from hgs_core.report.sources import FinishedRun, History

__all__ = ["comparison_section", "decomposition_section", "quality_section", "training_section"]

_MOST_BARS = 40  # cameras
_QUALITY = {
    "PSNR, dB": "psnr",
    "where it moves": "psnr_dynamic",
    "through the mean lens": "psnr_rig",
    "SSIM": "ssim",
    "SSIM where it moves": "ssim_dynamic",
}
"""Title of a column and the score in it."""


def quality_section(run: FinishedRun, cameras: Sequence[CameraPictures], times: Sequence[float]) -> str:
    """Return PSNR over time and by camera; `times` are the frames' in seconds, empty where the capture is gone."""
    series = run.per_frame("psnr")
    frames = {name: list(range(len(values))) for name, values in series.items()}
    for camera in cameras:
        if camera.camera not in series:
            series[camera.camera], frames[camera.camera] = list(camera.psnr), list(camera.frames)
    if not series:
        return section(
            "quality", "Quality", [note(f"No scores: {run.unscored or 'eval.json has none of single frames'}.")]
        )
    lines = []
    for number, (name, values) in enumerate(series.items()):
        places = [times[frame] for frame in frames[name]] if times else [float(frame) for frame in frames[name]]
        lines.append(Series(name, places, values, number))
    label = "seconds" if times else "frame"
    seen = [name for name in series if name not in run.spec.config.capture.hold_out]
    words = f"Training saw {', '.join(seen)}." if seen else "Cameras that neither initialisation nor training saw."
    over_time = line_chart("PSNR of every frame by camera", lines, label, "PSNR, dB", unit=" dB")
    bars = [_camera_bar(name, values, number) for number, (name, values) in enumerate(series.items())]
    lowest = sorted(bars, key=lambda bar: bar.total)[:_MOST_BARS]
    shown = [bar for bar in bars if bar in lowest]
    by_camera = bar_chart("Mean PSNR by camera", shown, "PSNR, dB")
    about = "Mean of the frames; the line across a bar marks the worst one."
    if len(shown) < len(bars):
        about += f" The lowest {len(shown)} of {len(bars)}."
    charts = chart("PSNR over time", over_time, words) + chart("PSNR by camera", by_camera, about)
    return section("quality", "Quality", [f'<div class="charts">{charts}</div>'])


def training_section(run: FinishedRun) -> str:
    """Return the curves of training, over iterations with the seconds above, and where its time went."""
    parts = [_curves(run, run.history)] if run.history else []
    if run.profile:
        parts.append(chart("Where the time went", _profile_chart(run), "Seconds of training by activity."))
    missing = [name for name, there in (("history", run.history), ("profile", run.profile)) if not there]
    html = [f'<div class="charts">{"".join(parts)}</div>'] if parts else []
    if missing:
        html.append(note(f"train.json of this run has no {' and no '.join(missing)}."))
    segments = len(run.manifest.segments)
    if run.history and segments > 1:
        html.append(note(f"The curves are of the first of {segments} segments, which trains the static splats too."))
    return section("training", "Training", html)


def decomposition_section(run: FinishedRun, cameras: Sequence[CameraPictures]) -> str:
    """Return which share of pixels, splats and bytes is dynamic."""
    totals = run.manifest.totals
    shares = [
        ("splats", _share(totals.splats_dynamic, totals.splats_static)),
        ("bytes", _share(totals.bytes_dynamic, totals.bytes_static)),
    ]
    moments = [moment for camera in cameras for moment in camera.moments]
    if moments:
        shares.insert(0, ("pixels", sum(moment.dynamic_share for moment in moments) / len(moments)))
    bars = [
        Bar(
            name,
            [
                Part("dynamic", 100 * share, 1, f"{share:.1%}"),
                Part("static", 100 * (1 - share), 0, f"{1 - share:.1%}"),
            ],
            f"{share:.1%}",
        )
        for name, share in shares
    ]
    words = "Bytes of chunks."
    if moments:
        words = f"A pixel counts as dynamic if dynamic splats give more than half of it; mean of the {len(moments)} pictures. {words}"  # noqa: E501
    html = bar_chart("Shares of dynamic splats", bars, "%")
    return section("decomposition", "What moves", [f'<div class="charts">{chart("Dynamic share", html, words)}</div>'])


def comparison_section(run: FinishedRun, others: Sequence[FinishedRun]) -> str:
    """Return speed and size against quality of all runs, and their table."""
    if not others:
        return section(
            "comparison", "Other runs", [note("Name other runs with --against to see speed and size against quality.")]
        )
    runs = [run, *others]
    names = _names(runs)
    points = [(number, one, decibels) for number, one in enumerate(runs) if (decibels := one.score("psnr")) is not None]
    charts = []
    for title, label, of in (
        ("Training time against quality", "minutes of training", lambda one: one.seconds / 60),
        ("Size against quality", "MB", lambda one: megabytes(one.bytes_total)),
    ):
        dots = [
            Point(
                names[number],
                of(one),
                decibels,
                number,
                not comparable(run, one),
                f"{names[number]}: {decibels:.2f} dB, {one.seconds / 60:.1f} min, {megabytes(one.bytes_total):.3f} MB",
            )
            for number, one, decibels in points
        ]
        if dots:
            charts.append(chart(title, scatter_chart(title, dots, label, "PSNR, dB")))
    rows = [_row(run, one, name) for one, name in zip(runs, names, strict=True)]
    head = ("run", "preset", *_QUALITY, "MB", "MB per 50 frames", "minutes", "splats", "comparable")
    html = [f'<div class="charts">{"".join(charts)}</div>', table("All runs", head, rows)]
    if not all(comparable(run, one) for one in others):
        html.append(note("Hollow points were scored on another capture, other cameras or other pictures."))
    return section("comparison", "Other runs", html)


def comparable(a: FinishedRun, b: FinishedRun) -> bool:
    """Return whether two runs were scored on the same pictures, and neither trained on them unlike the other."""

    def what(run: FinishedRun) -> tuple[object, ...]:
        cameras = sorted(map(str, run.scores.get("cameras", [])))
        truth = run.scores.get("truth", "capture")
        return run.spec.fingerprint, cameras, sorted(run.seen), run.scores.get("frames"), truth

    return what(a) == what(b)


def _camera_bar(name: str, values: Sequence[float], number: int) -> Bar:
    finite = [value for value in values if math.isfinite(value)]
    mean, worst = (sum(finite) / len(finite), min(finite)) if finite else (0.0, math.nan)
    words = f"{mean:.2f} dB" if finite else "equal"
    return Bar(name, [Part("", mean, number, words)], words, worst, f"{name}: worst frame {worst:.2f} dB")


def _curves(run: FinishedRun, history: History) -> str:
    top = TopAxis("seconds", history.iteration, history.seconds) if all(map(math.isfinite, history.seconds)) else None
    html = []
    for key, title, y_label, words in (
        ("psnr", "PSNR of training views", "PSNR, dB", "Smoothed; training draws the first part at reduced size."),
        ("loss", "Loss", "loss", "Smoothed."),
    ):
        if any(map(math.isfinite, history.figures.get(key, ()))):
            lines = [Series(key, history.iteration, history.figures[key])]
            svg = line_chart(title, lines, "iteration", y_label, top_axis=top, y_zero=key == "loss")
            html.append(chart(title, svg, words))
    counts = [
        Series(key, history.iteration, history.figures[key], number)
        for number, key in enumerate(("static", "dynamic"))
        if key in history.figures
    ]
    if counts:
        svg = line_chart("Splats", counts, "iteration", "splats", top_axis=top, y_zero=True)
        html.append(chart("Splats", svg))
    return "".join(html)


def _profile_chart(run: FinishedRun) -> str:
    stages = dict(sorted(run.profile.items(), key=lambda item: -item[1]))
    rest = run.seconds - sum(stages.values())
    if rest > 0.005 * run.seconds:
        stages["everything else"] = rest
    whole = sum(stages.values())
    bars = []
    for name, seconds in stages.items():
        words = f"{seconds:.1f} s, {seconds / whole:.0%}"
        bars.append(Bar(name, [Part("", seconds, 0, words)], words))
    return bar_chart("Where the time of training went", bars, "seconds")


def _share(dynamic: int, static: int) -> float:
    return dynamic / (dynamic + static) if dynamic + static else 0.0


def _names(runs: Sequence[FinishedRun]) -> list[str]:
    """Folder names, with the folder above where two are called alike."""
    names = [run.name for run in runs]
    return [run.name if names.count(run.name) == 1 else "/".join(run.folder.path.resolve().parts[-2:]) for run in runs]


def _row(run: FinishedRun, one: FinishedRun, name: str) -> tuple[str, ...]:
    quality = [(one.score(key), 2 if key.startswith("psnr") else 4) for key in _QUALITY.values()]
    frames = one.scores.get("frames")
    totals = one.manifest.totals
    scaled = f"{megabytes(per_frames(one.bytes_total, frames, 50)):.3f}" if isinstance(frames, int) and frames else "-"
    return (
        name,
        one.spec.config.preset,
        *("-" if value is None else f"{value:.{places}f}" for value, places in quality),
        f"{megabytes(one.bytes_total):.3f}",
        scaled,
        f"{one.seconds / 60:.1f}",
        f"{totals.splats_static + totals.splats_dynamic:,}",
        "yes" if comparable(run, one) else "no",
    )
