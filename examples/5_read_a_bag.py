"""Read the last run in a bag, without ROS: python examples/5_read_a_bag.py BAG [REPORT.html]."""

import sys
from pathlib import Path

import wholearm_ros as wa

bag = Path(sys.argv[1])
plan, trajectory, run = wa.read_bag(bag)
print(plan.summary())
print(
    f'{len(run.times)} joint states, {run.times[-1] - run.times[0]:.2f} s; {trajectory.duration=:.2f}'
)
if run.judged is not None:
    print('at the goal' if run.judged.executed else f'not at the goal: {run.judged.reason}')
if len(sys.argv) > 2:
    print(wa.write_report([bag], Path(sys.argv[2])))
