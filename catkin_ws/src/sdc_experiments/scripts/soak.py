#!/usr/bin/env python3
"""Drives laps for many simulated hours in lockstep and watches every process: rosrun sdc_sim soak.py [hours:=10] [camera:=false]

Exit status 0 when the drive was completed without a missed tick, no process grew by 5 MB after the warm-up, and no file stayed open.
"""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import defaultdict

import numpy as np

from sdc_experiments.soak import ProcessSample, judge, laps
from sdc_sim.evaluation.route_progress import COMPLETED

MOST_GROWTH_MB = 5.0
LOOK_EVERY_S = 0.25
PROGRESS = re.compile(r"referee: *([0-9.]+) %")


class Soak:
    def __init__(self, hours, camera):
        self.hours = hours
        self.camera = camera
        self.samples = defaultdict(list)
        self.percent = 0.0

    def drive(self, folder):
        """Drive it all; returns the report, or what was said instead."""
        route, report, log = (
            os.path.join(folder, name) for name in ("laps.csv", "report.json", "log")
        )
        np.savetxt(route, laps(self.hours), fmt="%.4f", delimiter=",")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            master = f"http://127.0.0.1:{probe.getsockname()[1]}"
        # Nothing is hurried over: the route is long to lay out, and a busy machine is no missed tick.
        command = [
            sys.executable,
            "-m",
            "sdc_common.ros.safe_launch",
            "sdc_package",
            "all.launch",
            "headless:=true",
            "sync:=true",
            f"camera:={self.camera}",
            f"waypoints_path:={route}",
            f"report:={report}",
            "sim_options:={start_patience_s: 600.0, patience_s: 60.0}",
        ]
        variables = {
            **os.environ,
            "ROS_MASTER_URI": master,
            "ROS_IP": "127.0.0.1",
            "ROS_HOME": os.path.join(folder, "ros"),
        }
        with open(log, "wb") as output:
            process = subprocess.Popen(
                command,
                env=variables,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                while process.poll() is None:
                    self.look(f"ROS_MASTER_URI={master}".encode(), log)
                    time.sleep(LOOK_EVERY_S)
            finally:
                with contextlib.suppress(ProcessLookupError):
                    process.send_signal(signal.SIGINT)
                process.wait()
        with contextlib.suppress(OSError), open(report, encoding="utf-8") as file:
            return json.load(file)
        with open(log, encoding="utf-8", errors="replace") as file:
            return {"status": "not reported:\n" + file.read()[-3000:]}

    def look(self, mark, log):
        """One sample of each process that belongs to the drive."""
        with open(log, "rb") as file:
            file.seek(max(0, os.path.getsize(log) - 4096))
            told = PROGRESS.findall(file.read().decode(errors="replace"))
        self.percent = float(told[-1]) if told else self.percent
        for pid in filter(str.isdigit, os.listdir("/proc")):
            with contextlib.suppress(OSError):
                if mark in read(f"/proc/{pid}/environ").split(b"\0"):
                    memory_kb = re.search(rb"RssAnon:\s+(\d+)", read(f"/proc/{pid}/status"))
                    if memory_kb:
                        sample = ProcessSample(
                            self.percent,
                            int(memory_kb[1]) / 1024.0,
                            len(os.listdir(f"/proc/{pid}/fd")),
                        )
                        self.samples[name_of(pid), int(pid)].append(sample)

    def tell(self, report):
        """Print what was seen; returns whether all of it was good."""
        good = report["status"] == COMPLETED and report["missed_ticks"] == 0
        if "duration_s" in report:
            print(
                f"{report['status']}: {report['duration_s'] / 3600.0:.2f} simulated hours, {report['ticks']} ticks, "
                f"{report['missed_ticks']} missed, {report['real_time_factor']:.0f} times real time"
            )
        else:
            print(report["status"])
        print("| process | memory after warm-up | growth | files left open |\n|---|---|---|---|")
        for (name, _), samples in sorted(self.samples.items()):
            verdict = judge(samples)
            if verdict is None:
                continue
            print(
                f"| {name} | {verdict.memory_mb:.1f} MB | {verdict.growth_mb:.2f} MB | {verdict.leaked_files} |"
            )
            good = good and verdict.growth_mb < MOST_GROWTH_MB and verdict.leaked_files == 0
        return good


def read(path):
    with open(path, "rb") as file:
        return file.read()


def name_of(pid):
    """What a process is called: the name of its node, or its program's; with the word `keeper` for what starts a node again."""
    words = read(f"/proc/{pid}/cmdline").decode(errors="replace").split("\0")
    name = next((word[len("__name:=") :] for word in words if word.startswith("__name:=")), None)
    keeper = " (keeper)" if "sdc_common.ros.supervisor" in words else ""
    modules = [word for word in words if word.startswith(("sdc_", "/usr/bin/ros"))]
    return (name or os.path.basename(modules[0] if modules else words[0])) + keeper


def main():
    arguments = dict(
        word.split(":=", 1) for word in sys.argv[1:] if ":=" in word and not word.startswith("__")
    )
    hours, camera = float(arguments.pop("hours", "10")), arguments.pop("camera", "false")
    if arguments or not hours > 0.0 or camera not in ("true", "false"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soak = Soak(hours, camera)
        good = soak.tell(soak.drive(folder))
    print("flat" if good else "NOT flat")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
