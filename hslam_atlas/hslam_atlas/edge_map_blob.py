"""An edge-map as bytes: exact, little-endian, the covariance as its lower triangle."""

import struct

import numpy as np

from hslam_atlas.errors import ContentError
from hslam_atlas.schema import LARGEST
from hslam_types.edge_map import EdgeMap
from hslam_types.se2 import SE2

_HEAD = struct.Struct("<2qI7d")


def encode(edge_map: EdgeMap) -> bytes:
    """Return the bytes of an edge-map."""
    m = edge_map
    head = _HEAD.pack(
        m.traversal, m.arrival, m.size, m.terminal_x, m.departure_heading, m.arrival_heading,
        *m.robot_at_arrival, m.path_length_m,
    )  # fmt: skip
    triangle = m.covariance[np.tril_indices(len(m.covariance))]
    sightings = np.array(m.sightings, dtype="<u4")
    return b"".join((head, m.landmarks.astype("<f8").tobytes(), sightings.tobytes(), triangle.astype("<f8").tobytes()))


def decode(blob: bytes) -> EdgeMap:
    """Return the edge-map of ``blob``; raises ContentError if it is not one."""
    if len(blob) < _HEAD.size:
        raise ContentError("is no edge-map: it is cut short")
    traversal, arrival, n, *reals = _HEAD.unpack_from(blob)
    size = 2 + 2 * n
    if len(blob) != _HEAD.size + 20 * n + 4 * size * (size + 1):
        raise ContentError(f"is no edge-map of {n} landmarks: it has {len(blob)} bytes")
    landmarks = np.frombuffer(blob, "<f8", 2 * n, _HEAD.size).reshape(n, 2).astype(np.float64)
    sightings = np.frombuffer(blob, "<u4", n, _HEAD.size + 16 * n)
    triangle = np.frombuffer(blob, "<f8", size * (size + 1) // 2, _HEAD.size + 20 * n)
    if not all((np.abs(part) <= LARGEST).all() for part in (reals, landmarks, triangle)):
        raise ContentError("is no edge-map: it holds what is no number")
    terminal_x, departure, along, x, y, theta, path_length = reals
    covariance = np.zeros((size, size))
    covariance[np.tril_indices(size)] = triangle
    covariance = covariance + np.tril(covariance, -1).T
    return EdgeMap(
        traversal=traversal,
        arrival=arrival,
        terminal_x=terminal_x,
        landmarks=landmarks,
        covariance=covariance,
        sightings=tuple(int(k) for k in sightings),
        departure_heading=departure,
        arrival_heading=along,
        robot_at_arrival=SE2(x, y, theta),
        path_length_m=path_length,
    )
