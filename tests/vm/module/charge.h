/* SPDX-License-Identifier: GPL-2.0-only */
/* The capacitors from discharge to discharge: what a charge brings back, and what it leaves. */
#ifndef GPIO_CERMD_CHARGE_H
#define GPIO_CERMD_CHARGE_H

#include <linux/types.h>

enum chargers { NO_CHARGER, CHARGER_A, ALL_CHARGERS };

/* Below V_DD, in 2^-32 of it. */
struct charge {
	bool two;	/* there is a node B */
	s64 along;	/* node A; what a discharge takes from A it takes from B C_A/(C_A+C_B) times */
	s64 lost;	/* node B, beside that: no charge through A brings it back */
};

struct charge charge_none(bool two);
/* What @chargers bring back in @dt ns. */
void charge_bring(struct charge *c, enum chargers chargers, u64 dt);
/* Their slowest time constant, ns. */
u64 charge_tau(const struct charge *c, enum chargers chargers);
/* What a discharge of the progress @theta takes. */
void charge_take(struct charge *c, u64 theta);
/* What leakage from B to ground takes in @dt ns, while the progress goes on from @theta by @way. */
void charge_leak(struct charge *c, u64 kohm, u64 dt, u64 theta, u64 way);
/* By how much less progress than @g, after a full charge, nodes A and B cross. */
void charge_missing(const struct charge *c, const u64 g[2], s64 missing[2]);

#endif
