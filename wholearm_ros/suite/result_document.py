"""The document `wholearm-suite-result/1`: the results of a suite, each with its scenario."""

from collections.abc import Sequence
from typing import Any

from wholearm_ros.suite.suite_file import SuiteEntry
from wholearm_ros.suite.suite_options import SuiteOptions

RESULT_FORMAT = 'wholearm-suite-result/1'


def suite_document(
    file: str,
    tasks: Sequence[SuiteEntry],
    options: SuiteOptions,
    results: list[dict[str, Any]],
    summary: dict[str, Any],
) -> dict[str, Any]:
    """file: name of the suite's file, shown in the report; the rest as `run_suite` and `summarize`
    give it.
    """
    return {
        'format': RESULT_FORMAT,
        'suite': file,
        'seed': options.seed,
        'perturb': options.perturb,
        'hand_errors': options.hand_errors,
        'draws': options.draws,
        'search': options.request.search,
        'transition': options.request.transition,
        'time_budget': options.request.time_budget,
        'min_success': options.request.min_success,
        'backend': options.backend,
        'rate': options.loop.rate,
        'summary': summary,
        'tasks': [{**r, 'scenario': task.scenario} for task, r in zip(tasks, results)],
    }
