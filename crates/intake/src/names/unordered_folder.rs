//! Folders whose name says that what is in them is not wanted, and that people may have named so for another reason.

use std::ffi::OsStr;

use super::{
    name_match::fold_name,
    old_words::{BACKUP, PAST},
};

/// Names of recycle bins that people or their computers choose. Nobody orders what is thrown away, and it is not taken out of there.
const BINS: [&str; 42] = [
    "papierkorb",
    "gelöscht",
    "gelöschte dateien",
    "gelöschte elemente",
    "recycle bin",
    "recycle",
    "recyclebin",
    "trash",
    "trashes",
    "trashcan",
    "trashbox",
    "wastebasket",
    "deleted",
    "deleted files",
    "deleted items",
    "corbeille",
    "éléments supprimés",
    "ゴミ箱",
    "ごみ箱",
    "papelera",
    "papelera de reciclaje",
    "eliminados",
    "cestino",
    "eliminati",
    "lixeira",
    "prullenbak",
    "回收站",
    "資源回收筒",
    "휴지통",
    "корзина",
    "удаленные",
    "удалённые",
    "kosz",
    "koš",
    "kôš",
    "geri dönüşüm kutusu",
    "çöp kutusu",
    "lomtár",
    "roskakori",
    "papperskorg",
    "papirkurv",
    "κάδος ανακύκλωσης",
];
/// Names of folders for what is done, besides backups and what is old. An order may have such a name, so it is asked about.
const DONE: [&str; 72] = [
    "archive",
    "archives",
    "archived",
    "archiv",
    "archivo",
    "archivio",
    "архив",
    "done",
    "printed",
    "finished",
    "completed",
    "do not print",
    "erledigt",
    "gedruckt",
    "fertig",
    "abgeschlossen",
    "abgeschlossene",
    "nicht drucken",
    "imprimé",
    "imprimés",
    "terminé",
    "terminés",
    "achevé",
    "achevés",
    "terminado",
    "terminados",
    "completado",
    "completados",
    "impreso",
    "impresos",
    "stampati",
    "completato",
    "completati",
    "готово",
    "завершено",
    "напечатано",
    "印刷済み",
    "完了",
    "完成",
    "已完成",
    "已打印",
    "cancelled",
    "canceled",
    "rejected",
    "on hold",
    "snapshot",
    "snapshots",
    "storniert",
    "abgelehnt",
    "annulé",
    "annulés",
    "cancelado",
    "annullato",
    "отменено",
    "キャンセル",
    "已取消",
    "storno",
    "failed",
    "error",
    "errors",
    "fehler",
    "ausschuss",
    "scrap",
    "rejects",
    "superseded",
    "obsolete",
    "processed",
    "wartend",
    "previous versions",
    "vorgängerversionen",
    "versions",
    "stversions",
];

/// Words in the name of a file that nobody wants to be printed.
const DO_NOT_PRINT: [&str; 12] = [
    "do not print",
    "dont print",
    "don't print",
    "not for print",
    "nicht drucken",
    "ne pas imprimer",
    "no imprimir",
    "non stampare",
    "не печатать",
    "印刷不要",
    "印刷禁止",
    "不要打印",
];
/// Words in the name of a file that is not wanted any more, or not yet.
const UNWANTED: [&str; 21] = [
    "cancelled",
    "canceled",
    "superseded",
    "obsolete",
    "rejected",
    "not approved",
    "deleted",
    "scrapped",
    "storniert",
    "gesperrt",
    "ausschuss",
    "nicht fertig",
    "nicht freigegeben",
    "gelöscht",
    "ungültig",
    "annulé",
    "supprimé",
    "cancelado",
    "annullato",
    "キャンセル",
    "已取消",
];

/// The name as it is compared: without the signs around it that put it first or last in a list, as in `_old`.
fn bare_name(name: &OsStr) -> Option<String> {
    let folded = fold_name(name.to_str()?);
    Some(folded.trim_matches(|c: char| !c.is_alphanumeric()).replace(['_', '-'], " "))
}

