"""How often the engines of the jury agree over a suite, and each disagreement in words."""

from itertools import combinations
from typing import Any


def jury_summary(results: list[dict[str, Any]]) -> dict[str, Any] | None:
    """Counts over every run of results of `--backend jury`; None of other results.

    runs; executed: {engine: runs that reached the goal}; agreement: [{engines: [a, b], runs}] for
    each pair; disagreements: [{task, draw, text}].
    """
    runs = [
        (result['name'], draw, told['jury'])
        for result in results
        for draw, told in enumerate(result['draws'])
        if 'jury' in told
    ]
    if not runs:
        return None
    reached = [
        {engine: told['executed'] for engine, told in jury['engines'].items()}
        for _, _, jury in runs
    ]
    return {
        'runs': len(runs),
        'executed': {engine: sum(r[engine] for r in reached) for engine in reached[0]},
        'agreement': [
            {'engines': [a, b], 'runs': sum(r[a] == r[b] for r in reached)}
            for a, b in combinations(reached[0], 2)
        ],
        'disagreements': [
            {'task': name, 'draw': draw, 'text': found['text']}
            for name, draw, jury in runs
            for found in jury['disagreements']
        ],
    }


def jury_lines(summary: dict[str, Any]) -> list[str]:
    """`jury_summary` in words, for people."""
    runs = summary['runs']
    goal = ', '.join(f'{engine} {n} of {runs}' for engine, n in summary['executed'].items())
    pairs = ', '.join(
        f'{" and ".join(pair["engines"])} {pair["runs"]} of {runs}' for pair in summary['agreement']
    )
    return [f'at the goal: {goal}', f'in agreement: {pairs}'] + [
        f'{d["task"]}, draw {d["draw"]}: {d["text"]}' for d in summary['disagreements']
    ]
