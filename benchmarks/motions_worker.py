"""Plans and retimes scenes for `compare_motions.py` with the package of a checkout, in its own Python.

It imports only what every checkout of the package has had, and keeps to the protocol of `worker.py` by itself.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import fields
from typing import Any

import humanoid_rail


def main() -> None:
    """Answer requests until stdin ends; the options of `Auto` are in the first line."""
    robot = humanoid_rail.load_robot()
    options = [field.name for field in fields(humanoid_rail.Auto)]
    print(json.dumps({"package": humanoid_rail.__file__, "options": options}), flush=True)
    for line in sys.stdin:
        print(json.dumps(answer(robot, **json.loads(line))), flush=True)


def answer(robot: humanoid_rail.Robot, scene: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return the retimed plan of a scene's file by `Auto` with some options, and the processor time that it took."""
    loaded = humanoid_rail.load_scene(scene)
    method = humanoid_rail.Auto(**options)
    started = time.process_time()
    try:
        motion = humanoid_rail.plan(robot, loaded, method)
        planned = time.process_time()
        if motion.timing is None:  # else planning has timed it already
            motion = humanoid_rail.retime(motion)
    except humanoid_rail.InvalidInput as error:
        return {"failed": str(error), "planning_time": time.process_time() - started}
    assert motion.timing is not None
    return {
        "planning_time": planned - started,
        "time": time.process_time() - started,
        "reason": motion.reason,
        "t": motion.t.tolist(),
        "q": motion.q.tolist(),
        "velocity": motion.timing.velocity.tolist(),
    }


if __name__ == "__main__":
    main()
