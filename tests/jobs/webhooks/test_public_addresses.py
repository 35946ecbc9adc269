from __future__ import annotations

from collections.abc import Callable
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network

import pytest
from hypothesis import given
from hypothesis import strategies as st

from jobs.webhooks.public_addresses import is_public

INSIDE = [
    "0.0.0.0/8",
    "10.0.0.0/8",
    "100.64.0.0/10",
    "127.0.0.0/8",
    "169.254.0.0/16",
    "172.16.0.0/12",
    "192.0.0.0/24",
    "192.0.2.0/24",
    "192.88.99.0/24",
    "192.168.0.0/16",
    "198.18.0.0/15",
    "198.51.100.0/24",
    "203.0.113.0/24",
    "224.0.0.0/4",
    "240.0.0.0/4",
]
V6_INSIDE = [
    "fc00::/7",
    "fe80::/10",
    "fec0::/10",
    "ff00::/8",
    "100::/64",
    "2001:db8::/32",
    "3fff::/20",
    "5f00::/16",
    "64:ff9b:1::/48",
    "2001::/32",
    "::/96",
    "::ffff:0:0:0/96",
]
PUBLIC = ["93.184.215.14", "8.8.8.8", "2606:2800:21f:cb07:6820:80da:af6b:8b2c", "2a00:1450:4001:81b::200e"]
EMBEDDINGS: dict[str, Callable[[int], int]] = {
    "mapped": lambda v4: 0xFFFF << 32 | v4,
    "compatible": lambda v4: v4,
    "translated": lambda v4: 0xFFFF << 48 | v4,
    "NAT64": lambda v4: 0x64_FF9B << 96 | v4,
    "local NAT64": lambda v4: 0x64_FF9B_0001 << 80 | v4,
    "6to4": lambda v4: 0x2002 << 112 | v4 << 80 | 1,
    "Teredo": lambda v4: 0x2001_0000 << 96 | 0x5DB8_D70E << 64 | (v4 ^ 0xFFFF_FFFF),
    "Teredo's server": lambda v4: 0x2001_0000 << 96 | v4 << 64,
    "ISATAP": lambda v4: 0x2A00_1450 << 96 | 0x0200_5EFE << 32 | v4,
    "local ISATAP": lambda v4: 0x2A00_1450 << 96 | 0x0000_5EFE << 32 | v4,
}


def within(networks: list[str]) -> st.SearchStrategy[IPv4Address]:
    return st.sampled_from(networks).flatmap(lambda one: st.ip_addresses(v=4, network=one))  # type: ignore[arg-type]


@given(within(INSIDE))
def test_no_address_of_a_special_network_is_public(address: IPv4Address) -> None:
    assert not is_public(str(address))


@pytest.mark.parametrize("kind", EMBEDDINGS)
@given(address=within(INSIDE))
def test_nor_is_one_that_leads_to_it(kind: str, address: IPv4Address) -> None:
    assert not is_public(str(IPv6Address(EMBEDDINGS[kind](int(address)))))


@given(st.sampled_from(V6_INSIDE).flatmap(lambda one: st.ip_addresses(v=6, network=IPv6Network(one))))  # type: ignore[arg-type]
def test_nor_is_one_of_a_special_network_of_version_6(address: IPv6Address) -> None:
    assert not is_public(str(address))
    assert not is_public(f"{address}%eth0")


@given(st.ip_addresses(v=4).filter(lambda one: not any(one in IPv4Network(network) for network in INSIDE)))
def test_all_others_of_version_4_are_public_also_behind_nat64(address: IPv4Address) -> None:
    assert is_public(str(address))
    for kind in ("mapped", "NAT64", "6to4", "ISATAP"):
        assert is_public(str(IPv6Address(EMBEDDINGS[kind](int(address)))))


@pytest.mark.parametrize("address", PUBLIC)
def test_hosts_of_the_internet_are_public(address: str) -> None:
    assert is_public(address)
