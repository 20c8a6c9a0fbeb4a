// SPDX-License-Identifier: MIT OR Apache-2.0
/*
 * Preloaded into the emulator: the host's wall clock stands still.
 *
 * The emulator resizes its cache of translated addresses by what it needed in the last 100 ms of the host's time
 * (tlb_mmu_resize_locked in accel/tcg/cputlb.c). What that cache still holds decides whether the guest takes some
 * spurious page faults, so the host's load shows in the guest's instruction count. This is the only use of the wall
 * clock while the guest's own clock is virtual.
 */
#include <stddef.h>
#include <sys/time.h>

int gettimeofday(struct timeval *restrict tv, void *restrict zone)
{
	(void)zone;
	tv->tv_sec = 1767225600;
	tv->tv_usec = 0;
	return 0;
}
