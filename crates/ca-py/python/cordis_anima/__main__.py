"""The command ``ca``: ``python -m cordis_anima``, and the script that the wheel installs."""

import signal
import sys

from ._core import command


def main() -> int:
    """Runs the command with the arguments of this process, and returns its exit code."""
    # the handler of Python would wait until the command returns
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(["ca", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
