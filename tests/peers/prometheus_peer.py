"""The metrics as promtool, a strict parser of OpenMetrics and a scraping Prometheus read them."""

import json
import math
import socket
import subprocess
import urllib.parse
import urllib.request

from bench import INDEX_OHM, Bench, check, free_port, memory_kib, until
from prometheus_client.openmetrics.parser import text_string_to_metric_families

OPENMETRICS = "application/openmetrics-text; version=1.0.0"


def get(url, accept="*/*"):
    with urllib.request.urlopen(urllib.request.Request(url, headers={"Accept": accept}), timeout=10) as answer:
        return answer.headers["Content-Type"], answer.read().decode()


def lint(page):
    done = subprocess.run(["promtool", "check", "metrics"], input=page, text=True, capture_output=True)
    return done.returncode == 0 and not done.stderr, done.stderr


with Bench() as bench:
    port, prometheus_port = free_port(), free_port()
    url = f"http://127.0.0.1:{port}/metrics"
    bridge = bench.cermctl("bridge", "prometheus", "--listen", f"127.0.0.1:{port}", "--stale", "2 s")

    def page(accept="*/*"):
        try:
            return get(url, accept)
        except OSError:
            return None

    until("readings on the page", lambda: (page() or "  ")[1].count("cermd_resistance_ohms{") == 2)
    check("promtool finds nothing to complain of", *lint(page()[1]))

    def strict():
        """A page of a moment in which both sensors are numbers, and what the strict parser makes of it."""
        kind, text = page(OPENMETRICS) or ("", "# EOF\n")
        families = {family.name: family for family in text_string_to_metric_families(text)}
        known = families.get("cermd_resistance_ohms")
        return (kind, families) if known and len(known.samples) == 2 else None

    (kind, families), _ = until("readings on the page for OpenMetrics", strict)
    check("the strict parser takes it", kind.startswith("application/openmetrics-text"), f"{len(families)} families")

    def index():
        found = strict()
        samples = found[1]["cermd_resistance_ohms"].samples if found else []
        return next((one.value for one in samples if one.labels["channel"] == "index"), 0.0)

    # The first readings, which are settling, are less certain than that.
    until("the value of the sensor", lambda: abs(index() - INDEX_OHM) < 0.02 * INDEX_OHM)

    (bench.path / "prometheus.yml").write_text(
        "global: {scrape_interval: 500ms, scrape_timeout: 400ms}\n"
        f"scrape_configs: [{{job_name: cermd, static_configs: [{{targets: ['127.0.0.1:{port}']}}]}}]\n"
    )
    bench.spawn(
        "prometheus.log", "prometheus", "--config.file=prometheus.yml", "--storage.tsdb.path=data",
        f"--web.listen-address=127.0.0.1:{prometheus_port}",
    )  # fmt: skip

    def query(what):
        """The values of an instant query by channel; empty: no such series now."""
        try:
            answer = get(f"http://127.0.0.1:{prometheus_port}/api/v1/query?" + urllib.parse.urlencode({"query": what}))
        except OSError:
            return {}
        result = json.loads(answer[1])["data"]["result"]
        return {series["metric"].get("channel"): float(series["value"][1]) for series in result}

    until("an answer of Prometheus", lambda: "index" in query("cermd_resistance_ohms"))
    value = query("cermd_resistance_ohms")["index"]
    check("Prometheus answers with the value", abs(value - INDEX_OHM) < 0.02 * INDEX_OHM, value)
    rate, _ = until("a rate", lambda: query("sum(rate(cermd_readings_total[5s]))").get(None), 20)
    check("a rate can be made of the counters", math.isfinite(rate) and rate > 0, f"{rate:.1f} readings/s")

    before, crowd = memory_kib(bridge), []
    for _ in range(1000):
        scraper = socket.create_connection(("127.0.0.1", port), 10)
        scraper.sendall(b"GET /metrics HTT")
        crowd.append(scraper)
    _, took = until("a scrape among a thousand slow ones", page)
    after = memory_kib(bridge)
    check("a thousand slow scrapers cost little", after - before < 16_000, f"{before} -> {after} KiB, {took:.2f} s")
    for scraper in crowd:
        scraper.close()

    bench.kill_daemon()
    _, took = until("cermd_up 0", lambda: query("cermd_up").get(None) == 0.0)
    check("a daemon that is gone shows", took < 2, f"after {took:.2f} s")
    check("no value of before is told", query("cermd_resistance_ohms") == {}, query("cermd_resistance_ohms"))
    bench.start_daemon()
    until("values again", lambda: "index" in query("cermd_resistance_ohms"))
    check("it is back", True)
