// SPDX-License-Identifier: GPL-2.0-only
/*
 * The circuit behind the pins of gpio-cermd: two capacitors and some resistors.
 *
 *   GPIO13 --Rp-- node A --C_A-- node B --Rp-- GPIO19        chargers, drive high
 *                 |  |              |  |
 *             GPIO5  |          GPIO6  C_B                   sense lines (they may charge, too)
 *                    |                 |
 *     GPIO20 --Rc1---+                ground                 sinks, drive low:
 *     GPIO21 --Rc2---+--Rx0-- GPIO16                         calibration resistors and sensors
 *                    +--Rx1-- GPIO26
 *
 * The network is not solved: every discharge runs along one trajectory, at a speed of sum 1/(R + Ro) over the
 * resistors that sink (Ro: output resistance of the pin). So the state is one number, the progress
 *
 *	theta = integral of sum 1/(R_i + Ro_i) dt	[ns/ohm = nF]
 *
 * and sense line A falls when theta reaches g_A, sense line B at g_B. While both nodes are charged, theta relaxes
 * exponentially towards 0; otherwise it stays. Crossings are hrtimers that raise the interrupts of the sense lines,
 * planned anew whenever a line changes.
 *
 * What a charge leaves of the discharge before it, through A alone (which charges B, too, through C_A) or through all
 * chargers, changes the progress at which the nodes cross: charge.c.
 *
 * What else the law does not know, each to first order and none by default. Leakage to ground goes on without a sink and
 * adds to the speed of each node: at A as any resistor there; at B, beside the trajectory, by leak_b_permille of what the same
 * resistor would do at A (integrated over the discharge; it is the same for any resistor that sinks); and it takes from B what
 * no charge through A brings back. Dielectric absorption is one branch: a share of the charge follows theta with a time
 * constant of its own, and has to be drawn, too.
 *
 * /sys/kernel/debug/gpio-cermd/discharges holds the true instants of the last discharges (CLOCK_MONOTONIC, ns):
 * the difference between a crossing there and the stamp that user space got is the true latency.
 * .../outputs is the mask of lines that drive now (gpiolib goes on calling a released open-drain line an output), .../high of
 * those that would drive high.
 * /sys/module/gpio_cermd/parameters: the circuit; what is written takes effect at the next change of a line.
 */
#include <linux/debugfs.h>
#include <linux/hrtimer.h>
#include <linux/module.h>
#include <linux/spinlock.h>
#include <linux/version.h>

#include "charge.h"
#include "circuit.h"
#include "fixed.h"
#include "records.h"

#define CHARGE_A	13
#define CHARGE_B	19
#define SINKS		4
#define SINK_MASK	(BIT(20) | BIT(21) | BIT(16) | BIT(26))
#define CHARGE_MASK	(BIT(CHARGE_A) | BIT(CHARGE_B) | SENSE_MASK)

static const unsigned int sink_line[SINKS] = { 20, 21, 16, 26 };

