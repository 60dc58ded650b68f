"""Points inside polygons."""

import numpy as np

from uwsim.base.polygon import inside


def test_a_polygon_holds_the_same_points_in_either_winding():
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]])  # with a notch at the top
    points = np.array([[1.0, 1.0], [2.0, 3.0], [3.5, 2.0], [5.0, 1.0], [-1.0, 1.0]])
    assert inside(points, corners).tolist() == [True, False, True, False, False]
    assert inside(points, corners[::-1]).tolist() == [True, False, True, False, False]
