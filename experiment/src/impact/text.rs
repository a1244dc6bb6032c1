//! The answer for people: a table and what it means.

use super::report::{Limit, Report};
use std::fmt::{Display, Formatter, Result};

/// Reports side by side, and a few sentences on each.
#[derive(Clone, Copy, Debug)]
pub struct Text<'a>(pub &'a [Report]);

/// A line of the table: what, factor from the SI unit to the one that is named, and where to find it.
type Line = (&'static str, f64, fn(&Report) -> Option<f64>);

const LINES: [Line; 29] = [
    ("exponent n", 1.0, |r| Some(r.exponent)),
    ("indentation coefficient c_in, N/m^n", 1.0, |r| {
        Some(r.indentation_n_per_m)
    }),
    ("rebound ratio c_re / c_in", 1.0, |r| Some(r.rebound_ratio)),
    ("effective modulus E*, GPa", 1e-9, |r| r.effective_modulus_pa),
    ("effective mass, kg", 1.0, |r| Some(r.effective_mass_kg)),
    ("speed, mm/s", 1e3, |r| Some(r.speed_m_per_s)),
    ("peak force, N", 1.0, |r| Some(r.peak_force_n)),
    ("maximum depth, um", 1e6, |r| Some(r.maximum_depth_m)),
    ("remaining depth, um", 1e6, |r| Some(r.remaining_depth_m)),
    ("indentation time, ms", 1e3, |r| Some(r.indentation_time_s)),
    ("rebound time, ms", 1e3, |r| Some(r.rebound_time_s)),
    ("characteristic impact time, ms", 1e3, |r| {
        Some(r.characteristic_time_s)
    }),
    ("restitution", 1.0, |r| Some(r.restitution)),
    ("impulse, N s", 1.0, |r| Some(r.impulse_ns)),
    ("lost energy, mJ", 1e3, |r| Some(r.lost_energy_j)),
    ("sampling time, ms", 1e3, |r| Some(r.sampling_time_s)),
    ("peak of the controlled force, N", 1.0, |r| r.controlled_peak_n),
    ("allowed force, N", 1.0, |r| r.allowed_force_n),
    ("  highest speed for it, mm/s", 1e3, |r| {
        r.speed_for_allowed_force_m_per_s
    }),
    ("allowed remaining depth, um", 1e6, |r| {
        r.allowed_remaining_depth_m
    }),
    ("  highest speed for it, mm/s", 1e3, |r| {
        r.speed_for_allowed_remaining_depth_m_per_s
    }),
    ("simulated: speed at contact, mm/s", 1e3, |r| {
        Some(r.simulated?.contact_speed_m_per_s)
    }),
    ("  peak force, N", 1.0, |r| Some(r.simulated?.peak_force_n)),
    ("  predicted for that speed, N", 1.0, |r| {
        Some(r.simulated?.predicted_peak_n)
    }),
    ("  deviation, %", 1e2, |r| Some(r.simulated?.deviation())),
    ("controller: approach speed, mm/s", 1e3, |r| {
        Some(r.simulated?.controller?.approach_speed_m_per_s)
    }),
    ("  speed measured at contact, mm/s", 1e3, |r| {
        Some(r.simulated?.controller?.contact_speed_m_per_s)
    }),
    ("  peak force for that speed, N", 1.0, |r| {
        Some(r.simulated?.controller?.peak_force_n)
    }),
    ("  deviation from the simulated peak, %", 1e2, |r| {
        let simulated = r.simulated?;
        Some(simulated.controller?.peak_force_n / simulated.peak_force_n - 1.0)
    }),
];

impl Display for Text<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let lines: Vec<(&str, Vec<String>)> = LINES
            .iter()
            .map(|(name, factor, of)| {
                let cell = |report| of(report).map_or(String::new(), |value| digits(factor * value));
                (*name, self.0.iter().map(cell).collect::<Vec<_>>())
            })
            .filter(|(_, cells)| cells.iter().any(|cell| !cell.is_empty()))
            .collect();
        let first = lines.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        let names: Vec<&str> = self.0.iter().map(|report| report.name.as_str()).collect();
        let width = |column: usize| {
            let cells = lines.iter().map(|(_, cells)| cells[column].len());
            cells.chain([names[column].chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.0.len()).map(width).collect();
        let line = |f: &mut Formatter<'_>, name: &str, cells: &[&str]| {
            let mut text = format!("{name:first$}");
            for (cell, width) in cells.iter().zip(&widths) {
                text += &format!("  {cell:>width$}");
            }
            writeln!(f, "{}", text.trim_end())
        };
        line(f, "", &names)?;
        for (name, cells) in &lines {
            line(f, name, &cells.iter().map(String::as_str).collect::<Vec<_>>())?;
        }
        self.0
            .iter()
            .try_for_each(|report| sentences(f, report, self.0.len() > 1))
    }
}

