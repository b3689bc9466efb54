"""What this package installs to be run."""

from hslam_ros.start import executable

record_node = executable("hslam_bags.record_node")
replay_node = executable("hslam_bags.replay_node")
