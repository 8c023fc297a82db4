"""The program softcd-detect: python -m softcd --help."""

import os
import signal
import sys

from . import _core


def main() -> int:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a running detection does not check for Python's signals
    return _core.detect_program([os.fsencode(word) for word in ["softcd-detect", *sys.argv[1:]]])


if __name__ == "__main__":
    sys.exit(main())
