"""Where a page is said to be, and the names that are allowed to reach it."""

from __future__ import annotations

import ipaddress
import socket
from types import SimpleNamespace

import ifaddr
import pytest

from app.cli.options.serving_options import announce
from app.front.origin import interface_addresses, local_address, network_addresses
from cli.calling import refusal

ADAPTERS = [
    SimpleNamespace(ips=[SimpleNamespace(ip="127.0.0.1"), SimpleNamespace(ip=("::1", 0, 0))]),
    SimpleNamespace(
        ips=[
            SimpleNamespace(ip="192.0.2.7"),
            SimpleNamespace(ip=("fe80::1", 0, 3)),
            SimpleNamespace(ip=("2001:db8::7", 0, 0)),
        ]
    ),
    SimpleNamespace(ips=[SimpleNamespace(ip="169.254.1.1"), SimpleNamespace(ip="198.51.100.2")]),
]


@pytest.fixture
def adapters(monkeypatch):
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: ADAPTERS)
    monkeypatch.setattr(socket, "gethostname", lambda: "Lab7")


@pytest.mark.usefixtures("adapters")
@pytest.mark.parametrize(
    ("host", "addresses"),
    [
        ("0.0.0.0", ["http://192.0.2.7:8080", "http://198.51.100.2:8080", "http://lab7:8080"]),
        ("::", ["http://[2001:db8::7]:8080", "http://lab7:8080"]),
        ("192.0.2.7", ["http://192.0.2.7:8080"]),
        ("2001:db8::7", ["http://[2001:db8::7]:8080"]),
        ("127.0.0.1", []),
        ("localhost", []),
        ("::1", []),
    ],
)
def test_addresses_that_others_can_use(host, addresses):
    assert network_addresses(host, 8080) == addresses


@pytest.mark.usefixtures("adapters")
def test_they_are_printed_with_a_warning(capsys):
    announce("0.0.0.0", 8080, "Ctrl-C stops it", "press every button")
    told = capsys.readouterr()
    assert told.out.splitlines() == [
        "flockscope is at http://localhost:8080 (Ctrl-C stops it)",
        "from other machines at http://192.0.2.7:8080 or http://198.51.100.2:8080 or "
        "http://lab7:8080",
    ]
    assert told.err == "warning: --host 0.0.0.0 lets anyone in the network press every button\n"


def test_of_a_page_for_this_machine_nothing_more_is_said(capsys):
    announce("127.0.0.1", 8080, "Ctrl-C stops it", "press every button")
    told = capsys.readouterr()
    assert (told.out.count("\n"), told.err) == (1, "")
    assert local_address("::1", 80) == "http://[::1]:80"


def test_the_addresses_are_this_machine_s_own():
    for version in (4, 6):
        for one in interface_addresses(version):
            address = ipaddress.ip_address(one)
            assert address.version == version
            assert not address.is_loopback
            family = socket.AF_INET if version == 4 else socket.AF_INET6
            with socket.socket(family, socket.SOCK_DGRAM) as sock:
                sock.bind((one, 0))


@pytest.mark.parametrize("command", [["lab"], ["live", "lab"]])
def test_a_name_that_is_none_ends_with_one_line_before_anything_is_served(command):
    names = ["--allow-host", "good.example.org", "--allow-host", "https://hub.example.org/"]
    said = refusal(*command, "--no-open", "--port", 0, *names)
    assert "--allow-host 'https://hub.example.org/' is not a host name" in said
