"""The controller: first it is to answer each odometry with one and the same command, then each pair of odometry and path rightly."""

from __future__ import annotations

from sdc_workshop.exam.answer import Problem
from sdc_workshop.exam.local_planner_subject import odometry_at
from sdc_workshop.exam.node_subject import NodeSubject, configuration_problem, message_name, refusal
from sdc_workshop.exam.variant import Variant
from sdc_workshop.workspace import PACKAGE

COMMANDS = "/carla/ego_vehicle/vehicle_control_cmd"
ODOMETRY = "/carla/ego_vehicle/odometry"
ROAD = "/planner/local_waypoints"
THROTTLE, STEER = 0.37, -0.21
# The brake of a controller that stops for want of odometry: so its commands are told apart from answers.
STOP_BRAKE = 0.987
_NEAR = 1e-3
BASICS = ("1.1", "1.2", "1.3", "1.4", "1.5")
PATH_FOLLOWING = ("2.1", "2.2", "2.3", "2.8", "2.9")


class ControllerSubject(NodeSubject):
    """What both parts share."""

    file = f"{PACKAGE}/scripts/simple_controller.py"
    init_todo = "1.2"

    def problems(self, variant: Variant, stage) -> list:
        found = self._problem(variant, stage)
        return [found] if found is not None else []

    def _problem(self, variant, stage):
        raise NotImplementedError

    def _connection_problem(self, node, how, variant):
        found = self.start_problem(node, how, variant)
        if found is not None:
            return found
        if how == "ended":
            return self.ended_problem(node, variant)
        return self.publisher_problem(
            node, COMMANDS, message_name("CarlaVehicleControl"), "1.3"
        ) or self.subscriber_problem(node, ODOMETRY, "nav_msgs/Odometry", "1.4")


def is_stop(command) -> bool:
    """Whether this is the command of a controller that has heard nothing."""
    return abs(command.brake - STOP_BRAKE) < _NEAR


class BasicControlSubject(ControllerSubject):
    """TODO 1.1 to 1.5: constant throttle and steer."""

    todos = BASICS
    left_empty = ("2.1", "2.2", "2.3", "2.8", "2.9")
    needs = ("CarlaVehicleControl",)

    def _problem(self, variant, stage):
        import rospy
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl

        settings = {
            "basic_control": True,
            "basic_throttle": THROTTLE,
            "basic_steer": STEER,
            "patience_s": 1000.0,
            "stop_brake": STOP_BRAKE,
            "steering_method": "stanley",
        }
        with stage.node(variant, settings) as node:
            how = node.wait_until(lambda: node.subscribes(ODOMETRY) and node.publishes(COMMANDS))
            found = self._connection_problem(node, how, variant)
            if found is not None or variant.judged == ("1.2",):
                return found
            heard, odometry = (
                node.listener(COMMANDS, CarlaVehicleControl),
                node.publisher(ODOMETRY, Odometry),
            )
            stamps = []

            def say():
                stamps.append(rospy.Time.now())
                odometry.publish(odometry_at(5.0, 2.0, 0.3, 1.5, stamps[-1]))

            def answers():
                return [command for command in list(heard.messages) if not is_stop(command)]

            how = node.ask(say, answers)
            if how != "true":
                return self._silence(node, how, variant)
            command = answers()[0]
            values = {"throttle": THROTTLE, "steer": STEER, "brake": 0.0}
            got = {name: getattr(command, name) for name in values}
            wrong = [name for name in values if abs(got[name] - values[name]) > _NEAR]
            if wrong:
                hint = f"{wrong[0]} is not handed on: CarlaVehicleControl(throttle=throttle, steer=steer, brake=brake)."
                if (
                    abs(got["throttle"] - STEER) < _NEAR
                    or abs(got["steer"] - THROTTLE) < _NEAR
                    or (abs(got["brake"] - THROTTLE) < _NEAR)
                    or abs(got["brake"] - STEER) < _NEAR
                ):
                    hint = "throttle, steer and brake have changed places: the fields of a message are best given by name, throttle=throttle."
                return Problem(_command(values), _command(got), hint, "1.5")
            if command.header.stamp not in stamps:
                return Problem(
                    "the command carries the stamp of the odometry that it answers",
                    f"its stamp is {command.header.stamp.to_sec():.3f}, the odometry's {stamps[-1].to_sec():.3f}",
                    "command.header.stamp = self.odometry.header.stamp: by it the world knows which moment a command answers.",
                    "1.5",
                )
            last = stamps[-1]
            how = node.ask(
                lambda: odometry.publish(odometry_at(5.0, 2.0, 0.3, 1.5, last)),
                lambda: sum(command.header.stamp == last for command in list(heard.messages)) > 1,
            )
            if how != "true":
                found = self.crash_problem(node, variant)
                if found is not None and "Nonetype" not in found.seen and "None" not in found.seen:
                    return found
                return Problem(
                    "an odometry that comes twice is answered twice, with the same command",
                    "the second time, no command came",
                    "self.last_command = command remembers it: repeat() publishes what is remembered.",
                    "1.5",
                )
            return self.crash_problem(node, variant)

    def _silence(self, node, how, variant):
        found = self.crash_problem(node, variant)
        if found is not None:
            return found
        if how == "busy":
            return Problem(
                "a command for each odometry",
                "a callback runs in circles",
                "Is there a loop in it that never ends?",
            )
        if "1.5" in variant.judged:
            return Problem(
                f"a command on {COMMANDS} for each odometry",
                "an odometry came, and nothing was published",
                "self.publisher.publish(command) sends the command: making one alone does not.",
                "1.5",
            )
        return Problem(
            f"a command on {COMMANDS} for each odometry",
            "an odometry came, and on_odometry was not called",
            "The third argument of rospy.Subscriber is the function that is called with each message: self.on_odometry.",
            "1.4",
        )


