//! Wall-clock time as text.
//!
//! For: RFC 3339 in UTC with nanoseconds. Must not know: which clock it was read from.

use std::fmt;

const NANOS_PER_SECOND: i64 = 1_000_000_000;
const SECONDS_PER_DAY: i64 = 86_400;

/// Nanoseconds since 1970-01-01T00:00:00Z, leap seconds not counted (`CLOCK_REALTIME`).
///
/// Displays as RFC 3339, always with nine digits of fraction: `2026-11-21T03:40:00.123456789Z`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UnixTime(pub i64);

impl fmt::Display for UnixTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.div_euclid(NANOS_PER_SECOND);
        let nanos = self.0.rem_euclid(NANOS_PER_SECOND);
        let (year, month, day) = civil_from_days(seconds.div_euclid(SECONDS_PER_DAY));
        let second_of_day = seconds.rem_euclid(SECONDS_PER_DAY);
        let (hour, minute, second) = (second_of_day / 3600, second_of_day / 60 % 60, second_of_day % 60);
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{nanos:09}Z")
    }
}

/// Days since 1970-01-01 to (year, month, day) of the Gregorian calendar.
///
/// H. Hinnant, "chrono-compatible low-level date algorithms": counts in eras of 400 years (146 097 days) that
/// begin on 1 March, so that the leap day is the last of its year and months have a linear length.
fn civil_from_days(days: i64) -> (i64, i64, i64) {
    const DAYS_PER_ERA: i64 = 146_097;
    const DAYS_FROM_0000_03_01: i64 = 719_468;
    let days = days + DAYS_FROM_0000_03_01;
    let era = days.div_euclid(DAYS_PER_ERA);
    let day_of_era = days.rem_euclid(DAYS_PER_ERA);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + i64::from(month <= 2);
    (year, month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants() {
        // From `date -u -d @SECONDS +%FT%TZ`.
        let known = [
            (0, "1970-01-01T00:00:00"),
            (-1, "1969-12-31T23:59:59"),
            (951_782_399, "2000-02-28T23:59:59"),
            (951_782_400, "2000-02-29T00:00:00"),
            (951_868_800, "2000-03-01T00:00:00"),
            (1_709_164_800, "2024-02-29T00:00:00"),
            (1_735_689_599, "2024-12-31T23:59:59"),
            (1_795_232_400, "2026-11-21T03:40:00"),
            (4_107_542_400, "2100-03-01T00:00:00"), // 2100 is no leap year
            (4_107_456_000, "2100-02-28T00:00:00"),
            (-2_203_891_200, "1900-03-01T00:00:00"), // nor was 1900
            (-2_203_977_600, "1900-02-28T00:00:00"),
        ];
        for (seconds, text) in known {
            assert_eq!(UnixTime(seconds * NANOS_PER_SECOND).to_string(), format!("{text}.000000000Z"));
        }
    }

    #[test]
    fn fraction_counts_forward_also_before_1970() {
        assert_eq!(UnixTime(1_795_232_400_123_456_789).to_string(), "2026-11-21T03:40:00.123456789Z");
        assert_eq!(UnixTime(-1).to_string(), "1969-12-31T23:59:59.999999999Z");
    }

    #[test]
    fn days_follow_each_other_through_800_years() {
        let month_lengths = |year: i64| {
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
        };
        let mut days = -135_140; // 1600-01-01
        for year in 1600..2400 {
            for (month, length) in (1..).zip(month_lengths(year)) {
                for day in 1..=length {
                    assert_eq!(civil_from_days(days), (year, month, day));
                    days += 1;
                }
            }
        }
    }
}
