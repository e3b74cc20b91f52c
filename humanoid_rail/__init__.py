"""Motion planning for redundant two-armed robots, after Kacprzak and Pajak (2019). Every motion comes with a proof.

>>> from humanoid_rail import load_robot_of_scene, load_scene, plan
>>> scene = load_scene("scenes/picks.yaml")
>>> trajectory = plan(load_robot_of_scene(scene), scene)

The public names are those of `__init__.pyi`. They are imported when they are first used, so that `import humanoid_rail`
is quick.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
