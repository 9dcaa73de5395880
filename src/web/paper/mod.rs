//! What goes onto paper, as PDF: labels for bins and bags on sheets of usual sizes, with a QR code that leads to the page of the order, and
//! the record of a part.

pub(super) mod label_font;
pub(super) mod label_form;
mod label_layout;
pub(super) mod label_pdf;
mod label_sheet;
pub(super) mod labels_of;
pub(super) mod record_page;
mod system_fonts;
