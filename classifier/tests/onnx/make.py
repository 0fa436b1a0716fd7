"""Write the small networks of the tests in this folder. Needs the package onnx from PyPI; those here were written by 1.23.2.

    python classifier/tests/onnx/make.py
"""

from pathlib import Path

import onnx

HEAD = """<
  ir_version: 8, opset_import: ["" : 17],
  metadata_props: ["underbrush.features": "force", "underbrush.window": "{window}",
    "underbrush.categories": "leaf,trunk", "underbrush.output": "{output}"]
>
"""

LINEAR = """linear (float[N, 2] x) => (int64[N] label, float[N, 2] p)
<float[2, 2] W = {0, 3, 0.5, -1}, float[2] b = {0.25, -0.5}>
{
  y = MatMul (x, W)
  z = Add (y, b)
  p = Softmax <axis = 1> (z)
  label = ArgMax <axis = 1, keepdims = 0> (p)
}"""

# The logarithm of a negative number, for forces above 1 N.
NOT_A_NUMBER = """logarithm (float[1, 2] x) => (float[1, 2] p)
<float one = {1}>
{
  room = Sub (one, x)
  score = Log (room)
  p = Softmax <axis = 1> (score)
}"""

# One over a force less 1 N.
INFINITE = """division (float[1, 2] x) => (float[1, 2] z)
<float one = {1}>
{
  above = Sub (x, one)
  z = Div (one, above)
}"""

# The forces themselves: no probabilities.
NO_PROBABILITIES = """identity (float[1, 2] x) => (float[1, 2] p)
<float zero = {0}>
{
  p = Add (x, zero)
}"""

# The places of the forces below 1 N, as many as there are.
CHANGING_SHAPE = """places (float[1, 2] x) => (float[n] p)
<float one = {1}, int64 second = {1}>
{
  small = Less (x, one)
  indices = NonZero (small)
  columns = Gather <axis = 0> (indices, second)
  p = Cast <to = 1> (columns)
}"""

# The row of a table that the second force names: none from 2 N on.
NO_SUCH_ROW = """table (float[1, 2] x) => (float[1, 2] p)
<float[2, 2] rows = {0.5, 0.5, 0.25, 0.75}, int64[1] second = {1}, int64[1] axis = {0}>
{
  force = Gather <axis = 1> (x, second)
  index = Cast <to = 7> (force)
  flat = Squeeze (index, axis)
  p = Gather <axis = 0> (rows, flat)
}"""

# A label as text beside the probabilities, as skl2onnx exports it.
LABEL = """label (float[1, 2] x) => (string[1] label, float[1, 2] p)
<string[2] names = {"leaf", "trunk"}>
{
  p = Softmax <axis = 1> (x)
  index = ArgMax <axis = 1, keepdims = 0> (p)
  label = Gather <axis = 0> (names, index)
}"""

FILES = {
    "linear": (LINEAR, 2, "probabilities"),
    "other_window": (LINEAR, 3, "probabilities"),
    "not_a_number": (NOT_A_NUMBER, 2, "probabilities"),
    "infinite": (INFINITE, 2, "log-odds"),
    "no_probabilities": (NO_PROBABILITIES, 2, "probabilities"),
    "changing_shape": (CHANGING_SHAPE, 2, "probabilities"),
    "no_such_row": (NO_SUCH_ROW, 2, "probabilities"),
    "label": (LABEL, 2, "probabilities"),
}

for name, (graph, window, output) in FILES.items():
    head = HEAD.replace("{window}", str(window)).replace("{output}", output)
    model = onnx.parser.parse_model(head + graph)
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, Path(__file__).with_name(f"{name}.onnx"))
