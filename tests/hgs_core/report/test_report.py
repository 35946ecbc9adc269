"""The page: valid, complete in itself, and of the figures that eval.json and the chunks have."""

from __future__ import annotations

import json
import re
import shutil
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import silent
from hgs_core.codec import load_manifest
from hgs_core.report.sizes import chunk_sizes
from hgs_core.report.write import write_report
from hgs_core.runs.folder import RunFolder
from tests.hgs_core.report.finished_run import write_finished_run

VOID = {"meta", "link", "img", "input"}


class Page(HTMLParser):
    """Elements that open and close in order, with what they refer to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        assert len(dict(attributes)) == len(attributes), f"<{tag}> has an attribute twice"
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def values(self, attribute: str) -> list[str]:
        return [value for _, attributes in self.tags if (value := attributes.get(attribute)) is not None]


def written(run: Path, out: Path, *against: Path) -> str:
    write_report(run, out, against, silent)
    return out.read_text()


def tile(text: str, key: str) -> str:
    found = re.search(rf'data-figure="{key}">.*?class="value">([^<]*)<', text)
    assert found, key
    return found[1]


def test_elements_nest_and_references_resolve(report: Path) -> None:
    page = Page(report.read_text())
    assert page.open == []
    ids = Counter(page.values("id"))
    assert set(ids.values()) == {1}
    assert {value.removeprefix("#") for value in page.values("href") if value.startswith("#")} <= set(ids)
    assert set(page.values("aria-labelledby")) <= set(ids)


def test_the_page_names_the_machine_that_trained_the_run(tmp_path: Path) -> None:
    machine = {"hgs": "1.2.3", "cpu": "a <processor>", "cores": 4}
    page = written(write_finished_run(tmp_path, machine=machine), tmp_path / "page.html")
    assert "Trained by HGS 1.2.3 on a &lt;processor&gt;, 4 cores." in page


def test_pictures_charts_and_sliders_have_names(report: Path) -> None:
    page = Page(report.read_text())
    for tag, attribute in (("img", "alt"), ("svg", "aria-label"), ("input", "aria-label")):
        named = [attributes.get(attribute) for found, attributes in page.tags if found == tag]
        assert named, tag
        assert all(named), tag


def test_charts_are_well_formed_svg(report: Path) -> None:
    charts = re.findall(r"<svg.*?</svg>", report.read_text(), re.DOTALL)
    assert len(charts) >= 10
    for chart in charts:
        assert "nan" not in " ".join(re.findall(r'"[^"]*"', chart)).split()
        ElementTree.fromstring(chart)


def test_the_page_refers_to_nothing_outside_itself(report: Path) -> None:
    page = Page(report.read_text())
    for attribute in ("src", "href", "srcset", "action", "data", "poster"):
        assert all(value.startswith(("data:", "#")) for value in page.values(attribute))
    assert "url(" not in report.read_text()
    assert "@import" not in report.read_text()


def test_figures_are_those_of_eval_json(run: Path, report: Path) -> None:
    text = report.read_text()
    scores = json.loads((run / "eval.json").read_text())
    assert tile(text, "psnr") == f"{scores['psnr']:.2f}"
    assert tile(text, "ssim") == f"{scores['ssim']:.4f}"
    assert tile(text, "bytes_total") == f"{scores['bytes_total'] / 1e6:.3f}"
    assert tile(text, "mb_50") == f"{scores['bytes_total'] / scores['frames'] * 50 / 1e6:.3f}"
    assert tile(text, "mb_300") == f"{scores['bytes_total'] / scores['frames'] * 300 / 1e6:.3f}"
    assert tile(text, "splats") == f"{scores['splats_static'] + scores['splats_dynamic']:,}"
    assert (tile(text, "minutes"), tile(text, "rate")) == ("0.2", "3.3")


def test_a_comparison_names_the_run_that_is_not_comparable(other: Path, report: Path) -> None:
    text = report.read_text()
    row = re.search(rf'<tr><th scope="row">{other.name}</th>(.*?)</tr>', text)
    assert row
    assert row[1].endswith("<td>no</td>")
    assert "Hollow points were scored on another capture" in text


def test_streams_of_all_chunks_add_up_to_their_files(run: Path) -> None:
    folder = RunFolder(run)
    manifest = load_manifest(folder.manifest)
    sizes = chunk_sizes(folder, manifest)
    assert [sum(size.streams.values()) for size in sizes] == [chunk.bytes for chunk in manifest.chunks]
    assert [size.splats for size in sizes] == [chunk.splats for chunk in manifest.chunks]


def test_without_the_capture_the_page_says_so_and_has_no_pictures(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    spec = json.loads((run / "run.json").read_text())
    (tmp_path / "run" / "run.json").write_text(json.dumps(spec | {"capture": str(tmp_path / "gone")}))
    text = written(tmp_path / "run", tmp_path / "report.html")
    assert "<img" not in text
    assert "No pictures" in text
    assert "the folder does not exist" in text
    assert tile(text, "psnr") == f"{json.loads((run / 'eval.json').read_text())['psnr']:.2f}"


def test_a_run_without_capture_and_scores_still_tells_its_size(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "eval.json").unlink()
    spec = json.loads((run / "run.json").read_text())
    (tmp_path / "run" / "run.json").write_text(json.dumps(spec | {"capture": str(tmp_path / "gone")}))
    text = written(tmp_path / "run", tmp_path / "report.html")
    assert "No scores" in text
    assert 'data-figure="psnr"' not in text
    assert float(tile(text, "bytes_total")) > 0


def test_without_held_out_cameras_training_cameras_are_shown_and_called_so(run: Path) -> None:
    path = write_finished_run(run.parent, "all", ())
    text = written(path, path / "report.html")
    assert "these are training cameras" in text
    assert text.count("(training saw it)") == 4
    assert 'data-figure="psnr"' not in text


def test_settings_that_differ_from_the_preset_are_listed(report: Path) -> None:
    assert '<tr><th scope="row">iterations</th><td>2500</td><td>40</td></tr>' in report.read_text()


def test_an_unmeasured_run_is_measured_first(run: Path) -> None:
    path = write_finished_run(run.parent, "unmeasured")
    text = written(path, path / "report.html")
    assert tile(text, "psnr") == f"{json.loads((path / 'eval.json').read_text())['psnr']:.2f}"


def test_an_unfinished_run_is_refused(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "train.json").unlink()
    with pytest.raises(InputError, match="no encoded scene yet"):
        written(tmp_path / "run", tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_a_damaged_eval_json_is_refused_by_name(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    (tmp_path / "run" / "eval.json").write_text("{")
    with pytest.raises(InputError, match=r"eval\.json: unreadable"):
        written(tmp_path / "run", tmp_path / "report.html")


def test_a_folder_as_the_page_is_refused(run: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        written(run, tmp_path)