/// What it means.
fn sentences(f: &mut Formatter<'_>, report: &Report, named: bool) -> Result {
    writeln!(f)?;
    if named {
        writeln!(f, "{}", report.name)?;
    }
    let samples = report.characteristic_time_s / report.sampling_time_s;
    if report.controllable {
        writeln!(
            f,
            "The impact lasts {} sampling times: control can act on it before it is over, if it is as fast as that.",
            digits(samples)
        )?;
    } else {
        writeln!(
            f,
            "The impact is over within {} of a sampling time: no controller of this sampling time can change it. Only \
             its\ncauses can be chosen: speed, mass, shape and material.",
            digits(samples)
        )?;
    }
    match (report.limit, report.controlled_peak_n) {
        (Some(Limit::Impact), Some(peak)) => writeln!(
            f,
            "The impact is the limit: its {} N are {} times the {} N of the controlled force's peak.",
            digits(report.compared_peak_n()),
            digits(report.compared_peak_n() / peak),
            digits(peak)
        )?,
        (Some(Limit::Control), Some(peak)) => writeln!(
            f,
            "Control is the limit: the {} N of the controlled force's peak exceed the impact's {} N.",
            digits(peak),
            digits(report.compared_peak_n())
        )?,
        _ => {}
    }
    let allowed = [
        report.speed_for_allowed_force_m_per_s,
        report.speed_for_allowed_remaining_depth_m_per_s,
    ];
    if let Some(limit) = allowed.into_iter().flatten().reduce(f64::min) {
        let verdict = if report.speed_m_per_s <= limit {
            "is allowed"
        } else {
            "is too fast"
        };
        writeln!(
            f,
            "Approach at {} mm/s at most: the {} mm/s asked for {verdict}.",
            digits(1e3 * limit),
            digits(1e3 * report.speed_m_per_s)
        )?;
    }
    if report.second_impact_speed_ratio > 1.0 {
        writeln!(
            f,
            "Off so elastic an object, a tool on a compliant sensor comes back up to {} times as fast as it came while the \
             robot\nmoves on: the second impact is the harder one.",
            digits(report.second_impact_speed_ratio)
        )?;
    }
    if report
        .simulated
        .and_then(|simulated| simulated.controller)
        .is_some_and(|controller| controller.slowed)
    {
        writeln!(
            f,
            "The controller has slowed the approach: task.max_impact_force_n binds."
        )?;
    }
    let Some(contact) = &report.transient_contact else {
        return Ok(());
    };
    writeln!(
        f,
        "\nTransient contact with a person: {}.\n  {} kg of robot and {} kg of body, reduced mass {} kg, on {} N/mm: \
         {} N at {} mm/s",
        contact.notice,
        digits(contact.robot_mass_kg),
        digits(contact.body_mass_kg),
        digits(contact.reduced_mass_kg),
        digits(1e-3 * contact.body_stiffness_n_per_m),
        digits(contact.force_n),
        digits(1e3 * report.speed_m_per_s)
    )?;
    match (contact.allowed_force_n, contact.speed_for_allowed_force_m_per_s) {
        (Some(force), Some(speed)) => {
            writeln!(
                f,
                "  {} N at v = F / sqrt(mu k) = {} mm/s",
                digits(force),
                digits(1e3 * speed)
            )
        }
        _ => Ok(()),
    }
}

/// Four significant digits; a power of ten from a million on and below a thousandth.
pub(super) fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{rounded:.3e}");
    }
    let decimals = (3.0 - libm::floor(libm::log10(size))).max(0.0) as usize;
    format!("{rounded:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_are_shown() {
        for (value, text) in [
            (0.7024814731, "0.7025"),
            (8944.2719, "8944"),
            (160.0, "160.0"),
            (1.23456, "1.235"),
            (0.0, "0"),
            (2e9, "2.000e9"),
            (-0.0123456, "-0.01235"),
            (99999.9, "100000"),
            (9.9996, "10.00"),
        ] {
            assert_eq!(digits(value), text);
        }
    }
}
