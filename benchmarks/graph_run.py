"""What benchmarks of whole runs on the graph share: a run whose diagnostics are heard, and each run in a process of its own."""

import json
import subprocess
import sys
import time

from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.launcher import RunOptions, RunReport, run_graph
from wholearm_ros.model.scenario_file import load_scenario
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.messages import values_of

RUN_WITHIN = 600.0  # [s]


def heard_run(options: RunOptions) -> tuple[RunReport | str, dict[str, list[tuple[float, dict]]]]:
    """(the report, or why there is none; by node, what it said on /diagnostics and when [s])."""
    said: dict[str, list[tuple[float, dict]]] = {}

    def hear(message):
        for status in message.status:
            node = status.name.rsplit('/', 1)[-1]
            said.setdefault(node, []).append((time.monotonic(), values_of(status)))

    def on_client_ready(client):
        topic = channels.DIAGNOSTICS
        client.node.create_subscription(topic.type, topic.name, hear, topic.qos)

    try:
        scenario = load_scenario(options.scenario)
        return run_graph(scenario, options, lambda *_: None, on_client_ready=on_client_ready), said
    except WholeArmError as error:
        return str(error), said


def in_a_process(file: str, *words: str) -> dict | str:
    """The last line of JSON that `file` prints with these arguments; the end of its errors where it fails."""
    command = [sys.executable, file, *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=RUN_WITHIN)
    return done.stderr[-300:] if done.returncode else json.loads(done.stdout.splitlines()[-1])
