"""An arm of your own: the Franka Panda of docs/arms/panda. Its URDF comes from the package example-robot-data."""

# %%
from pathlib import Path

import underbrush as ub

# A notebook runs in its own folder.
here = Path(globals().get("__file__", "own_arm.ipynb")).resolve()
folder = here.parents[2] / "docs" / "arms" / "panda"
arm = ub.Arm.load(folder / "panda.toml")
print(arm, arm.skin)

# %%
# The scene names the arm's file.
scene = ub.Scene(folder / "foliage.toml").changed({"goals": {"count": 1, "retries": 0, "patience_s": 1.0}})
reach = ub.reach(scene, seed=1)
print(reach, "touched", sorted({contact["link"] for contact in reach.contacts}))
assert reach.skin == arm.skin

# %%
reach.draw()
