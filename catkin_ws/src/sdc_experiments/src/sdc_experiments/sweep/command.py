"""rosrun sdc_experiments sweep.py STUDY.yaml: drive all cells of a study and write its results."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path
from typing import Sequence

from sdc_experiments.sweep.cell_drive import code_version, drive_cell, worker_problem
from sdc_experiments.sweep.dask_engine import ClusterError, DaskEngine, cores
from sdc_experiments.sweep.progress import SweepProgress
from sdc_experiments.sweep.results import FAILED, Results, ResultsError, table, write_csv
from sdc_experiments.sweep.settings import ROS
from sdc_experiments.sweep.study import Cell, Study, load_study

_DESCRIPTION = """Drive all cells of a study: each combination of its factors with each seed. A
sweep that was interrupted continues with the same command, and drives no finished cell again."""
_SHOWN_FAILURES = 5


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(prog="sweep.py", description=_DESCRIPTION)
    parser.add_argument("study", metavar="STUDY.yaml", type=Path)
    about = "scheduler of a Dask cluster (default: a cluster of processes on this machine)"
    parser.add_argument("--scheduler", default="", metavar="tcp://HOST:PORT", help=about)
    about = "folder of the results (default: the study's name, in the folder sweeps)"
    parser.add_argument("--output", type=Path, metavar="FOLDER", help=about)
    about = "processes on this machine (default: number of cores; with nodes, half of it)"
    parser.add_argument("--workers", type=int, metavar="N", help=about)
    options = parser.parse_args(arguments)
    if options.workers is not None and options.workers < 1:
        parser.error("--workers must be positive")
    if options.workers is not None and options.scheduler:
        parser.error("--workers is for this machine; the cluster of --scheduler has its own")
    return options


def run(arguments: Sequence[str]) -> int:
    """Run the command; return 0 when all cells were driven, 1 when some failed.

    Raises:
        DocumentError, ResultsError, ClusterError, OSError: the sweep cannot start or continue; the
            message is one line
    """
    options = parse(arguments)
    study = load_study(str(options.study))
    folder = (options.output or Path("sweeps") / options.study.stem).absolute()
    results = Results(folder, {**study.identity(), "code": code_version()})
    try:
        return _sweep(study, results, options)
    finally:
        results.close()


def _sweep(study: Study, results: Results, options: argparse.Namespace) -> int:
    cells = study.cells()
    finished = len(results.finished & {cell.key for cell in cells})
    left = [cell for cell in cells if cell.key not in results.finished]
    continued = f"; {finished} of them are finished" if finished else ""
    print(f"sweep: {len(cells)} drives{continued}; results in {results.folder}", flush=True)
    try:
        if left:
            _drive(study, left, results, SweepProgress(sys.stdout, len(cells), finished), options)
    finally:
        _write(study, cells, results)
    failed = results.failed
    for row in failed[:_SHOWN_FAILURES]:
        log = results.folder / row["log"]
        last = log.read_text(encoding="utf-8").strip().rpartition("\n")[2]
        print(f"sweep: failed: {last or 'no output'}; see {log}")
    if failed:
        print(f"sweep: {len(failed)} drives failed; the same command drives them again")
    return 1 if failed else 0


def _drive(
    study: Study,
    cells: list[Cell],
    results: Results,
    progress: SweepProgress,
    options: argparse.Namespace,
) -> None:
    version = code_version()
    by_key = {cell.key: cell for cell in cells}
    settings = study.stack, study.timeout_s, version
    tasks = ((key, (tuple(cell), *settings)) for key, cell in by_key.items())
    count = cores()
    workers = options.workers or (max(1, count // 2) if study.stack == ROS else count)
    with DaskEngine(options.scheduler, workers) as engine:
        if options.scheduler:
            engine.check(worker_problem, version, study.files())
            if not engine.workers:
                print("sweep: the cluster has no worker yet; the drives wait for one", flush=True)
        try:
            for key, result, error in engine.outcomes(drive_cell, tasks):
                failed = {"key": key, **by_key[key]._asdict(), "status": FAILED, "metrics": {}}
                row, log = (failed, error) if error else result
                results.add(row, log)
                progress.add(row["status"] == FAILED)
        finally:
            progress.close()


def _write(study: Study, cells: list[Cell], results: Results) -> None:
    """Write the tables and the page of all cells that were driven."""
    from sdc_experiments.sweep.page import write_page  # Matplotlib is slow to import

    rows = [results.rows[cell.key] for cell in cells if cell.key in results.rows]
    if not rows:
        return
    write_csv(results.folder / "results.csv", table(rows))
    page = write_page(results.folder, study, rows, len(cells) - len(rows))
    print(f"sweep: {len(rows)} of {len(cells)} drives, see {page} and results.csv", flush=True)


def main() -> None:
    """Run the command and exit."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        sys.exit(run(sys.argv[1:]))
    except KeyboardInterrupt:
        print("sweep: interrupted; the same command continues", file=sys.stderr)
        sys.exit(130)
    except (ValueError, ResultsError, ClusterError, OSError) as error:
        print(f"sweep: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
