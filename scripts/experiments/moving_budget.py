"""What it costs to keep the budget of encoding where things move as well.

    .venv/bin/python -m scripts.experiments.moving_budget RUN [RUN ...] [--budget default] [--fine-tune ITERATIONS]

Every trained run is encoded, and nothing of it kept, in three ways: with what moves unknown, so that whole pictures
alone keep the budget; with the budget kept in both and one coarseness for all splats; and as `hgs encode` does it.
Losses are of the views that the coarseness is chosen on, against the scene as it was trained or, where it is better, as
it was trained further.
"""

from __future__ import annotations

import argparse
import dataclasses
import tempfile
from collections.abc import Sequence
from pathlib import Path
from unittest.mock import patch

from hgs_core.codec import decode_scene, encode_scene
from hgs_core.fit import coarseness
from hgs_core.fit.encoding_loss import Loss
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.runs.encode_inputs import trained_scene, training_states, views_of_run
from hgs_core.runs.run_folder import RunFolder

_WAYS = ("whole pictures alone", "one coarseness", "two coarsenesses")


def _encode(run: Path, budget: str, fine_tune: int | None) -> None:
    folder = RunFolder(run)
    spec, scene = folder.read_spec(), trained_scene(folder)
    views, states = views_of_run(folder, spec, scene), training_states(folder, scene)
    iterations = coarseness.fine_tune_iterations(spec.config.train) if fine_tune is None else fine_tune
    utility = measure_utility(scene, list(views.trained.values()), views.times, any_background=views.any_background)
    loss = Loss(scene, views, views.trained)
    for way in _WAYS:
        known = views if way != _WAYS[0] else dataclasses.replace(views, moving=None)
        share = (lambda *_, **__: 1.0) if way == _WAYS[1] else coarseness.dynamic_share
        with patch.object(coarseness, "dynamic_share", share):
            found = coarseness.fit(
                scene,
                known,
                utility,
                budget,
                spec.config.train,
                seed=spec.config.seed,
                iterations=iterations,
                states=states,
            )
        with tempfile.TemporaryDirectory() as out:
            totals = encode_scene(
                found.scene,
                Path(out),
                cameras=views.cameras,
                closer=views.closer,
                times=views.times,
                title=views.title,
                settings=found.settings,
                utility=found.utility,
            ).totals
            lost = loss.of(decode_scene(Path(out))).without_gain(loss.of(found.scene))
        settings, size = found.settings, totals.bytes_static + totals.bytes_dynamic
        moving = "unknown" if lost.moving is None else f"{lost.moving:.4f}"
        print(
            f"{run.name}, {way}: coarseness {settings.coarseness:.3f}, {settings.dynamic_share:.2f} of it for dynamic "
            f"splats; {totals.bytes_static:,} + {totals.bytes_dynamic:,} = "
            f"{size:,} bytes; {lost.whole:.4f} dB lost, {moving} where it moves; "
            f"{totals.splats_static / max(1, len(scene.static)):.1%} of the static splats kept, "
            f"{totals.splats_dynamic / max(1, scene.dynamic_splats):.1%} of the dynamic ones",
            flush=True,
        )


def main(arguments: Sequence[str] | None = None) -> None:
    """Encode the runs and print a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--budget", choices=("low", "default", "high"), default="default")
    parser.add_argument("--fine-tune", type=int)
    options = parser.parse_args(arguments)
    for run in options.runs:
        _encode(run, options.budget, options.fine_tune)


if __name__ == "__main__":
    main()
