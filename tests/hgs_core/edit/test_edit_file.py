"""Files of edits: their size, format and version."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit import edit_file
from hgs_core.edit.edit_file import EditFormat, read_edit_file, shown


def test_a_file_in_any_of_the_formats_is_read(tmp_path: Path) -> None:
    file = tmp_path / "edit.json"
    for one in EditFormat:
        file.write_text(json.dumps({"format": one, "version": 1, "box": []}))
        assert read_edit_file(file, list(EditFormat))["box"] == []


def test_a_file_in_another_format_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "edit.json"
    file.write_text('{"format": "hgs-crop", "version": 1}')
    with pytest.raises(InputError, match=r"edit\.json: format: is \"hgs-crop\", not 'hgs-splats'; give a list of"):
        read_edit_file(file, [EditFormat.SPLATS])
    file.write_text('{"format": ["hgs-crop"], "version": 1}')
    with pytest.raises(InputError, match=r"not 'hgs-splats' or 'hgs-crop'; give a list of splats or a crop"):
        read_edit_file(file, list(EditFormat))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"edit\.json: cannot be read \(No such file or directory\)"):
        read_edit_file(tmp_path / "edit.json", list(EditFormat))


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(edit_file, "MAX_BYTES", 20)
    (tmp_path / "edit.json").write_text('{"format": "hgs-crop", "version": 1}')
    with pytest.raises(InputError, match=r"edit\.json: has \d+ bytes; give at most 20; edit in several steps"):
        read_edit_file(tmp_path / "edit.json", list(EditFormat))


def test_a_long_value_is_cut_for_a_message() -> None:
    assert shown([1, None]) == "[1, null]"
    assert len(shown("x" * 200)) == 80
