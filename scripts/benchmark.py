"""Measure the engines, side by side in one run: an evaluation of eq. 4.9, a whole plan, many obstacles, many plans."""

from humanoid_rail.cli import run
from humanoid_rail.commands.benchmark import command

if __name__ == "__main__":
    run(command)
