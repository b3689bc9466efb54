"""What is known of the gap between two obstacle points: a way, a wall that was not drawn whole, or neither."""

import numpy as np
import numpy.typing as npt

SHUT, UNKNOWN, OPEN = -1, 0, 1
Gaps = npt.NDArray[np.int8]
