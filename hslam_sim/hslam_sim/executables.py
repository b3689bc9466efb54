"""What this package installs to be run."""

from hslam_ros.start import executable

sim_node = executable("hslam_sim.sim_node")
