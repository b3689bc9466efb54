"""YAML that others wrote, read within bounds: plain values, or one error that says what is wrong and where.

PyYAML's safe loader makes no objects of the writer's choosing, but it fails in a dozen ways (dates that are none,
numbers of 5,000 digits, lists in lists in lists), lets aliases grow a page to gigabytes and takes the last of two equal
keys. And it speaks YAML 1.1, where ``1e-3`` is text; here it is a number as in YAML 1.2, and a date is text.
"""

import re
from typing import Any

import yaml

from hslam_types.errors import HslamError

_MOST_REPEATED = 100_000
"""Nodes that aliases may add to a document."""

_LARGEST_WHOLE = 2**64
"""No whole number reaches this: none that a message or a parameter can hold does."""


class YamlError(HslamError):
    """A text is not YAML, or is more than can be meant; ``line`` counts from 1, None where that is not known."""

    def __init__(self, problem: str, line: int | None = None) -> None:
        """Keep the line and make one line of what a library said in several."""
        problem = " ".join(problem.split())
        super().__init__(f"line {line}: {problem}" if line else problem)
        self.problem, self.line = problem, line


def load_yaml(text: str) -> Any:
    """Return the value of one YAML document: mappings, lists, text, numbers, booleans and None; raises YamlError."""
    try:
        return yaml.load(text, _BoundedLoader)  # noqa: S506 - derived from the safe loader
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise YamlError(error.problem or "is not YAML", mark.line + 1 if mark else None) from error
    except yaml.YAMLError as error:
        raise YamlError(str(error)) from error
    except RecursionError as error:
        raise YamlError("is nested too deeply") from error
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError) as error:
        # What PyYAML's constructors raise on a scalar that its tag does not fit.
        raise YamlError(f"a value is not what its tag says ({error})") from error


class _BoundedLoader(yaml.SafeLoader):
    """The safe loader, without doubled keys, dates, endless numbers and growth by aliases."""

    def __init__(self, stream: str) -> None:
        super().__init__(stream)
        self._nodes = 0
        self._repeated = 0
        self._sizes: dict[int, int] = {}
        """Nodes below each finished node that an alias can repeat, by its identity."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose a node, counting what an alias repeats."""
        is_alias = self.check_event(yaml.AliasEvent)
        mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
        before = self._nodes
        node = super().compose_node(parent, index)
        if is_alias:
            size = self._sizes.get(id(node))
            if size is None:
                raise yaml.MarkedYAMLError(problem="an alias stands within what it stands for", problem_mark=mark)
            self._nodes += size
            self._repeated += size
            if self._repeated > _MOST_REPEATED:
                raise yaml.MarkedYAMLError(problem="aliases make more of this than can be meant", problem_mark=mark)
        else:
            self._nodes += 1
            self._sizes[id(node)] = self._nodes - before
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Compose a mapping none of whose keys is there twice."""
        node = super().compose_mapping_node(anchor)
        seen: set[tuple[str, str]] = set()
        for key, _ in node.value:
            name = (key.tag, str(key.value))
            if isinstance(key, yaml.ScalarNode) and name in seen:
                raise yaml.MarkedYAMLError(problem=f"the key '{key.value}' is there twice", problem_mark=key.start_mark)
            seen.add(name)
        return node

    def construct_whole(self, node: yaml.ScalarNode) -> int:
        """Return a whole number that fits into 64 bits."""
        value = self.construct_yaml_int(node)
        if abs(value) >= _LARGEST_WHOLE:
            raise yaml.MarkedYAMLError(problem="a whole number of more than 64 bits", problem_mark=node.start_mark)
        return int(value)


_BoundedLoader.add_constructor("tag:yaml.org,2002:int", _BoundedLoader.construct_whole)
_BoundedLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_BoundedLoader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)
