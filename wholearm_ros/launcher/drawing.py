"""Outlines as text: lines of Braille characters, each of which has two by four dots."""

from collections.abc import Sequence

import numpy as np

BLANK = 0x2800  # the character without dots
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # bits of rows and columns


def draw_outlines(
    polygons: Sequence[np.ndarray], box: tuple[float, float, float, float], columns: int
) -> str:
    """The closed polygons (n, 2) that lie in the box (left, right, bottom, top), in the same unit,
    `columns` characters wide; what is outside is cut off.
    """
    left, right, bottom, top = box
    scale = 2 * columns / (right - left)  # dots a unit
    rows = int(np.ceil((top - bottom) * scale / 4))
    grid = np.zeros((4 * rows, 2 * columns), dtype=int)
    for polygon in polygons:
        for a, b in zip(polygon, np.roll(polygon, -1, axis=0)):
            steps = 2 + int(2 * scale * np.hypot(*(b - a)))
            points = a + np.linspace(0.0, 1.0, steps)[:, None] * (b - a)  # (steps, 2)
            x, y = ((points - [left, bottom]) * scale).astype(int).T
            seen = (0 <= x) & (x < 2 * columns) & (0 <= y) & (y < 4 * rows)
            grid[4 * rows - 1 - y[seen], x[seen]] = 1
    cells = grid.reshape(rows, 4, columns, 2)
    codes = BLANK + np.einsum('rdcs,ds->rc', cells, DOTS)
    return '\n'.join(''.join(map(chr, row)) for row in codes)
