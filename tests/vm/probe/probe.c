// SPDX-License-Identifier: MIT OR Apache-2.0
/*
 * probe v2|v1|paper: tests the circuit in the kernel through the character device, with nothing of cermd in between.
 * "paper" is uAPI v2 without chargers: the sense lines charge the nodes themselves.
 *
 * Charges, discharges through c1, c2, x, and through x and then c2; compares the instants that the circuit exports
 * with the law of the circuit, and the stamps with those instants. Prints a table; exit status 1 if anything is off.
 */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <linux/gpio.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

enum { SENSE_A = 5, SENSE_B = 6, CHARGE_A = 13, CHARGE_B = 19 };
enum { X = 1, C1 = 2, C2 = 4, SINKS = 3 };	/* masks, in request order: what is released first comes first */

static const unsigned int sense[] = { SENSE_A, SENSE_B }, chargers[] = { CHARGE_A, CHARGE_B };
static const unsigned int sinks[SINKS] = { 16, 20, 21 };
static const double g_farad[2] = { 483893e-12, 819120e-12 };

static const uint64_t sense_flags =
	GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_FALLING | GPIO_V2_LINE_FLAG_BIAS_DISABLED;

struct times {	/* ns; 0: has not happened */
	int64_t start, release, sink, cross[2], irq[2], stamp[2];
};

static int chip, sense_fd[2], charge_fd, sink_fd, sense_count;
static bool v1, paper;

static void die(const char *what)
{
	fprintf(stderr, "%s: %s\n", what, strerror(errno));
	exit(errno == EINVAL && v1 ? 77 : 1);	/* EINVAL: this kernel has no uAPI v1 */
}

static int find_chip(void)
{
	char path[32];

	for (int i = 0; i < 16; i++) {
		struct gpiochip_info info;

		snprintf(path, sizeof(path), "/dev/gpiochip%d", i);
		int fd = open(path, O_RDWR | O_CLOEXEC);
		if (fd >= 0 && ioctl(fd, GPIO_GET_CHIPINFO_IOCTL, &info) == 0 && strcmp(info.label, "cermd-rc") == 0)
			return fd;
		if (fd >= 0)
			close(fd);
	}
	errno = ENODEV;
	die("no chip with the label cermd-rc");
	return -1;
}

static int request_v2(const unsigned int *lines, int count, uint64_t flags, uint64_t values)
{
	struct gpio_v2_line_request request = { .num_lines = count, .consumer = "probe" };

	memcpy(request.offsets, lines, count * sizeof(*lines));
	request.config.flags = flags;
	if (flags & GPIO_V2_LINE_FLAG_OUTPUT) {
		request.config.num_attrs = 1;
		request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
		request.config.attrs[0].attr.values = values;
		request.config.attrs[0].mask = (1u << count) - 1;
	}
	if (ioctl(chip, GPIO_V2_GET_LINE_IOCTL, &request))
		die("GPIO_V2_GET_LINE");
	return request.fd;
}

static int handle_v1(const unsigned int *lines, int count, uint32_t flags, int value)
{
	struct gpiohandle_request request = { .lines = count, .flags = flags, .consumer_label = "probe" };

	memcpy(request.lineoffsets, lines, count * sizeof(*lines));
	memset(request.default_values, value, count);
	if (ioctl(chip, GPIO_GET_LINEHANDLE_IOCTL, &request))
		die("GPIO_GET_LINEHANDLE");
	return request.fd;
}

static int event_v1(unsigned int line)
{
	struct gpioevent_request request = { .lineoffset = line, .consumer_label = "probe",
		.handleflags = GPIOHANDLE_REQUEST_INPUT | GPIOHANDLE_REQUEST_BIAS_DISABLE,
		.eventflags = GPIOEVENT_REQUEST_FALLING_EDGE };

	if (ioctl(chip, GPIO_GET_LINEEVENT_IOCTL, &request))
		die("GPIO_GET_LINEEVENT");
	return request.fd;
}

/* Open drain: 0 drives low, 1 releases. Open source: 1 drives high, 0 releases. */
static void open_lines(void)
{
	chip = find_chip();
	if (v1) {
		sink_fd = handle_v1(sinks, SINKS, GPIOHANDLE_REQUEST_OUTPUT | GPIOHANDLE_REQUEST_OPEN_DRAIN, 1);
		charge_fd = handle_v1(chargers, 2, GPIOHANDLE_REQUEST_OUTPUT | GPIOHANDLE_REQUEST_OPEN_SOURCE, 0);
		sense_fd[0] = event_v1(SENSE_A);
		sense_fd[1] = event_v1(SENSE_B);
		sense_count = 2;
	} else {
		sink_fd = request_v2(sinks, SINKS, GPIO_V2_LINE_FLAG_OUTPUT | GPIO_V2_LINE_FLAG_OPEN_DRAIN, ~0ull);
		charge_fd = request_v2(chargers, 2, GPIO_V2_LINE_FLAG_OUTPUT | GPIO_V2_LINE_FLAG_OPEN_SOURCE, 0);
		sense_fd[0] = request_v2(sense, 2, sense_flags, 0);
		sense_count = 1;
	}
}

static void set_values(int fd, int count, unsigned int values)
{
	struct gpio_v2_line_values set = { .bits = values, .mask = (1u << count) - 1 };
	struct gpiohandle_data data;

	for (int i = 0; i < count; i++)
		data.values[i] = values >> i & 1;
	if (v1 ? ioctl(fd, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &data) : ioctl(fd, GPIO_V2_LINE_SET_VALUES_IOCTL, &set))
		die("SET_VALUES");
}

