"""`python -m humanoid_rail`, which is the console command `humanoid-rail`."""

from humanoid_rail.cli import main

if __name__ == "__main__":
    main()
