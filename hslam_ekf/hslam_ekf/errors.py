"""What the EKF level raises."""

from hslam_types.errors import HslamError


class EkfError(HslamError):
    """An event cannot be acted on: it lacks the node or branch its kind must have."""
