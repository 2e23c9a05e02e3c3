"""A program of the command solver, for tests: python3 child.py MODE [FILE].

Pixel p of an image is gain * change[p % channels]; "parameters" may hold {"gain": ...}. The modes do
one thing otherwise. It needs Python's own library alone.
"""

import array
import json
import os
import signal
import subprocess
import sys
import time

mode = sys.argv[1]
told = json.loads(sys.stdin.buffer.readline())
out = sys.stdout.buffer
channels = told["channels"]
pixels = told["image"][0] * told["image"][1]
gain = told["parameters"].get("gain", 1.0)


def say(line):
    out.write(line.encode() + b"\n")
    out.flush()


def whole(count):
    data = sys.stdin.buffer.read(count)
    if len(data) < count:
        if mode == "die-at-end":
            os.kill(os.getpid(), signal.SIGSEGV)
        if mode == "hang-at-end":
            time.sleep(600)
        sys.exit(3 if mode == "fail-at-end" else 0)
    return data


fits = 0
if mode == "fit":
    marks = os.path.join(told["work_folder"], "fits.txt")
    if not os.path.exists(marks):
        with open(marks, "w") as file:
            file.write(json.dumps(told))
        fits = 1
elif mode == "crash-early":
    os.kill(os.getpid(), signal.SIGSEGV)
elif mode == "raise":
    raise ValueError("no sheet without electrodes")
elif mode == "slow":
    time.sleep(600)
elif mode == "refuse":
    say(json.dumps({"error": "needs a training set"}))
    time.sleep(600)
elif mode == "chat":
    print("I am ready!")
    sys.stdout.flush()
elif mode == "endless":
    while True:
        out.write(b"x" * 4096)
elif mode == "memory":
    hoard = bytearray(600 << 20)
    hoard[:: 1 << 12] = b"x" * len(hoard[:: 1 << 12])
    time.sleep(600)
elif mode == "scenes":
    for n in (5, 5, 3):  # all ahead
        say(json.dumps({"scenes": n}))
    with open(os.path.join(told["work_folder"], "scenes.bin"), "wb") as file:
        for n in (5, 5, 3):
            file.write(whole(8 * n * (channels + pixels)))
elif mode == "many-scenes":
    say(json.dumps({"scenes": 1 << 20}))
elif mode == "leave":
    left = subprocess.Popen(["sleep", "600"], start_new_session=True)
    with open(sys.argv[2], "w") as file:
        file.write(str(left.pid))

say(json.dumps({"ready": True, "parameters": {"gain": gain, **({"fits": fits} if mode == "fit" else {})}}))
if mode == "print":
    say("one more thing")

while True:
    n = int.from_bytes(whole(8), "little")
    changes = array.array("d", whole(8 * n * channels))
    if mode == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if mode == "close":
        os.close(1)
        time.sleep(600)
    if mode == "quit":
        sys.stderr.write("out of ideas\n")
        sys.exit(3)
    if mode == "hang":
        time.sleep(600)
    images = array.array("d", bytes(8 * n * pixels))
    for frame in range(n):
        for pixel in range(pixels):
            images[frame * pixels + pixel] = gain * changes[frame * channels + pixel % channels]
    if mode == "nan":
        images[3] = float("nan")
    status = bytes([1 if mode == "status" and frame % 2 else 0 for frame in range(n)])
    if mode == "odd-status":
        status = b"\x09" * n
    data = images.tobytes() + status
    if mode == "short":
        data = data[:-100]
    if mode == "long":
        data += b"\0" * 100
    out.write(data)
    out.flush()
