"""The web server of the page: a page, its files, one socket for each that looks, reports."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

from aiohttp import web

from wholearm_ros.console import bags
from wholearm_ros.console.access import COOKIE, Access
from wholearm_ros.console.desk import SLOW, Desk
from wholearm_ros.console.page_socket import PageSocket
from wholearm_ros.errors import WholeArmError
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.report.html.page import ASSETS as REPORT_ASSETS

ASSETS = Path(__file__).parent / 'assets'
MOST_PAGES = 64
MOST_BODY = 4096  # [bytes] of a request; only a token is sent so
SHARED = ('page.css', 'theme.js', 'scene.js')  # of the report
OWN = ('console.css', 'link.js', 'live.js', 'rolling.js', 'draw.js', 'bags.js', 'console.js')
KINDS = {'.css': 'text/css', '.js': 'text/javascript', '.html': 'text/html'}
# Nothing from elsewhere, nothing in line, no page of others around ours.
OURS = "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'"
# A report brings its scripts in line: it runs without our origin, and cannot reach the socket.
ALONE = "sandbox allow-scripts; default-src 'unsafe-inline' data:"
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Server:
    """access: who may open the page; desk: what its messages do."""

    def __init__(self, access: Access, desk: Desk) -> None:
        self.access, self.desk = access, desk
        self._pages, self._sockets = 0, set[PageSocket]()

    def application(self) -> web.Application:
        """To be run by aiohttp."""
        app = web.Application(middlewares=[self.guard], client_max_size=MOST_BODY)
        app.router.add_get('/', self.page)
        app.router.add_get('/assets/{name}', self.asset)
        app.router.add_get('/login', self.login)
        app.router.add_post('/login', self.log_in)
        app.router.add_get('/live', self.live)
        app.router.add_get('/map', self.map)
        app.router.add_get('/bags/{name}', self.report)
        app.on_shutdown.append(self.leave)
        return app

    @web.middleware
    async def guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuses foreign names and origins, and what needs a token without one."""
        host, origin = request.headers.get('Host', ''), request.headers.get('Origin')
        if not self.access.host_allowed(host):
            raise web.HTTPForbidden(text='this name is not the console: use its address')
        if not self.access.origin_allowed(origin, host):
            raise web.HTTPForbidden(text='a page of another origin may not use the console')
        public = request.path in ('/', '/login') or request.path.startswith('/assets/')
        if not public and not self.access.known(request.cookies.get(COOKIE)):
            raise web.HTTPUnauthorized(text='the token that the console printed is needed')
        response = await handler(request)
        if not response.prepared:
            response.headers.setdefault('Content-Security-Policy', OURS)
            response.headers['X-Content-Type-Options'] = 'nosniff'
            response.headers['Referrer-Policy'] = 'no-referrer'
            response.headers['Cache-Control'] = 'no-store'
        return response

    async def page(self, _: web.Request) -> web.Response:
        """The page itself; it holds no data."""
        return _file(ASSETS / 'console.html')

    async def asset(self, request: web.Request) -> web.Response:
        """One of the files that the page names."""
        name = request.match_info['name']
        if name in SHARED:
            return _file(REPORT_ASSETS / name)
        if name in OWN:
            return _file(ASSETS / name)
        raise web.HTTPNotFound

    async def login(self, request: web.Request) -> web.Response:
        """Whether a token is needed still."""
        known = self.access.known(request.cookies.get(COOKIE))
        return web.Response(text='' if known else 'token')

    async def log_in(self, request: web.Request) -> web.Response:
        """The token as the body of the request; the answer sets a cookie."""
        session = self.access.log_in((await request.text()).strip())
        if session is None:
            await asyncio.sleep(0.5)
            raise web.HTTPUnauthorized(text='this is not the token that the console printed')
        response = web.Response(text='')
        response.set_cookie(COOKIE, session, httponly=True, samesite='Strict')
        return response

    async def live(self, request: web.Request) -> web.StreamResponse:
        """The socket of a page."""
        if len(self.desk.hub.pages) >= MOST_PAGES:
            raise web.HTTPServiceUnavailable(text=f'{MOST_PAGES} pages look already')
        self._pages += 1
        socket = PageSocket(self._pages, self.desk)
        self._sockets.add(socket)
        try:
            return await socket.serve(request)
        finally:
            self._sockets.discard(socket)

    async def leave(self, _: web.Application) -> None:
        """Every page is told at once that the console ends."""
        await asyncio.gather(*(socket.close() for socket in self._sockets))

    async def map(self, _: web.Request) -> web.Response:
        """The page of the face map, as far as it is made."""
        scenario = self.desk.bench.scenario
        return await _made(lambda: _map_page(scenario))

    async def report(self, request: web.Request) -> web.Response:
        """The report of a bag."""
        runs, name = self.desk.bench.recording.runs, request.match_info['name']
        return await _made(lambda: bags.report(runs, name))


def _file(path: Path) -> web.Response:
    return web.Response(text=path.read_text(encoding='utf-8'), content_type=KINDS[path.suffix])


def _map_page(scenario: Scenario) -> str:
    from wholearm_ros.report.html.map_page import map_page  # with matplotlib, only when asked for

    return map_page(scenario, MapStore(scenario).load())


async def _made(make: Callable[[], str]) -> web.Response:
    """A page that takes a while, made in a thread of its own."""
    try:
        text = await asyncio.get_running_loop().run_in_executor(SLOW, make)
    except WholeArmError as error:
        return web.Response(text=str(error), status=404)
    headers = {'Content-Security-Policy': ALONE}
    return web.Response(text=text, content_type='text/html', headers=headers)
