"""Parameters as rows of a README's table, so that a test can hold the two against each other."""

from hslam_types.config import Parameter


def markdown_row(entry: Parameter, prefix: str = "") -> str:
    """Return ``| `name` | default | range | unit | meaning |`` of a parameter declared under ``prefix``."""
    default = f"{entry.default:.4g}" if isinstance(entry.default, float) else str(entry.default).lower()
    bounds = "" if isinstance(entry.default, bool | str) else f"{entry.low:g} to {entry.high:g}"
    return f"| `{prefix}{entry.name}` | {default} | {bounds} | {entry.unit} | {entry.meaning} |"
