"""The costs predicted from a training's size."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.training_costs import COSTS, MEMORY, memory_terms, scene_bytes, terms, training_need
from hgs_core.runs.training_size import TrainingSize
from tests.large_training import LARGE

CONFIG = RunConfig()


def processor(**changes: object) -> dict[str, float]:
    return dict(training_need(dataclasses.replace(LARGE, **changes), CONFIG).processor)  # type: ignore[arg-type]


def test_every_term_has_a_coefficient() -> None:
    assert {part: len(own) for part, own in terms(LARGE).items()} == {part: len(own) for part, own in COSTS.items()}
    grown = memory_terms(LARGE, 256)
    assert {stage: len(own) for stage, own in grown.items()} == {stage: len(own) for stage, own in MEMORY.items()}


def test_stages_are_those_that_are_reported_in_their_order() -> None:
    assert list(processor()) == ["sync", "check", "frames", "masks", "points", "train", "encode", "publish"]


def test_what_a_capture_gives_is_not_made() -> None:
    assert not {"sync", "masks"} & set(processor(aligned=True, masked=True))


@pytest.mark.parametrize(
    ("change", "stages"),
    [
        ({"training_cameras": 30}, {"frames", "masks", "points", "train"}),
        ({"frames": 600}, {"frames", "masks", "encode"}),
        ({"pixels": 2e6}, {"masks", "points", "train", "encode"}),
        ({"filmed_pixels": 2e6}, {"sync", "check", "frames"}),
        ({"straightened": 1.0}, {"sync", "check", "frames"}),
        ({"iterations": 40_000}, {"train"}),
        ({"moving_steps": 9.0}, {"train"}),
    ],
)
def test_costs_grow_with_what_makes_them(change: dict[str, float], stages: set[str]) -> None:
    before, after = processor(), processor(**change)
    assert {stage for stage in before if after[stage] > before[stage]} == stages


def test_pictures_that_do_not_fit_in_memory_lie_on_disk() -> None:
    need = training_need(LARGE, CONFIG)
    assert need.pictures == 15 * 300 * 1352 * 1014 * 3
    ample = training_need(LARGE, CONFIG.changed({"capture.frame_memory_mib": 40_000}))
    assert ample.pictures == 0
    assert ample.most_memory > need.most_memory + (10 << 30)


def test_there_is_a_bound_on_pictures_on_disk() -> None:
    need = training_need(LARGE, CONFIG.changed({"capture.picture_disk_gib": 4}))
    assert need.pictures == 4 << 30


def test_memory_does_not_grow_with_the_length_of_a_capture_on_disk() -> None:
    longer = dataclasses.replace(LARGE, frames=3000, segments=LARGE.segments * 10)
    assert training_need(longer, CONFIG).memory == training_need(LARGE, CONFIG).memory


def test_a_moment_needs_less_memory_than_a_film_of_the_same_pictures() -> None:
    """Births look at two moments of a film at once."""
    film = dataclasses.replace(LARGE, frames=2)
    moment = dataclasses.replace(film, frames=1)
    pictures = 15 * 1352 * 1014 * 3 / 2**20
    more = (training_need(film, CONFIG).most_memory - training_need(moment, CONFIG).most_memory) / 2**20
    assert more > 1.1 * pictures + 100


def test_the_course_rises_to_the_end_and_begins_cheaply() -> None:
    course = np.array(training_need(LARGE, CONFIG).course)
    assert (np.diff(course) > 0).all()
    assert course[-1] == 1
    one = dataclasses.replace(LARGE, segments=LARGE.segments[:1])
    assert training_need(one, CONFIG).course[9] < 0.15  # a fifth of the iterations, at half resolution


@pytest.mark.parametrize(
    ("preset", "measured"),
    [("preview", 800_676), ("standard", 1_289_091)],  # docs/benchmarks.md, samples/studio
)
def test_a_scene_has_at_most_the_bytes_that_were_predicted(preset: str, measured: int) -> None:
    size = TrainingSize.announced(16, 60, 2.0, 512 * 384, RunConfig.for_preset(preset))
    assert measured < scene_bytes(size) < 1.3 * measured
