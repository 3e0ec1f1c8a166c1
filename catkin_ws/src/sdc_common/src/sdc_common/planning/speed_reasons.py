"""How often what limits the planned speed at the car is published.

The names of the reasons are in config/report_page.yaml of sdc_sim, with what they mean.
"""

# A reason is published when it changes, and again after this simulated time: at most the
# controller's timeout, so that the first plan after a timeout is published.
REPEAT_NS = 250_000_000
