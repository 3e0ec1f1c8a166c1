"""The arguments of ./drive that a page may choose, from the table of all commands."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any, Collection, Mapping

from sdc_cockpit.protocol import check_fields, page_schemas
from sdc_common.configuration import package_folder

# What JSON schema calls as the table of commands does.
_SCHEMA = ("type", "minimum", "maximum")


@functools.lru_cache(maxsize=None)
def form_fields() -> dict[str, dict[str, Any]]:
    """Return the rows of the table, with type, range and sentence, and the options of the sim."""
    path = Path(package_folder("sdc_common"), "data", "commands.json")
    rows = json.loads(path.read_text(encoding="utf-8"))["drive"]["arguments"]
    chosen = {name: rows[name] for name in page_schemas()["drive"]}
    return {**chosen, **page_schemas()["sim_options"]}


def drive_arguments(
    scenario: str, values: Mapping[str, Any], scenarios: Collection[str]
) -> list[str]:
    """Return the arguments of ./drive for a scenario, or for the packaged route without a name.

    Raises:
        ValueError: a name is unknown or a value is not allowed
    """
    chosen: dict[str, Any] = {**({"scenario": scenario} if scenario else {}), **values}
    fields: dict[str, Any] = {"scenario": {"enum": sorted(scenarios)}}
    for name, row in form_fields().items():
        keys = ("enum",) if "enum" in row else _SCHEMA
        fields[name] = {key: row[key] for key in keys if key in row}
    check_fields("arguments", chosen, fields, ())
    options = {name: chosen.pop(name) for name in page_schemas()["sim_options"] if name in chosen}
    if options:
        chosen["sim_options"] = options
    return [
        f"{name}:={value if isinstance(value, str) else json.dumps(value)}"
        for name in [*fields, "sim_options"]
        if name in chosen
        for value in [chosen[name]]
    ]
