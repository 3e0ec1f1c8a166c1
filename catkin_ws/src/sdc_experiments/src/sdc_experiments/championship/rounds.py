"""./championship round: grade a folder of drivers on hidden seeds, and write a static site."""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import json
import os
import re
import secrets
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Mapping

from sdc_experiments.championship import command
from sdc_experiments.championship.attempt import page_of, write_page
from sdc_experiments.championship.driver_process import DriverServer
from sdc_experiments.sandbox import SandboxError
from sdc_experiments.sweep.cell_drive import code_version, worker_problem
from sdc_experiments.sweep.dask_engine import DaskEngine, cores
from sdc_experiments.sweep.progress import SweepProgress
from sdc_sim.report.writer import write_json

_ROUND, _SECRET, _RESULTS, _SITE = "round.json", "secret", "results", "site"
_PAGES = {"index.html": "round.html", "feed.xml": "feed.xml"}
# A name is a file name and part of an address.
_NAME = re.compile(r"\w[\w-]{0,60}")


def run(options: SimpleNamespace) -> int:
    """Grade the drivers of a folder, write the site, and return the exit status."""
    folder = Path(options.folder)
    about = opened(folder, options)
    entries = entries_of(folder, options.baselines)
    missing = [name for name, source in entries.items() if not _result(folder, about, name, source)]
    if missing and about.get("secret"):
        raise ValueError(
            f"{folder}: the seeds of this round are public, and {missing[0]} is new or changed; "
            "use a new folder for another round"
        )
    print(f"championship: the secret of the seeds has the SHA-256 {about['secret_sha256']}")
    _write_site(folder, about, {})
    secret = (folder / _SECRET).read_text(encoding="utf-8")
    with DaskEngine(options.scheduler, cores()) as engine:
        if missing:
            engine.check(_worker_problem, code_version())
        (folder / _RESULTS).mkdir(exist_ok=True)
        seeds = seeds_of_secret(secret, about["league"], about["drives"])
        left = {name: entries[name] for name in missing}
        for result in command.graded(engine, left, about["league"], seeds):
            key = {"finished": _now(), "key": _key(about, left[result["name"]])}
            write_json(folder / _RESULTS / f"{result['name']}.json", {**key, **result})
    if options.reveal:
        about["secret"] = secret
        write_json(folder / _ROUND, about)
    found = {name: _result(folder, about, name, source) for name, source in entries.items()}
    table = _write_site(folder, about, {name: result for name, result in found.items() if result})
    for rank, result in enumerate(table, 1):
        problems = "".join(f"; {text}" for text in result["problems"])
        print(f"{rank:3} {result['score']:6.2f} {result['name']}{problems}")
    count = f"{len(table)} driver{'s' * (len(table) != 1)}, {about['drives']} drives each"
    print(f"championship: {about['league']}: {count}, see {folder / _SITE / 'index.html'}")
    return 0


def opened(folder: Path, options: SimpleNamespace) -> dict[str, Any]:
    """Return what the folder says about its round, which the first run writes.

    Raises:
        ValueError: an option is not that of the round
    """
    path = folder / _ROUND
    arguments = {"league": options.league, "drives": options.drives}
    if path.is_file():
        about = json.loads(path.read_text(encoding="utf-8"))
        for name, value in arguments.items():
            if about[name] != value:
                text = f"the round of this folder has {name}:={about[name]}, not {value}"
                raise ValueError(f"{folder}: {text}; use a new folder for another round")
        return about
    secret = options.secret or secrets.token_hex(32)
    file = os.open(folder / _SECRET, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
    with open(file, "w", encoding="utf-8") as stream:
        stream.write(secret)
    digest = hashlib.sha256(secret.encode()).hexdigest()
    about = {**arguments, "secret_sha256": digest, "opened": _now()}
    write_json(path, about)
    return about


def seeds_of_secret(secret: str, league: str, drives: int) -> list[str]:
    """Return the seeds of a round."""
    texts = (f"{secret}/{league}/{number}" for number in range(drives))
    return [hashlib.sha256(text.encode()).hexdigest() for text in texts]


def entries_of(folder: Path, with_baselines: bool) -> dict[str, str]:
    """Return the file of each driver by its name; of one that is no Python, the reason.

    Raises:
        ValueError: a file's name cannot be that of a page
    """
    names = command.FAST if with_baselines else ()
    found = {name: command.baseline(name) for name in names}
    for path in sorted(folder.glob("*.py")):
        if not _NAME.fullmatch(path.stem) or path.stem in {*found, "index"}:
            raise ValueError(
                f"{path}: rename it to letters, digits, - and _, not a baseline's name"
            )
        try:
            found[path.stem] = command.source_of(path)
        except (ValueError, OSError) as error:
            text = str(error).replace(str(path), path.name)
            found[path.stem] = f"raise SystemExit({text!r})"
    return found


def _key(about: Mapping[str, Any], source: str) -> str:
    """Return a text that differs where the score may differ."""
    parts = about["secret_sha256"], about["league"], about["drives"], code_version(), source
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _result(folder: Path, about: Mapping[str, Any], name: str, source: str) -> dict[str, Any]:
    """Return the stored result of a driver; an empty one if it was not graded or has changed."""
    with contextlib.suppress(OSError, ValueError):
        found = json.loads((folder / _RESULTS / f"{name}.json").read_text(encoding="utf-8"))
        if found["key"] == _key(about, source):
            return found
    return {}


def _worker_problem(version: str) -> str:
    """Return why this process cannot drive, or ""."""
    try:
        with DriverServer(""):
            return worker_problem(version, [])
    except SandboxError as error:
        return str(error)


def _write_site(
    folder: Path, about: Mapping[str, Any], results: Mapping[str, dict]
) -> list[dict[str, Any]]:
    """Write the site, and return the results, the best first."""
    site, table = folder / _SITE, sorted(results.values(), key=lambda result: -result["score"])
    site.mkdir(exist_ok=True)
    write_json(site / _ROUND, about)
    secret = about.get("secret", "")
    seeds = seeds_of_secret(secret, about["league"], about["drives"]) if secret else []
    drives = table[0]["rows"] if table else []
    number_of = {row["seed"]: number for number, row in enumerate(drives, 1)}
    progress = SweepProgress(sys.stdout, len(table), 0, "championship", "pages")
    for rank, entry in enumerate(table, 1):
        name, worst, shown = entry["name"], command.worst_of(entry), ""
        path = folder / f"{name}.py"
        source = path.read_text("utf-8", "replace") if path.exists() else command.baseline(name)
        if secret:
            write_json(site / f"{name}.json", entry)
            with DriverServer(source) as server:
                shown = page_of(server, about["league"], worst)
        # A drive is known by its number: the seeds are public after the reveal only.
        numbered = [{**row, "seed": number_of[row["seed"]]} for row in entry["rows"]]
        worst, result = {**worst, "seed": number_of[worst["seed"]]}, {**entry, "rows": numbered}
        values = {"rank": rank, "count": len(table), "about": about, "source": source}
        values = {**values, "result": result, "worst": worst, "shown": shown}
        write_page(site / f"{name}.html", "championship_entry.html.jinja", **values)
        progress.add()
    progress.close()
    for name, template in _PAGES.items():
        template = f"championship_{template}.jinja"
        write_page(site / name, template, about=about, table=table, seeds=seeds)
    return table


def _now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
