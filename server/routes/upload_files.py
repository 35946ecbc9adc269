"""`/v1/uploads/{id}/files`: files of an upload, each a resource of the protocol tus 1.0 (docs/upload.md)."""

from __future__ import annotations

import base64
import binascii
import re
from email.utils import formatdate

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect

from server.http.conditional import respond_json
from server.http.problems import ProblemError
from server.service import Service, ServiceDep
from server.uploads.arriving_file import ArrivingFile
from server.uploads.upload import Upload

__all__ = ["router"]

router = APIRouter(prefix="/v1/uploads/{upload_id}/files")

VERSION = "1.0.0"
BLOCK = 1 << 20  # bytes written at a time; no more of a body is held in memory
OFFSET_STREAM = "application/offset+octet-stream"

_NUMBER = re.compile("0|[1-9][0-9]{0,15}")
_SHA256 = re.compile("[0-9a-f]{64}")
_LONGEST_METADATA = 8192  # characters


@router.options("")
def options(upload_id: str, service: ServiceDep) -> Response:
    """Return the supported version and extensions of tus."""
    headers = {
        "Tus-Resumable": VERSION,
        "Tus-Version": VERSION,
        "Tus-Extension": "creation,creation-with-upload,expiration",
        "Tus-Max-Size": str(service.uploads.limits.file),
    }
    return Response(status_code=204, headers=headers)


@router.api_route("", methods=["GET", "HEAD"])
def list_files(request: Request, upload_id: str, service: ServiceDep) -> Response:
    """List the announced files with their received bytes."""
    return respond_json(request, {"files": service.uploads.get(upload_id).describe_files()})


@router.post("")
async def announce(request: Request, upload_id: str, service: ServiceDep) -> Response:
    """Announce a file, and receive any bytes in the request."""
    _require_tus(service, request)
    length = _number(request, "Upload-Length")
    metadata = _metadata(request.headers.get("Upload-Metadata", ""))
    upload = await run_in_threadpool(service.uploads.get, upload_id)
    file = await run_in_threadpool(_add, service, upload, metadata, length)
    if request.headers.get("Content-Type", "") == OFFSET_STREAM and not file.verified:
        await _receive(service, upload, file, request, 0)
    headers = {"Location": f"files/{file.number}"}
    return Response(status_code=201, headers=headers | _state(service, upload, file))


@router.head("/{number}")
def how_far(request: Request, upload_id: str, number: str, service: ServiceDep) -> Response:
    """Return the offset of a file."""
    upload = service.uploads.get(upload_id)
    file = _file(upload, number)
    headers = {"Upload-Length": str(file.size), "Cache-Control": "no-store"}
    return Response(status_code=200, headers=headers | _state(service, upload, file))


@router.patch("/{number}")
async def go_on(request: Request, upload_id: str, number: str, service: ServiceDep) -> Response:
    """Receive the next bytes of a file."""
    _require_tus(service, request)
    media_type = request.headers.get("Content-Type", "")
    if media_type != OFFSET_STREAM:
        detail = f"Content-Type is {media_type[:80] or 'missing'}; send {OFFSET_STREAM}"
        raise ProblemError(415, "body-not-bytes", detail)
    offset = _number(request, "Upload-Offset")
    upload = await run_in_threadpool(service.uploads.get, upload_id)
    file = _file(upload, number)
    await _receive(service, upload, file, request, offset)
    return Response(status_code=204, headers=_state(service, upload, file))


async def _receive(service: Service, upload: Upload, file: ArrivingFile, request: Request, offset: int) -> None:
    """Append the body in blocks; bytes received before an interruption are kept."""
    upload.require_unfinished()
    service.uploads.require_room()
    # Waits while the file is being verified.
    turn = await service.long_work.run(file.begin, offset)
    upload.heard_of()
    waiting = bytearray()
    try:
        async for part in request.stream():
            waiting += part
            if len(waiting) >= BLOCK:
                await service.file_work.run(file.append, turn, bytes(waiting))
                waiting.clear()
                service.uploads.require_room()
    except ClientDisconnect:
        if waiting:
            await service.file_work.run(file.append, turn, bytes(waiting))
        raise
    if waiting:
        await service.file_work.run(file.append, turn, bytes(waiting))
    upload.heard_of()


def _add(service: Service, upload: Upload, metadata: dict[str, str], length: int) -> ArrivingFile:
    path, sha256 = metadata.get("path", ""), metadata.get("sha256", "").lower()
    if not _SHA256.fullmatch(sha256):
        detail = f"sha256 {sha256[:80]!r} in Upload-Metadata is not the SHA-256 of the file; give 64 hexadecimal digits"
        raise ProblemError(422, "header-invalid", detail, field="sha256")
    return upload.add(path, length, sha256, service.uploads.limits)


def _require_tus(service: Service, request: Request) -> None:
    service.origins.require_same_site(request)
    version = request.headers.get("Tus-Resumable", "")
    if version != VERSION:
        detail = f"Tus-Resumable is {version[:20] or 'missing'}; send {VERSION}"
        raise ProblemError(412, "tus-version", detail, headers={"Tus-Version": VERSION})


def _number(request: Request, name: str) -> int:
    text = request.headers.get(name, "")
    if not _NUMBER.fullmatch(text):
        detail = f"{name} is {text[:40]!r}; give a number of bytes" if text else f"{name} is missing"
        raise ProblemError(422, "header-invalid", detail, field=name)
    return int(text)


def _metadata(text: str) -> dict[str, str]:
    """Parse pairs of a name and its value in Base64, separated by commas."""
    if len(text) > _LONGEST_METADATA:
        detail = f"Upload-Metadata has {len(text)} characters; at most {_LONGEST_METADATA} are allowed"
        raise ProblemError(422, "header-invalid", detail, field="Upload-Metadata")
    found: dict[str, str] = {}
    for pair in filter(None, (pair.strip() for pair in text.split(","))):
        name, _, value = pair.partition(" ")
        try:
            found[name] = base64.b64decode(value.strip(), validate=True).decode()
        except (binascii.Error, UnicodeDecodeError) as error:
            detail = f"{name[:40]!r} in Upload-Metadata is not UTF-8 in Base64"
            raise ProblemError(422, "header-invalid", detail, field="Upload-Metadata") from error
    return found


def _file(upload: Upload, number: str) -> ArrivingFile:
    upload.require_unfinished()
    return upload.file(int(number) if _NUMBER.fullmatch(number) else -1)


def _state(service: Service, upload: Upload, file: ArrivingFile) -> dict[str, str]:
    expires = upload.last_byte + 3600 * service.uploads.limits.hours
    return {
        "Tus-Resumable": VERSION,
        "Upload-Offset": str(file.offset),
        "Upload-Expires": formatdate(expires, usegmt=True),
    }
