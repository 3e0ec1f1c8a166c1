#!/usr/bin/env python3
"""Drive laps for many simulated hours in lockstep and watch every process.

rosrun sdc_experiments soak.py [hours:=10] [camera:=false]

The exit status is 0 if the drive was completed without a missed tick, no process grew by 5 MB or
more after the warm-up, and no file stayed open.
"""

import contextlib
import json
import re
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np
import psutil

from sdc_common.processes import isolated_ros_environment
from sdc_experiments.process_metrics import private_memory_mb, process_name, stack_processes
from sdc_experiments.soak import ProcessSample, judge, laps
from sdc_experiments.stack_launch import running
from sdc_sim.evaluation.route_progress import COMPLETED

MAX_GROWTH_MB = 5.0
SAMPLE_PERIOD_S = 0.25
PROGRESS = re.compile(r"referee: *([0-9.]+) %")
# The route takes long to load, and a busy machine must not cause a missed tick.
SIM_OPTIONS = "{start_patience_s: 600.0, patience_s: 60.0}"


class Soak:
    def __init__(self, hours, camera):
        self.hours = hours
        self.camera = camera
        self.samples = defaultdict(list)
        self.percent = 0.0

    def drive(self, folder):
        """Drive all laps; return the report, or the end of the log as its status."""
        route, report = folder / "laps.csv", folder / "report.json"
        np.savetxt(route, laps(self.hours), fmt="%.4f", delimiter=",")
        command = [
            *(sys.executable, "-m", "sdc_common.ros.safe_launch", "sdc_package", "all.launch"),
            *("headless:=true", "sync:=true", f"camera:={self.camera}"),
            *(f"waypoints_path:={route}", f"report:={report}", f"sim_options:={SIM_OPTIONS}"),
        ]
        with isolated_ros_environment(folder / "ros") as environment, running(
            command, environment, folder
        ) as launch:
            while launch.process.poll() is None:
                self.sample(environment["ROS_MASTER_URI"], launch.log)
                time.sleep(SAMPLE_PERIOD_S)
        with contextlib.suppress(OSError):
            return json.loads(report.read_text(encoding="utf-8"))
        return {"status": "no report:\n" + launch.output[-3000:]}

    def sample(self, master_uri, log):
        """Add one sample of each process of the drive."""
        with open(log, "rb") as file:
            file.seek(max(0, log.stat().st_size - 4096))
            printed = PROGRESS.findall(file.read().decode(errors="replace"))
        self.percent = float(printed[-1]) if printed else self.percent
        for process in stack_processes(master_uri):
            with contextlib.suppress(psutil.Error):
                memory_mb, files = private_memory_mb(process), process.num_fds()
                key = process_name(process), process.pid
                self.samples[key].append(ProcessSample(self.percent, memory_mb, files))

    def print_result(self, report):
        """Print the drive and a table of all processes; return whether all of it is good."""
        if "duration_s" in report:
            print(
                f"{report['status']}: {report['duration_s'] / 3600.0:.2f} simulated hours, "
                f"{report['ticks']} ticks, {report['missed_ticks']} missed, "
                f"{report['real_time_factor']:.0f} times real time"
            )
        else:
            print(report["status"])
        good = report["status"] == COMPLETED and report["missed_ticks"] == 0
        print("| process | memory after warm-up | growth | files left open |\n|---|---|---|---|")
        for (name, _), samples in sorted(self.samples.items()):
            verdict = judge(samples)
            if verdict is None:
                continue
            print(
                f"| {name} | {verdict.memory_mb:.1f} MB | {verdict.growth_mb:.2f} MB "
                f"| {verdict.leaked_files} |"
            )
            good = good and verdict.growth_mb < MAX_GROWTH_MB and verdict.leaked_files == 0
        return good


def main():
    arguments = dict(
        word.split(":=", 1) for word in sys.argv[1:] if ":=" in word and not word.startswith("__")
    )
    hours, camera = float(arguments.pop("hours", "10")), arguments.pop("camera", "false")
    if arguments or not hours > 0.0 or camera not in ("true", "false"):
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        soak = Soak(hours, camera)
        good = soak.print_result(soak.drive(Path(folder)))
    print("flat" if good else "NOT flat")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
