"""What the tests of every room share."""

import itertools
import os
import shutil
import sys
from pathlib import Path

import pytest
from hypothesis import settings

sys.path.insert(
    0, str(Path(__file__).parent)
)  # problems.py and plain_geometry.py, importable from every room
settings.register_profile(
    'same', derandomize=True, deadline=None, database=None
)  # the same examples everywhere
settings.load_profile('same')

_domains = itertools.count(os.getpid() * 7)
# Tests in which a clock decides run one after another.
REALTIME = (
    'test/ros/test_check_hand.py',
    'test/ros/test_faults.py',
    'test/ros/test_ros2_control.py',
    'test/ros/test_transport.py',
    'test/ros/test_whole_run.py',
)

CHROMIUM = next(
    (
        path
        for name in ('chromium', 'chromium-browser', 'google-chrome')
        if (path := shutil.which(name))
    ),
    None,
)
DRIVER = shutil.which('chromedriver')


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_xdist_make_scheduler(config, log):
    """Every file stays in one of the processes (`-n 2`), for its fixtures; those in real time stay in the same one."""
    from xdist.scheduler import LoadScopeScheduling

    class OneRealTimeGraphAtATime(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return 'realtime' if nodeid.startswith(REALTIME) else nodeid.partition('::')[0]

    return OneRealTimeGraphAtATime(config, log)


@pytest.fixture(scope='session')
def config() -> Path:
    """The directory of the shipped scenarios."""
    return Path(__file__).parents[1] / 'config'


def fresh_domain() -> str:
    """A ROS_DOMAIN_ID that no other test of this session uses (of 0 to 101, the first ten left to people)."""
    worker = int(os.environ.get('PYTEST_XDIST_WORKER', 'gw0')[2:])
    return str(10 + (2 * next(_domains) + worker % 2) % 92)


@pytest.fixture(scope='module')
def browser():
    """A real one, for the tests of pages."""
    if not (CHROMIUM and DRIVER):
        pytest.skip('no Chromium with its chromedriver here (Debian: chromium chromium-driver)')
    webdriver = pytest.importorskip('selenium.webdriver', reason='selenium is not installed')
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in ('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage'):
        options.add_argument(argument)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    driver.set_page_load_timeout(100)
    driver.set_script_timeout(60)
    yield driver
    driver.quit()
