"""What this package installs to be run."""

from hslam_ros.start import executable

atlas_node = executable("hslam_atlas.atlas_node")
