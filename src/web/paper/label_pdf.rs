//! Writes labels as a PDF. The font is embedded; letters that it lacks are drawn with the outlines of a font of the system. Such a text says
//! what it is to whoever reads the file (`ActualText`): a blank that nobody sees lies over it, for readers ask it only of text.

use std::{collections::BTreeMap, path::PathBuf};

use anyhow::{Context, Result};
use flate2::{Compression, write::ZlibEncoder};
use pdf_writer::{
    Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr,
    types::{CidFontType, FontFlags, SystemInfo, TextRenderingMode, UnicodeCmap},
};
use qrcode::{Color, EcLevel, QrCode};

use super::{
    label_font::{FONT_FILE, LabelFont, LetterShape},
    label_layout::{LINE_HEIGHT, Label, POINTS_PER_MM, RIM_MM, code_size, fitted, inner_size, text_size},
    label_sheet::SheetShape,
    system_fonts::{SystemFont, draw_glyph, fonts_with},
};

/// Free cells that a reader needs around a code; the rim of the label gives most of them.
const QUIET_CELLS: usize = 2;
/// Name of the font in the file, of its font program, and of what its glyphs mean.
const FONT_NAME: Name<'static> = Name(b"F");
const BASE_FONT: Name<'static> = Name(b"NESTDA+Inter-Medium");
const SYSTEM: SystemInfo<'static> = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// What the font of labels lacks for labels: fonts below these folders that have it, and the letters that none of them has.
///
/// # Errors
/// When the font in the program cannot be read.
pub(super) fn fonts_for(labels: &[Label], folders: &[PathBuf]) -> Result<(Vec<SystemFont>, Vec<char>)> {
    let missing = |fonts: &[SystemFont]| -> Result<Vec<char>> {
        Ok(LabelFont::read(fonts)?.lacks(labels.iter().flat_map(Label::texts)))
    };
    let letters = missing(&[])?;
    let fonts = if letters.is_empty() { Vec::new() } else { fonts_with(&letters, folders) };
    let left = missing(&fonts)?;
    Ok((fonts, left))
}

/// The labels on sheets, of which the first lacks `used` labels already. `fonts` draw what the embedded font lacks.
///
/// # Errors
/// When an address is too long for a code.
pub(super) fn write_labels(
    title: &str,
    labels: &[Label],
    (shape, used): (SheetShape, usize),
    fonts: &[SystemFont],
) -> Result<Vec<u8>> {
    let font = LabelFont::read(fonts)?;
    let (mut pdf, mut next) = (Pdf::new(), Ref::new(1));
    let (catalog, tree, info, font_ref) = (next.bump(), next.bump(), next.bump(), next.bump());
    pdf.document_info(info).title(TextStr(title)).producer(TextStr("nestd"));
    let used = used % shape.per_page();
    let places: Vec<(usize, &Label)> = (used..).zip(labels).collect();
    let mut letters = BTreeMap::new();
    let mut pages = Vec::new();
    for sheet in places.chunk_by(|a, b| a.0 / shape.per_page() == b.0 / shape.per_page()) {
        let mut content = Content::new();
        for (place, label) in sheet {
            let corner_mm = shape.corner_mm(place % shape.per_page());
            draw_label(&mut content, &font, &mut letters, label, (corner_mm, &shape))?;
        }
        let (page_ref, content_ref) = (next.bump(), next.bump());
        pages.push(page_ref);
        let packed = pack(&content.finish())?;
        pdf.stream(content_ref, &packed).filter(Filter::FlateDecode);
        let mut page = pdf.page(page_ref);
        let [width, height] = shape.page_mm.map(|mm| (mm * POINTS_PER_MM) as f32);
        page.parent(tree).media_box(Rect::new(0.0, 0.0, width, height)).contents(content_ref);
        page.resources().fonts().pair(FONT_NAME, font_ref);
        page.finish();
    }
    pdf.catalog(catalog).pages(tree);
    pdf.pages(tree).count(pages.len() as i32).kids(pages);
    embed_font(&mut pdf, &font, &letters, (font_ref, next))?;
    Ok(pdf.finish())
}

fn pack(bytes: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    std::io::Write::write_all(&mut encoder, bytes).context("compressing labels")?;
    encoder.finish().context("compressing labels")
}

