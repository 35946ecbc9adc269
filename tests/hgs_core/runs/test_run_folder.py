"""The run.json that a run was started with, read again."""

from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    run = RunFolder(tmp_path / "run")
    run.write_spec(RunSpec(tmp_path, "fingerprint", RunConfig().changed({"train.iterations": 7})))
    return run


def test_a_run_keeps_its_specification(run: RunFolder, tmp_path: Path) -> None:
    assert run.read_spec() == RunSpec(tmp_path, "fingerprint", RunConfig().changed({"train.iterations": 7}))


@pytest.mark.parametrize("value", ["Infinity", "NaN", "1e300", "9" * 400, "0", '"7"'])
def test_a_value_out_of_range_is_refused_with_its_file_and_field(run: RunFolder, value: str) -> None:
    run.spec.write_text(run.spec.read_text().replace('"iterations": 7', f'"iterations": {value}'))
    with pytest.raises(
        InputError, match=r"run\.json, config\.train\.iterations: .*give a whole number from 1 to 1000000"
    ):
        run.read_spec()


@pytest.mark.parametrize("text", ["", "{}", "[]", "\ud800", "[" * 100_000, '{"config": ' + "9" * 5000 + "}"])
def test_another_file_is_unreadable(run: RunFolder, text: str) -> None:
    run.spec.write_bytes(text.encode(errors="surrogatepass"))
    with pytest.raises(InputError, match=r"run\.json"):
        run.read_spec()


def test_it_knows_that_it_was_edited(tmp_path: Path) -> None:
    spec = RunSpec(tmp_path, "", RunConfig(), without_capture=True, edited=True)
    RunFolder(tmp_path / "edited").write_spec(spec)
    assert RunFolder(tmp_path / "edited").read_spec() == spec
