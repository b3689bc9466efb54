"""The base's side of the protocol, byte for byte and in time, with a world behind it and faults to inject."""
