"""The node processes: start them, notice one that ends, stop them, leave nothing behind."""

import ctypes
import fcntl
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from wholearm_ros.errors import WholeArmError

PR_SET_PDEATHSIG = 1
STOP_WITHIN = 3.0  # [s] between SIGINT and SIGKILL
KILLED = f'did not end within {STOP_WITHIN:.0f} s of SIGINT and was killed'
SHARED_MEMORY = Path('/dev/shm')


class NodeDied(WholeArmError):
    """A node process ended by itself."""


class DomainTaken(WholeArmError):
    """Another launcher runs its graph in this ROS domain."""


@contextmanager
def alone_in_domain() -> Iterator[None]:
    """No second launcher on this machine may start nodes of the same names.

    Two hands would answer every setpoint.

    The name of an abstract socket is taken: it goes with the process, however that ends. Raises
    DomainTaken.
    """
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    with socket.socket(socket.AF_UNIX) as name:
        try:
            name.bind(f'\0wholearm_ros/domain/{domain}')
        except OSError as error:
            raise DomainTaken(
                f'ROS_DOMAIN_ID: got {domain}, in which another `wholearm run` is under way; '
                'allowed: a domain of its own, 0 to 101'
            ) from error
        yield


class Processes:
    """A context: what was started inside has ended after it, and its shared memory is gone."""

    def __init__(self, log_directory: Path) -> None:
        self._logs = log_directory
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._shared_before = _shared_memory()

    def __enter__(self) -> 'Processes':
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def start(
        self,
        node: str,
        parameters: dict[str, Any],
        namespace: str = '',
        params: Path | None = None,
    ) -> None:
        """The program of `node` with `parameters`, which override those of the file `params`; its
        output in a file of its own.
        """
        command = [*self.program(node), '--ros-args']
        if params is not None:
            command += ['--params-file', str(params)]
        if namespace:
            command += ['-r', f'__ns:={namespace}']
        for name, value in parameters.items():
            command += ['-p', f'{name}:={_text(value)}']
        with open(self.log_of(node), 'wb') as log:
            # A session of its own: Ctrl-C reaches the launcher only, which then stops the nodes in
            # order.
            self._running[node] = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
                preexec_fn=die_with_parent,
            )

    def program(self, node: str) -> list[str]:
        """The command that runs `node`, without arguments."""
        return [sys.executable, '-m', f'wholearm_ros.nodes.{node}']

    def log_of(self, node: str) -> Path:
        """The file of the output of `node`."""
        return self._logs / f'{node}.log'

    def pid(self, node: str) -> int:
        """Of a node that was started."""
        return int(self._running[node].pid)

    def check(self) -> None:
        """Raises NodeDied when a process ended."""
        for node, process in self._running.items():
            code = process.poll()
            if code is not None:
                how = (
                    f'was killed by {signal.Signals(-code).name}'
                    if code < 0
                    else f'ended with exit code {code}'
                )
                lines = self.log_of(node).read_text(errors='replace').strip().splitlines()[-5:]
                raise NodeDied(
                    '\n'.join([f'{node} {how}; its last words:', *(f'  {line}' for line in lines)])
                )

    def stop(self) -> None:
        """SIGINT, and SIGKILL to those that stay; the recorder last, to record the others' end."""
        last = {n: p for n, p in self._running.items() if n == 'bag_recorder'}
        _stop({n: p for n, p in self._running.items() if n not in last})
        _stop(last)
        self._running = {}
        for path in _shared_memory() - self._shared_before:
            _remove_if_unused(path)


def _stop(processes: dict[str, subprocess.Popen[bytes]]) -> None:
    for process in processes.values():
        if process.poll() is None:
            process.send_signal(signal.SIGCONT)  # one that was stopped would not hear the next
            process.send_signal(signal.SIGINT)
    deadline = time.monotonic() + STOP_WITHIN
    for node, process in processes.items():
        try:
            process.wait(max(0.0, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            print(f'{node} {KILLED}', file=sys.stderr, flush=True)
            process.kill()
            process.wait()


def die_with_parent() -> None:
    """In a child before its program: SIGINT when whoever started it ends, however that may be."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGINT)


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return '[' + ', '.join(map(_text, value)) + ']'
    # A YAML string in double quotes, of whatever text: a scenario's JSON as well as a path.
    return json.dumps(value) if isinstance(value, str) else str(value)


def _shared_memory() -> set[Path]:
    return {
        p
        for pattern in ('fastrtps_*', 'sem.fastrtps_*', 'fastdds_*')
        for p in SHARED_MEMORY.glob(pattern)
    }


def _remove_if_unused(path: Path) -> None:
    """Fast DDS locks NAME_el as long as somebody uses NAME; a killed process leaves both."""
    lock = path if path.name.endswith('_el') else path.with_name(path.name + '_el')
    if path.name.startswith('sem.'):
        lock = path.with_name(path.name[len('sem.') :].replace('_mutex', '') + '_el')
    try:
        with open(lock, 'rb') as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink(missing_ok=True)
    except FileNotFoundError:
        if not _mapped(path):
            path.unlink(missing_ok=True)
    except BlockingIOError:
        pass  # somebody else's


def _mapped(path: Path) -> bool:
    """Whether a live process other than this one has `path` mapped; this one only sent to it."""
    for process in Path('/proc').glob('[0-9]*'):
        if process.name == str(os.getpid()):
            continue
        try:
            if str(path) in (process / 'maps').read_text():
                return True
        except OSError:
            continue  # it ended meanwhile, or is not ours
    return False
