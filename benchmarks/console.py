"""What the console costs, and how soon its Stop holds: `wholearm console` as a process, pages over WebSocket, the graph in real
time, a ROS client of its own that listens to the drives.

    python benchmarks/console.py [--stops 20] [--pages 0 3] [--seconds 8] [--rate 1000] [--backend planar] [--limit 150]

Stop: time from the sending by the page, while a joint moves, to its answer, and to the hold: both joints slower than
STILL from then on; for each of both ways to stop no longer than the limit [s].
Pages: frames and bytes a second of one page, and rate and latency of the loop, while the object is turned.
"""

import argparse
import asyncio
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import AsyncExitStack, asynccontextmanager

import aiohttp
import numpy as np

from wholearm_ros.launcher.client import Client
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.joint_state_serialization import read_joints
from wholearm_ros.ros.interface.messages import values_of

STILL = 0.05  # [rad/s]
AFTER = 0.5  # [s] for which it has to stay so
WAIT = 300.0  # [s]
LOOP = ('command latency p50 ms', 'command latency p99 ms', 'late commands', 'overruns')


class Listener:
    """Speeds of the joints with the machine's time, and the hand's reports, in a thread of its own."""

    def __init__(self):
        self.client, self.speeds, self.hand, self.leaving = Client(name='benchmark'), [], [], False
        self.client.leave_truth_alone()
        node = self.client.node
        node.create_subscription(
            channels.JOINT_STATES.type,
            channels.JOINT_STATES.name,
            self.on_joints,
            channels.NO_RESENDING,
            raw=True,
        )
        node.create_subscription(
            channels.DIAGNOSTICS.type, channels.DIAGNOSTICS.name, self.on_report, 10
        )
        self.thread = threading.Thread(target=self.spin)
        self.thread.start()

    def spin(self):
        while not self.leaving:
            self.client.executor.spin_once(timeout_sec=0.05)

    def on_joints(self, data):
        self.speeds.append((time.monotonic(), max(map(abs, read_joints(data).velocity))))

    def on_report(self, message):
        for status in message.status:
            if status.name.endswith('/hand_hardware'):
                self.hand.append((time.monotonic(), values_of(status)))

    def moving(self):
        return bool(self.speeds) and self.speeds[-1][1] > STILL

    def close(self):
        self.leaving = True
        self.thread.join()
        self.client.close()


class Page:
    def __init__(self, ws):
        self.ws, self.number, self.bytes, self.frames, self.heard = ws, 0, 0, 0, {}

    async def message(self):
        text = (await asyncio.wait_for(self.ws.receive(), WAIT)).data
        message = json.loads(text)
        self.bytes, self.frames = self.bytes + len(text), self.frames + (message['type'] == 'frame')
        self.heard[message['type']] = message
        return message

    async def until(self, satisfies):
        while True:
            message = await self.message()
            if satisfies(message):
                return message

    async def ask(self, command, **more):
        self.number += 1
        mine = self.number
        await self.ws.send_json({'type': command, 'id': mine, **more})
        return await self.until(lambda m: m['type'] == 'answer' and m['id'] == mine)


@asynccontextmanager
async def page_of(address):
    async with aiohttp.ClientSession() as session:
        async with session.ws_connect(f'{address}live') as ws:
            yield Page(ws)


async def begin_turn(page):
    """Whether the object is being turned now, from the start."""
    await page.ask('control', how='take')
    await page.ask('reset')
    if not (await page.ask('turn', edge=5))['ok']:
        return False
    told = await page.until(
        lambda m: ended(m) or (m['type'] == 'frame' and m['m'] == 'quasi_static')
    )
    return not ended(told)


def ended(message):
    return message['type'] == 'state' and message['outcome']


