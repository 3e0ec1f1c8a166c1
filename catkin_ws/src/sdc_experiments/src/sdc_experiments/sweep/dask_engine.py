"""Run independent tasks on a Dask cluster: the one of a scheduler, or one on this machine."""

from __future__ import annotations

import atexit
import contextlib
import importlib
import itertools
import logging
import os
import pickle
import signal
import tempfile
import uuid
import warnings
from multiprocessing import resource_tracker
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple

from sdc_common.configuration import how_to_install

# More tasks than these wait at the scheduler only when there are more workers.
_WAITING_TASKS = 200
_CONNECT_TIMEOUT_S = 10.0
_OWN_CLUSTER = {
    # A worker gets its next task when it is free: a task that kills its worker is alone.
    "distributed.scheduler.worker-saturation": 1.0,
    # These samples of each worker only serve a dashboard, and cost a tenth of a drive.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.worker.memory.monitor-interval": "500ms",
    # A task has one small result, and is never moved to another worker.
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.scheduler.work-stealing": False,
    # The pages name the tasks, and so the hidden seeds of a championship, to any local user.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}
# The small arrays of a drive gain nothing from threads of NumPy, which compete for the cores.
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def cores() -> int:
    """Return the number of cores for drives."""
    # Not all systems can bind a process to some of the cores.
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1


class ClusterError(RuntimeError):
    """A cluster that cannot run the tasks; the message is one line with the fix."""


class Outcome(NamedTuple):
    """The end of a task."""

    key: str  # key of the task
    result: Any  # what its function returned, or None
    error: str  # why it returned nothing, or ""


class DaskEngine(contextlib.ExitStack):
    """Runs tasks, one at a time in each process of a worker.

    A lost worker's tasks run again on another worker. Nothing is stored: each outcome is yielded
    as soon as it is known.

    Args:
        scheduler: address tcp://HOST:PORT of a cluster; empty: start one on this machine
        workers: number of processes of the cluster on this machine

    Raises:
        ClusterError: Dask is not complete, or the scheduler does not answer
    """

    def __init__(self, scheduler: str, workers: int = 1):
        try:
            import cryptography  # noqa: F401  Dask makes certificates with it
            import dask
            import distributed
        except ImportError as error:
            raise ClusterError(f"{error}; {how_to_install('cluster')}") from None
        super().__init__()
        dask.config.set({"distributed.comm.timeouts.connect": _CONNECT_TIMEOUT_S})
        if not scheduler:
            dask.config.set(_OWN_CLUSTER)
            # Ctrl-C is for this process. Its workers inherit the mask of the threads that start
            # them, also those that replace a lost worker.
            resource_tracker.ensure_running()  # its start would end the block
            mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
            try:
                scheduler = self.enter_context(_local_cluster(distributed, workers))
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        try:
            self._client = self.enter_context(
                distributed.Client(scheduler, timeout=_CONNECT_TIMEOUT_S)
            )
        except (OSError, TimeoutError, ValueError) as error:
            self.close()
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise ClusterError(
                f"no Dask scheduler at {scheduler} ({reason}); start one with 'dask scheduler' "
                "or correct --scheduler tcp://HOST:PORT"
            ) from None

    @property
    def workers(self) -> dict[str, Mapping]:
        """Return what the scheduler knows about each worker, by its address."""
        return dict(self._client.scheduler_info()["workers"])

    def check(self, function: Callable[..., str], *arguments: object) -> None:
        """Call a function on each worker; it returns "" or why the worker cannot run the tasks.

        Raises:
            ClusterError: a worker, or the scheduler, cannot run the tasks
        """
        module = function.__module__
        try:  # the scheduler of newer versions of Dask loads the functions, too
            self._client.run_on_scheduler(importlib.import_module, module)
        except Exception as error:  # noqa: BLE001  it is the scheduler's, of any type
            raise ClusterError(f"the scheduler: {_cannot_load(module, error)}") from None
        for address in self.workers:
            try:
                problem = self._client.run(function, *arguments, workers=[address])[address]
            except Exception as error:  # noqa: BLE001  it is the worker's, of any type
                problem = _cannot_load(module, error)
            if problem:
                raise ClusterError(f"worker {address}: {problem}")

    def outcomes(self, function: Callable, tasks: Iterable[tuple[str, tuple]]) -> Iterator[Outcome]:
        """Run a function for each task and yield the outcomes in the order of their ends.

        Args:
            function: a function of a module that the workers can import
            tasks: key and arguments of each task

        Raises:
            ClusterError: the connection to the scheduler is lost
        """
        import distributed

        # Other clients of the same scheduler may have tasks with the same keys.
        prefix = uuid.uuid4().hex
        left = iter(tasks)
        results: dict[str, Any] = {}

        def receive(event: tuple[float, tuple[str, bytes]]) -> None:
            key, result = event[1]
            results[key] = pickle.loads(result)

        # An event comes by itself, before the news that its task has ended. To fetch the result of
        # a task takes a third of all the time that Dask needs for it.
        self._client.subscribe_topic(prefix, receive)

        def submit(key: str, arguments: tuple) -> Any:
            return self._client.submit(
                _run, prefix, key, function, *arguments, key=f"{prefix}/{key}", pure=False
            )

        window = max(_WAITING_TASKS, 4 * len(self.workers))
        waiting = distributed.as_completed(
            [submit(*task) for task in itertools.islice(left, window)], loop=self._client.loop
        )
        for future in waiting:
            key = future.key.partition("/")[2]
            yield self._outcome(future, key, results)
            for task in itertools.islice(left, 1):
                waiting.add(submit(*task))

    @staticmethod
    def _outcome(future: Any, key: str, results: dict[str, Any]) -> Outcome:
        # A finished future may be lost by now, with its worker: its result is here all the same.
        if key in results:
            return Outcome(key, results.pop(key), "")
        if future.status == "error":
            return Outcome(key, None, _reason(future.exception()))
        raise ClusterError(
            "the connection to the Dask scheduler is lost; start the same command again: it "
            "continues where it stopped"
        )


def _cannot_load(module: str, error: Exception) -> str:
    return (
        f"it cannot load {module} ({error}); start it as the section 'A cluster' of "
        "docs/sweeps.md shows"
    )


def _run(topic: str, key: str, function: Callable, *arguments: object) -> None:
    """Run a function in a worker, and send its result as an event of a topic."""
    import distributed

    result = function(*arguments)
    distributed.get_worker().log_event(topic, (key, pickle.dumps(result)))


def _reason(error: BaseException) -> str:
    if type(error).__name__ == "KilledWorker":
        return "the workers that ran it ended one after the other: out of memory, or a crash"
    return f"{type(error).__name__}: {error}"


@contextlib.contextmanager
def _local_cluster(distributed: Any, workers: int) -> Iterator[Any]:
    """Start a scheduler in this process, and processes with one thread each."""
    warnings.filterwarnings("ignore", "Creating scratch directories")  # a busy machine is no error
    with tempfile.TemporaryDirectory(prefix="sweep_") as folder:
        try:
            cluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                memory_limit="auto",  # the machine's memory, divided by its cores
                env=_ONE_THREAD,
                dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": False},
                worker_dashboard_address="127.0.0.1:0",
                host="127.0.0.1",
                # Who connects without the certificate of this cluster would run code as its user.
                security=True,
                local_directory=folder,
                # What fails is named by this class. Dask finds it critical when a client is gone.
                silence_logs=logging.CRITICAL + 1,
            )
        except BaseException:
            # At exit, Dask fails to close a cluster that was interrupted during its start.
            atexit.unregister(distributed.deploy.spec.close_clusters)
            raise
        with cluster:
            yield cluster