/* Defaults: 2.2 uF and 680 nF, V_DD 3.3 V, V_Th 1.3 V. */
static unsigned long r_mohm[SINKS] = { 2320000, 12700000, 1000000, 0 };
module_param_array(r_mohm, ulong, NULL, 0644);
MODULE_PARM_DESC(r_mohm, "Rc1, Rc2, Rx0, Rx1 in milliohm; 0: nothing there");
static unsigned long ro_mohm[SINKS] = { 40000, 40000, 40000, 40000 };
module_param_array(ro_mohm, ulong, NULL, 0644);
MODULE_PARM_DESC(ro_mohm, "output resistance of the pins that sink Rc1, Rc2, Rx0, Rx1, in milliohm");
static unsigned int g_pf[2] = { 483893, 819120 };
module_param_array(g_pf, uint, NULL, 0644);
MODULE_PARM_DESC(g_pf, "progress at which nodes A and B cross, in pF; g_B = 0: there is no node B");
static unsigned int trigger_pf;
module_param(trigger_pf, uint, 0644);
MODULE_PARM_DESC(trigger_pf, "1 sigma of g_A and g_B from discharge to discharge: moves the true crossing");
static unsigned int leak_kohm[2];
module_param_array(leak_kohm, uint, NULL, 0644);
MODULE_PARM_DESC(leak_kohm, "leakage of nodes A and B to ground, in kohm; 0: none");
static unsigned int leak_b_permille[2] = { 881, 1732 };
module_param_array(leak_b_permille, uint, NULL, 0644);
MODULE_PARM_DESC(leak_b_permille, "what leakage of node B does to the progress of A and B, beside the same leakage of A");
static unsigned int absorbed_ppm, absorbed_tau_us = 10000;
module_param(absorbed_ppm, uint, 0644);
MODULE_PARM_DESC(absorbed_ppm, "dielectric absorption: capacity of the branch beside that of the capacitors");
module_param(absorbed_tau_us, uint, 0644);
MODULE_PARM_DESC(absorbed_tau_us, "its time constant");
static unsigned int hysteresis_pf[2];
module_param_array(hysteresis_pf, uint, NULL, 0644);
MODULE_PARM_DESC(hysteresis_pf, "by how much less progress a sense line that was low is high again");
static unsigned int stall_ns;
module_param(stall_ns, uint, 0644);
MODULE_PARM_DESC(stall_ns, "how much later a line moves, or is read, if the chip was not touched for 10 us");
static unsigned int late_ns, jitter_ns, tail_ns, tail_ppm;
module_param(late_ns, uint, 0644);
MODULE_PARM_DESC(late_ns, "mean time from a crossing to its interrupt, on top of the kernel's own; none if charging begins before");
module_param(jitter_ns, uint, 0644);
MODULE_PARM_DESC(jitter_ns, "1 sigma of that time; the sum is never negative");
module_param(tail_ns, uint, 0644);
MODULE_PARM_DESC(tail_ns, "by how much more, at least, a part of the interrupts is late: by n times as much in 1/n of them");
module_param(tail_ppm, uint, 0644);
MODULE_PARM_DESC(tail_ppm, "how large that part is");
static unsigned long seed = 1;
module_param(seed, ulong, 0444);
MODULE_PARM_DESC(seed, "of the noise, taken when the device is bound");
static unsigned long cut, stuck_low;
module_param(cut, ulong, 0644);
MODULE_PARM_DESC(cut, "mask of lines whose wire is broken: they drive nothing and read high");
module_param(stuck_low, ulong, 0644);
MODULE_PARM_DESC(stuck_low, "mask of lines shorted to ground: sinks always sink, inputs read low");
static unsigned int swallow;
module_param(swallow, uint, 0644);
MODULE_PARM_DESC(swallow, "how many of the next crossings raise no interrupt; counts down");
static unsigned long conflicts;
module_param(conflicts, ulong, 0644);
MODULE_PARM_DESC(conflicts, "how often a charger and a sink came to drive at once, or a line to drive the wrong way");

struct node {
	struct hrtimer timer;
	unsigned int line;
	u64 g;			/* threshold of this discharge */
	u64 late;		/* ns from the crossing to its interrupt in this discharge */
	u64 due;		/* instant of the crossing if nothing changes */
	bool crossed, raised;
	u64 theta, speed;	/* speed: units of theta per ns */
	bool low;		/* as the sense line reads */
};

static struct circuit {
	raw_spinlock_t lock;
	void (*fall)(unsigned int line);
	struct rnd_state rnd;
	unsigned long output, high, sinking;	/* masks of lines */
	bool conflict;
	enum chargers chargers;			/* that charge now */
	struct charge charge;
	s64 missing[2];				/* what it has left incomplete: by how much less progress nodes cross */
	s64 absorbed;				/* how far the branch of absorption has followed theta */
	u64 touched;				/* when the chip was */
	u64 at;					/* theta was computed for this instant */
	struct node node[2];
	struct record *record;			/* of the discharge under way */
	struct dentry *debugfs;
} circuit;

/* The progress of a node after @dt. No further than with empty capacitors, far below the thresholds. */
static u64 theta_after(struct circuit *c, struct node *node, u64 dt)
{
	u64 most = 2 * max(c->node[0].g, c->node[1].g);

	if (node->speed && dt > div64_u64(THETA_MAX - node->theta, node->speed))
		return most;
	return min(node->theta + dt * node->speed, most);
}

/* How far absorption will have followed node A after @dt. */
static s64 absorbed_after(struct circuit *c, u64 dt)
{
	u64 tau = max(absorbed_tau_us, 1U) * 1000ULL, from = c->node[0].theta, way;

	if (c->chargers)
		return scaled(c->absorbed, decay(dt, tau));
	way = theta_after(c, &c->node[0], dt) - from;
	return from + way - scaled(way, mean_decay(dt, tau)) + scaled(c->absorbed - (s64)from, decay(dt, tau));
}

/* What has to be drawn from a node until it crosses. */
static s64 needed(struct node *node, s64 absorbed)
{
	return absorbed_ppm ? node->g + div_s64(absorbed, 1000000) * absorbed_ppm : node->g;
}

