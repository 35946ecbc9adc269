from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.turning import turned_to_fit
from tests.rigs import rig_and_matches


def test_a_turned_camera_is_turned_back_where_it_stands() -> None:
    rig, pairs = rig_and_matches()
    angle = np.radians(4.0)
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    turned = rig.with_pose(2, turn @ rig.poses[2])
    mine = {pair: one for pair, one in pairs.items() if 2 in pair}
    pose, degrees = turned_to_fit(turned, mine, 2)
    assert degrees == pytest.approx(4.0, abs=0.05)
    np.testing.assert_allclose(pose, rig.poses[2], atol=0.01)
    np.testing.assert_allclose(turned.with_pose(2, pose).centres()[2], rig.centres()[2], atol=1e-9)


def test_a_right_camera_stays() -> None:
    rig, pairs = rig_and_matches()
    assert turned_to_fit(rig, {pair: one for pair, one in pairs.items() if 2 in pair}, 2)[1] < 0.05
