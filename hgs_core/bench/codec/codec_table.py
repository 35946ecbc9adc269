"""Results of the codec's benchmark as text."""

from __future__ import annotations

import dataclasses

from hgs_core.bench.codec.codec_bench import CodecReport
from hgs_core.bench.raster.raster_table import aligned

__all__ = ["codec_text"]


def codec_text(report: CodecReport) -> str:
    """Return the tables: encodings, other formats, errors, rates."""
    machine = report.machine
    lines = [
        f"{machine['cpu']}, {machine['cores']} cores, load {machine['load']}",
        f"{report.source}: {report.splats_static:,} static and {report.splats_dynamic:,} dynamic splats",
        "",
        "Encodings; bytes per splat are of those kept",
    ]
    rows = [
        [
            "budget",
            "coarseness",
            "of dynamic",
            "static",
            "bytes",
            "each",
            "dynamic",
            "bytes",
            "each",
            "all bytes",
            "loss dB",
            "moving dB",
            "held out dB",
            "encode s",
        ]
    ]
    for p in (*report.budgets, *report.sweep):
        rows.append(
            [
                p.name or "-",
                f"{p.coarseness:.3g}",
                f"{p.coarseness * p.dynamic_share:.3g}",
                f"{p.splats_static:,}",
                f"{p.bytes_static:,}",
                _each(p.bytes_static, p.splats_static),
                f"{p.splats_dynamic:,}",
                f"{p.bytes_dynamic:,}",
                _each(p.bytes_dynamic, p.splats_dynamic),
                f"{p.bytes_static + p.bytes_dynamic:,}",
                f"{p.loss:.3f}",
                _decibels(p.loss_moving),
                _decibels(p.loss_held_out),
                f"{p.encode_seconds:.1f}",
            ]
        )
    lines += aligned(rows, left=("budget",))
    lines += ["", f".splatv of the same splats: {report.bytes_splatv:,} bytes"]
    lines += [f"{name}: {size:,} bytes" for name, size in report.bytes_spz.items()]
    if report.errors:
        names = [field.name for field in dataclasses.fields(next(iter(report.errors.values())))]
        table = [["root mean square errors", *names]]
        table += [[name, *(f"{getattr(e, n):.3g}" for n in names)] for name, e in report.errors.items()]
        lines += ["", *aligned(table, left=("root mean square errors",))]
    lines += [
        "",
        f"a quarter of the bytes of the first encoding: {report.prefix_loss:.2f} dB lost in order of the "
        f"manifest, {report.prefix_loss_shuffled:.2f} dB shuffled",
    ]
    rates = ", ".join(f"{name} {rate / 1e6:.1f} M splats/s" for name, rate in report.decode_rates.items())
    return "\n".join([*lines, "", f"decoding by one core: {rates}"])


def _decibels(loss: float | None) -> str:
    return "-" if loss is None else f"{loss:.3f}"


def _each(size: int, splats: int) -> str:
    return f"{size / splats:.1f}" if splats else "-"
