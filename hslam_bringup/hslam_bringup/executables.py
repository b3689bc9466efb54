"""What this package installs to be run."""

from hslam_ros.start import executable

hslam = executable("hslam_bringup.cli")
