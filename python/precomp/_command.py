"""The command `precomp`: the same code as the program's."""

import signal
import sys

from precomp._precomp import main as run


def main() -> None:
    """Runs the command line of this process and ends it."""
    # The interpreter would keep an interrupt to itself until the command has ended.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run(["precomp", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
