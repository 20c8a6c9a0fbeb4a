// What the daemon says, drawn. A number is never shown longer than it is true.

const SPAN_MS = 120_000, SHORTEST_MS = 10_000, POINTS = 4_800, REDRAW_MS = 250, RETRY_MS = 1_000, WIDTH = 600, HEIGHT = 160;

const $ = (id) => document.getElementById(id);
const channels = new Map();
let patience_ms = 10_000, counted = null;
// From the clock of the measurements to that of this page, as far as the fastest line has shown it, ms.
let clock = Infinity;

function prefixOf(value) {
    return Math.abs(value) >= 1e6 ? [1e6, "M"] : Math.abs(value) >= 1e5 ? [1e3, "k"] : [1, ""];
}

// Decimal places that show so many digits.
function places(value, digits) {
    const exponent = value === 0 ? 0 : Number(Number(value).toExponential(digits - 1).split("e")[1]);
    return Math.min(6, Math.max(0, digits - 1 - exponent));
}

// An end of a scale, to a hundredth of it.
function end(value, range, unit) {
    const [scale, prefix] = prefixOf(value);
    return `${(value / scale).toFixed(places(range / scale, 3))} ${prefix}${unit}`;
}

// As the programs write it: two digits of the uncertainty, or one from 0.36 to 0.94.
function measured(value, u, unit) {
    if (value === undefined) return "";
    const [scale, prefix] = prefixOf(value);
    value /= scale;
    if (!(u > 0)) return `${value.toFixed(places(value, 4))} ${prefix}${unit}`;
    u /= scale;
    const leading = Number(u.toExponential(2).split("e")[0]);
    const shown = places(u, leading >= 3.545 && leading < 9.495 ? 1 : 2);
    return `${value.toFixed(shown)} ± ${u.toFixed(shown)} ${prefix}${unit}`;
}

// Of a unit of VERSION.
function symbol(unit) {
    return { ohm: "Ω", degC: "°C", deg: "°" }[unit] ?? unit;
}

class Channel {
    constructor({ id, unit }) {
        this.id = id;
        this.unit = unit;
        this.points = [];
        this.root = $("channel").content.cloneNode(true).firstElementChild;
        this.root.dataset.channel = id;
        this.part(".name").textContent = id;
        this.silence();
    }

    part(selector) {
        return this.root.querySelector(selector);
    }

    say(selector, text) {
        const part = this.part(selector);
        if (part.textContent !== text) part.textContent = text;
    }

    state(name, text = name) {
        this.say(".state", text);
        this.part(".state").className = `state ${name}`;
    }

    // Of its trigger; not known is not pressed.
    press(event) {
        this.part(".pressed").hidden = event !== "pressed";
    }

    // No reading, or none that is fresh.
    silence() {
        this.seen = null;
        this.rate = undefined;
        this.state("unknown", "no reading");
        for (const part of [".value", ".more", ".note"]) this.say(part, "");
        this.add(undefined);
    }

    hear(reading) {
        const now = performance.now();
        // Drawn where it was measured, not where it came.
        const measured_at = reading.t_mono_ns / 1e6;
        clock = Math.min(clock, now - measured_at);
        // It may have waited on its way: fresh is what was measured now.
        this.seen = measured_at + clock;
        const { status, r_ohm, r_u_ohm, r_min_ohm, r_max_ohm } = reading;
        const { value: v, value_u: u, value_min: least, value_max: most } = reading;
        const shows = this.unit !== "ohm", unit = symbol(this.unit);
        this.state(status, status === "fault" ? reading.fault : status);
        const resistance = measured(r_ohm, r_u_ohm, "Ω");
        const own = measured(v, u, unit);
        const bound = (sign, value, unit) => (value === undefined ? "" : `${sign} ${measured(value, undefined, unit)}`);
        const bounds = [bound("<", most, unit) || bound(">", least, unit), bound(">", r_min_ohm, "Ω") || bound("<", r_max_ohm, "Ω")];
        const shown = status === "ok" ? [shows ? own : "", resistance] : bounds;
        const [value, more] = shows && shown[0] ? shown : [shown[1], ""];
        this.say(".value", value || "\u2014");
        this.say(".more", more);
        this.say(".note", ["moving", "settling", "extrapolated"].filter((flag) => reading[flag]).join(", ") || reading.hint || "");
        this.add(v, u, measured_at + clock);
    }

    // A point without a value is a gap.
    add(value, u = 0, at = performance.now()) {
        this.points.push([at, value, u]);
        if (this.points.length > POINTS) this.points.shift();
    }

