"""The whole suite as nodes in simulation: sent about in a stored atlas by action, by name and by a click."""

import math
from pathlib import Path
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from hslam_msgs.action import NavigateTo
from hslam_msgs.msg import Destination, NodeStatus
from hslam_msgs.srv import NamePlace
from rclpy.action import ActionClient
from rclpy.node import Node
from ros_stage import Stage, Staged
from whole_runs import hslam, outcome

from hslam_atlas.atlas_node import AtlasNode
from hslam_atlas.store import AtlasStore
from hslam_ekf.ekf_node import EkfNode
from hslam_gvg.gvg_node import GvgNode
from hslam_ros.qos import CYCLE
from hslam_sim.sim_node import SimNode
from hslam_types.se2 import SE2

WITHIN_S = 300.0
NODES = ((9.0, 0.0), (0.0, 4.0), (9.0, -6.0), (-5.5, 4.0))
"""Of the reduced GVG of small_world (m)."""


class Site(Stage):
    """A robot in a world it has an atlas of, and somebody who wants something of it."""

    def __init__(self, **parameters: object) -> None:
        super().__init__(**parameters)
        self.person = self.add(Node("person"))
        self.statuses: list[NodeStatus] = []
        self.feedback: list[NavigateTo.Feedback] = []
        self.person.create_subscription(NodeStatus, "atlas/status", self.statuses.append, CYCLE)
        self.clicks = self.person.create_publisher(PoseStamped, "goal_pose", 10)
        self.client: Any = ActionClient(self.person, NavigateTo, "atlas/navigate_to")
        self.atlas = self.add(AtlasNode())
        self.add(EkfNode())
        self.add(GvgNode())
        self.sim = self.add(SimNode())

    def send(self, **destination: Any) -> Any:
        """Send the robot somewhere; return the client's handle."""
        self.feedback.clear()
        self.spin_until(self.client.server_is_ready)
        goal = NavigateTo.Goal(destination=Destination(**destination))
        handle = self.wait(self.client.send_goal_async(goal, lambda msg: self.feedback.append(msg.feedback)))
        assert handle.accepted
        return handle

    def end_of(self, handle: Any) -> Any:
        """Wait for the end of an errand: its status and result."""
        future = handle.get_result_async()
        self.spin_until(future.done, WITHIN_S)
        return future.result()

    @property
    def truth(self) -> SE2:
        """Where the robot truly is."""
        assert self.sim._last is not None
        return self.sim._last.truth

    def to_nearest_node_m(self) -> float:
        """How far the robot truly is from the nearest node."""
        return min(math.dist(self.truth[:2], node) for node in NODES)


@pytest.fixture(scope="module")
def atlas(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("explored")
    status, _, err = outcome(hslam("explore", "small_world", "--in-process", "--out", str(out)))
    assert status == 0, err
    return out / "atlas.db"


@pytest.mark.slow
def test_a_robot_is_sent_about_in_its_atlas(staged: Staged, atlas: Path) -> None:
    site = staged(Site, world="small_world", seed=3, landmark_seed=1, store=atlas, mission="none")
    with AtlasStore.reading(atlas) as store:
        first, *_, last = sorted(store.load()[0].nodes)

    # Nobody has told it where it is: it says so, and is stopped.
    lost = site.send(kind=Destination.NODE, node=last)
    site.spin_until(lambda: bool(site.feedback))
    assert (site.feedback[0].state, site.feedback[0].node) == ("localising", -1)
    assert math.isnan(site.feedback[0].path_left)
    site.wait(lost.cancel_goal_async())
    assert site.end_of(lost).status == GoalStatus.STATUS_CANCELED
    site.spin_until(lambda: site.statuses[-1].state in ("stopping", "stopped"))

    # What is nowhere is named.
    nowhere = site.end_of(site.send(kind=Destination.NODE, node=99))
    assert (nowhere.status, nowhere.result.unreachable) == (GoalStatus.STATUS_ABORTED, True)
    assert nowhere.result.message == "the atlas has no node 99"
    far = site.end_of(site.send(kind=Destination.NAMED, name="the moon"))
    assert far.result.message == "no place is called 'the moon'"

    # One errand takes the place of another.
    first_errand = site.send(kind=Destination.NODE, node=last)
    second_errand = site.send(kind=Destination.NODE, node=first)
    assert "took its place" in site.end_of(first_errand).result.message
    reached = site.end_of(second_errand)
    assert (reached.status, reached.result.success) == (GoalStatus.STATUS_SUCCEEDED, True)
    assert site.to_nearest_node_m() < 0.3
    assert {feedback.state for feedback in site.feedback} == {"localising", "navigating"}

    # A place is given a name, which its file keeps.
    door = Destination(kind=Destination.NODE, node=first)
    request = NamePlace.Request(name="door", destination=door)
    assert site.call(site.person, NamePlace, "atlas/name_place", request).success
    with AtlasStore.reading(atlas) as store:
        assert list(store.places()) == ["door"]

    # To a point beside the way, and back to the door.
    state = site.atlas._server.state
    edge_id = min(state.graph.edges)
    along = SE2(0.0, 0.0, state.maps.get(edge_id).departure_heading).apply(2.0, 0.2)
    aside = site.end_of(site.send(kind=Destination.ON_EDGE, edge=edge_id, distance=along[0], offset=along[1]))
    assert aside.result.success
    assert site.to_nearest_node_m() > 1.0
    clicked, pose = site.truth, site.atlas._base_in_map()
    assert pose is not None
    assert site.end_of(site.send(kind=Destination.NAMED, name="door")).result.success
    assert site.to_nearest_node_m() < 0.3

    # Somebody clicks at where it was.
    click = PoseStamped()
    click.header.frame_id = "map"
    click.pose.position.x, click.pose.position.y = pose.x, pose.y
    site.clicks.publish(click)
    site.spin_until(lambda: site.statuses[-1].state == "navigating")
    site.spin_until(lambda: site.statuses[-1].state == "reached", WITHIN_S)
    assert math.dist(site.truth[:2], clicked[:2]) < 0.4
