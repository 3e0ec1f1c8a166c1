"""The web server: page, libraries, road, and one websocket for each page."""

from __future__ import annotations

import asyncio
import errno
import functools
import os
import socket
from pathlib import Path
from typing import Any, Awaitable

import tornado.netutil
import tornado.web
import tornado.websocket

from sdc_cockpit.access import Access
from sdc_cockpit.protocol import MAX_MESSAGE_BYTES, json_message, read_message
from sdc_cockpit.viewers import Viewer
from sdc_sim.report import TEMPLATES

PORTS_TO_TRY = 50
# The files of Debian's packages libjs-three and libjs-chart.js.
_LIBRARIES = {
    "three.module.js": "three/three.module.js",
    "chart.js": "chart.js/Chart.min.js",
}
_LIBRARY_FOLDER = Path("/usr/share/javascript")
_PING_S = 10.0
# Arguments of the HTTP server. No request has a body; without a limit, the server keeps a body of
# 100 MB in memory before it looks for the token.
LIMITS = {
    "max_body_size": 0,
    "max_buffer_size": 1 << 20,
    "max_header_size": 1 << 14,
    # A connection without a request takes one of the files that this process can open [s].
    "idle_connection_timeout": 5.0,
}
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        "connect-src 'self' ws: wss:; frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
    ),
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
_REPORT_POLICY = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data:"
)
_NO_TOKEN = (
    "The token is missing or wrong: open the address that the terminal printed, with ?token="
)


class _Checked(tornado.web.RequestHandler):
    """A handler that refuses foreign hosts and origins, and, where it matters, a wrong token."""

    needs_token = True

    def initialize(self, access: Access, backend: Any, path: str = "") -> None:
        self.access, self.backend, self.path_of_page = access, backend, path

    def set_default_headers(self) -> None:
        for name, value in _HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        headers = self.request.headers
        host, origin = headers.get("Host"), headers.get("Origin")
        if not (self.access.allows_host(host) and self.access.allows_origin(origin, host)):
            raise tornado.web.HTTPError(403, reason="This host or origin is not allowed")
        if self.needs_token and not self.access.has_token(self.get_query_argument("token", None)):
            raise tornado.web.HTTPError(403, reason="The token is missing or wrong")

    def write_error(self, status_code: int, **_keywords: Any) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {self._reason}. {_NO_TOKEN if status_code == 403 else ''}\n")


class _Page(_Checked):
    def get(self) -> None:
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(Path(self.path_of_page).read_bytes())


class _File(_Checked, tornado.web.StaticFileHandler):
    """Files that everyone may read: they are part of this project or of Debian."""

    needs_token = False

    def initialize(self, access: Access, backend: Any, path: str) -> None:  # type: ignore[override]
        _Checked.initialize(self, access, backend)
        tornado.web.StaticFileHandler.initialize(self, path)

    def prepare(self) -> None:
        _Checked.prepare(self)

    def set_extra_headers(self, path: str) -> None:
        self.set_header("Cache-Control", "no-cache")


class _Library(_File):
    async def get(self, path: str, include_body: bool = True) -> None:  # type: ignore[override]
        await super().get(_LIBRARIES[path], include_body)


class _Road(_Checked):
    async def get(self) -> None:
        road = await asyncio.get_running_loop().run_in_executor(None, self.backend.road_json)
        if road is None:
            raise tornado.web.HTTPError(404, reason="There is no route yet")
        self.set_header("Content-Type", "application/json")
        self.finish(road)


class _DriveFile(_Checked):
    """A file that a drive wrote. Its sandbox has an own origin and cannot use this server.

    Its address contains the key of the drive, and not the token.
    """

    needs_token = False

    def prepare(self) -> None:
        super().prepare()
        if not self.access.has_key(self.get_query_argument("key", None), self.path_args[0]):
            raise tornado.web.HTTPError(403, reason="The key is missing or wrong")

    def get(self, drive: str, name: str) -> None:
        path = self.backend.drives.file(drive, name)
        if path is None:
            raise tornado.web.HTTPError(404, reason="There is no such file")
        kind = "text/html" if path.suffix == ".html" else "text/plain"
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.set_header("Content-Security-Policy", _REPORT_POLICY)
        self.finish(path.read_bytes())


