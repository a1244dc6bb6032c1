//! What a page is made of: figures, tables, and where they come from.

use super::{Origin, Panel};
use crate::compare::Failure;
use crate::table::{FIGURES, Figure, MORE, Row, fixed};
use crate::tuning::Gains;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// How every page looks, on paper, too.
const STYLE: &str = include_str!("style.css");

/// A page that needs nothing beside itself.
pub(crate) fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}

/// A figure inside the page; `label` is for those who can't see it.
pub(crate) fn drawing(svg: &str, label: &str) -> Markup {
    // Inside HTML the name space is known, and what is shown has a name of its own.
    let svg = svg.replacen(r#" xmlns="http://www.w3.org/2000/svg""#, "", 1);
    let label = html! { (label) }.into_string();
    PreEscaped(svg.replacen("<svg ", &format!(r#"<svg role="img" aria-label="{label}" "#), 1))
}

/// The command, the configuration's hash and the seeds.
pub(super) fn origin(origin: &Origin) -> Markup {
    html! {
        p.origin {
            code.command { (origin.command) }
            " " span { "configuration " code.hash { (origin.configuration_hash) } ", " (origin.seeds_text()) }
        }
    }
}

/// A text in which what stands between backticks is code.
pub(super) fn prose(text: &str) -> Markup {
    html! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

/// A box of its own for what is wider than a phone.
pub(crate) fn wide(label: &str, content: &Markup) -> Markup {
    html! { div.wide tabindex="0" role="region" aria-label=(label) { (content) } }
}

/// The laws of a section: first what is judged most, then the rest behind a button.
pub(super) fn laws_table(name: &str, rows: &[Row], law: &str) -> Markup {
    html! {
        (wide(&format!("{name}: figures of each law"), &figures_table(rows, &FIGURES, law)))
        details {
            summary { "Nine more figures" }
            (wide(&format!("{name}: more figures of each law"), &figures_table(rows, &MORE, law)))
        }
    }
}

fn figures_table(rows: &[Row], figures: &[Figure], law: &str) -> Markup {
    let gains = rows.iter().any(|row| row.gains != Gains::Default);
    html! {
        table.sortable {
            thead { tr {
                th scope="col" { "law" }
                @if gains { th scope="col" { "gains" } }
                @for (header, ..) in figures { th.number scope="col" { (header) } }
            } }
            tbody {
                @for row in rows {
                    tr.own[row.law == law] {
                        th scope="row" data-v=(row.law) { (row.law) }
                        @if gains { td data-v=(row.gains.word()) { (row.gains.word()) } }
                        @for figure in figures { (figure_cell(row, figure)) }
                    }
                }
            }
        }
    }
}

/// Mean with its confidence, and below it the worst. The attributes have all digits, as the commands' JSON has them.
fn figure_cell(row: &Row, (_, factor, decimals, value): &Figure) -> Markup {
    let text = |value: f64| fixed(value * factor, *decimals).replace('-', "\u{2212}");
    let (mean, worst, half) = (value(&row.mean), value(&row.worst), value(&row.confidence));
    html! {
        td.number data-v=(format!("{mean:?}")) data-worst=(format!("{worst:?}")) data-ci=(format!("{half:?}")) {
            @if mean.is_nan() { span.never { "never" } } @else {
                (text(mean))
                @if !half.is_nan() { span.half { " \u{b1}\u{2009}" (text(half)) } }
            }
            @if row.runs > 1 && !mean.is_nan() { small { "worst " (text(worst)) } }
        }
    }
}

/// Runs without figures, law by law.
pub(super) fn failures(failures: &[Failure]) -> Markup {
    let mut told: Vec<(&str, Gains, usize, &str)> = Vec::new();
    for failure in failures {
        match told
            .iter_mut()
            .find(|(law, gains, ..)| *law == failure.law && *gains == failure.gains)
        {
            Some((.., count, _)) => *count += 1,
            None => told.push((&failure.law, failure.gains, 1, &failure.reason)),
        }
    }
    html! {
        @for (law, gains, count, reason) in told {
            p.failure { b { (law) } ", " (gains.word()) " gains: " (count) " runs without figures, the first one: " (reason) }
        }
    }
}

/// Panels side by side where there is room.
pub(super) fn panels(scenario: &str, panels: &[Panel]) -> Markup {
    html! {
        div.panels {
            @for panel in panels {
                figure {
                    @match &panel.svg {
                        Ok(svg) => {
                            (drawing(svg, &format!("contact force over time: law {}, scenario {scenario}", panel.law)))
                        }
                        Err(reason) => { p.failure { b { (panel.law) } ": no force to show: " (reason) } }
                    }
                    figcaption { (origin(&panel.origin)) }
                }
            }
        }
    }
}

/// What the lines of a panel mean.
pub(crate) fn panel_legend() -> Markup {
    html! {
        p.legend {
            span { i.line.truth {} "true force" }
            span { i.line.measured {} "as the controller sees it" }
            span { i.line.desired {} "desired force" }
            span { i.band {} "\u{b1}10 %" }
        }
    }
}

/// What the marks of a ranking mean.
pub(super) fn ranking_legend() -> Markup {
    html! {
        p.legend {
            span { i.mark.default {} "default gains (of peers: as published)" }
            span { i.mark.tuned {} "tuned" }
            span { "thick: 95 % confidence of the mean; thin: to the worst run" }
        }
    }
}
