//! The page.

use super::origin::quoted;
use super::parts::{
    drawing, failures, laws_table, origin, page, panel_legend, panels, prose, ranking_legend, wide,
};
use super::{Loss, Options, Report, Section, losses, ranking};
use crate::figure::FigureError;
use crate::sweep::{Cell, verdicts};
use crate::table::{FIGURES, Figure, Row, fixed};
use crate::tuning::Gains;
use maud::{Markup, PreEscaped, html};

const SORT: &str = include_str!("sort.js");
/// What the rankings show, and what they are called.
const RANKED: [(&str, &str); 2] = [("IAE N s", "force error, IAE, N s"), ("peak N", "peak force, N")];

impl Report {
    /// The whole file.
    pub fn html(&self) -> Result<String, FigureError> {
        let (shoot_outs, others): (Vec<_>, Vec<_>) =
            self.sections.iter().partition(|section| section.shoot_out);
        let body = html! {
            (self.head(&shoot_outs))
            main {
                (how_to_read())
                @for section in &shoot_outs { (shoot_out(section)?) }
                @if !others.is_empty() {
                    h2 id="scenarios" { "Scenarios" }
                    p { "The law that each scenario is made for (shaded) beside the proposed one and the standard "
                        "pd law of eq. (1), with the scenario's own gains." }
                    (panel_legend())
                    @for section in &others { (scenario(section)) }
                }
                (self.maps())
                (self.losses())
                (self.again())
            }
            script { (PreEscaped(SORT)) }
        };
        Ok(page("Touchdown: force control laws side by side", &body))
    }

    fn head(&self, shoot_outs: &[&Section]) -> Markup {
        let tiles: Vec<_> = shoot_outs.iter().filter_map(|section| tile(section)).collect();
        html! {
            header { div {
                h1 { "How hard does it press, and how soon is it right?" }
                p.lead {
                    "A position-controlled robot meets an object that it did not expect there, and is to press with a stated "
                    "force. Touchdown takes the compliant sensor for what it is, a measurement of where the object "
                    "is, and this page holds that against other laws in " (thousands(self.runs)) " simulated experiments."
                }
                @if !tiles.is_empty() { div.tiles { @for tile in &tiles { (tile) } } }
                nav aria-label="Contents" { ul {
                    li { a href="#read" { "How to read this" } }
                    @for section in shoot_outs {
                        li { a href=(format!("#{}", anchor(&section.scenario))) { "Laws on a " (plant(section)) } }
                    }
                    @if self.sections.len() > shoot_outs.len() { li { a href="#scenarios" { "Scenarios" } } }
                    li { a href="#maps" { "Maps" } }
                    li { a href="#losses" { "Where it loses" } }
                    li { a href="#again" { "Make it again" } }
                } }
            } }
        }
    }

    fn maps(&self) -> Markup {
        let maps = &self.maps;
        let definition = &maps.plan.definition;
        let verdicts = verdicts(&maps.plan, &maps.cells);
        let count = |value: Option<usize>| value.map_or_else(|| "-".to_owned(), |value| value.to_string());
        html! {
            h2 id="maps" { "How far it reaches: maps" }
            p { "Each square is one plant. Bright: little force error. A cross: unstable. The orange line is not drawn from "
                "these runs: it is where the loop's own transfer function says that stability ends." }
            @for (map, svg) in definition.maps.iter().zip(&maps.figures) {
                figure {
                    (wide(&map.title, &drawing(svg, &map.title)))
                    figcaption { (origin(&maps.origin)) }
                }
            }
            h3 { "The maps in numbers" }
            (wide("the maps in numbers", &html! {
                table.sortable {
                    thead { tr {
                        th scope="col" { "map" } th scope="col" { "law" }
                        @for header in ["cells", "comes to rest", "stable", "least error of all", "theory agrees",
                            "else at its border", "theory too hopeful"] {
                            th.number scope="col" { (header) }
                        }
                    } }
                    tbody {
                        @for ((map, law), verdict) in self.cells().zip(&verdicts) {
                            tr {
                                th scope="row" { (verdict.map) } td { (verdict.law) }
                                td.number { (verdict.cells) } td.number { (verdict.settled_cells) }
                                td.number { (verdict.stable_cells) } td.number { (best_cells(map, law)) }
                                td.number { (count(verdict.agreeing_cells)) }
                                td.number { (count(verdict.near_border_cells)) }
                                td.number { (count(verdict.too_hopeful_cells)) }
                            }
                        }
                    }
                }
            }))
            (origin(&maps.origin))
        }
    }

    /// Each law of each map, beside the map.
    fn cells(&self) -> impl Iterator<Item = (&Vec<Vec<Vec<Cell>>>, usize)> {
        let maps = self.maps.cells.maps.iter();
        maps.flat_map(|map| (0..map.len()).map(move |law| (map, law)))
    }

