"""A run in one process: the servers that the nodes wrap, called in the order that lock-step imposes.

Gives the same atlas, bit for bit, as separate processes, and is several times faster.
"""

import math
import resource
from collections.abc import Callable
from dataclasses import replace

from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

from hslam_atlas.atlas_messages import atlas_to_msg
from hslam_atlas.config import AtlasConfig
from hslam_atlas.missions.mission import Sense
from hslam_atlas.picture import node_poses
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_bags.recorder import Recorder
from hslam_bringup.progress import Snapshot
from hslam_bringup.run_options import SCANNED, RunOptions
from hslam_bringup.run_record import RunRecord
from hslam_bringup.run_report import RunEnd
from hslam_bringup.simulated_robot import simulation_configuration
from hslam_ekf.config import EkfConfig
from hslam_ekf.server import EkfServer
from hslam_gvg.level import SCAN, GvgLevel, SourceConfig, level_from_mapping
from hslam_gvg.states import GvgError, GvgState
from hslam_landmarks.config import ScannerConfig
from hslam_landmarks.scan_landmarks import ScanLandmarks, lookout_from_mapping
from hslam_ros import conversions
from hslam_ros.scan_conversion import scan_from_msg, scan_to_msg
from hslam_ros.stamps import NS_PER_S
from hslam_sim import sim_messages
from hslam_sim.simulation import SimStep, Simulation
from hslam_sim.worlds import load_world
from hslam_types.sensing import LandmarkView, RangeScan, SonarSweep, Velocity

_SHOW_EVERY = 100
"""Steps between two looks at the run."""


class InProcessRun:
    """The robot, its world and the three levels, stepped together and recorded."""

    def __init__(
        self,
        simulation: Simulation,
        level: tuple[GvgLevel, SourceConfig],
        ekf: EkfServer,
        atlas: AtlasServer,
        record: RunRecord,
        lookout: tuple[ScanLandmarks, ScannerConfig] | None = None,
    ) -> None:
        """Take the parts as they are; the first step sends no command. A ``lookout`` finds the landmarks in scans."""
        self.simulation, self.ekf, self.atlas, self.record = simulation, ekf, atlas, record
        self.gvg, self._source = level
        self._lookout = lookout
        self.finished = self._explored = False
        self.path_length_m = 0.0
        self._command: Velocity | None = None
        self._last_xy: tuple[float, float] | None = None
        self._bumped: bool | None = None

    def step(self) -> None:
        """One cycle: sense, follow the GVG, filter, map and decide; the answer goes into the next cycle."""
        base = self.simulation.step(self._command)
        stamp_ns, put = base.stamp_ns, self.record.put
        odom_msg = conversions.odometry_to_msg(base.odom)
        odom = conversions.odometry_from_msg(odom_msg)  # the bits that a node would receive
        put("/odom", odom_msg, stamp_ns)
        put("/sonar", conversions.sonar_to_msg(base.sonar), stamp_ns)
        put("/ground_truth", sim_messages.truth_to_msg(base), stamp_ns)
        scan_msg = None if base.scan is None else scan_to_msg(base.scan)
        if scan_msg is not None:
            put("/scan", scan_msg, stamp_ns)
        view = base.landmarks if self._lookout is None else self._spotted(scan_msg)
        if view is not None:
            put("/landmarks", conversions.landmarks_to_msg(view), stamp_ns)
        if base.bumped is not self._bumped:
            self._bumped = base.bumped
            put("/bumper", Bool(data=base.bumped), stamp_ns)

        driven = self.gvg.step(odom, self._heard(base, scan_msg))
        mapped = self.ekf.step(odom, view, driven.events)
        sense = Sense(
            odom.base_in_odom,
            mapped.traversal,
            mapped.base_in_edge,
            self.ekf.so_far,
            self.gvg.room_m if self.atlas.dispatch.locator is not None else math.inf,
            driven.state is GvgState.IDLE,
        )
        decided = self.atlas.step(driven.events, mapped.edge_maps, mapped.links, sense)
        if decided.goal is not None:
            try:
                self.gvg.start(decided.goal, stamp_ns)
            except GvgError:  # as the node is told by the action server
                self.atlas.refused()
        self._command = driven.command
        self.finished, self._explored = self._explored, decided.finished  # the cycle under way meanwhile is the last

        put("/cmd_vel", conversions.velocity_to_msg(driven.command, stamp_ns), stamp_ns)
        for event in driven.events:
            put("/gvg/events", conversions.event_to_msg(event), stamp_ns)
        for edge_map in mapped.edge_maps:
            put("/ekf/edge_maps", conversions.edge_map_to_msg(edge_map, stamp_ns), stamp_ns)
        for link in mapped.links:
            put("/ekf/frame_links", conversions.link_to_msg(link, stamp_ns), stamp_ns)
        if decided.changed:
            put("/atlas/atlas", atlas_to_msg(self.atlas, node_poses(self.atlas.state.graph), stamp_ns), stamp_ns)
        here = odom.base_in_odom[:2]
        self.path_length_m += math.dist(self._last_xy or here, here)
        self._last_xy = here

    def _spotted(self, scan_msg: LaserScan | None) -> LandmarkView | None:
        """Return the look that the lookout makes of a scan."""
        if self._lookout is None or scan_msg is None:
            return None
        landmarks, scanner = self._lookout
        return landmarks.hear(scan_from_msg(scan_msg, scanner.scanner_in_base))

    def _heard(self, base: SimStep, scan_msg: LaserScan | None) -> SonarSweep | RangeScan | None:
        """Return what the GVG level hears of the step, in the bits that a node would receive."""
        if self._source.source != SCAN:
            return base.sonar
        return None if scan_msg is None else scan_from_msg(scan_msg, self._source.scanner_in_base)

    def snapshot(self) -> Snapshot:
        """Return where the run stands."""
        graph = self.atlas.state.graph
        sim_time_s = self.simulation.stamp_ns / NS_PER_S
        return Snapshot(sim_time_s, len(graph.nodes), len(graph.edges), self.atlas.unexplored, self.path_length_m)


def run_in_process(options: RunOptions, show: Callable[[Snapshot], None]) -> RunEnd:
    """Explore in this process until nothing that is left can be reached or the time limit is reached.

    However it ends, bag and atlas are closed whole.
    """
    with Recorder(options.bag) as recorder, AtlasStore(options.atlas) as store:
        run = InProcessRun(
            _simulation(options),
            level_from_mapping(options.node_settings("gvg")),
            EkfServer(EkfConfig.from_mapping(options.node_settings("ekf"))),
            AtlasServer(AtlasConfig.from_mapping({"mission": "explore"} | options.node_settings("atlas")), store),
            RunRecord(recorder),
            lookout_from_mapping(options.node_settings("scan_landmarks")) if options.landmarks == SCANNED else None,
        )
        steps = 0
        while not run.finished and run.simulation.stamp_ns < options.time_limit_s * NS_PER_S:
            run.step()
            steps += 1
            if steps % _SHOW_EVERY == 0:
                show(run.snapshot())
        show(run.snapshot())
        run.atlas.save_rest()
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return RunEnd(run.finished, {"all": round(peak_mb, 1)})


def _simulation(options: RunOptions) -> Simulation:
    """Return the simulated robot."""
    config = simulation_configuration(options.node_settings("sim"))
    world = load_world(options.world, landmark_seed=options.seed)
    if options.start is not None:
        world = replace(world, start=options.start)
    return Simulation(world, config, options.seed)
