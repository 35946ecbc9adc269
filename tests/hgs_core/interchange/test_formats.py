from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.formats import FORMATS, IMPORTED, format_of


def test_a_files_format_goes_by_its_suffix() -> None:
    names = [".ply", ".splat", ".splatv", ".spz", ".glb", ".4dgs"]
    assert [format_of(Path(f"folder.obj/x{name}"), lambda one: True).suffix for name in names] == names


@pytest.mark.parametrize(("name", "suffix"), [("x.obj", "'.obj'"), ("x", "'none'"), ("x.splatv", "'.splatv'")])
def test_a_suffix_that_does_not_fit_is_told_those_that_do(name: str, suffix: str) -> None:
    with pytest.raises(InputError) as caught:
        format_of(Path(name), lambda one: one.read is not None)
    assert str(caught.value) == f"{name}: has the suffix {suffix}; give one of .ply, .splat, .spz, .glb, .4dgs"


def test_no_suffix_is_taken_twice_and_those_imported_can_be_read() -> None:
    assert len({one.suffix for one in FORMATS}) == len(FORMATS)
    assert IMPORTED == (".ply", ".splat", ".spz", ".glb", ".4dgs")
