from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterator
from typing import Any

import pytest

from jobs.records.job import JobState

FILES = {"cam00.mp4": b"a video" * 50, "sparse/0/cameras.txt": b"poses"}
TUS = {"Tus-Resumable": "1.0.0"}


@pytest.fixture(autouse=True)
def _one_server(server: Any) -> Iterator[None]:
    yield
    server.app.state.service.uploads.close()


def begin(server: Any, **fields: Any) -> Any:
    body = {"name": "studio", "files": len(FILES), "bytes": sum(map(len, FILES.values())), "key": "k"} | fields
    return server.request("POST", "/v1/uploads", json=body)


def announce(server: Any, upload: str, path: str, content: bytes, body: bytes = b"") -> Any:
    told = {"path": path, "sha256": hashlib.sha256(content).hexdigest()}
    metadata = ",".join(f"{name} {base64.b64encode(value.encode()).decode()}" for name, value in told.items())
    headers = TUS | {"Upload-Length": str(len(content)), "Upload-Metadata": metadata}
    headers |= {"Content-Type": "application/offset+octet-stream"} if body else {}
    return server.request("POST", f"/v1/uploads/{upload}/files", headers=headers, content=body)


def sent(server: Any) -> str:
    upload: str = begin(server).json()["id"]
    for path, content in FILES.items():
        assert announce(server, upload, path, content, content).status_code == 201
    return upload


def test_an_upload_is_begun_sent_finished_listed_and_deleted(server: Any) -> None:
    begun = begin(server)
    assert (begun.status_code, begin(server).status_code) == (201, 200)
    upload = begun.json()
    assert begun.headers["location"] == f"uploads/{upload['id']}"
    assert (upload["state"], upload["received"], upload["capture"]) == ("receiving", 0, None)
    sent(server)
    assert server.get(f"/v1/{begun.headers['location']}").json()["received"] == upload["bytes"]
    finished = server.request("POST", f"/v1/uploads/{upload['id']}/finish")
    assert finished.status_code == 200
    capture = finished.json()["capture"]
    (listed,) = [one for one in server.get("/v1/captures").json()["captures"] if one["capture"] == capture]
    assert listed["name"] == "studio"
    told = server.get("/v1/uploads").json()
    assert ([one["id"] for one in told["uploads"]], told["limits"]["files"]) == ([upload["id"]], 20_000)
    assert server.request("DELETE", f"/v1/uploads/{upload['id']}").status_code == 204
    gone = server.get(f"/v1/uploads/{upload['id']}")
    assert (gone.status_code, gone.json()["code"]) == (404, "upload-not-found")
    assert capture not in server.get("/v1/captures").text


def test_a_capture_stays_while_a_job_needs_it(server: Any) -> None:
    upload = sent(server)
    capture = server.request("POST", f"/v1/uploads/{upload}/finish").json()["capture"]
    job = server.request("POST", "/v1/jobs", json={"capture": f"{capture}/sparse"}).json()["id"]
    refused = server.request("DELETE", f"/v1/uploads/{upload}")
    assert (refused.status_code, refused.json()["code"]) == (409, "capture-in-use")
    assert job in refused.json()["detail"]
    server.jobs.change(job, state=JobState.SUCCEEDED)
    assert server.request("DELETE", f"/v1/uploads/{upload}").status_code == 204


def test_nothing_unfinished_can_be_trained(server: Any) -> None:
    upload = sent(server)
    folder = server.home.folder / "uploads" / upload / "data"
    assert server.request("POST", "/v1/jobs", json={"capture": str(folder)}).status_code == 403
    early = begin(server, key="other").json()["id"]
    refused = server.request("POST", f"/v1/uploads/{early}/finish")
    assert (refused.status_code, refused.json()["code"]) == (409, "upload-incomplete")


@pytest.mark.parametrize(
    ("fields", "status", "code", "field"),
    [
        ({"files": 20_001}, 413, "upload-too-large", "files"),
        ({"bytes": 2 * 10**14}, 413, "upload-too-large", "bytes"),
        ({"files": 0}, 422, "body-invalid", "files"),
        ({"bytes": -1}, 422, "body-invalid", "bytes"),
        ({"bytes": 1e300}, 422, "body-invalid", "bytes"),
        ({"name": ""}, 422, "body-invalid", "name"),
        ({"path": "/etc"}, 422, "body-invalid", "path"),
    ],
)
def test_what_cannot_begin_is_refused(server: Any, fields: dict[str, Any], status: int, code: str, field: str) -> None:
    answer = begin(server, **fields)
    told = answer.json()
    assert (answer.status_code, told["code"], told["field"]) == (status, code, field)
    assert server.get("/v1/uploads").json()["uploads"] == []


@pytest.mark.parametrize(
    ("method", "path"),
    [("POST", ""), ("POST", "/x/finish"), ("DELETE", "/x"), ("POST", "/x/files"), ("PATCH", "/x/files/0")],
)
def test_pages_of_other_sites_change_nothing(server: Any, method: str, path: str) -> None:
    headers = TUS | {"Origin": "https://evil.example", "Content-Type": "application/offset+octet-stream"}
    answer = server.request(method, f"/v1/uploads{path}", headers=headers, content=b"x")
    assert (answer.status_code, answer.json()["code"]) == (403, "origin-not-allowed")


def test_one_address_has_so_many_unfinished_uploads_and_no_more(server: Any) -> None:
    assert [begin(server, key=str(number)).status_code for number in range(4)] == [201] * 4
    refused = begin(server, key="4")
    assert (refused.status_code, refused.json()["code"], refused.headers["retry-after"]) == (429, "uploads-open", "60")
    assert begin(server, key="3").status_code == 200


@pytest.mark.parametrize(("method", "status"), [("POST", 422), ("OPTIONS", 405)])
def test_a_tus_client_is_told_its_endpoint(server: Any, method: str, status: int) -> None:
    """The first request of a client that was given /v1/uploads."""
    metadata = {"Upload-Length": "5", "Upload-Metadata": f"filename {base64.b64encode(b'cam00.mp4').decode()}"}
    answer = server.request(method, "/v1/uploads", headers=TUS | (metadata if method == "POST" else {}))
    assert (answer.status_code, answer.json()["code"]) == (status, "tus-endpoint")
    assert "give the tus client the endpoint /v1/uploads/{id}/files" in answer.json()["detail"]
    assert server.get("/v1/uploads").json()["uploads"] == []


def test_metadata_that_tus_clients_send_by_themselves_do_not_suffice(server: Any) -> None:
    upload = begin(server).json()["id"]
    metadata = {"Upload-Length": "5", "Upload-Metadata": f"filename {base64.b64encode(b'cam00.mp4').decode()}"}
    answer = server.request("POST", f"/v1/uploads/{upload}/files", headers=TUS | metadata)
    assert (answer.status_code, answer.json()["code"], answer.json()["field"]) == (422, "header-invalid", "sha256")
    assert "give 64 hexadecimal digits" in answer.json()["detail"]
