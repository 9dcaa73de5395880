//! Charts of the history as inline SVG: height, density and utilisation of the builds over time, a line per machine.

use std::collections::BTreeMap;

use jiff::{ToSpan, civil::Date};
use language::{colon, comma, say};
use ledger::HistoryRow;
use maud::{Markup, PreEscaped, html};
use settings::FarmZone;

/// Width of a chart: about that of a phone, so that its text is never smaller than it is written.
const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 180.0;
const LEFT: f64 = 44.0;
const BOTTOM: f64 = 26.0;
const TOP: f64 = 10.0;
/// Most lines in a chart. The style sheet gives them colours that the colour-blind can tell apart.
const MAX_LINES: usize = 6;

/// A machine's points: seconds since 1970 and a value.
type ChartLines = BTreeMap<String, Vec<(f64, f64)>>;

/// The three charts of published builds; empty when there are fewer than two. The times are those of `zone`.
pub(crate) fn history_charts<'r>(rows: impl Iterator<Item = &'r HistoryRow>, zone: &FarmZone) -> Markup {
    let published: Vec<&HistoryRow> = rows.filter(|row| row.is_published()).collect();
    if published.len() < 2 {
        return html! {};
    }
    let lines = |value: &dyn Fn(&HistoryRow) -> Option<f64>| {
        let mut lines = ChartLines::new();
        for row in &published {
            if let (Some(at), Some(value)) = (row.published_at, value(row)) {
                lines.entry(row.machine.clone()).or_default().push((at.0.as_second() as f64, value));
            }
        }
        lines.values_mut().for_each(|line| line.sort_by(|a, b| a.0.total_cmp(&b.0)));
        lines
    };
    html! {
        div.charts {
            (line_chart(&say!("chart-height"), "mm", &lines(&|row| row.measures.height_mm), zone))
            (line_chart(&say!("chart-density"), "%", &lines(&|row| row.measures.density.map(|d| 100.0 * d)), zone))
            (line_chart(&say!("chart-used"), "%", &lines(&|row| row.height_share().map(|share| 100.0 * share)), zone))
        }
    }
}

/// A line chart with axes, units and a legend.
fn line_chart(title: &str, unit: &str, lines: &ChartLines, zone: &FarmZone) -> Markup {
    let points = || lines.values().flatten();
    let (first, last) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.0), b.max(p.0)));
    // Dates, with the time of day when the chart covers only a few days.
    let format = match last - first {
        span if span < 900.0 => "%H:%M:%S",
        span if span < 4.0 * 86_400.0 => "%m-%d %H:%M",
        _ => "%Y-%m-%d",
    };
    let date = |secs: f64| {
        let time = jiff::Timestamp::from_second(secs as i64).map(|time| time.to_zoned(zone.time_zone().clone()));
        time.map_or_else(|_| String::new(), |time| time.strftime(format).to_string())
    };
    let legend = lines.keys().take(MAX_LINES).enumerate();
    let more = lines.len().saturating_sub(MAX_LINES) as u32;
    html! {
        figure {
            figcaption { (title) (comma()) (unit)
                @for (at, name) in legend { " " span class=(format!("key c{at}")) { (name) } }
                @if more > 0 { " " (say!("more-machines", count = more)) } }
            (plot_lines(title, lines.values().take(MAX_LINES), &date))
        }
    }
}

/// A chart of the build height over the time of the search.
pub(crate) fn height_curve(points: &Vec<(f64, f64)>) -> Markup {
    html! {
        @if points.len() > 1 {
            figure { figcaption { (say!("height-curve")) }
                (plot_lines(&say!("height-over-time"), std::iter::once(points), &|secs| format!("{secs:.1} s"))) }
        }
    }
}

/// Draws lines in a frame; `label` formats the values of the horizontal axis.
fn plot_lines<'a>(
    title: &str,
    lines: impl Iterator<Item = &'a Vec<(f64, f64)>> + Clone,
    label: &dyn Fn(f64) -> String,
) -> Markup {
    let points = || lines.clone().flatten();
    let (first, last) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.0), b.max(p.0)));
    let most = next_round_number(points().map(|p| p.1).fold(1e-9, f64::max));
    let x = |at: f64| LEFT + (WIDTH - LEFT - 8.0) * (at - first) / (last - first).max(1e-9);
    let y = |value: f64| TOP + (HEIGHT - TOP - BOTTOM) * (1.0 - value / most);
    let mut body = String::new();
    for tick in 0..=4 {
        let value = most * f64::from(tick) / 4.0;
        let at = y(value);
        body += &format!("<line class=\"grid\" x1=\"{LEFT}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>", WIDTH - 8.0);
        body += &format!(
            "<text class=\"tick end\" x=\"{}\" y=\"{:.1}\">{}</text>",
            LEFT - 6.0,
            at + 4.0,
            short_number(value)
        );
    }
    for (at, line) in lines.clone().enumerate() {
        let path: Vec<String> = line.iter().map(|p| format!("{:.1},{:.1}", x(p.0), y(p.1))).collect();
        body += &format!("<polyline class=\"c{at}\" points=\"{}\"/>", path.join(" "));
        if line.len() <= 60 {
            body.extend(line.iter().map(|p| {
                let (cx, cy, told) = (x(p.0), y(p.1), short_number(p.1));
                format!(
                    "<circle class=\"c{at}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\"><title>{told}, {}</title></circle>",
                    label(p.0)
                )
            }));
        }
    }
    html! {
        svg viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(title) {
            (PreEscaped(body))
            @for (tick, anchor) in ["tick", "tick middle", "tick end"].into_iter().enumerate() {
                @let at = first + (last - first) * tick as f64 / 2.0;
                @if tick == 0 || last > first { text class=(anchor) x=(format!("{:.1}", x(at))) y=(HEIGHT - 8.0) { (label(at)) } }
            }
        }
    }
}

