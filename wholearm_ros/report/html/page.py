"""One self-contained HTML file: style, data and scripts inside, nothing from the network."""

import json
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

ASSETS = Path(__file__).parent / 'assets'


def page(title: str, body: str, data: dict[str, Any], script: str, plots: bool = True) -> str:
    """script: the file in assets/ that brings the page to life; it finds `data` in REPORT; plots:
    whether it draws plots.
    """
    values = json.dumps(data, separators=(',', ':'), allow_nan=False).replace('<', '\\u003c')
    assets = ('theme.js', 'scene.js', *(('plots.js',) if plots else ()), script)
    scripts = f'const REPORT = {values};', '\n' + ''.join(map(asset, assets))
    return _document(title, body, ''.join(f'<script>{text}</script>\n' for text in scripts))


def still_page(title: str, body: str) -> str:
    """A page without scripts."""
    return _document(title, body, '')


def _document(title: str, body: str, scripts: str) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f'<title>{escape(title)}</title>\n<style>\n{asset("page.css")}</style>\n</head>\n'
        f'<body>\n{body}\n{scripts}</body>\n</html>\n'
    )


def asset(name: str) -> str:
    """The text of a file in assets/."""
    return (ASSETS / name).read_text()


def table(head: Sequence[str], rows: Iterable[Sequence[Any]], kind: str = '') -> str:
    """Cells are text; what begins with a '<' kept as it is must come through `raw`.

    kind: CSS class; the rows of a `long` table become blocks on a narrow page, each cell with its
    heading.
    """
    names = [cell(name) for name in head]
    top = ''.join(f'<th>{name}</th>' for name in names)
    lines = ''.join(
        '<tr>'
        + ''.join(f'<td data-name="{n}">{cell(c)}</td>' for n, c in zip(names, row))
        + '</tr>'
        for row in rows
    )
    head_and_body = f'<thead><tr>{top}</tr></thead><tbody>{lines}</tbody>'
    return f'<div class="scroll"><table class="{kind}">{head_and_body}</table></div>'


class raw(str):
    """HTML that is already escaped."""


def cell(value: Any) -> str:
    """Escaped, unless it is `raw`."""
    return str(value) if isinstance(value, raw) else escape(str(value))


def facts(pairs: dict[str, Any]) -> str:
    """A list of names and values."""
    return (
        '<dl>'
        + ''.join(f'<dt>{cell(k)}</dt><dd>{cell(v)}</dd>' for k, v in pairs.items())
        + '</dl>'
    )
