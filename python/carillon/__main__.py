"""The program `carillon`, as `python -m carillon` and as pip installs it."""
import os
import sys

from carillon import _carillon


def main() -> None:
    program = _carillon.program()
    if not program:
        sys.exit("carillon: the program was not found: install it, or add its folder to PATH")
    os.execv(program, [program, *sys.argv[1:]])


if __name__ == "__main__":
    main()
