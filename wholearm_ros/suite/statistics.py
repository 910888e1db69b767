"""Counts and times over the results of a suite."""

from typing import Any

import numpy as np

from wholearm_ros.model.outcomes import AT_GOAL, LOST, PROBED, UNKNOWN
from wholearm_ros.suite.jury_summary import jury_summary

TIMES = ('plan_ms', 'generate_ms', 'verify_ms')


def summarize(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Summary of results. sound: successful runs / runs of planned tasks, None when nothing was
    planned; of a sequence every face is a run; jury: `jury_summary`.
    """
    planned = [r for r in results if r['planned']]
    runs = [run for r in planned for draw in r['draws'] for run in draw.get('reached', [draw])]
    done = sum(draw['executed'] for draw in runs)
    return {
        'tasks': len(results),
        'planned': len(planned),
        'executed': sum(r['executed'] for r in results),
        'errors': sum('error' in r for r in results),
        'runs': len(runs),
        'executed_runs': done,
        'sound': done / len(runs) if runs else None,
        'jury': jury_summary(results),
        **_claims(runs),
        **{name: _spread([r[name] for r in results if r[name] is not None]) for name in TIMES},
    }


def _claims(draws: list[dict[str, Any]]) -> dict[str, int]:
    """What was claimed against what is. Runs that were not felt count nowhere."""
    felt = [d for d in draws if d.get('claimed') in PROBED]
    return {
        'felt_runs': len(felt),
        'false_success': sum(d['claimed'] == AT_GOAL and not d['executed'] for d in felt),
        'false_failure': sum(d['claimed'] != AT_GOAL and d['executed'] for d in felt),
        'lost': sum(d['claimed'] == LOST for d in felt),
        'unknown': sum(d['claimed'] == UNKNOWN for d in felt),
    }


def _spread(values: list[float]) -> dict[str, float] | None:
    """Median and 95th percentile; None of no values."""
    if not values:
        return None
    return {'median': float(np.median(values)), 'p95': float(np.percentile(values, 95))}
