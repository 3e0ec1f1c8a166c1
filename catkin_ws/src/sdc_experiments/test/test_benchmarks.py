"""The table of benchmarks, and how rounds become lines."""

import re
import sys
from pathlib import Path

import pytest

from sdc_experiments.benchmarks.command import BENCHMARKS, table
from sdc_testing import program

PACKAGE = Path(__file__).resolve().parents[1]
PAGE = (PACKAGE.parents[2] / "docs" / "performance.md").read_text(encoding="utf-8")


def run(*arguments):
    return program.run(sys.executable, PACKAGE / "scripts" / "benchmark.py", *arguments)


def test_ratio_is_the_median_of_the_ratios_within_each_round():
    pairs = (1.0, 3.0), (2.0, 4.0), (10.0, 10.0)
    rounds = [dict(zip(("first", "other"), pair)) for pair in pairs]
    *_, first, other = table("lidar", rounds).splitlines()
    assert first.split() == ["first", "2", "1", "10", "1.00"]
    assert other.split() == ["other", "4", "3", "10", "2.00"]


def test_every_benchmark_is_listed_and_described():
    listed = [line.split()[0] for line in run().stdout.splitlines()]
    assert listed == list(BENCHMARKS)
    for name in BENCHMARKS:
        assert re.search(rf"^\| .*`{name}`.* \|", PAGE, re.MULTILINE), name


@pytest.mark.slow(2)
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["lidra"], "no benchmark 'lidra'; use some of tick, "),
        (["tick", "--setup", "missing"], "--setup: there is no file missing"),
        (["tick", "--rounds", "0"], "--rounds must be positive, got 0"),
    ],
)
def test_mistake_is_named(arguments, message):
    done = run(*arguments)
    assert done.returncode == 2
    assert message in done.stdout


@pytest.mark.nightly
@pytest.mark.slow(4)
def test_benchmark_prints_a_table():
    done = run("lidar", "--rounds", "1")
    assert done.returncode == 0, done.stdout
    assert done.stdout.startswith("lidar: ")
    assert done.stdout.splitlines()[2].endswith(" 1.00")
