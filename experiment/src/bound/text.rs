//! A bound for people.

use super::{Bound, Delay};
use std::fmt::{Display, Formatter};

impl Display for Bound {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let ms = |seconds: f64| 1e3 * seconds;
        let Delay {
            detection_s,
            sensor_s,
            cycle_s,
            command_s,
        } = self.delay;
        writeln!(
            f,
            "a command acts {:.1} ms after the contact: detection {:.1}, sensor {:.1}, cycle {:.1}, command path {:.1} ms; \
             at most {:.2} m/s^2 along the normal\n",
            ms(self.delay.sum_s()),
            ms(detection_s),
            ms(sensor_s),
            ms(cycle_s),
            ms(command_s),
            self.acceleration_limit_m_per_s2
        )?;
        writeln!(f, "programme         peak N  set10 ms  set2 ms  IAE N s")?;
        for (name, figures) in [
            ("each for itself", &self.least),
            ("least IAE", &self.with_least_iae),
        ] {
            writeln!(
                f,
                "{name:16}  {:6.1}  {:8.0}  {:7.0}  {:7.3}",
                figures.peak_n,
                ms(figures.settling_10_s),
                ms(figures.settling_2_s),
                figures.iae_n_s
            )?;
        }
        writeln!(
            f,
            "\nwith the least IAE the contact force is at least {:.1} N once commands act",
            self.least_contact_n
        )
    }
}
