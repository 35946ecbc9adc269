from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import obstore
import pytest
from s3_server import running_s3_server

from hgs_core.base.errors import InputError
from jobs.home.object_store import is_folder, open_object_store, require_conditional_puts


def test_a_folder_is_made(tmp_path: Path) -> None:
    url = (tmp_path / "deep" / "store").as_uri()
    assert is_folder(url)
    obstore.put(open_object_store(url), "a", b"1")
    assert (tmp_path / "deep" / "store" / "a").read_bytes() == b"1"


def test_a_bucket_is_no_folder() -> None:
    assert not is_folder("s3://bucket/prefix")


def test_an_endpoint_that_is_no_address_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_ENDPOINT", "storage:9000")
    with pytest.raises(InputError, match="AWS_ENDPOINT storage:9000: is not the address of a server; give https://"):
        open_object_store("s3://bucket/prefix")


class TestConditionalPuts:
    @pytest.fixture
    def url(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
        with running_s3_server() as server:
            for name, value in server.settings.items():
                monkeypatch.setenv(name, value)
            yield "s3://bucket/probed"

    def test_a_store_that_keeps_them_apart_will_do(self, url: str) -> None:
        require_conditional_puts(url)
        assert [page for page in obstore.list(open_object_store(url)) if page] == []

    @pytest.mark.parametrize(("ignored", "header"), [("create", "If-None-Match"), ("e_tag", "If-Match")])
    def test_one_that_does_not_is_refused(
        self, url: str, monkeypatch: pytest.MonkeyPatch, ignored: str, header: str
    ) -> None:
        put = obstore.put

        def careless(store: Any, path: str, data: bytes, mode: Any, use_multipart: bool) -> Any:
            return put(store, path, data, mode="overwrite" if ignored in mode else mode, use_multipart=use_multipart)

        monkeypatch.setattr(obstore, "put", careless)
        with pytest.raises(InputError, match=f"took 8 of 8 puts of one object at once with {header}, and not one"):
            require_conditional_puts(url)