class PathFollowingSubject(ControllerSubject):
    """TODO 2.1 to 2.3, 2.8 and 2.9: along the road ahead."""

    todos = PATH_FOLLOWING
    needs = ("CarlaVehicleControl", "Waypoint", "LocalPath")

    def _problem(self, variant, stage):
        from nav_msgs.msg import Odometry
        from sdc_package.msg import CarlaVehicleControl, LocalPath

        settings = {
            "basic_control": False,
            "patience_s": 1000.0,
            "stop_brake": STOP_BRAKE,
            "steering_method": "stanley",
        }
        with stage.node(variant, settings) as node:
            how = node.wait_until(
                lambda: (
                    node.subscribes(ODOMETRY) and node.publishes(COMMANDS) and node.subscribes(ROAD)
                )
            )
            found = self._connection_problem(node, how, variant) or self.subscriber_problem(
                node, ROAD, message_name("LocalPath"), "2.2"
            )
            if found is not None:
                return found
            drive = Drive(
                node,
                node.listener(COMMANDS, CarlaVehicleControl),
                node.publisher(ODOMETRY, Odometry),
                node.publisher(ROAD, LocalPath),
                stage,
            )
            try:
                drive.wanted(SCENES[0])
            except (TypeError, ValueError, KeyError) as error:
                return configuration_problem("simple_controller", error)
            for scene in SCENES:
                how = drive.play(scene)
                if how == "true":
                    continue
                found = self.crash_problem(node, variant)
                if found is not None:
                    return found
                if drive.answer is None:
                    return self._silence(node, how, variant)
                wanted, got = (
                    drive.wanted(scene),
                    {name: getattr(drive.answer, name) for name in ("throttle", "steer", "brake")},
                )
                todo = next(
                    (todo for todo in ("2.9", "2.8", "2.3") if todo in variant.judged), None
                )
                return Problem(
                    f"{scene.text}: {_command(wanted)}",
                    _command(got),
                    self._hint(wanted, got, scene, todo),
                    todo,
                )
            return self.crash_problem(node, variant)

    @staticmethod
    def _hint(wanted, got, scene, todo):
        def near(a, b):
            return abs(a - b) < 0.02

        if todo == "2.3":
            return "The path that was kept is another one than the one that came: each row is (point.x, point.y, point.v), in this order."
        if todo == "2.9" and near(got["steer"], -wanted["steer"]) and abs(wanted["steer"]) > 0.03:
            return (
                "The sign of steer is wrong: a positive wheel angle turns left, a positive steer command turns right; "
                "self.steering_map.command knows."
            )
        if (
            todo == "2.9"
            and near(got["throttle"], wanted["brake"])
            and near(got["brake"], wanted["throttle"])
        ):
            return "throttle and brake have changed places: pedals() returns (throttle, brake), publish() takes throttle, steer, brake."
        if near(got["steer"], wanted["steer"]):
            return {
                "2.8": "The steering is right, the pedals are not: self.speed_control.acceleration takes the target's speed, the "
                "target's acceleration, the car's speed and the step, in this order.",
                "2.9": "The steering is right, the pedals are not: pedals(acceleration) returns (throttle, brake), and publish takes "
                "throttle, steer, brake in this order.",
            }.get(todo, "The pedals are wrong.")
        return {
            "2.8": "The steering is wrong: self.steering.wheel_angle takes the road, x, y, yaw, speed and yaw rate, in this order; "
            "angles are in radians.",
            "2.9": "The steering is wrong: self.steering_map.command(wheel_angle, speed) makes the steer command, and returns with it "
            "whether it was limited.",
        }.get(todo, "The steering is wrong.")

    def _silence(self, node, how, variant):
        said = refusal(node)
        if how == "busy":
            return Problem(
                "a command for each pair of odometry and path",
                "a callback runs in circles",
                "Is there a loop in it that never ends?",
            )
        if said is not None and "refused a path" in said:
            return Problem(
                "the path is kept",
                f"the node says: {said}",
                "Each row of the list is (point.x, point.y, point.v): three numbers.",
                "2.3",
            )
        hints = {
            "2.2": "The third argument of rospy.Subscriber is the function that is called with each message: self.on_path.",
            "2.3": "self.road.update(rows) keeps the path: nothing before it may return.",
            "2.8": "After this region the command is made: nothing before it may return.",
            "2.9": "self.publish(throttle, steer, brake) sends the command.",
        }
        todo = next((todo for todo in ("2.9", "2.8", "2.3", "2.2") if todo in variant.judged), None)
        return Problem(
            f"a command on {COMMANDS} for each pair of odometry and path",
            "both came, and nothing was published",
            hints.get(todo, "Is everything handed on?"),
            todo,
        )


