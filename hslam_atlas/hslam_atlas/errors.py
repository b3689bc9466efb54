"""The atlas package's exceptions."""

from hslam_types.errors import HslamError


class AtlasError(HslamError):
    """Base of what the atlas raises on purpose."""


class StoreError(AtlasError):
    """An atlas file cannot be read or is not one."""


class ContentError(AtlasError):
    """What is kept in an atlas file is not what it must be; the text names table and row, whoever knows it the file."""
