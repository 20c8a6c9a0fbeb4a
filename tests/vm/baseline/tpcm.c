// SPDX-License-Identifier: MIT OR Apache-2.0
/*
 * tpcm READINGS [checked]: reads a resistor by two-point calibration in the plainest way: C, libgpiod, one node, no daemon.
 *
 * The measure for what a reading may cost beside the physics. Charges, discharges through Rc1, Rc2 and Rx, waits for the
 * falling edge, R_x = (T_x - T_c1) / (T_c2 - T_c1) (Rc2 - Rc1) + Rc1. Prints the mean and the CPU time per reading.
 * "checked" does as cermd does: forgets old edges and looks at the level before each discharge, and never waits so long
 * that the processor stops its tick, which makes stamps late.
 */
#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

static const enum gpiod_line_value released = GPIOD_LINE_VALUE_ACTIVE, sinking = GPIOD_LINE_VALUE_INACTIVE;

static const unsigned int sense = 5, chargers[] = { 13, 19 }, sinks[] = { 20, 21, 16 };
static const double rc1 = 2320, rc2 = 12700;

static struct gpiod_line_request *sense_request, *charge_request, *sink_request;
static struct gpiod_edge_event_buffer *events;
static int checked;

static void die(const char *what)
{
	fprintf(stderr, "%s: %s\n", what, strerror(errno));
	exit(1);
}

static struct gpiod_chip *find_chip(const char *label)
{
	char path[32];

	for (int i = 0; i < 16; i++) {
		snprintf(path, sizeof(path), "/dev/gpiochip%d", i);
		struct gpiod_chip *chip = gpiod_chip_open(path);
		struct gpiod_chip_info *info = chip ? gpiod_chip_get_info(chip) : NULL;
		if (info && strcmp(gpiod_chip_info_get_label(info), label) == 0)
			return chip;
	}
	die("no chip");
	return NULL;
}

static struct gpiod_line_request *request(struct gpiod_chip *chip, const unsigned int *lines, size_t count,
					  struct gpiod_line_settings *settings)
{
	struct gpiod_line_config *config = gpiod_line_config_new();

	gpiod_line_config_add_line_settings(config, lines, count, settings);
	struct gpiod_line_request *made = gpiod_chip_request_lines(chip, NULL, config);
	if (!made)
		die("request");
	gpiod_line_config_free(config);
	gpiod_line_settings_free(settings);
	return made;
}

static struct gpiod_line_settings *output(enum gpiod_line_drive drive, enum gpiod_line_value value)
{
	struct gpiod_line_settings *settings = gpiod_line_settings_new();

	gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
	gpiod_line_settings_set_drive(settings, drive);
	gpiod_line_settings_set_output_value(settings, value);
	return settings;
}

static void open_lines(void)
{
	struct gpiod_chip *chip = find_chip("cermd-rc");
	struct gpiod_line_settings *input = gpiod_line_settings_new();

	gpiod_line_settings_set_direction(input, GPIOD_LINE_DIRECTION_INPUT);
	gpiod_line_settings_set_edge_detection(input, GPIOD_LINE_EDGE_FALLING);
	gpiod_line_settings_set_bias(input, GPIOD_LINE_BIAS_DISABLED);
	sense_request = request(chip, &sense, 1, input);
	charge_request = request(chip, chargers, 2, output(GPIOD_LINE_DRIVE_OPEN_SOURCE, GPIOD_LINE_VALUE_INACTIVE));
	sink_request = request(chip, sinks, 3, output(GPIOD_LINE_DRIVE_OPEN_DRAIN, released));
	events = gpiod_edge_event_buffer_new(1);
}

static void charge(enum gpiod_line_value value)
{
	enum gpiod_line_value values[] = { value, value };

	if (gpiod_line_request_set_values(charge_request, values))
		die("charge");
}

static int64_t now(clockid_t clock)
{
	struct timespec ts;

	clock_gettime(clock, &ts);
	return ts.tv_sec * 1000000000ll + ts.tv_nsec;
}

static void check(void)
{
	while (gpiod_line_request_read_edge_events(sense_request, events, 1) > 0)
		;
	if (errno != EAGAIN || gpiod_line_request_get_value(sense_request, sense) != GPIOD_LINE_VALUE_ACTIVE)
		die("charge");
}

static int wait_for_edge(void)
{
	int ready = 0;

	for (int waits = 0; ready == 0 && waits < 300; waits++)
		ready = gpiod_line_request_wait_edge_events(sense_request, checked ? 3000000 : 1000000000);
	return ready;
}

static int64_t discharge(unsigned int sink)
{
	const struct timespec full = { 0, 20000000 };

	charge(GPIOD_LINE_VALUE_ACTIVE);
	clock_nanosleep(CLOCK_MONOTONIC, 0, &full, NULL);
	charge(GPIOD_LINE_VALUE_INACTIVE);
	if (checked)
		check();
	int64_t before = now(CLOCK_MONOTONIC);
	if (gpiod_line_request_set_value(sink_request, sink, sinking))
		die("sink");
	if (wait_for_edge() != 1 || gpiod_line_request_read_edge_events(sense_request, events, 1) != 1)
		die("edge");
	if (gpiod_line_request_set_value(sink_request, sink, released))
		die("release");
	return gpiod_edge_event_get_timestamp_ns(gpiod_edge_event_buffer_get_event(events, 0)) - before;
}

int main(int argc, char **argv)
{
	int readings = argc > 1 ? atoi(argv[1]) : 100;
	double sum = 0;
	struct rusage usage;

	checked = argc > 2;
	open_lines();
	if (checked)
		fcntl(gpiod_line_request_get_fd(sense_request), F_SETFL, O_NONBLOCK);
	int64_t cpu = now(CLOCK_PROCESS_CPUTIME_ID), start = now(CLOCK_MONOTONIC);
	for (int i = 0; i < readings; i++) {
		double c1 = discharge(sinks[0]), c2 = discharge(sinks[1]), x = discharge(sinks[2]);

		sum += (x - c1) / (c2 - c1) * (rc2 - rc1) + rc1;
	}
	cpu = now(CLOCK_PROCESS_CPUTIME_ID) - cpu;
	start = now(CLOCK_MONOTONIC) - start;
	getrusage(RUSAGE_SELF, &usage);
	printf("readings %d mean_ohm %.3f cpu_us_per_reading %.2f wall_us_per_reading %.1f\n", readings, sum / readings,
	       cpu / 1e3 / readings, start / 1e3 / readings);
	printf("rusage user_us %ld system_us %ld\n", (long)usage.ru_utime.tv_sec * 1000000 + usage.ru_utime.tv_usec,
	       (long)usage.ru_stime.tv_sec * 1000000 + usage.ru_stime.tv_usec);
	return 0;
}
