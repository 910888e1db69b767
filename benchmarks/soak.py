"""Many runs of `wholearm run` in lockstep, one after the other: no failure, the same pose each time, nothing left behind.

    python benchmarks/soak.py [--runs 3] [--rate 1000] [--scenario asymmetric_hexagon] [--log soak.jsonl]
    python benchmarks/soak.py --idle MINUTES [--runs 3] [--pacing lockstep]

With --log each run is a line of JSON, and what is already there counts: a long campaign can be done in pieces.
With --idle one graph stays up: for each run it is left alone for so long, then the hand is reset and the goal pursued. At the end
its nodes get SIGTERM.
"""

import argparse
import ctypes
import json
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))
from ros_graph import WAIT, WHOLE, Graph

from wholearm_ros.launcher.processes import SHARED_MEMORY, STOP_WITHIN
from wholearm_ros.ros.interface import channels

PR_SET_CHILD_SUBREAPER = 36
LONGEST = 600.0  # [s] of one run; beyond it has failed
WARNED = re.compile(r'\[(WARN|ERROR|FATAL)\]')
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


def idle(pacing: str, minutes: float, runs: int) -> bool:
    """Whether a graph that was left alone still reaches its goal each time, warned of nothing, and ended in time after SIGTERM."""
    with tempfile.TemporaryDirectory() as scratch, closing(Graph(Path(scratch))) as graph:
        graph.start(WHOLE, pacing)
        modes, good = graph.listen(channels.MODE), 0
        graph.wait(lambda: modes, 'the mode switcher')
        for number in range(runs):
            graph.spin(60.0 * minutes)
            assert graph.client.call(channels.RESET, WAIT).success
            result = graph.execute(graph.plan().id)
            good += result['outcome'] == 'succeeded'
            print(
                f'{minutes * (number + 1):g} min: {result["outcome"]}: {result["reason"]}',
                flush=True,
            )
        pids, began = [graph.processes.pid(node) for node in WHOLE], time.monotonic()
        for pid in pids:
            os.kill(pid, signal.SIGTERM)
        ended = [os.waitpid(pid, 0)[1] for pid in pids]
        took = time.monotonic() - began
        said = {node: graph.processes.log_of(node).read_text(errors='replace') for node in WHOLE}
        warned = [
            f'{n}: {line}'
            for n, text in said.items()
            for line in text.splitlines()
            if WARNED.search(line)
        ]
    print(
        f'{good} of {runs} reached; ended {took:.1f} s after SIGTERM, status {set(ended)}; {len(warned)} warnings'
    )
    print(*warned[:20], sep='\n')
    return good == runs and took < STOP_WITHIN and not warned


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
    parser.add_argument(
        '--idle', type=float, metavar='MINUTES', help='one graph, left alone before each run'
    )
    parser.add_argument('--pacing', default='lockstep', choices=['lockstep', 'realtime'])
    options = parser.parse_args()
    if options.idle is not None:
        sys.exit(0 if idle(options.pacing, options.idle, options.runs) else 1)
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
