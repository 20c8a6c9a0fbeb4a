"""The bridge and Mosquitto: TLS, passwords, restarts, a dead network, kills."""

import json
import signal
import subprocess
import time

from bench import INDEX_OHM, Bench, check, free_port, until
from broker import Mosquitto, taken_at

AVAILABILITY = "cermd/bench/availability"
DEVICE = "homeassistant/device/bench/config"
INDEX = "cermd/bench/channel/index"


def openssl(bench, *arguments):
    subprocess.run(["openssl", *arguments], cwd=bench.path, check=True, capture_output=True)


def certificates(bench):
    """An authority, a certificate of it for localhost, and another authority that has nothing to do with these."""
    for name in ("ca", "other-ca"):
        openssl(bench, "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2",
                "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.pem")  # fmt: skip
    openssl(bench, "req", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=localhost",
            "-keyout", "broker.key", "-out", "broker.csr")  # fmt: skip
    (bench.path / "san").write_text("subjectAltName=DNS:localhost\n")
    openssl(bench, "x509", "-req", "-in", "broker.csr", "-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial",
            "-days", "2", "-extfile", "san", "-out", "broker.pem")  # fmt: skip


def with_tls(bench):
    """A broker that has a second listener, by TLS and with a password; and its port."""
    port = free_port()
    (bench.path / "password").write_text("secret\n")
    subprocess.run(["mosquitto_passwd", "-c", "-b", "passwords", "board", "secret"], cwd=bench.path, check=True)
    return Mosquitto(
        bench,
        f"listener {port} 127.0.0.1\nallow_anonymous false\npassword_file passwords\n"
        "cafile ca.pem\ncertfile broker.pem\nkeyfile broker.key\n",
    ), port


with Bench() as bench:
    certificates(bench)
    broker, tls_port = with_tls(bench)

    def readings_since(since):
        return [reading for _, reading in broker.readings(since, INDEX)]

    def connect(*more):
        return bench.cermctl("bridge", "mqtt", "--broker", "localhost", "--id", "bench", *more)

    broker.stop()
    bridge = connect("--port", broker.port, "--every", "1 s")
    until("the bridge to miss its broker", lambda: "refused" in bench.log())
    broker.start()
    _, took = until("the board to come online", lambda: broker.availability() == "online")
    check("a broker that was not there at the start is found", took < 10, f"after {took:.2f} s")
    (_, retained, _, device), _ = until("the device", lambda: broker.last(DEVICE))
    check("the device is announced", json.loads(device)["cmps"]["index_resistance"]["unit_of_measurement"] == "\u03a9")
    ear = ["mosquitto_sub", "-p", str(broker.port), "-t", "#", "--retained-only", "-W", "2", "-F", "%t"]
    kept = subprocess.run(ear, capture_output=True).stdout
    check("only device and availability are retained", set(kept.decode().split()) == {DEVICE, AVAILABILITY}, kept)
    reading, _ = until("a reading", lambda: next((r for r in readings_since(0) if "r_ohm" in r), None))
    check("its value is that of the sensor", abs(reading["r_ohm"] - INDEX_OHM) < 0.02 * INDEX_OHM, reading["r_ohm"])
    since = time.time()
    time.sleep(5)
    count = len(readings_since(since))
    check("a constant is told about once a second, not 25 times", 4 <= count <= 15, f"{count} in 5 s")

    bench.kill_daemon()
    _, took = until("offline", lambda: broker.availability() == "offline")
    check("a killed daemon is offline at once", took < 1, f"after {took:.2f} s")
    bench.start_daemon()
    until("online", lambda: broker.availability() == "online")

    bridge.kill()
    _, took = until("the last will", lambda: broker.availability() == "offline")
    check("a killed bridge is offline at once", took < 1, f"after {took:.2f} s")
    bridge = connect("--port", broker.port, "--every", "1 s")
    until("online", lambda: broker.availability() == "online")

    broker.stop()
    broker.forget()
    time.sleep(3)
    back = time.time()
    broker.start()
    _, took = until("the board after a restart of the broker", lambda: broker.availability() == "online")
    check("a broker that comes back is told everything", took < 5, f"after {took:.2f} s")
    until("a reading", lambda: readings_since(back))
    check("the device too", broker.last(DEVICE) is not None)

    # The network is dead: nothing is answered, nothing is refused.
    warnings = bench.log().count("WARN")
    stopped = time.time()
    broker.process.send_signal(signal.SIGSTOP)
    _, took = until("the bridge to notice", lambda: bench.log().count("WARN") > warnings)
    time.sleep(5)
    check("a broker that hangs is noticed", took < 15, f"after {took:.1f} s: {bench.log().splitlines()[-1][-80:]}")
    woken = time.time()
    broker.process.send_signal(signal.SIGCONT)
    until("readings of now", lambda: any(taken_at(r) > woken for r in readings_since(woken)))
    # The broker reads first what its kernel took in before the bridge gave up: 10 s at the most.
    late = [taken_at(r) - stopped for r in readings_since(woken) if taken_at(r) < woken - 1]
    check("what was measured after it was noticed is not told", max(late, default=0.0) <= took,
          f"{len(late)} readings of the first {max(late, default=0.0):.1f} s")  # fmt: skip
    bridge.send_signal(signal.SIGINT)
    bridge.wait(10)
    check("told to end, it says so", broker.availability() == "offline")

    tls = ["--port", tls_port, "--user", "board", "--password-file", "password"]
    for what, arguments, words in [
        ("a wrong authority is told", [*tls, "--ca", "other-ca.pem"], "does not vouch for this broker"),
        ("so is another name", ["--broker", "127.0.0.1", *tls, "--ca", "ca.pem"], "its certificate is for another name"),
        ("so is TLS on the wrong port", ["--port", broker.port, "--ca", "ca.pem"], "is this its port for TLS?"),
        ("so is no TLS where it is wanted", ["--port", tls_port], "does it want TLS"),
        ("so is a wrong password", ["--port", tls_port, "--ca", "ca.pem", "--user", "board", "--password-file", "ca.pem"],
         "look at --user and --password-file"),
        ("so is nobody", ["--port", free_port()], "refused"),
    ]:  # fmt: skip
        log = f"log-{time.monotonic_ns()}"
        where = [] if "--broker" in arguments else ["--broker", "localhost"]
        attempt = bench.cermctl("bridge", "mqtt", *where, "--id", "other", *arguments, log=log)
        until(what, lambda: words in bench.log(log))
        check(what, attempt.poll() is None, bench.log(log).strip().splitlines()[-1][-160:])
        attempt.kill()
    bridge = connect(*tls, "--ca", "ca.pem")
    until("the board by TLS", lambda: broker.availability() == "online")
    check("TLS and a password work", True)
