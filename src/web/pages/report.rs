//! The report of a build: one self-contained HTML file to mail. It loads nothing from any host, and its content
//! security policy forbids it. A person views it in a browser without the farm, or prints it.

use std::{borrow::Cow, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use build_file::{BuildMetadata, Viewpoint};
use farm::CakeContents;
use language::say;
use ledger::BuildRow;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use settings::{FarmZone, MachineProfile};

use crate::{
    tables::{CAKE_PART_COLUMNS, SheetFact, TimeView, build_facts, fields, height_in_volume},
    web::{
        base::listing::{fact_list, table_of},
        core::{
            scene::pack_scene,
            view_section::{ViewSection, ViewedPart},
        },
        figures::{chart::height_curve, pick_map, search_report::ReportExcerpt},
        look::{
            script_texts::{VIEW, script_texts},
            style::STYLE,
        },
    },
};

/// Approximate limit of the triangles in the 3D view, so that the file can be mailed.
const MAX_TRIANGLES: usize = 250_000;
/// Width and height of the picture, pixels.
const PICTURE_SIZE: (u32, u32) = (960, 720);
const SCRIPT: &str = include_str!("../assets/view.js");

/// The content of a report.
#[derive(Debug)]
pub struct HtmlReport<'a> {
    /// The copies in the build with their meshes.
    pub cake: &'a CakeContents,
    /// Where the facts of the report come from.
    pub source: ReportSource<'a>,
}

/// Where the facts of a report come from.
#[derive(Debug, Clone, Copy)]
pub enum ReportSource<'a> {
    /// The ledger.
    Ledger(&'a BuildRow, &'a MachineProfile),
    /// A build file and its metadata.
    File(&'a Path, &'a BuildMetadata),
}

