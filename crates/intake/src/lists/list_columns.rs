//! Recognises the columns of an order list by the header words that people use.

use std::{collections::HashMap, sync::LazyLock};

use super::{
    list_cells::{bare_cell, normalize_word},
    row_state::{is_state_header, says_no},
};

/// Meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ListColumn {
    File,
    Copies,
    Due,
    Priority,
    Orientation,
    Order,
    Unit,
    Clearance,
    Note,
    Customer,
    Email,
    Material,
    Finish,
}

impl ListColumn {
    /// The name of the same field in tickets.
    pub fn ticket_word(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Copies => "copies",
            Self::Due => "due",
            Self::Priority => "priority",
            Self::Orientation => "orientation",
            Self::Order => "order",
            Self::Unit => "unit",
            Self::Clearance => "clearance",
            Self::Note => "note",
            Self::Customer => "customer",
            Self::Email => "email",
            Self::Material => "material",
            Self::Finish => "finish",
        }
    }
}

/// Header words with one clear meaning, in the languages of customers. [`plain`] is applied to them.
const CLEAR_HEADERS: [(ListColumn, &str); 12] = [
    (
        ListColumn::File,
        "file filename path filepath datei dateiname dateipfad fichier nomdufichier nomfichier nomdefichier archivo \
         nombredearchivo nombredelarchivo fichero nombredefichero nomefile nomedelfile arquivo nomedoarquivo ficheiro bestand \
         bestandsnaam filnamn filnavn plik nazwapliku soubor nazevsouboru tiedosto dosya dosyaadi fajl файл имяфайла ファイル \
         ファイル名 文件 文件名 檔案 檔名 檔案名稱 파일 파일명 파일이름 stl stlfile stldatei stldateien stlname lineitemname",
    ),
    (
        ListColumn::Copies,
        "copies copy lineitemquantity quantity quantities qty count pcs noofpcs noofpieces noofcopies numberofpieces numberofcopies totalqty \
         totalquantity qtytotal quantityrequired qtyrequired orderqty orderquantity kopien gesamtmenge gesamtstückzahl bestellmenge menge stück stückzahl stk anzahl anz quantité qté exemplaires \
         nbre cantidad cant unidades uds copias quantità qtà copie pezzi quantidade qtd qtde peças aantal stuks hoeveelheid \
         antal antall ilość sztuk szt množství počet kusů kpl määrä darab mennyiség adet miktar количество колво шт 数量 個数 員数 枚数 \
         部数 數量 份数 件数 수량 개수",
    ),
    (
        ListColumn::Due,
        "shipby mustshipby due duedate dueby deadline deliverydate deliveryby neededby needby fällig fälligam fälligkeit termin liefertermin \
         lieferdatum échéance datedelivraison délai fechadeentrega fechaentrega vencimiento scadenza datadiconsegna \
         dataconsegna prazo datadeentrega dataentrega leverdatum förfallodatum leveransdatum leveringsdato termindostawy termín \
         納期 希望納期 納品日 納入日 期限 期日 締切 交期 截止日期 交货日期 납기 납기일 срок срокпоставки",
    ),
    (
        ListColumn::Priority,
        "priority prio priorität priorité prioridad priorità prioridade prioriteit prioritet priorytet priorita 優先度 優先順位 \
         优先级 우선순위 приоритет",
    ),
    (
        ListColumn::Orientation,
        "orientation orientierung ausrichtung orientación orientamento orientação oriëntatie orientering orientacja orientace \
         向き 摆放方向 방향 ориентация",
    ),
    (
        ListColumn::Order,
        "order orderno ordernr ordernumber orderid orderref po pono ponumber job jobno jobnumber auftrag auftragsnummer \
         auftragsnr bestellung bestellnummer bestellnr commande numérodecommande ncommande ndecommande nodecommande bondecommande pedido ordine encomenda bestelling \
         bestelnummer zamówienie objednávka tilaus sipariş 注文 注文番号 受注番号 订单 订单号 訂單 주문 주문번호 заказ",
    ),
    (
        ListColumn::Unit,
        "unit einheit maßeinheit unité unidad unità unidade eenheid enhet enhed jednostka jednotka yksikkö 単位 单位 단위 единица",
    ),
    (
        ListColumn::Clearance,
        "clearance clearancemm spacing abstand abstandmm espacement distanza separación afstand avstånd 間隔 间距 간격 зазор",
    ),
    (
        ListColumn::Note,
        "note notes comment comments remark remarks bemerkung bemerkungen notiz notizen hinweis kommentar anmerkung remarque \
         remarques commentaire nota notas observaciones comentario osservazioni commento observação observações opmerking \
         opmerkingen uwagi poznámka 備考 メモ 备注 비고 примечание комментарий",
    ),
    (
        ListColumn::Customer,
        "customer customername customerno customernumber client clientname kunde kundenname kundennr kundennummer auftraggeber \
         besteller endkunde cliente nomduclient nomclient nombredelcliente nomecliente klant klantnaam kund kundnamn klient \
         zákazník zleceniodawca nazwaklienta asiakas müşteri 顧客 顧客名 客先 客先名 得意先 お客様 お客様名 \
         客户 客户名称 客戶 고객 고객명 клиент заказчик",
    ),
    (
        ListColumn::Email,
        "email emailaddress mailaddress contactemail customeremail emailadresse mailadresse courriel adressemail adresseemail \
         correoelectrónico eメール メール メールアドレス 电子邮件 邮箱 이메일",
    ),
    (
        ListColumn::Material,
        "material mat materials werkstoff werkstoffe matière matériau materiale materiaal materiál materiał materiaali materyal malzeme \
         材料 材質 材质 素材 原料 재료 소재 재질 материал",
    ),
];

