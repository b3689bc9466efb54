"""The means by which other tests see an order of hashes does see one."""

from hash_seeds import under_two_hash_seeds


def order_of_a_set() -> str:
    """Return words in the order of their hashes."""
    return " ".join({"departure", "arrival", "access", "lost", "home", "trace"})


def order_of_a_list() -> str:
    """Return words in the order of the alphabet."""
    return " ".join(sorted(order_of_a_set().split()))


def test_what_depends_on_the_order_of_a_set_comes_out_otherwise() -> None:
    first, second = under_two_hash_seeds(order_of_a_set)
    assert first != second


def test_what_does_not_comes_out_the_same() -> None:
    first, second = under_two_hash_seeds(order_of_a_list)
    assert first == second == "access arrival departure home lost trace"
