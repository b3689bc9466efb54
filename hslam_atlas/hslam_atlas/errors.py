"""The atlas package's exceptions."""

from hslam_types.errors import HslamError


class AtlasError(HslamError):
    """Base of what the atlas raises on purpose."""


class StoreError(AtlasError):
    """An atlas file cannot be read or is not one."""