    draw(now) {
        if (this.seen !== null && now - this.seen > patience_ms) this.silence();
        while (this.points.length && now - this.points[0][0] > SPAN_MS) this.points.shift();
        const known = this.points.filter(([, value]) => value !== undefined);
        let low = Infinity, high = -Infinity;
        for (const [, value, u] of known) {
            low = Math.min(low, value - u);
            high = Math.max(high, value + u);
        }
        const range = high - low || 1;
        const span = Math.min(SPAN_MS, Math.max(SHORTEST_MS, now - (this.points[0]?.[0] ?? now)));
        const at = ([t, value], offset = 0) => {
            const x = WIDTH * (1 - (now - t) / span), y = HEIGHT * (0.95 - 0.9 * ((value + offset - low) / range));
            return `${x.toFixed(1)} ${y.toFixed(1)}`;
        };
        const runs = [[]];
        for (const point of this.points) point[1] === undefined ? runs.push([]) : runs.at(-1).push(point);
        const drawn = runs.filter((run) => run.length > 1);
        this.part(".line").setAttribute("d", drawn.map((run) => "M" + run.map((p) => at(p)).join("L")).join(""));
        const around = (run) => [...run.map((p) => at(p, p[2])), ...run.toReversed().map((p) => at(p, -p[2]))].join("L");
        this.part(".band").setAttribute("d", drawn.map((run) => `M${around(run)}Z`).join(""));
        this.describe(known.length > 0, low, high, range, span);
    }

    describe(isKnown, low, high, range, span) {
        const unit = symbol(this.unit);
        const from = isKnown ? `from ${end(low, range, unit)}` : "", to = isKnown ? `to ${end(high, range, unit)}` : "";
        const past = `the last ${(span / 1000).toFixed(0)} s`;
        this.say(".low", from);
        this.say(".high", to);
        this.say(".span", this.rate > 0 ? `${past}, ${this.rate.toPrecision(3)}/s` : past);
        const label = isKnown ? `${this.id}: ${from} ${to} in ${past}` : `${this.id}: nothing in ${past}`;
        if (this.label !== label) this.part("svg").setAttribute("aria-label", (this.label = label));
    }
}

function link(text, kind) {
    $("link").textContent = text;
    $("link").className = kind;
}

function up({ release, channels: known, patience_s }) {
    patience_ms = 1000 * patience_s;
    clock = Infinity;
    link(`cermd ${release}: live`, "live");
    for (const [id, channel] of channels) {
        const same = known.some((info) => info.id === id && info.unit === channel.unit);
        if (!same) channels.delete(id);
    }
    for (const info of known) {
        if (channels.has(info.id)) channels.get(info.id).silence();
        else channels.set(info.id, new Channel(info));
        channels.get(info.id).press();
    }
    $("channels").replaceChildren(...known.map((info) => channels.get(info.id).root));
}

function away(text) {
    link(text, "away");
    for (const channel of channels.values()) {
        channel.silence();
        channel.press();
    }
    $("health").hidden = true;
    counted = null;
}

function health(stats) {
    const figures = [];
    const tell = (name, text) => text && figures.push([name, text]);
    if (counted && stats.uptime_s > counted.uptime_s && stats.readings >= counted.readings) {
        tell("readings a second", ((stats.readings - counted.readings) / (stats.uptime_s - counted.uptime_s)).toPrecision(3));
    }
    counted = stats;
    for (const [id, channel] of channels) channel.rate = stats.channels?.[id]?.rate_hz;
    tell("method", stats.method);
    const scaled = (ns) => (ns === undefined ? undefined : ns / 1000);
    tell("latency offset", measured(scaled(stats.offset_ns), scaled(stats.offset_u_ns), "µs") || "not known yet");
    tell("pin resistance", measured(stats.r_o_ohm, stats.r_o_u_ohm, "Ω"));
    tell("leak", measured(stats.leak_ohm, undefined, "Ω"));
    tell("feeds node A", measured(stats.feed_ohm, undefined, "Ω"));
    const faults = Object.entries(stats.faults).filter(([, count]) => count > 0);
    tell("faults", faults.map(([name, count]) => `${count} ${name}`).join(", ") || "none");
    tell("readings", `${stats.ok} ok, ${stats.moving} of them moving, ${stats.open} open, ${stats.short} short`);
    tell("GPIO lines", stats.gpio_works ? "in use" : "cannot be used");
    tell("running", stats.uptime_s < 120 ? `${stats.uptime_s.toFixed(0)} s` : `${(stats.uptime_s / 60).toFixed(0)} min`);
    tell("backend", stats.backend);
    $("figures").replaceChildren(...figures.map(([name, text]) => {
        const [group, term, figure] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
        term.textContent = name;
        figure.textContent = text;
        group.append(term, figure);
        return group;
    }));
    $("hint").textContent = stats.hint ?? "";
    $("hint").hidden = !stats.hint;
    $("health").hidden = false;
}

function listen() {
    const events = new EventSource("events");
    const on = (name, does) => events.addEventListener(name, (event) => does(JSON.parse(event.data)));
    on("up", up);
    on("down", () => away("cermd does not answer"));
    on("stats", health);
    on("reading", (reading) => channels.get(reading.channel)?.hear(reading));
    on("event", ({ channel, event }) => channels.get(channel)?.press(event));
    events.onerror = () => {
        away("no connection; trying again");
        // After a refusal it would not come again by itself.
        events.close();
        setTimeout(listen, RETRY_MS);
    };
}

setInterval(() => {
    const now = performance.now();
    for (const channel of channels.values()) channel.draw(now);
}, REDRAW_MS);
listen();
