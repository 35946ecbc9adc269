from __future__ import annotations

import asyncio
import base64
import hashlib
from collections.abc import Iterator
from typing import Any
from urllib.parse import urljoin

import httpx
import pytest

from server.routes.upload_files import BLOCK
from server.uploads.arriving_file import ArrivingFile
from tests.server.conftest import running_server

CONTENT = bytes(range(256)) * 40_000  # ten blocks and a bit
STREAM = {"Tus-Resumable": "1.0.0", "Content-Type": "application/offset+octet-stream"}


@pytest.fixture(autouse=True)
def _one_server(server: Any) -> Iterator[None]:
    yield
    server.app.state.service.uploads.close()


@pytest.fixture
def upload(server: Any) -> str:
    """The address of an upload of one file."""
    body = {"name": "studio", "files": 1, "bytes": len(CONTENT)}
    return f"/v1/uploads/{server.request('POST', '/v1/uploads', json=body).json()['id']}"


def announcement(path: str = "cam00.mp4", content: bytes = CONTENT, **headers: str) -> dict[str, str]:
    told = {"path": path, "sha256": hashlib.sha256(content).hexdigest()}
    metadata = ",".join(f"{name} {base64.b64encode(value.encode()).decode()}" for name, value in told.items())
    return {"Tus-Resumable": "1.0.0", "Upload-Length": str(len(content)), "Upload-Metadata": metadata} | headers


def located(made: httpx.Response) -> str:
    """The path of an announced file, from the answer."""
    return urljoin(made.request.url.path, made.headers["location"])


def patch(server: Any, file: str, offset: int, data: bytes) -> httpx.Response:
    answer: httpx.Response = server.request(
        "PATCH", file, headers=STREAM | {"Upload-Offset": str(offset)}, content=data
    )
    return answer


def test_a_client_of_tus_is_told_what_there_is(server: Any, upload: str) -> None:
    answer = server.request("OPTIONS", f"{upload}/files")
    assert answer.status_code == 204
    assert answer.headers["tus-version"] == "1.0.0"
    assert answer.headers["tus-extension"] == "creation,creation-with-upload,expiration"
    assert answer.headers["tus-max-size"] == str(100 * 1000**3)


def test_a_file_is_announced_sent_in_pieces_and_asked_about(server: Any, upload: str) -> None:
    made = server.request("POST", f"{upload}/files", headers=announcement())
    file = located(made)
    assert (made.status_code, made.headers["upload-offset"]) == (201, "0")
    first = patch(server, file, 0, CONTENT[:3_000_000])
    assert (first.status_code, first.headers["upload-offset"]) == (204, "3000000")
    told = server.request("HEAD", file).headers
    assert (told["upload-offset"], told["upload-length"]) == ("3000000", str(len(CONTENT)))
    assert told["cache-control"] == "no-store"
    assert "upload-expires" in told
    behind = patch(server, file, 2_999_999, CONTENT[2_999_999:])
    assert (behind.status_code, behind.headers["upload-offset"]) == (409, "3000000")
    assert patch(server, file, 3_000_000, CONTENT[3_000_000:]).status_code == 204
    (listed,) = server.get(f"{upload}/files").json()["files"]
    assert (listed["path"], listed["offset"], listed["verified"]) == ("cam00.mp4", len(CONTENT), True)


def test_a_changed_byte_is_refused_and_the_file_sent_again(server: Any, upload: str) -> None:
    changed = b"X" + CONTENT[1:]
    headers = announcement() | STREAM
    refused = server.request("POST", f"{upload}/files", headers=headers, content=changed)
    assert (refused.status_code, refused.json()["code"]) == (422, "checksum-mismatch")
    assert server.request("POST", f"{upload}/finish").status_code == 409
    sent = server.request("POST", f"{upload}/files", headers=headers, content=CONTENT)
    assert (sent.status_code, sent.headers["upload-offset"]) == (201, str(len(CONTENT)))
    assert server.request("POST", f"{upload}/finish").status_code == 200
    late = patch(server, located(sent), len(CONTENT), b"x")
    assert (late.status_code, late.json()["code"]) == (409, "upload-finished")