/// Draws a label whose left upper corner is there on a page.
fn draw_label(
    content: &mut Content,
    font: &LabelFont<'_>,
    letters: &mut BTreeMap<u16, char>,
    label: &Label,
    (corner_mm, shape): ([f64; 2], &SheetShape),
) -> Result<()> {
    let left = (corner_mm[0] + RIM_MM) * POINTS_PER_MM;
    let top = (shape.page_mm[1] - corner_mm[1] - RIM_MM) * POINTS_PER_MM;
    let (side, aside) = code_size(label, shape);
    if side > 0.0 {
        // In the middle of a label, and at the top of a page.
        let below = if shape.is_page() { 0.0 } else { 0.5 * (inner_size(shape)[1] - side) };
        draw_code(content, &label.address, [left, top - below], side)?;
    }
    let mut y = top;
    for (size, line) in fitted(font, label, text_size(label, shape)) {
        y -= LINE_HEIGHT * size;
        draw_text(content, font, letters, &line, [left + aside, y + 0.25 * size], size);
    }
    Ok(())
}

fn draw_text(
    content: &mut Content,
    font: &LabelFont<'_>,
    letters: &mut BTreeMap<u16, char>,
    text: &str,
    [x, y]: [f64; 2],
    size: f64,
) {
    for (letter, glyph) in text.chars().filter_map(|letter| Some((letter, font.glyph(letter)?))) {
        letters.entry(glyph).or_insert(letter);
    }
    let is_whole =
        text.chars().all(|letter| font.glyph(letter).is_some_and(|glyph| letters.get(&glyph) == Some(&letter)));
    if !is_whole {
        content.begin_marked_content_with_properties(Name(b"Span")).properties().actual_text(TextStr(text));
        lay_unseen_blank(content, font, [x, y], (size, size * font.text_width(text)));
    }
    let (mut x, mut run) = (x, (x, Vec::new()));
    for letter in text.chars() {
        match font.shape(letter) {
            LetterShape::Embedded(glyph) => run.1.extend(glyph.to_be_bytes()),
            LetterShape::Outline(face, glyph) => {
                show_run(content, &run, y, size);
                draw_glyph(content, face, glyph, [x, y], size);
                run = (x + size * font.letter_width(letter), Vec::new());
            }
        }
        x += size * font.letter_width(letter);
    }
    show_run(content, &run, y, size);
    if !is_whole {
        content.end_marked_content();
    }
}

/// Lays a blank that nobody sees over a place of this width.
fn lay_unseen_blank(content: &mut Content, font: &LabelFont<'_>, [x, y]: [f64; 2], (size, width): (f64, f64)) {
    let Some(blank) = font.glyph(' ') else { return };
    let stretch = 100.0 * width / (size * font.letter_width(' '));
    content.save_state().begin_text().set_font(FONT_NAME, size as f32);
    content.set_text_rendering_mode(TextRenderingMode::Invisible).set_horizontal_scaling(stretch as f32);
    content.set_text_matrix([1.0, 0.0, 0.0, 1.0, x as f32, y as f32]).show(Str(&blank.to_be_bytes()));
    content.end_text().restore_state();
}

/// Shows glyphs of the embedded font that stand behind each other from a place on.
fn show_run(content: &mut Content, (x, glyphs): &(f64, Vec<u8>), y: f64, size: f64) {
    if !glyphs.is_empty() {
        content.begin_text().set_font(FONT_NAME, size as f32);
        content.set_text_matrix([1.0, 0.0, 0.0, 1.0, *x as f32, y as f32]).show(Str(glyphs)).end_text();
    }
}

/// Draws the code of an address with its left upper corner there.
fn draw_code(content: &mut Content, address: &str, [left, top]: [f64; 2], side: f64) -> Result<()> {
    let code = QrCode::with_error_correction_level(address, EcLevel::M)
        .with_context(|| format!("the address {address} does not fit into a code"))?;
    let cells = code.width();
    let cell = side / (cells + 2 * QUIET_CELLS) as f64;
    let begin = QUIET_CELLS as f64 * cell;
    for (row, line) in code.to_colors().chunks(cells).enumerate() {
        let mut column = 0;
        // Neighbours in a row are one rectangle, without a seam.
        for run in line.chunk_by(|a, b| a == b) {
            if run[0] == Color::Dark {
                let [x, y] = [left + begin + column as f64 * cell, top - begin - (row + 1) as f64 * cell];
                content.rect(x as f32, y as f32, (run.len() as f64 * cell) as f32, cell as f32);
            }
            column += run.len();
        }
    }
    content.fill_nonzero();
    Ok(())
}

