#!/usr/bin/env python3
"""Cockpit: serves a page that shows the drive, and on which a person can drive."""

import argparse
import asyncio
import concurrent.futures
import contextlib
import functools
import os
import threading
import time
from dataclasses import replace
from pathlib import Path

import cv2
import rosgraph
import rospy
import tornado.httpserver
import tornado.ioloop
from geometry_msgs.msg import Point, PointStamped, PoseStamped
from rosgraph_msgs.msg import Log
from sdc_msgs.msg import CarlaVehicleControl
from sensor_msgs.msg import Image
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger

from sdc_cockpit import protocol, server
from sdc_cockpit.access import Access, is_loopback, new_token
from sdc_cockpit.drive_arguments import drive_arguments, form_fields
from sdc_cockpit.drive_runner import DriveRunner, metrics_of
from sdc_cockpit.drive_view import EGO, DriveView
from sdc_cockpit.driving import PERSON, STACK, RemoteDriving
from sdc_cockpit.graph_view import LogLines, node_rows
from sdc_cockpit.live_parameters import change_parameter, live_parameters
from sdc_cockpit.pictures import DriveSpeed, RateLimit, jpeg_file, mask_png
from sdc_cockpit.topic_feeds import Feed, TopicFeeds, decoded, seconds_of, stamp_of
from sdc_cockpit.viewers import Viewers
from sdc_common.configuration import package_folder
from sdc_common.ros.conversion import command_message
from sdc_common.ros.drive_master import running_node
from sdc_common.ros.node import ENDED_PARAMETER, LoopPublisher, parameter, refuse, spin_with
from sdc_common.ros.refusal import refusing
from sdc_common.validation import check_between, check_positive
from sdc_sim.manual_control.keyboard import KeyboardControlRates
from sdc_sim.road.road_markings import SPEED_COLOURS
from sdc_sim.scenario.packaged import folder_of

CAMERA = EGO + "/camera/rgb/front/image_color"
LANE_MASK = "/camera/lane_mask"
LANE_OVERLAY = "/perception/lane_overlay"
# Their kinds on the page.
PICTURES = {
    CAMERA: protocol.CAMERA,
    LANE_MASK: protocol.LANE_MASK,
    LANE_OVERLAY: protocol.LANE_OVERLAY,
}
UPDATE_S = 0.05
NODES_EVERY_S = 2.0
IDLE_STATE_EVERY_S = 0.5
LAST_MESSAGE_S = 0.2


def command_line():
    """Return the command that starts drives, and their folder."""
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--drive-command", default="")
    arguments.add_argument("--drives-folder", type=Path, default=Path("drives"))
    return arguments.parse_args(rospy.myargv()[1:])


