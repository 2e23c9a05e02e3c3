#!/usr/bin/python3
"""check_onnx.py MODEL: Debian's python3-onnx on a model; exit code 77 where it is not installed."""
import sys

try:
    import onnx
except ImportError:
    sys.exit(77)
model = onnx.load(sys.argv[1])
onnx.checker.check_model(model, full_check=True)
assert [output.name for output in model.graph.output] == ["conductivity_change"]
