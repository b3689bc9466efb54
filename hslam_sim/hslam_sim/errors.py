"""The package's root exception."""

from hslam_types.errors import HslamError


class SimulatorError(HslamError):
    """Base of every error `hslam_sim` raises on purpose."""
