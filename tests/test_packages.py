"""What docker/prepare installs from PyPI: one environment, on Debian's packages."""

import hashlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ROOT / ".venv" / "packages"
LIST = ROOT / "docker" / "venv-packages.txt"
EXTRA = re.compile(r"^(\w+) = (\[.*\])$", re.MULTILINE)

pytestmark = pytest.mark.slow(4)


def listed(text):
    return set(re.findall(r"^([\w.-]+)==", text, re.MULTILINE))


def wheel(folder, version):
    """Write a wheel of sumolib that has a module of this version; return its row in a list."""
    path = folder / f"sumolib-{version}-py3-none-any.whl"
    info = f"sumolib-{version}.dist-info"
    files = {
        f"sumolib_{version[0]}.py": "",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: sumolib\nVersion: {version}\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{info}/RECORD": "",
    }
    folder.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as file:
        for name, text in files.items():
            file.writestr(name, text)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return f"sumolib=={version} \\\n    --hash=sha256:{digest}\n"


@pytest.fixture
def project(tmp_path):
    """A project in which nothing is installed."""
    shutil.copytree(ROOT / "docker", tmp_path / "project" / "docker")
    shutil.copy(ROOT / "pyproject.toml", tmp_path / "project")
    return tmp_path / "project"


def prepare(project, *steps, status=0):
    """Run docker/prepare in a project whose only source of packages is its folder of wheels."""
    offline = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(project / "wheels")}
    done = subprocess.run(
        [project / "docker" / "prepare", *steps],
        env={**os.environ, **offline, "PIP_CONFIG_FILE": os.devnull},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stderr
    return done.stderr


def modules(project):
    return sorted(path.stem for path in (project / ".venv" / "packages").glob("sumolib_*.py"))


@pytest.mark.parametrize("step", ["linters", pytest.param("browser", marks=pytest.mark.nightly)])
def test_missing_connection_to_pypi_is_one_line(project, step):
    line = prepare(project, step, status=1).splitlines()[-1]
    assert line.startswith(f"prepare: {step} is not installed: PyPI cannot be reached")
    assert line.endswith(f"run docker/prepare {step} with a connection")


def test_packages_are_installed_once_and_again_when_their_version_changes(project, tmp_path):
    packages = project / "docker" / "venv-packages.txt"
    (project / ".maps").mkdir()
    packages.write_text(wheel(project / "wheels", "1.0") + "libsumo==1.0 --hash=sha256:0\n")
    assert prepare(project, "town") == "prepare: installing town into .venv (packages of PyPI: 1)\n"
    assert modules(project) == ["sumolib_1"]
    assert not (project / ".maps").exists()
    moved = project.rename(tmp_path / "moved")
    assert prepare(moved, "town", "town") == ""
    (moved / "docker" / packages.name).write_text(wheel(moved / "wheels", "2.0"))
    assert (
        prepare(moved, "town", "town")
        == "prepare: installing town into .venv (packages of PyPI: 1)\n"
    )
    assert modules(moved) == ["sumolib_2"]


def test_every_package_of_an_extra_is_in_the_list_or_debians():
    table = (ROOT / "pyproject.toml").read_text().split("[project.optional-dependencies]")[1]
    extras = EXTRA.findall(table.split("\n\n")[0])
    names = {name for _, row in extras for name in re.findall(r'"([\w.-]+)"', row)}
    debian = re.findall(r"^python3-(\S+)", (ROOT / "docker/apt-packages.txt").read_text(), re.M)
    assert listed(LIST.read_text()) == names - {*debian}


def test_numpy_is_that_of_debian():
    debian = re.findall(r"^python3-(\S+)", (ROOT / "docker/apt-packages.txt").read_text(), re.M)
    assert [one for one in listed(LIST.read_text()) if one.partition("-")[0] in debian] == []
    names = ("numpy", "scipy", "cv2", "typing_extensions", "yaml")
    code = f"import {', '.join(names)}\nprint({', '.join(f'{name}.__file__' for name in names)})"
    for python in ("python3", ROOT / ".venv" / "bin" / "python"):
        printed = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True)
        files = printed.stdout.split()
        assert [file for file in files if not file.startswith("/usr/lib/python3/")] == []


def test_program_that_runs_finds_what_is_installed_later():
    code = "import sys\ntry:\n import sdc_later\nexcept ImportError:\n print('missing', flush=True)"
    code += "\nsys.stdin.readline()\nimport sdc_later"
    module = PACKAGES / "sdc_later.py"
    program = subprocess.Popen(
        [sys.executable, "-B", "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert program.stdout.readline() == "missing\n"
        module.touch()
        program.communicate("\n")
    finally:
        module.unlink()
        program.kill()
    assert program.returncode == 0
