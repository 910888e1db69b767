"""The making of a face map beside everything else: `wholearm map` as a process of low priority."""

import asyncio
import json
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import scenario_to_dict

NICENESS = 10
TO_A_WAY = 30  # [s] for each


class MapJob:
    """One at a time; `publish` is told its lines."""

    def __init__(self, publish: Callable[[dict[str, Any]], None]) -> None:
        self._publish = publish
        self._task: asyncio.Task[None] | None = None

    async def begin(self, scenario: Scenario) -> str:
        """Of the object in the hand; what was made before is kept."""
        if self._task is not None and not self._task.done():
            return 'a map is being made already'
        self._task = asyncio.create_task(self._make(scenario))
        return 'making the map: minutes, and it can be used meanwhile'

    async def end(self) -> str:
        """What is made until now is kept."""
        if self._task is None or self._task.done():
            return 'no map is being made'
        self._task.cancel()
        try:
            await self._task
        except asyncio.CancelledError:
            pass
        return 'ended; what was made is kept'

    async def _make(self, scenario: Scenario) -> None:
        with tempfile.TemporaryDirectory(prefix='wholearm_map_') as directory:
            file = Path(directory) / 'scenario.json'
            file.write_text(json.dumps(scenario_to_dict(scenario)), encoding='utf-8')
            command = [sys.executable, '-m', 'wholearm_ros', 'map', str(file)]
            process = await asyncio.create_subprocess_exec(
                *command,
                *('--jobs', '1', '--time-budget', str(TO_A_WAY)),
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.DEVNULL,
                preexec_fn=lambda: os.nice(NICENESS),
            )
            assert process.stdout is not None
            self._tell(True, 'begun')
            try:
                async for line in process.stdout:
                    self._tell(True, line.decode(errors='replace').strip())
            finally:
                if process.returncode is None:
                    process.terminate()
                    await process.wait()
                self._tell(False, '')

    def _tell(self, running: bool, line: str) -> None:
        self._publish({'type': 'job', 'running': running, 'line': line})
