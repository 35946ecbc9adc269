"""Deliveries to a receiver on this machine, by a worker's process that is killed, too."""

from __future__ import annotations

import base64
import contextlib
import hashlib
import hmac
import http.server
import json
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import SplitResult, urlsplit

import pytest
import sqlalchemy as sa

from hgs_core.runs.run_config import RunConfig
from jobs.process import lasting_thread
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from jobs.records import announcements as webhook_table
from jobs.records.announcements import Announcement, WebhookTable
from jobs.records.job import Job
from jobs.records.job_table import JobTable
from jobs.webhooks import webhook_delivery
from jobs.webhooks.webhook_delivery import WebhookDelivery, signature
from jobs.webhooks.webhook_rules import WebhookRules

SECRET = b"0123456789abcdef0123456789abcdef"
RULES = WebhookRules(frozenset({"127.0.0.1"}), SECRET, private=True)

Poll = Callable[[Callable[[], bool], str], None]


class Receiver:
    """An HTTP server that keeps its requests, and answers with the next of its statuses, or 200."""

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


@pytest.mark.parametrize("error", [UnicodeError("label empty or too long"), ValueError("embedded null"), KeyError("x")])
def test_a_name_that_no_resolver_takes_is_a_failed_try_and_keeps_nobody_waiting(
    engine: sa.Engine, ended: WebhookTable, receiver: Receiver, error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    table, rows = JobTable(engine), webhook_table._rows
    with engine.begin() as connection:  # the rows of an older version, which let them in
        for place, host in enumerate(("a..corp.example", ".corp.example")):
            table.insert(connection, Job(f"b{place}", "B", "/captures/b", {}, webhook=f"http://{host}:80/"))
        connection.execute(sa.update(rows).values(next_try=time.time()))
    for place in range(2):
        table.fail(f"b{place}", 1, "out of memory")
    with engine.begin() as connection:
        connection.execute(sa.update(rows).where(rows.c.job_id != "a").values(next_try=0.0))

    real = socket.getaddrinfo

    def look_up(host: str, *more: Any, **options: Any) -> Any:
        if host != "127.0.0.1":
            raise error
        return real(host, *more, **options)

    class Lenient(WebhookRules):
        def checked(self, url: str) -> SplitResult:
            return urlsplit(url)

    monkeypatch.setattr(socket, "getaddrinfo", look_up)
    assert WebhookDelivery(ended, Lenient(RULES.hosts, SECRET, private=True)).deliver_due() == 1
    assert len(receiver.received) == 1
    one = ended.of("b0")
    assert one is not None
    assert (one.tries, one.error) == (1, f"cannot be sent: {error}")


def test_a_row_with_a_bad_name_is_given_up_after_three_days(ended: WebhookTable, engine: sa.Engine) -> None:
    rows = webhook_table._rows
    with engine.begin() as connection:
        connection.execute(sa.update(rows).values(url="https://a..corp.example/", ended=time.time() - 4 * 86400))
    WebhookDelivery(ended, WebhookRules(frozenset({".corp.example"}), SECRET)).deliver_due()
    assert (kept(ended).tries, kept(ended).next_try) == (1, None)
    assert "is no host" in kept(ended).error


def test_a_receiver_that_answers_byte_by_byte_is_left(
    ended: WebhookTable, engine: sa.Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(webhook_delivery, "LONGEST", 0.5)
    over = threading.Event()

    def drip(listener: socket.socket) -> None:
        connection, _ = listener.accept()
        with connection, contextlib.suppress(OSError):
            while not over.wait(0.02):
                connection.sendall(b"H")

    with socket.create_server(("127.0.0.1", 0)) as listener:
        dripping = threading.Thread(target=drip, args=(listener,))
        dripping.start()
        url = f"http://127.0.0.1:{listener.getsockname()[1]}/"
        with engine.begin() as connection:
            connection.execute(sa.update(webhook_table._rows).values(url=url))
        assert WebhookDelivery(ended, RULES).deliver_due() == 0
        over.set()
        dripping.join()
    assert kept(ended).tries == 1


def test_the_thread_goes_on_after_any_fault(
    ended: WebhookTable, receiver: Receiver, wait_until: Poll, monkeypatch: pytest.MonkeyPatch
) -> None:
    faults: list[BaseException] = [OSError("cannot sleep"), SystemExit()]
    monkeypatch.setattr(lasting_thread, "PAUSE", 0.01)

    def take() -> Announcement | None:
        if faults:
            raise faults.pop()
        return WebhookTable.take(ended)

    monkeypatch.setattr(ended, "take", take)
    monkeypatch.setattr(webhook_delivery, "POLL", 0.01)
    WebhookDelivery(ended, RULES).start()
    wait_until(lambda: len(receiver.received) == 1, "the delivery")


def test_a_worker_that_is_killed_while_it_tells_loses_nothing(
    client: JobClient,
    worker: Callable[..., subprocess.Popen[bytes]],
    receiver: Receiver,
    tmp_path: Path,
    wait_until: Poll,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
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
    assert ids == {f"{job_id}.1"}  # the id for receivers


def test_a_private_address_is_not_connected_to(engine: sa.Engine, receiver: Receiver) -> None:
    table = JobTable(engine)
    with engine.begin() as connection:
        url = receiver.url.replace("http:", "https:")
        table.insert(connection, Job("a", "A", "/captures/a", {}, webhook=url))
    table.cancel("a", 1)
    WebhookDelivery(WebhookTable(engine), WebhookRules(RULES.hosts, SECRET)).deliver_due()
    assert "127.0.0.1, which is not a public address" in kept(WebhookTable(engine)).error
