"""Edge-maps to an atlas: matching, loop closing, optimisation, planning, exploration."""

from hslam_atlas.atlas_reading import OpenAtlas, open_atlas

__all__ = ["OpenAtlas", "open_atlas"]