/// Bars by week, stacked by machine: all weeks from the Monday `days.0` up to before `days.1`, also those in which nothing was published;
/// each says its days. Nothing if nothing was published. `value` is what is summed.
pub(crate) fn weekly_bars(
    title: &str,
    rows: &[HistoryRow],
    days: (Date, Date),
    zone: &FarmZone,
    value: &dyn Fn(&HistoryRow) -> Option<f64>,
) -> Markup {
    let monday = |day: Date| day.saturating_sub(i64::from(day.weekday().to_monday_zero_offset()).days());
    let mut weeks: BTreeMap<Date, BTreeMap<&str, f64>> = BTreeMap::new();
    let mut machines: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.is_published()) {
        let (Some(at), Some(value)) = (row.published_at, value(row)) else { continue };
        let day = at.0.to_zoned(zone.time_zone().clone()).date();
        *weeks.entry(monday(day)).or_default().entry(row.machine.as_str()).or_default() += value;
        machines.insert(row.machine.as_str(), 0);
    }
    if weeks.is_empty() {
        return Markup::default();
    }
    let mut week = monday(days.0);
    while week < days.1 {
        weeks.entry(week).or_default();
        week = week.saturating_add(7.days());
    }
    machines.values_mut().enumerate().for_each(|(place, number)| *number = place.min(MAX_LINES - 1));
    let most = next_round_number(weeks.values().map(|week| week.values().sum()).fold(1e-9, f64::max));
    let step = (WIDTH - LEFT - 8.0) / weeks.len() as f64;
    let tall = HEIGHT - TOP - BOTTOM;
    html! {
        figure {
            figcaption { (title) @for (name, number) in &machines { " " span class=(format!("key c{number}")) { (name) } } }
            svg viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(title) {
                @for tick in 0..=4 {
                    @let at = TOP + tall * (1.0 - f64::from(tick) / 4.0);
                    line.grid x1=(LEFT) x2=(WIDTH - 8.0) y1=(at) y2=(at) {}
                    text.tick.end x=(LEFT - 6.0) y=(at + 4.0) { (short_number(most * f64::from(tick) / 4.0)) }
                }
                @for (place, (monday, week)) in weeks.iter().enumerate() {
                    @let left = LEFT + step * place as f64;
                    @let label = week_label(*monday);
                    @for (name, number, low, high) in stacked(week, &machines) {
                        rect class=(format!("bar c{number}")) x=(format!("{:.1}", left + 0.15 * step)) width=(format!("{:.1}", 0.7 * step))
                            y=(format!("{:.1}", TOP + tall * (1.0 - high / most))) height=(format!("{:.1}", tall * (high - low) / most)) {
                            title { (name) (comma()) (label) (colon()) (short_number(high - low)) }
                        }
                    }
                    text.tick.middle x=(format!("{:.1}", left + 0.5 * step)) y=(HEIGHT - 8.0) { (label) }
                }
            }
        }
    }
}

/// The days of a week: `23\u{2013}29`.
fn week_label(monday: Date) -> String {
    format!("{}\u{2013}{}", monday.day(), monday.saturating_add(6.days()).day())
}

/// The pieces of a bar from the bottom up: machine, number of its colour, lower and upper end.
fn stacked<'a>(week: &BTreeMap<&'a str, f64>, machines: &BTreeMap<&'a str, usize>) -> Vec<(&'a str, usize, f64, f64)> {
    let mut low = 0.0;
    let mut piece = |(&name, &value): (&&'a str, &f64)| {
        let from = low;
        low += value;
        (name, machines.get(name).copied().unwrap_or(0), from, from + value)
    };
    week.iter().map(&mut piece).collect()
}

/// The next round number: 1, 2, 2.5, 5 times a power of ten.
fn next_round_number(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    [1.0, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|s| *s >= value * 0.9999)
        .unwrap_or(value)
}

fn short_number(value: f64) -> String {
    let text = format!("{value:.2}");
    language::decimal(text.trim_end_matches('0').trim_end_matches('.').to_owned())
}
