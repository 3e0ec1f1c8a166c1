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

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sdc_package.msg import CarlaVehicleControl, LocalPath, Waypoint

from sdc_package.listening import wait_until
from sdc_package.node import LoopPublisher
from sdc_package.odometry import pose_and_speed

ODOMETRY = "/carla/ego_vehicle/odometry"
PATH = "/planner/local_waypoints"
COMMAND = "/carla/ego_vehicle/vehicle_control_cmd"
BARE_TICKS = 4000


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
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        process.wait()


def launch(*arguments):
    return ["roslaunch", "sdc_package", "all.launch", "headless:=true", *arguments]


def lockstep(camera):
    """The report of one complete drive in lockstep."""
    with tempfile.TemporaryDirectory() as folder, own_master() as environment:
        report = os.path.join(folder, "report.json")
        command = launch("sync:=true", f"camera:={str(camera).lower()}", f"report:={report}")
        subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        with open(report, encoding="utf-8") as file:
            return json.load(file)


def bare_node(role):
    """A node of the bare loop: messages of the contract, no thinking."""
    rospy.init_node("bare_" + role)
    if role == "planner":
        path = LocalPath([Waypoint(1.0, 2.0, 3.0)] * 25)
        publisher = LoopPublisher(PATH, LocalPath)
        rospy.Subscriber(ODOMETRY, Odometry, lambda _: publisher.publish(path), queue_size=1, tcp_nodelay=True)
    else:
        publisher = LoopPublisher(COMMAND, CarlaVehicleControl)
        rospy.Subscriber(ODOMETRY, Odometry, lambda _: None, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber(PATH, LocalPath, lambda _: publisher.publish(CarlaVehicleControl()), queue_size=1, tcp_nodelay=True)
    rospy.spin()


def bare_tick_ms():
    """Median time of a tick that is nothing but its hops: odometry to both nodes, path, command."""
    publisher = LoopPublisher(ODOMETRY, Odometry)
    answered = threading.Event()
    rospy.Subscriber(COMMAND, CarlaVehicleControl, lambda _: answered.set(), queue_size=1, tcp_nodelay=True)
    wait_until(lambda: publisher.get_num_connections() == 2, what="both bare nodes")
    times = []
    message = Odometry()
    for _ in range(BARE_TICKS):
        answered.clear()
        start = time.perf_counter()
        publisher.publish(message)
        if answered.wait(1.0):
            times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


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
    from sdc_sim.benchmark_parts import parts_ms
    return parts_ms()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bare", choices=("planner", "controller"), help=argparse.SUPPRESS)
    parser.add_argument("--seconds", type=float, default=20.0, help="how long the drive in real time is watched")
    arguments = parser.parse_args(rospy.myargv(sys.argv)[1:])
    if arguments.bare:
        bare_node(arguments.bare)
        return

    for camera in (False, True):
        report = lockstep(camera)
        tick = 1e3 * report["wall_duration_s"] / report["ticks"]
        print(f"lockstep, camera {'on ' if camera else 'off'}: {report['real_time_factor']:5.1f} times real time, "
              f"{tick:.2f} ms a tick, {report['missed_ticks']} missed", flush=True)
    for name, value in thinking_ms().items():
        print(f"  {name:<22} {value:.3f} ms", flush=True)

    with own_master() as environment:
        os.environ.update({name: environment[name] for name in ("ROS_MASTER_URI", "ROS_IP")})
        with running(["roscore", "-p", environment["ROS_MASTER_URI"].rsplit(":", 1)[1]], environment):
            rospy.init_node("benchmark_stack", disable_signals=True)
            own = os.path.abspath(__file__)
            with running([sys.executable, own, "--bare", "planner"], environment), \
                    running([sys.executable, own, "--bare", "controller"], environment):
                print(f"four bare hops, no thinking: {bare_tick_ms():.2f} ms a tick", flush=True)
            with tempfile.TemporaryDirectory() as folder:
                watch = RealTime()
                start = time.monotonic()
                with running(launch(f"report:={folder}/report.json"), environment) as process:
                    watch.moving.wait(60.0)
                    print(f"real time: first motion {time.monotonic() - start:.1f} s after roslaunch", flush=True)
                    del watch.delays[:]
                    time.sleep(arguments.seconds)
                    print(f"real time: {memory_mb(process.pid):.0f} MB resident in all processes (PSS, this one included)", flush=True)
                delays = 1e3 * np.array(watch.delays)
                print(f"real time: odometry to command median {np.median(delays):.2f} ms, 99 % {np.percentile(delays, 99):.2f} ms "
                      f"({len(delays)} ticks, as heard by a third process)", flush=True)


if __name__ == "__main__":
    main()
