//! Rows of an order list that say in another column that they are not wanted: `print? = no`, `status = cancelled`,
//! `gefertigt = x`. Such a part is not printed before a person says yes.

use std::{collections::HashSet, sync::LazyLock};

use super::list_cells::{is_placeholder, normalize_word};

/// Words of a cell that end or withdraw a row, whatever its column is called. [`normalize_word`] is applied to all words.
const ENDED: &str = "cancelled canceled cancel cancellation void obsolete discontinued deleted dropped skip skipped ignore onhold hold \
    notrequired notneeded donotprint dontprint noprint done printed produced manufactured made finished completed complete delivered \
    shipped closed storniert storno abgesagt entfällt entfallen gelöscht gestrichen hinfällig gesperrt pausiert erledigt gefertigt \
    gedruckt produziert hergestellt fertig abgeschlossen geliefert ausgeliefert nichtdrucken nichtfertigen nichtbenötigt nichtnötig \
    annulé annulée annuler supprimé supprimée abandonné suspendu enattente terminé terminée fini imprimé imprimée fabriqué fabriquée \
    livré livrée fait nepasimprimer pasnécessaire cancelado cancelada anulado impreso entregado terminado annullato stampato \
    consegnato geannuleerd vervallen geleverd キャンセル 取消 取消し 取り消し 中止 廃止 不要 保留 完了 済 済み 完成 印刷済 印刷済み \
    製造済 製造済み 製作済 納品済 納品済み 出荷済 出荷済み 取消済";
/// Headers of columns that say whether a row is ended, beside the words above.
const ENDED_HEADERS: &str = "cancelled canceled cancellation storniert storno storniertam entfällt annulé annulée done printed produced \
    finished completed delivered shipped erledigt gefertigt gefertigtam gedruckt gedrucktam produziert hergestellt fertig geliefert \
    geliefertam terminé imprimé fabriqué livré fait キャンセル 取消 完了 済 印刷済 製造済 納品済 出荷済 納品済み 完了日";
/// Headers of columns in which a no means that the row is not wanted.
const WANTED_HEADERS: &str = "print toprint printit doprint active isactive enabled include included needed required order toorder make tomake \
    produce build buildit released release approved go wanted status state todo drucken druck zudrucken aktiv freigabe freigegeben \
    genehmigt benötigt nötig bestellen fertigen zufertigen produzieren herstellen gewünscht zustand stand imprimer àimprimer impression \
    actif active activé nécessaire requis validé approuvé commander fabriquer àfabriquer produire statut état imprimir activo activa \
    estado stampare attivo stato afdrukken actief 印刷 印刷する 出力 造形 製造 製作 要否 有効 承認 状態 状況 ステータス 進捗 発注 必要";
/// Cells that say no.
const NO: &str = "no n nein non false falsch faux 0 off nope not never nicht nie pas aus inactive inaktiv inactif inactive disabled \
    deaktiviert désactivé rejected abgelehnt refusé keine kein none aucun falso nee いいえ ノー 否 無 無し なし 不可 無効 未承認";
/// Signs that say no.
const NO_SIGNS: [&str; 9] = ["✗", "✘", "❌", "☐", "×", "✕", "✖", "╳", "🚫"];

static ENDED_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(ENDED));
static ENDED_COLUMNS: LazyLock<HashSet<String>> = LazyLock::new(|| words(ENDED_HEADERS));
static WANTED_COLUMNS: LazyLock<HashSet<String>> = LazyLock::new(|| words(WANTED_HEADERS));
static NO_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(NO));

fn words(list: &str) -> HashSet<String> {
    list.split_whitespace().map(normalize_word).collect()
}

/// Whether a header names a column that says whether its rows are wanted.
pub(super) fn is_state_header(header: &str) -> bool {
    let word = normalize_word(header);
    ENDED_COLUMNS.contains(&word) || WANTED_COLUMNS.contains(&word)
}

/// Whether a cell of a column with this header says that its row is not wanted. A note counts by its whole text.
pub(super) fn says_no(header: &str, cell: &str) -> bool {
    let (column, word) = (normalize_word(header), normalize_word(cell));
    let is_no = NO_WORDS.contains(&word) || NO_SIGNS.contains(&cell.trim());
    match is_placeholder(cell) {
        // `なし` says nothing in most columns.
        true => WANTED_COLUMNS.contains(&column) && NO_WORDS.contains(&word),
        false if ENDED_WORDS.contains(&word) => true,
        false if ENDED_COLUMNS.contains(&column) => !is_no,
        false => WANTED_COLUMNS.contains(&column) && is_no,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_wanted_is_understood_in_the_languages_of_customers() {
        for (header, cell) in [
            ("print?", "no"),
            ("Print", "N"),
            ("status", "Cancelled"),
            ("Status", "on hold"),
            ("active", "false"),
            ("active", "0"),
            ("Drucken", "Nein"),
            ("Gefertigt", "x"),
            ("gefertigt am", "12.11.2026"),
            ("gefertigt", "3"),
            ("Storniert", "ja"),
            ("Freigabe", "✗"),
            ("Bemerkung", "nicht drucken"),
            ("Statut", "Annulée"),
            ("À imprimer", "non"),
            ("Livré", "oui"),
            ("状態", "取消"),
            ("印刷", "不要"),
            ("印刷", "なし"),
            ("備考", "キャンセル"),
            ("完了", "○"),
        ] {
            assert!(says_no(header, cell), "{header} = {cell}");
        }
    }

    #[test]
    fn what_is_wanted_and_what_says_something_else_is_not_asked_about() {
        for (header, cell) in [
            ("print?", "yes"),
            ("print?", ""),
            ("status", "open"),
            ("Status", "neu"),
            ("active", "TRUE"),
            ("Gefertigt", "nein"),
            ("gefertigt", "0"),
            ("Storniert", "-"),
            ("delivered", "no"),
            ("Gewinde", "nein"),
            ("Bemerkung", "nicht lackieren"),
            ("Preis", "0"),
            ("Farbe", "keine"),
            ("完了", ""),
            ("状態", "未着手"),
        ] {
            assert!(!says_no(header, cell), "{header} = {cell}");
        }
    }
}
