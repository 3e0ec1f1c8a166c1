"""./championship: write a driver, try it, and hold a round; docs/championship.md describes it."""

from __future__ import annotations

import importlib
import sys

from sdc_experiments.commands import parse
from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.dask_engine import ClusterError

# The module and function of each command, which gets its arguments and returns the exit status.
COMMANDS = {
    "new": "attempt:new",
    "try": "attempt:run",
    "round": "rounds:run",
    "race": "race:run",
    "baselines": "attempt:drive_baselines",
}


def main() -> int:
    """Run the command line and return the exit status."""
    try:
        options = parse("championship", sys.argv[1:])
        module, _, function = COMMANDS[options.command.split()[1]].partition(":")
        return getattr(importlib.import_module(f"{__package__}.{module}"), function)(options)
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
