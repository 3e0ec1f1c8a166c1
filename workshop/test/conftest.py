"""Build the world's workspace, and skip tests where there is no sandbox."""

import os
import subprocess
from pathlib import Path

import pytest

from sdc_experiments.sandbox import SandboxError
from sdc_workshop.exam.sandbox import require

os.environ["LANGUAGE"] = "en"  # The tests read English hints on every machine.


@pytest.fixture(scope="session")
def world():
    """Build the workspace that students' workspaces overlay, if it is not built yet."""
    prepare = Path(__file__).resolve().parents[2] / "docker" / "prepare"
    subprocess.run([prepare, "world"], check=True, timeout=300)


@pytest.fixture(scope="session")
def sandboxed():
    """Skip a test where there is no sandbox."""
    try:
        require()
    except SandboxError as error:
        pytest.skip(str(error))
