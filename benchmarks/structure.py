"""Figures of the tree, counted from its sources.

    python benchmarks/structure.py [PACKAGE_DIRECTORY]

Long signatures, long lines, types, docstrings, import circles of files, the largest function.
"""

import argparse
import ast
from pathlib import Path

FUNCTION = (ast.FunctionDef, ast.AsyncFunctionDef)
HERE = Path(__file__).resolve().parents[1] / 'wholearm_ros'


def figures(package: Path) -> dict:
    """name → value."""
    texts = {path: path.read_text(encoding='utf-8') for path in sorted(package.rglob('*.py'))}
    trees = {path: ast.parse(text) for path, text in texts.items()}
    functions = [n for tree in trees.values() for n in ast.walk(tree) if isinstance(n, FUNCTION)]
    public = [f for f in functions if not f.name.startswith('_')]
    lines = [line for text in texts.values() for line in text.splitlines()]
    largest = max(functions, key=lambda f: f.end_lineno - f.lineno)
    return {
        'files': len(texts),
        'lines': len(lines),
        'lines over 100 columns': sum(len(line) > 100 for line in lines),
        'functions': len(functions),
        'functions with more than 6 parameters': sum(len(_parameters(f)) > 6 for f in functions),
        'fully typed functions': _share(functions, _typed),
        'public functions with a docstring': _share(public, ast.get_docstring),
        'files in an import circle': len(_circular(package, trees)),
        'largest function': f'{largest.name}, {largest.end_lineno - largest.lineno + 1} lines',
    }


def _parameters(function) -> list:
    a = function.args
    return [p for p in (*a.posonlyargs, *a.args, *a.kwonlyargs) if p.arg not in ('self', 'cls')]


def _typed(function) -> bool:
    returns = function.returns is not None or function.name == '__init__'
    return returns and all(p.annotation is not None for p in _parameters(function))


def _share(functions, holds) -> str:
    return f'{100 * sum(bool(holds(f)) for f in functions) / len(functions):.0f} %'


def _circular(package: Path, trees: dict) -> set:
    """Modules that import themselves by way of others, of the same package."""
    names = {path: _name(package, path) for path in trees}
    known = set(names.values())
    imports = {
        names[path]: {m for m in _imported(names[path], path, tree) if m in known}
        for path, tree in trees.items()
    }
    return {module for module in imports if module in _reachable(imports, module)}


def _name(package: Path, path: Path) -> str:
    parts = path.relative_to(package.parent).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


def _imported(name: str, path: Path, tree) -> set:
    package = name.split('.') if path.name == '__init__.py' else name.split('.')[:-1]
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            up = package[: len(package) - node.level + 1] if node.level else []
            base = '.'.join([*up, *([node.module] if node.module else [])])
            found |= {base, *(f'{base}.{alias.name}' for alias in node.names)}
    return found


def _reachable(imports: dict, module: str) -> set:
    found, open_ = set(), list(imports[module])
    while open_:
        name = open_.pop()
        if name not in found:
            found.add(name)
            open_ += imports.get(name, ())
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('package', type=Path, nargs='?', default=HERE)
    for name, value in figures(parser.parse_args().package.resolve()).items():
        print(f'{name:40}{value}')


if __name__ == '__main__':
    main()
