"""Two atlas files joined to a third, which is there only once it is whole."""

from pathlib import Path

from hslam_atlas.atlas_merge import MergedAtlases, merge_atlases
from hslam_atlas.config import AtlasConfig
from hslam_atlas.store import AtlasStore
from hslam_bringup.errors import RunError


def joined(a: Path, b: Path, out: Path) -> MergedAtlases:
    """Write the atlas of two others to ``out``; raises MergeRefusedError, StoreError, and RunError if it exists."""
    if out.exists():
        raise RunError(f"{out} exists; choose another --out")
    partial = out.with_name(f"{out.name}.part")
    try:
        with AtlasStore.reading(a) as first, AtlasStore.reading(b) as second, AtlasStore(partial) as into:
            done = merge_atlases(first, second, into, AtlasConfig())
        partial.replace(out)
    finally:
        partial.unlink(missing_ok=True)
    return done