class _Comparison(_Checked):
    async def get(self) -> None:
        names = [str(self.get_query_argument(name, "")) for name in ("a", "b")]
        compare = functools.partial(self.backend.drives.comparison, *names)
        try:
            self.finish(await asyncio.get_running_loop().run_in_executor(None, compare))
        except ValueError as error:
            self.set_status(404)
            self.finish({"error": str(error)})


class _Socket(_Checked, tornado.websocket.WebSocketHandler):
    viewer: Viewer | None = None

    def check_origin(self, origin: str) -> bool:
        return self.access.allows_origin(origin, self.request.headers.get("Host"))

    def write_message(self, message: Any, binary: bool = False) -> Any:
        """Send a message; on a connection that was lost do nothing."""
        try:
            return super().write_message(message, binary)
        except tornado.websocket.WebSocketClosedError:
            return None

    def open(self, *_arguments: str, **_keywords: str) -> Awaitable[None] | None:
        self.set_nodelay(True)
        self.viewer = self.backend.viewers.add(self)
        self.backend.joined(self.viewer)
        return None

    def on_message(self, message: str | bytes) -> None:
        if self.viewer is None:
            return
        try:
            self.backend.receive(self.viewer, read_message(message))
        except ValueError as error:
            self.viewer.send(json_message("notice", level="warn", text=str(error)))

    def on_close(self) -> None:
        if self.viewer is not None:
            self.backend.viewers.remove(self.viewer)
            self.backend.left(self.viewer)
            self.viewer = None


def application(backend: Any, access: Access, www: Path) -> tornado.web.Application:
    """Return the web application.

    Args:
        backend: the node, with its `viewers` and `drives`. In the server's thread, `joined(viewer)`
            and `left(viewer)` are called for each page, and `receive(viewer, message)` for each
            message, which may raise ValueError. In other threads, `road_json()` is called, which
            returns the road, or None before there is one
        access: who may use it
        www: folder of the page
    """
    used = {"access": access, "backend": backend}
    return tornado.web.Application(
        [
            ("/", _Page, {**used, "path": str(www / "index.html")}),
            ("/ws", _Socket, used),
            ("/drives/([^/]+)/([^/]+)", _DriveFile, used),
            ("/api/compare", _Comparison, used),
            ("/api/road", _Road, used),
            ("/static/(page.css)", _File, {**used, "path": str(TEMPLATES)}),
            ("/static/(.*)", _File, {**used, "path": str(www)}),
            (f"/lib/({'|'.join(_LIBRARIES)})", _Library, {**used, "path": str(_LIBRARY_FOLDER)}),
        ],
        websocket_max_message_size=MAX_MESSAGE_BYTES,
        websocket_ping_interval=_PING_S,
        compress_response=True,
        log_function=lambda _handler: None,
    )


def bind(address: str, port: int) -> tuple[list[socket.socket], int]:
    """Bind the first free port from `port` on.

    Returns:
        sockets and the port

    Raises:
        OSError: the address is not one of this machine, or no port is free
    """
    for candidate in range(port, min(port + PORTS_TO_TRY, 65536)):
        try:
            sockets = tornado.netutil.bind_sockets(candidate, address)
            return sockets, sockets[0].getsockname()[1]
        except OSError as error:
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                raise
    raise OSError(f"no port is free from {port} on")


def page_address(address: str, port: int, token: str) -> str:
    """Return the URL of the page, as it is printed.

    In a terminal of ./workshop/browser, WORKSHOP_URL is the address of JupyterLab, which forwards
    /proxy/PORT/ to that port.
    """
    if os.environ.get("WORKSHOP_URL"):
        return f"{os.environ['WORKSHOP_URL']}proxy/{port}/?token={token}"
    host = socket.gethostname() if address in ("0.0.0.0", "::", "") else address
    return f"http://{f'[{host}]' if ':' in host else host}:{port}/?token={token}"
