"""Which of two meanings scales and opacities have."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange import import_scene
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.scene.opacities import opacities_of
from tests.hgs_core.interchange.scenes import Write
from tests.hgs_core.interchange.test_splat_properties import COUNT, columns, told


def activated(table: dict[str, np.ndarray], *, scales: bool = True, opacity: bool = True) -> dict[str, np.ndarray]:
    found = dict(table)
    for i in range(3 if scales else 0):
        found[f"scale_{i}"] = np.exp(table[f"scale_{i}"])
    if opacity:
        found["opacity"] = opacities_of(table["opacity"])
    return found


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, ["scale", "opacity"]),
        ({"scales": False}, ["opacity"]),
    ],
)
def test_numbers_as_they_are_drawn_become_logarithms_and_logits(
    written: Write, given: dict[str, bool], expected: list[str]
) -> None:
    plain, _ = told(written("x.ply", write_ply(columns())))
    found, changes = told(written("y.ply", write_ply(activated(columns(), **given))))
    assert changes == expected
    np.testing.assert_allclose(found.log_scales, plain.log_scales, atol=1e-5)
    np.testing.assert_allclose(found.opacity_logits, plain.opacity_logits, atol=1e-3)


def test_where_ranges_fit_both_the_answer_is_asked_for_and_taken(written: Write) -> None:
    same = columns() | {"opacity": np.full(COUNT, 0.9)}
    path = written("x.ply", write_ply(same))
    with pytest.raises(InputError, match=r"import it with --activated if so, with --no-activated if they are"):
        import_scene(path)
    logits, changes = told(path, activated=False)
    assert (float(logits.opacity_logits[0]), changes) == (np.float32(0.9), [])
    drawn = written("y.ply", write_ply(activated(columns(), opacity=False)))
    with pytest.raises(InputError, match="all scales are positive"):
        import_scene(drawn)
    both = written("z.ply", write_ply(activated(same, opacity=False)))
    found, changes = told(both, activated=True)
    assert changes == ["scale", "opacity"]
    np.testing.assert_allclose(opacities_of(found.opacity_logits), 0.9, rtol=1e-5)


def test_millimetres_have_positive_logarithms_of_scales(written: Write) -> None:
    table = columns() | {f"scale_{i}": columns()[f"scale_{i}"] + np.log(1000) for i in range(3)}
    table |= {axis: columns()[axis] * 1000 for axis in "xyz"}
    assert (table["scale_0"] > 0).all()
    assert told(written("x.ply", write_ply(table)))[1] == []


def test_the_answer_is_taken_for_those_numbers_alone_that_can_be_as_they_are_drawn(written: Write) -> None:
    """Scales below 0 are logarithms, and opacities beyond 1 logits."""
    same = columns() | {"opacity": np.full(COUNT, 2.5)}
    plain, _ = told(written("x.ply", write_ply(same)))
    for given, expected in (({"scales": False}, ["opacity"]), ({"opacity": False}, ["scale"])):
        path = written("y.ply", write_ply(activated(same, **given)))
        found, changes = told(path, activated=True)
        assert changes == expected
        np.testing.assert_allclose(found.log_scales, plain.log_scales, atol=1e-5)
        np.testing.assert_allclose(found.opacity_logits, plain.opacity_logits, atol=1e-3)
    with pytest.raises(InputError, match=r"holds no number as it is drawn: .*; import it without --activated$"):
        import_scene(written("z.ply", write_ply(same)), activated=True)
