// SPDX-License-Identifier: GPL-2.0-only
/*
 * gpio-cermd: a GPIO controller with a measuring circuit on its pins. For tests only.
 *
 * The lines have the names and numbers of a Raspberry Pi header, the chip's label is "cermd-rc". What the pins are
 * wired to is in circuit.c. Lines can be inputs and outputs without bias; open drain and open source are left to
 * gpiolib, as most controllers do. The two sense lines raise interrupts on falling edges.
 */
#include <linux/bitops.h>
#include <linux/gpio/driver.h>
#include <linux/interrupt.h>
#include <linux/irq.h>
#include <linux/irqdomain.h>
#include <linux/module.h>
#include <linux/pinctrl/pinconf-generic.h>
#include <linux/platform_device.h>
#include <linux/version.h>

#include "circuit.h"

static struct gpio_chip chip;
static unsigned long armed;	/* mask of lines whose interrupt is not masked */

static int gpio_cermd_get_direction(struct gpio_chip *gc, unsigned int line)
{
	return circuit_is_output(line) ? GPIO_LINE_DIRECTION_OUT : GPIO_LINE_DIRECTION_IN;
}

static int gpio_cermd_direction_input(struct gpio_chip *gc, unsigned int line)
{
	circuit_change(line, false, circuit_latch(line));
	return 0;
}

static int gpio_cermd_direction_output(struct gpio_chip *gc, unsigned int line, int value)
{
	circuit_change(line, true, value);
	return 0;
}

static int gpio_cermd_get(struct gpio_chip *gc, unsigned int line)
{
	return circuit_level(line);
}

#if LINUX_VERSION_CODE >= KERNEL_VERSION(6, 17, 0)
static int gpio_cermd_set(struct gpio_chip *gc, unsigned int line, int value)
{
	circuit_change(line, circuit_is_output(line), value);
	return 0;
}
#else
static void gpio_cermd_set(struct gpio_chip *gc, unsigned int line, int value)
{
	circuit_change(line, circuit_is_output(line), value);
}
#endif

static int gpio_cermd_set_config(struct gpio_chip *gc, unsigned int line, unsigned long config)
{
	return pinconf_to_config_param(config) == PIN_CONFIG_BIAS_DISABLE ? 0 : -ENOTSUPP;
}

static void gpio_cermd_fall(unsigned int line)
{
	if (test_bit(line, &armed))
		generic_handle_domain_irq(chip.irq.domain, line);
}

static void gpio_cermd_irq_mask(struct irq_data *d)
{
	clear_bit(irqd_to_hwirq(d), &armed);
	gpiochip_disable_irq(&chip, irqd_to_hwirq(d));
}

static void gpio_cermd_irq_unmask(struct irq_data *d)
{
	gpiochip_enable_irq(&chip, irqd_to_hwirq(d));
	set_bit(irqd_to_hwirq(d), &armed);
}

static int gpio_cermd_irq_set_type(struct irq_data *d, unsigned int type)
{
	return BIT(irqd_to_hwirq(d)) & SENSE_MASK && type == IRQ_TYPE_EDGE_FALLING ? 0 : -EINVAL;
}

static const struct irq_chip gpio_cermd_irq_chip = {
	.name = "gpio-cermd",
	.irq_mask = gpio_cermd_irq_mask,
	.irq_unmask = gpio_cermd_irq_unmask,
	.irq_set_type = gpio_cermd_irq_set_type,
	.flags = IRQCHIP_IMMUTABLE,
	GPIOCHIP_IRQ_RESOURCE_HELPERS,
};

static const char *const names[LINES] = {
	"ID_SDA", "ID_SCL", "GPIO2", "GPIO3", "GPIO4", "GPIO5", "GPIO6", "GPIO7", "GPIO8", "GPIO9",
	"GPIO10", "GPIO11", "GPIO12", "GPIO13", "GPIO14", "GPIO15", "GPIO16", "GPIO17", "GPIO18", "GPIO19",
	"GPIO20", "GPIO21", "GPIO22", "GPIO23", "GPIO24", "GPIO25", "GPIO26", "GPIO27",
};

static void gpio_cermd_stop(void *unused)
{
	circuit_stop();
}

static int gpio_cermd_probe(struct platform_device *pdev)
{
	int err;

	armed = 0;
	chip = (struct gpio_chip){
		.label = "cermd-rc", .owner = THIS_MODULE, .parent = &pdev->dev,
		.base = -1, .ngpio = LINES, .names = names,
		.get_direction = gpio_cermd_get_direction, .direction_input = gpio_cermd_direction_input,
		.direction_output = gpio_cermd_direction_output, .get = gpio_cermd_get, .set = gpio_cermd_set,
		.set_config = gpio_cermd_set_config,
	};
	gpio_irq_chip_set_chip(&chip.irq, &gpio_cermd_irq_chip);
	chip.irq.handler = handle_simple_irq;
	chip.irq.default_type = IRQ_TYPE_NONE;
	circuit_start(gpio_cermd_fall);
	err = devm_add_action_or_reset(&pdev->dev, gpio_cermd_stop, NULL);
	return err ?: devm_gpiochip_add_data(&pdev->dev, &chip, NULL);
}

static struct platform_driver gpio_cermd_driver = {
	.driver.name = "gpio-cermd",
	.probe = gpio_cermd_probe,
};
static struct platform_device *gpio_cermd_device;

static int __init gpio_cermd_init(void)
{
	int err = platform_driver_register(&gpio_cermd_driver);

	if (err)
		return err;
	gpio_cermd_device = platform_device_register_simple("gpio-cermd", PLATFORM_DEVID_NONE, NULL, 0);
	if (IS_ERR(gpio_cermd_device))
		platform_driver_unregister(&gpio_cermd_driver);
	return PTR_ERR_OR_ZERO(gpio_cermd_device);
}
module_init(gpio_cermd_init);

static void __exit gpio_cermd_exit(void)
{
	platform_device_unregister(gpio_cermd_device);
	platform_driver_unregister(&gpio_cermd_driver);
}
module_exit(gpio_cermd_exit);

MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("GPIO controller with a two-capacitor measuring circuit on its pins (tests only)");
