"""The world's nodes run with the packages that the world was built with, whoever launches them."""
import os
import subprocess
import sys

SCRIPT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "launch", "own_environment.sh"))
MASTER = "http://127.0.0.1:12345"


def package_seen(environment, *prefix):
    """The file that `import sdc_package` finds, and the master's address."""
    code = "import os, sdc_package.pid; print(sdc_package.pid.__file__); print(os.environ['ROS_MASTER_URI'])"
    return subprocess.run([*prefix, sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True, check=True,
                          timeout=60).stdout.split()


def test_an_unfinished_package_on_top_is_not_seen_and_the_master_is_kept(tmp_path):
    unfinished = tmp_path / "lib" / "python3" / "dist-packages" / "sdc_package"
    unfinished.mkdir(parents=True)
    (tmp_path / ".catkin").write_text("")
    (unfinished / "__init__.py").write_text("")
    (unfinished / "pid.py").write_text("")
    above = {**os.environ, "ROS_MASTER_URI": MASTER,
             "CMAKE_PREFIX_PATH": f"{tmp_path}:{os.environ['CMAKE_PREFIX_PATH']}",
             "PYTHONPATH": f"{unfinished.parent}:{os.environ['PYTHONPATH']}"}
    assert package_seen(above) == [str(unfinished / "pid.py"), MASTER]
    ours = {**os.environ, "ROS_MASTER_URI": MASTER}
    assert package_seen(above, "sh", SCRIPT) == package_seen(ours) == package_seen(ours, "sh", SCRIPT)
