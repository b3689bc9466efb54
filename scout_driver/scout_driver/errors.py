"""What can go wrong between the computer and the base."""

from hslam_types.errors import HslamError


class ScoutError(HslamError):
    """Base of this package's errors."""


class ProtocolError(ScoutError):
    """Bytes or values that the Scout's protocol does not allow."""


class LineLostError(ScoutError):
    """The serial line or the connection is gone; opening it again may cure it."""
