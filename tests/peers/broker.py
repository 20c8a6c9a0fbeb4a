"""Mosquitto with an ear at every topic, and a network to it that a test chokes or cuts."""

import json
import socket
import threading
import time
from datetime import datetime

from bench import free_port, until


class Mosquitto:
    def __init__(self, bench, more=""):
        """`more`: further lines of its configuration, of a second listener."""
        self.bench, self.port = bench, free_port()
        (bench.path / "broker.conf").write_text(
            f"user root\nper_listener_settings true\nlistener {self.port} 127.0.0.1\nallow_anonymous true\n{more}"
        )
        self.process, self.read, self.entries = None, 0, []
        self.start()

    def start(self):
        self.process = self.bench.spawn("mosquitto.log", "mosquitto", "-c", "broker.conf")
        until("a broker that listens", self.listens)
        self.listener = self.bench.spawn(
            "heard", "mosquitto_sub", "-p", self.port, "-t", "#", "-F", "%U %r %t %p", "-i", f"ear-{time.monotonic_ns()}"
        )

    def listens(self):
        with socket.socket() as client:
            return client.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self):
        for process in (self.listener, self.process):
            process.kill()
            process.wait()

    def heard(self):
        """Everything so far: (time, retained, topic, payload)."""
        with open(self.bench.path / "heard", "rb") as log:
            log.seek(self.read)
            fresh = log.read()
        whole = fresh[: fresh.rfind(b"\n") + 1]
        self.read += len(whole)
        lines = (line.split(" ", 3) for line in whole.decode(errors="replace").splitlines())
        self.entries += [(float(at), retain == "1", topic, payload) for at, retain, topic, payload in (l for l in lines if len(l) == 4)]
        return self.entries

    def forget(self):
        """What was heard so far."""
        self.heard()
        self.entries = []

    def last(self, topic):
        return next((entry for entry in reversed(self.heard()) if entry[2] == topic), None)

    def availability(self, board="bench"):
        entry = self.last(f"cermd/{board}/availability")
        return entry and entry[3]

    def readings(self, since, topic):
        """(when it was heard, the reading) of the topics that begin so."""
        return [(at, json.loads(payload)) for at, _, of, payload in self.heard() if of.startswith(topic) and at >= since]


def taken_at(reading):
    return datetime.fromisoformat(reading["time"][:26].rstrip("Z") + "+00:00").timestamp()


class Network:
    """A way to a port of this machine. Cut: what is on its way stays there, and who calls is never heard."""

    CHUNK = 512

    def __init__(self, port):
        self.target, self.is_cut, self.unheard = port, False, []
        # Bytes a second towards the port; None: as they come.
        self.bytes_s = None
        self.listener = socket.socket()
        # Little of what a slow reader has not read waits on its side.
        self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.listener.bind(("127.0.0.1", 0))
        self.listener.listen()
        self.port = self.listener.getsockname()[1]
        self._thread(self._accept)

    def cut(self):
        self.is_cut = True

    def mend(self):
        self.is_cut = False
        for caller in self.unheard:
            caller.close()
        self.unheard = []

    @staticmethod
    def _thread(does, *arguments):
        threading.Thread(target=does, args=arguments, daemon=True).start()

    def _accept(self):
        while True:
            near, _ = self.listener.accept()
            if self.is_cut:
                self.unheard.append(near)
                continue
            try:
                far = socket.create_connection(("127.0.0.1", self.target))
            except OSError:
                near.close()
                continue
            self._thread(self._carry, near, far, True)
            self._thread(self._carry, far, near, False)

    def _carry(self, source, sink, is_there):
        """From one end to the other, until either closes."""
        try:
            while True:
                self._wait()
                data = source.recv(self.CHUNK)
                self._wait()
                if not data:
                    break
                sink.sendall(data)
                if is_there and self.bytes_s:
                    time.sleep(len(data) / self.bytes_s)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def _wait(self):
        while self.is_cut:
            time.sleep(0.02)
