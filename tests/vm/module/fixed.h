/* SPDX-License-Identifier: GPL-2.0-only */
/* Sums without floating point: what the circuit needs of exponentials and of chance. */
#ifndef GPIO_CERMD_FIXED_H
#define GPIO_CERMD_FIXED_H

#include <linux/math64.h>
#include <linux/minmax.h>
#include <linux/prandom.h>

#define ONE	(1ULL << 32)	/* a factor of 1 */

/* Progress is in units of 2^-46 nF: 1 ns at 10 Mohm is still 7 million of them. */
#define NF_SHIFT	46
#define THETA_MAX	(1ULL << 62)

static inline u64 units_from_pf(u64 pf)
{
	return min(mul_u64_u64_div_u64(pf, 1ULL << NF_SHIFT, 1000), THETA_MAX / 2);
}

/* exp(-dt / tau), as 2^-whole x the series of exp(-part) */
static inline u64 decay(u64 dt, u64 tau)
{
	u64 x = mul_u64_u64_div_u64(min(dt, 40 * tau), 6196328019ULL /* 2^32 / ln 2 */, tau);
	u64 part = mul_u64_u64_shr(x & U32_MAX, 2977044472ULL /* 2^32 ln 2 */, 32);
	u64 term = ONE, plus = 0, minus = 0;
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

/* (1 - exp(-x)) / x of x = dt / tau: the mean of exp(-t / tau) over dt */
static inline u64 mean_decay(u64 dt, u64 tau)
{
	u64 x = mul_u64_u64_div_u64(dt, ONE, tau);

	return x ? mul_u64_u64_div_u64(ONE - decay(dt, tau), ONE, x) : ONE;
}

static inline s64 scaled(s64 value, u64 factor)
{
	return value < 0 ? -(s64)mul_u64_u64_shr(-value, factor, 32) : (s64)mul_u64_u64_shr(value, factor, 32);
}

/* -ln(1 - x), for x from -1 to a half: within 3 % at these ends, else exact */
static inline s64 minus_log(s64 x)
{
	s64 power = x, sum = 0;
	int i;

	for (i = 1; i <= 32 && power; i++) {
		sum += div_s64(power, i);
		power = x < 0 ? -scaled(power, -x) : scaled(power, x);
	}
	return sum;
}

/* The sum of 12 uniform numbers: nearly Gaussian. */
static inline s64 noise(struct rnd_state *rnd, u32 sigma)
{
	s64 sum = -6LL << 32;
	int i;

	for (i = 0; i < 12; i++)
		sum += prandom_u32_state(rnd);
	return (sum >> 8) * sigma >> 24;
}

/* With the probability @ppm more than @least, and more than n times @least in 1/n of these cases: a heavy tail. */
static inline u64 tail(struct rnd_state *rnd, u32 ppm, u32 least)
{
	if (!ppm || prandom_u32_state(rnd) % 1000000 >= ppm)
		return 0;
	return div_u64((u64)least << 32, max(prandom_u32_state(rnd), 1U << 24));
}

#endif