@pytest.mark.parametrize(
    ("headers", "status", "code"),
    [
        ({"Tus-Resumable": "0.2.2"}, 412, "tus-version"),
        ({"Upload-Length": "-1"}, 422, "header-invalid"),
        ({"Upload-Length": "1e9"}, 422, "header-invalid"),
        ({"Upload-Length": "9" * 16}, 413, "upload-too-large"),
        ({"Upload-Metadata": "path !!"}, 422, "header-invalid"),
        ({"Upload-Metadata": "path YQ=="}, 422, "header-invalid"),
        ({"Upload-Metadata": "a " + "A" * 9000}, 422, "header-invalid"),
    ],
)
def test_a_bad_announcement_is_refused(
    server: Any, upload: str, headers: dict[str, str], status: int, code: str
) -> None:
    answer = server.request("POST", f"{upload}/files", headers=announcement() | headers)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert server.get(f"{upload}/files").json()["files"] == []


def test_bytes_come_under_their_own_media_type_and_to_files_that_exist(server: Any, upload: str) -> None:
    file = located(server.request("POST", f"{upload}/files", headers=announcement()))
    headers = STREAM | {"Upload-Offset": "0", "Content-Type": "text/plain"}
    assert server.request("PATCH", file, headers=headers, content=b"x").status_code == 415
    for missing in ("7", "x", "-1", "9" * 30):
        assert patch(server, f"{upload}/files/{missing}", 0, b"x").status_code == 404
    too_much = patch(server, file, 0, CONTENT + b"x")
    assert (too_much.status_code, too_much.json()["code"]) == (413, "upload-too-large")


def test_what_came_before_a_cut_is_kept(server: Any, upload: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The connection ends in the middle of a body; then a second client goes on, and a third takes over from it.

    However long the body is, little more than a block of it is held at a time.
    """
    blocks: list[int] = []
    append = ArrivingFile.append

    def noting(file: ArrivingFile, turn: int, data: bytes) -> None:
        blocks.append(len(data))
        append(file, turn, data)

    monkeypatch.setattr(ArrivingFile, "append", noting)
    file = located(server.request("POST", f"{upload}/files", headers=announcement()))

    async def scenario() -> None:
        async with (
            running_server(server.app) as (_, address),
            httpx.AsyncClient(base_url=f"http://{address}") as client,
        ):
            host, _, port = address.partition(":")

            async def begin(offset: int) -> asyncio.StreamWriter:
                _, writer = await asyncio.open_connection(host, int(port))
                head = STREAM | {
                    "Host": address,
                    "Upload-Offset": str(offset),
                    "Content-Length": str(len(CONTENT) - offset),
                }
                lines = "".join(f"{name}: {value}\r\n" for name, value in head.items())
                writer.write(f"PATCH {file} HTTP/1.1\r\n{lines}\r\n".encode() + CONTENT[offset : offset + 2_500_000])
                await writer.drain()
                return writer

            async def offset_from(least: int) -> int:
                while (offset := int((await client.head(file)).headers["upload-offset"])) < least:
                    await asyncio.sleep(0.01)
                return offset

            (await begin(0)).close()
            assert await offset_from(2_500_000) == 2_500_000
            stale = await begin(2_500_000)
            offset = await offset_from(4_500_000)
            headers = STREAM | {"Upload-Offset": str(offset)}
            sent = await client.patch(file, headers=headers, content=CONTENT[offset:])
            assert (sent.status_code, sent.headers["upload-offset"]) == (204, str(len(CONTENT)))
            stale.close()

    asyncio.run(scenario())
    (listed,) = server.get(f"{upload}/files").json()["files"]
    assert listed["verified"]
    assert max(blocks) < 2 * BLOCK


def test_a_client_that_sends_all_before_it_listens_hears_why_it_was_refused(server: Any, upload: str) -> None:
    async def scenario() -> None:
        async with running_server(server.app) as (_, address):
            host, _, port = address.partition(":")
            reader, writer = await asyncio.open_connection(host, int(port))
            head = STREAM | {"Host": address, "Upload-Offset": "5", "Content-Length": str(8 << 20)}
            lines = "".join(f"{name}: {value}\r\n" for name, value in head.items())
            writer.write(f"PATCH {upload}/files/7 HTTP/1.1\r\n{lines}\r\n".encode())
            for _ in range(8):
                writer.write(bytes(1 << 20))
                await asyncio.wait_for(writer.drain(), 10)
            assert (await reader.readline()).startswith(b"HTTP/1.1 404 ")
            writer.close()

    asyncio.run(scenario())
