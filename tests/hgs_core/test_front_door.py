"""The library's front door: the names of `import hgs_core`, and the examples of its docstrings and of README."""

from __future__ import annotations

import doctest
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import hgs_core
from tests.conftest import REPOSITORY
from tests.synthetic import write_capture

FIRST_MET = [
    "open_capture",
    "RunConfig.for_preset",
    "train_scene",
    "evaluate_run",
    "load_manifest",
    "decode_scene",
    "rasterize",
    "load_scene",
    "save_scene",
    "encode_scene",
]
"""The names that a user meets first, in that order; each has a runnable example."""

SMALL: dict[str, Any] = {
    "capture": {"hold_out": ["2"]},
    "points": {"static": 300, "dynamic": 60, "interval": 0.1},
    "train": {"iterations": 60, "density": {"every": 20, "max_static": 400, "max_dynamic": 100}},
}


def public(path: str) -> Any:
    value: Any = hgs_core
    for name in path.split("."):
        value = getattr(value, name)
    return value


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a capture and a finished run of it, which the examples find by these names."""
    path = tmp_path_factory.mktemp("workplace")
    write_capture(path / "capture")
    hgs_core.train_scene(path / "capture", path / "run", hgs_core.RunConfig.from_json(SMALL))
    return path


def test_importing_the_package_loads_no_heavy_library() -> None:
    heavy = "{'torch', 'numpy', 'av', 'PIL', 'pycolmap', 'zstandard'}"
    code = f"import sys, hgs_core; dir(hgs_core); print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", hgs_core.__all__)
def test_every_public_name_resolves_and_says_what_it_is(name: str) -> None:
    value = getattr(hgs_core, name)
    assert value.__name__ == name
    assert value.__doc__
    assert not value.__doc__.startswith(f"{name}(")  # the default docstring of a dataclass


def test_dir_lists_the_public_names_and_others_are_refused() -> None:
    assert set(hgs_core.__all__) <= set(dir(hgs_core))
    with pytest.raises(AttributeError, match="'hgs_core' has no attribute 'open_captures'"):
        _ = hgs_core.open_captures


def test_the_package_is_marked_as_typed() -> None:
    assert (REPOSITORY / "hgs_core" / "py.typed").is_file()


@pytest.mark.parametrize("path", FIRST_MET)
def test_the_example_of_a_docstring_runs(path: str, workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(workplace)
    function = public(path)
    [test] = doctest.DocTestFinder(recurse=False).find(function, path, globs={})
    assert test.examples
    assert doctest.DocTestRunner().run(test).failed == 0


def test_the_example_of_the_readme_runs(
    workplace: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On the tiny capture and its finished run, under the names that README gives them."""
    [code] = re.findall(r"```python\n(.*?)```", (REPOSITORY / "README.md").read_text(), re.DOTALL)
    monkeypatch.chdir(workplace)
    for there, here in (("capture", "samples/studio"), ("run", "runs/studio")):
        Path(here).parent.mkdir(exist_ok=True)
        Path(here).symlink_to(workplace / there)
    small = hgs_core.RunConfig.from_json(SMALL)
    monkeypatch.setattr(hgs_core.RunConfig, "for_preset", lambda preset, **overrides: small)
    exec(compile(code, "README.md", "exec"), {})
    psnr, shape = capsys.readouterr().out.splitlines()
    assert float(psnr) > 10
    assert shape == "torch.Size([3, 48, 64])"
