"""Draw what the keys of a scenario file mean, docs/images/scenario.png: python docs/draw_scenario.py"""

from pathlib import Path

import numpy as np

import wholearm_ros as wa
from wholearm_ros.mechanics.contacts import start_configuration
from wholearm_ros.report.figures.canvas import new_figure, save
from wholearm_ros.report.figures.outlines import hand_outlines, object_outline
from wholearm_ros.report.figures.palette import INK, OBJECT, OBJECT_EDGE, PALM, SIDE_COLOURS

SCENARIO = wa.load_scenario('asymmetric_hexagon')


def arrow(axes, start, end, text, at, kind='<->', colour=INK, **options):
    axes.annotate('', end, start, arrowprops={'arrowstyle': kind, 'color': colour, 'lw': 1.2})
    axes.text(*at, text, fontsize=8, color=colour, **{'ha': 'center', 'va': 'center', **options})


def arc(axes, centre, radius, end, text, at):
    turns = np.linspace(0.0, end, 40)
    x, y = centre[0] + radius * np.cos(turns), centre[1] + radius * np.sin(turns)
    axes.plot(x, y, color=INK, lw=1.0)
    axes.plot([centre[0], centre[0] + 1.3 * radius], [centre[1]] * 2, color=INK, lw=0.8, ls=':')
    axes.annotate('', (x[-1], y[-1]), (x[-3], y[-3]), arrowprops={'arrowstyle': '->', 'lw': 1.0})
    axes.text(*at, text, fontsize=8, color=INK, ha='left', va='center')


def main():
    q = start_configuration(SCENARIO)
    figure = new_figure(9.0, 5.6)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.21, 0.235), ylim=(-0.082, 0.192), aspect='equal')
    axes.axis('off')
    axes.plot(*SCENARIO.palm.vertices.T, color=PALM, lw=4)
    axes.text(
        -0.205,
        -0.035,
        'palm.vertices: a line from left to right,\nthe object above it',
        fontsize=8,
        ha='left',
    )
    for k, outline in enumerate(hand_outlines(SCENARIO, q[3:])):
        axes.fill(*outline.T, facecolor=SIDE_COLOURS[k] + '55', edgecolor=SIDE_COLOURS[k])
    shape = object_outline(SCENARIO, q[:3])
    axes.fill(*shape.T, facecolor=OBJECT, edgecolor=OBJECT_EDGE)
    n = len(shape)
    for k, vertex in enumerate(shape):
        inward = q[:2] + 0.86 * (vertex - q[:2])
        middle = q[:2] + 0.80 * ((vertex + shape[(k + 1) % n]) / 2 - q[:2])
        axes.text(*inward, f'v{k}', fontsize=7.5, color=OBJECT_EDGE, ha='center', va='center')
        axes.text(*middle, f'edge {k}', fontsize=8, color=INK, ha='center', va='center')
    axes.plot(*q[:2], '+', color=INK, ms=9)
    axes.text(q[0] + 0.004, q[1] + 0.005, 'centroid', fontsize=8)
    arrow(axes, (0, -0.012), (q[0], -0.012), 'start.x', (q[0] / 2, -0.019))
    axes.plot([q[0]] * 2, [-0.015, q[1]], color=INK, lw=0.7, ls=':')
    for k, finger in enumerate((SCENARIO.hand.left, SCENARIO.hand.right)):
        axes.plot(*finger.axis, 'o', color=INK, ms=5)
        axes.text(
            finger.axis[0],
            finger.axis[1] - 0.012,
            f'hand.{("left", "right")[k]}.axis',
            fontsize=8,
            ha='center',
        )
    left, right = SCENARIO.hand.left, SCENARIO.hand.right
    along = np.array([np.cos(q[3]), np.sin(q[3])])
    side = 0.016 * np.array([-along[1], along[0]])
    arrow(
        axes,
        left.axis + side,
        left.axis + side + left.shape.length * along,
        'length',
        left.axis + 1.9 * side + 0.5 * left.shape.length * along,
        rotation=np.degrees(q[3]),
    )
    tip, across = left.axis + left.shape.length * along, np.array([-along[1], along[0]])
    axes.text(tip[0], tip[1] + 0.011, '2 half_width', fontsize=8, ha='center')
    arrow(axes, tip + 0.004 * along - 0.006 * across, tip + 0.004 * along + 0.006 * across, '', tip)
    arc(
        axes,
        right.axis,
        0.035,
        q[4],
        'angle of the joint\n(angle_limits)',
        (right.axis[0] + 0.04, right.axis[1] + 0.034),
    )
    arrow(axes, (0.0, -0.05), (0.05, -0.05), 'x', (0.055, -0.05), '->', '#d62728')
    arrow(axes, (0.0, -0.05), (0.0, -0.026), 'y', (-0.007, -0.03), '->', '#1a9850')
    axes.plot([0, 0], [-0.006, 0.006], color='#d62728', lw=1.2)
    axes.text(0.002, -0.058, 'frame palm, origin (0, 0) on the palm line', fontsize=8, color=INK)
    arrow(
        axes,
        (0.2, 0.17),
        (0.2, 0.125),
        'gravity.acceleration\n· cos(tilt_deg)',
        (0.2, 0.115),
        '->',
        va='top',
    )
    turn = {'arrowstyle': '->', 'color': '#2f6fb3', 'lw': 1.4, 'connectionstyle': 'arc3,rad=0.3'}
    axes.annotate('', (-0.045, 0.135), (0.03, 0.135), arrowprops=turn)
    axes.text(
        -0.01, 0.158, 'goal: {edge: 5, direction: ccw}', fontsize=8, color='#2f6fb3', ha='center'
    )
    save(figure, Path(__file__).parent / 'images' / 'scenario.png', dpi=90)


if __name__ == '__main__':
    main()
