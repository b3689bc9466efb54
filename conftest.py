"""What every test of the tree runs with."""

import os

from hypothesis import settings

# No deadline: on a loaded machine an example may take any time. On CI the examples are the same every time.
settings.register_profile("hslam", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("hslam")
