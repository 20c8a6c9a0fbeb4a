"""The page in Chromium: values move, a fault shows, it outlives restarts, axe finds nothing. PICTURES=FOLDER: takes pictures; in docs are
web-ok-1100-light and web-fault-390-dark."""

import os
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

from bench import SCENE, Bench, check, free_port, until

CACHE = Path(os.environ.get("CERMD_PEERS_CACHE") or Path.home() / ".cache/cermd-peers")
NODE_PACKAGES = ["playwright-core@1", "axe-core@4"]
HERE = Path(__file__).resolve().parent

if not (CACHE / "node_modules/axe-core").is_dir():
    CACHE.mkdir(parents=True, exist_ok=True)
    subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--prefix", CACHE, *NODE_PACKAGES], check=True)

with Bench() as bench:
    port = free_port()
    url = f"http://127.0.0.1:{port}/"
    web = None

    def start_web():
        global web
        web = bench.cermctl("web", "--listen", f"127.0.0.1:{port}")
        until("the page", lambda: fetch("/") == 200)

    def fetch(path, host=None):
        request = urllib.request.Request(url.rstrip("/") + path, headers={"Host": host} if host else {})
        try:
            with urllib.request.urlopen(request, timeout=5) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code
        except OSError:
            return None

    def restart_cermd(scene):
        (bench.path / "scene.toml").write_text(scene)
        bench.kill_daemon()
        bench.start_daemon()

    def kill_web():
        web.kill()
        web.wait()

    start_web()
    check("another name is refused (DNS rebinding)", fetch("/", "evil.example") == 403)
    check("this machine's is not", fetch("/", f"localhost:{port}") == 200)
    streams = [urllib.request.urlopen(url + "events", timeout=5) for _ in range(32)]
    check("pages are capped", fetch("/events") == 503)
    for stream in streams:
        stream.close()
    until("places to come free", lambda: fetch("/events") == 200)

    pictures = os.environ.get("PICTURES")
    arguments = ["node", HERE / "web_page.js", url] + ([str(Path(pictures).resolve())] if pictures else [])
    browser = subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "NODE_PATH": str(CACHE / "node_modules")},
    )  # fmt: skip
    does = {
        # No edge is ever reported.
        "break": lambda: restart_cermd(SCENE + "[events]\nlost = 1.0\n"),
        "mend": lambda: restart_cermd(SCENE),
        "kill cermd": bench.kill_daemon,
        "start cermd": bench.start_daemon,
        "kill web": kill_web,
        "start web": start_web,
    }
    for line in browser.stdout:
        wish = line.strip().removeprefix("do ")
        if wish in does:
            does[wish]()
            browser.stdin.write("done\n")
            browser.stdin.flush()
        else:
            print(line, end="", flush=True)
    sys.exit(browser.wait())
