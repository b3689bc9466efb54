"""A domain is one run's alone, for as long as any of its processes lives."""

import subprocess
import sys

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
