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
 * What a charge of the time t leaves of the discharge before it is off that trajectory, with the slower mode of the
 * network under charge: both nodes cross at another progress, to first order
 *
 *	g_n + memory_n (1 - exp(-theta / C_T)) exp(-t / tau),	C_T = C_A C_B / (C_A + C_B)
 *
 * with the theta at which that discharge ended. tau and memory_n are from a numerical integration of the network.
 *
 * /sys/kernel/debug/gpio-cermd/discharges holds the true instants of the last discharges (CLOCK_MONOTONIC, ns):
 * the difference between a crossing there and the stamp that user space got is the true latency.
 * .../outputs is the mask of lines that drive now (gpiolib goes on calling a released open-drain line an output).
 * /sys/module/gpio_cermd/parameters: the circuit; what is written takes effect at the next change of a line.
 */
#include <linux/debugfs.h>
#include <linux/hrtimer.h>
#include <linux/math64.h>
#include <linux/module.h>
#include <linux/prandom.h>
#include <linux/seq_file.h>
#include <linux/spinlock.h>
#include <linux/version.h>

#include "circuit.h"

#define CHARGE_A	13
#define CHARGE_B	19
#define SINKS		4
#define SINK_MASK	(BIT(20) | BIT(21) | BIT(16) | BIT(26))
#define CHARGE_MASK	(BIT(CHARGE_A) | BIT(CHARGE_B) | SENSE_MASK)
#define RECORDS		8192

/* Progress is in units of 2^-46 nF: 1 ns at 10 Mohm is still 7 million of them. */
#define NF_SHIFT	46
#define THETA_MAX	(1ULL << 62)

static const unsigned int sink_line[SINKS] = { 20, 21, 16, 26 };

/* Defaults: 2.2 uF and 680 nF, V_DD 3.3 V, V_Th 1.3 V; 220 ohm from each charger to its node. */
static unsigned long r_mohm[SINKS] = { 2320000, 12700000, 1000000, 0 };
module_param_array(r_mohm, ulong, NULL, 0644);
MODULE_PARM_DESC(r_mohm, "Rc1, Rc2, Rx0, Rx1 in milliohm; 0: nothing there");
static unsigned long ro_mohm[SINKS] = { 40000, 40000, 40000, 40000 };
module_param_array(ro_mohm, ulong, NULL, 0644);
MODULE_PARM_DESC(ro_mohm, "output resistance of the pins that sink Rc1, Rc2, Rx0, Rx1, in milliohm");
static unsigned int g_pf[2] = { 483893, 819120 };
module_param_array(g_pf, uint, NULL, 0644);
MODULE_PARM_DESC(g_pf, "progress at which nodes A and B cross, in pF; g_B = 0: there is no node B");
static unsigned int charge_tau_ns = 1048546;
module_param(charge_tau_ns, uint, 0644);
MODULE_PARM_DESC(charge_tau_ns, "time constant of charging");
static int memory_pf[2] = { -23984, 269400 };
module_param_array(memory_pf, int, NULL, 0644);
MODULE_PARM_DESC(memory_pf, "what a charge of no time would add to g_A and g_B after a discharge to 0 V, in pF");
static unsigned int total_pf = 519444;
module_param(total_pf, uint, 0644);
MODULE_PARM_DESC(total_pf, "C_T: C_A and C_B in series, in pF");
static unsigned int trigger_pf;
module_param(trigger_pf, uint, 0644);
MODULE_PARM_DESC(trigger_pf, "1 sigma of g_A and g_B from discharge to discharge: moves the true crossing");
static unsigned int late_ns, jitter_ns;
module_param(late_ns, uint, 0644);
MODULE_PARM_DESC(late_ns, "mean time from a crossing to its interrupt, on top of the kernel's own; none if charging begins before");
module_param(jitter_ns, uint, 0644);
MODULE_PARM_DESC(jitter_ns, "1 sigma of that time; the sum is never negative");
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

