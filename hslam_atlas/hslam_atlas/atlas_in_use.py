"""The atlas a robot works on, with the file it is kept in; another one may be taken up in its place."""

from pathlib import Path

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore


class AtlasInUse:
    """Holds the present server."""

    def __init__(self, config: AtlasConfig, path: Path | None) -> None:
        """Take up an atlas file, or an empty atlas in memory; raises StoreError."""
        self._config = config
        self.server = _server(config, AtlasStore(path))

    def take_up(self, path: Path) -> None:
        """Go on with the atlas of another file, which must exist: the robot has to find itself in it.

        Raises StoreError, and stays with the present one, where that is not saved or the other cannot be read.
        """
        self.server.save_rest()
        server = _server(self._config, AtlasStore(path, create=False))
        server.dispatch.begin("explore" if self.server.exploring else "none")
        self.server.store.close()
        self.server = server

    def change(self, config: AtlasConfig) -> None:
        """Go on with another mission, or another end of it."""
        mission = self._config.mission
        self._config = self.server.state.config = config
        self.server.dispatch.return_home = config.return_home
        if config.mission != mission:
            self.server.dispatch.begin(config.mission)

    def close(self) -> None:
        """Save what could not be saved until now, and close the file; raises StoreError if it still cannot be."""
        try:
            self.server.save_rest()
        finally:
            self.server.store.close()


def _server(config: AtlasConfig, store: AtlasStore) -> AtlasServer:
    """Return a server for a store, which is closed where that cannot be; raises StoreError."""
    try:
        return AtlasServer(config, store)
    except StoreError:
        store.close()
        raise
