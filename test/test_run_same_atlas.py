"""One seed, one atlas: separate processes and one process, whose texts hash differently, leave the same content."""

import json
from pathlib import Path

import pytest
from whole_runs import atlas_dump, hslam, outcome

OWN_TO_A_RUN = {"wall_time_s", "real_time_factor", "peak_rss_mb"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "chosen"),
    [("sim", ()), ("turtlebot", ()), ("turtlebot", ("--landmarks", "scan"))],
    ids=["sonar", "lidar", "lidar alone"],
)
def test_separate_processes_and_one_process_agree_bit_for_bit(
    tmp_path: Path, robot: str, chosen: tuple[str, ...]
) -> None:
    separate, single = tmp_path / "separate", tmp_path / "single"
    for out, how, hash_seed in ((separate, [], "1"), (single, ["--in-process"], "2")):
        arguments = ("explore", "small_world", "--robot", robot, *chosen, "--out", str(out), *how)
        status, _, err = outcome(hslam(*arguments, hash_seed=hash_seed), 600.0)
        assert status == 0, err
    assert atlas_dump(separate / "atlas.db") == atlas_dump(single / "atlas.db")
    reports = [json.loads((out / "report.json").read_text()) for out in (separate, single)]
    kept = [{name: value for name, value in report.items() if name not in OWN_TO_A_RUN} for report in reports]
    assert kept[0] == kept[1]
    assert kept[0]["completed"]
    assert kept[0]["isomorphic"]
    assert kept[0]["collisions"] == kept[0]["loop_closures_false"] == 0
    for name in ("figure_3_path_by_odometry", "figure_4_edge_maps", "figure_5_edge_map", "figure_6_loop_closing"):
        for ending in ("png", "svg"):
            assert (single / "figures" / f"{name}.{ending}").stat().st_size > 10_000
