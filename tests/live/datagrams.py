"""Runs `ertbench live --send` and holds its datagrams against its lines: datagrams.py ERTBENCH FRAMES SOLVER."""

import json
import math
import pathlib
import socket
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "examples/ros2"))
from contacts_node import parse  # noqa: E402

program, frames, solver = sys.argv[1:]
assert parse(b"") is None and parse(b"ERTC" + bytes(37)) is None
for kind in ("binary", "json"):
    port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    port.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    port.bind(("127.0.0.1", 0))
    port.settimeout(10)
    lines = subprocess.run(
        [program, "live", "--solver", solver, "--input", f"replay:{frames}", "--lossless", "--send",
         f"udp://127.0.0.1:{port.getsockname()[1]}", "--send-format", kind],
        check=True, capture_output=True, text=True).stdout.splitlines()
    answers = [line for line in map(json.loads, lines) if "contacts" in line]
    assert len(answers) >= 5 and any(answer["contacts"] for answer in answers), len(answers)
    for answer in answers:
        bytes_ = port.recv(65536)
        if kind == "json":
            assert json.loads(bytes_) == answer
            continue
        sent = parse(bytes_)
        assert sent["frame"] == answer["frame"], (sent, answer)
        assert (sent["status"] == 0) == (answer["status"] == "ok")
        assert math.isclose(sent["time_s"], answer["time_s"], abs_tol=1e-6)
        assert math.isclose(1e6 * sent["latency_s"], answer["latency_us"], rel_tol=1e-5)
        assert sent["dead_electrodes"] == answer["dead_electrodes"]
        assert len(sent["contacts"]) == len(answer["contacts"])
        for a, b in zip(sent["contacts"], answer["contacts"]):
            for key in ("x_mm", "y_mm", "strength", "peak", "area_mm2"):
                assert math.isclose(a[key], b[key], rel_tol=1e-5, abs_tol=1e-3), (key, a, b)
            assert math.isnan(a["force_N"]) == (b["force_N"] is None)
