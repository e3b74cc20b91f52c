"""Plan every scene of a folder, one at a time, and tabulate per family of scenes what came of it."""

from humanoid_rail.cli import run
from humanoid_rail.commands.evaluate import command

if __name__ == "__main__":
    run(command)
