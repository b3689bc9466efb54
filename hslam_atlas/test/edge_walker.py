"""A robot at the level of events: answers goals with events, edge-maps and links as noisy as the real levels' are."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from corridor_floor import CorridorFloor, Point

from hslam_types.edge_map import EdgeMap, FrameLink
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind, NodeView
from hslam_types.se2 import SE2, Array, rotation, wrap

_SEGMENT_M = 2.0
_ONE_STOP_M = 0.7
"""Stops on the way nearer than this to one another count as one place."""


@dataclass(frozen=True)
class WalkNoise:
    """What goes wrong, standard deviations and probabilities."""

    node_m: float = 0.04
    bearing: float = math.radians(3.0)
    landmark_m: float = 0.03
    drift_per_50m: float = math.radians(0.75)
    slip_per_metre: float = 0.008
    degree_misread: float = 0.03
    node_missed: float = 0.01
    landmark_missed: float = 0.05
    clutter: float = 0.03
    odom_drift: float = math.radians(1.0)
    way_shut: float = 0.0
    """A way is taken for shut midway: a boundary point is announced where there is none."""
    walls_unheard: float = 0.0
    """A view's clearance is read three to ten times too large."""


@dataclass
class Step:
    """One step's inputs to the atlas."""

    stamp_ns: int
    events: tuple[GvgEvent, ...]
    edge_maps: tuple[EdgeMap, ...] = ()
    links: tuple[FrameLink, ...] = ()


@dataclass
class _Leg:
    """What is kept of the last traversal for the link: its frames and accumulated errors."""

    departure_in_world: SE2
    heading_error: float
    shift: Array
    phi: float
    traversal: int
    covariance: Array


