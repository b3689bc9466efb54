"""Two machines on a network, as two namespaces of Linux: nodes of a private domain, one that is open, and a stranger.

Run inside a network namespace of its own it prints, as JSON, whom each of the three nodes has heard.
"""

import json
import os
import select
import subprocess
import sys
from collections.abc import Collection

import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from hslam_ros.private_domain import private_domain

LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
HERE, THERE = "198.51.100.1", "198.51.100.2"
"""Addresses for documentation alone, RFC 5737."""


def node(name: str, awaited: Collection[str]) -> None:
    """Call out a node's name and listen to others'; says when it has heard those awaited, and whom when asked."""
    rclpy.init()
    speaker = rclpy.create_node(name)
    heard: set[str] = set()
    speaker.create_subscription(String, "names", lambda message: heard.add(message.data), LATCHED)
    speaker.create_publisher(String, "names", LATCHED).publish(String(data=name))
    say("up")
    while not heard.issuperset({name, *awaited}):
        rclpy.spin_once(speaker, timeout_sec=0.05)
    say("heard")
    while not select.select([sys.stdin], [], [], 0.0)[0]:
        rclpy.spin_once(speaker, timeout_sec=0.05)
    say(json.dumps(sorted(heard - {name})))
    rclpy.shutdown()


def say(word: str) -> None:
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


def ip(command: str) -> None:
    subprocess.run(["ip", *command.split()], check=True)


def network() -> None:
    """Lay a wire to another namespace, put the nodes at its ends and print whom they have heard."""
    ip("link set lo up")
    ip("link add here type veth peer name there")
    ip(f"address add {HERE}/24 dev here")
    ip("link set here up")
    with private_domain() as domain:
        # What the two machines share here, unlike others, is their memory: nobody but the closed node uses it.
        joining = {"ROS_DOMAIN_ID": str(domain.number), "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        stranger = start("stranger", ["opened"], joining | {"ROS_STATIC_PEERS": HERE}, ("unshare", "--net"))
        expect(stranger, "a namespace of its own")
        ip(f"link set there netns {stranger.pid}")
        tell(stranger, "the wire is laid")
        expect(stranger, "up")
        # Not before: nodes look for networks that run when they start.
        own = {"ROS_DISCOVERY_SERVER": f"{THERE}:11811", "ROS_STATIC_PEERS": THERE}
        closed = start("closed", ["opened"], own | domain.environment)
        expect(closed, "up")
        # The last to come: until it has been heard, the two before had all the time to find each other.
        opened = start("opened", ["closed", "stranger"], joining)
        expect(opened, "up")
        nodes = {"closed": closed, "stranger": stranger, "opened": opened}
        for one in nodes.values():
            expect(one, "heard")
        say(json.dumps({name: json.loads(ask(one)) for name, one in nodes.items()}))


def at_the_other_end() -> None:
    """Take the wire that is laid to this namespace."""
    say("a namespace of its own")
    sys.stdin.readline()
    ip("link set lo up")
    ip(f"address add {THERE}/24 dev there")
    ip("link set there up")


def start(
    name: str, awaited: Collection[str], environment: dict[str, str], within: tuple[str, ...] = ()
) -> subprocess.Popen[str]:
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("ROS_", "FAST", "RMW_"))}
    command = [*within, sys.executable, __file__, name, *awaited]
    return subprocess.Popen(command, env=kept | environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def expect(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdout
    line = process.stdout.readline().strip()
    assert line == word, f"{process.args!r} said '{line}', not '{word}'"


def tell(process: subprocess.Popen[str], word: str) -> None:
    assert process.stdin
    process.stdin.write(f"{word}\n")
    process.stdin.flush()


def ask(process: subprocess.Popen[str]) -> str:
    answer, _ = process.communicate("whom?\n")
    return answer


if __name__ == "__main__":
    if len(sys.argv) == 1:
        network()
    else:
        if sys.argv[1] == "stranger":
            at_the_other_end()
        node(sys.argv[1], sys.argv[2:])
