//! An analysis as one HTML file that needs nothing but a browser, and prints on A4.

use super::text::{NO_FORCE, gaps};
use super::{Analysis, Health, source};
use crate::report::parts::{drawing, page, wide};
use crate::table::{FIGURES, MORE, fixed};
use maud::{Markup, html};
use node::scenario::Scenario;
use spatial::ports::ImpactAssessment;
use std::path::Path;

/// Where an analysis comes from.
#[derive(Clone, Debug)]
pub struct Headline<'a> {
    /// Name of the scenario, or its path.
    pub scenario: &'a str,
    /// Name of the log.
    pub log: String,
    /// What is wrong with the log, one line each.
    pub complaints: Vec<String>,
}

impl Analysis {
    /// The page of a log of `scenario`.
    pub fn html(&self, scenario: &Scenario, headline: &Headline<'_>) -> String {
        let law = crate::tuning::law_word(scenario.controller.law);
        let name = Path::new(headline.scenario).file_stem().unwrap_or_default();
        let title = format!("Run of {}, law {law}", name.to_string_lossy());
        let body = html! {
            (self.header(scenario, headline, &title))
            main {
                (self.drawings(scenario))
                h2 { "Impact" }
                (self.impact_table())
                h2 { "Timing" }
                (self.timing_table())
                h2 { "Channels" }
                (self.channel_table())
                h2 { "Configuration" }
                (configuration(scenario))
                footer { "Touchdown " (env!("CARGO_PKG_VERSION")) }
            }
        };
        page(&title, &body)
    }

    fn header(&self, scenario: &Scenario, headline: &Headline<'_>, title: &str) -> Markup {
        html! {
            header { div {
                h1 { (title) }
                p { "Scenario " code { (headline.scenario) } ", log " code { (headline.log) } ", configuration " code { (format!("{:016x}", scenario.hash())) }
                    ", seed " (scenario.timing.seed) "."
                    @if let Some((.., from)) = &self.recording { " Force: " (source(*from)) "." }
                }
                @for complaint in &headline.complaints { p.failure { (complaint) } }
                @match self.metrics() {
                    Some(Ok(metrics)) => {
                        @for figures in [&FIGURES[..], &MORE[..]] {
                            (wide("figures", &html! {
                                table {
                                    thead { tr { @for (name, ..) in figures { th.number scope="col" { (name) } } } }
                                    tbody { tr { @for (_, factor, decimals, value) in figures {
                                        td.number { (number(value(&metrics) * factor, *decimals)) }
                                    } } }
                                }
                            }))
                        }
                    }
                    Some(Err(reason)) => { p.failure { "No figures: " (reason) } }
                    None => { p.failure { "No figures: " (NO_FORCE) } }
                }
            } }
        }
    }

    fn drawings(&self, scenario: &Scenario) -> Markup {
        html! {
            @for figure in self.figures(scenario) {
                figure {
                    h3 { (figure.title) }
                    (drawing(&figure.svg, figure.title))
                }
            }
        }
    }

    fn impact_table(&self) -> Markup {
        let cells = |it: Option<ImpactAssessment>| {
            let it = it.filter(|it| it.effective_mass_kg > 0.0);
            it.map(|it| [it.speed_m_per_s, it.peak_force_n, it.maximum_depth_m])
        };
        let rows = [
            ("foreseen just before the contact", cells(self.impact.foreseen)),
            (
                "of the speed measured at the contact",
                cells(self.impact.measured),
            ),
            ("true", self.impact.truth),
        ];
        html! {
            (wide("impact", &html! {
                table {
                    thead { tr {
                        th scope="col" { "impact" } th.number scope="col" { "speed mm/s" }
                        th.number scope="col" { "peak N" } th.number scope="col" { "depth um" }
                    } }
                    tbody {
                        @for (name, row) in &rows {
                            @if let Some([speed, peak, depth]) = row {
                                tr {
                                    th scope="row" { (name) } td.number { (number(1e3 * speed, 2)) }
                                    td.number { (number(*peak, 1)) } td.number { (number(1e6 * depth, 2)) }
                                }
                            }
                        }
                    }
                }
            }))
        }
    }

    fn timing_table(&self) -> Markup {
        let ms = |times: &[f64; 4]| {
            times
                .iter()
                .map(|time| number(1e3 * time, 2))
                .collect::<Vec<_>>()
                .join(" / ")
        };
        let rows = |health: &Health| {
            [
                ms(&health.answer_s),
                ms(&health.lateness_s),
                ms(&health.round_trip_s),
                health.missed.to_string(),
                health.lost.to_string(),
                health.dropped.to_string(),
            ]
        };
        html! {
            p { "Times: median / 99 % / 99.9 % / most, ms of the wall clock, as the nodes have said last." }
            (wide("timing", &html! {
                table {
                    thead { tr {
                        th scope="col" { "node" }
                        @for name in ["answer ms", "lateness ms", "round trip ms", "missed", "lost", "dropped"] {
                            th.number scope="col" { (name) }
                        }
                    } }
                    tbody { @for health in &self.timing.nodes {
                        tr { th scope="row" { (health.node) } @for cell in rows(health) { td.number { (cell) } } }
                    } }
                }
            }))
            @if let Some(missed) = self.timing.missed_commands { p { "Cycles without a new command: " (missed) "." } }
            @for clock in &self.clocks {
                p { "Clock of " (clock.device) ": " (number(1e3 * clock.ahead_s, 3)) " ms ahead of the controller's, told by the "
                    (clock.told_by) @if let Some(bound) = clock.bound_s { ", within " (number(1e3 * bound, 3)) " ms" } "." }
            }
        }
    }

    fn channel_table(&self) -> Markup {
        html! {
            (wide("channels", &html! {
                table {
                    thead { tr {
                        th scope="col" { "channel" }
                        @for name in ["messages", "repeated", "senders", "every (steps)", "missing"] {
                            th.number scope="col" { (name) }
                        }
                    } }
                    tbody { @for it in &self.channels {
                        tr {
                            th scope="row" { (it.channel) } td.number { (it.messages) } td.number { (it.repeated) }
                            td.number { (it.senders) } td.number { (it.period_steps) } td.number { (it.missing) }
                        }
                    } }
                }
            }))
            @for channel in self.channels.iter().filter(|it| it.missing > 0) { p { (gaps(channel)) } }
        }
    }
}

/// The keys that are not at their defaults, then all.
fn configuration(scenario: &Scenario) -> Markup {
    let (all, default) = (scenario.to_toml(), Scenario::default().to_toml());
    let mut changed = Vec::new();
    let mut section = "";
    let mut pairs = default.lines();
    for line in all.lines() {
        if line.starts_with('[') {
            section = line;
        }
        if pairs.next() != Some(line) && line.contains(" = ") {
            changed.push(format!("{section} {line}"));
        }
    }
    html! {
        p { "Other than the default:" @if changed.is_empty() { " nothing." } }
        @if !changed.is_empty() { pre.keys { (changed.join("\n")) } }
        p { "All values:" }
        pre.keys { (all) }
    }
}

fn number(value: f64, decimals: usize) -> String {
    match value.is_nan() {
        true => "-".to_owned(),
        false => fixed(value, decimals).replace('-', "\u{2212}"),
    }
}
