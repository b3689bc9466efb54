"""The tables of an atlas file (SQLite)."""

VERSION = 1
"""Of the tables, as the file itself tells it."""
LARGEST = 1e12
"""Largest length (m), angle (rad), evidence (nats) or entry of a covariance: nothing on a floor comes near it."""

TABLES = f"""
BEGIN;
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE nodes (
    id INTEGER PRIMARY KEY, kind INTEGER NOT NULL, clearance REAL NOT NULL);
CREATE TABLE branches (
    node INTEGER NOT NULL, key INTEGER NOT NULL, bearing REAL NOT NULL, edge INTEGER, seen INTEGER NOT NULL,
    missed INTEGER NOT NULL, attempts INTEGER NOT NULL, given_up INTEGER NOT NULL,
    PRIMARY KEY (node, key)) WITHOUT ROWID;
CREATE TABLE visits (
    node INTEGER NOT NULL, sequence INTEGER NOT NULL, stamp_ns INTEGER NOT NULL,
    PRIMARY KEY (node, sequence)) WITHOUT ROWID;
CREATE TABLE edges (
    id INTEGER PRIMARY KEY, node0 INTEGER NOT NULL, branch0 INTEGER NOT NULL, frame0 BLOB NOT NULL,
    node1 INTEGER NOT NULL, branch1 INTEGER NOT NULL, frame1 BLOB NOT NULL,
    terminal_x REAL NOT NULL, terminal_variance REAL NOT NULL, path_length REAL NOT NULL, traversals TEXT NOT NULL);
CREATE TABLE edge_maps (edge INTEGER PRIMARY KEY, map BLOB NOT NULL);
CREATE TABLE links (
    id INTEGER PRIMARY KEY, node0 INTEGER NOT NULL, node1 INTEGER NOT NULL, pose BLOB NOT NULL,
    path_length REAL NOT NULL);
CREATE TABLE questions (
    node INTEGER NOT NULL, other INTEGER NOT NULL, pose BLOB NOT NULL, place_evidence REAL NOT NULL,
    map_evidence TEXT NOT NULL, compared TEXT NOT NULL,
    PRIMARY KEY (node, other)) WITHOUT ROWID;
INSERT INTO meta VALUES ('version', '{VERSION}');
COMMIT;
"""  # noqa: S608 - the number above
"""Poses are twelve little-endian doubles: x, y (m), theta (rad) and their 3 x 3 covariance, row-major. Frames of edges
are in their node's frame; links and questions hold the second node in the first's frame, the node in the other's."""
