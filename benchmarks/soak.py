"""Many runs of `wholearm run` in lockstep, one after the other: no failure, the same pose each time, nothing left behind.

    python benchmarks/soak.py [--runs 3] [--rate 1000] [--scenario asymmetric_hexagon] [--log soak.jsonl]

With --log each run is a line of JSON, and what is already there counts: a long campaign can be done in pieces.
"""

import argparse
import ctypes
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from wholearm_ros.launcher.processes import SHARED_MEMORY

PR_SET_CHILD_SUBREAPER = 36
LONGEST = 600.0  # [s] of one run; beyond it has failed
POSE = re.compile(r'^final pose +(.*?);', re.M)


def left_behind() -> dict:
    """What a run may leave: processes that are now ours, shared memory, directories of logs."""
    children = [
        pid
        for task in Path('/proc/self/task').iterdir()
        for pid in (task / 'children').read_text().split()
    ]
    return {
        'processes': set(children),
        'shared memory': {p.name for p in SHARED_MEMORY.glob('*fast*')},
        'directories': {p.name for p in Path(tempfile.gettempdir()).glob('wholearm_*')},
    }


def memory_available() -> float:
    """[MB] of the machine."""
    return int(re.search(r'MemAvailable: +(\d+)', Path('/proc/meminfo').read_text())[1]) / 1024


def one_run(scenario: str, rate: float) -> dict:
    before, began = left_behind(), time.monotonic()
    try:
        done = subprocess.run(
            [
                sys.executable,
                '-m',
                'wholearm_ros',
                'run',
                scenario,
                '--pacing',
                'lockstep',
                '--rate',
                str(rate),
            ],
            capture_output=True,
            text=True,
            timeout=LONGEST,
        )
        code, told = done.returncode, done.stdout + done.stderr
    except subprocess.TimeoutExpired as error:
        code, told = None, str(error)
    pose = POSE.search(told)
    return {
        'code': code,
        'seconds': round(time.monotonic() - began, 1),
        'pose': pose[1] if pose else told[-2000:],
        'peak MB': resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024,
        'available MB': round(memory_available()),
        'left': {kind: sorted(now - before[kind]) for kind, now in left_behind().items()},
    }


def show(runs: list) -> bool:
    """Whether all went well."""
    failed = [r for r in runs if r['code'] != 0]
    poses, left = (
        {r['pose'] for r in runs},
        {kind: sum(len(r['left'][kind]) for r in runs) for kind in runs[0]['left']},
    )
    seconds = sorted(r['seconds'] for r in runs)
    print(
        f'{len(runs)} runs, {len(failed)} failed, {len(poses)} different final poses, {seconds[0]:.0f} to {seconds[-1]:.0f} s '
        f'(median {seconds[len(seconds) // 2]:.0f} s)'
    )
    print('left behind: ' + ', '.join(f'{kind} {count}' for kind, count in left.items()))
    print(
        f'largest process {runs[0]["peak MB"]} MB in the first run, {runs[-1]["peak MB"]} MB up to the last; '
        f'free memory of the machine {runs[0]["available MB"]} MB after the first, {runs[-1]["available MB"]} MB after the last'
    )
    for r in failed:
        print(f'  exit code {r["code"]}: {r["pose"]}')
    return not failed and len(poses) == 1 and not any(left.values())


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--rate', type=float, default=1000.0)
    parser.add_argument('--scenario', default='asymmetric_hexagon')
    parser.add_argument('--log', type=Path)
    options = parser.parse_args()
    ctypes.CDLL(None).prctl(
        PR_SET_CHILD_SUBREAPER, 1
    )  # what outlives its launcher becomes a child of ours, and is seen
    runs = (
        [json.loads(line) for line in options.log.read_text().splitlines()]
        if options.log and options.log.exists()
        else []
    )
    for _ in range(options.runs):
        runs.append(one_run(options.scenario, options.rate))
        if options.log:
            with options.log.open('a') as log:
                log.write(json.dumps(runs[-1]) + '\n')
    sys.exit(0 if show(runs) else 1)


if __name__ == '__main__':
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    main()
