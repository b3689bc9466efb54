"""Edge-maps to an atlas: matching, loop closing, optimisation, planning, exploration."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hslam_atlas.atlas_reading import OpenAtlas, open_atlas

__all__ = ["OpenAtlas", "open_atlas"]


def __getattr__(name: str) -> Any:
    """Import what programs use once they ask for it: an executable must have begun before it imports much."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from hslam_atlas import atlas_reading  # noqa: PLC0415

    return getattr(atlas_reading, name)
