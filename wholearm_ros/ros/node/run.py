"""A node as a process of its own, from the first line to the exit code; signals end it in time."""

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import NoReturn, Optional

import rclpy
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from wholearm_ros.errors import WholeArmError
from wholearm_ros.ros.interface.transport import choose_transport
from wholearm_ros.ros.node.node import LEAVE_WITHIN, WholeArmNode

SIGNALS = (signal.SIGINT, signal.SIGTERM)
SIGNAL_PERIOD = 0.05  # [s] between two looks at whether a signal came
GONE_WITHIN = 1.5  # [s] for the middleware to take the node apart, then the kernel ends the process


class Ending:
    """Notices SIGINT and SIGTERM whatever the main thread is doing, and ends the process in time.

    rclpy's handlers would shut the middleware down at once; here the node still publishes on its
    way out. Python runs handlers only between two lines of the main thread, which may be compiling
    or deep in the middleware, so a thread waits for what the interpreter writes into a pipe when a
    signal arrives.
    """

    def __init__(self) -> None:
        self.within = LEAVE_WITHIN  # [s] from the signal to the end of the process
        self.signalled = threading.Event()
        self._read, write = os.pipe()
        os.set_blocking(write, False)
        for number in SIGNALS:
            signal.signal(number, lambda *_: None)
        signal.set_wakeup_fd(write, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while not set(os.read(self._read, 1)) & set(SIGNALS):
            pass
        self.signalled.set()
        time.sleep(self.within)
        os._exit(0)  # nothing is flushed: whoever writes holds the lock


def end_process(code: int) -> NoReturn:
    """At once: the interpreter's own exit waits for threads and takes compiled code apart, which on
    a busy machine takes seconds.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _end_within(seconds: float) -> None:
    """By the kernel: the middleware was seen to wait for ever and keep the interpreter's lock, with
    which no thread of ours can end the process.
    """
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, seconds)


def run_node(
    make_node: Callable[[], WholeArmNode],
    args: Optional[list[str]] = None,
    make_executor: Callable[[], Executor] = EventsExecutor,
) -> NoReturn:
    """Spin the node until SIGINT or SIGTERM, then end the process.

    Its exit code: 0, or 2 when the node cannot start as configured.
    """
    ending, transport = Ending(), choose_transport()
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        node = make_node()
    except WholeArmError as error:
        print(f'error: {error}', file=sys.stderr, flush=True)
        end_process(2)
    node.get_logger().info(transport)
    ending.within = node.leave_within
    executor = make_executor()
    executor.add_node(node)
    _raise_priority(node)
    gc.collect()
    gc.freeze()  # what is there stays: no collection of it holds up the loop
    _spin(executor, node, ending)
    node.leave()
    _end_within(GONE_WITHIN)
    executor.shutdown(timeout_sec=0.0)
    node.destroy_node()  # type: ignore[no-untyped-call]  # others see it go
    rclpy.try_shutdown()
    end_process(0)


def _spin(executor: Executor, node: WholeArmNode, ending: Ending) -> None:
    """spin() would not look up, and spin_once() returns after every message."""
    never: Future = Future(executor=executor)
    while not ending.signalled.is_set() and not node.finished():
        executor.spin_until_future_complete(never, timeout_sec=SIGNAL_PERIOD)


def _raise_priority(node: WholeArmNode) -> None:
    """Where the machine allows it; else the node runs as it is and says so."""
    priority = node.parameters.priority
    if not priority:
        return
    try:
        for thread in os.listdir('/proc/self/task'):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(priority))
    except OSError as error:
        node.get_logger().info(f'priority: not allowed here ({error.strerror}); running without')