/* Brings the state to @now; notes crossings on the way. */
static void advance(struct circuit *c, u64 now)
{
	u64 dt = now - c->at, left = c->chargers ? decay(dt, charge_tau(&c->charge, c->chargers)) : ONE;
	u64 theta = c->node[0].theta;
	int n;

	c->at = now;
	if (absorbed_ppm)
		c->absorbed = absorbed_after(c, dt);
	if (c->chargers)
		charge_bring(&c->charge, c->chargers, dt);
	for (n = 0; n < 2; n++) {
		struct node *node = &c->node[n];
		s64 missing;

		if (c->chargers) {
			node->theta = mul_u64_u64_shr(node->theta, left, 32);
		} else {
			node->theta = theta_after(c, node, dt);
			if (!node->crossed && node->due <= now) {
				node->crossed = true;
				if (c->record)
					c->record->cross[n] = node->due;
			}
		}
		missing = needed(node, c->absorbed) - node->theta;
		node->low = missing <= 0 || (node->low && missing <= units_from_pf(hysteresis_pf[n]));
	}
	if (leak_kohm[1] && c->charge.two && c->chargers != ALL_CHARGERS)
		charge_leak(&c->charge, leak_kohm[1], dt, c->chargers ? 0 : theta, c->chargers ? 0 : c->node[0].theta - theta);
}

/* Plans the crossings that are still to come. */
static void plan(struct circuit *c, u64 now)
{
	int n, i;

	for (n = 0; n < 2; n++) {
		struct node *node = &c->node[n];
		u64 dt = 0;

		if (node->crossed)
			continue;
		hrtimer_try_to_cancel(&node->timer);
		node->due = KTIME_MAX;
		if (c->chargers || !node->speed)
			continue;
		/* What is absorbed until then is known when the instant is: found by turns, which close in by absorbed_ppm. */
		for (i = 0; i < (absorbed_ppm ? 4 : 1); i++) {
			s64 missing = needed(node, absorbed_ppm ? absorbed_after(c, dt) : 0) - (s64)node->theta;

			dt = DIV64_U64_ROUND_UP(max_t(s64, missing, 0), node->speed);
		}
		node->due = now + dt;
		hrtimer_start(&node->timer, ns_to_ktime(node->due + node->late), HRTIMER_MODE_ABS_HARD);
	}
}

static void begin_discharge(struct circuit *c, u64 now)
{
	int n;

	c->record = records_new();
	*c->record = (struct record){ .first = c->sinking, .along = c->charge.along, .start = now };
	for (n = 0; n < 2; n++) {
		struct node *node = &c->node[n];
		s64 pf = max(g_pf[n] + noise(&c->rnd, trigger_pf), 1LL);

		node->g = g_pf[n] ? max_t(s64, units_from_pf(pf) - c->missing[n], 1) : THETA_MAX;
		node->late = max(late_ns + noise(&c->rnd, jitter_ns), 0LL) + tail(&c->rnd, tail_ppm, tail_ns);
		node->crossed = !g_pf[n] || node->low || node->theta >= node->g;
		node->raised = node->crossed;
	}
}

/* What it has left is in `missing` from now on. */
static void end_charge(struct circuit *c)
{
	u64 g[2] = { units_from_pf(g_pf[0]), units_from_pf(g_pf[1]) };
	int n;

	for (n = 0; n < 2; n++)
		if (!c->node[n].low)
			c->node[n].theta = 0;
	charge_missing(&c->charge, g, c->missing);
}

static void note_switch(struct circuit *c, u64 now)
{
	struct record *r = c->record;

	if (!r->release && r->first & ~c->sinking)
		r->release = now;
	if (!r->sink && c->sinking & ~r->first) {
		r->sink = now;
		r->next = c->sinking & ~r->first;
	}
}

static u64 speed_through(u64 mohm)
{
	return mohm ? div64_u64(1000ULL << NF_SHIFT, mohm) : 0;
}

/* The lines that drive to @level, through unbroken wires. */
static unsigned long driving(struct circuit *c, bool level)
{
	return c->output & (level ? c->high : ~c->high) & ~cut;
}

