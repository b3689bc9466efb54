"""The EKF level as one object: odometry, looks and GVG events in, edge-maps and links out."""

import math
from dataclasses import dataclass

from hslam_ekf.config import EkfConfig
from hslam_ekf.errors import EkfError
from hslam_ekf.innovation_check import InnovationCheck
from hslam_ekf.odometry_noise import OdometryNoise
from hslam_ekf.traversal import Traversal
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent
from hslam_types.se2 import SE2, Array
from hslam_types.sensing import LandmarkView, OdometrySample

_BIAS_FLOOR = math.radians(0.05)
"""The rotation bias carried from edge to edge is trusted to this (rad/m) at best: floors and loads differ."""


@dataclass(frozen=True, slots=True, eq=False)
class EkfOutput:
    """What one step brought."""

    edge_maps: tuple[EdgeMap, ...] = ()
    links: tuple[FrameLink, ...] = ()
    traversal: int = -1
    """Sequence of the event that began the frame of ``base_in_edge``; -1 without one."""
    arrived: bool = False
    """Whether that frame is the turned edge frame of a published map, not yet the departure's."""
    base_in_edge: SE2 | None = None
    """Pose of base_link in the traversal's frame, None before the first access or departure and when lost."""
    covariance: Array | None = None
    """Covariance of ``base_in_edge``, 3 x 3."""


class EkfServer:
    """Runs one filter at a time: begun by a departure, closed by an arrival, kept until the next departure."""

    def __init__(self, config: EkfConfig | None = None) -> None:
        """Start without a traversal."""
        self._config = config or EkfConfig()
        self._bias = 0.0
        self._bias_variance = self._config.turn_bias_per_metre**2
        self._partial = False
        self._last: OdometrySample | None = None
        self.traversal: Traversal | None = None
        """The traversal under way, for display."""
        self.noise = OdometryNoise()
        """How the last step was weighed."""
        self.innovations = InnovationCheck()
        """Whether the stated noise holds."""

    def step(self, odom: OdometrySample, view: LandmarkView | None, events: tuple[GvgEvent, ...]) -> EkfOutput:
        """Take one cycle: predict, correct by the look, then act on the events emitted at this stamp.

        A look between two cycles is taken where the odometry puts the robot then; one older than the last cycle
        is left out.  A look at a departure's stamp goes to the traversal that ends there, and to no other: no
        measurement is used twice.  Raises EkfError if an event lacks what its kind must have.
        """
        if self.traversal is not None:
            self._track(self.traversal, odom, view)
        self._last = odom
        edge_maps: list[EdgeMap] = []
        links: list[FrameLink] = []
        for event in events:
            if event.kind is EventKind.ACCESS:
                self._begin(event, odom.base_in_odom, SE2())
            elif event.kind is EventKind.DEPARTURE:
                departure_in_base = _departure_in_base(event, odom.base_in_odom)
                if self.traversal is not None and self.traversal.arrived:
                    links.append(self.traversal.link(event, departure_in_base))
                self._begin(event, odom.base_in_odom, departure_in_base.inverse())
            elif event.kind is EventKind.ARRIVAL:
                edge_maps.extend(self._arrive(event))
            else:
                self.traversal = None
        return self._output(tuple(edge_maps), tuple(links))

    def so_far(self, arrival: GvgEvent | None = None) -> EdgeMap | None:
        """Return the map of the traversal under way as `Traversal.so_far` does; None without one, or past its end.

        A traversal that began at an access point ends without a map: what it saw is asked for here.
        """
        if self.traversal is None or self.traversal.arrived:
            return None
        return self.traversal.so_far(arrival)

    def _track(self, traversal: Traversal, odom: OdometrySample, view: LandmarkView | None) -> None:
        """Bring a traversal to the cycle's odometry, correcting it by the look on the way."""
        noise = self._step_noise(odom)
        if view is not None and self._last is not None and view.stamp_ns > self._last.stamp_ns:
            share = (view.stamp_ns - self._last.stamp_ns) / (odom.stamp_ns - self._last.stamp_ns)
            if share < 1.0:
                traversal.advance(_between(self._last, odom, share), None if noise is None else share * noise)
                noise = None if noise is None else (1.0 - share) * noise
            else:
                traversal.advance(odom.base_in_odom, noise)
            traversal.look(view)
            self.innovations.take(*traversal.filter.nis)
        traversal.advance(odom.base_in_odom, noise)

    def _step_noise(self, odom: OdometrySample) -> Array | None:
        """Return what the odometry says of its step; None where the constants hold, and where it stands still."""
        moved = self._last is not None and odom.base_in_odom != self._last.base_in_odom
        if self._last is None or not moved or not self._config.odometry_covariances:
            return None
        return self.noise.of_step(self._last, odom)

    def _begin(self, event: GvgEvent, base_in_odom: SE2, base_in_frame: SE2) -> None:
        """Start a traversal; only the rotation bias, a property of the base, is carried over."""
        if self.traversal is not None:
            self._bias = float(self.traversal.filter.mean[3])
            known = float(self.traversal.filter.covariance[3, 3])
            self._bias_variance = max(known, min(_BIAS_FLOOR, self._config.turn_bias_per_metre) ** 2)
        self._partial = event.kind is EventKind.ACCESS
        self.traversal = Traversal(
            event.sequence, base_in_odom, base_in_frame, self._bias, self._bias_variance, self._config
        )

    def _arrive(self, event: GvgEvent) -> tuple[EdgeMap, ...]:
        """Close the traversal's map; the way from an access point to the first node has no origin, so no map."""
        if self.traversal is None or self.traversal.arrived or self._partial:
            return ()
        return (self.traversal.arrive(event),)

    def _output(self, edge_maps: tuple[EdgeMap, ...], links: tuple[FrameLink, ...]) -> EkfOutput:
        """Join the step's products with the pose after it."""
        if self.traversal is None:
            return EkfOutput(edge_maps, links)
        pose, covariance = self.traversal.filter.pose()
        return EkfOutput(edge_maps, links, self.traversal.sequence, self.traversal.arrived, pose, covariance)


def _between(before: OdometrySample, after: OdometrySample, share: float) -> SE2:
    """Return the odometry pose between two samples, at a ``share`` of the time from one to the other."""
    step = before.base_in_odom.to(after.base_in_odom)
    return before.base_in_odom @ SE2(share * step.x, share * step.y, share * step.theta)


def _departure_in_base(event: GvgEvent, base_in_odom: SE2) -> SE2:
    """Return the departure frame (at the node, facing the branch) seen from base_link."""
    node = event.node
    if node is None or not 0 <= event.branch < node.degree:
        raise EkfError(f"departure event {event.sequence} names no branch of a node")
    return base_in_odom.to(SE2(node.x_in_odom, node.y_in_odom, node.bearings_in_odom[event.branch]))
