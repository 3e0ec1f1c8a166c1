"""A student who follows the guide, with real terminals and a display."""

import contextlib
import os
import re
import subprocess

from guide_blocks import edited, missing_line

from sdc_common.processes import kill_left_behind, wait_until
from sdc_common.ros.drive_master import free_master_port
from sdc_workshop import languages
from sdc_workshop.steps import Step, all_steps
from sdc_workshop.workspace import PROJECT, write

GUIDE = [PROJECT / "workshop" / name for name in languages.GUIDE]
TIMEOUT_S = 600.0
PROMPT = re.compile(r"\[prompt:(\d+)\]")


class Terminal:
    """A bash in a terminal of `script`: commands may keep running, and Ctrl-C ends them."""

    def __init__(self, name, environment, home):
        self.name = name
        self.log = home / f".terminal-{len(list(home.glob('.terminal-*')))}"
        # A wide terminal, in which ls lists all names in one line, in their order.
        prompt = "stty columns 1000; export PS1='[prompt:$?]'"
        bash = "exec bash --norc --noprofile --noediting -i"
        self.shell = subprocess.Popen(
            ["script", "-q", "-f", "--echo", "never", "-c", f"{prompt}; {bash}", self.log],
            cwd=home,
            # Another shell loses exported functions.
            env={**environment, "TERM": "dumb", "SHELL": "/bin/bash"},
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.typed_at = 0
        wait_until(self.log.exists, TIMEOUT_S, "the terminal")
        self.wait(PROMPT.search, "the prompt")

    @property
    def shown(self):
        """Its output since the last line was typed."""
        return self.log.read_bytes()[self.typed_at :].decode(errors="replace").replace("\r\n", "\n")

    def wait(self, condition, what):
        """Return the first true value of condition(output)."""
        return wait_until(
            lambda: condition(self.shown), TIMEOUT_S, f"{what} in the terminal {self.name}"
        )

    def type(self, line, end=b"\n"):
        """Type a line, and do not wait for its end."""
        self.typed_at = self.log.stat().st_size
        self.shell.stdin.write(line.encode() + end)
        self.shell.stdin.flush()

    def run(self, line):
        """Type a line and wait for its end; return its status and output."""
        self.type(line)
        prompt = self.wait(PROMPT.search, f"the end of '{line}'")
        return int(prompt[1]), self.shown[: prompt.start()]

    def interrupt(self):
        """Type Ctrl-C and wait for the prompt."""
        self.type("\x03", b"")
        self.wait(PROMPT.search, "the prompt after Ctrl-C")

    def close(self):
        """End its program and close it."""
        with contextlib.suppress(TimeoutError, BrokenPipeError):
            self.interrupt()
        self.shell.communicate(timeout=30)


class Student:
    """A student with an empty home."""

    def __init__(self, home, display=None, page=None):
        port = free_master_port()
        self.home = home
        self.page = page
        self.workspace = home / "sdc_ws"
        self.display = display
        self.environment = {
            "HOME": str(home),
            "PATH": "/usr/bin:/bin",
            "LANG": os.environ.get("LANG", "C.UTF-8"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            # Other tests have masters of their own.
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_IP": "127.0.0.1",
            "BASH_FUNC_roscore%%": f"() {{ command roscore -p {port}; }}",
        }
        if display is not None:
            self.environment["DISPLAY"] = display.environment["DISPLAY"]
        self.terminals = {}
        self.output = ""
        self.held = []
        self.steps_seen = set()
        (home / "workshop").symlink_to(PROJECT)

    def terminal(self, name, new=False):
        if new and name in self.terminals:
            self.terminals.pop(name).close()
        if name not in self.terminals:
            self.terminals[name] = self.open_terminal(name)
            if os.path.exists("/opt/ros/noetic/setup.bash"):
                self.terminals[name].run("source /opt/ros/noetic/setup.bash")
            if new and name != "work":
                self.terminals[name].run("cd ~")
        return self.terminals[name]

    def open_terminal(self, name):
        return Terminal(name, self.environment, self.home)

    def follow(self, block):
        """Do what a block of the guide says. Raises AssertionError with its line."""
        try:
            getattr(self, block.does)(block)
        except Exception as error:
            others = "".join(
                f"\n== terminal {name}:\n{terminal.shown[-3000:]}"
                for name, terminal in self.terminals.items()
            )
            raise AssertionError(f"{self.page}, line {block.line}: {error}{others}") from error

    def run(self, block):
        terminal = self.terminal(block.terminal, block.new)
        lines = block.text.splitlines()
        if block.terminal != "work":
            for line in lines[:-1]:
                assert terminal.run(line)[0] == 0, terminal.shown
            terminal.type(lines[-1])
            return
        self.output = ""
        for line in lines:
            if line.startswith("./workshop/check "):
                self.steps_seen.update(
                    terminal.run(line.replace("./workshop/check", "echo"))[1].split()
                )
            status, output = terminal.run(line)
            self.output += output
            assert status == 0, f"'{line}' ended with {status}:\n{output}"
        while self.held:
            self.display.xdotool("keyup", self.held.pop())

    def skip(self, block):
        pass

    def see(self, block):
        if block.terminal == "work":
            missing = missing_line(block.text, self.output)
            assert missing is None, f"'{missing}' is not in\n{self.output}"
        else:
            self.terminal(block.terminal).wait(
                lambda output: missing_line(block.text, output) is None, block.text
            )

    def window(self, block):
        title = block.text.strip()
        wait_until(lambda: self.display.windows(title), TIMEOUT_S, f"the window '{title}'")

    def keys(self, block):
        if block.terminal is not None:
            assert block.text == "Ctrl-C\n"
            self.terminals[block.terminal].interrupt()
            return
        does, key = block.text.split()
        self.display.focus(block.window)
        if does == "hold":
            self.display.xdotool("keydown", key)
            self.held.append(key)
        else:
            assert does == "press"
            self.display.xdotool("key", key)

    def edit(self, block):
        path = self.workspace / "src" / block.file
        path.write_text(edited(path.read_text(encoding="utf-8"), block), encoding="utf-8")

    def write(self, block):
        steps = [step for step in all_steps() if (step.file, step.todo) == (block.file, block.todo)]
        if steps:
            self.save(steps[0], block.text)
            self.steps_seen.add(steps[0].id)
        else:
            assert block.todo is None, f"there is no step for {block.file}, TODO {block.todo}"
            self.save(Step("own", "", 4, f"../{block.file}"), block.text)

    def change(self, block):
        section, line = block.text.splitlines()
        key, value = line.split(": ")
        path = self.workspace / "src" / block.file
        text = path.read_text(encoding="utf-8")
        # The comment of the line stays.
        found = rf"(^{section}.*?^{key}: )\S+"
        assert re.search(found, text, re.MULTILINE | re.DOTALL), f"no {key} below {section}"
        changed = re.sub(found, rf"\g<1>{value}", text, count=1, flags=re.MULTILINE | re.DOTALL)
        path.write_text(changed, encoding="utf-8")

    def save(self, step, text):
        write(self.workspace, step, text)

    def __enter__(self):
        return self

    def __exit__(self, error, *_):
        for terminal in reversed(self.terminals.values()):
            terminal.close()
        left = kill_left_behind(self.environment["ROS_MASTER_URI"])
        assert error or left == [], "processes were left behind"
