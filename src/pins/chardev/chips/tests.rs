use super::*;

#[test]
fn a_missing_chip_says_so_and_may_come_later() {
    let empty = tempfile::tempdir().unwrap();
    for wanted in ["pinctrl-rp1", "/nonexistent/gpiochip0"] {
        let error = find_in(empty.path(), wanted).unwrap_err();
        assert!(error.is_gone());
        assert!(error.to_string().contains(wanted) && error.to_string().contains("no GPIO chip"), "{error}");
    }
}

#[test]
fn a_chip_is_found_by_its_label_under_any_number() {
    let boot = |labels: &[(u32, &str)]| {
        let chips = labels.iter().map(|(number, label)| {
            let mut chip = Chip::of_lines(Vec::new());
            (chip.listing.name, chip.listing.label) = (format!("gpiochip{number}"), (*label).to_owned());
            chip
        });
        chips.collect::<Vec<_>>().into_iter()
    };
    let before = || boot(&[(0, "brcmvirt-gpio"), (4, "pinctrl-rp1"), (10, "expander")]);
    let after = || boot(&[(0, "pinctrl-rp1"), (1, "expander"), (4, "brcmvirt-gpio")]);
    let name = |chips, wanted| choose(chips, wanted).unwrap().map(|chip| chip.listing.name);
    assert_eq!(name(before(), "pinctrl-rp1").as_deref(), Some("gpiochip4"));
    assert_eq!(name(after(), "pinctrl-rp1").as_deref(), Some("gpiochip0"));
    assert_eq!(name(after(), "pinctrl"), None, "a part of a label is no label");
    // By a number it is whatever has the number now: why `cermctl check` warns of one.
    let label = |chips| choose(chips, "gpiochip4").unwrap().map(|chip| chip.listing.label);
    assert_eq!([label(before()), label(after())].map(Option::unwrap), ["pinctrl-rp1", "brcmvirt-gpio"]);
    let twins = choose(boot(&[(0, "expander"), (3, "expander")]), "expander").unwrap_err().to_string();
    assert!(twins.contains("gpiochip0, gpiochip3"), "{twins}");
}

#[test]
fn what_is_no_chip_is_refused_by_the_kernel_call() {
    let dev = tempfile::tempdir().unwrap();
    std::fs::write(dev.path().join("gpiochip0"), "").unwrap();
    std::os::unix::fs::symlink(dev.path().join("gpiochip0"), dev.path().join("gpiochip4")).unwrap();
    assert_eq!(all(dev.path()).len(), 1, "a link is not a second chip");
    let error = find_in(dev.path(), "pinctrl-rp1").unwrap_err();
    assert!(matches!(&error, ChardevError::Call { call: "GET_CHIPINFO", .. }), "{error}");
    assert!(error.to_string().contains("not a GPIO chip"), "{error}");
}

#[test]
fn another_device_is_not_opened() {
    let null = std::fs::metadata("/dev/null").unwrap();
    assert!(is_another_device(&null) || !Path::new("/sys/dev/char/1:3").exists());
    let dev = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/null", dev.path().join("link")).unwrap();
    for wanted in ["/dev/null", dev.path().join("link").to_str().unwrap()] {
        let error = find_in(dev.path(), wanted).unwrap_err().to_string();
        assert!(error.contains("not a GPIO chip"), "{error}");
    }
}

#[test]
fn the_kernels_words_for_a_line_are_kept() {
    let info = v2::LineInfo {
        name: "GPIO20".into(),
        consumer: "cermd".into(),
        offset: 20,
        flags: v2::LineFlags::USED | v2::LineFlags::OUTPUT | v2::LineFlags::OPEN_DRAIN,
        ..Default::default()
    };
    let line = LineListing::from(info);
    assert!(line.direction == "output" && line.used);
    assert_eq!(line.flags, ["open-drain"]);
}

#[test]
fn a_busy_line_names_its_holder() {
    let held = |consumer: Option<&str>| LineListing {
        offset: 4,
        name: consumer.map(|_| "GPIO20".to_owned()),
        consumer: consumer.map(str::to_owned),
        ..LineListing::default()
    };
    let refused = |errno| {
        let source = io::Error::from_raw_os_error(errno);
        ChardevError::call("GET_LINE", "sink-c1".to_owned(), source, Path::new("/nonexistent"))
    };
    let error = explain_busy(refused(libc::EBUSY), &[]);
    assert!(error.to_string().contains("cermctl lines"), "{error}");
    let held = [held(Some("gpioset")), held(None)];
    let error = explain_busy(refused(libc::EBUSY), &held);
    let holders = "held by another consumer: GPIO20 (\"gpioset\"), line 4 (\"unnamed\")";
    assert!(error.to_string().ends_with(holders), "{error}");
    assert!(error.is_busy() && error.is_held_by("gpioset") && !error.is_held_by("cermd"));
    assert!(error.is_held_by_others_than("cermd") && !error.is_held_by_others_than("gpioset"));
    assert!(!refused(libc::EBUSY).is_held_by_others_than("cermd"), "nobody knows who");
    assert!(!explain_busy(refused(libc::EIO), &held).is_held_by("gpioset"));
}

#[test]
fn a_line_without_an_interrupt_is_told_from_a_chip_that_is_gone() {
    let refused = |errno| {
        let source = io::Error::from_raw_os_error(errno);
        ChardevError::call("GET_LINE", "sense-b (GPIO6)".to_owned(), source, Path::new("/nonexistent"))
    };
    // ENXIO from Linux 6.3 on, ENODEV before.
    for errno in [libc::ENXIO, libc::ENODEV] {
        let error = no_interrupt(refused(errno), true, "sense-b (GPIO6) of gpiochip0 [pcf8574]");
        let text = error.to_string();
        assert!(text.starts_with("sense-b (GPIO6) of gpiochip0 [pcf8574] has no interrupt"), "{text}");
        assert!(!error.is_gone() && matches!(error, ChardevError::Wiring(_)));
        assert!(no_interrupt(refused(errno), false, "").is_gone());
    }
    assert!(no_interrupt(refused(libc::EBUSY), true, "").is_busy());
}

#[test]
fn flags_of_v1_are_those_of_v2() {
    let of_v2 = |flags| as_v2(v1::LineInfo { flags, ..Default::default() }).flags;
    for (v1, v2) in [
        (v1::LineInfoFlags::USED, v2::LineFlags::USED),
        (v1::LineInfoFlags::OUTPUT, v2::LineFlags::OUTPUT),
        (v1::LineInfoFlags::ACTIVE_LOW, v2::LineFlags::ACTIVE_LOW),
        (v1::LineInfoFlags::OPEN_DRAIN, v2::LineFlags::OPEN_DRAIN),
        (v1::LineInfoFlags::OPEN_SOURCE, v2::LineFlags::OPEN_SOURCE),
        (v1::LineInfoFlags::BIAS_PULL_UP, v2::LineFlags::BIAS_PULL_UP),
        (v1::LineInfoFlags::BIAS_PULL_DOWN, v2::LineFlags::BIAS_PULL_DOWN),
        (v1::LineInfoFlags::BIAS_DISABLED, v2::LineFlags::BIAS_DISABLED),
    ] {
        assert_eq!(of_v2(v1), v2);
    }
    assert!(v1::LineInfoFlags::all().iter_names().count() == 8, "each flag is in the table above");
}
