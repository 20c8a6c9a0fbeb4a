"""A real Home Assistant, set up by its own API as a person would: the board appears, follows, is unavailable when it is gone.

It takes a Debian with Python 3.14 (forky) in a folder, some 2 GB that are kept in the cache, and root. PICTURES=FOLDER: a picture of
the device's page.
"""

import json
import os
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

from bench import INDEX_OHM, SCENE, Bench, check, free_port, until

CACHE = Path(os.environ.get("CERMD_PEERS_CACHE") or Path.home() / ".cache/cermd-peers")
ROOT = CACHE / "home-assistant"
HERE = Path(__file__).resolve().parent
MIRROR = os.environ.get("DEBIAN_MIRROR", "http://deb.debian.org/debian")
PACKAGES = "python3,python3-venv,python3-dev,ca-certificates,g++,libffi-dev,zlib1g-dev,libjpeg-dev"
VERSION = "2026.11.0"


def in_root(*command, **more):
    """In the folder, with the kernel's file systems."""
    script = "mount --rbind /dev dev && mount -t proc proc proc && exec chroot . \"$@\""
    return ["unshare", "--mount", "sh", "-c", f"cd '{ROOT}' && {script}", "sh", *map(str, command)]


def build():
    if (ROOT / "opt/ha/bin/hass").exists():
        return
    if not (ROOT / "usr/bin/python3").exists():
        subprocess.run(["mmdebstrap", "--mode=root", "--variant=apt", "--aptopt=Acquire::Check-Valid-Until \"false\"",
                        f"--include={PACKAGES}", "forky", ROOT, MIRROR], check=True)  # fmt: skip
    # The network as this machine has it, and whom it believes.
    for name in ("resolv.conf", "hosts", "ssl/certs/ca-certificates.crt"):
        (ROOT / "etc" / name).write_bytes((Path("/etc") / name).read_bytes())
    subprocess.run(in_root("python3", "-m", "venv", "/opt/ha"), check=True)
    subprocess.run(in_root("/opt/ha/bin/pip", "install", "-q", "uv"), check=True)
    subprocess.run(in_root("/opt/ha/bin/uv", "pip", "install", "-q", "--python", "/opt/ha/bin/python", f"homeassistant=={VERSION}"), check=True)


class HomeAssistant:
    def __init__(self, bench):
        self.url = f"http://127.0.0.1:{free_port()}"
        self.tokens = {}
        config = ROOT / "config"
        subprocess.run(["rm", "-rf", config], check=True)
        config.mkdir()
        port = self.url.rsplit(":", 1)[1]
        (config / "configuration.yaml").write_text(f"frontend:\nconfig:\nhttp:\n  server_host: 127.0.0.1\n  server_port: {port}\n")
        bench.spawn("home-assistant.log", *in_root("/opt/ha/bin/hass", "-c", "/config"), start_new_session=True)

    def call(self, path, body=None, form=False):
        headers = {"Authorization": f"Bearer {self.tokens['access_token']}"} if self.tokens else {}
        data = None
        if body is not None:
            data = (urllib.parse.urlencode(body) if form else json.dumps(body)).encode()
            headers["Content-Type"] = "application/x-www-form-urlencoded" if form else "application/json"
        try:
            request = urllib.request.Request(self.url + path, data, headers)
            with urllib.request.urlopen(request, timeout=120) as answer:
                text = answer.read()
        except urllib.error.HTTPError as error:
            sys.exit(f"{path}: {error.code} {error.read().decode()[:400]}")
        return json.loads(text) if text.lstrip()[:1] in (b"{", b"[") else text.decode()

    def answers(self):
        try:
            return self.call("/api/onboarding")
        except OSError:
            return None

    def onboard(self):
        client = self.url + "/"
        person = {"name": "t", "username": "t", "password": "t-t-t-t", "client_id": client, "language": "en"}
        code = self.call("/api/onboarding/users", person)["auth_code"]
        self.tokens = self.call("/auth/token", {"grant_type": "authorization_code", "code": code, "client_id": client}, form=True)
        self.call("/api/onboarding/analytics", {})

    def finish(self):
        """What the pages want done before they show anything else."""
        self.call("/api/onboarding/core_config", {})
        self.call("/api/onboarding/integration", {"client_id": self.url + "/", "redirect_uri": self.url + "/?auth_callback=1"})

    def add_mqtt(self, port):
        flow = self.call("/api/config/config_entries/flow", {"handler": "mqtt"})
        other = {"set_client_cert": False, "set_ca_cert": "off"}
        answers = {"broker": "127.0.0.1", "port": port, "protocol": "5", "other_settings": other}
        return self.call(f"/api/config/config_entries/flow/{flow['flow_id']}", answers)

    def state(self, entity):
        """Its state and attributes."""
        found = [state for state in self.call("/api/states") if state["entity_id"] == entity]
        return (found[0]["state"], found[0]["attributes"]) if found else (None, {})