static void sink(unsigned int mask) { set_values(sink_fd, SINKS, ~mask); }

static void charge(bool on)
{
	struct gpio_v2_line_config config = { .flags = on ? GPIO_V2_LINE_FLAG_OUTPUT : sense_flags };

	if (!paper) {
		set_values(charge_fd, 2, on ? 3 : 0);
		return;
	}
	if (on) {
		config.num_attrs = 1;
		config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_OUTPUT_VALUES;
		config.attrs[0].attr.values = config.attrs[0].mask = 3;
	}
	if (ioctl(sense_fd[0], GPIO_V2_LINE_SET_CONFIG_IOCTL, &config))
		die("SET_CONFIG");
}

/* Waits for one event on either sense line. */
static bool stamp(struct times *t, int timeout_ms)
{
	struct pollfd fds[2] = { { .fd = sense_fd[0], .events = POLLIN }, { .fd = sense_fd[1], .events = POLLIN } };
	struct gpio_v2_line_event event;
	struct gpioevent_data old;

	if (poll(fds, sense_count, timeout_ms) <= 0)
		return false;
	int node = v1 ? !(fds[0].revents & POLLIN) : 0;
	if (v1) {
		if (read(sense_fd[node], &old, sizeof(old)) != sizeof(old))
			die("read");
		t->stamp[node] = old.timestamp;
	} else {
		if (read(sense_fd[0], &event, sizeof(event)) != sizeof(event))
			die("read");
		t->stamp[event.offset == SENSE_B] = event.timestamp_ns;
	}
	return true;
}

/* The last line of the circuit's own record. */
static void truth(struct times *t)
{
	FILE *file = fopen("/sys/kernel/debug/gpio-cermd/discharges", "r");
	char line[512];

	if (!file)
		die("the circuit's record");
	while (fgets(line, sizeof(line), file))
		sscanf(line, "%*d %*x %*x %*u %" SCNd64 " %" SCNd64 " %" SCNd64 " %" SCNd64 " %" SCNd64 " %" SCNd64 " %" SCNd64,
		       &t->start, &t->release, &t->sink, &t->cross[0], &t->cross[1], &t->irq[0], &t->irq[1]);
	fclose(file);
}

static void sleep_ns(long ns)
{
	struct timespec ts = { ns / 1000000000, ns % 1000000000 };

	clock_nanosleep(CLOCK_MONOTONIC, 0, &ts, NULL);
}

static struct times discharge(unsigned int first, unsigned int next, long after_ns)
{
	struct times t = { 0 };

	charge(true);
	sleep_ns(20000000);
	charge(false);
	while (stamp(&t, 0))
		;
	memset(&t, 0, sizeof(t));
	sink(first);
	if (next) {
		sleep_ns(after_ns);
		sink(next);
	}
	for (int i = 0; i < 2 && stamp(&t, 1000); i++)
		;
	sink(0);
	truth(&t);
	return t;
}

/* Progress at crossing `node`, which has to be g; R1 and R2 are those of the first and the second part. */
static double progress(const struct times *t, int node, double r1, double r2)
{
	if (t->sink && t->cross[node] > t->sink)
		return ((t->release - t->start) / r1 + (t->cross[node] - t->sink) / r2) * 1e-9;
	return (t->cross[node] - t->start) / r1 * 1e-9;
}

static int check(const char *name, const struct times *t, double r1, double r2)
{
	int bad = 0;

	for (int node = 0; node < 2; node++) {
		double off = progress(t, node, r1, r2) / g_farad[node] - 1;
		int64_t late = t->stamp[node] - t->cross[node];

		printf("%-8s %c true %9" PRId64 " stamp %9" PRId64 " late %6" PRId64 " irq late %6" PRId64 " law off %+.1e\n",
		       name, "ab"[node], t->cross[node] - t->start, t->stamp[node] - t->start, late,
		       t->irq[node] - t->cross[node], off);
		/* 1 ns in the shortest time, and what 20 ms of charging leave: e^-19 of a third of g. */
		if (off > 3e-6 || off < -3e-6 || late <= 0 || late > 50000)
			bad = 1;
	}
	if (t->sink)
		printf("%-8s   switch %7" PRId64 " gap %5" PRId64 "\n", name, t->release - t->start, t->sink - t->release);
	return bad;
}

int main(int argc, char **argv)
{
	static const struct { const char *name; unsigned int first, next; long after_ns; double r1, r2; } runs[] = {
		{ "c1", C1, 0, 0, 2360, 0 }, { "c2", C2, 0, 0, 12740, 0 }, { "x", X, 0, 0, 1040, 0 },
		{ "x>c2", X, C2, 300000, 1040, 12740 }, { "x>c2 (b)", X, C2, 500000, 1040, 12740 },
		{ "c1>c2", C1, C2, 800000, 2360, 12740 },
	};
	int bad = 0;

	v1 = argc > 1 && strcmp(argv[1], "v1") == 0;
	paper = argc > 1 && strcmp(argv[1], "paper") == 0;
	open_lines();
	for (unsigned int i = 0; i < sizeof(runs) / sizeof(*runs); i++) {
		struct times t = discharge(runs[i].first, runs[i].next, runs[i].after_ns);

		bad |= check(runs[i].name, &t, runs[i].r1, runs[i].r2);
	}
	return bad;
}
