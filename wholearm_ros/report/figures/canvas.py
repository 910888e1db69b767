"""Figures without global state: made on the Agg canvas, written to files."""

import io
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


def new_figure(width: float, height: float, **options: Any) -> Figure:
    """width, height [inch]"""
    figure = Figure(figsize=(width, height), **options)
    FigureCanvasAgg(figure)
    return figure


def save(figure: Figure, path: Path, dpi: int = 120) -> Path:
    """PNG or SVG, by the name's ending; the same figure gives the same bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(
        path, dpi=dpi, metadata={'Date': None} if path.suffix == '.svg' else {'Software': None}
    )
    return path


def svg_text(figure: Figure) -> str:
    """The figure as an <svg> element, transparent, to be put into a page."""
    text = io.StringIO()
    with matplotlib.rc_context({'svg.hashsalt': 'wholearm'}):
        figure.savefig(text, format='svg', transparent=True, metadata={'Date': None})
    return text.getvalue()[text.getvalue().index('<svg') :]
