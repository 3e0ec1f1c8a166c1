"""stable-baselines3 trains on the environments, in the environment of docker/prepare sb3."""

import re
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
PYTHON = HERE.parents[3] / ".sb3" / "bin" / "python"

pytestmark = [pytest.mark.nightly, pytest.mark.slow(90)]


@pytest.mark.skipif(not PYTHON.exists(), reason="run docker/prepare sb3")
def test_ppo_learns_in_a_minute():
    command = [PYTHON, HERE / "train_ppo.py"]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    returns = [float(value) for value in re.findall(r"mean return (\S+)", output)]
    assert len(returns) == 5
    assert returns[-1] > returns[0] + 300.0
