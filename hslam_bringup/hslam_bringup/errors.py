"""Errors of whole runs."""

from hslam_types.errors import HslamError


class RunError(HslamError):
    """A run could not start, go on or end as it should."""


class NodeDiedError(RunError):
    """A node's process ended while it was needed."""