async def measure_stops(address, listener, number, drives, limit):
    """(n, 2) [ms]: until the answer, until the hold."""
    draw, rows, last = random.Random(0), [], time.monotonic() + limit
    async with page_of(address) as page:
        await page.until(lambda m: m['type'] == 'graph' and m['status'] == 'ready')
        while len(rows) < number and time.monotonic() < last:
            if not await begin_turn(page):
                continue
            begin = time.monotonic() + draw.uniform(0.0, 1.2)
            while time.monotonic() < begin or not listener.moving():
                if ended(await page.message()):
                    break
            else:
                rows.append(await measure_stop(page, listener, drives))
                print(
                    f'  {len(rows):2}: answer {rows[-1][0]:6.1f} ms, hold {rows[-1][1]:6.1f} ms',
                    flush=True,
                )
    return np.array(rows).reshape(-1, 2)


async def measure_stop(page, listener, drives):
    """[ms] until the answer, until the hold."""
    sent = time.monotonic()
    answer = await page.ask('stop', drives=drives)
    answered = time.monotonic()
    if not drives and 'Reset' in answer['message'] or not answer['ok']:
        print(f'  {answer["message"]}')
    await page.until(lambda m: time.monotonic() > sent + AFTER + 1.0)
    fast = [t for t, v in listener.speeds if v > STILL and sent <= t < sent + AFTER + 1.0]
    listener.speeds.clear()
    return 1e3 * (answered - sent), 1e3 * (max(fast, default=sent) - sent)


async def measure_pages(address, listener, pages, seconds):
    """What one page gets a second, and what the hand reports of the loop meanwhile."""
    async with page_of(address) as page:
        while not await begin_turn(page):
            pass
    async with AsyncExitStack() as stack:
        opened = [await stack.enter_async_context(page_of(address)) for _ in range(pages)]
        end = time.monotonic() + seconds

        async def read(page):
            while time.monotonic() < end:
                await page.message()

        first = listener.hand[-1]
        await asyncio.gather(*map(read, opened), asyncio.sleep(seconds))
        last = listener.hand[-1]
    rate = (int(last[1]['steps']) - int(first[1]['steps'])) / (last[0] - first[0])
    told = ', '.join(f'{name} {last[1][name]}' for name in LOOP if name in last[1])
    shown = (
        f'{opened[0].frames / seconds:.1f} frames/s, {opened[0].bytes / seconds / 1e3:.1f} kB/s a page; '
        if opened
        else ''
    )
    return f'{pages} pages: {shown}loop {rate:.0f} Hz; {told}'


async def measure(address, options):
    listener = Listener()
    try:
        async with page_of(address) as page:
            await page.until(lambda m: m['type'] == 'graph' and m['status'] == 'ready')
        for pages in options.pages:
            while not listener.hand:
                await asyncio.sleep(0.1)
            print(await measure_pages(address, listener, pages, options.seconds), flush=True)
        for drives in (False, True):
            name = 'hand_hardware/stop' if drives else 'mode_switcher/stop'
            print(f'Stop by {name}:')
            rows = await measure_stops(address, listener, options.stops, drives, options.limit)
            for what, column in zip(('answer', 'hold'), rows.T):
                print(
                    f'  {what}: median {np.median(column):.0f} ms, worst {np.max(column):.0f} ms of {len(column)}'
                )
    finally:
        listener.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--stops', type=int, default=20)
    parser.add_argument('--pages', type=int, nargs='*', default=[0, 3])
    parser.add_argument('--seconds', type=float, default=8.0)
    parser.add_argument('--rate', type=float, default=1000.0)
    parser.add_argument('--backend', default='planar')
    parser.add_argument('--limit', type=float, default=150.0)
    options = parser.parse_args()
    command = [sys.executable, '-m', 'wholearm_ros', 'console', '--no-open', '--port', '0']
    command += ['--rate', str(options.rate), '--backend', options.backend]
    with tempfile.TemporaryDirectory() as directory:
        console = subprocess.Popen(command, cwd=directory, stdout=subprocess.PIPE, text=True)
        address = re.search(r'http://\S+', console.stdout.readline())[0]
        try:
            print(f'load {os.getloadavg()[0]:.1f}')
            asyncio.run(measure(address, options))
        finally:
            console.send_signal(signal.SIGINT)
            console.wait()


if __name__ == '__main__':
    main()
