"""A run as users of ROS have it: every node a process of its own, in lock-step over DDS."""

import os
import time
from collections.abc import Callable, Mapping

from hslam_bringup.fleet import Fleet, NodeProcess
from hslam_bringup.onlooker import Onlooker
from hslam_bringup.progress import Snapshot
from hslam_bringup.run_options import LANDMARKS, RunOptions
from hslam_bringup.run_report import RunEnd
from hslam_ros.private_domain import PrivateDomain

_LOOK_S = 0.25
"""How often the runner looks at the processes and redraws."""


def run_separately(options: RunOptions, domain: PrivateDomain, show: Callable[[Snapshot], None]) -> RunEnd:
    """Explore with separate processes in ``domain`` until nothing left can be reached, or until the time limit.

    Raises NodeDiedError, naming the node, when a process ends early.  However it ends, the nodes are stopped in
    order: the base first, the recorder last.
    """
    bases = _simulated_base(options) if options.robot != "scout" else _scout_behind_its_line(options)
    world = bases[0].name
    levels = _levels(options, world)
    fleet = Fleet(options.out / "log", domain)
    try:
        for node in levels + bases:
            fleet.start(node)
        finished = _watch(fleet, world, domain, options, show)
    finally:
        fleet.stop([node.name for node in reversed(levels + bases)])
    return RunEnd(finished, fleet.peak_rss_mb())


def _levels(options: RunOptions, world: str) -> list[NodeProcess]:
    """Return the recorder and the three levels; ``world`` is the node that looks for landmarks."""
    recorder = {"path": str(options.bag), "require": "odom,cmd_vel,gvg/events,ekf/edge_maps,atlas/atlas"}
    lookers = LANDMARKS[options.landmarks]
    ekf = {"landmark_source": lookers[0] if lookers else world}
    atlas = {"store": str(options.atlas), "mission": "explore"}
    return [
        NodeProcess("recorder", "hslam_bags", "record_node", recorder),
        NodeProcess("atlas", "hslam_atlas", "atlas_node", _parameters(options, "atlas", atlas)),
        NodeProcess("ekf", "hslam_ekf", "ekf_node", _parameters(options, "ekf", ekf)),
        NodeProcess("gvg", "hslam_gvg", "gvg_node", _parameters(options, "gvg", {})),
        *(NodeProcess(name, "hslam_landmarks", f"{name}_node", _parameters(options, name, {})) for name in lookers),
    ]


def _simulated_base(options: RunOptions) -> list[NodeProcess]:
    sim = _world_parameters(options) | {"lockstep_nodes": ["atlas", "recorder"]}
    sim["lockstep_suspects"] = ["gvg", *LANDMARKS[options.landmarks], "ekf"]
    return [NodeProcess("sim", "hslam_sim", "sim_node", _parameters(options, "sim", sim))]


def _scout_behind_its_line(options: RunOptions) -> list[NodeProcess]:
    """Return the emulated base with the world behind it, and the driver at the other end of its serial line."""
    line = {"port": str((options.out / "scout.tty").absolute())}
    awaited = {"lockstep_nodes": ["gvg", "ekf", "atlas", "recorder"]}
    emulator = _parameters(options, "scout_emulator", _world_parameters(options) | line | awaited)
    return [
        NodeProcess("scout_emulator", "scout_driver", "scout_emulator", emulator),
        NodeProcess("scout", "scout_driver", "scout_node", _parameters(options, "scout", line)),
    ]


def _world_parameters(options: RunOptions) -> dict[str, object]:
    start = {} if options.start is None else {"start": " ".join(repr(value) for value in options.start)}
    return {"world": options.world, "seed": options.seed, "landmark_seed": options.seed} | start


def _parameters(options: RunOptions, node: str, own: Mapping[str, object]) -> dict[str, object]:
    return {"lockstep": True} | dict(own) | options.node_settings(node)


def _watch(
    fleet: Fleet, world: str, domain: PrivateDomain, options: RunOptions, show: Callable[[Snapshot], None]
) -> bool:
    """Follow the run to its end; return whether that was the mission's, not the time limit."""
    os.environ.update(domain.environment)
    onlooker = Onlooker(domain.number)
    try:
        while not fleet.ended(world):
            time.sleep(_LOOK_S)
            now = onlooker.look()
            if now is not None:
                show(now)
                if now.sim_time_s > options.time_limit_s:
                    return False
        return True
    finally:
        onlooker.close()
