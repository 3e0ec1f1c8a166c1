"""Names of what limits the planned speed at the car: why it drives no faster, or brakes."""

# A reason is published when it changes, and again after this simulated time: at most the
# controller's timeout, so that the first plan after a timeout is published.
REPEAT_NS = 250_000_000

MEANINGS = {
    "cruise": "the planned speed, or the limit of the road",
    "bend": "the lateral acceleration, or its change, in a bend",
    "braking_ahead": "brakes for a bend or a lower limit ahead",
    "end_of_route": "brakes for the end of the route",
    "accelerating": "accelerates, at the start or after a bend",
    "obstacle": "stops behind an obstacle, or follows it",
    "traffic_light": "stops at a traffic light",
    "stop_sign": "stops at a stop sign",
    "right_of_way": "gives way at a junction",
    "junction_blocked": "waits until the way out of a junction is free",
    "crosswalk": "stops for a pedestrian at a crosswalk",
    "passing": "drives beside its lane, around another road user",
    "merging": "lets another one go first, where lanes change",
    "path_timeout": "the controller brakes: no path arrives",
    "odometry_timeout": "the controller brakes: no odometry arrives",
}
