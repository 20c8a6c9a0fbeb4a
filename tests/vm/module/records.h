/* SPDX-License-Identifier: GPL-2.0-only */
/* The last discharges, in debugfs. */
#ifndef GPIO_CERMD_RECORDS_H
#define GPIO_CERMD_RECORDS_H

#include <linux/debugfs.h>
#include <linux/spinlock.h>
#include <linux/types.h>

/* One discharge; instants in ns, 0: has not happened. */
struct record {
	unsigned long first, next;	/* lines that sank at the start; that were added later */
	s64 along;			/* left by the charge before it, see charge.h */
	u64 start, release, sink;	/* a first line sank; was released; a next one sank */
	u64 cross[2], irq[2];		/* nodes A and B: the law's crossing; the interrupt was raised */
};

/* Forgets all. @lock: held by who writes. */
void records_start(struct dentry *folder, raw_spinlock_t *lock);
struct record *records_new(void);

#endif
