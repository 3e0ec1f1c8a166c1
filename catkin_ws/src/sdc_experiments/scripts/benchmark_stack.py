#!/usr/bin/env python3
"""Time the whole stack in separate processes, and compare it with the lower limit of rospy.

rosrun sdc_experiments benchmark_stack.py [--rounds 5] [--seconds 30] [--setup FILE] [--ratios-only]
"""

import argparse
import os
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import rosgraph
import rospkg
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl

from sdc_common.testing.message_listener import wait_until
from sdc_common.testing.processes import isolated_ros_environment
from sdc_experiments.bare_loop import COMMAND, ODOMETRY, BareWorld
from sdc_experiments.benchmark_camera import bare_warp
from sdc_experiments.benchmark_parts import parts_ms
from sdc_experiments.process_metrics import cpu_ms, memory_mb
from sdc_experiments.stack_launch import drive_in_lockstep, launch_command, running
from sdc_package.odometry import pose_and_speed

TICK_S = 0.05
MIN_ROUNDS = 5
BARE_TICKS = 1000
BARE_PICTURES = 300
# The parts of a tick that run one after the other. Pictures are rendered in parallel.
SERIAL_PARTS = ("physics", "serialize", "planner", "controller")
# Start and end of a drive are left out of the CPU time.
STEADY_FROM, STEADY_UNTIL = 0.3, 0.8
FIRST_MOTION_TIMEOUT_S = 60.0
MASTER_TIMEOUT_S = 60.0


class RealTimeObserver:
    """Measures the delay from each odometry to its command, and detects the first motion."""

    def __init__(self):
        self.received_at_s = {}
        self.delays_s = []
        self.moving = threading.Event()
        rospy.Subscriber(ODOMETRY, Odometry, self.on_odometry, tcp_nodelay=True)
        rospy.Subscriber(COMMAND, CarlaVehicleControl, self.on_command, tcp_nodelay=True)

    def on_odometry(self, odometry):
        self.received_at_s[odometry.header.stamp.to_nsec()] = time.perf_counter()
        if pose_and_speed(odometry)[3] > 0.01:
            self.moving.set()

    def on_command(self, command):
        received_at_s = self.received_at_s.pop(command.header.stamp.to_nsec(), None)
        if received_at_s is not None:
            self.delays_s.append(time.perf_counter() - received_at_s)


def show(line):
    print(line, flush=True)


def measure_ratios(world, rounds, setups, route):
    """Print the ratio of a lockstep tick to a tick of the bare loop, for each workspace.

    Other programs on the machine change the speed from minute to minute. Each round therefore
    measures the bare loop again, right before the drives that it is compared with.
    """
    warp = bare_warp()
    ratios = {(camera, setup): [] for camera in (False, True) for setup in setups}
    for number in range(1, rounds + 1):
        for camera in (False, True):
            bare_ms = world.tick_ms(BARE_PICTURES, warp) if camera else world.tick_ms(BARE_TICKS)
            columns = [f"bare {bare_ms:.2f} ms ({1e3 * TICK_S / bare_ms:.1f} times real time)"]
            for setup in setups:
                tick_ms = drive_in_lockstep(camera, route, setup).tick_ms
                ratios[camera, setup].append(tick_ms / bare_ms)
                columns.append(
                    f"{workspace(setup)} {tick_ms:.2f} ms, ratio {tick_ms / bare_ms:.2f}"
                )
            show(f"round {number}, camera {on_off(camera)}: {'; '.join(columns)}")
    for (camera, setup), values in ratios.items():
        show(
            f"lockstep tick over bare loop, camera {on_off(camera)}, {workspace(setup)}: "
            f"median {statistics.median(values):.2f} of {len(values)} rounds "
            f"({min(values):.2f} to {max(values):.2f})"
        )


def workspace(setup):
    return "this workspace" if setup is None else setup


def on_off(camera):
    return "on" if camera else "off"


def measure_lockstep(parts):
    """Print times and CPU times per tick of complete drives in lockstep."""
    for camera in (False, True):
        drive = drive_in_lockstep(camera, sample=cpu_ms)
        show(
            f"lockstep, camera {on_off(camera)}: {drive.report['real_time_factor']:.1f} times "
            f"real time, {drive.tick_ms:.2f} ms per tick, {drive.report['missed_ticks']} missed"
        )
        if not camera:
            serial = {name: parts[name] for name in SERIAL_PARTS}
            serial["waiting"] = drive.tick_ms - sum(serial.values())
            show(f"  one tick: {listed(serial, 3)} (waiting: rospy, kernel, other processes)")
        used = cpu_per_tick_ms(drive)
        show(
            f"  CPU time per tick: {listed({n: v for n, v in used.items() if v >= 0.05}, 2)}; "
            f"total {sum(used.values()):.2f} ms"
        )


