"""Hidden Markov models here and in hmmlearn (and dynamax, where it is installed): the same models on the same sequences.

    pip install -r benches/peers/hmm-requirements.txt
    python benches/peers/hmm.py [--states 10 20] [--repeats 3]

Run it from the root of the workspace. Sequences are presses of two categories, models are left-to-right as in the
authors' recipe, and every model scores both categories. First, log-likelihoods are compared: they must agree within
1e-9 where the peer's are finite, and disagreements and failures are counted and printed. Then nanoseconds per sample
are measured on one thread, as the fastest of several runs, in processor time so that other programs disturb less. Ours
come from `benches/peers/hmm.rs`.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", XLA_FLAGS="--xla_cpu_multi_thread_eigen=false")

try:
    import numpy as np
    from hmmlearn.hmm import GaussianHMM
except ImportError as missing:
    sys.exit(f"{missing}: install the peers first, `pip install -r benches/peers/hmm-requirements.txt`")

ITERATIONS = 10


def sequences(category, rng):
    """Presses that rise, hold and fall: force of each sample, N."""
    size = {"leaf": 0.5, "trunk": 3.0}[category]
    for _ in range(100):
        phase = np.linspace(0, 1, rng.integers(50, 150))
        shape = np.minimum(1, 4 * phase) * np.minimum(1, 5 * (1 - phase))
        yield np.abs(size * rng.uniform(0.5, 1.5) * shape + rng.normal(0, 0.05 * size, len(phase)))


def start(states, own):
    """A model from equal time slices, upper triangular."""
    slices = [np.concatenate([np.array_split(one, states)[k] for one in own]) for k in range(states)]
    transition = np.triu(np.full((states, states), 0.05)) + 0.4 * np.eye(states) + 0.3 * np.eye(states, k=1)
    transition /= transition.sum(axis=1, keepdims=True)
    return {
        "initial": [1 / states] * states,
        "transition": transition.tolist(),
        "mean": [[float(part.mean())] for part in slices],
        "covariance": [[[float(max(part.var(), 1e-4))]] for part in slices],
    }


def quickest(repeats, work):
    best = float("inf")
    for _ in range(repeats):
        begin = time.process_time()
        work()
        best = min(best, time.process_time() - begin)
    return best


def hmmlearn_model(parameters, implementation):
    model = GaussianHMM(len(parameters["initial"]), covariance_type="full", implementation=implementation,
                        init_params="", n_iter=ITERATIONS, tol=-np.inf)
    model.startprob_, model.transmat_ = np.array(parameters["initial"]), np.array(parameters["transition"])
    model.means_, model.covars_ = np.array(parameters["mean"]), np.array(parameters["covariance"])
    return model


def by_hmmlearn(parameters, everything, own, repeats, implementation):
    model = hmmlearn_model(parameters, implementation)

    def score():
        scores = []
        for one in everything:
            try:
                scores.append(model.score(one[:, None]))
            except ValueError:  # With scaling, scoring fails on data of another category.
                scores.append(np.nan)
        return scores

    columns, lengths = np.concatenate(own)[:, None], [len(one) for one in own]
    train = quickest(repeats, lambda: hmmlearn_model(parameters, implementation).fit(columns, lengths))
    return score(), quickest(repeats, score), train / ITERATIONS


def by_dynamax(parameters, everything, repeats):
    import jax
    import jax.numpy as jnp
    from dynamax.hidden_markov_model import hmm_filter
    jax.config.update("jax_enable_x64", True)
    initial, transition, mean, covariance = (jnp.array(parameters[key]) for key in
                                             ("initial", "transition", "mean", "covariance"))

    @jax.jit
    def filtered(values, count):
        log_density = -0.5 * ((values - mean.T) ** 2 / covariance[:, 0].T + jnp.log(2 * jnp.pi * covariance[:, 0].T))
        # Sequences are padded to one length, because each length would be compiled anew. A padded sample changes
        # nothing.
        log_density = jnp.where(jnp.arange(len(values))[:, None] < count, log_density, 0.0)
        return hmm_filter(initial, transition, log_density).marginal_loglik

    longest = max(map(len, everything))
    padded = [(jnp.pad(jnp.array(one), (0, longest - len(one)))[:, None], len(one)) for one in everything]

    def score():
        return [float(filtered(values, count)) for values, count in padded]

    score()
    return score(), quickest(repeats, score), None


def by_us(models, trials, repeats):
    with tempfile.TemporaryDirectory() as folder:
        table, file = os.path.join(folder, "trials.csv"), os.path.join(folder, "models.json")
        with open(table, "w", encoding="utf-8") as out:
            print("trial,category,time_s,force_n", file=out)
            for number, (category, values) in enumerate(trials):
                for index, value in enumerate(values):
                    print(f"{number},{category},{0.01 * index!r},{float(value)!r}", file=out)
        with open(file, "w", encoding="utf-8") as out:
            json.dump({"format": FORMAT, "features": ["force_n"], "models": models}, out)
        command = ["cargo", "run", "--release", "-q", "--example", "hmm_peer", "--"]
        found = subprocess.run([*command, table, file, str(repeats)], check=True, capture_output=True, text=True)
        return json.loads(found.stdout)


# As in the start models of classifier/tests/data/hmm.
with open("classifier/tests/data/hmm/5-states-force-left-right.start.json", encoding="utf-8") as example:
    FORMAT = json.load(example)["format"]


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--states", type=int, nargs="+", default=[10, 20])
    options.add_argument("--repeats", type=int, default=3)
    options = options.parse_args()
    rng = np.random.default_rng(1)
    trials = [(category, values) for category in ("leaf", "trunk") for values in sequences(category, rng)]
    everything = [values for _, values in trials]
    samples = sum(map(len, everything))
    print("| states | model | library | Baum-Welch ns | forward ns | worst relative difference | wrong or failed |")
    print("|---|---|---|---|---|---|---|")
    for states in options.states:
        of = {category: [values for name, values in trials if name == category] for category in ("leaf", "trunk")}
        models = {category: start(states, own) for category, own in of.items()}
        found = by_us(models, trials, options.repeats)
        for category, own in of.items():
            us = np.array(found[category]["forward"])
            row = found[category]
            print(f"| {states} | {category} | here, four at a time | {row['iteration_ns_per_sample']:.0f} "
                  f"| {row['forward_ns_per_sample']:.0f} | – | – |")
            print(f"| {states} | {category} | here, one by one | – | {row['forward_single_ns_per_sample']:.0f} | – | – |")
            peers = {
                "hmmlearn, log": lambda: by_hmmlearn(models[category], everything, own, options.repeats, "log"),
                "hmmlearn, scaling": lambda: by_hmmlearn(models[category], everything, own, options.repeats, "scaling"),
                "dynamax": lambda: by_dynamax(models[category], everything, options.repeats),
            }
            reference = None
            for name, measure in peers.items():
                try:
                    scores, scoring, training = measure()
                except ImportError:
                    print(f"{name} is not installed", file=sys.stderr)
                    continue
                except ValueError as failed:
                    print(f"{name} failed: {failed}", file=sys.stderr)
                    continue
                difference = np.abs((np.array(scores) - us) / us)
                agrees = difference < 1e-9
                if name == "hmmlearn, log":
                    reference = agrees.all()
                worst = difference[agrees].max() if agrees.any() else float("nan")
                train = "–" if training is None else f"{1e9 * training / sum(map(len, own)):.0f}"
                print(f"| {states} | {category} | {name} | {train} | {1e9 * scoring / samples:.0f} "
                      f"| {worst:.0e} | {(~agrees).sum()} of {len(us)} |")
            if not reference:
                sys.exit("ours and hmmlearn's log-space scores differ by more than 1e-9")


if __name__ == "__main__":
    main()
