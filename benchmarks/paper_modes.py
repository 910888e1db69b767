"""The modes of a run on the ROS graph, beside the paper's (IV): both hexagons with dynamic transitions, one run each.

python benchmarks/paper_modes.py [--pacing lockstep]
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from wholearm_ros.model.modes import CAGING, DYNAMIC
from wholearm_ros.report.bag_run import read_bag
from wholearm_ros.report.figures.mode_spans import executed_spans

PAPER = {
    DYNAMIC: '0.51-0.65',
    CAGING: '1.23-2.27',
}  # [s] of the asymmetric hexagon, a run of 2.27 s


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--pacing', default='lockstep')
    options = parser.parse_args()
    for scenario in ('asymmetric_hexagon', 'regular_hexagon'):
        with tempfile.TemporaryDirectory() as folder:
            bag = Path(folder) / 'bag'
            done = subprocess.run(
                [
                    sys.executable,
                    '-m',
                    'wholearm_ros',
                    'run',
                    scenario,
                    '--transition',
                    'dynamic',
                    '--pacing',
                    options.pacing,
                    '--record',
                    str(bag),
                ],
                stdout=subprocess.PIPE,
                text=True,
            )
            print(f'{scenario}: exit {done.returncode}')
            if done.returncode:
                print(done.stdout)
                continue
            _, _, run = read_bag(bag)
        for start, end, mode in executed_spans(run):
            paper = (
                f'   the paper: {PAPER[mode]} s'
                if scenario.startswith('asym') and mode in PAPER
                else ''
            )
            print(f'  {start:5.2f}-{end:.2f} s  {mode}{paper}')


if __name__ == '__main__':
    main()
