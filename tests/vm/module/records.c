// SPDX-License-Identifier: GPL-2.0-only
/* The last discharges, a line each, in the file "discharges". */
#include <linux/math64.h>
#include <linux/minmax.h>
#include <linux/seq_file.h>

#include "fixed.h"
#include "records.h"

#define RECORDS	65536

static struct record records[RECORDS];
static u64 count;
static raw_spinlock_t *lock;

struct record *records_new(void)
{
	return &records[count++ % RECORDS];
}

static void *seq_start(struct seq_file *s, loff_t *pos)
{
	if (count > RECORDS)
		*pos = max_t(loff_t, *pos, count - RECORDS);
	return *pos < count ? pos : NULL;
}

static void *seq_next(struct seq_file *s, void *v, loff_t *pos)
{
	++*pos;
	return seq_start(s, pos);
}

static void seq_stop(struct seq_file *s, void *v)
{
}

static int seq_show(struct seq_file *s, void *v)
{
	loff_t i = *(loff_t *)v;
	struct record r;

	scoped_guard(raw_spinlock_irqsave, lock)
		r = records[i % RECORDS];
	if (!i)
		seq_puts(s, "# seq first next along_ppb start release sink a b a_irq b_irq\n");
	seq_printf(s, "%lld %#lx %#lx %lld %llu %llu %llu %llu %llu %llu %llu\n", i + 1, r.first, r.next,
		   scaled(r.along, 1000000000), r.start, r.release, r.sink,
		   r.cross[0], r.cross[1], r.irq[0], r.irq[1]);
	return 0;
}

static const struct seq_operations records_sops = {
	.start = seq_start,
	.next = seq_next,
	.stop = seq_stop,
	.show = seq_show,
};
DEFINE_SEQ_ATTRIBUTE(records);

void records_start(struct dentry *folder, raw_spinlock_t *of_writer)
{
	count = 0;
	lock = of_writer;
	debugfs_create_file("discharges", 0444, folder, NULL, &records_fops);
}
