//! The report of a build: one HTML file to mail, with everything in it. It asks no host for anything, and its policy forbids it
//! to; it is looked at in a browser without the farm, and printed.

use std::{borrow::Cow, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use build_file::{BuildInfo, Viewpoint};
use jiff::Timestamp;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{
    build::{curve, view},
    listing::{facts, table_of},
    pick_map,
    scene::packed,
    search::Told,
    words::count,
};
use crate::{
    farm::Cake,
    ledger::BuildRow,
    settings::Profile,
    tables::{CAKE_PART_COLUMNS, SheetFact, build_facts, fields, height_in_volume},
};

/// Triangles of the 3D view, about: what a mail may carry.
const MOST_DRAWN: usize = 250_000;
/// Pixels of the picture.
const PICTURE: (u32, u32) = (960, 720);
const STYLE: &str = include_str!("assets/style.css");
const SCRIPT: &str = include_str!("assets/view.js");

/// What a report tells.
#[derive(Debug)]
pub struct Report<'a> {
    /// What stands in the build.
    pub cake: &'a Cake,
    /// Where its facts come from.
    pub source: Source<'a>,
}

/// Where the facts of a report come from.
#[derive(Debug, Clone, Copy)]
pub enum Source<'a> {
    /// The ledger.
    Ledger(&'a BuildRow, &'a Profile),
    /// A build file, and what it says about itself.
    File(&'a Path, &'a BuildInfo),
}

impl Report<'_> {
    /// The whole file.
    ///
    /// # Errors
    /// When the scene cannot be written, which does not happen.
    pub fn html(&self) -> anyhow::Result<String> {
        let (number, height_mm, layer_mm) = self.numbers();
        let scene = STANDARD.encode(packed(self.cake, (number, height_mm, layer_mm), MOST_DRAWN)?);
        let key = blake3::hash(scene.as_bytes()).to_hex().to_string();
        let title = self.title();
        let whole = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(policy(&key));
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (title) }
                    style nonce=(key) { (PreEscaped(STYLE)) }
                }
                body {
                    main #main { (self.content(&title, number)) }
                    footer { p { "Made by nestd " (env!("CARGO_PKG_VERSION")) ". Times are UTC, lengths mm." } }
                    // Letters of base64 end no element.
                    script #scene type="text/plain" { (PreEscaped(&scene)) }
                    script type="module" nonce=(key) { (PreEscaped(SCRIPT)) }
                }
            }
        };
        Ok(whole.into_string())
    }

    fn content(&self, title: &str, number: i64) -> Markup {
        let copies = self.cake.copies() as u32;
        let (points, cake) = self.searched();
        html! {
            h1 { (title) }
            @if self.cake.missing() > 0 {
                p.bad { (count(self.cake.missing() as u32, "part is", "parts are")) " not shown: the originals are no longer kept." }
            }
            (view(number, copies, ""))
            (self.facts(copies))
            (curve(&points))
            h2 { "Parts" }
            (table_of("Parts", None, CAKE_PART_COLUMNS, &self.cake.parts))
            h2 { "Pick map" }
            img.cake alt=(pick_map::PICTURE) width=(PICTURE.0) height=(PICTURE.1) src=(self.picture());
            (pick_map::map(&cake))
        }
    }

    fn title(&self) -> String {
        match self.source {
            Source::Ledger(build, _) => format!("Build {} on {}", build.id, build.profile),
            Source::File(file, info) => {
                let name = || file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                build_file::visible(&info.title.clone().unwrap_or_else(name))
            }
        }
    }

    /// Number, height and layer, mm.
    fn numbers(&self) -> (i64, Option<f64>, f64) {
        let top_mm = || self.cake.top_mm();
        match self.source {
            Source::Ledger(build, profile) => {
                (build.id.0, build.measures.height_mm.or_else(top_mm), profile.space.layer_mm)
            }
            Source::File(_, info) => {
                let number = info.build_id.as_ref().and_then(|id| id.parse().ok()).unwrap_or(0);
                (number, top_mm(), info.layer_mm.unwrap_or(nester::DEFAULT_LAYER_MM))
            }
        }
    }

    fn facts(&self, copies: u32) -> Markup {
        match self.source {
            Source::Ledger(build, profile) => {
                facts(&build_facts(build, Some(profile), (copies.to_string(), None), Timestamp::now()))
            }
            Source::File(file, info) => facts(&of_file(file, info, self.cake)),
        }
    }

    /// How the height fell, and the cake with how its copies come out.
    fn searched(&self) -> (Vec<(f64, f64)>, Cow<'_, Cake>) {
        match self.source {
            Source::Ledger(build, _) => (build.curve(), Cow::Borrowed(self.cake)),
            Source::File(file, _) => {
                let (told, mut cake) = (Told::beside(file), self.cake.clone());
                told.mark(&mut cake);
                (told.curve, Cow::Owned(cake))
            }
        }
    }

    fn picture(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(self.cake.picture(Viewpoint::Iso, PICTURE)))
    }
}

/// Nothing but what is inside: scripts and styles by their key, pictures as data.
fn policy(key: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{key}'; style-src 'nonce-{key}'; img-src data:; \
         base-uri 'none'; form-action 'none'"
    )
}

/// What a build file says about itself.
fn of_file(file: &Path, info: &BuildInfo, cake: &Cake) -> Vec<SheetFact> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let shown = |said: &Option<String>| said.as_deref().map(build_file::visible);
    let search = [info.seed.map(|seed| format!("seed {seed}")), shown(&info.application)];
    let lines = [
        height_in_volume(cake.top_mm(), Some(cake.volume_mm.z)).map(|text| fields::HEIGHT.fact_of(text)),
        fields::DENSITY.fact(info.density),
        fields::COPIES.fact(cake.copies()),
        fields::CLEARANCE.with_unit(info.clearance_mm).map(|asked| fields::CLEARANCE.fact_of(asked + " asked")),
        fields::MACHINE.fact(shown(&info.profile)),
        fields::SEARCH.fact(search.into_iter().flatten().collect::<Vec<_>>().join(", ")),
        fields::MADE.fact(shown(&info.created)),
        fields::FILE.fact(build_file::visible(&name)),
    ];
    lines.into_iter().flatten().collect()
}

#[cfg(test)]
#[path = "report_tests.rs"]
mod tests;