/// Ambiguous header words, used only for columns that no clear word names.
const AMBIGUOUS_HEADERS: [(ListColumn, &str); 5] = [
    (
        ListColumn::File,
        "part parts partname partno partnumber name model item article description designation reference teil teilenummer artikel \
         artikelnr artikelnummer artikelname benennung zeichnung zeichnungsnr désignation référence article teilename bauteil bezeichnung modell pièce piece nom nombre pieza \
         pezzo nome parte peça onderdeel naam detalj del część díl osa parça деталь название 部品 部品名 部品番号 図面番号 図面 品番 図番 型番 品名 零件 零件名称 名称 부품 품명",
    ),
    (ListColumn::Copies, "pieces pièces piezas amount units nombre numero número number nummer stücke ks db"),
    (ListColumn::Unit, "units unités einheiten"),
    (ListColumn::Due, "delivery livraison entrega consegna levering dostawa dodání"),
    // Quotations have a finish and an after-treatment: the first is taken, the other told as unknown.
    (
        ListColumn::Finish,
        "finish finishing surfacefinish finishingsteps postprocessing postprocess nachbearbeitung nachbehandlung oberflächenbehandlung oberflächenfinish \
         finition finitions posttraitement acabado acabados finitura finiture afwerking nabewerking efterbehandling wykończenie \
         仕上げ 後加工 後処理 表面処理 表面处理 后处理 후처리 후가공",
    ),
];

/// Starts of header words for a due date, with whatever is said beside it: `Wunschtermin`, `Délai souhaité`.
const DUE_PARTS: &str =
    "termin duedate lieferdat deliverydate deliverby requiredby neededby needby délai datedelivraison 納期 納入日";
/// Words that may stand behind a word for copies; a price or a weight of a piece must not.
const COPIES_TAILS: &str = "required needed ordered requested total parts pieces pcs teile stück stk gesamt bestellt benötigt soll \
                            gewünscht demandée commandée souhaitée totale pièces 個";
/// Words that may stand behind a word for the file.
const FILE_TAILS: &str = "stl 3mf cad name stp";

type HeaderWords = HashMap<String, Vec<ListColumn>>;

/// The meaning of a header of several words, such as `Quantity required`, if the first is clear.
fn meaning_of_phrase(header: &str) -> Option<ListColumn> {
    let whole = normalize_word(header);
    let words: Vec<String> = header.split_whitespace().map(normalize_word).filter(|word| !word.is_empty()).collect();
    let are_tails = |tails: &str| {
        let tails: Vec<String> = tails.split_whitespace().map(normalize_word).collect();
        words.len() > 1 && words[1..].iter().all(|word| tails.contains(word))
    };
    match words.first().and_then(|first| CLEAR_WORDS.get(first)).and_then(|columns| columns.first()) {
        Some(ListColumn::Copies) if are_tails(COPIES_TAILS) => Some(ListColumn::Copies),
        Some(ListColumn::File) if are_tails(FILE_TAILS) => Some(ListColumn::File),
        _ => {
            let is_due = DUE_PARTS.split_whitespace().any(|part| whole.contains(&normalize_word(part)));
            is_due.then_some(ListColumn::Due)
        }
    }
}

/// The meaning of a label above the table of a list, if it is one that all rows may share.
pub(super) fn meaning_of_label(label: &str) -> Option<ListColumn> {
    let clear = CLEAR_WORDS.get(&normalize_word(label)).and_then(|columns| columns.first().copied());
    clear.or_else(|| meaning_of_phrase(label)).filter(|column| {
        use ListColumn as C;
        matches!(column, C::Due | C::Order | C::Customer | C::Email | C::Material | C::Priority)
    })
}

