"""Who may use the cockpit: token, Host and Origin of a request."""

from __future__ import annotations

import hmac
import ipaddress
import os
import secrets
from urllib.parse import urlsplit


def new_token() -> str:
    """Return the token of the environment, or one that cannot be guessed.

    ./workshop/browser sets JUPYTER_TOKEN, so that one token opens JupyterLab and cockpit.
    """
    return os.environ.get("JUPYTER_TOKEN") or secrets.token_hex(24)


class Access:
    """Decides about requests.

    There is no cookie: a page of another site that makes this browser send a request has no token.
    """

    def __init__(self, token: str, loopback: bool):
        self.token = token
        self._loopback = loopback

    def has_token(self, candidate: str | None) -> bool:
        """Return whether a request contains the token, in a time that does not depend on it."""
        return _equal(candidate, self.token)

    def key(self, drive: str) -> str:
        """Return what opens the files of one drive, and nothing else.

        A script in a report can read its own address and send it away.
        """
        return hmac.new(self.token.encode(), drive.encode(), "sha256").hexdigest()

    def has_key(self, candidate: str | None, drive: str) -> bool:
        """Return whether a request contains the key of a drive."""
        return _equal(candidate, self.key(drive))

    def allows_host(self, host: str | None) -> bool:
        """Return whether a Host header names this server.

        On the loopback interface only its own names do: another site whose name resolves to this
        machine (DNS rebinding) is refused.
        """
        name = _host_name(host)
        return name is not None and (not self._loopback or is_loopback(name))

    def allows_origin(self, origin: str | None, host: str | None) -> bool:
        """Return whether a page of this origin may use the server: only the server's own pages.

        A request without an Origin comes from a program and not from a page.
        """
        if origin is None:
            return True
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        return (
            parts.scheme in ("http", "https")
            and host is not None
            and parts.netloc.lower() == host.lower()
        )


def _equal(candidate: str | None, wanted: str) -> bool:
    return hmac.compare_digest((candidate or "").encode("utf-8", "replace"), wanted.encode())


def is_loopback(name: str) -> bool:
    """Return whether a host name or address is that of the loopback interface."""
    if name == "localhost":
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def _host_name(host: str | None) -> str | None:
    try:
        return urlsplit(f"//{host}").hostname if host else None
    except ValueError:
        return None
