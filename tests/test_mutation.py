"""The figures of the mutation run, and the code that it mutates."""

import importlib.util
import json
from pathlib import Path

SPEC = importlib.util.spec_from_file_location("mutation", Path(__file__).with_name("mutation.py"))
mutation = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(mutation)

CODE = '''
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Gains:
    """Two gains."""

    kp: float
    ki: float = 0.5

    @property
    def both(self) -> float:
        """Return the sum."""
        return self.kp + self.ki


class Place(NamedTuple):
    x: float

    def twice(self):
        return 2.0 * self.x

    @property
    def half(self):
        return 0.5 * self.x
'''


def test_page_shows_the_stored_figures():
    page = mutation.DOCUMENT.read_text(encoding="utf-8")
    stored = json.loads(mutation.STORED.read_text(encoding="utf-8"))
    assert mutation.table(stored) in page, "run tests/mutate"
    assert set(stored) <= set(mutation.all_modules())


def test_code_without_properties_does_the_same():
    text = mutation.without_properties(CODE)
    assert "@property" not in text
    found = {}
    exec(text, found)
    gains = found["Gains"](2.0)
    assert (gains.both, gains.ki, gains) == (2.5, 0.5, found["Gains"](2.0, 0.5))
    assert (found["Place"](3.0).twice(), found["Place"](3.0).half) == (6.0, 1.5)
    assert found["Place"]._fields == ("x",)


def test_every_library_module_is_valid_without_properties():
    for module in mutation.all_modules():
        text = mutation.path_of(module).read_text(encoding="utf-8")
        compile(mutation.without_properties(text), module, "exec")


def test_a_module_is_tested_by_the_unit_tests_of_its_name_and_of_those_that_import_it():
    named, fast, starting = mutation.tests_of("sdc_package.pid")
    names = [Path(path).name for path in named]
    assert names == ["test_pid.py", "test_speed_control.py"]
    assert set(named) < set(fast)
    fast = mutation.tests_of("sdc_sim.evaluation.metrics")[1]
    assert not [path for path in fast if path.endswith(("test_camera.py", "test_processes.py"))]


def test_a_module_without_a_test_of_its_name_is_tested_by_those_of_its_users():
    named = mutation.tests_of("sdc_sim.physics.vehicle_motion")[0]
    assert "catkin_ws/src/sdc_sim/test/test_vehicle.py" in named
    named, fast, starting = mutation.tests_of("sdc_common.ros.catkin_workspace")
    assert (named, fast) == ([], [])
    assert starting == ["catkin_ws/src/sdc_common/test/test_catkin_workspace.py"]