/// Headers of further numbers of pieces, of which nobody knows whether they are the ones to print.
const OTHER_COPIES: &str = "restmenge reststückzahl offenemenge mengeoffen mengegeliefert liefermenge rückstand \
                            remaining remainingqty qtyremaining remainingquantity quantityremaining openqty qtyopen openquantity \
                            outstanding qtyoutstanding backorder backordered balance quantityshipped quantitydelivered \
                            quantitérestante quantitélivrée reliquat cantidadpendiente cantidadentregada quantitàresidua 残数 残数量 納入数";

static CLEAR_WORDS: LazyLock<HeaderWords> = LazyLock::new(|| index_words(&CLEAR_HEADERS));
static AMBIGUOUS_WORDS: LazyLock<HeaderWords> = LazyLock::new(|| index_words(&AMBIGUOUS_HEADERS));

fn index_words(of: &[(ListColumn, &str)]) -> HeaderWords {
    let mut words = HeaderWords::new();
    for (column, list) in of {
        for word in list.split_whitespace() {
            let columns = words.entry(normalize_word(word)).or_default();
            if !columns.contains(column) {
                columns.push(*column);
            }
        }
    }
    words
}

/// Position of each column in a list.
#[derive(Debug, Default)]
pub(crate) struct ColumnLayout {
    positions: HashMap<ListColumn, usize>,
    /// Number of columns.
    pub count: usize,
    /// Headers that nestd does not know, as written, with their positions.
    unknown_at: Vec<(usize, String)>,
    /// All headers, as written.
    headers: Vec<String>,
    /// Further columns that may hold the files, each with its header, if the header does not tell.
    file_choices: Vec<(usize, String)>,
}

impl ColumnLayout {
    /// Recognises the columns of a header line. `Err` says why the line is not a header, or why it cannot be used.
    pub fn from_header<'a>(header: impl Iterator<Item = &'a str> + Clone) -> Result<Self, String> {
        let headers: Vec<String> = header.clone().map(|name| name.trim().to_owned()).collect();
        let mut columns = Self { count: headers.len(), headers, ..Self::default() };
        let mut open = Vec::new();
        for (at, name) in header.enumerate().filter(|(_, name)| !name.trim().is_empty()) {
            match CLEAR_WORDS.get(&normalize_word(name)).map(Vec::as_slice) {
                Some(&[column, ..]) if columns.positions.insert(column, at).is_some() => {
                    return Err(format!("it has two columns for {}", column.ticket_word()));
                }
                Some(_) => {}
                None => open.push((at, name)),
            }
        }
        // Of several phrases that mean the same, the first is taken, and the others are told as unknown.
        open.retain(|(at, name)| match meaning_of_phrase(name) {
            Some(column) if !columns.positions.contains_key(&column) => {
                columns.positions.insert(column, *at);
                false
            }
            _ => true,
        });
        for (column, _) in AMBIGUOUS_HEADERS {
            if columns.positions.contains_key(&column) {
                continue;
            }
            let may_be = |name: &str| {
                AMBIGUOUS_WORDS.get(&normalize_word(name)).is_some_and(|columns| columns.contains(&column))
            };
            if let Some(found) = open.iter().position(|(_, name)| may_be(name)) {
                let (at, name) = open.remove(found);
                columns.positions.insert(column, at);
                if column == ListColumn::File {
                    let others = open.iter().filter(|(_, name)| may_be(name));
                    let others = others.map(|(at, name)| (*at, name.trim().to_owned()));
                    columns.file_choices = std::iter::once((at, name.trim().to_owned())).chain(others).collect();
                }
            }
        }
        let is_other = |name: &str| {
            let word = normalize_word(name);
            OTHER_COPIES.split_whitespace().any(|other| normalize_word(other) == word)
        };
        if columns.positions.contains_key(&ListColumn::Copies) && open.iter().any(|(_, name)| is_other(name)) {
            return Err(format!("it has two columns for {}", ListColumn::Copies.ticket_word()));
        }
        columns.unknown_at = open.iter().map(|(at, name)| (*at, name.trim().to_owned())).collect();
        match columns.positions.contains_key(&ListColumn::File) {
            true => Ok(columns),
            false => Err(NO_HEADER.to_owned()),
        }
    }

    /// The columns of a list without a header: files and copies.
    pub fn without_header(file: usize, copies: usize) -> Self {
        let places = HashMap::from([(ListColumn::File, file), (ListColumn::Copies, copies)]);
        Self { positions: places, count: 2, ..Self::default() }
    }

    /// Takes as the column of the files the one in which most cells name the files that are there, or are names of files, if the header leaves a choice.
    pub fn choose_file_column(&mut self, count_names: impl Fn(usize) -> (usize, usize)) {
        let Some(&first) = self.positions.get(&ListColumn::File).filter(|_| self.file_choices.len() > 1) else {
            return;
        };
        // Of equals the first.
        let best = self.file_choices.iter().rev().max_by_key(|(at, _)| count_names(*at)).map_or(first, |(at, _)| *at);
        self.positions.insert(ListColumn::File, best);
        self.unknown_at.retain(|(at, _)| *at != best);
        self.unknown_at.extend(self.file_choices.iter().filter(|(at, _)| *at == first && first != best).cloned());
        self.unknown_at.sort();
    }

    /// Headers that nestd does not know, as written.
    pub fn unknown_headers(&self) -> Vec<String> {
        self.unknown_at.iter().map(|(_, name)| name.clone()).filter(|name| !is_state_header(name)).collect()
    }

    /// What a row says against itself in a column without another meaning, such as `status = cancelled`.
    pub fn objection(&self, record: &csv::StringRecord) -> Option<String> {
        let has_meaning = |at: usize| {
            self.positions.iter().any(|(column, &known)| known == at && !matches!(column, ListColumn::Note))
        };
        let header = |at: usize| self.headers.get(at).map_or("", String::as_str);
        let cells = record.iter().enumerate().filter(|(at, _)| !has_meaning(*at));
        let mut cells = cells.map(|(at, cell)| (header(at), bare_cell(cell)));
        cells.find(|(header, cell)| says_no(header, cell)).map(|(header, cell)| match header {
            "" => cell.to_owned(),
            _ => format!("{header} = {cell}"),
        })
    }

    /// Number of columns with a known meaning.
    pub fn known_count(&self) -> usize {
        self.positions.len()
    }

    /// Text of a row in a column; "" if there is none.
    pub fn cell_text<'a>(&self, record: &'a csv::StringRecord, column: ListColumn) -> &'a str {
        self.positions.get(&column).and_then(|&at| record.get(at)).map_or("", bare_cell)
    }
}

