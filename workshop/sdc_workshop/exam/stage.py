"""The ROS on which a student's nodes are tried: a master of its own, on a free port, in this process, and a node that talks to them."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import tempfile
import time
from pathlib import Path

import yaml

from sdc_workshop.exam.process import Program
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.variant import Variant
from sdc_workshop.exam.variant import make as make_variant
from sdc_workshop.regions import RegionError
from sdc_workshop.steps import load_steps
from sdc_workshop.workspace import PACKAGE, SOLUTION

NAME = "/workshop_check"
_AGAIN_S = 0.2


class Stage:
    """Ends with the `with` block, and with it all that runs on it. One a process: rospy knows its master once and for all."""

    def __init__(self, student: Student):
        self.student = student
        self._closing = contextlib.ExitStack()
        self._master = None
        self._display = None
        self._runs = 0

    def __enter__(self):
        self.folder = Path(
            self._closing.enter_context(tempfile.TemporaryDirectory(prefix="workshop_check_"))
        )
        (self.folder / "tmp").mkdir()
        return self

    def __exit__(self, *_):
        if self._master is not None:
            import rospy

            rospy.signal_shutdown("the check has ended")
            self._master.stop()
        self._closing.close()

    @property
    def master(self):
        """The master; started when it is first asked for."""
        if self._master is None:
            os.environ.update(
                ROS_IP="127.0.0.1",
                ROS_HOME=str(self.folder / "ros"),
                ROS_LOG_DIR=str(self.folder / "ros" / "log"),
            )
            os.environ.pop("ROS_HOSTNAME", None)
            from rosmaster.master import Master

            self._master = Master(port=0)
            self._master.start()
            self._master.uri = f"http://127.0.0.1:{self._master.uri.rstrip('/').rpartition(':')[2]}"
            os.environ["ROS_MASTER_URI"] = self._master.uri
            import rospy

            rospy.init_node(NAME[1:], argv=[], disable_signals=True, disable_rosout=True)
            for name in ("rosout", "rospy", "rosmaster"):
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        return self._master

    @property
    def display(self):
        """A screen that nobody sees; None where there is none to be had."""
        if self._display is None:
            from sdc_common.testing.virtual_display import VirtualDisplay

            try:
                if shutil.which("xdotool") is None or shutil.which("xwd") is None:
                    raise FileNotFoundError("xdotool")
                self._display = self._closing.enter_context(VirtualDisplay(800, 600))
            except OSError:
                self._display = False
        return self._display or None

    def environment(self, **more) -> dict:
        """The student's environment, on this master. Raises NotBuilt."""
        base = {
            **self.student.environment,
            "ROS_MASTER_URI": self.master.uri if self._master is not None else "http://127.0.0.1:1",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "ros"),
            "ROS_LOG_DIR": str(self.folder / "ros" / "log"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONUNBUFFERED": "1",
            "TMPDIR": str(self.folder / "tmp"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        return {**base, **more}

    def build(self, variant: Variant) -> tuple:
        """Put a variant of a Python file, with a library whose other files are solved, on disk; returns (its path, PYTHONPATH)."""
        self._runs += 1
        folder = self.folder / str(self._runs)
        shadow, library = folder / "python" / PACKAGE, folder / "library"
        shadow.mkdir(parents=True)
        library.mkdir()
        for name in library_files():
            text = self.student.text(name)
            if name == variant.name:
                text = variant.text
            else:
                try:
                    text = (
                        make_variant(name, text if text is not None else "", ()).text
                        if text
                        else None
                    )
                except RegionError:
                    text = None
            (library / Path(name).name).write_text(
                text if text is not None else (SOLUTION / name).read_text(encoding="utf-8"),
                encoding="utf-8",
            )
        shadow.joinpath("__init__.py").write_text(
            f"__path__ = {[str(library), str(self.student.library), str(self.student.built_python)]!r}\n",
            encoding="utf-8",
        )
        path = library / Path(variant.name).name
        if variant.name not in library_files():
            path = folder / Path(variant.name).name
            path.write_text(variant.text, encoding="utf-8")
        return path, f"{shadow.parent}:{self.student.environment.get('PYTHONPATH', '')}"

    def program(self, command, **environment) -> Program:
        """Start a command in the student's environment."""
        return Program(command, self.environment(**environment), self.folder)

    @contextlib.contextmanager
    def node(self, variant: Variant, parameters: dict, **environment):
        """A running node made of a variant of its file. Its parameters are those of the student's config/NAME.yaml, and `parameters`."""
        name = Path(variant.name).stem
        self.student.environment  # noqa: B018  without a build, not even a master is needed
        api = self.master.handler
        api.setParam(NAME, f"/{name}", {**self.configuration(name), **parameters})
        path, python_path = self.build(variant)
        node = Node(
            self,
            self.program(["/usr/bin/env", "python3", path], PYTHONPATH=python_path, **environment),
            path,
        )
        try:
            yield node
        finally:
            node.close()
            self._forget()
            api.deleteParam(NAME, f"/{name}")

    def configuration(self, name: str) -> dict:
        """The student's config/NAME.yaml; the project's figures where that cannot be read, or has none."""
        found = yaml.safe_load(self._solution_configuration(name)) or {}
        with contextlib.suppress(yaml.YAMLError):
            own = yaml.safe_load(self.student.text(f"{PACKAGE}/config/{name}.yaml") or "")
            if isinstance(own, dict):
                found.update(own)
        return found

    @staticmethod
    def _solution_configuration(name: str) -> str:
        path = SOLUTION / PACKAGE / "config" / f"{name}.yaml"
        return path.read_text(encoding="utf-8") if path.is_file() else ""

    def state(self) -> tuple:
        """({topic: [node]} published, {topic: [node]} subscribed, {topic: type}) as the master knows it, this process left out."""
        handler = self.master.handler
        _, _, (publishers, subscribers, _) = handler.getSystemState(NAME)

        def others(rows):
            return {
                topic: [node for node in nodes if node != NAME]
                for topic, nodes in rows
                if set(nodes) - {NAME}
            }

        return others(publishers), others(subscribers), dict(handler.getTopicTypes(NAME)[2])

    def clear(self) -> None:
        """As if nothing had been started here yet: a launch leaves its parameters behind."""
        self._forget()
        for name in list(self.master.handler.getParam(NAME, "/")[2]):
            self.master.handler.deleteParam(NAME, f"/{name}")

    def _forget(self) -> None:
        """Nodes that were killed never say goodbye: say it for them."""
        handler = self.master.handler
        with handler.ps_lock:
            manager = handler.reg_manager
            for name, reference in list(manager.nodes.items()):
                if name == NAME:
                    continue
                for registrations, unregister in (
                    (manager.publishers, manager.unregister_publisher),
                    (manager.subscribers, manager.unregister_subscriber),
                    (manager.services, manager.unregister_service),
                ):
                    for key, rows in list(registrations.map.items()):
                        if any(row[0] == name for row in rows):
                            api = (
                                registrations.service_api_map[key][1]
                                if registrations is manager.services
                                else reference.api
                            )
                            unregister(key, name, api)
            mine = {
                topic
                for registrations in (manager.publishers, manager.subscribers)
                for topic in registrations.map
            }
            for topic in list(handler.topics_types):
                if topic not in mine:
                    del handler.topics_types[topic]


def library_files() -> list:
    """The files of the car's library that have regions, relative to the src folder."""
    return sorted(
        {
            step.file
            for step in load_steps()
            if step.todo and f"/src/{PACKAGE}/" in (step.file or "")
        }
    )


class Node:
    """A student's node on the stage, and the ends of the topics that lead to it."""

    def __init__(self, stage: Stage, program: Program, path: Path):
        self.stage = stage
        self.program = program
        self.path = path
        self.seen_types = {}
        self._ends = []

    @property
    def output(self) -> str:
        return self.program.output

    def wait_until(self, condition) -> str:
        """As Program.wait_until."""
        return self.program.wait_until(condition)

    @property
    def names(self) -> list:
        """The names under which it is known to the master."""
        published, subscribed, _ = self.stage.state()
        return sorted(
            {name for nodes in (*published.values(), *subscribed.values()) for name in nodes}
        )

    def publishes(self, topic: str) -> str | None:
        """The type with which it publishes on this topic, which `seen_types` keeps; None when it does not."""
        published, _, types = self.stage.state()
        if topic not in published:
            return None
        self.seen_types[topic] = types.get(topic, "?")
        return self.seen_types[topic]

    def subscribes(self, topic: str) -> str | None:
        """The type with which it listens to this topic; None when it does not. To be asked before a publisher of our own is there."""
        _, subscribed, types = self.stage.state()
        return types.get(topic, "?") if topic in subscribed else None

    def topics(self) -> tuple:
        """(published, subscribed) names, without those that every node has."""
        published, subscribed, _ = self.stage.state()
        return sorted(set(published) - {"/rosout"}), sorted(set(subscribed) - {"/clock"})

    def publisher(self, topic: str, message_class, latch: bool = False):
        """An end to speak to it."""
        import rospy

        end = rospy.Publisher(topic, message_class, queue_size=20, latch=latch, tcp_nodelay=True)
        self._ends.append(end)
        return end

    def listener(self, topic: str, message_class) -> Heard:
        """An end to listen to it."""
        heard = Heard(topic, message_class)
        self._ends.append(heard.subscriber)
        return heard

    def ask(self, say, is_answered) -> str:
        """Call `say()` again and again until `is_answered()`; how it came as in Program.wait_until. A first message may be lost
        while the two are connecting."""
        said_at = [0.0]
        last = "true"

        def condition():
            if is_answered():
                return True
            if time.monotonic() - said_at[0] > _AGAIN_S:
                say()
                said_at[0] = time.monotonic()
            return False

        for _ in range(2):
            last = self.program.wait_until(condition)
            if last != "idle":
                return last
        return last

    def close(self) -> None:
        for end in self._ends:
            end.unregister()
        self.program.end()


class Heard:
    """What has been heard on a topic, in order."""

    def __init__(self, topic: str, message_class):
        import rospy

        self.messages = []
        self.subscriber = rospy.Subscriber(
            topic, message_class, self.messages.append, tcp_nodelay=True
        )

    @property
    def latched(self) -> bool:
        """Whether the publisher of the last message latches it."""
        return bool(self.messages) and self.messages[-1]._connection_header.get("latching") == "1"
