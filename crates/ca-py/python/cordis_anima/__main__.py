"""The command ``ca``: ``python -m cordis_anima``, and the script that the wheel installs."""

import signal
import sys

from ._core import command


def main() -> int:
    """Runs the command with the arguments of this process and returns its exit code."""
    # Python's handler would only run after the command has returned
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(["ca", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
