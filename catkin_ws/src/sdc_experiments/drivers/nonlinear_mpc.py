"""The MPC with the nonlinear model; some of its steps take longer than 20 ms, and act late."""

from sdc_experiments.configuration import node_parameters
from sdc_mpc.nonlinear import NonlinearMpc
from sdc_package.steering.axles import Axles


class Driver:
    def __init__(self, mission):
        config = node_parameters("simple_controller")
        steering = NonlinearMpc(Axles(**config["axles"]), **config["mpc"])
        self.step = mission.default_car(steering).step
