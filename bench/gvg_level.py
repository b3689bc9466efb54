"""Measures the GVG level alone: explores floors with the identity of every node given, and scores what was found.

No filter and no atlas take part: whether a node was seen before is told from the truth, so that what is missed here was
missed by the local map, the local graph or the driving.

hslam-env python bench/gvg_level.py MAPS/*.yaml --seeds 1-5 --sensor ring
"""

import argparse
import json
import math
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import networkx as nx
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from hslam_gvg.config import GvgConfig
from hslam_gvg.follow_config import RingFollowConfig
from hslam_gvg.graph_follower import GraphFollower
from hslam_gvg.level import GvgLevel
from hslam_gvg.local_graph.graph_config import RingGraphConfig
from hslam_gvg.ranging.sonar_map_config import SonarMapConfig
from hslam_gvg.server import GvgServer
from hslam_gvg.states import GvgError
from hslam_report.explored import ExploredEdge, ExploredGraph, ExploredNode, Visit, true_meet_point
from hslam_report.score import score_graph
from hslam_sim.lidar_configuration import LidarConfiguration
from hslam_sim.simulation import SimStep, Simulation, SimulationConfiguration
from hslam_sim.truth import true_gvg
from hslam_sim.worlds import load_world
from hslam_types.errors import HslamError
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal, NodeKind
from hslam_types.se2 import wrap
from hslam_types.sensing import Velocity

SAME_BRANCH = math.radians(35.0)
DEPARTURE_COST_M = 6.0
"""What stopping at a node costs, in metres of driving."""
MOST_DETOURS = 6
"""So many drives in a row may only hope for a way to what is left."""
TRIES = 2
"""So often a branch that leads nowhere is tried."""


@dataclass
class Branch:
    """One branch of a node, by its true bearing (rad, map)."""

    bearing: float
    edge: int | None = None
    seen: int = 1
    missed: int = 0
    failed: int = 0

    @property
    def imagined(self) -> bool:
        """Whether it is given up."""
        doubted = self.missed >= 2 and self.missed > self.seen
        return self.edge is None and (doubted or self.failed >= TRIES)

    @property
    def is_open(self) -> bool:
        """Whether it is still to be driven."""
        return self.edge is None and not self.imagined


@dataclass
class Node:
    """One true place."""

    kind: NodeKind
    x: float
    y: float
    clearance_m: float
    branches: list[Branch] = field(default_factory=list)
    visits: list[Visit] = field(default_factory=list)


