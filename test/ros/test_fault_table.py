"""docs/faults.md: every row names tests, and they exist."""

import re
from pathlib import Path

HERE = Path(__file__).parent
TABLE = (HERE.parents[1] / 'docs' / 'faults.md').read_text().split('\n## ')[0]
ROWS = [line.strip('|\n').split('|') for line in TABLE.splitlines() if line.startswith('| ')][1:]


def test_every_row_has_a_test_that_exists():
    known = set(
        re.findall(
            r'def (test_\w+)', ''.join(p.read_text() for p in HERE.parent.rglob('test_*.py'))
        )
    )
    known |= {p.name for p in HERE.parent.rglob('test_*.py')}
    assert len(ROWS) > 15
    for what, _, tests in ROWS:
        named = re.findall(r'`(test_[\w.]+)`', tests)
        assert named or 'same' in tests, what
        assert set(named) <= known, (what, set(named) - known)
