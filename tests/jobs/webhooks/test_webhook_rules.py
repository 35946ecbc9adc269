from __future__ import annotations

import base64
import socket
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from jobs.webhooks.webhook_rules import WebhookRules

SECRET = "s" * 32
RULES = WebhookRules(frozenset({"hooks.example.org", ".acme.example"}), SECRET.encode())


def test_the_settings_are_read() -> None:
    given = {"HGS_WEBHOOK_HOSTS": "Hooks.example.org, .acme.example", "HGS_WEBHOOK_SECRET": SECRET}
    assert WebhookRules.configured(given) == RULES
    encoded = {**given, "HGS_WEBHOOK_SECRET": "whsec_" + base64.b64encode(SECRET.encode()).decode()}
    assert WebhookRules.configured(encoded) == RULES
    assert WebhookRules.configured({**given, "HGS_WEBHOOK_PRIVATE": "1"}).private


@pytest.mark.parametrize("secret", ["", "short", "whsec_%%"])
def test_hosts_need_a_secret(secret: str) -> None:
    with pytest.raises(InputError, match="HGS_WEBHOOK_SECRET"):
        WebhookRules.configured({"HGS_WEBHOOK_HOSTS": "a.example", "HGS_WEBHOOK_SECRET": secret})


def test_the_secret_is_not_shown() -> None:
    assert SECRET not in repr(RULES)


@pytest.mark.parametrize(
    "url", ["https://hooks.example.org/a?b=c", "https://x.acme.example:8443", "https://HOOKS.example.org"]
)
def test_named_hosts_are_allowed(url: str) -> None:
    RULES.checked(url)


@pytest.mark.parametrize(
    "url",
    [
        "http://hooks.example.org/",
        "ftp://hooks.example.org/",
        "file:///etc/passwd",
        "https://other.example/",
        "https://acme.example/",
        "https://notacme.example/",
        "https://hooks.example.org.evil.example/",
        "https://user@hooks.example.org/",
        "https://hooks.example.org@evil.example/",
        "https://hooks.example.org:0/",
        "https://hooks.example.org:x/",
        "https://hooks.example.org/a b",
        "https://hooks.example.org/\r\nX: y",
        "nonsense",
        "https://hooks.example.org/#a",
        "https://[::1/",
        "https://127.0.0.1/",
        "https://hooks.example.org/" + "a" * 2000,
        "https://a..acme.example/",
        "https://.acme.example/",
        "https://a.b...acme.example/",
        f"https://{'a' * 64}.acme.example/",
        f"https://{'a.' * 130}acme.example/",
        "https://-a.acme.example/",
        "https://a-.acme.example/",
        "https://a%2f.acme.example/",
        "https://a*.acme.example/",
        "https://b\u00fcro.acme.example/",
        "https://a_.acme.example./",
        "https://[fe80::1%25eth0]/",
        "https://a,.acme.example",
    ],
)
def test_everything_else_is_refused(url: str) -> None:
    with pytest.raises(InputError, match="webhook"):
        RULES.checked(url)


@pytest.mark.parametrize(
    "host", ["https://a.example", "a..example", ".", "a.example/x", "a.example:x", "*.a.example", "[::1"]
)
def test_a_setting_that_names_no_host_is_refused(host: str) -> None:
    with pytest.raises(InputError, match="is no host; give names, separated by commas"):
        WebhookRules.configured({"HGS_WEBHOOK_HOSTS": f"b.example,{host}", "HGS_WEBHOOK_SECRET": SECRET})


def test_a_host_with_a_port_is_allowed_with_that_port_alone() -> None:
    rules = WebhookRules(
        frozenset({"a.example:8443", ".b.example:443", "[2001:4860::8]:9", "2a00:1450::1"}), SECRET.encode()
    )
    for url in (
        "https://a.example:8443/",
        "https://x.b.example/",
        "https://[2001:4860::8]:9/",
        "https://[2a00:1450::1]:7/",
    ):
        rules.checked(url)
    for url in ("https://a.example/", "https://x.b.example:444/", "https://[2001:4860::8]/"):
        with pytest.raises(InputError, match="may be told"):
            rules.checked(url)


@given(st.text(st.sampled_from("abz09-_.%:[]@\u00fc\u0130"), max_size=80))
def test_what_is_allowed_can_be_looked_up(name: str) -> None:
    try:
        parts = RULES.checked(f"https://{name}.acme.example/")
    except InputError:
        return
    assert parts.hostname is not None
    parts.hostname.encode("idna")  # getaddrinfo's encoding


def test_without_settings_there_are_no_webhooks() -> None:
    with pytest.raises(InputError, match="HGS_WEBHOOK_HOSTS"):
        WebhookRules().checked("https://hooks.example.org/")


@pytest.mark.parametrize(
    "address",
    [
        "127.0.0.1",
        "10.0.0.5",
        "192.168.1.1",
        "172.16.0.1",
        "169.254.169.254",
        "0.0.0.0",
        "100.64.0.1",
        "224.0.0.1",
        "::1",
        "fe80::1",
        "fd00::1",
        "fec0::1",
        "64:ff9b::a00:1",
        "::10.0.0.1",
        "::ffff:0:7f00:1",
        "::ffff:127.0.0.1",
        "::ffff:10.0.0.1",
        "2002:7f00:1::",
        "::",
    ],
)
def test_a_name_that_leads_to_a_private_address_is_refused(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[Any] = [(0, 0, 0, "", ("93.184.215.14", 443)), (0, 0, 0, "", (address, 443))]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: found)
    parts = RULES.checked("https://hooks.example.org/")
    with pytest.raises(PermissionError, match="not a public address"):
        RULES.addresses(parts)
    inside = WebhookRules(RULES.hosts, RULES.secret, private=True)
    assert inside.addresses(parts) == ["93.184.215.14", address]
