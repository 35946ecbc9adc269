"""Prometheus metrics of the server; names and meanings are in docs/operation.md."""

from __future__ import annotations

import asyncio
import time

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

from hgs_core.base.version import software_version

__all__ = ["CONTENT_TYPE", "Metrics"]

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"

LAG_INTERVAL = 0.25  # seconds between two measurements of the event loop
_SECONDS = (0.001, 0.005, 0.025, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0)


class Metrics:
    """The counters of one server process."""

    def __init__(self) -> None:
        self.registry = registry = CollectorRegistry()
        build = Gauge("hgs_build_info", "1, with the version of the software", ["version"], registry=registry)
        build.labels(software_version()).set(1)
        self.requests = Counter(
            "hgs_requests", "HTTP requests answered", ["method", "route", "status"], registry=registry
        )
        self.request_seconds = Histogram(
            "hgs_request_seconds",
            "Seconds from a request to the end of its response",
            ["route"],
            buckets=_SECONDS,
            registry=registry,
        )
        self.sent_bytes = Counter("hgs_sent_bytes", "Bytes of bodies and messages", ["kind"], registry=registry)
        self.streams = Gauge("hgs_streams", "Streams that are open", registry=registry)
        self.stream_closes = Counter("hgs_stream_closes", "Streams that ended, by code", ["code"], registry=registry)
        self.stream_send_seconds = Histogram(
            "hgs_stream_send_seconds",
            "Seconds that a message waited for its client's connection",
            buckets=_SECONDS,
            registry=registry,
        )
        self.stream_waits = Counter(
            "hgs_stream_waits", "Clients that stopped playing while data was in transit", registry=registry
        )
        self.refused = Counter("hgs_refused_streams", "Streams refused with 503", registry=registry)
        self.lag_seconds = Gauge(
            "hgs_event_loop_lag_seconds", "Recent peak delay of the event loop, in seconds", registry=registry
        )
        self.jobs = Gauge("hgs_jobs", "Jobs by state", ["state"], registry=registry)
        self.workers = Gauge("hgs_workers", "Workers that are alive", registry=registry)
        self.lag = 0.0

    def text(self) -> bytes:
        """Return all metrics in Prometheus's text format."""
        return generate_latest(self.registry)

    async def watch_lag(self) -> None:
        """Measure the event loop's delay for ever; a peak decays within seconds."""
        while True:
            asked = time.monotonic()
            await asyncio.sleep(LAG_INTERVAL)
            self.lag = max(time.monotonic() - asked - LAG_INTERVAL, 0.8 * self.lag)
            self.lag_seconds.set(self.lag)
