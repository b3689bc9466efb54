"""Explore a simulated floor: the simulator, the three levels, the recorder and, if asked, RViz.

ros2 launch hslam_bringup floor.launch.py world:=wean_hall_6 seed:=1 bag:=/tmp/floor rviz:=true
"""

import itertools
import os
from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction, SetEnvironmentVariable, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import EqualsSubstitution, LaunchConfiguration, NotEqualsSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from hslam_bringup.linear_algebra import ON_ONE_THREAD
from hslam_ros.private_domain import within_this_machine

SHARE = Path(get_package_share_directory("hslam_bringup"))

ARGUMENTS = {
    "world": ("small_world", "shipped world, or path of a world's or map_server's YAML file"),
    "seed": ("1", "seed of all chance: noise, odometry bias, landmarks"),
    "mode": ("lock_step", "lock_step: as fast as the nodes go, repeatable; free_running: by the wall clock"),
    "atlas": (
        "",
        "atlas file to write, or to go on with; empty: a new one below runs/; none: in memory",
    ),
    "bag": ("", "folder of the bag to record; empty: not recorded"),
    "rviz": ("false", "show the floor in RViz"),
    "network": ("closed", "closed: this machine alone can reach the nodes; open: as ROS's own variables say"),
}


CHOICES = {"mode": ["lock_step", "free_running"], "rviz": ["false", "true"], "network": ["closed", "open"]}
REQUIRED = "odom,cmd_vel,gvg/events,ekf/edge_maps,atlas/atlas"
"""Topics that the recorder hears before it says that the run may begin."""


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments and start the nodes; when one ends, the others are stopped."""
    given = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    mode = PythonExpression(["'", str(SHARE / "config"), "/", given["mode"], ".yaml'"])
    seed = ParameterValue(given["seed"], value_type=int)
    # The first step waits for the recorder too, so that its bag has every cycle.
    awaited = PythonExpression(["['atlas', 'recorder'] if '", given["bag"], "' else ['atlas']"])
    own = {
        "sim": {
            "world": text(given["world"]),
            "seed": seed,
            "landmark_seed": seed,
            "lockstep_nodes": ParameterValue(awaited, value_type=list[str]),
        },
        "gvg": {},
        "ekf": {},
        "atlas": {"store": text(given["atlas"]), "mission": "explore"},
    }
    levels = [
        Node(
            package=f"hslam_{name}",
            executable=f"{name}_node",
            name=name,
            parameters=[mode, parameters],
            output="screen",
            on_exit=Shutdown(reason=f"{name} ended"),
        )
        for name, parameters in own.items()
    ]
    recorder = Node(
        package="hslam_bags",
        executable="record_node",
        name="recorder",
        parameters=[{"path": text(given["bag"]), "require": REQUIRED}],
        output="screen",
        condition=IfCondition(NotEqualsSubstitution(given["bag"], "")),
        on_exit=Shutdown(reason="the recorder ended"),
    )
    viewer = Node(
        package="rviz2",
        executable="rviz2",
        name="viewer",
        arguments=["-d", str(SHARE / "rviz" / "floor.rviz")],
        parameters=[{"use_sim_time": True}],
        condition=IfCondition(EqualsSubstitution(given["rviz"], "true")),
    )
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=about, choices=CHOICES.get(name))
        for name, (default, about) in ARGUMENTS.items()
    ]
    surroundings = [
        SetEnvironmentVariable(name, value) for name, value in ON_ONE_THREAD.items() if name not in os.environ
    ]
    closed = IfCondition(EqualsSubstitution(given["network"], "closed"))
    surroundings += [
        SetEnvironmentVariable(name, value, condition=closed) for name, value in within_this_machine().items()
    ]
    return LaunchDescription(
        [
            *declared,
            OpaqueFunction(function=check_seed),
            OpaqueFunction(function=choose_atlas),
            *surroundings,
            recorder,
            *reversed(levels),
            viewer,
        ]
    )


def check_seed(context: LaunchContext) -> None:
    """Raise before any node is started: launch leaves those running that were when a later one could not be."""
    seed = LaunchConfiguration("seed").perform(context)
    if not seed.isdecimal():
        raise ValueError(f"seed takes a whole number from 0, not '{seed}'")


def choose_atlas(context: LaunchContext) -> list[LogInfo]:
    """Say where the atlas is kept: what a robot has learnt is not lost because nobody named a file."""
    given = LaunchConfiguration("atlas").perform(context)
    chosen = "" if given == "none" else given or str(_new_atlas(context))
    context.launch_configurations["atlas"] = chosen
    return [LogInfo(msg=f"the atlas is kept in {chosen or 'memory alone'}")]


def _new_atlas(context: LaunchContext) -> Path:
    world, seed = (LaunchConfiguration(name).perform(context) for name in ("world", "seed"))
    folders = (Path("runs") / f"{Path(world).stem}_{seed}_launch{n}" for n in itertools.count(1))
    return next(folder for folder in folders if not folder.exists()).absolute() / "atlas.db"


def text(value: LaunchConfiguration) -> ParameterValue:
    """Return a parameter that stays text, whatever it looks like to YAML."""
    return ParameterValue(value, value_type=str)
