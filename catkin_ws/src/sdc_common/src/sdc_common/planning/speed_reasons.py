"""Names of what limits the planned speed at the car: why it drives no faster, or brakes."""

# A reason is published when it changes, and again after this simulated time: at most the
# controller's timeout, so that the first plan after a timeout is published.
REPEAT_NS = 250_000_000

CRUISE = "cruise"
BEND = "bend"
BRAKING_AHEAD = "braking_ahead"
END_OF_ROUTE = "end_of_route"
ACCELERATING = "accelerating"
OBSTACLE = "obstacle"
TRAFFIC_LIGHT = "traffic_light"
PATH_TIMEOUT = "path_timeout"
ODOMETRY_TIMEOUT = "odometry_timeout"

MEANINGS = {
    CRUISE: "the cruise speed",
    BEND: "the lateral acceleration, or its change, in a bend",
    BRAKING_AHEAD: "brakes for a bend ahead",
    END_OF_ROUTE: "brakes for the end of the route",
    ACCELERATING: "accelerates, at the start or after a bend",
    OBSTACLE: "stops behind an obstacle, or follows it",
    TRAFFIC_LIGHT: "stops at a traffic light",
    PATH_TIMEOUT: "the controller brakes: no path arrives",
    ODOMETRY_TIMEOUT: "the controller brakes: no odometry arrives",
}
