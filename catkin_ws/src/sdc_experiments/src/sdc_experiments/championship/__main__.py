"""./championship: write a driver, try it, and hold a round; docs/championship.md describes it."""

from __future__ import annotations

import importlib
import sys

from sdc_common.validation import suggestion
from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.dask_engine import ClusterError

# The module of each command, whose function `run` gets its arguments and returns the exit status,
# and its usage.
COMMANDS = {
    "new": ("attempt:new", "FILE.py"),
    "try": (
        "attempt:run",
        "FILE.py|--stack FILE.launch [workspace:=FOLDER] [league:=control|driving|traffic] "
        "[drives:=200] [seeds:=FIRST-LAST] [replay:=FILE.json] [sandbox:=false] "
        "[report:=report/championship] [--scheduler tcp://HOST:PORT]",
    ),
    "round": (
        "rounds:run",
        "FOLDER [league:=control] [drives:=200] [baselines:=false] [reveal:=false] "
        "[secret:=HEX] [--scheduler tcp://HOST:PORT]",
    ),
    "race": (
        "race:run",
        "A.py B.py [C.py ...] [seed:=1] [replay:=FILE.json] [sandbox:=false] [report:=report/race]",
    ),
    "baselines": ("attempt:drive_baselines", "[league:=control] [drives:=200] [NAME ...]"),
}


def main() -> int:
    """Run the command line and return the exit status."""
    name, arguments = (sys.argv[1:2] or ["--help"])[0], sys.argv[2:]
    if name in ("-h", "--help") or "--help" in arguments:
        print("\n".join(f"./championship {one} {usage}" for one, (_, usage) in COMMANDS.items()))
        return 0
    try:
        if name not in COMMANDS:
            fix = suggestion(name, COMMANDS, "./championship --help lists the commands")
            raise ValueError(f"unknown command '{name}'; {fix}")
        module, _, function = COMMANDS[name][0].partition(":")
        return getattr(importlib.import_module(f"{__package__}.{module}"), function)(arguments)
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        print(f"championship: {error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    except (ValueError, ClusterError, SandboxError) as error:
        print(f"championship: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
