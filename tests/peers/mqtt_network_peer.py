"""The bridge and Mosquitto over a network that is slow, stops, or dies without a word, while readings go on at full rate."""

import time

from bench import CIRCUIT, SCENE, Bench, check, memory_kib, until
from broker import Mosquitto, Network, taken_at

CHANNELS = 12
CONFIG = CIRCUIT + "[gpio]\nbackend = \"mock\"\n" + "".join(f"[[channel]]\nid = \"{i}\"\n" for i in range(CHANNELS)) + """
[server]
socket = "socket"
[mock]
scene = "scene.toml"
"""
MANY = SCENE.split("[[sensor]]")[0] + "[[sensor]]\nconstant = \"1 kohm\"\n" * CHANNELS
TOPIC = "cermd/bench/channel/"
# Of a topic, a payload and what an allocator has around them, at the least.
MESSAGE_BYTES = 300
# Pages that the bridge touches for the first time: what 2500 messages would take.
ROOM_KIB = 750
SLOW_S = 40
STOPPED_S = 3
DEAD_S = 34
KEEP_ALIVE_S = 5
# A broker waits for one and a half of it (MQTT 3.1.1, 3.1.2.10), and Mosquitto looks every 5 s.
BROKER_S = 1.5 * KEEP_ALIVE_S + 5
# From a reading to an ear, on a busy machine.
FRESH_S = 1.0

with Bench(CONFIG, MANY) as bench:
    broker = Mosquitto(bench)
    network = Network(broker.port)
    # Every reading is told: 20 a second of each channel, the most that the bridge asks for.
    bridge = bench.cermctl(
        "bridge", "mqtt", "--broker", "127.0.0.1", "--port", network.port, "--id", "bench", "--every", "10 ms",
        "--at-most-every", "10 ms",
    )  # fmt: skip

    def ages(since, until_then=None):
        """Of the readings that were heard since: how old they were when they came."""
        found = [at - taken_at(reading) for at, reading in broker.readings(since, TOPIC) if at <= (until_then or at)]
        return found or [float("inf")]

    def worst_memory(seconds):
        worst, end = 0, time.monotonic() + seconds
        while time.monotonic() < end:
            worst = max(worst, memory_kib(bridge))
            time.sleep(0.1)
        return worst

    def check_memory(what, before, seconds):
        """Over so many seconds; what was not told in them would not have fitted."""
        since = time.time()
        worst = worst_memory(seconds)
        untold = rate * seconds - len(broker.readings(since, TOPIC))
        leak = untold * MESSAGE_BYTES / 1024
        check(f"{what}: memory would show what piles up", leak > 1.5 * ROOM_KIB, f"{untold:.0f} readings, {leak:.0f} KiB")
        check(f"{what}: nothing piles up", worst - before < ROOM_KIB, f"{before} -> {worst} KiB")

    def check_fresh(what, since):
        """From some instant on."""
        time.sleep(3)
        oldest = max(ages(since + FRESH_S))
        check(f"{what}: what is told after it is of now", oldest < FRESH_S, f"the oldest {oldest:.2f} s")

    until("readings", lambda: broker.readings(0, TOPIC))
    time.sleep(5)
    since = time.time()
    time.sleep(5)
    heard = broker.heard()
    rate = len(broker.readings(since, TOPIC)) / 5
    bytes_s = sum(len(topic) + len(payload) for at, _, topic, payload in heard if at >= since) / 5
    check("many readings are told", rate > 50, f"{rate:.0f}/s, {bytes_s / 1024:.0f} KiB/s, the oldest {max(ages(since)):.2f} s")

    # A broker that reads, but a third of what there is.
    before, warnings = memory_kib(bridge), bench.log().count("WARN")
    since, network.bytes_s = time.time(), bytes_s / 3
    check_memory("a slow broker", before, SLOW_S)
    late = max(ages(since + 5))
    check("a slow broker: nothing is older than twice the keep-alive", late < 2 * KEEP_ALIVE_S + FRESH_S, f"the oldest {late:.2f} s")
    print(f"{bench.log().count('WARN') - warnings} times given up")
    network.bytes_s = None
    check_fresh("a slow broker", time.time())

    # One that stops for less than anybody's patience.
    warnings = bench.log().count("WARN")
    network.cut()
    time.sleep(STOPPED_S)
    network.mend()
    check_fresh(f"a stop of {STOPPED_S} s", time.time())
    check(f"a stop of {STOPPED_S} s is no outage", bench.log().count("WARN") == warnings and broker.availability() == "online")

    # The connection stays, and nothing comes through.
    before, since = memory_kib(bridge), time.time()
    network.cut()
    noticed = {}

    def both_notice():
        if broker.availability() == "offline":
            noticed.setdefault("broker", time.time() - since)
        if bench.log().count("WARN") > warnings:
            noticed.setdefault("bridge", time.time() - since)
        return len(noticed) == 2

    until("broker and bridge to notice", both_notice)
    check("a dead network: offline at the broker by the keep-alive", noticed["broker"] < BROKER_S + 1, f"after {noticed['broker']:.1f} s")
    check("a dead network: the bridge notices", noticed["bridge"] < 2 * KEEP_ALIVE_S + 1, f"after {noticed['bridge']:.1f} s")
    check_memory("a dead network", before, DEAD_S - max(noticed.values()))
    mended = time.time()
    broker.forget()
    network.mend()
    _, took = until("the board after a dead network", lambda: broker.availability() == "online")
    check("a dead network: it comes back by itself", took < 10, f"after {took:.1f} s")
    first, _ = until("a reading", lambda: broker.readings(mended, TOPIC))
    at, reading = first[0]
    check("a dead network: the first reading after it was taken after it", taken_at(reading) > mended, f"{at - taken_at(reading):.2f} s old")
    check_fresh("a dead network", at)
    taken = [taken_at(reading) for _, reading in broker.readings(mended, TOPIC)]
    check("a dead network: none of the outage ever comes", min(taken) > mended, f"{len(taken)} readings")
    check("the device is told again", broker.last("homeassistant/device/bench/config") is not None)
    check("it is still the same process", bridge.poll() is None)
