"""Times PyTorch's own LSTM and GRU, and ONNX Runtime's prediction with them, on one CPU thread, as the reference for `cargo bench -p precomp-models`.

    pip install torch numpy onnx onnxruntime
    python benches/pytorch/recurrent.py [--repeats 20]

Prints, in milliseconds (the least of the repeats), a training step (forward, mean-square loss, backward, Adam) of a stack of
3 layers of 128 units with a linear head, 32 sequences of 128 steps, 10 features; the same without the optimiser; and the
prediction of one long sequence.
"""

import argparse
import io
import time

import onnxruntime
import torch

LAYERS, HIDDEN, BATCH, STEPS, INPUT, LONG = 3, 128, 32, 128, 10, 4096


def least_ms(repeats, work):
    """Least time of `repeats` calls after two to warm up, ms."""
    for _ in range(2):
        work()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)


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


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=20)
    repeats = parser.parse_args().repeats
    torch.set_num_threads(1)
    torch.manual_seed(0)
    print(f"PyTorch {torch.__version__}, {torch.get_num_threads()} thread")
    for name, layer in [("lstm", torch.nn.LSTM), ("gru", torch.nn.GRU)]:
        net = layer(INPUT, HIDDEN, LAYERS, batch_first=True)
        head = torch.nn.Linear(HIDDEN, 1)
        parameters = list(net.parameters()) + list(head.parameters())
        optimiser = torch.optim.Adam(parameters, lr=1e-3)
        x = torch.randn(BATCH, STEPS, INPUT)
        y = torch.randn(BATCH, STEPS, 1)

        def gradients():
            optimiser.zero_grad(set_to_none=True)
            torch.nn.functional.mse_loss(head(net(x)[0]), y).backward()

        def step():
            gradients()
            optimiser.step()

        sequence = torch.randn(1, LONG, INPUT)

        def predict():
            with torch.no_grad():
                head(net(sequence)[0])

        print(f"{name} training step   {least_ms(repeats, step):9.2f} ms")
        print(f"{name} gradients       {least_ms(repeats, gradients):9.2f} ms")
        print(f"{name} predict {LONG}    {least_ms(max(3, repeats // 4), predict):9.2f} ms")
        session = onnx_session(net, head, sequence)
        feed = {"x": sequence.numpy()}
        print(f"{name} predict {LONG}    {least_ms(max(3, repeats // 4), lambda: session.run(None, feed)):9.2f} ms, ONNX Runtime")


if __name__ == "__main__":
    main()
