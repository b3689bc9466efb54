"""Which branch of a node is which between two visits: bearings scatter, one may be missed or invented."""

from collections.abc import Sequence

from hslam_types.se2 import wrap


def match_bearings(seen: Sequence[float], known: Sequence[tuple[int, float]], gate: float) -> list[int | None]:
    """Pair bearings seen with (key, bearing) known, all in one frame (rad); returns a key or None for each seen one.

    Pairs are taken from the nearest on, one to one, within ``gate``, and only if the cyclic order holds.
    """
    offers = sorted(
        (abs(wrap(bearing - other)), i, key)
        for i, bearing in enumerate(seen)
        for key, other in known
        if abs(wrap(bearing - other)) < gate
    )
    rank = {key: n for n, (key, _) in enumerate(sorted(known, key=lambda entry: (wrap(entry[1]), entry[0])))}
    order = {i: n for n, i in enumerate(sorted(range(len(seen)), key=lambda i: (wrap(seen[i]), i)))}
    chosen: dict[int, int] = {}
    for _, i, key in offers:
        if i in chosen or key in chosen.values():
            continue
        trial = {**chosen, i: key}
        if _keeps_order([rank[trial[j]] for j in sorted(trial, key=lambda j: order[j])]):
            chosen = trial
    return [chosen.get(i) for i in range(len(seen))]


def _keeps_order(ranks: list[int]) -> bool:
    """Whether ranks ascend when read round the circle: at most one descent."""
    descents = sum(1 for a, b in zip(ranks, ranks[1:] + ranks[:1], strict=True) if b <= a)
    return descents <= 1
