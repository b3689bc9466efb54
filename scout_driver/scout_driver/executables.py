"""What this package installs to be run."""

from hslam_ros.start import executable

scout_node = executable("scout_driver.scout_node")
scout_emulator = executable("scout_driver.scout_emulator")
scout_calibrate = executable("scout_driver.scout_calibrate")
