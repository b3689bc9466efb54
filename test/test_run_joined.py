"""A run says which ROS domain it has moved to, and who sets no more than that domain hears it."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from whole_runs import PATIENCE_S, hslam

HEAR_ODOMETRY = """
import rclpy, sys
from nav_msgs.msg import Odometry
rclpy.init()
node = rclpy.create_node("guest")
heard = []
node.create_subscription(Odometry, "odom", heard.append, 1)
while not heard:
    rclpy.spin_once(node)
"""


def test_who_sets_the_domain_that_a_run_prints_hears_it(tmp_path: Path) -> None:
    run = hslam("explore", "small_world", "--out", str(tmp_path / "run"))
    try:
        assert run.stdout
        said = run.stdout.readline()
        joining = re.search(r"alone in ROS domain (\d+) of this machine; to join it: export (ROS_DOMAIN_ID)=\1$", said)
        assert joining, said
        ours = ("ROS_DOMAIN", "ROS_AUTOMATIC", "ROS_LOCALHOST", "ROS_STATIC", "ROS_DISCOVERY", "FAST", "RMW_", "SKIP_")
        theirs = {name: value for name, value in os.environ.items() if not name.startswith(ours)}
        theirs[joining[2]] = joining[1]
        subprocess.run([sys.executable, "-c", HEAR_ODOMETRY], env=theirs, check=True, timeout=PATIENCE_S)
    finally:
        run.send_signal(signal.SIGINT)
        run.communicate()
