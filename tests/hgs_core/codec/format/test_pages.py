from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.paged_manifest import read_index
from hgs_core.codec.format.pages import read_columns, read_page
from hgs_core.codec.format.paging import paged

VECTORS: dict[str, Any] = json.loads((Path(__file__).parents[3] / "vectors" / "pages.json").read_text(encoding="utf-8"))
WHOLE = read_manifest(VECTORS["manifest"])


def test_the_vectors_are_read_and_say_the_same() -> None:
    for name, manifest in (("whole", WHOLE), ("beginning", first_segments(WHOLE, 1))):
        made, vector = paged(manifest, manifest.to_json(), 16, 0), VECTORS[name]
        assert read_index(made.index)["manifest"] == read_index(bytes.fromhex(vector["index"]))["manifest"]
        kept = [read_page(bytes.fromhex(data)) for data in vector["pages"].values()]
        assert [read_page(data) for data in made.pages.values()] == kept


@pytest.mark.parametrize("name", VECTORS["refused"])
def test_what_is_no_page_is_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"^a page: "):
        read_columns(bytes.fromhex(VECTORS["refused"][name]), "a page")