/// Error text for a list without a usable header.
pub(super) const NO_HEADER: &str = "none of its lines names its columns, at least file and copies; known are file, copies, due, \
                                    priority, orientation, order, unit, clearance, note, customer, material, and their words \
                                    in other languages";

#[cfg(test)]
mod tests {
    use super::*;

    fn known(header: &str) -> Vec<(&'static str, usize)> {
        let columns = ColumnLayout::from_header(header.split(';')).unwrap();
        let mut places: Vec<_> = columns.positions.iter().map(|(column, &at)| (column.ticket_word(), at)).collect();
        places.sort_by_key(|&(_, at)| at);
        places
    }

    #[test]
    fn of_two_columns_for_the_finish_the_first_is_taken() {
        let layout = ColumnLayout::from_header(["file", "qty", "Finish", "Post-processing"].into_iter()).unwrap();
        assert_eq!(layout.positions[&ListColumn::Finish], 2);
        assert_eq!(layout.unknown_at, [(3, "Post-processing".to_owned())]);
    }

    #[test]
    fn headers_are_understood_in_the_languages_of_customers() {
        for header in [
            "File;Copies;Due",
            "Dateiname;Stückzahl;Fällig am",
            "Datei;Menge (Stk.);Liefertermin",
            "Fichier;Quantité;Échéance",
            "Archivo;Cantidad;Fecha de entrega",
            "nome file;q.tà;scadenza",
            "Arquivo;Qtd.;Prazo",
            "ファイル;数量;納期",
            "ファイル名;個数;期限",
            "文件名;数量;交期",
            "Part No.;Qty;Due date",
            "Bestand;Aantal;Leverdatum",
            "Nom;Nombre;De\u{301}lai",
            "Nombre;Cantidad;Entrega",
        ] {
            assert_eq!(known(header), [("file", 0), ("copies", 1), ("due", 2)], "{header}");
        }
    }

    #[test]
    fn a_clear_word_wins_over_one_that_only_may_mean_it_and_the_rest_is_unknown() {
        let columns = ColumnLayout::from_header(["Name", "File", "Pieces", "Qty", "Preis"].into_iter()).unwrap();
        assert_eq!((columns.positions[&ListColumn::File], columns.positions[&ListColumn::Copies]), (1, 3));
        assert_eq!(columns.unknown_headers(), ["Name", "Pieces", "Preis"]);
    }

    #[test]
    fn two_columns_for_one_thing_and_none_for_the_file_are_no_header() {
        assert_eq!(
            ColumnLayout::from_header(["file", "copies", "qty"].into_iter()).unwrap_err(),
            "it has two columns for copies"
        );
        assert_eq!(ColumnLayout::from_header(["a.stl", "10"].into_iter()).unwrap_err(), NO_HEADER);
    }

    #[test]
    fn no_word_is_clear_for_two_things() {
        for (word, columns) in CLEAR_WORDS.iter() {
            assert_eq!(columns.len(), 1, "{word}: {columns:?}");
            assert!(!AMBIGUOUS_WORDS.contains_key(word), "{word}");
        }
    }
}