class GivenIdentity:
    """Drives to the nearest unexplored branch; knows from the truth which node it is at."""

    def __init__(self) -> None:
        """Begin with nothing explored."""
        self.nodes: list[Node] = []
        self.edges: list[tuple[int, int, int, int, float]] = []
        self._links: dict[tuple[int, int], tuple[int, float]] = {}
        """Where the last drive by a branch (node, branch) ended, and its length (m)."""
        self._here: tuple[int, list[int]] | None = None
        self._underway: tuple[int, int] | None = None
        self._waiting = True
        self._detours = 0
        """Drives in a row that only hope to see more."""
        self.done = False

    def step(self, events: tuple[GvgEvent, ...], base: SimStep) -> GvgGoal | None:
        """Take what was announced; return the next goal, if one is due."""
        for event in events:
            if event.kind is EventKind.DEPARTURE and self._here is not None:
                self._underway = self._here[0], self._here[1][event.branch]
                self._here = None
            elif event.kind is EventKind.LOST:
                self._fail()
                self._here, self._waiting = None, True
            elif event.kind is EventKind.ARRIVAL:
                self._arrive(event, base)
                self._waiting = True
        if not self._waiting:
            return None
        self._waiting = False
        if self._here is None:
            return GvgGoal(GoalKind.ACCESS)
        branch = self._next()
        self.done = branch is None
        return GvgGoal(GoalKind.STOP) if branch is None else GvgGoal(GoalKind.TRACE, branch=self._here[1].index(branch))

    def refused(self) -> None:
        """Be told that a goal was not taken."""
        self._here, self._waiting = None, True

    def left(self) -> int:
        """Return how many branches are still to be driven."""
        return sum(branch.is_open for node in self.nodes for branch in node.branches)

    def explored(self) -> ExploredGraph:
        """Return the graph as the scores want it."""
        kept = [
            sorted((b for b in range(len(node.branches)) if not node.branches[b].imagined), key=self._bearing(node))
            for node in self.nodes
        ]
        nodes = tuple(
            ExploredNode(i, self._kind(node, kept[i]), len(kept[i]), node.clearance_m, tuple(node.visits))
            for i, node in enumerate(self.nodes)
        )
        edges = tuple(ExploredEdge(u, v, kept[u].index(a), kept[v].index(b), m) for u, a, v, b, m in self.edges)
        return ExploredGraph(nodes, edges)

    @staticmethod
    def _kind(node: Node, kept: list[int]) -> NodeKind:
        """Return what a node is once those of its branches that lead nowhere are given up."""
        return NodeKind.BOUNDARY_POINT if len(kept) == 1 else node.kind

    @staticmethod
    def _bearing(node: Node) -> Any:
        return lambda b: node.branches[b].bearing

    def _arrive(self, event: GvgEvent, base: SimStep) -> None:
        view = event.node
        assert view is not None
        x, y = true_meet_point(base.truth, base.odom.base_in_odom, view)
        turn = wrap(base.truth.theta - base.odom.base_in_odom.theta)
        here = self._identify(view.kind, x, y, view.clearance_m)
        node = self.nodes[here]
        keys = self._keys(node, [wrap(bearing + turn) for bearing in view.bearings_in_odom])
        node.visits.append(Visit(event.sequence, x, y))
        if self._underway is not None:
            self._drove(here, keys[event.branch] if event.branch >= 0 else None, event.path_length_m)
        self._here = here, keys

    def _identify(self, kind: NodeKind, x: float, y: float, clearance_m: float) -> int:
        found = []
        for i, node in enumerate(self.nodes):
            larger = max(clearance_m, node.clearance_m)
            gate_m = max(0.5, 0.55 * larger) if kind is NodeKind.MEET_POINT else max(1.0, 0.8 * larger)
            if kind is node.kind and math.hypot(node.x - x, node.y - y) < gate_m:
                found.append((math.hypot(node.x - x, node.y - y), i))
        if found:
            return min(found)[1]
        self.nodes.append(Node(kind, x, y, clearance_m))
        return len(self.nodes) - 1

    def _keys(self, node: Node, bearings: list[float]) -> list[int]:
        """Return which branch of the node each bearing seen is; new ones are added."""
        known = range(len(node.branches))
        pairs = sorted((abs(wrap(b - node.branches[k].bearing)), j, k) for j, b in enumerate(bearings) for k in known)
        keys: dict[int, int] = {}
        for apart, j, k in pairs:
            if apart <= SAME_BRANCH and j not in keys and k not in keys.values():
                keys[j] = k
        for k in known:
            node.branches[k].seen += k in keys.values()
            node.branches[k].missed += k not in keys.values()
        for j, bearing in enumerate(bearings):
            if j not in keys:
                node.branches.append(Branch(bearing))
                keys[j] = len(node.branches) - 1
        return [keys[j] for j in range(len(bearings))]

    def _drove(self, to: int, by: int | None, length_m: float) -> None:
        assert self._underway is not None
        node, key = self._underway
        back = to == node and (by == key or length_m < 1.5 * self.nodes[node].clearance_m)
        if back or by is None:
            self._fail()
            if not back:
                self._links[node, key] = to, length_m
        else:
            self._links[node, key] = to, length_m
            self._links.setdefault((to, by), (node, length_m))
            if self.nodes[node].branches[key].edge is None:
                self.edges.append((node, key, to, by, length_m))
                self.nodes[node].branches[key].edge = len(self.edges) - 1
            if self.nodes[to].branches[by].edge is None:
                self.nodes[to].branches[by].edge = len(self.edges) - 1
        self._underway = None

    def _fail(self) -> None:
        if self._underway is not None:
            self.nodes[self._underway[0]].branches[self._underway[1]].failed += 1
        self._underway = None

    def _next(self) -> int | None:
        """Return the branch of the node stood at that leads to the nearest branch still to be driven."""
        assert self._here is not None
        here, keys = self._here
        fresh = [key for key in keys if self.nodes[here].branches[key].is_open]
        if fresh:
            self._detours = 0
            return fresh[0]
        graph: nx.MultiDiGraph[int] = nx.MultiDiGraph()
        graph.add_nodes_from(range(len(self.nodes)))
        for (u, branch), (v, length_m) in self._links.items():
            if u != here or branch in keys:
                graph.add_edge(u, v, by=branch, weight=length_m + DEPARTURE_COST_M)
        away = nx.single_source_dijkstra_path_length(graph, here)
        paths = nx.single_source_dijkstra_path(graph, here)
        goals = [i for i in away if i != here and any(branch.is_open for branch in self.nodes[i].branches)]
        if goals:
            first = paths[min(goals, key=lambda i: (away[i], i))][1]
            return int(min(graph.get_edge_data(here, first).values(), key=lambda way: way["weight"])["by"])
        # What leads on may not have shown on this visit: from a neighbour it may.
        wanted = self.left() > 0 and self._detours < MOST_DETOURS
        known = [key for key in keys if (here, key) in self._links]
        self._detours += 1
        return known[self._detours % len(known)] if wanted and known else None


