"""The Python package: its types, its wheel in a fresh environment, and the real cermd; the sensor of gpiozero."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

from bench import INDEX_OHM, Bench, check, until

PACKAGE = Path(__file__).resolve().parents[2] / "clients/python"


def wheel(folder):
    """Built from a copy, so that nothing is left behind, and without the network."""
    subprocess.run(["cp", "-r", PACKAGE, folder / "package"], check=True)
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", folder, folder / "package"]
    subprocess.run(command, check=True)
    return next(folder.glob("cermd-*.whl"))


with Bench() as bench:
    typed = subprocess.run(["mypy", "--config-file", PACKAGE / "pyproject.toml", "-p", "cermd"], capture_output=True, text=True,
                           env={**os.environ, "MYPYPATH": str(PACKAGE / "src")}, cwd=bench.path)  # fmt: skip
    check("mypy --strict", typed.returncode == 0, typed.stdout.strip())
    built = wheel(bench.path)
    target = bench.path / "installed"
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-index", "--no-deps", "--target", target, built], check=True)
    check("a wheel is built and installed", (target / "cermd/py.typed").exists(), built.name)
    sys.path.insert(0, str(target))

    import cermd

    check("the installed one is used", Path(cermd.__file__).is_relative_to(target))
    path = str(bench.socket)

    reading = next(cermd.readings("index", socket=path))
    until("a reading that has settled", lambda: cermd.latest("index", socket=path).is_ok)
    reading = cermd.latest("index", socket=path)
    check("a value with its uncertainty", abs(reading.ohms - INDEX_OHM) < 0.02 * INDEX_OHM and reading.ohms_u > 0, reading)
    check("its time", abs(reading.time.timestamp() - time.time()) < 5 and 0 <= reading.age() < 5, reading.time)
    check("what is unknown is None", reading.newtons is None and reading.fault is None)
    check("stats", cermd.stats(socket=path)["backend"] == "mock")
    for what, does in [("a wrong channel", lambda: next(cermd.readings("toe", socket=path))),
                       ("no daemon", lambda: cermd.latest("thumb", socket=str(bench.path / "none")))]:  # fmt: skip
        try:
            does()
            check(f"{what} is an error", False)
        except cermd.CermdError as error:
            check(f"{what} is an error", True, error)

    seen = []
    stream = cermd.readings("thumb", "index", socket=path, max_hz=20)
    thread = threading.Thread(target=lambda: [seen.append(reading) for reading in stream])
    thread.start()
    until("readings of both", lambda: {reading.channel for reading in seen} == {"thumb", "index"})
    bench.kill_daemon()
    killed = time.monotonic_ns()
    time.sleep(1)
    bench.start_daemon()
    _, took = until("readings after a restart", lambda: seen[-1].monotonic_ns > killed)
    check("it connects again", True, f"{took:.2f} s after the start")
    stream.close()
    thread.join(2)
    check("close ends the loop of another thread", not thread.is_alive())
    started = time.monotonic()
    with cermd.readings("thumb", socket=str(bench.path / "none")) as nobody:
        check("get returns in time without a daemon", nobody.get(0.3) is None and 0.2 < time.monotonic() - started < 1)

    with cermd.readings("index", socket=path) as stream:
        until("a reading without a wait", lambda: stream.get(0.0))
        time.sleep(0.5)
        waiting = 0
        while stream.get(0.0) is not None:
            waiting += 1
        check("get takes what has come without a wait", waiting > 5, f"{waiting} readings")

    with cermd.events("thumb", socket=path) as stream:
        first, _ = until("an event at once", lambda: stream.get(1.0))
        told = [first, *(next(stream) for _ in range(3))]
        known = [event.is_pressed for event in told if event.reason is None]
        check("events take turns", all(a != b for a, b in zip(known, known[1:])) and len(known) >= 2, known)

    source = PACKAGE.parents[1] / "examples/readings.c"
    subprocess.run(["cc", "-Wall", "-Wextra", "-Werror", "-o", bench.path / "readings", source], check=True)
    with subprocess.Popen([bench.path / "readings", path], stdout=subprocess.PIPE, text=True) as example:
        lines = [example.stdout.readline() for _ in range(10)]
        example.kill()
    values = [float(line.split()[1]) for line in lines if line.startswith("index ")]
    check("the example in C", len(values) >= 3 and all(abs(v - INDEX_OHM) < 0.02 * INDEX_OHM for v in values), lines[-1].strip())

    from cermd.gpiozero import ForceSensor

    events = []
    with ForceSensor("thumb", full_scale=20, threshold=6, socket=path, stale=0.5) as sensor:
        sensor.when_activated = lambda: events.append("pressed")
        sensor.when_deactivated = lambda: events.append("released")
        check("wait_for_active", sensor.wait_for_active(20) is not False and sensor.is_active, sensor.force)
        check("value is of the full scale", abs(sensor.value - sensor.force / 20) < 0.2, sensor.value)
        until("two presses", lambda: events.count("pressed") >= 2)
        check("presses and releases take turns", all(a != b for a, b in zip(events, events[1:])), events)
        sensor.wait_for_active(20)
        bench.kill_daemon()
        sensor.wait_for_inactive(5)
        check("an outage releases", not sensor.is_active and sensor.value is None and events[-1] == "released")
        bench.start_daemon()
        sensor.wait_for_active(20)

    from gpiozero import PWMLED
    from gpiozero.pins.mock import MockFactory, MockPWMPin

    pins = MockFactory(pin_class=MockPWMPin)
    with ForceSensor("thumb", full_scale=20, socket=path, stale=0.5) as sensor, PWMLED(17, pin_factory=pins) as led:
        # From before the first reading on.
        led.source = sensor
        until("an output to follow the sensor", lambda: led.value > 0.3)
        bench.kill_daemon()
        until("it to be off in an outage", lambda: sensor.value is None and led.value == 0)
        bench.start_daemon()
        _, took = until("it to follow again", lambda: led.value > 0.3)
        check("an output follows by its source, and is off where nothing is known", True, f"{took:.2f} s after the start")
        check("there is no source of a sensor", not hasattr(sensor, "source"))
    with ForceSensor("toe", socket=path) as sensor:
        until("the sensor to say what is wrong", lambda: sensor.error is not None)
        check("a channel that is not there is no end of it", sensor.value is None and "toe" in str(sensor.error), sensor.error)
    check("closed", sensor.closed and not [thread for thread in threading.enumerate() if thread is not threading.main_thread()])
