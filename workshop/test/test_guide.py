"""Plays the student: an empty home, and guide.md word for word, on real terminals, with a screen of its own."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import termios
import threading
import time
from pathlib import Path

import pytest

from sdc_common.testing.virtual_display import VirtualDisplay
from sdc_workshop.guide import GuideError, missing_line, read
from sdc_workshop.steps import Step, load_steps
from sdc_workshop.workspace import PROJECT, differences, solution_body, write

GUIDE = PROJECT / "workshop" / "guide.md"
PATIENCE_S = 90.0
PROMPT = re.compile(r"\[prompt:(\d+)\]")


class Terminal:
    """A bash on a terminal of its own, as a person has it: commands may keep running, Ctrl-C ends them."""

    def __init__(self, name, environment, home):
        self.name = name
        self.heard = ""
        self.changed = threading.Condition()
        self.keyboard, screen = os.openpty()
        settings = termios.tcgetattr(screen)
        settings[3] &= ~termios.ECHO
        termios.tcsetattr(screen, termios.TCSANOW, settings)
        self.shell = subprocess.Popen(
            ["setsid", "--ctty", "bash", "--norc", "--noprofile", "--noediting", "-i"],
            cwd=home,
            env={**environment, "PS1": "[prompt:$?]", "TERM": "dumb"},
            stdin=screen,
            stdout=screen,
            stderr=screen,
        )
        os.close(screen)
        threading.Thread(target=self.listen, daemon=True).start()
        self.typed_at = 0
        self.wait(lambda said: PROMPT.search(said), "the prompt")

    def listen(self):
        with contextlib.suppress(OSError):
            while True:
                said = os.read(self.keyboard, 65536).decode(errors="replace")
                with self.changed:
                    self.heard += said
                    self.changed.notify_all()

    @property
    def said(self):
        """What it has said since the last line was typed."""
        return self.heard[self.typed_at :].replace("\r\n", "\n")

    def wait(self, condition, what):
        """The first true value of condition(said)."""
        limit = time.monotonic() + PATIENCE_S
        with self.changed:
            while True:
                value = condition(self.said)
                if value:
                    return value
                left = limit - time.monotonic()
                assert left > 0.0, (
                    f"waited in vain for {what} in the terminal {self.name}, which says\n{self.said}"
                )
                self.changed.wait(left)

    def type(self, line):
        """Type a line, and let it run."""
        with self.changed:
            self.typed_at = len(self.heard)
        os.write(self.keyboard, line.encode() + b"\n")

    def run(self, line):
        """Type a line and wait for its end; returns (status, what it said)."""
        self.type(line)
        prompt = self.wait(PROMPT.search, f"the end of '{line}'")
        return int(prompt[1]), self.said[: prompt.start()]

    def interrupt(self):
        """Ctrl-C, until the prompt is back."""
        with self.changed:
            self.typed_at = len(self.heard)
        os.write(self.keyboard, b"\x03")
        self.wait(PROMPT.search, "the prompt after Ctrl-C")

    def close(self):
        """End what runs in it, then close it."""
        if self.shell.poll() is None:
            with contextlib.suppress(AssertionError):
                self.interrupt()
            os.kill(self.shell.pid, signal.SIGHUP)
            try:
                self.shell.wait(timeout=30)
            except subprocess.TimeoutExpired:
                self.shell.kill()
                self.shell.wait()
        os.close(self.keyboard)


class Student:
    """Somebody with an empty home who follows the guide."""

    def __init__(self, home, display):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.home = home
        self.workspace = home / "sdc_ws"
        self.display = display
        self.environment = {
            "HOME": str(home),
            "PATH": "/usr/bin:/bin",
            "LANG": os.environ.get("LANG", "C.UTF-8"),
            "DISPLAY": display.environment["DISPLAY"],
            "LIBGL_ALWAYS_SOFTWARE": "1",
            # A master of its own, beside those of other tests.
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_IP": "127.0.0.1",
            "BASH_FUNC_roscore%%": f"() {{ command roscore -p {port}; }}",
        }
        self.terminals = {}
        self.said = ""
        self.held = []
        self.steps_seen = set()
        (home / "workshop").symlink_to(PROJECT)

    def terminal(self, name, new=False):
        if new and name in self.terminals:
            self.terminals.pop(name).close()
        if name not in self.terminals:
            self.terminals[name] = Terminal(name, self.environment, self.home)
            if os.path.exists("/opt/ros/noetic/setup.bash"):
                self.terminals[name].run("source /opt/ros/noetic/setup.bash")
            if new and name != "work":
                self.terminals[name].run("cd ~")
        return self.terminals[name]

    def follow(self, block):
        getattr(self, block.does)(block)

    def run(self, block):
        terminal = self.terminal(block.terminal, block.new)
        lines = block.text.splitlines()
        if block.terminal != "work":
            for line in lines[:-1]:
                assert terminal.run(line)[0] == 0, terminal.said
            terminal.type(lines[-1])
            return
        self.said = ""
        for line in lines:
            if line.startswith("./workshop/check "):
                self.steps_seen.update(
                    terminal.run(line.replace("./workshop/check", "echo"))[1].split()
                )
            status, said = terminal.run(line)
            self.said += said
            assert status == 0, f"'{line}' ended with {status}:\n{said}"
        while self.held:
            self.display.key_up(self.held.pop())

    def skip(self, block):
        pass

    def see(self, block):
        if block.terminal == "work":
            missing = missing_line(block.text, self.said)
            assert missing is None, f"'{missing}' is not in\n{self.said}"
        else:
            self.terminal(block.terminal).wait(
                lambda said: missing_line(block.text, said) is None, block.text
            )

    def window(self, block):
        limit = time.monotonic() + PATIENCE_S
        while not self.display.windows(block.text.strip()):
            assert time.monotonic() < limit, f"no window '{block.text.strip()}' opened"
            time.sleep(0.05)

    def keys(self, block):
        if block.terminal is not None:
            assert block.text == "Ctrl-C\n"
            self.terminals[block.terminal].interrupt()
            return
        does, key = block.text.split()
        self.display.focus(block.window)
        if does == "hold":
            self.display.key_down(key)
            self.held.append(key)
        else:
            assert does == "press"
            self.display.press(key)

    def write(self, block):
        steps = [
            step for step in load_steps() if (step.file, step.todo) == (block.file, block.todo)
        ]
        if steps:
            write(self.workspace, steps[0], block.text)
            self.steps_seen.add(steps[0].id)
        else:
            assert block.todo is None, f"there is no step for {block.file}, TODO {block.todo}"
            write(self.workspace, Step("own", "", 4, f"../{block.file}"), block.text)

    def leave(self):
        for terminal in reversed(self.terminals.values()):
            terminal.close()
        mark = f"ROS_MASTER_URI={self.environment['ROS_MASTER_URI']}"
        left = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            with contextlib.suppress(OSError):
                if mark in Path("/proc", pid, "environ").read_text(errors="replace").split("\0"):
                    left.append(Path("/proc", pid, "cmdline").read_text().replace("\0", " "))
                    os.kill(int(pid), signal.SIGKILL)
        return left


@pytest.fixture
def student(tmp_path):
    with VirtualDisplay() as display:
        student = Student(tmp_path, display)
        left = None
        try:
            yield student
        finally:
            left = student.leave()
        assert left == [], "processes were left behind"


def test_the_guide_leads_to_a_car_that_drives(student):
    blocks = read(GUIDE.read_text(encoding="utf-8"))
    times = []
    for block in blocks:
        start = time.monotonic()
        try:
            student.follow(block)
        except Exception as error:
            others = "".join(
                f"\n== terminal {name}:\n{terminal.said[-3000:]}"
                for name, terminal in student.terminals.items()
            )
            raise AssertionError(f"{GUIDE}, line {block.line}: {error}{others}") from error
        times.append((time.monotonic() - start, block.line))
    assert differences(student.workspace) == [], "the files are not the solution's"
    assert [step.id for step in load_steps() if step.id not in student.steps_seen] == [], (
        "steps that the guide leaves out"
    )
    print(
        "slowest blocks (s, line):",
        [(round(seconds, 1), line) for seconds, line in sorted(times, reverse=True)[:12]],
    )


def test_snippets_are_the_solution():
    """The same is found at the end of the long test; this one says at once which snippet has drifted."""
    written = {
        (block.file, block.todo): block
        for block in read(GUIDE.read_text(encoding="utf-8"))
        if block.does == "write"
    }
    for step in filter(lambda step: step.file, load_steps()):
        block = written[step.file, step.todo]
        assert block.text == solution_body(step), (
            f"{GUIDE}, line {block.line}: not what the solution has at {step.place}"
        )


def test_blocks_that_nobody_can_follow():
    with pytest.raises(GuideError, match="line 3: what to do with 'bash loudly'"):
        read("\n\n```bash loudly\nls\n```\n")


def test_what_should_be_seen_in_its_order():
    assert missing_line("a...c\n\nd\n", "xx abc\nd") is None
    assert missing_line("d\na...c\n", "xx abc\nd") == "a...c"
    assert missing_line("a...c\n", "a\nc") == "a...c"