class EdgeWalker:
    """Walks a floor."""

    def __init__(self, floor: CorridorFloor, start: int, rng: np.random.Generator, noise: WalkNoise) -> None:
        self.floor, self.rng, self.noise = floor, rng, noise
        self.node = start
        """The true node it is at; below zero where it stopped on the way."""
        self.path_length_m = 0.0
        self.true_node: dict[int, int] = {}
        """True node of every arrival, by event sequence."""
        self._ways = floor.leaving(start)
        self._place: Point = floor.nodes[start]
        self._stops: list[Point] = []
        self.losses = 0
        self._sequence = 0
        self._clock = 0
        self._odom_heading = 0.0
        self._view: NodeView | None = None
        self._real: list[int | None] = []
        self._centre: Point = (0.0, 0.0)
        self._bearings: list[float] = []
        self._leg: _Leg | None = None

    def follow(self, goal: GvgGoal) -> list[Step]:
        """Carry out a goal to its end."""
        if goal.kind is GoalKind.ACCESS:
            access = self._event(EventKind.ACCESS)
            self._look(None)
            self._leg = None
            arrival = self._arrival(-1, 3.0)
            return [Step(access.stamp_ns, (access,)), Step(arrival.stamp_ns, (arrival,))]
        assert goal.kind is GoalKind.TRACE
        return self._trace(goal.branch)

    def branch_towards(self, bearing: float) -> int:
        """Return the index of the branch seen nearest to a direction of the floor (rad)."""
        return min(range(len(self._bearings)), key=lambda i: abs(wrap(self._bearings[i] - bearing)))

    def bearing_of(self, branch: int) -> float:
        """Return the direction of a branch seen (rad), as this visit took it."""
        return self._bearings[branch]

    def true_edge(self) -> tuple[SE2, float]:
        """Return the last traversal's edge frame in the floor, from where it left through where it arrived, and length.

        The length (m) is the distance of the two.
        """
        assert self._leg is not None
        left = self._leg.departure_in_world
        dx, dy = self._centre[0] - left.x, self._centre[1] - left.y
        return SE2(left.x, left.y, math.atan2(dy, dx)), math.hypot(dx, dy)

    def turn_round(self, branch: int, arrived_by: float, reach_m: float, length_m: float) -> list[Step]:
        """Leave by a branch, turn ``reach_m`` on and be back, announced along the branch nearest to ``arrived_by``."""
        assert self._view is not None
        departure = self._event(EventKind.DEPARTURE, self._view, branch)
        links = self._links(departure, self._bearings[branch])
        frame = SE2(*self._centre, self._bearings[branch])
        away = frame.apply(reach_m, 0.0)
        self._look(arrived_by)
        along = self.branch_towards(arrived_by)
        path = _dense(np.array([(frame.x, frame.y), away, self._centre]))
        arrival = self._arrival(along, length_m)
        edge_map = self._map(frame, path, departure.sequence, arrival, self._bearings[along], length_m)
        return [
            Step(departure.stamp_ns, (departure,), (), links),
            Step(arrival.stamp_ns, (arrival,), (edge_map,)),
        ]

    def _trace(self, branch: int) -> list[Step]:
        assert self._view is not None
        departure = self._event(EventKind.DEPARTURE, self._view, branch)
        steps = [Step(departure.stamp_ns, (departure,), (), self._links(departure, self._bearings[branch]))]
        real = self._real[branch]
        ways = self._ways
        if real is None:  # an invented branch: the nearest real one, or lost
            if self.rng.random() < 0.5:
                lost = self._event(EventKind.LOST)
                self.losses += 1
                return [*steps, Step(lost.stamp_ns, (lost,))]
            towards = self._bearings[branch]
            real = min(range(len(ways)), key=lambda i: abs(wrap(ways[i][1] - towards)))
        frame = SE2(*self._centre, self._bearings[branch])
        _, _, line, there = ways[real]
        came_from = ways[real][0]
        if self.noise.way_shut and self.node >= 0 and self.rng.random() < self.noise.way_shut:
            full = self._stop_on(line, came_from)
            return [*steps, self._come(frame, full, departure)]
        full = list(line)
        while len(self.floor.leaving(there)) > 2 and self.rng.random() < self.noise.node_missed:
            heading = math.atan2(full[-1][1] - full[-2][1], full[-1][0] - full[-2][0])
            onward = [way for way in self.floor.leaving(there) if way[0] != came_from]
            way = min(onward, key=lambda w: abs(wrap(w[1] - heading)))
            full += list(way[2][1:])
            came_from, there = way[0], way[3]
        self.node, self._ways, self._place = there, self.floor.leaving(there), self.floor.nodes[there]
        return [*steps, self._come(frame, full, departure)]

    def _stop_on(self, line: tuple[Point, ...], corridor: int) -> list[Point]:
        """Stop somewhere on a way, from where only the way back is seen; return the line as far as there."""
        lengths = np.hypot(*np.diff(np.array(line), axis=0).T)
        left_m = float(lengths.sum() * self.rng.uniform(0.3, 0.9))
        full = [line[0]]
        for (x, y), (to_x, to_y), length in zip(line, line[1:], lengths.tolist(), strict=False):
            share = min(left_m / length, 1.0)
            full.append((x + share * (to_x - x), y + share * (to_y - y)))
            left_m -= length
            if left_m <= 0.0:
                break
        back = tuple(reversed(full))
        bearing = math.atan2(back[1][1] - back[0][1], back[1][0] - back[0][0])
        where = next((k for k, stop in enumerate(self._stops) if math.dist(stop, back[0]) < _ONE_STOP_M), None)
        if where is None:
            where = len(self._stops)
            self._stops.append(back[0])
        left = self.node
        self.node, self._ways, self._place = -1 - where, [(corridor, bearing, back, left)], back[0]
        return full

    def _come(self, frame: SE2, full: list[Point], departure: GvgEvent) -> Step:
        """Arrive where the robot now is, along a line that began at ``frame``."""
        arrived_by = math.atan2(full[-2][1] - full[-1][1], full[-2][0] - full[-1][0])
        self._look(arrived_by)
        path = _dense(np.array([(frame.x, frame.y), *full[1:-1], self._centre]))
        length = float(np.hypot(*np.diff(path, axis=0).T).sum())
        self.path_length_m += length
        along = min(
            (i for i, r in enumerate(self._real) if r is not None),
            key=lambda i: abs(wrap(self._bearings[i] - arrived_by)),
        )
        arrival = self._arrival(along, length)
        edge_map = self._map(frame, path, departure.sequence, arrival, self._bearings[along], length)
        return Step(arrival.stamp_ns, (arrival,), (edge_map,))

    def _look(self, arrived_by: float | None) -> None:
        """Make this visit's view of the node: scattered centre and bearings, perhaps a branch too many or too few."""
        noise, rng = self.noise, self.rng
        ways = self._ways
        x, y = self._place
        self._centre = (x + rng.normal(0.0, noise.node_m), y + rng.normal(0.0, noise.node_m))
        entries: list[tuple[float, int | None]] = [
            (wrap(w[1] + rng.normal(0.0, noise.bearing)), i) for i, w in enumerate(ways)
        ]
        if len(ways) == 3 and rng.random() < noise.degree_misread:
            free = max((w[1] + math.pi for w in ways), key=lambda b: min(abs(wrap(b - w[1])) for w in ways))
            entries.append((wrap(free), None))
        elif len(ways) == 4 and rng.random() < noise.degree_misread:
            hidden = [e for e in entries if arrived_by is None or abs(wrap(e[0] - arrived_by)) > 0.6]
            entries.remove(hidden[int(rng.integers(len(hidden)))])
        turned = sorted(entries, key=lambda e: wrap(e[0] + self._odom_heading))
        self._bearings = [b for b, _ in turned]
        self._real = [r for _, r in turned]
        kind = NodeKind.MEET_POINT if len(ways) > 1 else NodeKind.BOUNDARY_POINT
        clearance = 1.3 if len(ways) > 1 else 1.0
        if noise.walls_unheard and rng.random() < noise.walls_unheard:
            clearance *= rng.uniform(3.0, 10.0)
        self._odom_heading = wrap(self._odom_heading + rng.normal(0.0, 10.0 * noise.odom_drift))
        c = rotation(self._odom_heading) @ np.array(self._centre)
        self._view = NodeView(
            kind, float(c[0]), float(c[1]), clearance + rng.normal(0.0, 0.08),
            tuple(wrap(b + self._odom_heading) for b in self._bearings),
        )  # fmt: skip

    def _links(self, departure: GvgEvent, bearing: float) -> tuple[FrameLink, ...]:
        leg = self._leg
        if leg is None:
            return ()
        true = leg.departure_in_world.to(SE2(*self._centre, bearing))
        xy = rotation(-leg.phi) @ (np.array([true.x, true.y]) + leg.shift + self.rng.normal(0.0, 0.01, 2))
        heading = wrap(true.theta + leg.heading_error - leg.phi + self.rng.normal(0.0, math.radians(0.3)))
        return (FrameLink(leg.traversal, departure.sequence, SE2(float(xy[0]), float(xy[1]), heading), leg.covariance),)

    def _map(
        self, frame: SE2, path: Array, departure: int, arrival: GvgEvent, arrival_bearing: float, length: float
    ) -> EdgeMap:
        """Return the map a consistent filter would have made: errors drawn from the covariance it states."""
        noise, rng = self.noise, self.rng
        seen = self.floor.visible_along(path)
        seen = seen[rng.random(len(seen)) > noise.landmark_missed]
        world = self.floor.landmarks[seen]
        clutter = int(rng.binomial(len(seen), noise.clutter)) if len(seen) else 0
        if clutter:
            world = np.concatenate(
                (world, world[rng.integers(len(world), size=clutter)] + rng.normal(0, 1.0, (clutter, 2)))
            )
        points = np.concatenate((path[-1:], world))
        into = rotation(-frame.theta)
        points, local_path = (points - [frame.x, frame.y]) @ into.T, (path - [frame.x, frame.y]) @ into.T
        stations = local_path[:: max(int(_SEGMENT_M / 0.5), 1)]
        nearest = np.argmin(np.hypot(*(points[:, None] - local_path[None]).transpose(2, 0, 1)), axis=1)
        nearest[0] = len(local_path) - 1
        before = (np.arange(len(stations)) * max(int(_SEGMENT_M / 0.5), 1))[None, :] < nearest[:, None]
        lever = points[:, None] - stations[None]
        jacobian = np.zeros((2 * len(points), 3 * len(stations)))
        jacobian[0::2, 0::3] = np.where(before, -lever[..., 1], 0.0)
        jacobian[1::2, 0::3] = np.where(before, lever[..., 0], 0.0)
        jacobian[0::2, 1::3] = before
        jacobian[1::2, 2::3] = before
        step = np.tile(
            [noise.drift_per_50m * math.sqrt(_SEGMENT_M / 50.0), *[noise.slip_per_metre * math.sqrt(_SEGMENT_M)] * 2],
            len(stations),
        )
        drawn = rng.normal(0.0, 1.0, len(step)) * step
        own = np.full(2 * len(points), noise.landmark_m)
        covariance = jacobian @ np.diag(step**2) @ jacobian.T + np.diag(own**2)
        shift = (jacobian[:2] @ drawn).reshape(2)
        points += (jacobian @ drawn + rng.normal(0.0, 1.0, len(own)) * own).reshape(-1, 2)
        heading_error = float(drawn[0::3].sum())
        points, covariance, phi = _turned(points, covariance)
        spread = np.diag([0.02**2, 0.02**2, math.radians(0.3) ** 2 + float((step[0::3] ** 2).sum())])
        self._leg = _Leg(frame, heading_error, shift, phi, departure, spread)
        return EdgeMap(
            departure, arrival.sequence, float(points[0, 0]), points[1:], covariance,
            tuple(int(n) for n in rng.integers(4, 40, len(points) - 1)), wrap(-phi),
            wrap(arrival_bearing - frame.theta + heading_error - phi), SE2(float(points[0, 0]), 0.0, 0.0), length,
        )  # fmt: skip

    def _arrival(self, branch: int, length: float) -> GvgEvent:
        event = self._event(EventKind.ARRIVAL, self._view, branch, length)
        self.true_node[event.sequence] = self.node
        return event

    def _event(self, kind: EventKind, view: NodeView | None = None, branch: int = -1, length: float = 0.0) -> GvgEvent:
        self._clock += 10**9
        event = GvgEvent(self._sequence, self._clock, kind, view, branch, length)
        self._sequence += 1
        return event


def _dense(line: Array) -> Array:
    """Return points every half metre along a line."""
    parts = []
    for a, b in pairwise(line):
        count = max(int(math.dist(a, b) / 0.5), 1)
        parts.append(a + (b - a) * np.linspace(0.0, 1.0, count, endpoint=False)[:, None])
    return np.concatenate((*parts, line[-1:]))


def _turned(points: Array, covariance: Array) -> tuple[Array, Array, float]:
    """Turn so that the first point lies on x, as the filter does at arrival."""
    x, y = points[0].tolist()
    phi = math.atan2(y, x) if math.hypot(x, y) >= 0.5 else 0.0
    turned = points @ rotation(phi)
    jacobian = np.kron(np.eye(len(points)), rotation(-phi))
    if phi:
        by_angle = np.column_stack((turned[:, 1], -turned[:, 0])).reshape(-1)
        jacobian[:, :2] += np.outer(by_angle, np.array([-y, x]) / (x * x + y * y))
    jacobian[1] = 0.0
    turned[0, 1] = 0.0
    return turned, jacobian @ covariance @ jacobian.T, phi
