"""A bag that is begun and ended from the page: a recorder beside the graph."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.launcher import LOOP_PRIORITY
from wholearm_ros.launcher.processes import NodeDied, Processes

RECORDER = 'bag_recorder'
BAG = 'bag'  # the directory of the bag in that of its run, as `make run` names it


class Recording:
    """A context that ends with the graph; runs: the directory of all runs; directory: of the bag
    that is being recorded, None for none.
    """

    def __init__(self, runs: Path) -> None:
        self.runs = runs
        self.directory: Path | None = None
        self._recorder: Processes | None = None

    def __enter__(self) -> 'Recording':
        return self

    def __exit__(self, *_: object) -> None:
        self.released()()

    def begin(self) -> Path:
        """The directory of the new bag; raises WholeArmError when it cannot be made."""
        if self.directory is not None:
            raise WholeArmError(f'{self.directory} is being recorded; allowed: one at a time')
        run = self.runs / datetime.now().strftime('%Y-%m-%d_%H-%M-%S')
        try:
            run.mkdir(parents=True)
        except OSError as error:
            raise WholeArmError(f'{run}: cannot be made: {error.strerror or error}') from error
        self._recorder, self.directory = Processes(run), run / BAG
        path = str(self.directory.absolute())
        self._recorder.start(RECORDER, {'path': path, 'priority': LOOP_PRIORITY})
        return self.directory

    def released(self) -> Callable[[], None]:
        """What ends the bag, which takes a while; nothing is being recorded any more."""
        recorder, self._recorder, self.directory = self._recorder, None, None
        return (lambda: None) if recorder is None else recorder.stop

    def check(self) -> None:
        """Raises NodeDied, once, when the recorder has ended by itself."""
        if self._recorder is None:
            return
        try:
            self._recorder.check()
        except NodeDied:
            self.released()()
            raise
