from __future__ import annotations

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.requests import HTTPConnection

from server.access.direct_requests import sign_of_proxy

# As the documentation of each has it.
SET_BY_PROXIES = [
    "Forwarded",
    "X-Forwarded-For",
    "X-Forwarded-Host",
    "X-Forwarded-Proto",
    "X-Forwarded-Port",
    "X-Forwarded-Server",
    "X-Forwarded-Prefix",
    "X-Forwarded-Ssl",
    "X-Forwarded-Client-Cert",
    "Forwarded-For",
    "X-Forwarded",
    "Via",
    "X-Real-IP",
    "X-Client-IP",
    "X-Cluster-Client-IP",
    "X-ProxyUser-Ip",
    "X-Original-URL",
    "X-Original-Forwarded-For",
    "X-Original-Host",
    "X-Rewrite-URL",
    "X-Remote-Addr",
    "X-Remote-IP",
    "Remote-User",
    "Client-IP",
    "True-Client-IP",
    "CF-Connecting-IP",
    "CF-Connecting-IPv6",
    "CF-Ray",
    "CF-IPCountry",
    "CF-Visitor",
    "CDN-Loop",
    "Fastly-Client-IP",
    "Fastly-FF",
    "Fly-Client-IP",
    "Akamai-Origin-Hop",
    "Incap-Client-IP",
    "X-Envoy-External-Address",
    "X-Amzn-Trace-Id",
    "X-Amz-Cf-Id",
    "X-Azure-ClientIP",
    "X-Azure-FDID",
    "X-AppEngine-User-IP",
    "X-ARR-SSL",
    "X-Varnish",
    "X-Scheme",
    "X-NginX-Proxy",
    "X-Request-Start",
    "X-Host",
    "WL-Proxy-Client-IP",
    "Tailscale-User-Login",
    "Front-End-Https",
    "Proxy-Connection",
    "X-Coming-From",
    "SSL-Client-Cert",
]
DIRECT = {
    "Host": "127.0.0.1:8000",
    "User-Agent": "Mozilla/5.0",
    "Accept": "*/*",
    "Accept-Encoding": "gzip, br, zstd",
    "Accept-Language": "en",
    "Connection": "keep-alive",
    "Sec-Fetch-Site": "same-origin",
    "Cookie": "a=b",
    "Referer": "http://127.0.0.1:8000/",
    "Origin": "http://127.0.0.1:8000",
    "Upgrade-Insecure-Requests": "1",
    "Sec-CH-UA": '"x"',
    "X-Request-Id": "1",
    "X-Requested-With": "fetch",
    "Cache-Control": "no-cache",
    "DNT": "1",
    "Tus-Resumable": "1.0.0",
    "If-None-Match": '"a"',
    "Range": "bytes=0-1",
    "Priority": "u=1",
    "TE": "trailers",
    "Traceparent": "00-1",
    "Upload-Offset": "0",
    "Idempotency-Key": "k",
    "Content-Length": "0",
}


def sign(headers: dict[str, str], peer: str | None = "127.0.0.1", version: str = "1.1") -> str | None:
    named = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
    client = None if peer is None else (peer, 50000)
    return sign_of_proxy(HTTPConnection({"type": "http", "headers": named, "client": client, "http_version": version}))


def test_what_browsers_and_programs_on_this_machine_send_shows_none() -> None:
    assert sign(DIRECT) is None
    assert sign({"Host": "127.0.0.1:8000", "Connection": "Upgrade", "Upgrade": "websocket"}) is None
    assert sign({"Host": "127.0.0.1:8000", "Connection": "keep-alive, Upgrade", "Upgrade": "websocket"}) is None


@pytest.mark.parametrize("name", SET_BY_PROXIES)
def test_every_header_of_a_proxy_does(name: str) -> None:
    for written in (name, name.lower(), name.upper()):
        assert sign(DIRECT | {written: "192.0.2.1"}) == f"the header {name.title()}"
        assert sign(DIRECT | {written: ""}) == f"the header {name.title()}"


@given(st.sampled_from(["X-Forwarded-", "Forwarded-", "CF-", "X-Envoy-"]), st.text(string.ascii_letters, min_size=1))
def test_so_does_one_that_nobody_has_thought_of(family: str, rest: str) -> None:
    assert sign(DIRECT | {family + rest: "x"}) is not None


@pytest.mark.parametrize(
    "host", ["localhost", "LOCALHOST:80", "hgs.localhost", "127.0.0.1", "127.8.8.8:1", "[::1]:8000"]
)
def test_names_of_this_machine_show_none(host: str) -> None:
    page = {"Origin": f"http://{host}", "Referer": f"http://{host}/"}
    assert sign(DIRECT | page | {"Host": host}) is None


@pytest.mark.parametrize(
    "host",
    [
        "203.0.113.5",
        "203.0.113.5:8000",
        "10.0.0.1",
        "192.168.1.2:80",
        "0.0.0.0:8000",
        "[2001:db8::1]",
        "[fe80::1]:1",
        "scenes.example.org",
        "localhost.example.org",
        "hgs_backend",
        "",
        "[",
        "::1]",
        "127.0.0.1.nip.io",
        "127.1",
        "2130706433",
        "[::ffff:10.0.0.1]",
        "localhost:99999999",
    ],
)
def test_any_other_host_does(host: str) -> None:
    assert sign({"Host": host}) is not None
    assert sign({}) == "no Host"


@pytest.mark.parametrize("peer", ["192.0.2.7", "10.0.0.1", "2001:db8::1", "::ffff:10.0.0.1", "unix", "", None])
def test_a_peer_that_is_not_this_machine_does(peer: str | None) -> None:
    assert sign(DIRECT, peer) is not None


@pytest.mark.parametrize("peer", ["127.0.0.1", "127.0.0.2", "::1", "::ffff:127.0.0.1"])
def test_this_machine_has_several_addresses(peer: str) -> None:
    assert sign(DIRECT, peer) is None


def test_how_proxies_speak_gives_them_away() -> None:
    assert sign(DIRECT, version="1.0") == "HTTP/1.0"
    assert sign(DIRECT | {"Connection": "close"}) == "Connection: close"
    assert sign(DIRECT | {"Connection": "TE, Close"}) == "Connection: close"
    assert sign(DIRECT | {"Connection": "upgrade"}) == "Connection: upgrade"


@pytest.mark.parametrize("name", ["Origin", "Referer"])
def test_a_page_with_another_address_that_says_it_is_ours_does(name: str) -> None:
    assert sign(DIRECT | {name: "https://scenes.example.org/view/a"}) == "a page that has another address"
    assert sign(DIRECT | {name: "https://scenes.example.org", "Sec-Fetch-Site": "cross-site"}) is None
    assert sign(DIRECT | {name: "null"}) is None
