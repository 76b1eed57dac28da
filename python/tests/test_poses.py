# SPDX-License-Identifier: MIT
"""A pose that is refused: the message says what is wrong with it, and what was expected."""
import numpy as np
import pytest

import maxlogdet

CAMERA = maxlogdet.PinholeCamera(458, 457)


def with_entry(row, column, value):
    pose = np.eye(4)
    pose[row, column] = value
    return pose


@pytest.mark.parametrize("reason, text, pose", [
    ("invalid_pose", "{} is not finite: expected numbers", np.full((4, 4), np.nan)),
    ("invalid_pose", "{} is not finite: expected numbers", np.full((3, 4), np.inf)),
    ("invalid_pose", "{} is not finite: expected numbers", with_entry(0, 3, np.nan)),
    ("invalid_pose", "{} is not finite: expected numbers", with_entry(3, 3, -np.inf)),
    ("invalid_pose", r"{}.* no rotation: expected R R\^T = I", 2 * np.eye(4)[:3]),
    ("invalid_pose", r"{}.* no rotation: expected .* det R > 0", with_entry(2, 2, -1)),
    (None, r"^{}: expected the last row 0, 0, 0, 1, got \[0\.5 .* 1\. *\]; is it transposed\?$",
     with_entry(3, 0, 0.5)),
    (None, r"^{}: expected shape \(3, 4\) or \(4, 4\), got \(4, 3\)$", np.eye(4)[:, :3]),
    (None, r"^{}: expected shape \(3, 4\) or \(4, 4\), got \(2, 4\)$", np.eye(4)[:2]),
    (None, r"^{}: expected shape \(3, 4\) or \(4, 4\), got \(4,\)$", np.ones(4)),
])
def test_messages_say_what_is_wrong_with_a_pose(reason, text, pose):
    for name, wrong in (("T_cw", dict(T_cw=pose)), ("T_cb", dict(camera=[(CAMERA, pose)]))):
        with pytest.raises(ValueError, match=text.format(name)) as raised:
            maxlogdet.match_information(**{"camera": CAMERA, "T_cw": np.eye(4), "points": np.ones((1, 3)), **wrong})
        assert getattr(raised.value, "error", None) == reason
