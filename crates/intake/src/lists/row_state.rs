//! Rows of an order list that say in another column that they are not wanted: `print? = no`, `status = cancelled`,
//! `gefertigt = x`. Such a part is not printed before a person says yes.

use std::{collections::HashSet, sync::LazyLock};

use super::list_cells::{is_placeholder, normalize_word};
use crate::names::unordered_folder::not_to_print_words;

/// Words of a cell that end or withdraw a row, whatever its column is called. [`normalize_word`] is applied to all words.
const ENDED: &str = "cancelled canceled cancel cancellation void obsolete discontinued deleted dropped skip skipped ignore onhold hold \
    notrequired notneeded donotprint dontprint noprint done printed produced manufactured made finished completed complete delivered \
    shipped closed storniert storno abgesagt entfällt entfallen gelöscht gestrichen hinfällig gesperrt pausiert erledigt gefertigt \
    gedruckt produziert hergestellt fertig abgeschlossen geliefert ausgeliefert nichtdrucken nichtfertigen nichtbenötigt nichtnötig \
    annulé annulée annuler supprimé supprimée abandonné suspendu enattente terminé terminée fini imprimé imprimée fabriqué fabriquée \
    livré livrée fait nepasimprimer pasnécessaire cancelado cancelada anulado impreso entregado terminado annullato stampato \
    consegnato geannuleerd vervallen geleverd キャンセル 取消 取消し 取り消し 中止 廃止 不要 保留 完了 済 済み 完成 印刷済 印刷済み \
    製造済 製造済み 製作済 納品済 納品済み 出荷済 出荷済み 取消済 cxl cxld 已取消 已打印 已完成 已发货 已交付 отменено отменён отменена \
    отмена напечатано готово выполнено отгружено anulowane anulowano wydrukowane zrušeno vytištěno törölve iptal basıldı annulleret \
    inställd peruttu hiddenrow struckthrough 취소 취소됨 완료 출력완료";
/// Words of a state in which nothing is to be made yet, or no more.
const NOT_YET: &str = "superseded draft quote quotation estimate pending wait waiting pause paused stop stopped postponed deferred sold \
    notapproved unapproved entwurf angebot anfrage warten wartet wartend zurückgestellt verschoben ersetzt überholt brouillon devis \
    attente remplacé reporté borrador presupuesto pendiente bozza preventivo attesa concept offerte wacht 下書き 見積 見積中 待ち 草稿 报价 待定 \
    черновик ожидание";
/// Words by which a short note withdraws a row.
const WITHDRAWN: &str = "cancelled canceled cancel storniert storno abgesagt entfällt entfallen hinfällig annulé annulée cancelado cancelada \
    anulado annullato geannuleerd vervallen キャンセル 取消 已取消 отменено отменён notneeded notrequired nolongerneeded nichtbenötigt \
    nichtnötig nichtmehrbenötigt pasnécessaire obsolete superseded";
/// A longer note tells of something else, too.
const MAX_NOTE_WORDS: usize = 5;
/// Headers of columns that say whether a row is ended, beside the words above.
const ENDED_HEADERS: &str = "cancelled canceled cancellation storniert storno storniertam entfällt annulé annulée done printed produced \
    finished completed delivered shipped erledigt gefertigt gefertigtam gedruckt gedrucktam produziert hergestellt fertig geliefert \
    geliefertam terminé imprimé fabriqué livré fait キャンセル 取消 完了 済 印刷済 製造済 納品済 出荷済 納品済み 完了日 hold onhold skip void \
    qtyprinted qtydone qtydelivered qtyshipped printedqty deliveredqty отменено напечатано готово 已打印 已完成 已取消 취소 완료";
/// Headers of columns in which a no means that the row is not wanted.
const WANTED_HEADERS: &str = "print toprint printit doprint active isactive enabled include included needed required order toorder make tomake \
    produce build buildit released release approved go wanted status state todo drucken druck zudrucken aktiv freigabe freigegeben \
    genehmigt benötigt nötig bestellen fertigen zufertigen produzieren herstellen gewünscht zustand stand imprimer àimprimer impression \
    actif active activé nécessaire requis validé approuvé commander fabriquer àfabriquer produire statut état imprimir activo activa \
    estado stampare attivo stato afdrukken actief printyn printyesno druckenjn druckenjanein imprimeron печать печатать статус состояние \
    drukować tisk tisknout nyomtatás yazdır skriv 打印 状态 是否打印 需要 인쇄 출력 상태 印刷 印刷する 出力 造形 製造 製作 要否 有効 承認 状態 状況 ステータス 進捗 発注 必要";
/// Cells that say no.
const NO: &str = "no n nein non false falsch faux 0 off nope not never nicht nie pas aus inactive inaktiv inactif inactive disabled \
    deaktiviert désactivé rejected abgelehnt refusé keine kein none aucun falso nee não nej nei ei nie nem hayır нет не 否 不 不打印 아니오 いいえ ノー 否 無 無し なし 不可 無効 未承認";
/// Headers of columns for a change of the part's shape, which nestd does not make.
const CHANGE_HEADERS: &str = "scale scaling scalefactor skalierung massstab maßstab faktor skalierungsfaktor échelle escala scala mirror \
    mirrored mirroring gespiegelt spiegeln spiegelung miroir espejo specchio specchiato 倍率 縮尺 尺度 ミラー 反転 镜像 缩放";

/// Signs that say no.
const NO_SIGNS: [&str; 9] = ["✗", "✘", "❌", "☐", "×", "✕", "✖", "╳", "🚫"];

/// Words beside which an end has not come: `not printed yet`, `wird gedruckt`.
const OPEN: &str = "not no yet to be will until nicht noch wird werden zu kein keine bis soll pas encore à non no todavía ancora не ещё еще \
    まだ 未 予定 还没";

