"""The ROS master, the display and the files with which a student's nodes are run."""

from __future__ import annotations

import contextlib
import functools
import logging
import os
import secrets
import shutil
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any, Sequence

import yaml

from sdc_sim.catkin_workspace import workspace_environment
from sdc_workshop.exam.limits import limit_requests
from sdc_workshop.exam.process import Program
from sdc_workshop.exam.sandbox import Sandbox
from sdc_workshop.exam.student import Student
from sdc_workshop.exam.variant import Variant
from sdc_workshop.exam.variant import make as make_variant
from sdc_workshop.regions import RegionError
from sdc_workshop.steps import all_steps
from sdc_workshop.student_file import FileError, values
from sdc_workshop.temporary import temporary_folder
from sdc_workshop.workspace import PACKAGE, SOLUTION, WORLD, solution_text

if TYPE_CHECKING:
    from rosmaster.master import Master

    from sdc_testing.virtual_display import VirtualDisplay

NAME = "/workshop_check"
_GUARD = Path(__file__).with_name("probes") / "guard"
NEVER_RETURNED = "it never returned, and was ended"


class Stage:
    """A temporary folder, and a ROS master in this process.

    The end of the `with` block ends all programs. There is one stage in a process: rospy keeps its
    first master.

    Attributes:
        student: the workspace whose programs run
        folder: the temporary folder, which the student's programs can read
        hidden: a folder that they do not see: what the referee knows
        sandbox: where the student's programs run, or None
        seed: the checks draw their arguments from it; the student does not know it before

    Args:
        secret: draws the roads of a grade; no program of a student gets it. Without one, the seed
            draws the road
    """

    def __init__(
        self, student: Student, sandbox: Sandbox | None = None, seed: str = "", secret: str = ""
    ):
        self.student = student
        self.sandbox = sandbox
        self._secret = secret
        self.seed = seed or secrets.token_hex(4)
        self._closing = contextlib.ExitStack()

    def __enter__(self) -> Stage:
        self.folder, self.hidden = (
            self._closing.enter_context(temporary_folder(prefix))
            for prefix in ("workshop_check_", "workshop_referee_")
        )
        (self.folder / "tmp").mkdir()
        sandbox = self.sandbox
        if sandbox is not None:
            self.folder.chmod(0o755)  # the programs run as another user
            self.student.run = lambda command, own: sandbox.program(command, own, self.folder)
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()

    @functools.cached_property
    def master(self) -> Master:
        """The master; it is started at the first use."""
        os.environ.update(
            ROS_IP="127.0.0.1",
            ROS_HOME=str(self.folder / "ros"),
            ROS_LOG_DIR=str(self.folder / "ros" / "log"),
        )
        os.environ.pop("ROS_HOSTNAME", None)
        from rosmaster.master import Master

        limit_requests(self.report)
        # The kernel chooses the port, which no drive chooses for a master that it starts later.
        master = Master(port=0)
        master.start()
        self._closing.callback(master.stop)
        port = master.uri.rstrip("/").rpartition(":")[2]
        os.environ["ROS_MASTER_URI"] = master.uri = f"http://127.0.0.1:{port}"
        import rospy

        rospy.init_node(NAME[1:], argv=[], disable_signals=True, disable_rosout=True)
        self._closing.callback(rospy.signal_shutdown, "the check has ended")
        for name in ("rosout", "rospy", "rosmaster"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        return master

    @functools.cached_property
    def display(self) -> VirtualDisplay | None:
        """A virtual display; None where its programs are not installed."""
        from sdc_testing.virtual_display import VirtualDisplay

        with contextlib.suppress(OSError):
            if shutil.which("xdotool") is not None:
                return self._closing.enter_context(VirtualDisplay(800, 600))
        return None

    def random(self, name: str) -> Random:
        """Return the random numbers of the check with this name, which the seed decides about."""
        return Random(f"{self.seed}/{name}")

    def road_seed(self, second: bool) -> int:
        """Return what the first road or the second one of a car is drawn from."""
        if second:
            return int(self._secret)
        return Random(f"{self._secret or self.seed}/road").getrandbits(63)

    def report(self, text: str) -> None:
        """Report what the sandbox has kept a program from."""
        if self.sandbox is not None:
            self.sandbox.report(text, "")

    def environment(self, **more: str) -> dict:
        """Return the student's environment variables, with this master. Raises NotBuilt."""
        own = self.student.environment
        # A sandbox does not show the solution; without one, Python refuses to open it.
        paths = [] if self.sandbox else [str(_GUARD)]
        paths.append(own.get("PYTHONPATH", ""))
        return {**own, "PYTHONPATH": ":".join(paths), **self._ros_environment(), **more}

    def _ros_environment(self) -> dict:
        return {
            "ROS_MASTER_URI": self.master.uri if "master" in vars(self) else "http://127.0.0.1:1",
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": str(self.folder / "tmp" / "ros"),
            "ROS_LOG_DIR": str(self.folder / "tmp" / "ros" / "log"),
            "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONUNBUFFERED": "1",
            "TMPDIR": str(self.folder / "tmp"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }

    @functools.cached_property
    def _world(self) -> dict:
        return workspace_environment(str(WORLD))

    @property
    def world_environment(self) -> dict:
        """The environment variables of the world's workspace, which no student has written."""
        logs = str(self.hidden / "ros")
        return {**self._world, **self._ros_environment(), "ROS_HOME": logs, "ROS_LOG_DIR": logs}

    def launch_environment(self) -> dict:
        """Return an environment that finds the student's files, but none of the Python modules.

        Raises:
            NotBuilt: see Student.environment
        """
        self.student.environment  # noqa: B018  raises NotBuilt
        paths = f"{self.student.src}:{self.world_environment['ROS_PACKAGE_PATH']}"
        return {**self.world_environment, "ROS_PACKAGE_PATH": paths}

    def build(self, variant: Variant) -> tuple:
        """Write a variant of a Python file to disk, with a library in which all else is solved.

        Return the path of the file, and the PYTHONPATH that finds the library.
        """
        self.forget_build()
        folder, name_of_package = self.folder / "run", Path(variant.name).parts[0]
        root = f"{name_of_package}/src/{name_of_package}/"
        own, package = self.student.src / root, folder / "python" / name_of_package
        if own.is_dir():
            shutil.copytree(own, package, ignore=shutil.ignore_patterns("__pycache__"))
        files = {str(step.file) for step in all_steps() if step.todo}
        library = {name for name in files if name.startswith(root)}
        # The other TODOs are solved there: no program sees what an earlier one needed.
        texts = {name: self._solved(name) for name in library - {variant.name}}
        texts[variant.name] = variant.text
        messages = str(self.student.built_python(name_of_package))
        texts[f"{root}__init__.py"] = f"__path__.append({messages!r})\n"

        def path_of(name: str) -> Path:
            in_library = name.startswith(root)
            return package / name[len(root) :] if in_library else folder / Path(name).name

        for name, text in texts.items():
            path_of(name).parent.mkdir(parents=True, exist_ok=True)
            path_of(name).write_text(text, encoding="utf-8")
        python_path = f"{package.parent}:{self.environment()['PYTHONPATH']}"
        return path_of(variant.name), python_path

    def forget_build(self) -> None:
        """Delete what `build` has written."""
        shutil.rmtree(self.folder / "run", ignore_errors=True)

    def _solved(self, name: str) -> str:
        """Return the student's file with all regions solved; the solution where that fails."""
        with contextlib.suppress(RegionError):
            text = self.student.text(name)
            if text:
                return make_variant(name, text, ()).text
        return solution_text(name)

    def program(self, command: Sequence[object], **environment: str) -> Program:
        """Start a command in the student's environment."""
        return self.start(command, self.environment(**environment))

    def start(self, command: Sequence[object], environment: dict, **options: Any) -> Program:
        """Start a command that the student decides about, with only these environment variables."""
        if self.sandbox is None:
            return Program(command, environment, self.folder, **options)
        return self.sandbox.program(command, environment, self.folder, **options)

    def configuration(self, name: str) -> dict:
        """Return the parameters of the student's config/NAME.yaml, completed by the solution's."""
        path = SOLUTION / PACKAGE / "config" / f"{name}.yaml"
        found = yaml.safe_load(path.read_text(encoding="utf-8") if path.is_file() else "") or {}
        with contextlib.suppress(FileError):
            found.update(values(self.student.text(f"{PACKAGE}/config/{name}.yaml") or ""))
        return found

    def state(self) -> tuple:
        """Return publishing nodes, subscribing nodes and types by topic, without this process."""
        handler = self.master.handler
        _, _, (publishers, subscribers, _) = handler.getSystemState(NAME)

        def others(rows: list) -> dict:
            return {
                topic: [node for node in nodes if node != NAME]
                for topic, nodes in rows
                if set(nodes) - {NAME}
            }

        return others(publishers), others(subscribers), dict(handler.getTopicTypes(NAME)[2])

    def clear(self) -> None:
        """Remove all nodes and parameters from the master, which a launch leaves behind."""
        self.unregister_nodes()
        for name in list(self.master.handler.getParam(NAME, "/")[2]):
            self.master.handler.deleteParam(NAME, f"/{name}")

    def unregister_nodes(self) -> None:
        """Unregister all nodes from the master: a node that was killed does not do it itself."""
        handler = self.master.handler
        with handler.ps_lock:
            manager = handler.reg_manager
            for name in set(manager.nodes) - {NAME}:
                for registrations in (manager.publishers, manager.subscribers, manager.services):
                    registrations.unregister_all(name)
                del manager.nodes[name]
            mine = {*manager.publishers.map, *manager.subscribers.map}
            for topic in set(handler.topics_types) - mine:
                del handler.topics_types[topic]
