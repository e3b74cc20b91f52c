"""Plans scenes for `against.py` in a process of a checkout's own Python: requests by lines of JSON, answers likewise.

It imports only what every checkout of the package has had.
"""

from __future__ import annotations

import json
import sys

import humanoid_rail


def main() -> None:
    """Answer requests until stdin ends."""
    robot = humanoid_rail.load_robot()
    print(json.dumps({"package": humanoid_rail.__file__}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        found = humanoid_rail.plan(robot, humanoid_rail.load_scene(request["scene"]), request["method"])
        answer = {
            "status": str(found.status),
            "certified": bool(found.certified),
            "planning_time": found.planning_time,
            "duration": found.duration,
        }
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
