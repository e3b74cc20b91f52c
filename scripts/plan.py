"""Plan a motion of both hands to their targets, print what came of it and play it back."""

from humanoid_rail.cli.console import run
from humanoid_rail.cli.plan import command

if __name__ == "__main__":
    run(command)