def level_of(sensor: str) -> GvgLevel:
    """Return the level for a sensor: `scan`, `ring` along the local graph, or `laws`, the ring by control laws."""
    if sensor == "laws":
        return GvgServer(GvgConfig())
    if sensor == "ring":
        return GraphFollower(RingFollowConfig(), SonarMapConfig(), RingGraphConfig())
    return GraphFollower()


def explore(world_name: str, seed: int, beams: int, reach_m: float, limit_s: float, sensor: str) -> dict[str, Any]:
    """Explore one floor with one seed; return what the table shows."""
    world = load_world(world_name, landmark_seed=seed)
    config = SimulationConfiguration()
    if sensor == "scan":
        config = SimulationConfiguration(lidar=LidarConfiguration(beams=beams, range_max_m=reach_m))
    simulation, gvg, explorer = Simulation(world, config, seed), level_of(sensor), GivenIdentity()
    command: Velocity | None = None
    driven_m, spent_s, steps, last = 0.0, 0.0, 0, world.start
    while not explorer.done and simulation.stamp_ns < limit_s * 1e9:
        base = simulation.step(command)
        began = time.process_time()
        out = gvg.step(base.odom, base.scan if sensor == "scan" else base.sonar)
        spent_s += time.process_time() - began
        steps += 1
        goal = explorer.step(out.events, base)
        if goal is not None:
            try:
                gvg.start(goal, base.stamp_ns)
            except GvgError:
                explorer.refused()
        command = out.command
        driven_m += math.hypot(base.truth.x - last.x, base.truth.y - last.y)
        last = base.truth
    score = score_graph(explorer.explored(), true_gvg(world))
    return {
        "world": world.name,
        "seed": seed,
        "ended": explorer.done,
        "left": explorer.left(),
        "nodes": score.nodes,
        "true": score.true_core_nodes,
        "node P": score.node_precision,
        "node R": score.node_recall,
        "edge P": score.edge_precision,
        "edge R": score.edge_recall,
        "contacts": base.collisions,
        "driven m": driven_m,
        "simulated s": simulation.stamp_ns * 1e-9,
        "ms a step": 1e3 * spent_s / steps,
    }


def _explored(job: tuple[str, int, int, float, float, str]) -> dict[str, Any]:
    try:
        return explore(*job)
    except HslamError as error:
        return {"world": Path(job[0]).stem, "seed": job[1], "failed": str(error)}


def main() -> None:
    """Parse the command line and print the table; exit status 1 when a run failed or touched a wall."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="+")
    parser.add_argument("--sensor", default="scan", choices=("scan", "ring", "laws"))
    parser.add_argument("--seeds", default="1", help="one seed or a range, such as 1-5")
    parser.add_argument("--beams", type=int, default=360)
    parser.add_argument("--reach", type=float, default=8.0, help="of the lidar, m")
    parser.add_argument("--time-limit", type=float, default=20_000.0, help="simulated seconds a run may take")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, help="file to write the rows to")
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    jobs = [
        (w, seed, options.beams, options.reach, options.time_limit, options.sensor)
        for w in options.worlds
        for seed in seeds
    ]
    with Progress(console=Console(stderr=True)) as progress, ProcessPoolExecutor(options.jobs) as pool:
        rows = list(progress.track(pool.map(_explored, jobs), len(jobs), description="exploring"))
    good = [row for row in rows if "failed" not in row]
    table = Table(*(good[0] if good else rows[0]))
    for row in rows:
        table.add_row(*(f"{value:.2f}" if isinstance(value, float) else str(value) for value in row.values()))
    Console(width=170).print(table)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))
    sys.exit(len(good) < len(rows) or any(row["contacts"] for row in good))


if __name__ == "__main__":
    main()
