"""Two boards on one Mosquitto, and what Home Assistant is told of their triggers, by its own template language."""

import json
import time

from bench import CONFIG, SCENE, Bench, check, until
from broker import Mosquitto
from jinja2 import Environment

# Put together carelessly, "hall" and "thumb-index" are what "hall-thumb" and "index" are.
LEFT, RIGHT = "hall", "hall-thumb"
OF_LEFT = CONFIG.replace('"index"', '"thumb-index"')
# The threshold of the inputs walks out of reach: after some seconds there is no number any more.
FAILS = SCENE + "[drift]\nv-th-per-minute = \"-15 V\"\n"


def entities(broker, board):
    """Of the announcement of a board: by their keys."""
    entry = broker.last(f"homeassistant/device/{board}/config")
    return json.loads(entry[3])["cmps"] if entry else {}


def bridge_of(bench, broker, board):
    return bench.cermctl("bridge", "mqtt", "--broker", "127.0.0.1", "--port", broker.port, "--id", board, "--every", "1 s")


def boards(left, right):
    broker = Mosquitto(left)
    bridges = {LEFT: bridge_of(left, broker, LEFT), RIGHT: bridge_of(right, broker, RIGHT)}
    for board in bridges:
        until(f"{board} online", lambda: broker.availability(board) == "online" and entities(broker, board))
    of = {board: entities(broker, board) for board in bridges}
    ids = [entity["unique_id"] for entities in of.values() for entity in entities.values()]
    check("no two entities have one id", len(set(ids)) == len(ids) == 2 * len(of[LEFT]), f"{len(ids)} of them")
    devices = [json.loads(broker.last(f"homeassistant/device/{board}/config")[3])["dev"]["ids"] for board in bridges]
    check("nor two boards", devices[0] != devices[1], devices)
    for board, entities_of in of.items():
        topics = {value for entity in entities_of.values() for key, value in entity.items() if key.endswith("_topic")}
        check(f"what is told of {board} is its own", all(topic.startswith(f"cermd/{board}/") for topic in topics), len(topics))
    time.sleep(3)
    check("neither throws the other out", all("WARN" not in bench.log() for bench in (left, right)))

    for what, kill in (("bridge", bridges[LEFT].kill), ("daemon", left.kill_daemon)):
        since = time.time()
        kill()
        _, took = until("offline", lambda: broker.availability(LEFT) == "offline")
        time.sleep(3)
        heard = [entry for entry in broker.heard() if entry[0] > since + took + 0.5]
        said = {board: sum(topic.startswith(f"cermd/{board}/channel/") for _, _, topic, _ in heard) for board in bridges}
        check(f"a killed {what} makes its own board unavailable", took < 1 and said[LEFT] == 0, f"after {took:.2f} s")
        check("and not the other one", broker.availability(RIGHT) == "online" and said[RIGHT] > 5, f"{said[RIGHT]} readings in 2.5 s")
        if what == "bridge":
            bridges[LEFT] = bridge_of(left, broker, LEFT)
            until("online", lambda: broker.availability(LEFT) == "online")
    bridges[RIGHT].kill()
    until("offline", lambda: broker.availability(RIGHT) == "offline")
    broker.stop()


def trigger(bench):
    broker, topic = Mosquitto(bench), "cermd/bench/trigger/thumb"
    bridge_of(bench, broker, "bench")
    until("the device", lambda: entities(broker, "bench"))
    entity = entities(broker, "bench")["thumb_pressed"]
    check("a trigger is a binary sensor", (entity["p"], entity["state_topic"]) == ("binary_sensor", topic))
    check("a channel without one is none", "index_pressed" not in entities(broker, "bench"))
    shows = Environment().from_string(entity["value_template"])

    def told():
        """(time, what is told, what Home Assistant makes of it)."""
        heard = [(at, json.loads(payload)) for at, _, of, payload in broker.heard() if of == topic]
        return [(at, event, shows.render(value_json=event)) for at, event in heard]

    # The sensor goes up and down within 5 s.
    until("pressed and released", lambda: {"ON", "OFF"} <= {shown for _, _, shown in told()})
    until("each of them twice", lambda: len(changes(told())) > 4)
    check("pressed and released arrive", all(event["event"] == ("pressed" if shown == "ON" else "released") for _, event, shown in told()))
    _, took = until("pressed", lambda: told()[-1][2] == "ON")
    force = [reading["f_n"] for at, reading in broker.readings(0, "cermd/bench/channel/thumb") if "f_n" in reading]
    check("the force has been on both sides of the threshold", min(force) < 4.8 and max(force) > 6)

    (bench.path / "scene.toml").write_text(FAILS)
    bench.kill_daemon()
    until("offline", lambda: broker.availability() == "offline")
    bench.start_daemon()
    begin = time.time()

    def lately():
        """What Home Assistant has been shown in the last 4 s."""
        return [shown for at, _, shown in told() if at > max(begin, time.time() - 4)]

    # It is told again each second.
    until("unknown for good", lambda: len(lately()) >= 3 and set(lately()) == {"None"}, 60)
    fresh = [entry for entry in told() if entry[0] > begin]
    check("known, then by a fault unknown, and that stays", fresh[0][2] in ("ON", "OFF"), [shown for _, _, shown in changes(fresh)])
    check("the reason is told", fresh[-1][1] == {**fresh[-1][1], "event": "released", "reason": "fault"}, fresh[-1][1])
    since = time.time() - 2
    status = broker.readings(since, "cermd/bench/channel/thumb")
    check("beside the fault itself", status and all(reading["status"] == "fault" for _, reading in status), status[-1][1])


def changes(told):
    return [entry for before, entry in zip([None, *told], told) if before is None or before[2] != entry[2]]


with Bench(OF_LEFT) as left, Bench() as right:
    boards(left, right)
with Bench() as bench:
    trigger(bench)
