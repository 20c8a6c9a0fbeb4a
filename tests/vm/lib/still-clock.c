// SPDX-License-Identifier: MIT OR Apache-2.0
/*
 * Preloaded into the emulator, so that nothing of the host's time reaches the guest.
 *
 * 1. The host's wall clock stands still. The emulator resizes its cache of translated addresses by what it needed in the
 * last 100 ms of the host's time (tlb_mmu_resize_locked in accel/tcg/cputlb.c). What that cache still holds decides
 * whether the guest takes some spurious page faults, so the host's load shows in the guest's instruction count. This is
 * the only use of the wall clock while the guest's own clock is virtual.
 *
 * 2. The main thread looks at the processor only while the thread that emulates it waits. When the processor idles, the
 * main thread sets the guest's clock forward to the next timer (icount_start_warp_timer in accel/tcg/icount-common.c). But
 * the processor counts as idle from its wait instruction on, and the instructions before that are added to the clock a
 * little later: a main thread that happens to look in between sets the clock too far.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stddef.h>
#include <sys/time.h>
#include <unistd.h>

int gettimeofday(struct timeval *restrict tv, void *restrict zone)
{
	(void)zone;
	tv->tv_sec = 1767225600;
	tv->tv_usec = 0;
	return 0;
}

static int (*lock)(pthread_mutex_t *);
static int (*wait_for)(pthread_cond_t *, pthread_mutex_t *);
/* The emulator's big lock, under which idle changes; NULL until the emulated processor has waited first. */
static pthread_mutex_t *_Atomic big_lock;
static int idle;
static pthread_cond_t became_idle = PTHREAD_COND_INITIALIZER;

__attribute__((constructor)) static void find(void)
{
	lock = dlsym(RTLD_NEXT, "pthread_mutex_lock");
	wait_for = dlsym(RTLD_NEXT, "pthread_cond_wait");
}

static int in_main_thread(void)
{
	return gettid() == getpid();
}

/* Of the threads beside the main one only the emulated processor's waits without a time limit. */
int pthread_cond_wait(pthread_cond_t *condition, pthread_mutex_t *mutex)
{
	int status;

	if (in_main_thread())
		return wait_for(condition, mutex);
	big_lock = mutex;
	idle = 1;
	pthread_cond_broadcast(&became_idle);
	status = wait_for(condition, mutex);
	idle = 0;
	return status;
}

int pthread_mutex_lock(pthread_mutex_t *mutex)
{
	int status;

	if (!lock)
		find();
	status = lock(mutex);
	if (mutex == big_lock && in_main_thread())
		while (!idle)
			wait_for(&became_idle, mutex);
	return status;
}
