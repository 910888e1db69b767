"""Compilation of every kernel, so that no service call pays for it:
`python -m wholearm_ros.planner.warm`.
"""

import sys
import time


def warm() -> float:
    """Plan, generate and simulate a small scenario; returns the seconds it took, few when the
    compiled code is on disk.
    """
    from wholearm_ros.model.scenario_file import parse_scenario
    from wholearm_ros.planner.planner import plan_and_verify
    from wholearm_ros.planner.request import PlanRequest
    from wholearm_ros.planning.routes import BEST, RANDOM

    began = time.monotonic()
    finger = {
        'length': 0.15,
        'half_width': 0.006,
        'mass': 0.16,
        'rotor_inertia': 0.005,
        'angle_limits': [0.05, 3.09],
        'torque_limit': 7.0,
    }
    square = {
        'object': {'vertices': [[0.0, 0.0], [0.07, 0.0], [0.08, 0.06], [0.01, 0.07]], 'mass': 0.3},
        'hand': {
            'left': {'axis': [-0.1, -0.02], **finger},
            'right': {'axis': [0.1, -0.02], **finger},
        },
        'palm': {'vertices': [[-0.15, 0.0], [0.15, 0.0]]},
        'gravity': {'acceleration': 9.81, 'tilt_deg': 15.0},
        'start': {'edge': 0, 'x': 0.0},
        'goal': {'edge': 3, 'direction': 'ccw'},
    }
    for search, moves in ((RANDOM, 0), (BEST, 1)):
        plan_and_verify(
            parse_scenario(square),
            PlanRequest(
                search=search,
                samples=1,
                candidates=2,
                moves=moves,
                certificate_samples=1,
                min_success=0.0,
            ),
        )
    return time.monotonic() - began


if __name__ == '__main__':
    print('compiling kernels (once, about a minute on two cores) ...', file=sys.stderr, flush=True)
    print(f'kernels ready after {warm():.0f} s', file=sys.stderr)
