//! The columns of an order list, under the words that people give them.

use std::{collections::HashMap, sync::LazyLock};

use unicode_normalization::{UnicodeNormalization, char::is_combining_mark};

/// What a column says of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Column {
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
    Material,
}

impl Column {
    /// The word of tickets.
    pub fn word(self) -> &'static str {
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
            Self::Material => "material",
        }
    }
}

/// Words that mean one thing, in the languages of customers; [`plain`] is applied to them.
const CLEAR: [(Column, &str); 11] = [
    (
        Column::File,
        "file filename path filepath datei dateiname dateipfad fichier nomdufichier nomfichier nomdefichier archivo \
         nombredearchivo nombredelarchivo fichero nombredefichero nomefile nomedelfile arquivo nomedoarquivo ficheiro bestand \
         bestandsnaam filnamn filnavn plik nazwapliku soubor nazevsouboru tiedosto dosya dosyaadi fajl файл имяфайла ファイル \
         ファイル名 文件 文件名 檔案 檔名 檔案名稱 파일 파일명 파일이름 stl stlfile stldatei",
    ),
    (
        Column::Copies,
        "copies copy quantity quantities qty count pcs kopien menge stück stückzahl stk anzahl anz quantité qté exemplaires \
         nbre cantidad cant unidades uds copias quantità qtà copie pezzi quantidade qtd qtde peças aantal stuks hoeveelheid \
         antal antall ilość sztuk szt množství počet kusů kpl määrä darab mennyiség adet miktar количество колво шт 数量 個数 \
         部数 數量 份数 件数 수량 개수",
    ),
    (
        Column::Due,
        "due duedate dueby deadline deliverydate deliveryby neededby needby fällig fälligam fälligkeit termin liefertermin \
         lieferdatum échéance datedelivraison délai fechadeentrega fechaentrega vencimiento scadenza datadiconsegna \
         dataconsegna prazo datadeentrega dataentrega leverdatum förfallodatum leveransdatum leveringsdato termindostawy termín \
         納期 期限 期日 締切 交期 截止日期 交货日期 납기 납기일 срок срокпоставки",
    ),
    (
        Column::Priority,
        "priority prio priorität priorité prioridad priorità prioridade prioriteit prioritet priorytet priorita 優先度 優先順位 \
         优先级 우선순위 приоритет",
    ),
    (
        Column::Orientation,
        "orientation orientierung ausrichtung orientación orientamento orientação oriëntatie orientering orientacja orientace \
         向き 摆放方向 방향 ориентация",
    ),
    (
        Column::Order,
        "order orderno ordernr ordernumber orderid orderref po pono ponumber job jobno jobnumber auftrag auftragsnummer \
         auftragsnr bestellung bestellnummer bestellnr commande numérodecommande ncommande pedido ordine encomenda bestelling \
         bestelnummer zamówienie objednávka tilaus sipariş 注文 注文番号 受注番号 订单 订单号 訂單 주문 주문번호 заказ",
    ),
    (
        Column::Unit,
        "unit einheit maßeinheit unité unidad unità unidade eenheid enhet enhed jednostka jednotka yksikkö 単位 单位 단위 единица",
    ),
    (
        Column::Clearance,
        "clearance clearancemm spacing abstand abstandmm espacement distanza separación afstand avstånd 間隔 间距 간격 зазор",
    ),
    (
        Column::Note,
        "note notes comment comments remark remarks bemerkung bemerkungen notiz notizen hinweis kommentar anmerkung remarque \
         remarques commentaire nota notas observaciones comentario osservazioni commento observação observações opmerking \
         opmerkingen uwagi poznámka 備考 メモ 备注 비고 примечание комментарий",
    ),
    (
        Column::Customer,
        "customer customername client kunde kundenname auftraggeber cliente klant kund klient zákazník asiakas 顧客 顧客名 客先 \
         客户 고객 клиент заказчик",
    ),
    (
        Column::Material,
        "material werkstoff matière matériau materiale materiaal materiál materiaali malzeme 材料 材質 材质 재료 소재 материал",
    ),
];

/// Words that may mean one thing where no clear word says it.
const PERHAPS: [(Column, &str); 3] = [
    (
        Column::File,
        "part partname partno partnumber name model item teil teilename bauteil bezeichnung modell pièce piece nom nombre pieza \
         pezzo nome parte peça onderdeel naam detalj del część díl osa parça деталь название 部品 部品名 品名 零件 零件名称 名称 부품 품명",
    ),
    (Column::Copies, "pieces pièces piezas amount units nombre numero número number nummer stücke ks db"),
    (Column::Due, "delivery livraison entrega consegna levering dostawa dodání"),
];

type Words = HashMap<String, Vec<Column>>;

