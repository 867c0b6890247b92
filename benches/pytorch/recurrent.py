"""Times the recurrent layers of `precomp-models` beside PyTorch and ONNX Runtime, each on one CPU thread, in turns.

    pip install torch numpy onnx onnxruntime
    python benches/pytorch/recurrent.py [--rounds 10]

Builds the crate's benchmark; then, round by round, runs a piece of it and at once the same with the others, so that a machine
whose speed changes slows all of them alike. The network is a stack of 3 layers of 128 units with a linear head, for 10
features. A training step is forward, mean-square loss, backward and Adam on 32 sequences of 128 steps; a prediction goes over
one sequence of 4096 steps, once step by step and once in chunks of 128 side by side, each begun 64 steps early. Prints the
least time, the lower quartile and the median of all rounds, in milliseconds, and the ratios of those of this project to those
of the others.
"""

import argparse
import io
import json
import os
import pathlib
import subprocess
import tempfile
import time

import onnxruntime
import torch

LAYERS, HIDDEN, BATCH, STEPS, INPUT, LONG = 3, 128, 32, 128, 10, 4096
CHUNKS = "in chunks of 128 after 64"
ROOT = pathlib.Path(__file__).resolve().parents[2]


def build():
    """The benchmark's executable."""
    command = ["cargo", "bench", "-p", "precomp-models", "--bench", "recurrent", "--no-run", "--message-format", "json"]
    made = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True)
    messages = map(json.loads, made.stdout.splitlines())
    return [m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "recurrent"][-1]


def ours(executable, name, seconds):
    """Times of a piece of the benchmark, ms."""
    with tempfile.TemporaryDirectory() as folder:
        limits = ["--sample-size", "10", "--warm-up-time", "0.5", "--measurement-time", str(seconds), "--noplot"]
        environment = {**os.environ, "CRITERION_HOME": folder, "RAYON_NUM_THREADS": "1"}
        command = [executable, "--bench", "--exact", name, *limits]
        subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        (sample,) = pathlib.Path(folder).glob("*/new/sample.json")
        sample = json.loads(sample.read_text())
    return [1e-6 * time / count for time, count in zip(sample["times"], sample["iters"])]


def theirs(work, seconds):
    """Times of calls of `work` after two to warm up, ms."""
    work(), work()
    times = []
    while sum(times) < 1e3 * seconds or len(times) < 3:
        start = time.perf_counter()
        work()
        times.append(1e3 * (time.perf_counter() - start))
    return times


def onnx_session(net, head, sequence):
    """The network as a session of ONNX Runtime on one thread."""

    class Whole(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.net, self.head = net, head

        def forward(self, x):
            return self.head(self.net(x)[0])

    graph = io.BytesIO()
    torch.onnx.export(Whole().eval(), (sequence,), graph, input_names=["x"], output_names=["y"], dynamo=False)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(graph.getvalue(), options, providers=["CPUExecutionProvider"])


def rivals(layer):
    """What the others do for a training step and for a prediction, by their names."""
    net = layer(INPUT, HIDDEN, LAYERS, batch_first=True)
    head = torch.nn.Linear(HIDDEN, 1)
    optimiser = torch.optim.Adam([*net.parameters(), *head.parameters()], lr=1e-3)
    x, y = torch.randn(BATCH, STEPS, INPUT), torch.randn(BATCH, STEPS, 1)
    sequence = torch.randn(1, LONG, INPUT)
    session = onnx_session(net, head, sequence)
    net.train()
    feed = {"x": sequence.numpy()}

    def step():
        optimiser.zero_grad(set_to_none=True)
        torch.nn.functional.mse_loss(head(net(x)[0]), y).backward()
        optimiser.step()

    def predict():
        with torch.no_grad():
            head(net(sequence)[0])

    return {
        "training step": {"PyTorch": step},
        f"predict {LONG}": {"PyTorch": predict, "ONNX Runtime": lambda: session.run(None, feed)},
    }


def statistics(times):
    """Least, lower quartile and median."""
    times = sorted(times)
    return times[0], times[len(times) // 4], times[len(times) // 2]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=2.0, help="of each piece in a round (default 2)")
    options = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(0)
    executable = build()
    print(f"PyTorch {torch.__version__}, ONNX Runtime {onnxruntime.__version__}, {torch.get_num_threads()} thread, {options.rounds} rounds")
    print(f"{'ms':52}   least  quartile    median     ratios")
    for name, layer in [("lstm", torch.nn.LSTM), ("gru", torch.nn.GRU)]:
        for task, works in rivals(layer).items():
            ways = {"precomp": "", f"precomp {CHUNKS}": f" {CHUNKS}"} if "predict" in task else {"precomp": ""}
            times = {who: [] for who in [*ways, *works]}
            for _ in range(options.rounds):
                for who, way in ways.items():
                    times[who] += ours(executable, f"{name} {task}{way}", options.seconds)
                for rival, work in works.items():
                    times[rival] += theirs(work, options.seconds)
            found = {who: statistics(times) for who, times in times.items()}
            for who, values in found.items():
                line = f"{name + ' ' + task + ', ' + who:52}" + "".join(f"{value:10.2f}" for value in values)
                if who in works:
                    shares = ("  ".join(f"{a / b:.3f}" for a, b in zip(found[way], values)) for way in ways)
                    line += "     " + "     ".join(shares)
                print(line, flush=True)


if __name__ == "__main__":
    main()
