"""The suite: many tasks planned and executed on a simulated hand, without ROS, by the same code as
the nodes.
"""

from collections.abc import Callable, Iterable
from functools import partial

from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.suite_options import SuiteOptions
from wholearm_ros.suite.task_result import Result, failed, run_task
from wholearm_ros.suite.workers import work_on


def run_suite(
    tasks: Iterable[SuiteEntry],
    options: SuiteOptions,
    jobs: int = 1,
    on_result: Callable[[Result], None] | None = None,
    scheduler: str | None = None,
) -> list[Result]:
    """One result a task, in the tasks' order; `on_result` is called with each as soon as it is
    there.

    jobs: processes of this machine; scheduler: address of a Dask scheduler whose workers are used
    instead. An error in a task is that task's result; it does not stop the others. Raises
    WholeArmError when the scheduler does not answer.
    """
    tasks = list(tasks)
    results: dict[int, Result] = {}
    work = partial(run_task, options=options)
    for k, result in work_on(tasks, work, _lost, jobs, scheduler):
        results[k] = result
        if on_result:
            on_result(result)
    return [results[k] for k in range(len(tasks))]


def _lost(task: SuiteEntry, why: str) -> Result:
    return failed(task.name, why)
