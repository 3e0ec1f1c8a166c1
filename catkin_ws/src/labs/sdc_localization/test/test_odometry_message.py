import numpy as np

from sdc_localization.odometry_message import pose_covariance

COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 5.0, 0.6], [0.5, 0.6, 6.0]])


def test_covariance_of_the_estimate_is_at_its_place():
    rows = np.reshape(pose_covariance(COVARIANCE), (6, 6))
    assert (rows[np.ix_((0, 1, 5), (0, 1, 5))] == COVARIANCE).all()
    assert not rows[2:5].any()
