"""An object above the palm floats; one that lies on it, on an edge or a corner, does not."""

import numpy as np
import pytest
from problems import ASYMMETRIC

from wholearm_ros.mechanics.contacts import pose_on_palm
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.start_checks import floating, palm_clearance


@pytest.mark.parametrize('x, turn', [(-0.02, 0.0), (0.0, 0.148), (0.003, 0.302), (0.01, -1.0)])
@pytest.mark.parametrize('height', [0.0, 2e-3, 0.1])
def test_the_height_above_the_palm_is_told(x, turn, height):
    pose = pose_on_palm(build_world(ASYMMETRIC), x, turn) + np.array([0.0, height, 0.0])
    assert palm_clearance(ASYMMETRIC, pose) == pytest.approx(height, abs=1e-6)
    problem = floating('start', ASYMMETRIC, pose, 1e-3)
    if height:
        assert problem == (
            f'start: got an object {1e3 * height:.2f} mm above the palm; allowed: at most 1 mm'
        )
    else:
        assert problem is None
