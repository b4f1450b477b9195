"""The program ``gaitshift``, which comes along with the package: ``gaitshift demo`` or ``python -m gaitshift demo``."""

import signal
import sys

from gaitshift import _native


def main() -> int:
    """Runs the program with this process's command line and gives its exit code."""
    # Python would only take note of Ctrl-C and act on it when the program has ended.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _native.program(["gaitshift", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
