"""A Nomadic Scout on a serial line: the protocol, the driver, its ROS node, and an emulator of the base."""