static ENDED_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(ENDED));
static ENDED_COLUMNS: LazyLock<HashSet<String>> = LazyLock::new(|| words(ENDED_HEADERS));
static WANTED_COLUMNS: LazyLock<HashSet<String>> = LazyLock::new(|| words(WANTED_HEADERS));
static OPEN_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(OPEN));
static NOT_YET_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(NOT_YET));
static WITHDRAWN_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(WITHDRAWN));
static CHANGE_COLUMNS: LazyLock<HashSet<String>> = LazyLock::new(|| words(CHANGE_HEADERS));
static NO_WORDS: LazyLock<HashSet<String>> = LazyLock::new(|| words(NO));

fn words(list: &str) -> HashSet<String> {
    list.split_whitespace().map(normalize_word).collect()
}

/// Whether a header names a column that says whether its rows are wanted.
pub(super) fn is_state_header(header: &str) -> bool {
    let word = normalize_word(header);
    ENDED_COLUMNS.contains(&word) || WANTED_COLUMNS.contains(&word) || CHANGE_COLUMNS.contains(&word)
}

/// Whether a cell asks for a scale or a mirror image.
fn is_change(cell: &str, word: &str) -> bool {
    let number = cell.trim().trim_end_matches('%').trim().replace(',', ".").parse::<f64>();
    let is_same = match number {
        Ok(number) if cell.contains('%') => number == 100.0,
        Ok(number) => number == 1.0 || number == 100.0 || number == 0.0,
        Err(_) => {
            matches!(cell.trim(), "1:1" | "1 : 1") || NO_WORDS.contains(word) || matches!(word, "none" | "original")
        }
    };
    !is_same
}

/// Most words of an end: `do not print`.
const MAX_WORDS: usize = 3;

fn words_of(cell: &str) -> Vec<String> {
    cell.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(normalize_word).collect()
}

/// Whether a longer text tells of one of these ends: `cancelled by customer`, `already printed`, but not `not printed yet`.
fn tells_of(ends: &HashSet<String>, cell: &str) -> bool {
    let said = words_of(cell);
    let is_open = |range: &[String]| range.iter().any(|word| OPEN_WORDS.contains(word));
    (1..=MAX_WORDS).flat_map(|length| said.windows(length).enumerate().map(move |(at, run)| (at, length, run))).any(
        |(at, length, run)| ends.contains(&run.concat()) && !is_open(&said[..at]) && !is_open(&said[at + length..]),
    )
}

/// Whether a cell of a column with this header says that its row is not wanted. Of a note, only its whole text counts, or the plain
/// words not to print.
pub(super) fn says_no(header: &str, cell: &str) -> bool {
    let (column, word) = (normalize_word(header), normalize_word(cell));
    let is_no = NO_WORDS.contains(&word) || NO_SIGNS.contains(&cell.trim());
    let is_state = ENDED_COLUMNS.contains(&column) || WANTED_COLUMNS.contains(&column);
    match is_placeholder(cell) {
        // `なし` says nothing in most columns.
        true => WANTED_COLUMNS.contains(&column) && NO_WORDS.contains(&word),
        false if CHANGE_COLUMNS.contains(&column) => is_change(cell, &word),
        false if ENDED_WORDS.contains(&word) || not_to_print_words(cell).is_some() => true,
        false if is_state && tells_of(&ENDED_WORDS, cell) => true,
        false if words_of(cell).len() <= MAX_NOTE_WORDS && tells_of(&WITHDRAWN_WORDS, cell) => true,
        false if WANTED_COLUMNS.contains(&column) && NOT_YET_WORDS.contains(&word) => true,
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
            ("status", "cancelled by customer"),
            ("Status", "printed 12.11.2026"),
            ("status", "on hold - waiting for PO"),
            ("status", "already printed"),
            ("State", "CXL"),
            ("Status", "storno 12.11."),
            ("Status", "bereits gedruckt"),
            ("note", "please do not print"),
            ("Hinweis", "Bitte nicht drucken!"),
            ("Печать", "нет"),
            ("状态", "已取消"),
            ("打印", "否"),
            ("Scale", "50 %"),
            ("Maßstab", "1:2"),
            ("scale", "2"),
            ("Mirror", "yes"),
            ("gespiegelt", "x"),
            ("Print Y/N", "N"),
            ("Drucken j/n", "n"),
            ("Hold", "Y"),
            ("Skip", "x"),
            ("Qty printed", "5"),
            ("status", "superseded"),
            ("Status", "Entwurf"),
            ("status", "not approved"),
            ("Status", "zurückgestellt"),
            ("status", "pending"),
            ("comment", "customer cancelled"),
            ("note", "cancelled by customer"),
            ("note", "not needed any more"),
        ] {
            assert!(says_no(header, cell), "{header} = {cell}");
        }
    }

    #[test]
    fn what_is_wanted_and_what_says_something_else_is_not_asked_about() {
        for (header, cell) in [
            ("Scale", "100%"),
            ("scale", "1.0"),
            ("Maßstab", "1:1"),
            ("Mirror", "no"),
            ("gespiegelt", "-"),
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
            ("Status", "not printed yet"),
            ("Status", "noch nicht gedruckt"),
            ("Status", "wird gedruckt"),
            ("status", "to be printed"),
            ("note", "cancelled order 7 was the same part"),
            ("Qty printed", "0"),
            ("Hold", "N"),
            ("note", "pending paint sample"),
            ("note", "draft angle 2 degrees"),
            ("status", "approved"),
            ("note", "not cancelled"),
        ] {
            assert!(!says_no(header, cell), "{header} = {cell}");
        }
    }
}
