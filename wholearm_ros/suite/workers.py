"""Where the tasks of a suite, or of a map, are worked on: here, in processes of
this machine, or on Dask.

Each way yields (place of the task, result) as results come, every place once.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures import as_completed as as_pool_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from multiprocessing import get_context
from typing import Any, TypeVar

from wholearm_ros.errors import WholeArmError
from wholearm_ros.planner.warm import warm

ANSWER_WITHIN = 10.0  # [s] of a scheduler that is asked for the first time
WORKER_WITHIN = 60.0  # [s] for the first worker to come
Task = TypeVar('Task')
Result = TypeVar('Result')


def work_on(
    tasks: Sequence[Task],
    work: Callable[[Task], Result],
    failed: Callable[[Task, str], Result],
    jobs: int = 1,
    scheduler: str | None = None,
) -> Iterator[tuple[int, Result]]:
    """`work(task)` → result for every task; `failed(task, why)` → result of one whose workers died.

    scheduler: address of a Dask scheduler, whose workers are used instead of `jobs` processes.
    Raises WholeArmError when it does not answer, or has no worker.
    """
    if scheduler is None and jobs == 1:
        return _here(tasks, work)
    if scheduler is None and not _has_dask():
        return _in_processes(tasks, work, failed, jobs)
    return _on_cluster(tasks, work, failed, jobs, scheduler)


def _here(tasks: Sequence[Task], work: Callable[[Task], Result]) -> Iterator[tuple[int, Result]]:
    _warm_once()
    for k, task in enumerate(tasks):
        yield k, work(task)


def _in_processes(
    tasks: Sequence[Task],
    work: Callable[[Task], Result],
    failed: Callable[[Task, str], Result],
    jobs: int,
) -> Iterator[tuple[int, Result]]:
    """Without Dask. A worker that dies takes every open task of the pool with it; they become
    errors.
    """
    with ProcessPoolExecutor(jobs, mp_context=get_context('spawn'), initializer=_warm_once) as pool:
        places = {pool.submit(work, task): k for k, task in enumerate(tasks)}
        for future in as_pool_completed(places):
            k = places[future]
            try:
                yield k, future.result()
            except BrokenProcessPool as error:
                yield k, failed(tasks[k], f'a worker process died: {error}')


def _on_cluster(
    tasks: Sequence[Task],
    work: Callable[[Task], Result],
    failed: Callable[[Task, str], Result],
    jobs: int,
    scheduler: str | None,
) -> Iterator[tuple[int, Result]]:
    """On Dask: a dead worker's tasks go to another one, also those done whose results were not
    handed over.
    """
    dask = _dask()
    with _client(dask, jobs, scheduler) as client:
        # A key a task: the same suite sent twice is worked on twice; pure, tasks that look alike
        # would become one.
        futures = client.map(_work_warm, tasks, work=work, pure=False, batch_size=1)
        places = {future.key: k for k, future in enumerate(futures)}
        for future in dask.as_completed(futures):
            k = places[future.key]
            try:
                # This waits when the worker has died since and the task is worked on again.
                yield k, future.result()
            except (dask.KilledWorker, dask.CancelledError) as error:
                yield k, failed(tasks[k], f'lost on the cluster: {error}')
            future.release()


def _dask() -> Any:
    """The module `distributed`; it takes a second to import, and is an extra."""
    try:
        import distributed
    except ImportError as error:
        raise WholeArmError(
            f'--scheduler: {error}; allowed: with Dask, pip install "wholearm_ros[cluster]"'
        ) from error
    return distributed


@contextmanager
def _client(dask: Any, jobs: int, scheduler: str | None) -> Iterator[Any]:
    """A client of the scheduler, or of an embedded cluster of `jobs` processes."""
    if scheduler is None:
        local = dask.LocalCluster(
            jobs, threads_per_worker=1, host='127.0.0.1', dashboard_address='127.0.0.1:0'
        )
        with local as cluster, dask.Client(cluster) as client:
            yield client
        return
    try:
        client = dask.Client(scheduler, timeout=ANSWER_WITHIN)
        client.wait_for_workers(1, timeout=WORKER_WITHIN)
    except (OSError, ValueError) as error:
        raise WholeArmError(
            f'--scheduler {scheduler}: {error or "no answer"}; allowed: the address that '
            '`dask scheduler` prints, with at least one `dask worker`'
        ) from error
    with client:
        yield client


def _work_warm(task: Task, work: Callable[[Task], Result]) -> Result:
    _warm_once()
    return work(task)


@cache
def _warm_once() -> float:
    """Load the compiled code once a process, so that no task's times hold that."""
    return warm()


def _has_dask() -> bool:
    return find_spec('distributed') is not None
