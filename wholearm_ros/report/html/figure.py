"""A figure as a page shows it: its colours are those of the page, light or dark."""

import re

from matplotlib.figure import Figure

from wholearm_ros.report.figures.canvas import svg_text
from wholearm_ros.report.figures.map_figure import NO_PLAN
from wholearm_ros.report.figures.palette import (
    INK,
    OBJECT,
    OBJECT_EDGE,
    PALM,
    PLANNED,
    SIDE_COLOURS,
)

THEME = {  # colour of a figure → variable of page.css
    INK: 'ink',
    '#000000': 'ink',
    '#ffffff': 'card',
    '#666666': 'soft',
    '#9a9a9a': 'faint',
    NO_PLAN: 'line',
    OBJECT: 'object',
    OBJECT_EDGE: 'object-edge',
    PALM: 'palm',
    PLANNED: 'planned',
    SIDE_COLOURS[0]: 'left',
    SIDE_COLOURS[1]: 'right',
}


def figure_in_page(figure: Figure) -> str:
    """An <svg> element whose known colours follow the page's theme."""
    return re.sub(
        r'(?<=: )#[0-9a-f]{6}\b',
        lambda found: f'var(--{THEME[found[0]]})' if found[0] in THEME else found[0],
        svg_text(figure),
    )
