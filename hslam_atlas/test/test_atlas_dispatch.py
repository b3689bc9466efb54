"""One mission in place of another; who follows the robot; an atlas taken up again."""

import math
from pathlib import Path

import pytest
from edge_walker import EdgeWalker
from scripted_level import ScriptedLevel, located, row
from test_atlas_node import walker

from hslam_atlas.config import AtlasConfig
from hslam_atlas.errors import StoreError
from hslam_atlas.missions.destination import AtNode, Destination, DestinationError, OnEdge
from hslam_atlas.missions.mission import Happened
from hslam_atlas.missions.navigate import Navigate
from hslam_atlas.numbering import Numbering
from hslam_atlas.places import check_name, from_json, to_json
from hslam_atlas.server import AtlasServer
from hslam_atlas.store import AtlasStore
from hslam_types.gvg_events import EventKind, GoalKind, GvgEvent, GvgGoal
from hslam_types.se2 import SE2

MIDDLE = (math.pi, 0.0, 1.5)


def explored(server: AtlasServer, base: EdgeWalker, goals: int) -> GvgGoal:
    """Do what a server asks for so many goals; return the next."""
    goal = server.step((), (), ()).goal
    for _ in range(goals):
        assert goal is not None
        for step in base.follow(goal):
            goal = server.step(step.events, step.edge_maps, step.links).goal
    assert goal is not None
    return goal


def test_an_exploration_goes_on_where_another_session_left_it(tmp_path: Path) -> None:
    """The robot is put down where the first began, counts from 0 again, is found and adds to what was known."""
    with AtlasStore(tmp_path / "atlas.db") as store:
        first = AtlasServer(store=store)
        explored(first, walker(), 6)
        nodes, edges = len(first.state.graph.nodes), len(first.state.graph.edges)
        before = {node.id: len(node.visits) for node in first.state.graph.nodes.values()}
    with AtlasStore(tmp_path / "atlas.db") as store:
        server, base = AtlasServer(store=store), walker()
        assert server.dispatch.doing == "localising"
        goal = server.step((), (), ()).goal
        for _ in range(30):
            assert goal is not None
            for step in base.follow(goal):
                goal = server.step(step.events, step.edge_maps, step.links).goal
            if server.dispatch.doing == "exploring":
                break
            assert len(server.state.graph.nodes) == nodes  # nothing is added by who does not know where it is
        assert server.dispatch.doing == "exploring"
        for _ in range(6):
            assert goal is not None
            for step in base.follow(goal):
                goal = server.step(step.events, step.edge_maps, step.links).goal
        graph = server.state.graph
        assert len(graph.edges) > edges
        assert any(len(graph.nodes[node].visits) > count for node, count in before.items() if node in graph.nodes)
        numbers = [sequence for node in graph.nodes.values() for sequence, _ in node.visits]
        assert len(numbers) == len(set(numbers))
        assert server.unsaved is None


def test_numbers_go_on_where_the_gvg_level_counts_on_or_begins_anew() -> None:
    graph = row().graph
    graph.nodes[1].visits.append((41, 0))
    departure = GvgEvent(3, 0, EventKind.LOST)
    numbering = Numbering(graph)
    assert numbering.event(departure).sequence == 45
    assert (numbering.drive(5), numbering.said(47)) == (47, 5)
    assert Numbering(graph).event(GvgEvent(42, 0, EventKind.LOST)).sequence == 42
    graph.nodes[1].visits.append((60, 0))
    numbering.renew()
    assert numbering.event(departure).sequence == 64


def test_return_home_follows_exploration() -> None:
    server, base = AtlasServer(AtlasConfig(return_home=True)), walker()
    goal = server.step((), (), ()).goal
    states, finished = [], False
    for _ in range(400):
        if goal is None or goal.kind is GoalKind.STOP:
            break
        for step in base.follow(goal):
            out = server.step(step.events, step.edge_maps, step.links)
            goal, finished = out.goal, out.finished
        states.append(server.dispatch.doing)
    assert "exploring" in states
    assert (finished, states[-1]) == (True, "reached")
    assert server.dispatch.about() == min(server.state.graph.nodes)


def test_a_hint_is_believed_once_a_drive_confirms_it() -> None:
    level, state = ScriptedLevel(), row()
    server = AtlasServer(AtlasConfig(mission="none"), state.maps)  # type: ignore[arg-type]
    server.state.graph.nodes.update(state.graph.nodes)
    server.state.graph.edges.update(state.graph.edges)
    dispatch = server.dispatch
    dispatch.step(Happened(sense=level.sense(SE2(), None)))
    dispatch.hint(SE2(0.2, 0.1, 0.05))
    assert (dispatch.about(), dispatch.doing) == (None, "following")
    dispatch.step(level.departs((0.0,), 0, 0.0))
    dispatch.step(level.arrives(MIDDLE, 0, 12.0, seed=0))
    assert dispatch.about() == 1
    base = dispatch.base_in_map()
    assert base is not None
    assert math.dist(base[:2], (12.0, 0.0)) < 0.1


def test_an_errand_in_the_middle_of_an_edge_turns_round_where_that_is_nearer() -> None:
    state, level = row(), ScriptedLevel()
    mission = Navigate(state, located(state))
    mission.go_to(AtNode(2))
    mission.step(level.departs((0.0,), 0, 0.0))
    early = level.sense(SE2(2.0, 0.0, 0.0), SE2(2.0, 0.0, 0.0))
    assert mission.step(Happened(sense=early)).goal is None
    mission.go_to(AtNode(0))
    back = mission.step(Happened(sense=early)).goal
    assert back is not None
    assert back.kind is GoalKind.ACCESS
    assert abs(back.heading_in_odom or 0.0) == pytest.approx(math.pi)
    mission.go_to(AtNode(1))
    assert mission.step(Happened(sense=level.sense(SE2(4.0, 0.0, 0.0), SE2(4.0, 0.0, 0.0)))).goal is None


def test_places_keep_their_names_in_the_file(tmp_path: Path) -> None:
    places: dict[str, Destination] = {"door": AtNode(3), "my desk": OnEdge(1, 2.5, -0.75)}
    with AtlasStore(tmp_path / "atlas.db") as store:
        assert store.places() == {}
        store.save_places(places)
        store.save_as(tmp_path / "copy.db")
    with AtlasStore.reading(tmp_path / "copy.db") as store:
        assert store.places() == places
    assert from_json(to_json(places)) == places


@pytest.mark.parametrize("value", ["[]", "{", '{"a": [-1]}', '{"a": [1, 2]}', '{"a": [1.5, 0, 0]}', '{"a": ["x"]}'])
def test_broken_places_are_named(tmp_path: Path, value: str) -> None:
    with AtlasStore(tmp_path / "atlas.db") as store:
        store._set_meta("places", value)
        with pytest.raises(StoreError, match=r"atlas\.db: cannot be read \(table meta, row"):
            store.places()


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 101])
def test_a_name_is_one(name: str) -> None:
    with pytest.raises(DestinationError, match="printable name"):
        check_name(name)
    assert check_name(" door ") == "door"
