"""`wholearm console` as a process, its real graph over real DDS, and pages over HTTP and WebSocket."""

import asyncio
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
from contextlib import asynccontextmanager

import pytest

rclpy = pytest.importorskip('rclpy')
aiohttp = pytest.importorskip('aiohttp')

from conftest import fresh_domain

from wholearm_ros.launcher.client import Client
from wholearm_ros.model.modes import STOPPED

pytestmark = pytest.mark.timeout(280)
WAIT = 150.0  # [s] a bound, not a measure: machines may be loaded
QUICK = ['--pacing', 'lockstep', '--rate', '250', '--backend', 'planar', '--token']


class Console:
    """The process; `address` of its page."""

    def __init__(self, directory, *more):
        command = [sys.executable, '-m', 'wholearm_ros', 'console', '--no-open', '--port', '0']
        self.directory = directory
        self.process = subprocess.Popen(
            [*command, *more],
            cwd=directory,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        line = self.process.stdout.readline()
        self.address, self.token = re.match(r'console: (http://[^#]+/)#?(\S*)', line).groups()
        self.origin = self.address.rstrip('/')

    def end(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=WAIT)[0], self.process.returncode


class Page:
    """A connected page: `ask` returns the answer, `until` the first message that satisfies."""

    def __init__(self, ws):
        self.ws, self.heard, self.number = ws, {}, 0

    async def message(self):
        message = json.loads((await asyncio.wait_for(self.ws.receive(), WAIT)).data)
        self.heard[message['type']] = message
        return message

    async def until(self, satisfies):
        end = time.monotonic() + WAIT
        while time.monotonic() < end:
            message = await self.message()
            if satisfies(message):
                return message
        raise AssertionError(f'not heard; last: {self.heard.keys()} {self.heard.get("state")}')

    async def ask(self, command, **more):
        self.number += 1
        mine = self.number
        await self.ws.send_json({'type': command, 'id': mine, **more})
        return await self.until(lambda m: m['type'] == 'answer' and m['id'] == mine)

    async def ready(self):
        status = self.heard.get('graph', {}).get('status')
        if status != 'ready':
            await self.until(lambda m: m['type'] == 'graph' and m['status'] == 'ready')


@asynccontextmanager
async def session_of(console):
    """Of a browser that has shown the token, where there is one."""
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
        if console.token:
            async with session.post(f'{console.address}login', data=console.token) as answer:
                assert answer.status == 200
        yield session


@asynccontextmanager
async def page_of(console):
    async with session_of(console) as session:
        headers = {'Origin': console.origin}
        async with session.ws_connect(f'{console.address}live', headers=headers) as ws:
            page = Page(ws)
            await page.until(lambda m: m['type'] == 'hello')
            yield page


@pytest.fixture(scope='module')
def console(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', fresh_domain())
        patch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
        patch.setenv('WHOLEARM_MAPS', str(tmp_path_factory.mktemp('maps')))
        console = Console(tmp_path_factory.mktemp('console'), *QUICK)
        yield console
        if console.process.poll() is None:
            console.end()


@pytest.fixture(scope='module')
def alone(tmp_path_factory):
    """A console that waits for a graph that is not there: what needs none is quick on it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_DOMAIN_ID', fresh_domain())
        console = Console(tmp_path_factory.mktemp('alone'), '--join', '--token')
        yield console
        said, code = console.end()
        assert code == 0 and 'Traceback' not in said and console.token not in said


@pytest.fixture
def listener(console):
    """A client of the same graph, which is not the console's."""
    client = Client(name='test_listener')
    yield client
    client.close()


def test_the_page_is_whole_and_asks_nobody_else(alone):
    async def look():
        async with session_of(alone) as session:
            async with session.get(alone.address) as answer:
                text = await answer.text()
                assert answer.status == 200
                assert "default-src 'self'" in answer.headers['Content-Security-Policy']
            assert not re.search(r'https?://', text)
            named = re.findall(r'(?:src|href)="(assets/[^"]+)"', text)
            assert len(named) >= 9
            for name in named:
                async with session.get(alone.address + name) as answer:
                    assert answer.status == 200, name
                    found = await answer.text()
                    assert set(re.findall(r'https?://[\w.]+', found)) <= {'http://www.w3.org'}
            for name in ('assets/../server.py', 'assets/%2e%2e/server.py', 'assets/map.js'):
                async with session.get(alone.address + name) as answer:
                    assert answer.status == 404

    asyncio.run(look())


@pytest.mark.parametrize(
    'headers', [{'Origin': 'http://evil.example'}, {'Origin': 'null'}, {'Host': 'evil.example'}]
)
@pytest.mark.parametrize('path', ['', 'live', 'map', 'bags/one'])
def test_a_foreign_origin_and_a_foreign_name_are_refused(alone, headers, path):
    async def look():
        async with aiohttp.ClientSession() as session:
            async with session.get(alone.address + path, headers=headers) as answer:
                assert answer.status == 403
            if path == 'live':
                with pytest.raises(aiohttp.WSServerHandshakeError):
                    await session.ws_connect(alone.address + path, headers=headers)

    asyncio.run(look())


def test_what_is_malformed_is_answered_and_ends_nothing(alone):
    async def throw():
        async with page_of(alone) as page:
            bad = [
                '',
                '{',
                '[]',
                'null',
                '{"type":"dance"}',
                '{"type":"turn","edge":1e9}',
                '[' * 5000,
            ]
            bad += ['{"type":"check","scenario":' + '{"a":' * 300 + '1' + '}' * 300 + '}']
            for text in bad:
                await page.ws.send_str(text)
                answer = await page.until(lambda m: m['type'] == 'answer')
                assert not answer['ok'] or answer['checked']['problems'], text
            await page.ws.send_bytes(os.urandom(1000))
            assert 'bytes' in (await page.until(lambda m: m['type'] == 'answer'))['message']
            told = await page.ask('check', scenario={'object': {'vertices': 'x' * 100_000}})
            assert told['ok'] and told['checked']['problems']
            told = await page.ask(
                'import', kind='svg', text='<svg><path d="M0,0' + 'L1,1' * 9000 + '"/></svg>'
            )
            assert not told['ok']
            for name in ('turn', 'feel', 'reset', 'load'):
                more = {'turn': {'edge': 1}, 'load': {'scenario': {}}}.get(name, {})
                answer = await page.ask(name, **more)
                assert not answer['ok'] and 'no control' in answer['message']
        async with page_of(alone) as page:
            await page.ws.send_str('x' * 600_000)
            with pytest.raises(TypeError):  # no text any more: the connection is closed
                while True:
                    await page.message()
            assert page.ws.closed  # by 1009, or by a reset: the rest of the message was not read
        async with page_of(alone) as page:
            assert (await page.ask('files'))['ok']

    asyncio.run(throw())


def test_control_is_asked_for_taken_over_and_lost_with_the_page(alone):
    async def share():
        async with page_of(alone) as one:
            assert (await one.ask('control', how='ask'))['ok']
            async with page_of(alone) as two:
                refused = await two.ask('control', how='ask')
                assert not refused['ok'] and 'has control' in refused['message']
                assert (await two.ask('control', how='take'))['ok']
                page = two.heard['hello']['page']
                await one.until(lambda m: m['type'] == 'control' and m['holder'] == page)
                assert 'no control' in (await one.ask('cancel'))['message']
            await one.until(lambda m: m['type'] == 'control' and m['holder'] is None)

    asyncio.run(share())


def test_a_token_is_asked_for_and_a_graph_that_is_not_there_is_not_stopped(alone):
    async def look():
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
            for path in ('live', 'map', 'bags/x'):
                async with session.get(alone.address + path) as answer:
                    assert answer.status == 401
            async with session.get(f'{alone.address}login') as answer:
                assert await answer.text() == 'token'
            async with session.post(f'{alone.address}login', data='guess') as answer:
                assert answer.status == 401 and not answer.cookies
            async with session.post(f'{alone.address}login', data='x' * 10_000) as answer:
                assert answer.status == 413
            async with session.post(f'{alone.address}login', data=alone.token) as answer:
                cookie = answer.cookies['wholearm_console']
                assert answer.status == 200
                assert cookie['httponly'] and cookie['samesite'] == 'Strict'
            async with session.get(f'{alone.address}login') as answer:
                assert await answer.text() == ''
        async with page_of(alone) as page:
            graph = page.heard.get('graph') or await page.until(lambda m: m['type'] == 'graph')
            assert graph['status'] == 'waiting' and graph['join']
            answer = await page.ask('stop')
            assert not answer['ok'] and 'emergency stop' in answer['message']

    asyncio.run(look())


def test_fifty_pages_and_one_that_never_reads_keep_nobody_from_an_answer(alone):
    host, _, port = alone.address[7:-1].rpartition(':')
    deaf = socket.create_connection((host, int(port)))

    async def read(one):
        async for _ in one:
            pass

    async def crowd():
        async with session_of(alone) as session:
            cookie = next(iter(session.cookie_jar))
            deaf.sendall(
                f'GET /live HTTP/1.1\r\nHost: {host}:{port}\r\nCookie: {cookie.key}={cookie.value}\r\n'
                'Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n'
                'Sec-WebSocket-Key: MTIzNDU2Nzg5MDEyMzQ1Ng==\r\n\r\n'.encode()
            )
            connect = lambda: session.ws_connect(f'{alone.address}live')
            pages = await asyncio.gather(*(connect() for _ in range(50)))
            reading = [asyncio.create_task(read(one)) for one in pages]
            async with page_of(alone) as page:
                await page.until(lambda m: m['type'] == 'control' and m['pages'] >= 51)
                assert 'emergency stop' in (await page.ask('stop'))['message']
                assert (await page.ask('files'))['ok']
            refused = 0
            for _ in range(20):
                try:
                    pages.append(await connect())
                except aiohttp.WSServerHandshakeError as error:
                    refused += error.status == 503
            assert refused >= 5
            for one in reading:
                one.cancel()
            await asyncio.gather(*(one.close() for one in pages))

    asyncio.run(crowd())
    deaf.close()


def test_turn_stop_by_a_page_that_looks_on_feel_and_turn_again(console, listener):
    """Stop in the middle holds the hand; the object is felt where it is, and turned from there."""

    async def work():
        async with page_of(console) as page:
            await page.ready()
            assert (await page.ask('control', how='ask'))['ok']
            assert (await page.ask('turn', edge=5))['ok']
            await page.until(
                lambda m: m['type'] == 'frame' and m['m'] == 'quasi_static' and 'g' in m
            )
            async with page_of(console) as other:  # which has no control
                stopped = await other.ask('stop')
            assert stopped['ok'], stopped
            state = await page.until(lambda m: m['type'] == 'state' and m['outcome'])
            assert state['outcome'] in ('aborted', 'canceled') and 'stop' in state['reached']
            listener.wait(lambda: listener.latest.mode == STOPPED, WAIT, 'mode')
            if 'eset' in stopped['message']:  # a busy machine: the drives themselves were stopped
                assert 'Reset first' in (await page.ask('feel'))['message']
            assert (await page.ask('reset'))['ok']
            assert (await page.ask('feel'))['ok']
            state = await page.until(lambda m: m['type'] == 'state' and m['felt'])
            assert state['place']['edge'] == 0, state
            assert state['place']['x'] == pytest.approx(-20.0, abs=3.0)
            assert (await page.ask('turn', edge=5))['ok']
            state = await page.until(lambda m: m['type'] == 'state' and m['outcome'])
            assert state['outcome'] == 'succeeded', state
            assert state['place']['edge'] == 5 and state['tries'][-1]['claimed'] == 'at_goal'
            (here,) = (f for f in page.heard['faces']['faces'] if f['here'])
            assert here['edge'] == 5

    asyncio.run(work())


def test_a_browser_logs_in_stops_asks_and_says_when_nobody_hears_it(alone, browser):
    """On a phone: the question lies beside Stop, and what the space bar would do elsewhere Enter does."""
    by_id = lambda name: browser.find_element('id', name)
    keys = lambda *pressed: browser.switch_to.active_element.send_keys(*pressed)

    def until(script):
        end = time.monotonic() + WAIT
        while not browser.execute_script(f'return {script}'):
            assert time.monotonic() < end, script
            time.sleep(0.05)

    def drive():
        browser.execute_cdp_cmd(
            'Emulation.setDeviceMetricsOverride',
            {'width': 390, 'height': 844, 'deviceScaleFactor': 1, 'mobile': True},
        )
        browser.get(alone.address)
        until("!byId('login').hidden && byId('stop').classList.contains('dead')")
        by_id('token').send_keys(alone.token + '\n')
        until("link.isAlive() && !byId('stop').classList.contains('dead')")
        keys(' ')
        until("byId('stop-text').textContent.includes('emergency stop')")
        by_id('only-warnings').send_keys('\n')
        until("byId('only-warnings').checked")
        by_id('control').click()
        until("byId('ask').open")
        keys('\ue00c')  # Escape
        until("!byId('ask').open")
        by_id('control').click()
        until("byId('ask').open")
        by_id('ask-yes').click()  # an error if something lies over it
        until('inControl()')
        alone.process.send_signal(signal.SIGSTOP)
        until("!byId('lost').hidden && byId('stop').classList.contains('dead')")
        keys(' ')
        until("byId('stop-text').textContent.includes('did not reach')")
        alone.process.send_signal(signal.SIGCONT)
        until("byId('lost').hidden && link.isAlive()")
        assert browser.execute_script('return document.documentElement.scrollWidth') <= 390
        assert browser.get_log('browser') == []

    async def work():
        async with page_of(alone) as other:
            assert (await other.ask('control', how='take'))['ok']
            await asyncio.to_thread(drive)

    asyncio.run(work())


async def abuse(console, draw):
    """Everything at once that a page must not do: it is answered or refused, and nothing else."""
    async with session_of(console) as session:
        deaf = await session.ws_connect(f'{console.address}live')  # and never read
        crowd = await asyncio.gather(
            *(session.ws_connect(f'{console.address}live') for _ in range(50))
        )
        async with page_of(console) as page:
            for _ in range(30):
                kind = draw.choice(['turn', 'stop', 'load', 'record', 'check', 'dance', None])
                junk = draw.choice([draw.random(), 'x' * draw.randrange(9000), [[]], {'edge': -1}])
                key = draw.choice(['edge', 'drives', 'scenario', 'on', draw.randbytes(9).hex()])
                text = json.dumps({'type': kind, key: junk})
                await page.ws.send_str(text[: draw.choice([None, len(text) // 2])])
                answer = await page.until(lambda m: m['type'] == 'answer')
                assert not answer['ok'] or answer['checked']['problems'], text
            await page.ws.send_bytes(draw.randbytes(100_000))
            assert not (await page.until(lambda m: m['type'] == 'answer'))['ok']
            await page.ws.send_str('x' * 600_000)  # which ends this page
        for headers in ({'Origin': 'http://evil.example'}, {'Host': 'evil.example'}):
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await session.ws_connect(f'{console.address}live', headers=headers)
        for one in (*crowd, deaf):
            await one.close()
    async with aiohttp.ClientSession() as session:
        async with session.post(f'{console.address}login', data='guess') as answer:
            assert answer.status == 401
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await session.ws_connect(f'{console.address}live')


def test_a_graph_that_turns_its_object_goes_on_under_abuse(console):
    async def work():
        draw, abused = random.Random(0), 0
        async with page_of(console) as page:
            await page.ready()
            assert (await page.ask('control', how='ask'))['ok']
            assert (await page.ask('reset'))['ok']
            assert (await page.ask('turn', edge=5))['ok']
            await page.until(lambda m: m['type'] == 'frame' and m['m'] == 'quasi_static')
            end = asyncio.create_task(page.until(lambda m: m['type'] == 'state' and m['outcome']))
            while not end.done():
                await abuse(console, draw)
                abused += not end.done()
            assert (await end)['outcome'] == 'succeeded'
            assert abused >= 1

    asyncio.run(work())


def test_the_drives_are_stopped_past_every_other_node(console, listener):
    async def work():
        async with page_of(console) as page:
            await page.ready()
            answer = await page.ask('stop', drives=True)
            assert answer['ok'] and 'take no command until' in answer['message']
            await page.until(lambda m: m['type'] == 'loop' and m['drives'] == 'stopped')
            assert (await page.ask('control', how='ask'))['ok']
            assert 'Reset first' in (await page.ask('turn', edge=5))['message']
            assert (await page.ask('reset'))['ok']

    asyncio.run(work())


def test_a_run_is_recorded_listed_replayed_and_reported(console):
    async def work():
        async with page_of(console) as page, session_of(console) as session:
            await page.ready()
            assert (await page.ask('control', how='ask'))['ok']
            assert (await page.ask('reset'))['ok']
            begun = await page.ask('record', on=True)
            assert begun['ok'] and 'runs' in begun['message']
            bag = console.directory / page.heard['recording']['bag'] / 'metadata.yaml'
            while not bag.exists():  # the recorder listens before it makes its file
                await page.message()
            assert (await page.ask('turn', edge=5))['ok']
            await page.until(lambda m: m['type'] == 'state' and m['outcome'] == 'succeeded')
            assert (await page.ask('record', on=False))['ok']
            (listed,) = (await page.ask('files'))['bags']
            run = (await page.ask('replay', bag=listed['name']))['run']
            assert len(run['times']) > 50 and 'quasi_static' in run['modes']
            assert not (await page.ask('replay', bag='another'))['ok']
            async with session.get(f'{console.address}bags/{listed["name"]}') as answer:
                assert (
                    answer.status == 200 and 'sandbox' in answer.headers['Content-Security-Policy']
                )
                assert '<svg' in await answer.text()
            async with session.get(f'{console.address}bags/..%2f..%2fetc') as answer:
                assert answer.status == 404

    asyncio.run(work())


def test_another_object_is_put_into_the_hand(console):
    async def work():
        async with page_of(console) as page:
            await page.ready()
            assert (await page.ask('control', how='ask'))['ok']
            told = (await page.ask('open', name='regular_hexagon'))['scenario']
            assert (await page.ask('load', scenario={**told, 'name': 'loaded'}))['ok']
            scene = await page.until(lambda m: m['type'] == 'scene')
            assert scene['scenario']['name'] == 'loaded'
            await page.until(lambda m: m['type'] == 'frame')

    asyncio.run(work())


def test_at_the_end_every_page_is_told_and_every_node_has_ended(console):
    async def work():
        async with page_of(console) as page:
            console.process.send_signal(signal.SIGINT)
            async for _ in page.ws:
                pass
            assert page.ws.close_code == aiohttp.WSCloseCode.GOING_AWAY

    asyncio.run(work())
    said, code = console.end()
    assert code == 0 and 'every node has been stopped' in said
    assert 'Traceback' not in said