/// Embeds the font with what its glyphs mean.
fn embed_font(
    pdf: &mut Pdf,
    font: &LabelFont<'_>,
    letters: &BTreeMap<u16, char>,
    (font_ref, mut next): (Ref, Ref),
) -> Result<()> {
    let (descendant, descriptor, meaning, file) = (next.bump(), next.bump(), next.bump(), next.bump());
    pdf.type0_font(font_ref)
        .base_font(BASE_FONT)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(descendant)
        .to_unicode(meaning);
    let mut cid = pdf.cid_font(descendant);
    cid.subtype(CidFontType::Type2).base_font(BASE_FONT).system_info(SYSTEM).font_descriptor(descriptor);
    cid.cid_to_gid_map_predefined(Name(b"Identity"));
    cid.widths().consecutive(0, (0..font.glyph_count()).map(|glyph| font.width_of(glyph) as f32));
    cid.finish();
    let ([x0, y0, x1, y1], ascent, descent) = font.metrics();
    pdf.font_descriptor(descriptor)
        .name(BASE_FONT)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(x0, y0, x1, y1))
        .italic_angle(0.0)
        .ascent(ascent)
        .descent(descent)
        .cap_height(ascent)
        .stem_v(90.0)
        .font_file2(file);
    let mut cmap = UnicodeCmap::<u16>::new(Name(b"nestd"), SYSTEM);
    for (&glyph, &letter) in letters {
        cmap.pair(glyph, letter);
    }
    pdf.cmap(meaning, &cmap.finish());
    let packed = pack(FONT_FILE)?;
    pdf.stream(file, &packed).filter(Filter::FlateDecode).pair(Name(b"Length1"), FONT_FILE.len() as i32);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{
        super::{label_sheet::LabelSheet, system_fonts::triangle_font},
        *,
    };

    #[test]
    fn a_japanese_name_is_drawn_with_a_font_of_the_system_and_what_none_has_is_named() {
        let label =
            Label {
                title: "試作品-ロボット".to_owned(), lines: vec!["株式会社 1".to_owned()], address: String::new()
            };
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().to_owned()];
        let lacks = |folders: &[PathBuf]| fonts_for(std::slice::from_ref(&label), folders).unwrap().1;
        assert_eq!(lacks(&[]).len(), 7, "{:?}", lacks(&[]));
        std::fs::write(folder.path().join("gothic.ttf"), triangle_font(&"試作品株式会".chars().collect::<Vec<_>>()))
            .unwrap();
        assert_eq!(lacks(&folders), ['社']);
        let (fonts, _) = fonts_for(std::slice::from_ref(&label), &folders).unwrap();
        let font = LabelFont::read(&fonts).unwrap();
        let mut content = Content::new();
        draw_text(&mut content, &font, &mut BTreeMap::new(), &label.title, [10.0, 20.0], 10.0);
        let drawn = String::from_utf8_lossy(&content.finish()).into_owned();
        // Three outlines, one beside the other, and the rest as text behind them.
        for place in ["10 20 m", "20 20 m", "30 20 m", "1 0 0 1 40 20 Tm"] {
            assert!(drawn.contains(place), "{place}: {drawn}");
        }
        assert!((font.text_width("試作品") - 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_text_that_is_drawn_with_outlines_is_read_back_from_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let texts = ["試作品", "株式会社 1", "試作品-ロボット", "bracket.stl"];
        let outlined: Vec<char> = "試作品株式会社".chars().collect();
        std::fs::write(folder.path().join("gothic.ttf"), triangle_font(&outlined)).unwrap();
        let lines = texts[1..].iter().map(|text| (*text).to_owned()).collect();
        let label = Label { title: texts[0].to_owned(), lines, address: String::new() };
        let labels = [label.clone(), label];
        let (fonts, lacks) = fonts_for(&labels, &[folder.path().to_owned()]).unwrap();
        assert!(lacks.is_empty(), "{lacks:?}");
        let file = folder.path().join("labels.pdf");
        std::fs::write(&file, write_labels("Labels", &labels, (LabelSheet::A4Wide.shape(), 0), &fonts).unwrap())
            .unwrap();
        // Where poppler-utils are installed.
        let Ok(read) = std::process::Command::new("pdftotext").args(["-enc", "UTF-8"]).arg(&file).arg("-").output()
        else {
            return;
        };
        let read = String::from_utf8(read.stdout).unwrap();
        for text in texts {
            assert_eq!(read.matches(text).count(), 2 + 2 * usize::from(text == texts[0]), "{text}: {read}");
        }
    }

    #[test]
    fn a_sheet_that_is_begun_is_gone_on_with_and_a_page_holds_what_fits() {
        let label = Label { title: "K".to_owned(), lines: Vec::new(), address: String::new() };
        let pages = |labels: usize, sheet: LabelSheet, used: usize| {
            let pdf = write_labels("Labels", &vec![label.clone(); labels], (sheet.shape(), used), &[]).unwrap();
            String::from_utf8_lossy(&pdf).matches("/Type /Page\n").count()
        };
        assert_eq!(pages(24, LabelSheet::A4Small, 0), 1);
        assert_eq!(pages(24, LabelSheet::A4Small, 1), 2);
        assert_eq!(pages(15, LabelSheet::A4Wide, 0), 2);
        assert_eq!((pages(30, LabelSheet::Letter, 30), pages(3, LabelSheet::Roll, 5)), (1, 3));
    }
}