/* After each change of a line. Called with the lock held. */
static void rewire(struct circuit *c)
{
	unsigned long up = driving(c, true), down = driving(c, false), sinking = 0;
	bool charge_a = up & (BIT(CHARGE_A) | BIT(SENSE_A)), charge_b = up & (BIT(CHARGE_B) | BIT(SENSE_B));
	enum chargers chargers = !charge_a ? NO_CHARGER : charge_b || !g_pf[1] ? ALL_CHARGERS : CHARGER_A;
	bool conflict;
	u64 now = ktime_get_ns(), speed = 0;
	int i, n;

	advance(c, now);
	for (i = 0; i < SINKS; i++) {
		if (!r_mohm[i] || !((down | stuck_low) & BIT(sink_line[i])))
			continue;
		sinking |= BIT(sink_line[i]);
		speed += speed_through(r_mohm[i] + ro_mohm[i]);
	}
	conflict = (up & CHARGE_MASK && down & SINK_MASK) || up & SINK_MASK || down & CHARGE_MASK;
	if (conflict && !c->conflict)
		conflicts++;
	c->conflict = conflict;
	c->sinking = sinking;
	for (n = 0; n < 2; n++)
		c->node[n].speed = speed + speed_through(leak_kohm[0] * 1000000ULL) +
				   speed_through(leak_kohm[1] * 1000000ULL) * leak_b_permille[n] / 1000;
	c->charge.two = g_pf[1];
	if (chargers && !c->chargers)
		charge_take(&c->charge, c->node[0].theta);
	if (!chargers && c->chargers)
		end_charge(c);
	c->chargers = chargers;
	if (chargers)
		c->record = NULL;
	else if (c->record)
		note_switch(c, now);
	else if (sinking)
		begin_discharge(c, now);
	plan(c, now);
}

static enum hrtimer_restart crossing(struct hrtimer *timer)
{
	struct node *node = container_of(timer, struct node, timer);
	struct circuit *c = &circuit;
	bool raise;

	scoped_guard(raw_spinlock_irqsave, &c->lock) {
		u64 now = ktime_get_ns();

		advance(c, now);
		if (!node->crossed || node->raised || !c->record)
			return HRTIMER_NORESTART;
		node->raised = true;
		raise = BIT(node->line) & ~cut & ~stuck_low;
		if (raise && swallow) {
			swallow--;
			raise = false;
		}
		if (raise)
			c->record->irq[node - c->node] = now;
	}
	if (raise)
		c->fall(node->line);
	return HRTIMER_NORESTART;
}

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 13, 0)
static void hrtimer_setup(struct hrtimer *timer, enum hrtimer_restart (*function)(struct hrtimer *),
			  clockid_t clock, enum hrtimer_mode mode)
{
	hrtimer_init(timer, clock, mode);
	timer->function = function;
}
#endif

void circuit_start(void (*fall)(unsigned int line))
{
	struct circuit *c = &circuit;
	int n;

	memset(c, 0, sizeof(*c));
	raw_spin_lock_init(&c->lock);
	c->fall = fall;
	prandom_seed_state(&c->rnd, seed);
	c->at = ktime_get_ns();
	c->charge = charge_none(g_pf[1]);
	for (n = 0; n < 2; n++) {
		c->node[n] = (struct node){ .line = n ? SENSE_B : SENSE_A, .g = units_from_pf(g_pf[n]),
					    .due = KTIME_MAX, .crossed = true, .raised = true,
					    .theta = THETA_MAX, .low = true };
		hrtimer_setup(&c->node[n].timer, crossing, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_HARD);
	}
	c->debugfs = debugfs_create_dir("gpio-cermd", NULL);
	records_start(c->debugfs, &c->lock);
	debugfs_create_ulong("outputs", 0444, c->debugfs, &c->output);
	debugfs_create_ulong("high", 0444, c->debugfs, &c->high);
}

void circuit_stop(void)
{
	debugfs_remove(circuit.debugfs);
	hrtimer_cancel(&circuit.node[0].timer);
	hrtimer_cancel(&circuit.node[1].timer);
}

/* A bus on the way to the chip falls asleep. */
static void touch(struct circuit *c)
{
	u64 from = ktime_get_ns();

	if (stall_ns && from - c->touched > 10000)
		while (ktime_get_ns() - from < stall_ns)
			cpu_relax();
	c->touched = ktime_get_ns();
}

void circuit_change(unsigned int line, bool output, bool high)
{
	touch(&circuit);
	guard(raw_spinlock_irqsave)(&circuit.lock);
	__assign_bit(line, &circuit.output, output);
	__assign_bit(line, &circuit.high, high);
	rewire(&circuit);
}

bool circuit_is_output(unsigned int line)
{
	return test_bit(line, &circuit.output);
}

bool circuit_latch(unsigned int line)
{
	return test_bit(line, &circuit.high);
}

/* An input reads the node behind it. */
bool circuit_level(unsigned int line)
{
	struct node *node = &circuit.node[line == SENSE_B || line == CHARGE_B];

	touch(&circuit);
	guard(raw_spinlock_irqsave)(&circuit.lock);
	if (stuck_low & BIT(line))
		return false;
	if (circuit.output & BIT(line))
		return circuit.high & BIT(line);
	if (cut & BIT(line))
		return true;
	if (!(BIT(line) & (CHARGE_MASK | SINK_MASK)))
		return false;
	advance(&circuit, ktime_get_ns());
	return !node->low;
}
