"""A domain is one run's alone, for as long as any of its processes lives, and nobody on the network can reach it."""

import os
import subprocess
import sys

import psutil
import pytest

from hslam_ros.private_domain import private_domain


def test_a_domain_is_free_again_when_the_last_process_of_the_run_has_ended() -> None:
    with private_domain() as first:
        with private_domain() as second:
            assert second.number != first.number
        waits = [sys.executable, "-c", "input()"]
        node = subprocess.Popen(waits, stdin=subprocess.PIPE, pass_fds=(first.reservation,))
    with private_domain() as meanwhile:
        assert meanwhile.number != first.number
    node.communicate(b"\n")
    with private_domain() as again:
        assert again.number == first.number


@pytest.mark.parametrize(
    "mine",
    [
        {},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        {"ROS_LOCALHOST_ONLY": "1"},
        {"FASTRTPS_DEFAULT_PROFILES_FILE": "/no/such.xml", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"},
    ],
)
def test_nodes_of_a_private_domain_have_no_socket_on_the_network(mine: dict[str, str]) -> None:
    waits = "import rclpy; rclpy.init(); node = rclpy.create_node('inside'); print('up', flush=True); input()"
    with private_domain() as domain:
        node = subprocess.Popen(
            [sys.executable, "-c", waits],
            env=dict(os.environ) | mine | domain.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert node.stdout
        assert node.stdout.readline() == b"up\n"
        bound = {socket.laddr.ip for socket in psutil.Process(node.pid).net_connections("inet")}
        node.communicate(b"\n")
    assert bound == {"127.0.0.1"}