class Cockpit:
    def __init__(self):
        rospy.init_node("cockpit")
        cv2.setNumThreads(1)
        try:
            self.jpeg_quality = parameter("jpeg_quality")
            self.lockstep_rest_s = parameter("lockstep_rest_s")
            check_between(1, 100, jpeg_quality=self.jpeg_quality)
            check_positive(lockstep_rest_s=self.lockstep_rest_s)
            self.limits = {kind: RateLimit(parameter("pictures_per_second")) for kind in PICTURES}
            self.driving = RemoteDriving(
                KeyboardControlRates(**parameter("manual_control")["rates"]),
                parameter("driver_timeout_s"),
                parameter("braking_limit_s"),
            )
        except (KeyError, TypeError, ValueError) as error:
            refuse(f"{error}; correct it in config/cockpit.yaml or config/manual_control.yaml")
        self.full_speed_mps = parameter("full_speed_mps")
        options = command_line()
        self.drives = DriveRunner(options.drive_command, options.drives_folder, self.on_drive_end)
        self.scenarios = sorted(path.stem for path in Path(folder_of("scenario")).glob("*.yaml"))
        self.address = parameter("address")
        self.access = Access(new_token(), is_loopback(self.address))
        try:
            self.sockets, self.port = server.bind(self.address, parameter("port"))
        except OSError as error:
            refuse(f"cannot listen on {self.address}: {error}; set cockpit_address or cockpit_port")
        self.viewers = Viewers()
        self.log = LogLines()
        self.loop = None
        self.publishing = threading.Lock()
        self.overridden = self.other_driver = False
        self.next_nodes_s = self.next_state_s = 0.0
        self.drive_speed = DriveSpeed()
        self.executor = concurrent.futures.ThreadPoolExecutor(max_workers=4)
        self.master = rosgraph.Master(rospy.get_name())
        # What the messages of a page do, by their type; all other types are services of the world.
        self.actions = {
            "drawn": lambda viewer, values: viewer.drawn(values["picture"]),
            "keys": self.control,
            "pedals": self.control,
            "show": self.show_mask,
            "obstacle": self.place_obstacle,
            "goal": self.set_goal,
            "set": lambda _, values: self.begin(change_parameter, values["name"], values["value"]),
            "start": self.request_drive,
            "stop": lambda *_: self.begin(self.stop_drive),
            "drive": self.take_car,
            "release": self.release_car,
            "reverse": lambda viewer, _: self.driving.toggle_reverse(viewer.number),
        }

        self.commands = LoopPublisher(EGO + "/vehicle_control_cmd_manual", CarlaVehicleControl)
        self.overrides = LoopPublisher(EGO + "/vehicle_control_manual_override", Bool, latch=True)
        self.goal_publisher = rospy.Publisher("/move_base_simple/goal", PoseStamped, queue_size=10)
        self.click_publisher = rospy.Publisher("/clicked_point", PointStamped, queue_size=10)

        self.view = DriveView(
            time.time, self.on_odometry, lambda: rospy.get_param("/sim/map_path", "")
        )
        camera, *lanes = (
            Feed(topic, picture=True, callback=functools.partial(self.on_picture, topic))
            for topic in PICTURES
        )
        self.feeds = TopicFeeds([camera, *self.view.feeds, *lanes])
        rospy.Subscriber("/rosout", Log, self.log.add)
        rospy.Subscriber(EGO + "/vehicle_control_manual_override", Bool, self.on_override)

    def on_picture(self, topic, message):
        kind = PICTURES[topic]
        if not self.viewers.wanted(kind):
            return
        with refusing(topic):
            stamp = stamp_of(message)
            stamp_s, now_s = seconds_of(stamp), time.monotonic()
            self.drive_speed.add(now_s, stamp_s)
            if not self.limits[topic].admits(now_s):
                return
            if self.drive_speed.is_lockstep:
                self.feeds.rest(topic, self.lockstep_rest_s)
            picture = decoded(message, Image)
            is_mask = topic == LANE_MASK
            file = mask_png(picture) if is_mask else jpeg_file(picture, self.jpeg_quality)
            wall_s = self.view.wall_time_of(stamp)
            self.in_loop(self.viewers.broadcast_picture, kind, stamp_s, wall_s, file)

    def on_odometry(self):
        if self.driving.overrides:
            self.publish_command()

    def on_override(self, message):
        """Notice when another program, such as the manual control window, takes the car."""
        caller = message._connection_header["callerid"]
        if caller != rospy.get_name():
            self.other_driver = message.data

    def in_loop(self, function, *arguments):
        if self.loop is not None:
            self.loop.add_callback(function, *arguments)

    def publish_command(self):
        # Two threads call it: of two messages, the later one must have the later content.
        with self.publishing:
            command = self.driving.step(time.monotonic(), self.view.speed_mps)
            if self.driving.overrides != self.overridden:
                self.overridden = self.driving.overrides
                self.overrides.publish(self.overridden)
            if command is not None:
                stamp_ns = rospy.Time(*(self.view.stamp or (0, 0))).to_nsec()
                command = replace(command, stamp_ns=stamp_ns)
                self.commands.publish(command_message(command, CarlaVehicleControl))

    # The methods that the server calls.

    def joined(self, viewer):
        if len(self.viewers) == 1:
            self.log.take_new()  # The page gets all lines below.
        fields = {"scenario": {"enum": self.scenarios}, **form_fields()}
        scale = {"full_speed": self.full_speed_mps, "speed_colours": SPEED_COLOURS}
        values = {"viewer": viewer.number, "fields": fields, **scale}
        viewer.send(protocol.json_message("hello", log=self.log.all(), **values))
        self.executor.submit(self.attempt, "Drives", self.send_drives)
        self.next_nodes_s = self.next_state_s = 0.0
        self.subscribe()

    def left(self, viewer):
        self.driving.vanish(viewer.number, time.monotonic())
        self.subscribe()

    def road_json(self):
        road = self.view.road
        return None if road is None else road.to_json()

    def receive(self, viewer, message):
        kind, values = message
        action = self.actions.get(kind)
        if action is None:
            self.executor.submit(self.call_sim, kind)
        else:
            action(viewer, values)

    def control(self, viewer, values):
        self.driving.control(viewer.number, values, time.monotonic())

    def show_mask(self, viewer, values):
        viewer.shows_mask = values["mask"]
        self.subscribe()

    def place_obstacle(self, _viewer, values):
        header = Header(stamp=rospy.Time(0), frame_id="map")
        self.click_publisher.publish(header, Point(values["x"], values["y"], 0.0))

    def set_goal(self, _viewer, values):
        goal = PoseStamped(header=Header(stamp=rospy.Time(0), frame_id="map"))
        goal.pose.position.x, goal.pose.position.y = values["x"], values["y"]
        self.goal_publisher.publish(goal)

    def request_drive(self, _viewer, values):
        arguments = drive_arguments(values["scenario"], values["arguments"], self.scenarios)
        self.begin(self.start_drive, values["scenario"], arguments)

    def take_car(self, viewer, _values):
        self.driving.take(viewer.number, time.monotonic())
        self.publish_command()

    def release_car(self, viewer, _values):
        self.driving.release(viewer.number)
        self.publish_command()

    def call_sim(self, name):
        try:
            answer = rospy.ServiceProxy("/sim/" + name, Trigger)()
            level, text = "info" if answer.success else "warn", f"{name}: {answer.message}"
        except (rospy.ServiceException, rospy.ROSInterruptException) as error:
            level, text = "warn", f"{name}: this world does not offer it ({error})"
        self.notice(level, text)

    def notice(self, level, text):
        message = protocol.json_message("notice", level=level, text=text)
        self.in_loop(self.viewers.broadcast, message, True)

    def begin(self, action, *arguments):
        self.executor.submit(self.reported, action, *arguments)

    def reported(self, action, *arguments):
        """Call what a page asked for, and report to all pages how it went."""
        try:
            self.notice("info", action(*arguments))
        except (ValueError, OSError, rosgraph.MasterException) as error:
            self.notice("warn", str(error))
        self.send_parameters()

    def start_drive(self, scenario, arguments):
        name = self.drives.start(scenario, arguments, self.before_drive)
        self.send_drives()
        return f"started {name}"

    def before_drive(self):
        if node := running_node(rosgraph.get_master_uri(), ["/sim"]):
            raise ValueError(f"a drive runs that this page did not start: {node}; end it first")
        rospy.set_param(ENDED_PARAMETER, False)
        self.view.clear()

    def stop_drive(self):
        self.drives.stop()
        return "the drive ends and writes its report"

    def on_drive_end(self):
        self.driving.release()
        self.publish_command()
        self.other_driver = False
        self.send_drives()

    def send_drives(self):
        past = [{**row, "key": self.access.key(row["name"])} for row in self.drives.past()]
        drives = {"running": self.drives.running, "ended": self.drives.last, "past": past}
        message = protocol.json_message("drives", offered=self.drives.offered, **drives)
        self.in_loop(self.viewers.broadcast, message, True)

    def send_parameters(self):
        message = protocol.json_message("parameters", values=live_parameters())
        self.in_loop(self.viewers.broadcast, message)

    # The work of the server's thread.

    def subscribe(self):
        topics = frozenset()
        if len(self.viewers) or self.driving.overrides:
            topics = frozenset(self.feeds.feeds)
            if not self.viewers.shows_mask:
                topics -= {LANE_MASK, LANE_OVERLAY}
            if not len(self.viewers):
                topics -= {CAMERA}
        self.feeds.want(topics)

    def update(self):
        if self.driving.overrides:
            self.publish_command()
            if not self.driving.overrides:
                self.subscribe()
        if not len(self.viewers):
            return
        now_s = time.monotonic()
        lines = self.log.take_new()
        if lines:
            self.viewers.broadcast(protocol.json_message("log", lines=lines), always=True)
        if now_s >= self.next_nodes_s:
            self.next_nodes_s = now_s + NODES_EVERY_S
            self.executor.submit(self.attempt, "Nodes", self.send_nodes)
        if self.view.running or now_s >= self.next_state_s:
            self.next_state_s = now_s + IDLE_STATE_EVERY_S
            self.viewers.broadcast(protocol.json_message("state", **self.state()))

    def state(self):
        mode = self.driving.mode
        if mode == STACK and self.other_driver:
            mode = "other program"
        driver = self.driving.viewer if mode == PERSON else None
        values = {"mode": mode, "driver": driver, "viewers": len(self.viewers)}
        return {**self.view.state(), **values, "phase": self.phase()}

    def phase(self):
        """Return what happens before and after the drive itself, None while the car drives."""
        if self.view.stamp is None:
            return self.drives.phase or "no simulation yet"
        with contextlib.suppress(OSError, rosgraph.MasterException):
            if rospy.get_param_cached(ENDED_PARAMETER, False):
                return "writing the report"
        return None

    def attempt(self, panel, action):
        """Send the content of a panel, or report why there is none."""
        try:
            action()
        except (ValueError, OSError, rosgraph.MasterException) as error:
            self.notice("warn", f"{panel}: {error}")

    def send_nodes(self):
        rows = node_rows(self.master, self.feeds.rates())
        self.in_loop(self.viewers.broadcast, protocol.json_message("nodes", nodes=rows))
        self.send_parameters()

    def serve(self):
        asyncio.set_event_loop(asyncio.new_event_loop())
        self.loop = tornado.ioloop.IOLoop.current()
        www = Path(package_folder("sdc_cockpit")) / "www"
        web = tornado.httpserver.HTTPServer(
            server.application(self, self.access, www), **server.LIMITS
        )
        web.add_sockets(self.sockets)
        url = server.page_address(self.address, self.port, self.access.token)
        print("cockpit: " + url, flush=True)
        tornado.ioloop.PeriodicCallback(self.update, 1e3 * UPDATE_S).start()
        rospy.on_shutdown(self.on_shutdown)
        self.loop.start()

    def show_end(self):
        """Show how the drive of this page ended, which ends the page, too."""
        with contextlib.suppress(OSError, KeyError, rosgraph.MasterException):
            path = os.path.expanduser(rospy.get_param("/referee/report"))
            metrics = {"report": path, **metrics_of(path)}
            self.in_loop(self.viewers.broadcast, protocol.json_message("ended", **metrics), True)

    def on_shutdown(self):
        if not self.drives.offered:
            self.show_end()
        self.drives.end()
        if self.overridden:
            self.overrides.publish(False)
            time.sleep(LAST_MESSAGE_S)
        self.in_loop(self.loop.stop)


if __name__ == "__main__":
    cockpit = Cockpit()
    spin_with(cockpit.serve)
