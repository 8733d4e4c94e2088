#!/usr/bin/env python3
"""Dead reckoning as a running process: turns as the gyroscope says and walks on at a constant speed. An example of
somebody's own system; it needs Python's standard library alone.

    system: {process: [python3, scenarios/examples/gyro_process.py], needs: [imu]}

One line of JSON comes in, one goes out; scenarios/code/systems/frame_protocol.h lists all keys. Images lie in shared
memory: the bytes of `message["image"]` begin at its "offset" in the file that the first message names ("frames")."""
import json
import math
import sys


def times(a, b):
    """Product of two quaternions x, y, z, w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


def turned(q, v):
    """The vector v turned by q."""
    return times(times(q, [*v, 0]), [-q[0], -q[1], -q[2], q[3]])[:3]


def answer(message, state):
    if message["event"] == "start":
        state.update(R_CI=message["calibration"]["imu"]["X_CI"][3:], q=[0, 0, 0, 1], p=[0, 0, 0], last=None,
                     speed=message["settings"].get("speed_m_s", 0.1))
        return {"ready": True}
    if message["event"] == "finish":
        return {"frames": [], "maps": []}
    for stamp, wx, wy, wz, *_ in message["imu"]:
        dt = (stamp - state["last"]) * 1e-9 if state["last"] is not None else 0
        state["last"] = stamp
        w = turned(state["R_CI"], [wx, wy, wz])
        angle = math.hypot(*w) * dt
        s = math.sin(angle / 2) / angle * dt if angle > 0 else 0
        state["q"] = times(state["q"], [s * w[0], s * w[1], s * w[2], math.cos(angle / 2)])
        ahead = turned(state["q"], [0, 0, 1])
        state["p"] = [p + state["speed"] * dt * a for p, a in zip(state["p"], ahead)]
    return {"status": "tracking", "pose": state["p"] + state["q"]}


if __name__ == "__main__":
    memory = {}
    for line in sys.stdin:
        print(json.dumps(answer(json.loads(line), memory)), flush=True)
