"""Token, Host and Origin."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_cockpit.access import Access, new_token

LOCAL = Access("secret", loopback=True)


def test_tokens_are_long_and_differ_unless_the_environment_has_one(monkeypatch):
    assert len(new_token()) >= 32
    assert new_token() != new_token()
    monkeypatch.setenv("JUPYTER_TOKEN", "given")
    assert new_token() == "given"
    monkeypatch.setenv("JUPYTER_TOKEN", "")  # as docker compose passes one that is not set
    assert len(new_token()) >= 32


@pytest.mark.parametrize("given_token", [None, "", "secre", "secrets", "Secret", "\udcff", "é"])
def test_only_the_token_is_accepted(given_token):
    assert not LOCAL.has_token(given_token)
    assert LOCAL.has_token("secret")


@pytest.mark.parametrize(
    ("host", "allowed"),
    [
        *((host, True) for host in ("127.0.0.1:8080", "localhost:8080", "localhost", "[::1]:80")),
        *((host, False) for host in (None, "", "evil.example", "10.0.0.1", "[", "localhost.evil")),
    ],
)
def test_on_loopback_only_its_own_hosts_are_allowed(host, allowed):
    assert LOCAL.allows_host(host) == allowed
    assert not allowed or LOCAL.allows_origin(f"http://{host}", host)


def test_any_host_is_allowed_on_a_network():
    assert Access("secret", loopback=False).allows_host("my-laptop:8080")


@pytest.mark.parametrize(
    ("origin", "allowed"),
    [
        (None, True),  # a program, no page
        *((f"http://{name}", False) for name in ("evil.example", "127.0.0.1:9999", "[")),
        ("http://127.0.0.1:8080.evil", False),
        ("file://127.0.0.1:8080", False),
        ("null", False),
        ("", False),
    ],
)
def test_only_own_pages_are_allowed(origin, allowed):
    assert LOCAL.allows_origin(origin, "127.0.0.1:8080") == allowed


@given(st.text(), st.text())
def test_fuzz_any_header_is_answered(host, origin):
    assert LOCAL.allows_host(host) in (True, False)
    assert LOCAL.allows_origin(origin, host) in (True, False)
