"""Turns the datagrams of `ertbench live --send udp://127.0.0.1:9100 --send-format binary` into a message.

    ros2 topic echo /skin/contacts          # [frame, status, x, y, strength, x, y, strength, ...], mm

`parse` is tested; the node itself was not tried on a robot.
"""

import socket
import struct

HEAD = struct.Struct("<4sHHQdfBBHQ")
CONTACT = struct.Struct("<6f")


def parse(record):
    """The answer in a record of version 1 (docs/live.md), as a dictionary; None if it is no such record."""
    if len(record) < HEAD.size:
        return None
    magic, version, count, frame, time_s, latency_s, status, reasons, _, dead = HEAD.unpack_from(record)
    if magic != b"ERTC" or version != 1 or len(record) != HEAD.size + count * CONTACT.size:
        return None
    names = ("x_mm", "y_mm", "strength", "peak", "area_mm2", "force_N")
    contacts = [dict(zip(names, one)) for one in CONTACT.iter_unpack(record[HEAD.size:])]
    return {"frame": frame, "time_s": time_s, "latency_s": latency_s, "status": status, "reasons": reasons,
            "dead_electrodes": [e for e in range(64) if dead >> e & 1], "contacts": contacts}


def main():
    import rclpy
    from std_msgs.msg import Float32MultiArray

    rclpy.init()
    publisher = rclpy.create_node("ertbench").create_publisher(Float32MultiArray, "skin/contacts", 10)
    port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    port.bind(("127.0.0.1", 9100))
    while rclpy.ok():
        answer = parse(port.recv(65536))
        if answer:
            places = [c[key] for c in answer["contacts"] for key in ("x_mm", "y_mm", "strength")]
            publisher.publish(Float32MultiArray(data=[float(answer["frame"]), float(answer["status"])] + places))


if __name__ == "__main__":
    main()
