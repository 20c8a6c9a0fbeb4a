// SPDX-License-Identifier: GPL-2.0-only
/*
 * A discharge takes the same charge from both capacitors: node B falls k = C_A/(C_A+C_B) times as far as A. With a and b, how far
 * they are below V_DD, b = k a stays so, unless something takes charge from B: b = k a + lost.
 *
 * A charge through A alone brings back what discharges took, a and k a with the time constant R C_A C_B/(C_A+C_B). All chargers
 * bring a and b back, by
 *
 *	R da/dt = -(1/C_A + 1/C_B) a - b / C_B		R db/dt = -a / C_B - b / C_B
 *
 * The matrix is symmetric: its modes are (-y, 1), with tau = R (C_B + 2 C_A + sqrt(C_B^2 + 4 C_A^2)) / 2 and y = 1 - R C_B/tau,
 * and (1, y), with R^2 C_A C_B/tau.
 *
 * A discharge from a runs as any, from the progress -C_T ln(1 - a) on; and B crosses earlier for what it has lost, by
 * C_T ln(1 + lost/(k e_B)), with e_B = exp(-g_B/C_T) that is left of A when B crosses.
 */
#include <linux/kernel.h>
#include <linux/module.h>

#include "charge.h"
#include "fixed.h"

/* Defaults: 220 ohm from each charger to its node, its pin included. */
static unsigned long c_pf[2] = { 2200000, 680000 };
module_param_array(c_pf, ulong, NULL, 0644);
MODULE_PARM_DESC(c_pf, "C_A and C_B, in pF; where there is no node B, the capacitor and nothing");
static unsigned long charge_mohm = 220000;
module_param(charge_mohm, ulong, 0644);
MODULE_PARM_DESC(charge_mohm, "from the supply through a charger to its node, in milliohm");

static u64 tau(u64 pf)
{
	return max(div64_u64((u64)charge_mohm * pf, 1000000), 1ULL);
}

/* C_T: both capacitors in series. */
static u64 total_pf(bool two)
{
	return max(two ? mul_u64_u64_div_u64(c_pf[0], c_pf[1], max(c_pf[0] + c_pf[1], 1UL)) : c_pf[0], 1ULL);
}

/* k */
static u64 share_of_b(void)
{
	return mul_u64_u64_div_u64(c_pf[0], ONE, max(c_pf[0] + c_pf[1], 1UL));
}

struct charge charge_none(bool two)
{
	return (struct charge){ .two = two, .along = ONE, .lost = two ? ONE - share_of_b() : 0 };
}

u64 charge_tau(const struct charge *c, enum chargers chargers)
{
	if (chargers != ALL_CHARGERS || !c->two)
		return tau(total_pf(c->two));
	return tau((c_pf[1] + 2 * c_pf[0] + int_sqrt(c_pf[1] * c_pf[1] + 4 * c_pf[0] * c_pf[0])) / 2);
}

void charge_bring(struct charge *c, enum chargers chargers, u64 dt)
{
	u64 k = share_of_b(), slow = charge_tau(c, chargers), y, share;
	s64 a = c->along, b = scaled(a, k) + c->lost, in_slow, in_fast;

	if (chargers != ALL_CHARGERS || !c->two) {
		c->along = scaled(a, decay(dt, slow));
		return;
	}
	y = ONE - mul_u64_u64_div_u64(tau(c_pf[1]), ONE, slow);
	share = mul_u64_u64_div_u64(ONE, ONE, ONE + mul_u64_u64_shr(y, y, 32));
	in_slow = scaled(scaled(b - scaled(a, y), share), decay(dt, slow));
	in_fast = scaled(scaled(a + scaled(b, y), share), decay(dt, max(mul_u64_u64_div_u64(tau(c_pf[0]), tau(c_pf[1]), slow), 1ULL)));
	c->along = in_fast - scaled(in_slow, y);
	c->lost = in_slow + scaled(in_fast, y) - scaled(c->along, k);
}

void charge_take(struct charge *c, u64 theta)
{
	c->along = (s64)ONE - scaled((s64)ONE - c->along, decay(theta, units_from_pf(total_pf(c->two))));
}

void charge_leak(struct charge *c, u64 kohm, u64 dt, u64 theta, u64 way)
{
	u64 total = units_from_pf(total_pf(c->two));
	s64 fallen = (s64)ONE - scaled(scaled((s64)ONE - c->along, decay(theta, total)), mean_decay(way, total));
	s64 high = (s64)ONE - c->lost - scaled(fallen, share_of_b());

	c->lost += scaled(high, mul_u64_u64_div_u64(dt, ONE, max(kohm * (c_pf[0] + c_pf[1]), 1UL)));
}

void charge_missing(const struct charge *c, const u64 g[2], s64 missing[2])
{
	u64 total = units_from_pf(total_pf(c->two)), left;

	missing[0] = missing[1] = scaled(minus_log(c->along), total);
	if (!c->two)
		return;
	left = max(mul_u64_u64_shr(share_of_b(), decay(g[1], total), 34), 1ULL);	/* k e_B in 2^-30 */
	missing[1] -= scaled(minus_log(max(div64_s64(-c->lost << 30, left), -(s64)ONE)), total);
}
