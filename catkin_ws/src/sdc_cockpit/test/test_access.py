"""Token, Host and Origin."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sdc_cockpit.access import Access, is_loopback, new_token

LOCAL = Access("secret", loopback=True)


def test_tokens_are_long_and_differ():
    assert len(new_token()) >= 32
    assert new_token() != new_token()


def test_token_of_the_environment_is_used(monkeypatch):
    monkeypatch.setenv("JUPYTER_TOKEN", "given")
    assert new_token() == "given"


@pytest.mark.parametrize("given_token", [None, "", "secre", "secrets", "Secret", "\udcff", "é"])
def test_wrong_token_is_refused(given_token):
    assert not LOCAL.has_token(given_token)


def test_token_is_accepted():
    assert LOCAL.has_token("secret")


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "localhost", "[::1]:8080"])
def test_own_hosts_are_allowed(host):
    assert LOCAL.allows_host(host)
    assert LOCAL.allows_origin(f"http://{host}", host)


@pytest.mark.parametrize(
    "host", [None, "", "evil.example", "evil.example:8080", "10.0.0.1", "[", "localhost.evil"]
)
def test_foreign_hosts_are_refused_on_loopback(host):
    assert not LOCAL.allows_host(host)


def test_any_host_is_allowed_on_a_network():
    assert Access("secret", loopback=False).allows_host("my-laptop:8080")


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "",
        "http://127.0.0.1:9999",
        "file://127.0.0.1:8080",
        "http://127.0.0.1:8080.evil",
        "http://[",
    ],
)
def test_foreign_origins_are_refused(origin):
    assert not LOCAL.allows_origin(origin, "127.0.0.1:8080")


def test_request_of_a_program_has_no_origin():
    assert LOCAL.allows_origin(None, "127.0.0.1:8080")


@given(st.text(), st.text())
def test_fuzz_any_header_is_answered(host, origin):
    assert LOCAL.allows_host(host) in (True, False)
    assert LOCAL.allows_origin(origin, host) in (True, False)


def test_loopback_addresses():
    assert is_loopback("127.0.0.1") and is_loopback("::1") and is_loopback("localhost")
    assert not is_loopback("0.0.0.0") and not is_loopback("example.org")
