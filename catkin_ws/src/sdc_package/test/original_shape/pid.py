"""A module beside the nodes, which they import by its name."""


class PID:
    def __init__(self, kp, kd):
        self.kp, self.kd, self.last = kp, kd, 0.0

    def step(self, error, seconds):
        slope, self.last = (error - self.last) / seconds, error
        return min(max(self.kp * error + self.kd * slope, 0.0), 1.0)
