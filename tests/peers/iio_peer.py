"""The channels as libiio's programs and its Python bindings read them."""

import struct
import subprocess
import time

import iio
from bench import INDEX_OHM, Bench, check, free_port, until


def run(*command):
    done = subprocess.run(command, capture_output=True, timeout=30)
    return done.returncode, done.stdout, done.stderr.decode()


with Bench() as bench:
    port = free_port()
    uri = f"ip:127.0.0.1:{port}"
    bench.cermctl("bridge", "iio", "--listen", f"127.0.0.1:{port}", "--stale", "2 s")

    def uncertainty():
        """Of the second channel, ohm."""
        code, text, _ = run("iio_attr", "-u", uri, "-c", "cermd", "resistance1", "uncertainty")
        return float(text) if code == 0 and text.strip() else float("inf")

    until("a reading that has settled", lambda: uncertainty() < 5)

    code, info, errors = run("iio_info", "-u", uri)
    text = info.decode()
    check("iio_info reads it", code == 0 and "iio:device0: cermd (buffer capable)" in text, errors)
    for wanted in ["4 channels found", "resistance0: thumb (input, index: 0, format: le:S64/64>>0)", "force0: thumb", "timestamp:"]:
        check(f"it has {wanted!r}", wanted in text, "" if wanted in text else text)
    code, value, errors = run("iio_attr", "-u", uri, "-c", "cermd", "resistance1", "input")
    check("iio_attr reads the value", abs(float(value) - INDEX_OHM) < 0.02 * INDEX_OHM, value.decode().strip() + errors)
    check("and its state", run("iio_attr", "-u", uri, "-c", "cermd", "resistance1", "status")[1].strip() == b"ok")

    since = time.time_ns()
    code, rows, errors = run("iio_readdev", "-u", uri, "-b", "10", "-s", "40", "cermd", "resistance1", "timestamp")
    check("iio_readdev reads a buffer", code == 0 and len(rows) == 40 * 16, f"{len(rows)} bytes {errors}")
    rows = list(struct.iter_unpack("<qq", rows))
    worst = max(abs(milliohm / 1000 - INDEX_OHM) for milliohm, _ in rows)
    check("every row has the value", worst < 0.02 * INDEX_OHM, f"at most {worst:.3f} ohm off")
    times = [at for _, at in rows]
    steps = [(after - before) / 1e6 for before, after in zip(times, times[1:])]
    check("rows are in order, of now, and none is missing", times[0] >= since - 1e9 and all(5 < step < 50 for step in steps),
          f"{min(steps):.1f} to {max(steps):.1f} ms apart")  # fmt: skip
    code, rows, errors = run("iio_readdev", "-u", uri, "-b", "5", "-s", "10", "cermd")
    check("all channels at once", code == 0 and len(rows) == 10 * 8 * 4, f"{len(rows)} bytes {errors}")

    context = iio.Context(uri)
    device = context.find_device("cermd")
    channel = device.find_channel("index")
    check("Python finds a channel by its name", channel.id == "resistance1", context.description)
    raw, scale = float(channel.attrs["raw"].value), float(channel.attrs["scale"].value)
    check("raw times scale is the value", abs(raw * scale - INDEX_OHM) < 0.02 * INDEX_OHM, raw * scale)
    channel.enabled = True
    buffer = iio.Buffer(device, 8)
    buffer.refill()
    check("Python reads a buffer", len(buffer.read()) == 64, len(buffer.read()))
    del buffer

    bench.kill_daemon()
    code, value, errors = run("iio_attr", "-u", uri, "-c", "cermd", "resistance1", "input")
    check("without cermd there is no value", code != 0 or not value.strip(), (value.decode() + errors).strip())
    try:
        check("nor for a context from before", False, channel.attrs["input"].value)
    except OSError as error:
        check("nor for a context from before", True, error)
    check("and the state says so", channel.attrs["status"].value == "unknown")
    since = time.monotonic()
    bench.start_daemon()
    until("readings again", lambda: channel.attrs["status"].value == "ok")
    check("it is back", True, f"{time.monotonic() - since:.1f} s after its start")