/* One discharge; instants in ns, 0: has not happened. */
struct record {
	unsigned long first, next;	/* lines that sank at the start; that were added later */
	u64 depth;			/* left by the charge before it */
	u64 start, release, sink;	/* a first line sank; was released; a next one sank */
	u64 cross[2], irq[2];		/* nodes A and B: the law's crossing; the interrupt was raised */
};

struct node {
	struct hrtimer timer;
	unsigned int line;
	u64 g;			/* threshold of this discharge */
	u64 late;		/* ns from the crossing to its interrupt in this discharge */
	u64 due;		/* instant of the crossing if nothing changes */
	bool crossed, raised;
};

static struct circuit {
	raw_spinlock_t lock;
	void (*fall)(unsigned int line);
	struct rnd_state rnd;
	unsigned long output, high, sinking;	/* masks of lines */
	bool charging, conflict;
	u64 theta, speed;			/* speed: units of theta per ns */
	u64 depth;				/* below V_DD, left of the last discharge: 2^-32 */
	u64 at;					/* theta was computed for this instant */
	struct node node[2];
	struct record *record;			/* of the discharge under way */
	u64 count;
	struct dentry *debugfs;
} circuit;

static struct record records[RECORDS];

static u64 units_from_pf(u64 pf)
{
	return min(mul_u64_u64_div_u64(pf, 1ULL << NF_SHIFT, 1000), THETA_MAX / 2);
}

/* exp(-dt / tau) with 32 binary digits, as 2^-whole x the series of exp(-part) */
static u64 decay(u64 dt, u64 tau)
{
	u64 x = mul_u64_u64_div_u64(min(dt, 40 * tau), 6196328019ULL /* 2^32 / ln 2 */, tau);
	u64 part = mul_u64_u64_shr(x & U32_MAX, 2977044472ULL /* 2^32 ln 2 */, 32);
	u64 term = 1ULL << 32, plus = 0, minus = 0;
	int i;

	for (i = 1; i < 16; i++) {
		if (i & 1)
			plus += term;
		else
			minus += term;
		term = mul_u64_u64_shr(term, part, 32) / i;
	}
	return (plus - minus) >> (x >> 32);
}

/* The sum of 12 uniform numbers: nearly Gaussian. */
static s64 noise(struct circuit *c, u32 sigma)
{
	s64 sum = -6LL << 32;
	int i;

	for (i = 0; i < 12; i++)
		sum += prandom_u32_state(&c->rnd);
	return (sum >> 8) * sigma >> 24;
}

/* Brings the state to @now; notes crossings on the way. */
static void advance(struct circuit *c, u64 now)
{
	u64 dt = now - c->at;
	int n;

	c->at = now;
	if (c->charging) {
		u64 left = decay(dt, max(charge_tau_ns, 1));

		c->theta = mul_u64_u64_shr(c->theta, left, 32);
		c->depth = mul_u64_u64_shr(c->depth, left, 32);
		return;
	}
	for (n = 0; n < 2; n++) {
		if (c->node[n].crossed || c->node[n].due > now)
			continue;
		c->node[n].crossed = true;
		if (c->record)
			c->record->cross[n] = c->node[n].due;
	}
	/* Far below the thresholds the capacitors are empty: no further. */
	if (c->speed && dt > div64_u64(THETA_MAX - c->theta, c->speed))
		c->theta = THETA_MAX;
	else
		c->theta += dt * c->speed;
	c->theta = min(c->theta, 2 * max(c->node[0].g, c->node[1].g));
}

/* Plans the crossings that are still to come. */
static void plan(struct circuit *c, u64 now)
{
	int n;

	for (n = 0; n < 2; n++) {
		struct node *node = &c->node[n];

		if (node->crossed)
			continue;
		hrtimer_try_to_cancel(&node->timer);
		node->due = KTIME_MAX;
		if (c->charging || !c->speed)
			continue;
		node->due = now + DIV64_U64_ROUND_UP(node->g - c->theta, c->speed);
		hrtimer_start(&node->timer, ns_to_ktime(node->due + node->late), HRTIMER_MODE_ABS_HARD);
	}
}

