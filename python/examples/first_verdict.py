"""Ten lines from nothing to a verdict: simulate, cut contacts, fit, classify a new reach frame by frame."""

# %%
import tempfile
from collections import Counter
from pathlib import Path

import underbrush as ub

out = Path(tempfile.mkdtemp()) / "data"
data = ub.generate(["leaf", "trunk"], reaches=2, out=out, seed=1)
trials = data.trials(labels="environment", min_samples=20)
model = ub.fit(trials)
reach = ub.reach("mixed", seed=3)
online = model.online(reach.skin, "forearm", decision=15.0)
verdicts = [own["verdict"] for index in range(len(reach)) for own in online.update(reach.frame(index))]
print(Counter(verdicts))

# %%
# The moment in which the arm touched the most. The taxels have the colours of the forces that they sense.
reach.draw()

# %%
found = ub.evaluate(trials, ub.Options())
print(f"accuracy {found['accuracy']:.3f}, majority baseline {found['majority_baseline']:.3f}")
assert set(verdicts) <= {"leaf", "trunk", "uncertain"}
