"""Lists that do not agree are refused; tests/vectors/invalid_manifest.json has more of them, for every reader."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest_reading import read_manifest
from tests.conftest import REPOSITORY


def list_a_static_chunk_twice(manifest: dict[str, Any]) -> None:
    manifest["static"].append(manifest["static"][0])


def list_a_static_chunk_as_dynamic(manifest: dict[str, Any]) -> None:
    manifest["slices"][0]["chunks"][0]["id"] = manifest["static"][0]["id"]


def need_a_chunk_that_comes_later(manifest: dict[str, Any]) -> None:
    manifest["slices"][0]["needs"] = [manifest["slices"][0]["chunks"][0]["id"]]


def name_a_segment_that_is_not_there(manifest: dict[str, Any]) -> None:
    manifest["slices"][0]["segment"] = 99


def count_too_few(manifest: dict[str, Any]) -> None:
    manifest["totals"]["splats_static"] -= 1


def leave_out_the_cameras(manifest: dict[str, Any]) -> None:
    manifest["cameras"] = []


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (list_a_static_chunk_twice, r"manifest\.static: lists a chunk twice"),
        (list_a_static_chunk_as_dynamic, r"manifest\.slices\[0\]\.chunks\[0\]\.id: \w{64} is listed twice"),
        (need_a_chunk_that_comes_later, r"manifest\.slices\[0\]\.needs\[0\]: \w{64} is not a chunk of an earlier"),
        (name_a_segment_that_is_not_there, r"manifest\.slices\[0\]\.segment: is 99, expected below"),
        (count_too_few, r"manifest\.totals\.splats_static: is \d+, but the chunks add up to \d+"),
        (leave_out_the_cameras, r"manifest\.cameras: is empty"),
    ],
)
def test_lists_that_do_not_agree_are_refused(spoil: Callable[[dict[str, Any]], None], message: str) -> None:
    manifest = json.loads((REPOSITORY / "tests" / "vectors" / "manifest.json").read_text())
    read_manifest(manifest)
    spoil(manifest)
    with pytest.raises(InputError, match=message):
        read_manifest(manifest)
