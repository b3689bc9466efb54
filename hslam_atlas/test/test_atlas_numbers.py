"""Every number that stands outside the configuration says what it is and where it comes from."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "hslam_atlas"


def is_numeric(statement: ast.stmt) -> bool:
    """Whether a statement gives a name in capitals to a number, or to several."""
    if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
        return False
    target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
    name = ast.unparse(target)
    if name != name.upper() or "ColorRGBA" in ast.unparse(statement.value):
        return False
    numbers = [node.value for node in ast.walk(statement.value) if isinstance(node, ast.Constant)]
    return any(isinstance(number, int | float) and not isinstance(number, bool) for number in numbers)


def is_text(statement: ast.stmt | None) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(getattr(statement.value, "value", None), str)


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_docstring_stands_under_it(path: Path) -> None:
    body = ast.parse(path.read_text()).body
    bare = [
        ast.unparse(statement)
        for statement, under in zip(body, [*body[1:], None], strict=True)
        if is_numeric(statement) and not is_text(under)
    ]
    assert not bare
