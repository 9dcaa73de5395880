//! Labels for bins and bags: sheets of usual sizes as PDF, with a QR code that leads to the page of the order.

pub(super) mod label_font;
pub(super) mod label_form;
pub(super) mod label_pdf;
mod label_sheet;
pub(super) mod labels_of;
mod system_fonts;
