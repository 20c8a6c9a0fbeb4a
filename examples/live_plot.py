#!/usr/bin/env python3
"""A live plot of a channel with its uncertainty: live_plot.py [CHANNEL]. Needs clients/python and matplotlib. Not tested."""

import sys
import time
from collections import deque

import matplotlib.pyplot as plt
from matplotlib.animation import FuncAnimation

import cermd

SECONDS, MAX_HZ = 30, 50
channel = sys.argv[1] if len(sys.argv) > 1 else "thumb"
stream = cermd.readings(channel, max_hz=MAX_HZ)
points = deque(maxlen=SECONDS * MAX_HZ)
figure, axes = plt.subplots()
# Until there is a number.
unit = ""


def draw(_frame):
    global unit
    while (reading := stream.get(timeout=0.0)) is not None:
        unit = reading.unit or unit
        # A state is a gap, not a zero.
        value = float("nan") if reading.value is None else reading.value
        points.append((reading.monotonic_ns * 1e-9, value, reading.value_u or 0.0))
    # cermd and this run on one clock, so an outage moves out of the picture.
    times = [at - time.monotonic() for at, _, _ in points]
    values = [value for _, value, _ in points]
    axes.clear()
    axes.plot(times, values)
    low, high = ([value + sign * u for _, value, u in points] for sign in (-1, 1))
    axes.fill_between(times, low, high, alpha=0.3, label="1 sigma")
    axes.set(xlabel="s", ylabel=f"{channel}, {unit}", xlim=(-SECONDS, 0))
    axes.legend(loc="upper left")


animation = FuncAnimation(figure, draw, interval=100, cache_frame_data=False)
plt.show()