def cpu_per_tick_ms(drive):
    """Return the CPU time per tick of each process in the steady part of a drive, sorted [ms]."""
    steady = [sample for sample in drive.samples if STEADY_FROM < sample[0] < STEADY_UNTIL]
    (first_share, first), (last_share, last) = steady[0], steady[-1]
    ticks = (last_share - first_share) * drive.report["ticks"]
    used = {name: (last[name] - first[name]) / ticks for name in first if name in last}
    return dict(sorted(used.items(), key=lambda item: -item[1]))


def listed(times_ms, digits):
    return ", ".join(f"{name} {value:.{digits}f}" for name, value in times_ms.items()) + " ms"


def measure_real_time(environment, folder, seconds):
    """Print first motion, memory and delay of a drive in real time."""
    observer = RealTimeObserver()
    start = time.monotonic()
    command = launch_command(f"report:={folder}/report.json")
    with running(command, environment, folder):
        observer.moving.wait(FIRST_MOTION_TIMEOUT_S)
        show(f"real time: first motion {time.monotonic() - start:.1f} s after roslaunch")
        del observer.delays_s[:]
        time.sleep(seconds)
        # The measurement of the memory delays the nodes: keep the delays from before it.
        delays_ms = 1e3 * np.array(observer.delays_s)
        memory = memory_mb(environment["ROS_MASTER_URI"])
        show(f"real time: {memory:.0f} MB in all processes of the stack (PSS)")
    show(
        f"real time: odometry to command median {np.median(delays_ms):.2f} ms, "
        f"99 % {np.percentile(delays_ms, 99):.2f} ms "
        f"({len(delays_ms)} ticks, measured in another process)"
    )


def parse_arguments():
    routes = Path(rospkg.RosPack().get_path("sdc_package")) / "test" / "routes"
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--rounds", type=int, default=MIN_ROUNDS, help="rounds of the ratios, at least 5"
    )
    parser.add_argument(
        "--route", default=str(routes / "fast_bends.csv"), help="waypoints of the rounds"
    )
    parser.add_argument(
        "--setup", help="setup.bash of another workspace, whose stack is measured in each round too"
    )
    parser.add_argument("--ratios-only", action="store_true", help="measure only the rounds")
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="duration of the drive in real time [s]"
    )
    arguments = parser.parse_args(rospy.myargv(sys.argv)[1:])
    if arguments.rounds < MIN_ROUNDS:
        parser.error(f"--rounds must be at least {MIN_ROUNDS}, got {arguments.rounds}")
    for name in ("route", "setup"):
        path = getattr(arguments, name)
        if path is not None and not os.path.isfile(path):
            parser.error(f"--{name}: there is no file {path}")
    return arguments


def main():
    arguments = parse_arguments()
    cv2.setNumThreads(1)
    setups = [None] if arguments.setup is None else [None, os.path.abspath(arguments.setup)]
    with tempfile.TemporaryDirectory() as name, isolated_ros_environment(name) as environment:
        folder = Path(name)
        os.environ.update({key: environment[key] for key in ("ROS_MASTER_URI", "ROS_IP")})
        port = environment["ROS_MASTER_URI"].rsplit(":", 1)[1]
        bare_node = [sys.executable, "-m", "sdc_experiments.bare_loop"]
        with running(["roscore", "-p", port], environment, folder):
            wait_until(rosgraph.is_master_online, MASTER_TIMEOUT_S, "the ROS master")
            rospy.init_node("benchmark_stack", disable_signals=True)
            with running([*bare_node, "planner"], environment, folder), running(
                [*bare_node, "controller"], environment, folder
            ):
                measure_ratios(BareWorld(), arguments.rounds, setups, arguments.route)
            if not arguments.ratios_only:
                parts = parts_ms()
                measure_lockstep(parts)
                show(f"each part alone, median: {listed(parts, 3)}")
                measure_real_time(environment, folder, arguments.seconds)
            rospy.signal_shutdown("all is measured")


if __name__ == "__main__":
    main()
