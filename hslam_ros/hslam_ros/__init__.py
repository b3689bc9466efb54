"""What every node of the suite needs of ROS: conversions, parameters, QoS, order of inputs, spinning."""
