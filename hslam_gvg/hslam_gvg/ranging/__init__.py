"""What the sensors have shown round the robot: obstacles, known free space, and how far it has travelled since."""