impl HtmlReport<'_> {
    /// Renders the whole HTML file.
    ///
    /// # Errors
    /// When the scene cannot be serialised, which does not happen in practice.
    pub fn to_html(&self) -> anyhow::Result<String> {
        let (number, height_mm, layer_mm) = self.scene_numbers();
        let scene = STANDARD.encode(pack_scene(self.cake, (number, height_mm, layer_mm), MAX_TRIANGLES)?);
        let key = blake3::hash(scene.as_bytes()).to_hex().to_string();
        let title = self.report_title();
        let whole = html! {
            (DOCTYPE)
            html lang=(language::current().tag()) {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(content_policy(&key));
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (title) }
                    style nonce=(key) { (PreEscaped(STYLE)) }
                }
                body {
                    main #main { (self.body_markup(&title, number)) }
                    footer { p { (say!("made-by", version = env!("CARGO_PKG_VERSION"))) } }
                    (script_texts(&[VIEW]))
                    // Base64 text cannot contain `</script>`.
                    script #scene type="text/plain" { (PreEscaped(&scene)) }
                    script type="module" nonce=(key) { (PreEscaped(SCRIPT)) }
                }
            }
        };
        Ok(whole.into_string())
    }

    fn body_markup(&self, title: &str, number: i64) -> Markup {
        let copies = self.cake.copy_count() as u32;
        let (points, cake) = self.search_results();
        let parts = self.cake.parts.iter().map(ViewedPart::of_cake).collect();
        html! {
            h1 { (title) }
            @if self.cake.missing_mesh_count() > 0 {
                p.bad { (say!("parts-not-shown", parts = self.cake.missing_mesh_count())) }
            }
            (ViewSection { build: number, version: String::new(), parts }.to_markup())
            (self.facts_markup(copies))
            (height_curve(&points))
            h2 { (fields::PARTS.said()) }
            (table_of(&fields::PARTS.said(), None, CAKE_PART_COLUMNS, &self.cake.parts, &self.time_view()))
            h2 { (say!("pick-map")) }
            img.cake alt=(pick_map::picture_text()) width=(PICTURE_SIZE.0) height=(PICTURE_SIZE.1) src=(self.picture_data_url());
            (pick_map::map_without_links(&cake))
        }
    }

    /// A report is kept: it tells no ages. The metadata of a build file are texts.
    fn time_view(&self) -> TimeView {
        match self.source {
            ReportSource::Ledger(_, profile) => TimeView::kept(&profile.time_zone),
            ReportSource::File(..) => TimeView::kept(&FarmZone::default()),
        }
    }

    fn report_title(&self) -> String {
        match self.source {
            ReportSource::Ledger(build, _) => say!("build-on", build = build.id.to_string(), printer = &build.machine),
            ReportSource::File(file, info) => {
                let name = || file.file_name().unwrap_or_default().to_string_lossy().into_owned();
                build_file::escape_invisible(&info.heading.title.clone().unwrap_or_else(name))
            }
        }
    }

    /// The build's number, its height in mm and the layer height in mm.
    fn scene_numbers(&self) -> (i64, Option<f64>, f64) {
        let top_mm = || self.cake.top_mm();
        match self.source {
            ReportSource::Ledger(build, profile) => {
                (build.id.0, build.measures.height_mm.or_else(top_mm), profile.space.layer_mm)
            }
            ReportSource::File(_, info) => {
                let number = info.heading.build_id.as_ref().and_then(|id| id.parse().ok()).unwrap_or(0);
                (number, top_mm(), info.rules.layer_mm.unwrap_or(nester::DEFAULT_LAYER_MM))
            }
        }
    }

    fn facts_markup(&self, copies: u32) -> Markup {
        match self.source {
            ReportSource::Ledger(build, profile) => {
                let view = self.time_view();
                fact_list(&build_facts(build, Some(profile), (copies.to_string(), None), &view), &view)
            }
            ReportSource::File(file, info) => fact_list(&file_facts(file, info, self.cake), &self.time_view()),
        }
    }

    /// The curve of the height during the search, and the cake with the removal order of its copies.
    fn search_results(&self) -> (Vec<(f64, f64)>, Cow<'_, CakeContents>) {
        match self.source {
            ReportSource::Ledger(build, _) => (build.height_curve(), Cow::Borrowed(self.cake)),
            ReportSource::File(file, _) => {
                let (excerpt, mut cake) = (ReportExcerpt::read_beside(file), self.cake.clone());
                excerpt.mark_removal_order(&mut cake);
                (excerpt.curve, Cow::Owned(cake))
            }
        }
    }

    fn picture_data_url(&self) -> String {
        format!("data:image/png;base64,{}", STANDARD.encode(self.cake.render_picture(Viewpoint::Iso, PICTURE_SIZE)))
    }
}

/// A content security policy that allows only what is in the file: scripts and styles by nonce, pictures as data URLs.
fn content_policy(key: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{key}'; style-src 'nonce-{key}'; img-src data:; \
         base-uri 'none'; form-action 'none'"
    )
}

/// The facts from the metadata of a build file.
fn file_facts(file: &Path, info: &BuildMetadata, cake: &CakeContents) -> Vec<SheetFact> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let shown = |text: &Option<String>| text.as_deref().map(build_file::escape_invisible);
    let search =
        [info.heading.seed.map(|seed| say!("seed", seed = seed.to_string())), shown(&info.heading.application)];
    let lines = [
        height_in_volume(cake.top_mm(), Some(cake.volume_mm.z)).map(|text| fields::HEIGHT.fact_of(text)),
        fields::DENSITY.fact(info.density),
        fields::COPIES.fact(cake.copy_count()),
        fields::CLEARANCE
            .with_unit(info.rules.clearance_mm)
            .map(|asked| fields::CLEARANCE.fact_of(say!("asked", clearance = asked))),
        fields::MACHINE.fact(shown(&info.heading.machine)),
        fields::SEARCH.fact(language::join_names(search.into_iter().flatten())),
        fields::MADE.fact(shown(&info.heading.created)),
        fields::FILE.fact(build_file::escape_invisible(&name)),
    ];
    lines.into_iter().flatten().collect()
}

#[cfg(test)]
#[path = "tests/report_tests.rs"]
mod tests;
