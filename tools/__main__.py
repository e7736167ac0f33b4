"""Entry point: `python tools COMMAND`, from the folder of the project."""

from railgrip.__main__ import main

if __name__ == "__main__":
    main(module="commands")
