"""The MPC keeps its bars, and the command prints them."""

import sys

import numpy as np
import pytest

pytest.importorskip("osqp", reason="osqp is not installed (docker/prepare mpc)")

from sdc_experiments import tracking
from sdc_experiments.tracking import CONDITIONS, measure, method_of
from sdc_package.local_path import ReferencePath

pytestmark = pytest.mark.slow(40)


@pytest.mark.parametrize(
    ("condition", "rms_m", "worst_m"),
    [
        pytest.param(0, 0.02, 0.10, id="dry", marks=pytest.mark.nightly),
        pytest.param(1, 0.035, 0.10, id="wet"),
    ],
)
def test_mpc_keeps_its_bars_at_20_mps(condition, rms_m, worst_m):
    rms, worst, _ = measure("mpc", *CONDITIONS[condition][1:], seed=11)
    assert rms < rms_m
    assert worst < worst_m


def test_nonlinear_mpc_agrees_near_the_path():
    pytest.importorskip("casadi", reason="casadi is not installed (docker/prepare mpc)")
    path = ReferencePath()
    s = np.arange(-10.0, 40.0)
    path.update(list(zip(100.0 * np.sin(s / 100.0), 100.0 - 100.0 * np.cos(s / 100.0), 0 * s + 15)))
    linear, nonlinear = method_of("mpc"), method_of("nonlinear_mpc")
    for x, y in (0.0, 0.1), (0.75, 0.1):
        wheels = [one.wheel_angle(path, x, y, 0.0, 15.0, 0.15) for one in (linear, nonlinear)]
    assert wheels[0] == pytest.approx(wheels[1], abs=3e-4)
    assert linear.acceleration_mps2 == pytest.approx(nonlinear.acceleration_mps2, abs=0.02)


def test_command_prints_a_row_for_each_drive(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["tracking", "stanley", "seeds:=4"])
    monkeypatch.setattr(tracking, "CONDITIONS", CONDITIONS[:1])
    tracking.main()
    assert "| dry, 20 m/s | `stanley` | " in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["tracking", "stanly"])
    with pytest.raises(SystemExit, match="did you mean 'stanley'"):
        tracking.main()
