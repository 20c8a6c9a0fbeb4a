/* SPDX-License-Identifier: GPL-2.0-only */
/* The circuit behind the pins, as the controller sees it. Lines are numbered as on a Raspberry Pi header. */
#ifndef GPIO_CERMD_CIRCUIT_H
#define GPIO_CERMD_CIRCUIT_H

#include <linux/bits.h>
#include <linux/types.h>

#define LINES		28
#define SENSE_A		5
#define SENSE_B		6
#define SENSE_MASK	(BIT(SENSE_A) | BIT(SENSE_B))

/* Empty capacitors, all lines inputs. @fall is called in hard interrupt context when a sense line falls. */
void circuit_start(void (*fall)(unsigned int line));
void circuit_stop(void);

/* Changes the mask of lines that are outputs and the mask of their levels. */
void circuit_change(unsigned int line, bool output, bool high);
bool circuit_is_output(unsigned int line);
bool circuit_latch(unsigned int line);	/* the level that the line has or would have as an output */
bool circuit_level(unsigned int line);	/* the level at the pin */

#endif
