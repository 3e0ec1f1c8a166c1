#!/usr/bin/env python3
"""Times the whole stack in separate processes, beside the floor that rospy itself sets: rosrun sdc_sim benchmark_stack.py"""

import argparse
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

import cv2
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint
from sensor_msgs.msg import Image

from sdc_common.ros.node import LoopPublisher
from sdc_common.testing.message_listener import wait_until
from sdc_experiments.benchmark_camera import bare_warp
from sdc_package.odometry import pose_and_speed
from sdc_sim.ros.message_conversion import image_message

ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
COMMAND = "/carla/ego_vehicle/vehicle_control_cmd"
IMAGE = "/carla/ego_vehicle/camera/rgb/front/image_color"
BARE_TICKS = 4000
BARE_PICTURES = 1000
TICK_S = 0.05
# The parts of a tick that wait for each other; pictures are made beside them.
ONE_AFTER_THE_OTHER = ("physics", "serialise", "planner", "controller")


@contextlib.contextmanager
def own_master():
    """An environment with a ROS master of its own, on loopback."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    yield {**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}


@contextlib.contextmanager
def running(command, environment):
    """A process in a group of its own that is ended in order."""
    process = subprocess.Popen(
        command,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        process.wait()


def launch(*arguments):
    return ["roslaunch", "sdc_package", "all.launch", "headless:=true", *arguments]


def lockstep(camera):
    """The report of one complete drive in lockstep, and the CPU milliseconds a tick of each process in the midst of it."""
    with tempfile.TemporaryDirectory() as folder, own_master() as environment:
        report = os.path.join(folder, "report.json")
        command = launch("sync:=true", f"camera:={str(camera).lower()}", f"report:={report}")
        samples = []
        with running(command, environment) as process:
            while process.poll() is None:
                samples.append((time.time(), cpu_ms(environment)))
                time.sleep(0.25)  # a look costs some milliseconds of what it measures
        with open(report, encoding="utf-8") as file:
            figures = json.load(file)
        age_s = [(os.stat(report).st_mtime - at) / figures["wall_duration_s"] for at, _ in samples]
    midst = [sample for age, sample in zip(age_s, samples) if 0.3 < age < 0.8]
    (first_at, first), (last_at, last) = midst[0], midst[-1]
    ticks = (last_at - first_at) * figures["ticks"] / figures["wall_duration_s"]
    return figures, {name: (last[name] - first[name]) / ticks for name in first if name in last}


def cpu_ms(environment):
    """CPU milliseconds that each process under this master has used, by its name."""
    mine = f"ROS_MASTER_URI={environment['ROS_MASTER_URI']}".encode()
    used = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            if mine not in environment_of(pid):
                continue
            with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
                user, system = file.read().rsplit(")", 1)[1].split()[11:13]
            with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                words = file.read().split("\0")
            names = [word.split(":=")[1] for word in words if word.startswith("__name:=")] or [
                word.split(".")[1] for word in words if word.startswith("sdc_sim.")
            ]
            if names:
                used[names[0]] = 1e3 * (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    return used


def bare_node(role):
    """A node of the bare loop: messages of the contract, no thinking."""
    rospy.init_node("bare_" + role)
    if role == "planner":
        path = LocalPath([Waypoint(1.0, 2.0, 3.0)] * 25)
        publisher = LoopPublisher(PATH, LocalPath)
        rospy.Subscriber(
            ODOMETRY, Odometry, lambda _: publisher.publish(path), queue_size=1, tcp_nodelay=True
        )
        rospy.Subscriber(
            IMAGE, Image, lambda _: None, queue_size=1, buff_size=4 * 1024 * 1024, tcp_nodelay=True
        )
    else:
        publisher = LoopPublisher(COMMAND, CarlaVehicleControl)
        rospy.Subscriber(ODOMETRY, Odometry, lambda _: None, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber(
            PATH,
            LocalPath,
            lambda _: publisher.publish(CarlaVehicleControl()),
            queue_size=1,
            tcp_nodelay=True,
        )
    rospy.spin()


class BareWorld:
    """The third process of the bare loop: odometry to both nodes, path, command, and nothing that is worth it."""

    def __init__(self):
        self.odometry_publisher = LoopPublisher(ODOMETRY, Odometry)
        self.image_publisher = LoopPublisher(IMAGE, Image)
        self.answered = threading.Event()
        rospy.Subscriber(
            COMMAND,
            CarlaVehicleControl,
            lambda _: self.answered.set(),
            queue_size=1,
            tcp_nodelay=True,
        )
        wait_until(
            lambda: (
                self.odometry_publisher.get_num_connections() == 2
                and self.image_publisher.get_num_connections()
            ),
            what="both bare nodes",
        )

    def tick_ms(self, ticks, paint=None):
        """Median time of a tick that is nothing but its hops; with `paint`, a picture is made and published in each."""
        times = []
        message = Odometry()
        for _ in range(ticks):
            self.answered.clear()
            start = time.perf_counter()
            self.odometry_publisher.publish(message)
            if paint:
                self.image_publisher.publish(image_message(paint(), rospy.Time(0)))
            if self.answered.wait(1.0):
                times.append(time.perf_counter() - start)
        return 1e3 * float(np.median(times))


def tell_bare_loop(world):
    for what, tick in (
        ("no thinking", world.tick_ms(BARE_TICKS)),
        (
            "one perspective warp and its picture published in each",
            world.tick_ms(BARE_PICTURES, bare_warp()),
        ),
    ):
        print(
            f"bare loop of three processes, {what}: {tick:.2f} ms a tick, {1e3 * TICK_S / tick:.1f} times real time",
            flush=True,
        )


class RealTime:
    """What a drive in real time costs: first motion, memory, and the delay from an odometry to its command."""

    def __init__(self):
        self.heard = {}
        self.delays = []
        self.moving = threading.Event()
        rospy.Subscriber(ODOMETRY, Odometry, self.on_odometry, tcp_nodelay=True)
        rospy.Subscriber(COMMAND, CarlaVehicleControl, self.on_command, tcp_nodelay=True)

    def on_odometry(self, odometry):
        self.heard[odometry.header.stamp.to_nsec()] = time.perf_counter()
        if pose_and_speed(odometry)[3] > 0.01:
            self.moving.set()

    def on_command(self, command):
        heard = self.heard.pop(command.header.stamp.to_nsec(), None)
        if heard is not None:
            self.delays.append(time.perf_counter() - heard)


def memory_mb(group):
    """Proportional set size of all processes of a session, megabytes."""
    total = 0
    for pid in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            if os.getsid(int(pid)) == group or environment_of(pid) == environment_of(group):
                with open(f"/proc/{pid}/smaps_rollup", encoding="ascii") as file:
                    total += sum(int(line.split()[1]) for line in file if line.startswith("Pss:"))
    return total / 1024.0


def environment_of(pid):
    """The ROS master that a process belongs to."""
    with open(f"/proc/{pid}/environ", "rb") as file:
        return [part for part in file.read().split(b"\0") if part.startswith(b"ROS_MASTER_URI=")]


def thinking_ms():
    """Median time of each part of a tick, measured alone in this process on the packaged route."""
    from sdc_experiments.benchmark_parts import parts_ms

    return parts_ms()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bare", choices=("planner", "controller"), help=argparse.SUPPRESS)
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="how long the drive in real time is watched"
    )
    arguments = parser.parse_args(rospy.myargv(sys.argv)[1:])
    if arguments.bare:
        bare_node(arguments.bare)
        return

    cv2.setNumThreads(1)
    parts = thinking_ms()
    for camera in (False, True):
        report, used = lockstep(camera)
        tick = 1e3 * report["wall_duration_s"] / report["ticks"]
        print(
            f"lockstep, camera {'on ' if camera else 'off'}: {report['real_time_factor']:5.1f} times real time, "
            f"{tick:.2f} ms a tick, {report['missed_ticks']} missed",
            flush=True,
        )
        if not camera:
            one_after_the_other = {name: parts[name] for name in ONE_AFTER_THE_OTHER}
            one_after_the_other["waiting"] = tick - sum(one_after_the_other.values())
            print(
                "  a tick: "
                + ", ".join(f"{name} {value:.3f}" for name, value in one_after_the_other.items())
                + " ms (waiting: rospy's hops, the kernel, other processes)",
                flush=True,
            )
        print(
            "  CPU a tick: "
            + ", ".join(
                f"{name} {value:.2f}"
                for name, value in sorted(used.items(), key=lambda item: -item[1])
                if value >= 0.05
            )
            + f" ms; together {sum(used.values()):.2f}",
            flush=True,
        )
    print(
        "each part alone, median: "
        + ", ".join(f"{name} {value:.3f}" for name, value in parts.items())
        + " ms",
        flush=True,
    )

    with own_master() as environment:
        os.environ.update({name: environment[name] for name in ("ROS_MASTER_URI", "ROS_IP")})
        with running(
            ["roscore", "-p", environment["ROS_MASTER_URI"].rsplit(":", 1)[1]], environment
        ):
            rospy.init_node("benchmark_stack", disable_signals=True)
            own = os.path.abspath(__file__)
            with running([sys.executable, own, "--bare", "planner"], environment), running(
                [sys.executable, own, "--bare", "controller"], environment
            ):
                tell_bare_loop(BareWorld())
            with tempfile.TemporaryDirectory() as folder:
                watch = RealTime()
                start = time.monotonic()
                with running(launch(f"report:={folder}/report.json"), environment) as process:
                    watch.moving.wait(60.0)
                    print(
                        f"real time: first motion {time.monotonic() - start:.1f} s after roslaunch",
                        flush=True,
                    )
                    del watch.delays[:]
                    time.sleep(arguments.seconds)
                    delays = 1e3 * np.array(
                        watch.delays
                    )  # before the look at all processes' memory, which holds them up
                    print(
                        f"real time: {memory_mb(process.pid):.0f} MB resident in all processes (PSS, this one included)",
                        flush=True,
                    )
                print(
                    f"real time: odometry to command median {np.median(delays):.2f} ms, 99 % {np.percentile(delays, 99):.2f} ms "
                    f"({len(delays)} ticks, as heard by a third process)",
                    flush=True,
                )


if __name__ == "__main__":
    main()