/// Whether a folder is a recycle bin by its name.
pub(crate) fn is_bin_name(name: &OsStr) -> bool {
    bare_name(name).is_some_and(|name| BINS.contains(&name.as_str()))
}

/// Whether a folder is by its name for what was wanted once: `old`, `backup_2025-11`, `2025-03 done`.
pub(crate) fn is_past_name(name: &OsStr) -> bool {
    let is_past = |name: &str| [&BACKUP[..], &PAST, &DONE].iter().any(|words| words.contains(&name));
    bare_name(name).is_some_and(|name| is_past(without_date(&name)))
}

/// A name without the year or date before or behind it; a shorter number, as in `alt 3`, belongs to the name.
fn without_date(name: &str) -> &str {
    let date = |c: char| c.is_ascii_digit() || matches!(c, ' ' | '.');
    let is_date = |text: &str| text.split([' ', '.']).any(|word| word.len() >= 4);
    let bare = name.trim_end_matches(date);
    let name = if is_date(&name[bare.len()..]) { bare } else { name };
    let bare = name.trim_start_matches(date);
    if is_date(&name[..name.len() - bare.len()]) { bare } else { name }
}

/// The words by which a text says that something is not to be printed, if it has such.
pub(crate) fn not_to_print_words(text: &str) -> Option<&'static str> {
    let text = plain_words(text);
    DO_NOT_PRINT.into_iter().find(|words| text.contains(words))
}

/// The words of a file's name by which nobody wants it to be printed, if it has such.
pub(crate) fn unwanted_words(name: &str) -> Option<&'static str> {
    let text = plain_words(name);
    not_to_print_words(name).or_else(|| UNWANTED.into_iter().find(|words| text.contains(words)))
}

fn plain_words(text: &str) -> String {
    fold_name(text).replace(['_', '-'], " ").replace('’', "'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_and_folders_of_the_past_are_told_from_orders() {
        for name in ["Papierkorb", "Recycle Bin", "TRASH", "_Deleted", "Corbeille", "ゴミ箱", "Papelera", "Cestino"]
        {
            assert!(is_bin_name(OsStr::new(name)) && !is_past_name(OsStr::new(name)), "{name}");
        }
        for name in [
            "old",
            "OLD",
            "_old_",
            "Backups",
            "Sicherung",
            "Anciennes versions",
            "old_versions",
            "旧",
            "バックアップ",
            "Viejo",
            "backup_2025",
            "Archiv 2025-11",
            "old 20251101",
            "Fertig",
            "Abgeschlossen",
            "2025-03 alt",
            "20250301_done",
            "01.03.2025 old",
            "respaldos",
            "terminés",
            "Старые",
        ] {
            assert!(is_past_name(OsStr::new(name)) && !is_bin_name(OsStr::new(name)), "{name}");
        }
        for name in [
            "Oldenburg",
            "order-1042",
            "alt 3",
            "3 alt",
            "tmp",
            "part 2025",
            "2025",
            "trash can lids",
            "Archivregal",
            "1042",
            "",
        ] {
            assert!(!is_past_name(OsStr::new(name)) && !is_bin_name(OsStr::new(name)), "{name}");
        }
    }

    #[test]
    fn a_name_that_says_not_to_print_is_told_from_others() {
        assert_eq!(not_to_print_words("x_DO_NOT_PRINT.stl"), Some("do not print"));
        assert_eq!(not_to_print_words("Halter - nicht drucken.stl"), Some("nicht drucken"));
        assert_eq!(not_to_print_words("print-bed clip.stl"), None);
        assert_eq!(unwanted_words("x_storniert.stl"), Some("storniert"));
        assert_eq!(unwanted_words("Halter (not approved).stl"), Some("not approved"));
        assert_eq!(unwanted_words("door_stop hold.stl"), None);
    }
}