class Scene:
    """A place and a speed of the car, and the speeds planned on a straight road along the line y = x / 2 + 1."""

    def __init__(self, text, x, y, yaw, speed, planned, pedals):
        self.text, self.x, self.y, self.yaw, self.speed, self.planned, self.pedals = (
            text,
            x,
            y,
            yaw,
            speed,
            planned,
            pedals,
        )

    def rows(self):
        return [(0.9 * i, 0.45 * i + 1.0, self.planned(i)) for i in range(25)]


SCENES = (
    Scene(
        "A car to the left of its road, too slow", 4.0, 3.6, 0.4636, 1.0, lambda i: 6.0, "throttle"
    ),
    Scene(
        "A car to the right of its road that points to the left, too fast",
        4.0,
        2.5,
        0.6636,
        12.0,
        lambda i: 6.0,
        "brake",
    ),
    Scene(
        "A car that is as fast as planned, while the plan speeds up",
        4.0,
        3.1,
        0.35,
        5.0,
        lambda i: (25.0 + 2.0 * 1.5 * (i - 4.6) * 1.006) ** 0.5 if i > 4.6 else 5.0,
        "throttle",
    ),
)


class Drive:
    """Plays scenes to a controller, tick by tick, and waits until its command is what it should be."""

    STEP_S = 0.2
    # The acceleration asked for may change by so much a tick that after these it is where it should be.
    TICKS = 14

    def __init__(self, node, heard, odometry, road, stage):
        self.node, self.heard, self.odometry, self.road = node, heard, odometry, road
        self.figures = stage.configuration("simple_controller")
        self.tick = None
        self.answer = None

    def play(self, scene) -> str:
        """How it came, as Program.wait_until has it: "true" when the right command was given."""
        import rospy
        from sdc_package.msg import LocalPath, Waypoint

        if self.tick is None:
            self.tick = rospy.Time.now()
        wanted = self.wanted(scene)
        how = "true"
        for _ in range(self.TICKS):
            self.tick += rospy.Duration(self.STEP_S)
            stamp, before = self.tick, len(self.heard.messages)

            def say(stamp=stamp):
                self.odometry.publish(odometry_at(scene.x, scene.y, scene.yaw, scene.speed, stamp))
                self.road.publish(LocalPath([Waypoint(*row) for row in scene.rows()]))

            def answers(stamp=stamp, before=before):
                return [
                    command
                    for command in self.heard.messages[before:]
                    if command.header.stamp == stamp and not is_stop(command)
                ]

            how = self.node.ask(say, answers)
            if how != "true":
                self.answer = None
                return how
            self.answer = answers()[0]
            if all(
                abs(getattr(self.answer, name) - value) < (0.002 if name == "steer" else 0.03)
                for name, value in wanted.items()
            ):
                return "true"
        return "false"

    def wanted(self, scene) -> dict:
        """The command that this scene comes to, as the car's library reckons it."""
        from sdc_package.actuation import PedalMap, SteeringMap
        from sdc_package.local_path import ReferencePath as Road
        from sdc_package.pid import PidGains
        from sdc_package.speed_control import SpeedControl, SpeedControlLimits
        from sdc_package.steering.axles import Axles
        from sdc_package.steering.method import load_steering

        figures = self.figures
        road = Road()
        road.update(scene.rows())
        control = SpeedControl(PidGains(**figures["pid"]), SpeedControlLimits(**figures["limits"]))
        target = road.nearest(scene.x, scene.y, control.preview_m(scene.speed))
        for _ in range(self.TICKS):
            acceleration = control.acceleration(
                target.speed_mps, target.acceleration_mps2, scene.speed, self.STEP_S
            )
        steering = load_steering("stanley", figures["stanley"], Axles(**figures["axles"]))
        throttle, brake = PedalMap(**figures["pedals"]).pedals(acceleration)
        steer, _ = SteeringMap(**figures["steering"]).command(
            steering.wheel_angle(road, scene.x, scene.y, scene.yaw, scene.speed, 0.0), scene.speed
        )
        return {"throttle": throttle, "steer": steer, "brake": brake}


def _command(values) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())
