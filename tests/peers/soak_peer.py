"""All bridges at once for MINUTES (2), while daemon and broker are killed, stopped and started by chance: nothing stale, memory flat.

Every reading that comes out of a bridge has the time of its measurement; its age is taken the moment it comes out.
"""

import json
import os
import random
import signal
import socket
import statistics
import subprocess
import threading
import time
import urllib.request
from datetime import datetime

from bench import Bench, check, free_port, memory_kib, until
from prometheus_client.parser import text_string_to_metric_families

SECONDS = 60 * float(os.environ.get("MINUTES", "2"))
SEED = int(os.environ.get("SEED", "1"))
STALE_S = 2.0
# A scrape and a thread of this program take their time on a busy machine.
SLACK_S = 1.0
# What the broker's kernel took before the bridge gave up: twice its keep-alive of 5 s.
BROKER_S = 10.0


class Ages:
    """The ages of readings that came out of one bridge."""

    def __init__(self, limit):
        self.limit, self.count, self.worst, self.too_old = limit, 0, 0.0, 0

    def add(self, taken_at, seen_at=None):
        age = (seen_at or time.time()) - taken_at
        self.count += 1
        self.worst = max(self.worst, age)
        self.too_old += age > self.limit


def unix(text):
    return datetime.fromisoformat(text[:26].rstrip("Z") + "+00:00").timestamp()


def forever(does):
    """In a thread, again whenever the other side fails."""

    def turn():
        while True:
            try:
                does()
            except (OSError, ValueError):
                time.sleep(0.2)

    threading.Thread(target=turn, daemon=True).start()


with Bench() as bench:
    ports = {name: free_port() for name in ("prometheus", "web", "iio", "broker")}
    listen = {name: ["--listen", f"127.0.0.1:{port}", "--stale", f"{STALE_S} s"] for name, port in ports.items()}
    ages = {name: Ages(STALE_S + SLACK_S) for name in ("prometheus", "web", "mqtt", "iio")}
    ages["mqtt"].limit = BROKER_S + STALE_S + SLACK_S
    (bench.path / "broker.conf").write_text(f"user root\nlistener {ports['broker']} 127.0.0.1\nallow_anonymous true\n")
    broker = None

    def start_broker():
        global broker
        broker = bench.spawn("mosquitto.log", "mosquitto", "-c", "broker.conf")

    start_broker()
    bridges = {
        "prometheus": bench.cermctl("bridge", "prometheus", *listen["prometheus"]),
        "web": bench.cermctl("web", *listen["web"]),
        "iio": bench.cermctl("bridge", "iio", *listen["iio"]),
        "mqtt": bench.cermctl("bridge", "mqtt", "--broker", "127.0.0.1", "--port", ports["broker"], "--id", "bench",
                              "--every", "1 s", "--change", "1", "--stale", f"{STALE_S} s"),
    }  # fmt: skip

    def scrape():
        with urllib.request.urlopen(f"http://127.0.0.1:{ports['prometheus']}/metrics", timeout=5) as page:
            text = page.read().decode()
        for family in text_string_to_metric_families(text):
            if family.name == "cermd_reading_timestamp_seconds":
                for sample in family.samples:
                    ages["prometheus"].add(sample.value)
        time.sleep(0.1)

    def events():
        with urllib.request.urlopen(f"http://127.0.0.1:{ports['web']}/events", timeout=60) as stream:
            for line in stream:
                if line.startswith(b'data: {"class":"READING"'):
                    ages["web"].add(unix(json.loads(line[6:])["time"]))

    def buffer():
        with socket.create_connection(("127.0.0.1", ports["iio"]), 60) as client, client.makefile("rb") as answers:
            # resistance1 and timestamp; a row is asked for at a time.
            client.sendall(b"OPEN iio:device0 1 0000000c\r\n")
            if answers.readline() != b"0\n":
                raise ValueError
            while True:
                client.sendall(b"READBUF iio:device0 16\r\n")
                length = int(answers.readline())
                if length == 16:
                    answers.readline()
                    ages["iio"].add(int.from_bytes(answers.read(16)[8:], "little") / 1e9)

    def subscribe():
        command = ["mosquitto_sub", "-p", str(ports["broker"]), "-t", "cermd/bench/channel/#", "-F", "%U %p"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as ear:
            for line in ear.stdout:
                ages["mqtt"].add(unix(json.loads(line.split(" ", 1)[1])["time"]))
        raise OSError

    for does in (scrape, events, buffer, subscribe):
        forever(does)
    until("readings by every way", lambda: all(way.count for way in ages.values()))

    def restart(what):
        if what == "daemon":
            bench.kill_daemon()
            time.sleep(chance.uniform(0, 3))
            bench.start_daemon()
        else:
            broker.kill()
            broker.wait()
            time.sleep(chance.uniform(0, 3))
            start_broker()

    def halt(what):
        process = bench.daemon if what == "daemon" else broker
        process.send_signal(signal.SIGSTOP)
        time.sleep(chance.uniform(0, 15))
        process.send_signal(signal.SIGCONT)

    chance, begin, memory, troubles = random.Random(SEED), time.monotonic(), {name: [] for name in bridges}, 0
    while time.monotonic() - begin < SECONDS:
        time.sleep(chance.uniform(2, 8))
        chance.choice([restart, halt])(chance.choice(["daemon", "broker"]))
        troubles += 1
        for name, process in bridges.items():
            memory[name].append(memory_kib(process))
    before = {name: way.count for name, way in ages.items()}
    until("readings by every way at the end", lambda: all(way.count > before[name] for name, way in ages.items()))

    print(f"{SECONDS / 60:g} minutes, {troubles} troubles, seed {SEED}")
    for name, process in bridges.items():
        way, sizes = ages[name], memory[name]
        quarter = max(1, len(sizes) // 4)
        first, last = statistics.median(sizes[quarter : 2 * quarter] or sizes), statistics.median(sizes[-quarter:])
        check(f"{name}: it is still the same process", process.poll() is None)
        check(f"{name}: nothing stale", way.too_old == 0, f"{way.count} readings, the oldest {way.worst:.2f} s")
        check(f"{name}: memory is flat", last - first < 1024, f"{first:.0f} -> {last:.0f} KiB")
