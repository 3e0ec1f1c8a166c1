"""The web server with a backend that only records."""

import asyncio
import json
import tempfile
from pathlib import Path

import pytest
import tornado.httpclient
import tornado.testing
import tornado.websocket
from page_messages import read_picture

from sdc_cockpit import server
from sdc_cockpit.access import Access
from sdc_cockpit.protocol import CAMERA, Message
from sdc_cockpit.viewers import MAX_UNDRAWN, Viewers

TOKEN = "secret"


class RecordingDrives:
    page = None

    def file(self, name, file):
        return self.page if (name, file) == ("1-oval", "report.html") else None

    def comparison(self, a, b):
        if b == "gone":
            raise ValueError("there is no drive 'gone'")
        return {"text": f"{a} {b}", "picture": ""}


class RecordingBackend:
    def __init__(self):
        self.viewers = Viewers()
        self.drives = RecordingDrives()
        self.received, self.gone = [], []

    def joined(self, viewer):
        self.viewer = viewer
        viewer.send(b'{"type":"hello"}')

    def left(self, viewer):
        self.gone.append(viewer.number)

    def receive(self, viewer, message):
        self.received.append(message)
        viewer.send(b'{"type":"received"}')

    def road_json(self):
        return b"{}"


class ServerTest(tornado.testing.AsyncHTTPTestCase):
    def setUp(self):
        # Dask, in another test of this process, makes a loop that it runs the current one.
        asyncio.set_event_loop(asyncio.new_event_loop())
        super().setUp()

    def get_app(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        (Path(folder.name) / "www").mkdir()
        (Path(folder.name) / "secret.txt").write_text("private")
        (Path(folder.name) / "www" / "index.html").write_text("<h1>page</h1>")
        self.backend = RecordingBackend()
        self.backend.folder = Path(folder.name)
        return server.application(
            self.backend, Access(TOKEN, loopback=True), Path(folder.name) / "www"
        )

    def code(self, path, **headers):
        return self.fetch(path, headers=headers).code

    async def connect(self, query=f"?token={TOKEN}", **headers):
        request = tornado.httpclient.HTTPRequest(
            f"ws://127.0.0.1:{self.get_http_port()}/ws{query}", headers=headers
        )
        connection = await tornado.websocket.websocket_connect(request)
        assert await connection.read_message() == '{"type":"hello"}'
        return connection

    def test_page_and_data_need_the_token(self):
        for path in ("/", "/api/road"):
            assert self.code(path) == 403
            assert self.code(path + "?token=wrong") == 403
            assert self.code(f"{path}?token={TOKEN}") == 200

    def test_foreign_host_and_origin_are_refused(self):
        for path in ("/", "/api/road", "/static/index.html"):
            address = f"{path}?token={TOKEN}"
            assert self.code(address, Host="evil.example") == 403
            assert self.code(address, Origin="http://evil.example") == 403

    def test_page_may_load_scripts_from_this_server_only(self):
        headers = self.fetch(f"/?token={TOKEN}").headers
        assert "script-src 'self';" in headers["Content-Security-Policy"]
        assert headers["Referrer-Policy"] == "no-referrer"

    def test_no_file_outside_of_the_page_is_served(self):
        for path in ("/static/../secret.txt", "/static/%2e%2e/secret.txt", "/lib/../../secret.txt"):
            assert self.code(f"{path}?token={TOKEN}") in (403, 404)

    def test_report_of_a_drive_cannot_use_the_server(self):
        self.backend.drives.page = self.backend.folder / "www" / "index.html"
        key = Access(TOKEN, loopback=True).key("1-oval")
        answer = self.fetch(f"/drives/1-oval/report.html?key={key}")
        assert (answer.code, answer.body) == (200, b"<h1>page</h1>")
        policy = answer.headers["Content-Security-Policy"]
        assert "sandbox allow-scripts;" in policy and "allow-same-origin" not in policy
        for query in ("", f"?token={TOKEN}", f"?key={Access(TOKEN, loopback=True).key('2')}"):
            assert self.code(f"/drives/1-oval/report.html{query}") == 403
        for path in ("/", "/api/road", "/api/compare", "/drives/2/report.html"):
            assert self.code(f"{path}?token={key}&key={key}") == 403
        assert self.code(f"/drives/1-oval/drive.json?key={key}") == 404
        assert self.code(f"/drives/../secret.txt?key={key}") == 403

    def get_httpserver_options(self):
        assert 0.0 < server.LIMITS["idle_connection_timeout"] <= 30.0
        return {**server.LIMITS, "idle_connection_timeout": 0.2}

    @tornado.testing.gen_test
    async def test_connection_without_a_request_is_closed_and_a_viewer_stays(self):
        viewer = await self.connect()
        reader, writer = await asyncio.open_connection("127.0.0.1", self.get_http_port())
        assert await asyncio.wait_for(reader.read(), 10.0) == b""
        writer.close()
        await viewer.write_message("{}")
        assert "unknown type" in await viewer.read_message()

    def test_body_is_refused_before_the_server_keeps_it(self):
        for size in (1, 10_000_000):
            with pytest.raises(Exception, match="closed|400"):
                self.fetch("/", method="POST", body=bytes(size), raise_error=True)
        assert self.code(f"/?token={TOKEN}") == 200

    def test_comparison_of_two_drives(self):
        answer = self.fetch(f"/api/compare?a=1&b=2&token={TOKEN}")
        assert json.loads(answer.body) == {"text": "1 2", "picture": ""}
        answer = self.fetch(f"/api/compare?a=1&b=gone&token={TOKEN}")
        assert (answer.code, json.loads(answer.body)["error"]) == (404, "there is no drive 'gone'")
        assert self.code("/api/compare?a=1&b=2") == 403

    @tornado.testing.gen_test
    async def test_websocket_needs_token_and_own_origin(self):
        for query, headers in (
            ("", {}),
            ("?token=wrong", {}),
            (f"?token={TOKEN}", {"Origin": "http://evil.example"}),
            (f"?token={TOKEN}", {"Host": "evil.example"}),
        ):
            with pytest.raises(tornado.httpclient.HTTPClientError, match="403"):
                await self.connect(query, **headers)
        assert len(self.backend.viewers) == 0

    @tornado.testing.gen_test
    async def test_malformed_message_is_reported_and_the_connection_stays(self):
        connection = await self.connect()
        for text in ("", "{", '{"type":"exec"}', '{"type":"keys","held":[[]]}', "[" * 3000):
            await connection.write_message(text)
            assert json.loads(await connection.read_message())["type"] == "notice"
        await connection.write_message(b"\x00\xff", binary=True)
        assert json.loads(await connection.read_message())["type"] == "notice"
        await connection.write_message('{"type":"pause"}')
        assert await connection.read_message() == '{"type":"received"}'
        assert self.backend.received == [Message("pause")]

    @tornado.testing.gen_test
    async def test_too_long_message_ends_only_its_connection(self):
        first, second = await self.connect(), await self.connect()
        await first.write_message("x" * 100_000)
        assert await first.read_message() is None
        assert self.backend.gone == [1]
        await second.write_message('{"type":"step"}')
        assert await second.read_message() == '{"type":"received"}'

    @tornado.testing.gen_test
    async def test_page_that_draws_nothing_gets_no_more_pictures(self):
        connection = await self.connect()
        for number in range(MAX_UNDRAWN + 5):
            self.backend.viewers.broadcast_picture(CAMERA, 0.1 * number, 2.0, b"file")
            await tornado.gen.sleep(0.01)
        numbers = [read_picture(await connection.read_message())[1] for _ in range(MAX_UNDRAWN)]
        assert numbers == list(range(1, MAX_UNDRAWN + 1))
        assert not self.backend.viewers.wanted(CAMERA)
        self.backend.viewer.drawn(MAX_UNDRAWN)
        self.backend.viewers.broadcast_picture(CAMERA, 1.0, 2.0, b"newest")
        assert read_picture(await connection.read_message())[4] == b"newest"

    @tornado.testing.gen_test
    async def test_thirty_viewers_get_each_picture(self):
        connections = [await self.connect() for _ in range(30)]
        for number in (1, 2):
            self.backend.viewers.broadcast_picture(CAMERA, 0.1 * number, 2.0, b"file")
            for connection in connections:
                message = read_picture(await connection.read_message())
                assert (message[1], message[4]) == (number, b"file")


def test_next_port_is_used_if_one_is_taken():
    sockets, port = server.bind("127.0.0.1", 23456)
    others, other = server.bind("127.0.0.1", port)
    for one in (*sockets, *others):
        one.close()
    assert other > port


def test_printed_address_names_the_machine():
    assert server.page_address("127.0.0.1", 8080, "t") == "http://127.0.0.1:8080/?token=t"
    assert "0.0.0.0" not in server.page_address("0.0.0.0", 8080, "t")
    assert server.page_address("::1", 8080, "t") == "http://[::1]:8080/?token=t"


def test_printed_address_in_jupyterlab_is_the_forwarded_one(monkeypatch):
    monkeypatch.setenv("WORKSHOP_URL", "http://127.0.0.1:8888/")
    address = server.page_address("127.0.0.1", 8081, "t")
    assert address == "http://127.0.0.1:8888/proxy/8081/?token=t"
