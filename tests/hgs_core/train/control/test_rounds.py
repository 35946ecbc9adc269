"""Which rounds a training has, and after which iterations they are due."""

from __future__ import annotations

import pytest

from hgs_core.base.config_fields import with_fields
from hgs_core.points.backdrop import Backdrop
from hgs_core.points.far_apart import LONG
from hgs_core.train.control import rounds
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.train_config import TrainConfig

CONFIG = TrainConfig(iterations=1000, density=DensityConfig(start=0.1, end=0.6, every=100))


def due(config: TrainConfig, *, masked: bool = True, statics_learn: bool = True) -> dict[str, list[int]]:
    """For every round of a training, the iterations, counted from 1, that it follows."""
    every = rounds(config, masked=masked, statics_learn=statics_learn)
    return {control.name: [i + 1 for i in range(config.iterations) if control.due(i)] for control in every}


def test_rounds_follow_an_iteration_in_their_order() -> None:
    assert list(due(CONFIG)) == ["moving steps", "pruning", "births", "infill", "density", "labels"]


def test_rounds_have_their_places_in_the_run() -> None:
    found = due(CONFIG)
    assert found["pruning"] == [300, 450, 650, 850]
    assert found["births"] == [300, 450]
    assert found["density"] == [100, 200, 300, 400, 500, 600]
    assert found["moving steps"] == [400, 500, 600, 700, 800, 900, 1000]


def test_labels_and_infill_have_the_same_ten_while_splats_are_still_added() -> None:
    found = due(CONFIG)
    assert found["labels"] == found["infill"] == [150, 200, 250, 300, 350, 400, 450, 500, 550, 600]


@pytest.mark.parametrize(
    ("changed", "name", "left"),
    [
        ({"density": {"birth_rounds": 1}}, "births", 1),
        ({"density": {"birth_rounds": 0}}, "births", 0),
        ({"labels": {"adaptive": False}}, "labels", 0),
        ({"density": {"infill": 0.0}}, "infill", 0),
        ({"labels": {"initial": "dynamic"}}, "infill", 0),
        ({"density": {"prune_contribution": 0.0}}, "pruning", 0),
    ],
)
def test_the_config_turns_rounds_off(changed: dict[str, object], name: str, left: int) -> None:
    assert len(due(with_fields(CONFIG, changed, "config.train"))[name]) == left


def test_without_moving_steps_there_is_no_round_of_them() -> None:
    assert "moving steps" not in due(with_fields(CONFIG, {"moving_steps": 0.0}, "config.train"))


def test_without_masks_nothing_is_born_and_nothing_known_to_move() -> None:
    assert list(due(CONFIG, masked=False)) == ["pruning", "infill", "density", "labels"]


def test_statics_that_do_not_learn_are_neither_added_nor_relabelled() -> None:
    assert list(due(CONFIG, statics_learn=False)) == ["moving steps", "pruning", "births", "density"]


BACKDROP = Backdrop((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), 1.0)


def test_cameras_far_apart_have_rounds_that_ask_no_pictures_to_agree() -> None:
    first = rounds(CONFIG, masked=True, statics_learn=True, backdrop=BACKDROP)
    names = ["silhouettes", "pruning", "density", "hull", "backdrop fill", "backdrop"]
    assert [control.name for control in first] == names
    later = rounds(CONFIG, masked=True, statics_learn=False, backdrop=BACKDROP)
    assert [control.name for control in later] == names[:4]


def test_long_trainings_of_cameras_far_apart_go_on_over_the_room() -> None:
    config = with_fields(CONFIG, {"iterations": LONG, "moving_steps": 2.0}, "config.train")
    found = {control.name: control for control in rounds(config, masked=True, statics_learn=True, backdrop=BACKDROP)}
    assert list(found)[:6] == ["moving steps", "silhouettes", "pruning", "births", "density", "hull"]
    assert not any(found["silhouettes"].due(iteration) for iteration in (LONG // 2, LONG - 1))
    assert found["moving steps"].due(LONG - 1)
