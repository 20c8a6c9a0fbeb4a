"""A cermd on a simulated circuit in a folder of its own, and programs beside it. All of them end with the test."""

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BIN = Path(os.environ["CERMD_BIN"]).resolve()

CIRCUIT = """
[circuit]
kind = "two-capacitor"
c-a = "330 nF"
c-b = "22 nF"
r-c1 = "470 ohm"
r-c2 = "12.7 kohm"
"""

CONFIG = CIRCUIT + """
r-charge = "260 ohm"
[gpio]
backend = "mock"
[measure]
rate-hz = 50
[[channel]]
id = "thumb"
zero-ohm = 0.0
scale = 1.0
force = { alpha = "13346 N ohm" }
on-above = "6 N"
[[channel]]
id = "index"
zero-ohm = 0.0
scale = 1.0
[server]
socket = "socket"
[mock]
scene = "scene.toml"
"""

SCENE = CIRCUIT + """
r-p = "220 ohm"
r-o = "40 ohm"
v-dd = "3.3 V"
threshold = { falling = "1.3 V" }
[stamps]
mean = "8 us"
jitter = "1.5 us"
[calls]
fixed = "100 ns"
per-line = "10 ns"
moves-at = [0.0, 1.0]
[[sensor]]
sine = { mean = "3 kohm", amplitude = "2 kohm", frequency = "0.2 Hz" }
[[sensor]]
constant = "2 kohm"
"""
INDEX_OHM = 2000.0


class Bench:
    def __init__(self, config=CONFIG, scene=SCENE):
        self._folder = tempfile.TemporaryDirectory(prefix="cermd-peers-")
        self.path = Path(self._folder.name)
        self._children = []
        (self.path / "cermd.toml").write_text(config)
        (self.path / "scene.toml").write_text(scene)
        self.socket = self.path / "socket"
        self.daemon = None

    def __enter__(self):
        self.start_daemon()
        return self

    def __exit__(self, kind, error, _):
        if kind is not None and getattr(error, "code", 1) not in (0, None):
            for log in sorted(self.path.glob("*.log")):
                tail = log.read_text(errors="replace").splitlines()[-20:]
                print(f"-- {log.name}", *tail, sep="\n")
        for child in self._children:
            if child.poll() is None:
                child.send_signal(signal.SIGCONT)
                child.kill()
                child.wait()
        self._folder.cleanup()

    def spawn(self, log, *command, **more):
        """A process whose output goes into a file of the folder."""
        with open(self.path / log, "ab") as output:
            child = subprocess.Popen([str(part) for part in command], stdout=output, stderr=output, cwd=self.path, **more)
        self._children.append(child)
        return child

    def start_daemon(self):
        self.daemon = self.spawn("cermd.log", BIN / "cermd", "--config", "cermd.toml")
        until("a cermd that serves", self._serves)

    def _serves(self):
        with socket.socket(socket.AF_UNIX) as client:
            return client.connect_ex(str(self.socket)) == 0

    def kill_daemon(self):
        self.daemon.kill()
        self.daemon.wait()

    def cermctl(self, *arguments, log="cermctl.log"):
        return self.spawn(log, BIN / "cermctl", *arguments, "--socket", self.socket)

    def log(self, name="cermctl.log"):
        return (self.path / name).read_text(errors="replace")

    def get(self, channel):
        """The reading that `cermctl get` prints now."""
        command = [BIN / "cermctl", "get", "--json", "--socket", self.socket, channel]
        return json.loads(subprocess.check_output(command))


def until(what, look, seconds=30.0):
    """Looks until there is an answer that is not false; the answer, and how long it took, s."""
    since = time.monotonic()
    while True:
        answer = look()
        took = time.monotonic() - since
        if answer:
            return answer, took
        if took > seconds:
            sys.exit(f"waited {seconds} s in vain for {what}")
        time.sleep(0.02)


def check(what, is_so, seen=""):
    print(f"{'ok' if is_so else 'FAILED'}: {what}", seen, flush=True)
    if not is_so:
        sys.exit(1)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def memory_kib(process):
    """What a process has in memory."""
    for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1])
    return 0