build()
with Bench() as bench:
    broker_port = free_port()
    (bench.path / "broker.conf").write_text(f"user root\nlistener {broker_port} 127.0.0.1\nallow_anonymous true\n")

    def start_broker():
        return bench.spawn("mosquitto.log", "mosquitto", "-c", "broker.conf")

    def start_bridge():
        return bench.cermctl("bridge", "mqtt", "--broker", "127.0.0.1", "--port", broker_port, "--id", "bench", "--every", "1 s")

    broker, bridge = start_broker(), start_bridge()
    home = HomeAssistant(bench)
    _, took = until("Home Assistant", home.answers, 600)
    print(f"Home Assistant {VERSION} answers after {took:.0f} s")
    home.onboard()
    added = home.add_mqtt(broker_port)
    check("MQTT is added", added.get("type") == "create_entry", added.get("errors") or "")

    resistance, status = "sensor.bench_index_resistance", "sensor.bench_index_status"
    is_number = lambda text: text is not None and text.replace(".", "", 1).isdigit()  # noqa: E731
    _, took = until("the entity", lambda: is_number(home.state(resistance)[0]), 120)
    value, attributes = home.state(resistance)
    check("the entity appears with its value", abs(float(value) - INDEX_OHM) < 0.05 * INDEX_OHM, f"{value} after {took:.1f} s")
    check("its unit and uncertainty", attributes["unit_of_measurement"] == "\u03a9" and attributes["r_u_ohm"] > 0, attributes)
    check("its state", home.state(status)[0] == "ok")
    force = "sensor.bench_thumb_force"
    seen = set()
    for _ in range(10):
        seen.add(home.state(force)[0])
        time.sleep(0.5)
    check("a value follows", len(seen) >= 5, sorted(seen))

    bridge.kill()
    _, took = until("unavailable", lambda: home.state(resistance)[0] == "unavailable")
    check("a killed bridge is unavailable", took < 1, f"after {took:.2f} s")
    bridge = start_bridge()
    _, took = until("the value again", lambda: is_number(home.state(resistance)[0]))
    check("and back", True, f"{took:.1f} s after its start")
    (bench.path / "scene.toml").write_text(SCENE + "[events]\nlost = 1.0\n")
    bench.kill_daemon()
    bench.start_daemon()
    until("the fault", lambda: home.state(status)[0] == "fault")
    _, attributes = home.state(status)
    check("a fault has no number", home.state(resistance)[0] == "unknown", attributes.get("fault"))
    (bench.path / "scene.toml").write_text(SCENE)
    bench.kill_daemon()
    _, took = until("unavailable", lambda: home.state(resistance)[0] == "unavailable")
    check("a killed daemon is unavailable", took < 1, f"after {took:.2f} s")
    bench.start_daemon()
    until("the value again", lambda: is_number(home.state(resistance)[0]))
    broker.kill()
    broker.wait()
    until("unavailable", lambda: home.state(resistance)[0] == "unavailable")
    broker = start_broker()
    _, took = until("the value after a restart of the broker", lambda: is_number(home.state(resistance)[0]), 120)
    check("back after a restart of the broker", True, f"{took:.1f} s")
    if os.environ.get("PICTURES"):
        # Only now: it begins to fetch what a home may want, and takes its time.
        home.finish()
        until("the end of its start", lambda: home.call("/api/config")["state"] == "RUNNING", 300)
        device = home.call("/api/template", {"template": f"{{{{ device_id('{force}') }}}}"}).strip()
        tokens = home.tokens | {"hassUrl": home.url, "clientId": home.url + "/", "expires": 1000 * (time.time() + 1500)}
        picture = Path(os.environ["PICTURES"]).resolve() / "home-assistant.png"
        subprocess.run(["node", HERE / "home_assistant_page.js", f"{home.url}/config/devices/device/{device}", json.dumps(tokens), picture],
                       check=True, env={**os.environ, "NODE_PATH": str(CACHE / "node_modules")})  # fmt: skip
