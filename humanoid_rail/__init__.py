"""Motion planning for redundant two-armed robots, after Kacprzak and Pajak (2019). Every motion comes with a proof.

>>> from humanoid_rail import load_robot, load_scene, plan
>>> trajectory = plan(load_robot(), load_scene("scenes/picks.yaml"))

The public names are those of `__init__.pyi`. They are imported when they are first used, so that `import humanoid_rail`
is quick.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
