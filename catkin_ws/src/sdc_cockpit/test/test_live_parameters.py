"""Parameters that change while the car drives, with a parameter server in memory."""

from types import SimpleNamespace

import pytest
import rosgraph
import rospy

from sdc_cockpit.live_parameters import change_parameter, live_parameters

NAMES = ["/sim/friction", "/sim/side_wind_mps", "/sim/odometry_noise/position_m"]
NAMES.append("/simple_controller/stanley/k")


@pytest.fixture
def server(monkeypatch):
    """Provide the parameters, and what each node answers to ~reload; None is no answer."""
    sim = {"friction": 1.0, "side_wind_mps": 0.0, "tick_s": 0.05}
    sim["odometry_noise"] = {"position_m": 0.0}
    controller = {"steering_method": "stanley", "stanley": {"k": 2.5, "name": "text"}}
    controller["lqr"] = {"steer_weight": 1.0}
    values = {"/sim": sim, "/simple_controller": controller}
    answers = {"/sim/reload": (True, ""), "/simple_controller/reload": (True, "")}

    def set_param(name, value):
        *path, last = name.lstrip("/").split("/")
        place = values["/" + path[0]]
        for part in path[1:]:
            place = place[part]
        place[last] = value

    def proxy(name, _service_class):
        def call():
            if answers[name] is None:
                raise rospy.ServiceException("service not available")
            success, message = answers[name]
            return SimpleNamespace(success=success, message=message)

        return call

    def lookup(_master, name):
        if name not in answers:
            raise rosgraph.MasterError("no provider")

    monkeypatch.setattr(rosgraph.Master, "lookupService", lookup)
    monkeypatch.setattr(rospy, "get_param", lambda name, default: values.get(name, default))
    monkeypatch.setattr(rospy, "set_param", set_param)
    monkeypatch.setattr(rospy, "ServiceProxy", proxy)
    return SimpleNamespace(values=values, answers=answers)


def test_disturbances_and_gains_of_the_steering_method_are_listed(server):
    assert list(live_parameters()) == NAMES
    del server.values["/sim"]
    assert list(live_parameters()) == NAMES[3:]


def test_refused_value_is_restored_and_reported_in_one_line(server):
    server.answers["/sim/reload"] = (False, "friction must be a number from 0.001 to 100, got -1.0")
    with pytest.raises(ValueError, match="^/sim/friction: friction must be a number"):
        change_parameter("/sim/friction", -1.0)
    assert live_parameters()["/sim/friction"] == 1.0


def test_node_that_does_not_respond_is_reported(server):
    server.answers["/simple_controller/reload"] = None
    with pytest.raises(ValueError, match="/simple_controller did not respond"):
        change_parameter("/simple_controller/stanley/k", 1.0)
    assert live_parameters()["/simple_controller/stanley/k"] == 2.5


@pytest.mark.parametrize("name", ["/sim/tick_s", "/simple_controller/lqr/steer_weight", "/x", ""])
def test_other_parameters_cannot_be_changed(server, name):
    with pytest.raises(ValueError, match="no running node offers to change it"):
        change_parameter(name, 1.0)
