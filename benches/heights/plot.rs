//! Height over time as an SVG drawing: a line per seed, for our own method and, where it was measured, the published one.

use std::fmt::Write;

use nester::NestingMethod;

use super::{record_book::SearchRecord, trial::CurveStep};

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 400.0;
/// Left, right, top, bottom.
const MARGIN: [f64; 4] = [60.0, 20.0, 36.0, 48.0];
/// Start of the time axis, CPU seconds; the axis is logarithmic.
const FIRST_SECS: f64 = 0.03;

/// Maps CPU seconds and mm to coordinates of the drawing.
struct PlotAxes {
    last_secs: f64,
    low_mm: f64,
    high_mm: f64,
}

impl PlotAxes {
    fn x(&self, secs: f64) -> f64 {
        let share = (secs.max(FIRST_SECS) / FIRST_SECS).ln() / (self.last_secs / FIRST_SECS).ln();
        MARGIN[0] + share.min(1.0) * (WIDTH - MARGIN[0] - MARGIN[1])
    }

    fn y(&self, mm: f64) -> f64 {
        let share = (mm - self.low_mm) / (self.high_mm - self.low_mm);
        HEIGHT - MARGIN[3] - share * (HEIGHT - MARGIN[2] - MARGIN[3])
    }
}

fn colour(method: NestingMethod) -> &'static str {
    match method {
        NestingMethod::Nestd => "#1668a8",
        NestingMethod::Paper => "#c0442f",
    }
}

/// The drawing of the records of one workload; `last_secs` is their budget.
pub fn drawing(title: &str, records: &[&SearchRecord], last_secs: f64) -> String {
    let heights = || records.iter().flat_map(|r| r.finding.curve.iter().map(|step| step.2));
    let bound_mm = records.iter().map(|r| r.finding.lower_bound_mm).fold(0.0, f64::max);
    let axes = PlotAxes { last_secs, low_mm: 0.0, high_mm: 1.05 * heights().fold(bound_mm.max(1.0), f64::max) };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n\
         <text x=\"{}\" y=\"22\" font-size=\"15\">{title}</text>\n",
        MARGIN[0]
    );
    grid(&mut svg, &axes);
    let bound_y = axes.y(bound_mm);
    line(&mut svg, [axes.x(FIRST_SECS), bound_y, axes.x(last_secs), bound_y], "#777\" stroke-dasharray=\"5 4");
    text(&mut svg, axes.x(FIRST_SECS) + 6.0, bound_y - 5.0, "start", "lower bound");
    for record in records {
        let way = step_path(&axes, &record.finding.curve, record.finding.cpu_secs);
        let stroke = colour(record.finding.trial.method);
        let _ = writeln!(
            svg,
            "<path d=\"{way}\" fill=\"none\" stroke=\"{stroke}\" stroke-width=\"1.6\" stroke-opacity=\"0.8\"/>"
        );
    }
    let methods = [(NestingMethod::Nestd, "nestd"), (NestingMethod::Paper, "published method")];
    let is_drawn = |method: NestingMethod| records.iter().any(|r| r.finding.trial.method == method);
    for (at, (method, name)) in methods.into_iter().filter(|(method, _)| is_drawn(*method)).enumerate() {
        let (x, y) = (WIDTH - 270.0 + 90.0 * at as f64, 22.0);
        line(&mut svg, [x, y - 4.0, x + 24.0, y - 4.0], colour(method));
        text(&mut svg, x + 30.0, y, "start", name);
    }
    svg.push_str("</svg>\n");
    svg
}

/// The path of a curve in steps: a height is valid until a lower one is found.
fn step_path(axes: &PlotAxes, curve: &[CurveStep], end_secs: f64) -> String {
    let mut way = String::new();
    for (at, step) in curve.iter().enumerate() {
        let (x, y) = (axes.x(step.0), axes.y(step.2));
        let _ = if at == 0 { write!(way, "M{x:.1} {y:.1}") } else { write!(way, "H{x:.1}V{y:.1}") };
    }
    if !curve.is_empty() {
        let _ = write!(way, "H{:.1}", axes.x(end_secs));
    }
    way
}

fn grid(svg: &mut String, axes: &PlotAxes) {
    let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
    let step = steps.into_iter().find(|step| axes.high_mm / step <= 8.0).unwrap_or(500.0);
    let mut mm = 0.0;
    while mm <= axes.high_mm {
        let y = axes.y(mm);
        line(svg, [MARGIN[0], y, WIDTH - MARGIN[1], y], "#ddd");
        text(svg, MARGIN[0] - 8.0, y + 4.0, "end", &mm.to_string());
        mm += step;
    }
    for secs in [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0, 160.0, 600.0] {
        if secs <= axes.last_secs {
            let x = axes.x(secs);
            line(svg, [x, MARGIN[2], x, HEIGHT - MARGIN[3]], "#eee");
            text(svg, x, HEIGHT - MARGIN[3] + 18.0, "middle", &secs.to_string());
        }
    }
    text(svg, 0.5 * WIDTH, HEIGHT - 10.0, "middle", "CPU seconds");
    text(svg, 8.0, MARGIN[2] - 8.0, "start", "mm");
}

fn line(svg: &mut String, [x1, y1, x2, y2]: [f64; 4], stroke: &str) {
    let _ = writeln!(svg, "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{stroke}\"/>");
}

fn text(svg: &mut String, x: f64, y: f64, anchor: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#333\">{words}</text>");
}
