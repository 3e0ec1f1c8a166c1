"""./workshop/desktop: a small desktop in the browser, for RViz and the windows of the workshop."""

from __future__ import annotations

import os
import secrets
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import numpy as np
import yaml

from sdc_cockpit.access import new_token
from sdc_experiments.commands import parse
from sdc_workshop.browser import service
from sdc_workshop.workspace import PROJECT

PORT = 6080
NOVNC = Path("/usr/share/novnc")
# Larger than a page, which cuts it: a larger page would repeat the background.
_SIZE = "2560x1600"
_SETUP = PROJECT / "catkin_ws" / "devel" / "setup.bash"
# The menu, and at the top of the desktop a line of text and the icons.
CONTENT = yaml.safe_load(Path(__file__).with_name("desktop.yaml").read_text(encoding="utf-8"))


class Desktop:
    """An X server with a window manager, whose picture a page of noVNC shows.

    Other users of this machine have no access: the X server needs a cookie, the VNC server is a
    socket in a private folder, and the page needs the token. `folder` is empty and private.
    """

    def __init__(self, programs: service.Programs, folder: Path):
        self._programs = programs
        self._folder = folder

    def start(
        self, environment: Mapping[str, str], address: str, port: int, given_token: str
    ) -> dict[str, str]:
        """Start the desktop; return the environment of programs that open windows there.

        Raises:
            ServiceError: a program does not start
        """
        inside = {**environment, **self._start_server(environment)}
        self._start_window_manager(inside)
        self._start_web_server(environment, address, port, given_token)
        return inside

    def _start_server(self, environment: Mapping[str, str]) -> dict[str, str]:
        cookies = self._folder / "Xauthority"
        cookie = secrets.token_hex(16)
        # The server reads the cookie before it chooses its number; it accepts that of any number.
        self._add_cookie(cookies, ":0", cookie)
        read, write = os.pipe()
        command = (
            ["Xtigervnc", "-displayfd", str(write), "-auth", str(cookies), "-nolisten", "tcp"]
            + ["-geometry", _SIZE, "-depth", "24", "-desktop", "workshop", "-AlwaysShared"]
            + ["-rfbport", "-1", "-rfbunixpath", str(self._folder / "vnc")]
            + ["-SecurityTypes", "None"]
        )
        process = self._programs.start(command, environment, pass_fds=(write,))
        os.close(write)
        with open(read, encoding="ascii") as answer:
            number = answer.readline().strip()
        if not number:
            raise self._programs.failure(process, "does not start")
        self._add_cookie(cookies, f":{number}", cookie)
        return {
            "DISPLAY": f":{number}",
            "XAUTHORITY": str(cookies),
            "LIBGL_ALWAYS_SOFTWARE": "1",
        }

    @staticmethod
    def _add_cookie(cookies: Path, display: str, cookie: str) -> None:
        subprocess.run(
            ["xauth", "-q", "-f", str(cookies)],
            input=f"add {display} . {cookie}\n",
            text=True,
            check=True,
            capture_output=True,
        )

    def _start_window_manager(self, environment: Mapping[str, str]) -> None:
        settings = self._folder / "icewm"
        settings.mkdir()
        (settings / "menu").write_text(
            "".join(
                f'prog "{title}" utilities-terminal {terminal(title, command)}\n'
                for title, command in CONTENT["menu"].items()
            ),
            encoding="utf-8",
        )
        shutil.copy(Path(__file__).with_name("icewm_preferences"), settings / "preferences")
        (settings / "toolbar").touch()
        self._programs.start(
            ["icewm"],
            {**environment, "ICEWM_PRIVCFG": str(settings)},
            cwd=environment.get("HOME", "/"),
        )
        self._start_icons(environment)

    def _start_icons(self, environment: Mapping[str, str]) -> None:
        """Start idesk, which reads its files from the home folder, and write how to use it."""
        home, own = environment.get("HOME", "/"), self._folder / "idesk"
        (own / ".idesktop").mkdir(parents=True)
        width, height = map(int, _SIZE.split("x"))
        background = np.full((height, width, 3), (72, 60, 48), np.uint8)
        cv2.putText(background, CONTENT["hint"], (40, 40), 0, 0.6, (255, 255, 255), 1, cv2.LINE_AA)
        cv2.imwrite(str(own / "background.png"), background)
        shutil.copy(Path(__file__).with_name("idesk_settings"), own / ".ideskrc")
        icon = Path(__file__).with_name("idesk_icon").read_text(encoding="utf-8")
        for i, (title, picture) in enumerate(CONTENT["icons"].items()):
            values = {"home": home, "command": terminal(title, CONTENT["menu"][title])}
            text = icon.format(title=title, picture=picture, x=50 + 130 * i, **values)
            (own / ".idesktop" / f"{i}.lnk").write_text(text)
        self._programs.start(["idesk"], {**environment, "HOME": str(own)}, cwd=own)

    def _start_web_server(
        self, environment: Mapping[str, str], address: str, port: int, given_token: str
    ) -> None:
        www = self._folder / "www"
        www.mkdir()
        for path in NOVNC.iterdir():
            (www / path.name).symlink_to(path)
        shutil.copy(Path(__file__).with_name("desktop.html"), www / "index.html")
        tokens = self._folder / "tokens"
        tokens.touch(mode=0o600)
        tokens.write_text(f"{given_token}: unix_socket:{self._folder / 'vnc'}\n", encoding="utf-8")
        process = self._programs.start(
            ["websockify", "--web", str(www), f"{address}:{port}"]
            + ["--token-plugin", "ReadOnlyTokenFile", "--token-source", str(tokens)],
            environment,
        )
        self._programs.wait_for_port(process, address, port)


def terminal(title: str, command: str) -> str:
    """Return the command line of a terminal window that runs a command in the project."""
    script = f"cd {PROJECT}; {f'source {_SETUP}; {command}' if command else 'exec bash'}"
    return f"xterm -fa Monospace -fs 11 -title '{title}' -e bash -c '{script}'"


def main(arguments: Sequence[str]) -> None:
    """Serve the desktop until Ctrl-C."""
    with service.errors_in_one_line("desktop"), tempfile.TemporaryDirectory() as name:
        options = parse("workshop/desktop", arguments)
        folder = Path(name)
        with service.Programs(folder / "log") as programs:
            port = service.free_port(options.ip, options.port)
            given_token = new_token()
            Desktop(programs, folder).start(os.environ, options.ip, port, given_token)
            service.announce(
                "desktop", service.url(options.ip, port, f"?token={given_token}"), options.ip
            )
            programs.wait()


if __name__ == "__main__":
    main(sys.argv[1:])
