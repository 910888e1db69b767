"""Makes the reference bags again: one lockstep run of each shipped scenario, and the README that says how. `make bags`."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from wholearm_ros.launcher.launcher import RunOptions, run_graph
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.ros.interface import channels

HERE = Path(__file__).resolve().parent
SCENARIOS = ('asymmetric_hexagon', 'regular_hexagon')
SEED, RATE = 0, 250.0  # [Hz]: a quarter of the default keeps a bag small
LIMIT = 2 * 2**20  # bytes
TOPICS = tuple(
    t.name for t in channels.RECORDED if t not in (channels.MARKERS, channels.DIAGNOSTICS)
)

README = """# Reference bags

One run of each shipped scenario on the ROS graph, in lockstep on the PyBullet hand: every topic of the run but
`markers` and `/diagnostics`.
`test/ros/test_replay.py` plays them into live nodes and asks for the same answers.

Made by `make bags` ({command}), seed {seed}, motor rate {rate:.0f} Hz, at commit {commit}.
Make them again when planning, trajectory generation or control has changed on purpose, and commit them with that change.

| bag | bytes | messages | plan | final pose of the object [m, m, rad] |
|---|---|---|---|---|
{rows}

Replay one: `ros2 run wholearm_ros bag_player --ros-args -p path:=bags/asymmetric_hexagon` (rate, start, topics, clock: see
`docs/ros.md`), or with rosbag2's own `ros2 bag play bags/asymmetric_hexagon`.
"""


def make(name: str) -> str:
    """Records the bag of one scenario; its row of the table."""
    from rosbags.highlevel import AnyReader

    path, scenario = HERE / name, HERE.parent / 'config' / f'{name}.yaml'
    shutil.rmtree(path, ignore_errors=True)
    report = run_graph(
        load_scenario(scenario),
        RunOptions(name, 'lockstep', seed=SEED, record=path, topics=TOPICS, rate=RATE),
        lambda *_: None,
    )
    print(f'{name}: {report.message}', flush=True)
    if not report.success:
        sys.exit(f'{name}: not at its goal: {report.message} {report.judged}')
    size = sum(f.stat().st_size for f in path.iterdir())
    if size > LIMIT:
        sys.exit(f'{name}: the bag has {size} bytes; allowed: {LIMIT}')
    with AnyReader([path]) as reader:
        messages = reader.message_count
    pose = ', '.join(f'{float(v):.12f}' for v in report.judged.pose)
    return f'| `{name}` | {size} | {messages} | {report.planner["plan id"]} | {pose} |'


def main():
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    commit = subprocess.run(
        ['git', 'rev-parse', '--short', 'HEAD'], cwd=HERE, capture_output=True, text=True
    ).stdout.strip()
    rows = '\n'.join(make(name) for name in SCENARIOS)
    (HERE / 'README.md').write_text(
        README.format(
            command='`python bags/make_bags.py`',
            seed=SEED,
            rate=RATE,
            commit=commit or 'unknown',
            rows=rows,
        )
    )


if __name__ == '__main__':
    main()
