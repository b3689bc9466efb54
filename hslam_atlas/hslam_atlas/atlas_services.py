"""What can be asked of the atlas as ROS services: a copy, another atlas in its place, which node the robot is at."""

from collections.abc import Callable
from pathlib import Path

from hslam_msgs.srv import AtlasFile, IdentifyNode, NamePlace
from rclpy.node import Node

from hslam_atlas.atlas_in_use import AtlasInUse
from hslam_atlas.destinations import destination_from_msg
from hslam_atlas.errors import AtlasError, StoreError
from hslam_atlas.missions.destination import DestinationError
from hslam_atlas.places import check_name
from hslam_types.se2 import SE2


class AtlasServices:
    """Answers; what cannot be done is refused with the reason, and changes nothing."""

    def __init__(
        self, node: Node, atlas: AtlasInUse, loaded: Callable[[], None], base_in_map: Callable[[], SE2 | None]
    ) -> None:
        """Offer the services on ``node``; ``loaded`` is called once another atlas is in use.

        ``base_in_map`` gives where the robot is, None while that is in doubt.
        """
        self._atlas, self._loaded, self._base_in_map = atlas, loaded, base_in_map
        node.create_service(AtlasFile, "~/save", self._on_save)
        node.create_service(AtlasFile, "~/load", self._on_load)
        node.create_service(IdentifyNode, "~/identify", self._on_identify)
        node.create_service(NamePlace, "~/name_place", self._on_name_place)

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

    def _on_name_place(self, request: NamePlace.Request, response: NamePlace.Response) -> NamePlace.Response:
        server, base = self._atlas.server, self._base_in_map()
        try:
            places, name = server.store.places(), check_name(request.name)
            if not request.forget:
                here = None if base is None else (base.x, base.y)
                places[name] = destination_from_msg(request.destination, server.state, places, here)
            elif places.pop(name, None) is None:
                raise DestinationError(f"no place is called '{name}'")
            server.store.save_places(places)
            told = "forgotten" if request.forget else str(places[name])
            response.success, response.message = True, f"{name}: {told}"
        except AtlasError as error:
            response.success, response.message = False, str(error)
        return response