static void begin_discharge(struct circuit *c, u64 now)
{
	bool is_charged = true;
	int n;

	c->record = &records[c->count++ % RECORDS];
	*c->record = (struct record){ .first = c->sinking, .depth = c->depth, .start = now };
	for (n = 0; n < 2; n++) {
		struct node *node = &c->node[n];
		s64 pf = max(g_pf[n] + noise(c, trigger_pf), 1LL);
		s64 memory = div_s64((s64)memory_pf[n] * (s64)c->depth, 1000) << (NF_SHIFT - 32);

		node->g = g_pf[n] ? max_t(s64, units_from_pf(pf) + memory, 1) : THETA_MAX;
		node->late = max(late_ns + noise(c, jitter_ns), 0LL);
		node->crossed = !g_pf[n] || c->theta >= node->g;
		node->raised = node->crossed;
		is_charged &= c->theta < node->g;
	}
	if (is_charged)
		c->theta = 0;
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
	bool charging = charge_a && (charge_b || !g_pf[1]), conflict;
	u64 now = ktime_get_ns(), speed = 0;
	int i;

	advance(c, now);
	for (i = 0; i < SINKS; i++) {
		if (!r_mohm[i] || !((down | stuck_low) & BIT(sink_line[i])))
			continue;
		sinking |= BIT(sink_line[i]);
		speed += div64_u64(1000ULL << NF_SHIFT, r_mohm[i] + ro_mohm[i]);
	}
	conflict = (up & CHARGE_MASK && down & SINK_MASK) || up & SINK_MASK || down & CHARGE_MASK;
	if (conflict && !c->conflict)
		conflicts++;
	c->conflict = conflict;
	c->sinking = sinking;
	c->speed = speed;
	if (charging && c->record)
		c->depth = (1ULL << 32) - decay(c->theta, units_from_pf(max(total_pf, 1)));
	c->charging = charging;
	if (charging)
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

static void *records_start(struct seq_file *s, loff_t *pos)
{
	if (circuit.count > RECORDS)
		*pos = max_t(loff_t, *pos, circuit.count - RECORDS);
	return *pos < circuit.count ? pos : NULL;
}

static void *records_next(struct seq_file *s, void *v, loff_t *pos)
{
	++*pos;
	return records_start(s, pos);
}

static void records_stop(struct seq_file *s, void *v)
{
}

static int records_show(struct seq_file *s, void *v)
{
	loff_t i = *(loff_t *)v;
	struct record r;

	scoped_guard(raw_spinlock_irqsave, &circuit.lock)
		r = records[i % RECORDS];
	if (!i)
		seq_puts(s, "# seq first next depth_ppb start release sink a b a_irq b_irq\n");
	seq_printf(s, "%lld %#lx %#lx %llu %llu %llu %llu %llu %llu %llu %llu\n", i + 1, r.first, r.next,
		   mul_u64_u64_shr(r.depth, 1000000000, 32), r.start, r.release, r.sink,
		   r.cross[0], r.cross[1], r.irq[0], r.irq[1]);
	return 0;
}

static const struct seq_operations records_sops = {
	.start = records_start,
	.next = records_next,
	.stop = records_stop,
	.show = records_show,
};
DEFINE_SEQ_ATTRIBUTE(records);

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
	c->theta = THETA_MAX;
	c->depth = 1ULL << 32;
	for (n = 0; n < 2; n++) {
		c->node[n] = (struct node){ .line = n ? SENSE_B : SENSE_A, .g = units_from_pf(g_pf[n]),
					    .due = KTIME_MAX, .crossed = true, .raised = true };
		hrtimer_setup(&c->node[n].timer, crossing, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_HARD);
	}
	c->debugfs = debugfs_create_dir("gpio-cermd", NULL);
	debugfs_create_file("discharges", 0444, c->debugfs, NULL, &records_fops);
	debugfs_create_ulong("outputs", 0444, c->debugfs, &c->output);
}

void circuit_stop(void)
{
	debugfs_remove(circuit.debugfs);
	hrtimer_cancel(&circuit.node[0].timer);
	hrtimer_cancel(&circuit.node[1].timer);
}

void circuit_change(unsigned int line, bool output, bool high)
{
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
	return circuit.theta < node->g;
}
