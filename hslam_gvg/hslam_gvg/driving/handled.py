"""Nodes that are not to be noticed again for a while: the one just left, and those looked for in vain."""

import math

from hslam_voronoi.branch_graph import Hub


class Handled:
    """Places with a radius, each until so much travel."""

    def __init__(self) -> None:
        """Begin with none."""
        self._places: list[tuple[float, float, float, float]] = []

    def clear(self) -> None:
        """Forget all."""
        self._places.clear()

    def add(self, x: float, y: float, radius_m: float, until_m: float) -> None:
        """Hide nodes about a place until the odometer reads ``until_m``."""
        self._places.append((x, y, radius_m, until_m))

    def hides(self, hub: Hub, travel_m: float) -> bool:
        """Whether a node is hidden when the odometer reads ``travel_m``; a roomy node reaches half as far again."""
        self._places = [place for place in self._places if place[3] > travel_m]
        return any(
            math.hypot(hub.x - x, hub.y - y) < max(radius, min(hub.clearance, 1.5 * radius))
            for x, y, radius, _ in self._places
        )
