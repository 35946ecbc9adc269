"""Deliveries to a receiver on this machine, by a worker's process that is killed, too."""

from __future__ import annotations

import base64
import hashlib
import hmac
import http.server
import json
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import sqlalchemy as sa

from hgs_core.runs.config import RunConfig
from jobs import webhook_table
from jobs.client import JobClient
from jobs.job import Job
from jobs.job_request import JobRequest
from jobs.store import JobTable
from jobs.webhook_delivery import WebhookDelivery, signature
from jobs.webhook_rules import WebhookRules
from jobs.webhook_table import Announcement, WebhookTable

SECRET = b"0123456789abcdef0123456789abcdef"
RULES = WebhookRules(frozenset({"127.0.0.1"}), SECRET, private=True)

Poll = Callable[[Callable[[], bool], str], None]


class Receiver:
    """An HTTP server that keeps what it is sent, and answers with the next of its statuses, or 200."""

    def __init__(self) -> None:
        self.received: list[tuple[str, dict[str, str], bytes]] = []
        self.statuses: list[int] = []
        self.hold = threading.Event()
        self.hold.set()
        receiver = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                receiver.received.append((self.path, {k.lower(): v for k, v in self.headers.items()}, body))
                receiver.hold.wait(120)
                self.send_response(receiver.statuses.pop(0) if receiver.statuses else 200)
                self.send_header("Location", "/elsewhere")
                self.end_headers()

            def log_message(self, *_: object) -> None:
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/ends?of=jobs"
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()


@pytest.fixture
def receiver() -> Iterator[Receiver]:
    receiver = Receiver()
    yield receiver
    receiver.hold.set()
    receiver.server.shutdown()
    receiver.server.server_close()


@pytest.fixture
def ended(engine: sa.Engine, receiver: Receiver) -> WebhookTable:
    """The end of a job is to be told to the receiver."""
    table = JobTable(engine)
    with engine.begin() as connection:
        table.insert(connection, Job("a", "A", "/captures/a", {}, webhook=receiver.url))
    table.fail("a", 1, "out of memory")
    return WebhookTable(engine)


def kept(table: WebhookTable) -> Announcement:
    one = table.of("a")
    assert one is not None
    return one


def test_an_end_arrives_signed(ended: WebhookTable, receiver: Receiver) -> None:
    assert WebhookDelivery(ended, RULES).deliver_due() == 1
    ((path, headers, body),) = receiver.received
    assert (path, headers["content-type"], headers["webhook-id"]) == ("/ends?of=jobs", "application/json", "a.1")
    assert json.loads(body)["data"]["error"] == "out of memory"
    signed = f"a.1.{headers['webhook-timestamp']}.".encode() + body
    expected = base64.b64encode(hmac.new(SECRET, signed, hashlib.sha256).digest()).decode()
    assert headers["webhook-signature"] == f"v1,{expected}"
    assert WebhookDelivery(ended, RULES).deliver_due() == 0  # and once


def test_the_signature_is_that_of_the_standards_example() -> None:
    """Standard Webhooks, the reference libraries' test vector."""
    secret = base64.b64decode("MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw")
    found = signature(secret, "msg_p5jXN8AQM9LWM0D4loKWxJek", 1614265330, b'{"test": 2432232314}')
    assert found == "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="


@pytest.mark.parametrize("status", [500, 404, 302])
def test_what_is_not_taken_is_tried_again(ended: WebhookTable, receiver: Receiver, status: int) -> None:
    receiver.statuses = [status]
    assert WebhookDelivery(ended, RULES).deliver_due() == 0
    assert len(receiver.received) == 1  # a redirection is not followed
    assert kept(ended).error == f"the receiver answered {status}"
    assert kept(ended).next_try is not None


def test_a_receiver_that_is_gone_is_left_alone(ended: WebhookTable, receiver: Receiver) -> None:
    receiver.statuses = [410]
    WebhookDelivery(ended, RULES).deliver_due()
    assert kept(ended).next_try is None


def test_a_host_that_is_no_longer_allowed_is_not_asked(ended: WebhookTable, receiver: Receiver) -> None:
    WebhookDelivery(ended, WebhookRules(frozenset({"hooks.example.org"}), SECRET, private=True)).deliver_due()
    assert receiver.received == []
    assert "not a host that may be told" in kept(ended).error


def test_a_worker_that_is_killed_while_it_tells_loses_nothing(
    client: JobClient, worker: Callable[..., subprocess.Popen[bytes]], receiver: Receiver, tmp_path: Path,
    wait_until: Poll, monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    for name, value in (("HOSTS", "127.0.0.1"), ("SECRET", SECRET.decode()), ("PRIVATE", "1")):
        monkeypatch.setenv(f"HGS_WEBHOOK_{name}", value)
    (tmp_path / "behaviour").write_text("count")
    job_id = client.submit(JobRequest(tmp_path, RunConfig(), webhook=receiver.url))
    client.cancel(job_id)
    receiver.hold.clear()
    first = worker()
    wait_until(lambda: len(receiver.received) == 1, "the first try")
    first.kill()
    first.wait()
    receiver.hold.set()
    with client._engine.begin() as connection:  # so that nobody waits for a minute
        connection.execute(sa.update(webhook_table._rows).values(next_try=0.0))
    worker()
    wait_until(lambda: (told := client.announcement(job_id)) is not None and told.delivered > 0, "the delivery")
    ids = {headers["webhook-id"] for _, headers, _ in receiver.received}
    assert ids == {f"{job_id}.1"}  # by which a receiver knows it again


def test_a_private_address_is_not_connected_to(engine: sa.Engine, receiver: Receiver) -> None:
    table = JobTable(engine)
    with engine.begin() as connection:
        url = receiver.url.replace("http:", "https:")
        table.insert(connection, Job("a", "A", "/captures/a", {}, webhook=url))
    table.cancel("a", 1)
    WebhookDelivery(WebhookTable(engine), WebhookRules(RULES.hosts, SECRET)).deliver_due()
    assert "127.0.0.1, which is not a public address" in kept(WebhookTable(engine)).error
