"""Plans many scenes at once, on the cores of one machine or, through joblib's backends, of many."""

from __future__ import annotations

import os
import pickle
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache

from humanoid_rail._parent import end_with_parent
from humanoid_rail.errors import EngineMissing, HumanoidRailError, InvalidInput, short
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import as_method
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.planner import plan
from humanoid_rail.planning.shared_memory import Packed, pack, shared_folder, unpack
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory

PlanOrError = Trajectory | Exception
"""The outcome for a scene is a trajectory, or the error that planning raised."""
Chunk = list[int]
"""A chunk holds the indices of the scenes that a worker is given at a time."""

LARGEST_CHUNK = 24
"""A worker process is given at most this many scenes at a time."""
CHUNKS_EACH = 8
"""Each worker gets at least this many chunks, so that none waits long for another at the end."""


class WorkerDied(HumanoidRailError):
    """The process that planned a scene ended without a result: killed, out of memory, or crashed."""


def plan_many(
    robot: Robot,
    scenes: Iterable[Scene],
    method: PlanningMethod | str = "auto",
    *,
    n_jobs: int | None = -1,
    progress: bool | None = None,
) -> list[PlanOrError]:
    """Plan a motion for each scene, in parallel.

    Workers are joblib's: processes that stay warm between calls, unless a ``joblib.parallel_config`` around the call
    says otherwise (``backend="dask"``, ``"ray"``, ``"threading"``). While the native engine plans, the interpreter is
    free for other threads.

    Args:
        robot: The robot.
        scenes: Start, targets and obstacles of each motion.
        method: How they are planned, the same for all; see :func:`plan`.
        n_jobs: Number of workers; -1 for as many as there are cores, None for what ``joblib.parallel_config`` says.
        progress: Whether to show a progress bar on stderr; by default if that is a terminal.

    Returns:
        For each scene, in order, its trajectory or the exception that planning it raised. One failing scene never
        takes others down; with joblib's own processes that holds even where it kills the process that plans it.

    Raises:
        InvalidInput: If the robot is none, an element of the scenes is none, or `n_jobs` or the method is not valid,
            whatever the scene.
        EngineMissing: If there is no native engine and the method needs it.
    """
    # Imported where they are used: they take longer than all of this package.
    from joblib import effective_n_jobs

    from humanoid_rail.progress import progress_bar

    chosen = as_method(method)
    if isinstance(n_jobs, bool) or not isinstance(n_jobs, int | None) or n_jobs == 0:
        raise InvalidInput("n_jobs", n_jobs, "a number of workers, -1 for all cores, or None")
    if not isinstance(robot, Robot):
        raise InvalidInput("robot", robot, "a Robot")
    chosen.gains.diagonal(3 * len(robot.hands))
    if isinstance(scenes, Scene | str) or not isinstance(scenes, Iterable):
        raise InvalidInput("scenes", scenes, "a list of scenes")
    scenes = list(scenes)
    for i, scene in enumerate(scenes):
        if not isinstance(scene, Scene):
            raise InvalidInput(f"scenes[{i}]", scene, "a Scene")
    workers = max(1, effective_n_jobs(n_jobs))
    size = min(LARGEST_CHUNK, max(1, len(scenes) // (workers * CHUNKS_EACH)))
    chunks = [list(range(i, min(i + size, len(scenes)))) for i in range(0, len(scenes), size)]
    outcomes: dict[int, PlanOrError] = {}
    with shared_folder() as folder, progress_bar("planning", len(scenes), progress) as advance:
        job = _Job(pickle.dumps(robot), chosen, os.getpid(), folder)
        for indices, results in _run(job, scenes, chunks, n_jobs):
            outcomes |= zip(indices, results, strict=True)
            advance(len(indices))
    for outcome in outcomes.values():
        if isinstance(outcome, EngineMissing):
            raise outcome
    return [_of(robot, scene, outcomes[i]) for i, scene in enumerate(scenes)]


@dataclass(frozen=True)
class _Job:
    """What all chunks have in common."""

    robot: bytes
    """The robot, pickled."""
    method: PlanningMethod
    """How to plan."""
    process: int
    """The process that wants the results."""
    folder: str
    """Where other processes of the same machine may leave them."""


def _run(
    job: _Job, scenes: Sequence[Scene], chunks: list[Chunk], n_jobs: int | None
) -> Iterator[tuple[Chunk, list[PlanOrError]]]:
    """Yield chunks with their outcomes as they come. Where a worker dies, halves of what is left are tried again."""
    from joblib import Parallel, delayed
    from joblib.externals.loky.process_executor import BrokenProcessPool
    from joblib.parallel import get_active_backend

    left = {chunk[0]: chunk for chunk in chunks}
    try:
        # Some backends, Ray's among them, have no results to show before the last.
        lazy = get_active_backend()[0].supports_return_generator
        return_as = "generator_unordered" if lazy else "list"
        parallel = Parallel(n_jobs=n_jobs, return_as=return_as, batch_size=1, pre_dispatch="4*n_jobs")
        planning = (delayed(_plan_chunk)(job, chunk, [scenes[i] for i in chunk]) for chunk in chunks)
        for chunk, outcomes in parallel(planning):
            del left[chunk[0]]
            if isinstance(outcomes, Packed):
                outcomes = [_by(job.method, outcome) for outcome in unpack(outcomes)]
            yield chunk, outcomes
    except BrokenProcessPool as error:
        unfinished = list(left.values())
        if len(unfinished) == 1:
            (chunk,) = unfinished
            if len(chunk) == 1:
                yield chunk, [WorkerDied(f"scene {scenes[chunk[0]].name!r}: {error}")]
                return
            unfinished = [[i] for i in chunk]
        middle = len(unfinished) // 2
        for half in (unfinished[:middle], unfinished[middle:]):
            yield from _run(job, scenes, half, n_jobs)


def _plan_chunk(job: _Job, chunk: Chunk, scenes: list[Scene]) -> tuple[Chunk, list[PlanOrError] | Packed]:
    _watch_over(job.process)
    outcomes = [_plan_one(_robot(job.robot), scene, job.method) for scene in scenes]
    if os.getpid() == job.process:
        return chunk, outcomes
    # A method may hold functions that do not pickle. Who asked for the plans has it, and puts it in again.
    auto = as_method("auto")
    return chunk, pack([_by(auto, _that_pickles(outcome)) for outcome in outcomes], job.folder)


@cache
def _watch_over(process: int) -> None:
    """Have a worker end with the process that started it, if that is the one that wants the results."""
    if os.getppid() == process:
        end_with_parent(process)


def _by(method: PlanningMethod, outcome: PlanOrError) -> PlanOrError:
    """Return an outcome as one of a method."""
    if isinstance(outcome, Trajectory):
        return replace(outcome, provenance=replace(outcome.provenance, method=method))
    return outcome


def _of(robot: Robot, scene: Scene, outcome: PlanOrError) -> PlanOrError:
    """Return an outcome that knows its robot and its scene."""
    return replace(outcome, robot=robot, scene=scene) if isinstance(outcome, Trajectory) else outcome


@lru_cache(maxsize=4)
def _robot(pickled: bytes) -> Robot:
    """Return the robot that a worker makes once and keeps, with what the engine makes of it."""
    robot: Robot = pickle.loads(pickled)
    return robot


def _plan_one(robot: Robot, scene: Scene, method: PlanningMethod) -> PlanOrError:
    try:
        # Who asked for the plan has robot and scene: they need not come back with it.
        return replace(plan(robot, scene, method), robot=None, scene=None)
    except Exception as error:  # whatever it is, it is this scene's result
        return error
    except SystemExit as error:  # one of the user's functions must not end the process
        return HumanoidRailError(f"SystemExit: {error}")


def _that_pickles(outcome: PlanOrError) -> PlanOrError:
    """Return an outcome that can go to another process: an exception that cannot becomes its text."""
    if isinstance(outcome, Trajectory):
        return outcome
    try:
        pickle.loads(pickle.dumps(outcome))
    except Exception:  # what an exception carries need not pickle
        if isinstance(outcome, InvalidInput):
            return InvalidInput(outcome.field, short(outcome.value), outcome.valid, outcome.source)
        return HumanoidRailError(f"{type(outcome).__name__}: {_text(outcome)}")
    return outcome


def _text(error: Exception) -> str:
    try:
        return str(error)
    except Exception:  # nor need it have a text
        return "its text cannot be read"
