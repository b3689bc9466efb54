"""The executor that runs nodes."""

from rclpy.executors import Executor, SingleThreadedExecutor


def make_executor() -> Executor:
    """Return rclpy's events executor, or the single-threaded one where rclpy is too old to have it (7.1.3 is).

    Both run one callback at a time, in the order the messages came; the older one takes longer to find the next.
    """
    try:
        from rclpy.experimental import EventsExecutor  # noqa: PLC0415
    except ImportError:
        return SingleThreadedExecutor()
    return EventsExecutor()