    fn losses(&self) -> Markup {
        let all: Vec<(&Section, Loss<'_>)> = self
            .sections
            .iter()
            .flat_map(|section| losses(section).into_iter().map(move |loss| (section, loss)))
            .collect();
        let compared: usize = self
            .sections
            .iter()
            .map(|section| section.comparison.rows.len())
            .sum();
        html! {
            h2 id="losses" { "Where it loses" }
            p { "Every figure in which another law is better than the one that the scenario is made for, by more than both "
                "confidence intervals together, with the same kind of gains. Taken from the " (compared)
                " rows above by rule, none left out. What the maps say of that: \u{201c}least error of all\u{201d}." }
            @if all.is_empty() { p { "None." } } @else {
                (wide("losses", &html! {
                    table.sortable {
                        thead { tr {
                            th scope="col" { "scenario" } th scope="col" { "figure" } th scope="col" { "gains" }
                            th scope="col" { "made for it" } th.number scope="col" { "mean" }
                            th scope="col" { "better" } th.number scope="col" { "mean" }
                        } }
                        tbody {
                            @for (section, loss) in &all {
                                tr {
                                    th scope="row" { a href=(format!("#{}", anchor(&section.scenario))) { (loss.scenario) } }
                                    td { (loss.figure) } td { (loss.own.gains.word()) }
                                    td { (loss.own.law) }
                                    td.number data-v=(format!("{:?}", loss.means[0])) { (number(loss.means[0], loss.decimals)) }
                                    td { (loss.best.law) }
                                    td.number data-v=(format!("{:?}", loss.means[1])) { (number(loss.means[1], loss.decimals)) }
                                }
                            }
                        }
                    }
                }))
                p.origin { "From the tables of these scenarios: their commands stand there." }
            }
        }
    }

    fn again(&self) -> Markup {
        html! {
            h2 id="again" { "Make it again" }
            p { "The whole page, the same to the last byte on any number of cores:" }
            p.origin { code.command { (command(&self.options)) } }
            p { "Every command on this page prints the configuration hash beside it with " code { "--json" }
                ". " code { "touchdown run" } " draws the same curve from three processes that talk over LCM; "
                "its tuned gains stand in the command. Nothing here was typed in." }
            footer { "Touchdown " (env!("CARGO_PKG_VERSION")) }
        }
    }
}

/// The command that writes a report like this one.
fn command(options: &Options) -> String {
    let Options {
        scenarios,
        phases,
        seeds,
        sweep,
        sweep_phases,
    } = options;
    format!(
        "touchdown report --scenarios {} --phases {phases} --seeds {seeds} --sweep {} --sweep-phases {sweep_phases}",
        quoted(&scenarios.join(",")),
        quoted(sweep)
    )
}

fn how_to_read() -> Markup {
    html! {
        h2 id="read" { "How to read this" }
        dl {
            dt { "peak" } dd { "The highest force that the tool's deflection shows; the target is in the scenario, mostly 10 N." }
            dt { "set10, set2" } dd { "When the force was last outside \u{b1}10 % (\u{b1}2 %) of the target, after the first contact." }
            dt { "IAE" } dd { "Force error added up over 1.5 s: one number for fast and accurate. Smaller is better, as with all of them." }
            dt { "steady error" } dd { "How far the true force is from the target in the end." }
            dt { "orientation" } dd { "How far the tool turned, at most and in the end." }
            dt { "a \u{b1} b, worst c" } dd { "Mean over contact phases and seeds, with its 95 % confidence; below it the worst run. "
                "A contact falls where it likes between two commands of the robot, and a single run shows luck." }
            dt { "default, tuned" } dd { "As configured or, for peers, as published; and tuned for this robot by the same criterion "
                "and budget for every law (" code { "touchdown tune" } "). Untuned laws prove nothing." }
            dt { "gray lines" } dd { "Under each figure and table: the command that makes it again, the hash of its configuration, its seeds." }
        }
        h3 { "The laws" }
        dl {
            @for (law, text) in LAWS { dt { code { (law) } } dd { (text) } }
        }
    }
}

const LAWS: [(&str, &str); 8] = [
    (
        "proposed",
        "The paper's: sensor and pose tell where the object is, and the pose follows where the wanted force results.",
    ),
    (
        "impedance",
        "The same object model, with a mass, a damper and a spring between.",
    ),
    (
        "elastic",
        "The same behind elastic gears: an observer for links and object, and an optimal regulator.",
    ),
    ("literal", "The paper's eq. (2) at each sample, without a model."),
    (
        "pd",
        "The standard: a slow force loop around the position loop, eq. (1).",
    ),
    ("pd-reset", "The same, begun anew at the contact."),
    ("ros2", "ROS 2's admittance_controller."),
    ("fzi", "FZI's cartesian_force_controller."),
];

/// All laws on one plant.
fn shoot_out(section: &Section) -> Result<Markup, FigureError> {
    let rows = &section.comparison.rows;
    let mut figures = Vec::new();
    for (header, title) in RANKED {
        if let Some(figure) = FIGURES.iter().find(|figure| figure.0 == header) {
            let svg =
                ranking::draw(rows, figure, title).map_err(|error| FigureError::Draw(error.to_string()))?;
            figures.extend(svg.map(|svg| (title, svg)));
        }
    }
    Ok(html! {
        h2 id=(anchor(&section.scenario)) { "All laws on one plant: " (plant(section)) }
        p { (prose(&section.about)) }
        (ranking_legend())
        div.panels {
            @for (title, svg) in &figures {
                figure { (drawing(svg, &format!("{title} of each law, scenario {}", section.scenario))) }
            }
        }
        (origin(&section.origin))
        (laws_table(&section.scenario, rows, &section.law))
        (origin(&section.origin))
        (failures(&section.comparison.failures))
        h3 { "Force over time, tuned where there is anything to tune" }
        (panel_legend())
        (panels(&section.scenario, &section.panels))
    })
}

fn scenario(section: &Section) -> Markup {
    html! {
        h3 id=(anchor(&section.scenario)) { (spoken(&section.scenario)) }
        p { (prose(&section.about)) }
        (laws_table(&section.scenario, &section.comparison.rows, &section.law))
        (origin(&section.origin))
        (failures(&section.comparison.failures))
        (panels(&section.scenario, &section.panels))
    }
}

/// What a shoot-out comes to: the scenario's law against the standard one, both tuned.
fn tile(section: &Section) -> Option<Markup> {
    let tuned = |law: &str| -> Option<&Row> {
        let rows = section.comparison.rows.iter();
        rows.filter(|row| row.law == law)
            .max_by_key(|row| row.gains == Gains::Tuned)
    };
    let (own, pd) = (tuned(&section.law)?, tuned("pd")?);
    let ratio = pd.mean.iae_n_s / own.mean.iae_n_s;
    let figure =
        |row: &Row, (_, factor, decimals, value): &Figure| number(value(&row.mean) * factor, *decimals);
    let [settling, peak] =
        ["set10 ms", "peak N"].map(|header| FIGURES.iter().find(|figure| figure.0 == header));
    let (settling, peak) = (settling?, peak?);
    let (law, name) = (&section.law, plant(section));
    Some(html! {
        div { b { (number(ratio, 1)) "\u{d7}" }
            span { "less force error: " code { (law) } " against a tuned " code { "pd" } ", " (name) } }
        div { b { (figure(own, settling)) " ms" }
            span { "until within \u{b1}10 %, instead of " (figure(pd, settling)) " ms, " (name) } }
        div { b { (figure(own, peak)) " N" }
            span { "at the peak, instead of " (figure(pd, peak)) " N, " (name) } }
    })
}

/// Cells of `map` in which law number `law` comes to rest with the least error of all.
fn best_cells(map: &[Vec<Vec<Cell>>], law: usize) -> usize {
    let iae = |law: usize, y: usize, x: usize| {
        let cell = &map[law][y][x];
        cell.mean.filter(|_| cell.settled()).map(|mean| mean.iae_n_s)
    };
    let best = |y: usize, x: usize| {
        iae(law, y, x)
            .is_some_and(|own| (0..map.len()).all(|other| iae(other, y, x).is_none_or(|iae| own <= iae)))
    };
    let all = (0..map[law].len()).flat_map(|y| (0..map[law][y].len()).map(move |x| (y, x)));
    all.filter(|&(y, x)| best(y, x)).count()
}

fn number(value: f64, decimals: usize) -> String {
    match value.is_nan() {
        true => "never".to_owned(),
        false => fixed(value, decimals).replace('-', "\u{2212}"),
    }
}

fn thousands(count: usize) -> String {
    match count {
        0..1000 => count.to_string(),
        _ => format!("{},{:03}", count / 1000, count % 1000),
    }
}

/// A scenario's name for people.
fn spoken(scenario: &str) -> String {
    scenario
        .rsplit('/')
        .next()
        .unwrap_or(scenario)
        .trim_end_matches(".toml")
        .replace('_', " ")
}

/// What a section's laws act on: `rigid gantry`.
fn plant(section: &Section) -> String {
    match section.comparison.rows.first() {
        Some(row) => format!("{} {}", row.robot, row.kinematics),
        None => spoken(&section.scenario),
    }
}

/// The same inside an address.
fn anchor(scenario: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    format!("of-{}", scenario.chars().map(plain).collect::<String>())
}
