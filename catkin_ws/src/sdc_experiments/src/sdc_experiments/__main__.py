"""The command sdc: drive, scenarios, championship, map check and gym; docs/pip.md has examples.

`python3 -m sdc_experiments COMMAND ...` is the same. ./scenarios and ./championship run it.
"""

from __future__ import annotations

import importlib
import sys

from sdc_common.validation import suggestion
from sdc_experiments.commands import WordError, help_text, parse
from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.dask_engine import ClusterError

# The module and the function of each command, which gets its arguments and returns the exit status.
COMMANDS = {
    "sdc drive": "sdc_experiments.drive_command:run",
    "scenarios": "sdc_experiments.scenarios:run",
    "championship new": "sdc_experiments.championship.attempt:new",
    "championship try": "sdc_experiments.championship.attempt:run",
    "championship round": "sdc_experiments.championship.rounds:run",
    "championship race": "sdc_experiments.championship.race:run",
    "championship baselines": "sdc_experiments.championship.attempt:drive_baselines",
    "sdc map check": "sdc_map.map_report:check",
    "sdc gym": "sdc_experiments.learning:list_environments",
}
# The commands by their first word, as the table of arguments names them.
_BY_WORD = {
    "drive": "sdc drive",
    "scenarios": "scenarios",
    "championship": "championship",
    "map": "sdc map",
    "gym": "sdc gym",
}


def main() -> int:
    """Run the command line and return the exit status."""
    word, *words = sys.argv[1:] or ["--help"]
    try:
        if word in ("-h", "--help"):
            print("\n\n".join(map(help_text, _BY_WORD.values())))
            return 0
        if word not in _BY_WORD:
            fix = suggestion(word, [*_BY_WORD], f"use one of {', '.join(_BY_WORD)}")
            raise WordError(f"unknown command '{word}'; {fix}")
        options = parse(_BY_WORD[word], words)
        module, _, function = COMMANDS[options.command].partition(":")
        return getattr(importlib.import_module(module), function)(options)
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        text = f"{error.filename}: {error.strerror}" if error.filename else str(error)
    except (ValueError, ImportError, ClusterError, SandboxError) as error:
        text = str(error)
    print(f"{word if word in _BY_WORD else 'sdc'}: {text}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
