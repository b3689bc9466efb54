"""Nobody on the network reaches the nodes of a private domain: tried from another network namespace."""

import json
import shutil
import subprocess
import sys

import network_of_two
import pytest

ALONE = ["unshare", "--user", "--map-root-user", "--net", "--pid", "--fork", "--kill-child"]
"""Namespaces of one's own, which end with the command; a user may make them where the machine's owner lets users."""


def missing() -> str:
    """Return what this machine lacks for networks of one's own, in words, or nothing."""
    if lacking := [tool for tool in ("unshare", "ip") if not shutil.which(tool)]:
        return f"no command {' or '.join(lacking)} (apt install util-linux iproute2)"
    laid = [*ALONE, "ip", "link", "add", "here", "type", "veth", "peer", "name", "there"]
    answer = subprocess.run(laid, capture_output=True, text=True, check=False)
    return f"no network namespaces for this user: {answer.stderr.strip()}" if answer.returncode else ""


def test_a_stranger_who_knows_the_address_is_not_heard_and_hears_nothing() -> None:
    if reason := missing():
        pytest.skip(reason)
    command = [*ALONE, sys.executable, network_of_two.__file__]
    said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60.0).stdout
    assert json.loads(said) == {"closed": ["opened"], "stranger": ["opened"], "opened": ["closed", "stranger"]}
