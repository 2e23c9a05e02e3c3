"""Sends frames to udp_contacts, and damaged ones between them; a contact must come of those that changed."""

import json
import socket
import struct
import subprocess
import sys
import time

program, solver = sys.argv[1:]
free = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
free.bind(("127.0.0.1", 0))
port = free.getsockname()[1]
free.close()

child = subprocess.Popen([program, solver, str(port)], stdout=subprocess.PIPE, text=True)
time.sleep(1)
out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
quiet = [0.01 + 1e-4 * (i % 7) for i in range(208)]
touched = [v + (1e-3 if i < 30 else 0) for i, v in enumerate(quiet)]
for frame in (quiet, touched[:100], touched, touched + touched, quiet):
    out.sendto(struct.pack(f"<{len(frame)}f", *frame), ("127.0.0.1", port))
out.sendto(b"", ("127.0.0.1", port))
lines = child.communicate(timeout=60)[0].splitlines()
assert child.returncode == 0, child.returncode
contacts = [json.loads(line)["contacts"] for line in lines]
assert [bool(one) for one in contacts] == [False, True, False], contacts
assert all(abs(c["x_mm"]) < 110 and abs(c["y_mm"]) < 110 for c in contacts[1]), contacts
