"""What a robot is out for: each mission hears what happened and says what the GVG level shall do next."""