static CLEAR_WORDS: LazyLock<Words> = LazyLock::new(|| words(&CLEAR));
static PERHAPS_WORDS: LazyLock<Words> = LazyLock::new(|| words(&PERHAPS));

fn words(of: &[(Column, &str)]) -> Words {
    let mut words = Words::new();
    for (column, list) in of {
        for word in list.split_whitespace() {
            let columns = words.entry(plain(word)).or_default();
            if !columns.contains(column) {
                columns.push(*column);
            }
        }
    }
    words
}

/// A header's word without accents, capitals, signs, and what stands in brackets behind it: `Stück (Stk.)` is `stuck`.
fn plain(word: &str) -> String {
    let head = word.split(['(', '[', '（']).next().filter(|head| !head.trim().is_empty()).unwrap_or(word);
    let letters = head.nfkd().filter(|&c| !is_combining_mark(c)).flat_map(char::to_lowercase);
    letters.filter(|c| c.is_alphanumeric()).collect::<String>().replace('ß', "ss")
}

/// Where each column stands in a list.
#[derive(Debug, Default)]
pub(super) struct Columns {
    places: HashMap<Column, usize>,
    /// How many there are.
    pub count: usize,
    /// Headers that mean nothing to nestd, as written.
    pub unknown: Vec<String>,
}

impl Columns {
    /// The columns of a header; `Err` says why it is none, or cannot be used.
    pub fn of<'a>(header: impl Iterator<Item = &'a str> + Clone) -> Result<Self, String> {
        let mut columns = Self { count: header.clone().count(), ..Self::default() };
        let mut open = Vec::new();
        for (at, name) in header.enumerate().filter(|(_, name)| !name.trim().is_empty()) {
            match CLEAR_WORDS.get(&plain(name)).map(Vec::as_slice) {
                Some(&[column, ..]) if columns.places.insert(column, at).is_some() => {
                    return Err(format!("it has two columns for {}", column.word()));
                }
                Some(_) => {}
                None => open.push((at, name)),
            }
        }
        for (column, _) in PERHAPS {
            if columns.places.contains_key(&column) {
                continue;
            }
            let may_be = |name: &str| PERHAPS_WORDS.get(&plain(name)).is_some_and(|columns| columns.contains(&column));
            if let Some(found) = open.iter().position(|(_, name)| may_be(name)) {
                columns.places.insert(column, open.remove(found).0);
            }
        }
        columns.unknown = open.iter().map(|(_, name)| name.trim().to_owned()).collect();
        match columns.places.contains_key(&Column::File) {
            true => Ok(columns),
            false => Err(NO_HEADER.to_owned()),
        }
    }

    /// The columns of a list without a header: files and copies.
    pub fn without_header(file: usize, copies: usize) -> Self {
        let places = HashMap::from([(Column::File, file), (Column::Copies, copies)]);
        Self { places, count: 2, unknown: Vec::new() }
    }

    /// How many columns mean something.
    pub fn known(&self) -> usize {
        self.places.len()
    }

    /// A row's cell of a column; "" where there is none.
    pub fn cell<'a>(&self, record: &'a csv::StringRecord, column: Column) -> &'a str {
        self.places.get(&column).and_then(|&at| record.get(at)).unwrap_or("")
    }
}

/// Why a list without a usable header is none.
pub(super) const NO_HEADER: &str = "none of its lines names its columns, at least file and copies; known are file, copies, due, \
                                    priority, orientation, order, unit, clearance, note, customer, material, and their words \
                                    in other languages";

#[cfg(test)]
mod tests {
    use super::*;

    fn known(header: &str) -> Vec<(&'static str, usize)> {
        let columns = Columns::of(header.split(';')).unwrap();
        let mut places: Vec<_> = columns.places.iter().map(|(column, &at)| (column.word(), at)).collect();
        places.sort_by_key(|&(_, at)| at);
        places
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
        let columns = Columns::of(["Name", "File", "Pieces", "Qty", "Preis"].into_iter()).unwrap();
        assert_eq!((columns.places[&Column::File], columns.places[&Column::Copies]), (1, 3));
        assert_eq!(columns.unknown, ["Name", "Pieces", "Preis"]);
    }

    #[test]
    fn two_columns_for_one_thing_and_none_for_the_file_are_no_header() {
        assert_eq!(Columns::of(["file", "copies", "qty"].into_iter()).unwrap_err(), "it has two columns for copies");
        assert_eq!(Columns::of(["a.stl", "10"].into_iter()).unwrap_err(), NO_HEADER);
    }

    #[test]
    fn no_word_is_clear_for_two_things() {
        for (word, columns) in CLEAR_WORDS.iter() {
            assert_eq!(columns.len(), 1, "{word}: {columns:?}");
            assert!(!PERHAPS_WORDS.contains_key(word), "{word}");
        }
    }
}
