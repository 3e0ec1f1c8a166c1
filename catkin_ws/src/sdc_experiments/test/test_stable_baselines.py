"""stable-baselines3, which docker/prepare sb3 installs, trains on the environments."""

import re
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

pytestmark = [pytest.mark.nightly, pytest.mark.slow(90)]


@pytest.mark.parametrize("name", ["SdcTown-v0", "SdcRandomRoutes-v0", "SdcTraffic-v0"])
def test_checker_of_stable_baselines_is_content(name):
    checker = pytest.importorskip("stable_baselines3.common.env_checker", reason="sb3")
    gymnasium = pytest.importorskip("gymnasium")
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        checker.check_env(gymnasium.make(f"sdc_experiments.learning:{name}").unwrapped)


def test_ppo_learns_in_a_minute():
    pytest.importorskip("stable_baselines3", reason="run docker/prepare sb3")
    command = [sys.executable, Path(__file__).with_name("train_ppo.py")]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    returns = [float(value) for value in re.findall(r"mean return (\S+)", output)]
    assert len(returns) == 5
    assert returns[-1] > returns[0] + 300.0
