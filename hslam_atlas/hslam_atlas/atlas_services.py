"""What can be asked of the atlas as ROS services: a copy, another atlas in its place, which node the robot is at."""

from collections.abc import Callable
from pathlib import Path

from hslam_msgs.srv import AtlasFile, IdentifyNode
from rclpy.node import Node

from hslam_atlas.atlas_in_use import AtlasInUse
from hslam_atlas.errors import StoreError


class AtlasServices:
    """Answers; what cannot be done is refused with the reason, and changes nothing."""

    def __init__(self, node: Node, atlas: AtlasInUse, loaded: Callable[[], None]) -> None:
        """Offer the services on ``node``; ``loaded`` is called once another atlas is in use."""
        self._atlas, self._loaded = atlas, loaded
        node.create_service(AtlasFile, "~/save", self._on_save)
        node.create_service(AtlasFile, "~/load", self._on_load)
        node.create_service(IdentifyNode, "~/identify", self._on_identify)

    def _on_save(self, request: AtlasFile.Request, response: AtlasFile.Response) -> AtlasFile.Response:
        try:
            self._atlas.server.save_as(Path(request.path))
            response.success, response.message = True, f"saved to {request.path}"
        except StoreError as error:
            response.success, response.message = False, str(error)
        return response

    def _on_load(self, request: AtlasFile.Request, response: AtlasFile.Response) -> AtlasFile.Response:
        try:
            self._atlas.take_up(Path(request.path))
            self._loaded()
            response.success, response.message = True, f"loaded {request.path}; the robot has to find itself"
        except StoreError as error:
            response.success, response.message = False, str(error)
        return response

    def _on_identify(self, request: IdentifyNode.Request, response: IdentifyNode.Response) -> IdentifyNode.Response:
        response.success = self._atlas.server.identify(request.node)
        response.message = "taken" if response.success else "the map contradicts, or that node was never suspected"
        return response
