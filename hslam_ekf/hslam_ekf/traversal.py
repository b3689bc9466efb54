"""One traversal: a filter from departure to arrival, the edge-map it ends in, and the link to the next one."""

import math
from copy import deepcopy

import numpy as np

from hslam_ekf.association import associate
from hslam_ekf.config import EkfConfig
from hslam_ekf.edge_frame import turn_to_terminal
from hslam_ekf.errors import EkfError
from hslam_ekf.landmark_evidence import LandmarkEvidence
from hslam_ekf.landmark_filter import LandmarkFilter
from hslam_ekf.motion_model import ROBOT
from hslam_ekf.range_bearing import observe, relative_point
from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GvgEvent, NodeKind, NodeView
from hslam_types.se2 import SE2, Array, compose_jacobians, wrap
from hslam_types.sensing import LandmarkView

_OUT_OF_SIGHT_M = 0.5
"""Landmarks expected this much beyond the sensor's range cannot be what was seen."""
_INSIDE = 2.0
"""By how many deviations of its bearing a landmark must be inside a field of view for its absence to count."""


class Traversal:
    """Tracks robot and landmarks in the departure frame, then, once arrived, in the edge frame."""

    def __init__(
        self, sequence: int, base_in_odom: SE2, base_in_frame: SE2, bias: float, bias_variance: float, config: EkfConfig
    ) -> None:
        """Begin at event ``sequence`` with the robot's exact pose in the frame and the rotation bias as known."""
        self.sequence = sequence
        self.arrived = False
        self.filter = LandmarkFilter(base_in_frame, bias, bias_variance, config)
        self._evidence = LandmarkEvidence(config)
        self._base_in_odom = base_in_odom
        self._config = config

    def advance(self, base_in_odom: SE2, noise: Array | None = None) -> None:
        """Predict to a new odometry pose, by the step's own covariance if it has one; standing still costs nothing."""
        if base_in_odom != self._base_in_odom:
            self.filter.predict(self._base_in_odom.to(base_in_odom), noise)
            self._base_in_odom = base_in_odom

    def look(self, view: LandmarkView) -> None:
        """Associate a look's sightings, correct by the accepted ones, start landmarks from the strange ones."""
        readings = np.array(view.sightings, dtype=np.float64).reshape(-1, 4)
        sightings, noise = readings[:, :2], readings[:, 2:] ** 2
        distance = observe(self.filter.mean[:3], self.filter.landmarks)[:, 0]
        reach_m = view.range_max_m + math.hypot(view.field.sensor_x, view.field.sensor_y)
        expected = self.filter.expect(np.flatnonzero(distance < reach_m + _OUT_OF_SIGHT_M))
        verdict = associate(
            sightings, noise, expected.sightings, expected.spread,
            accept_gate=self._config.accept_gate, new_gate=self._config.new_gate,
        )  # fmt: skip
        self.filter.correct(expected, verdict.landmarks, sightings[verdict.sightings], noise[verdict.sightings])
        margins = _INSIDE * np.sqrt(expected.spread[:, 1, 1])
        inside = view.field.shows(expected.sightings, view.range_max_m, margins)
        self._evidence.count(
            expected.landmarks[verdict.landmarks], expected.landmarks[inside], expected.sightings[inside], sightings
        )
        if len(verdict.fresh):
            self.filter.augment(sightings[verdict.fresh], noise[verdict.fresh])
            self._evidence.add(len(verdict.fresh))
        credible = self._evidence.credible()
        if len(credible) < len(self._evidence.sightings):
            self.filter.keep(credible)
            self._evidence.keep(credible)

    def arrive(self, event: GvgEvent) -> EdgeMap:
        """Close the edge-map at the terminal the event announces and go on in its edge frame.

        The terminal joins the state as a point seen from the robot with the homing error, the frame turns
        through it, and the map is what remains when robot and bias are marginalised out.
        """
        if event.node is None or event.branch >= event.node.degree or event.node.degree == 0:
            raise EkfError(f"arrival event {event.sequence} comes without a node or names no branch of it")
        terminal, by_pose = relative_point(
            self.filter.mean[:3], *self._base_in_odom.inverse().apply(event.node.x_in_odom, event.node.y_in_odom)
        )
        covariance = self.filter.covariance
        cross = by_pose @ covariance[:3]
        own = cross[:, :3] @ by_pose.T + self._config.homing_m**2 * np.eye(2)
        mean, joint, phi = turn_to_terminal(
            np.concatenate((self.filter.mean, terminal)),
            np.block([[covariance, cross.T], [cross, own]]),
        )
        self.filter.replace(mean[:-2], joint[:-2, :-2])
        self.arrived = True
        base_in_edge = self.filter.pose()[0]
        bearing_in_odom = event.node.reference_bearing(event.branch)
        kept = self._evidence.lasting()
        rows = np.concatenate((ROBOT + 2 * kept[:, None] + np.arange(2), [[len(mean) - 2, len(mean) - 1]]))
        rows = np.roll(rows, 1, axis=0).reshape(-1)  # the terminal first
        return EdgeMap(
            traversal=self.sequence,
            arrival=event.sequence,
            terminal_x=float(mean[-2]),
            landmarks=self.filter.landmarks[kept],
            covariance=joint[np.ix_(rows, rows)],
            sightings=tuple(self._evidence.sightings[kept].tolist()),
            departure_heading=-phi,
            arrival_heading=wrap(bearing_in_odom - self._base_in_odom.theta + base_in_edge.theta),
            robot_at_arrival=base_in_edge,
            path_length_m=event.path_length_m,
        )

    def so_far(self, arrival: GvgEvent | None = None) -> EdgeMap:
        """Return the map as if the way ended where the robot is, or at the node of an arrival; the filter goes on.

        Without an arrival, ``arrival_heading`` is the robot's and ``path_length_m`` is 0.
        """
        if arrival is None:
            x, y, heading = self._base_in_odom
            place = NodeView(NodeKind.BOUNDARY_POINT, x, y, 0.0, (heading,))
            arrival = GvgEvent(self.sequence, 0, EventKind.ARRIVAL, place, 0)
        return deepcopy(self).arrive(arrival)

    def link(self, departure: GvgEvent, departure_in_base: SE2) -> FrameLink:
        """Tell where the frame that starts at ``departure`` sits in this edge's frame."""
        base_in_edge, covariance = self.filter.pose()
        by_base, _ = compose_jacobians(base_in_edge, departure_in_base)
        spread: Array = by_base @ covariance @ by_base.T
        return FrameLink(
            traversal=self.sequence,
            departure=departure.sequence,
            departure_in_edge=base_in_edge @ departure_in_base,
            covariance=0.5 * (spread + spread.T),
        )
