### Sentences about tickets, order lists and names, as they are stored in English.

## What a part waits for

told-waits-because = { $name } wartet, denn { $why }
told-stands-beside = { $name } liegt neben { $why }
told-list-cannot-be-read = { $name } kann nicht gelesen werden: { $why }
told-list-not-understood = { $name } ist nicht verständlich: { $why }
told-list-not-understood-detail = { $name } ist nicht verständlich (Einzelheit auf Englisch: { $detail })
told-list-above-not-understood = { $name } in einem Ordner darüber ist nicht verständlich
told-list-above-names-it = { $name } in einem Ordner darüber nennt es, aber eine Liste gilt für die Dateien ihres eigenen Ordners
told-list-aside-names-it = { $name } in einem anderen Ordner des Auftrags nennt es, aber eine Liste gilt für die Dateien ihres eigenen Ordners und darunter
told-list-above-not-read = { $name } in einem Ordner darüber ist eine Liste, die nestd nicht liest
told-in-no-row = { $name } steht in keiner der { $rows } Zeilen von { $list }
told-below-in-no-row = { $name } steht in keiner der { $rows } Zeilen von { $list } in einem Ordner darüber
told-beside-list-not-understood = { $name } liegt neben { $list }, und diese Liste ist nicht verständlich: { $why }
told-beside-list-detail = { $name } liegt neben { $list }, und diese Liste ist nicht verständlich (Einzelheit auf Englisch: { $detail })
told-came-after-row = { $name } kam, nachdem seine Zeile in { $list } schon für ein früher angenommenes Teil dieses Namens galt
told-not-clear-in-list = { $name } ist in { $list } nicht eindeutig: { $why }
told-rows-add-up = { $rows } Zeilen sind für { $name }; sind alle gewünscht, sie zusammenzählen oder jeder einen eigenen Dateinamen oder Ordner geben, sonst eine stehen lassen
told-row-may-be-for = die Zeile { $row } kann für { $name } oder für { $other } sein; den ganzen Namen schreiben
told-row-folder = die Zeile { $row } kann für { $name } oder für { $other } sein; auch den Ordner schreiben, wie hier
told-ticket-not-read = { $name } wird nicht gelesen: ein Ticket heißt wie die ganze Teiledatei mit angehängtem .toml
told-ticket-for-several = { $name } kann für mehrere Teile sein: es wie die ganze Teiledatei mit angehängtem .toml nennen
told-list-which = { $name } ({ $why })
told-is-hidden = versteckt, deshalb liest nestd es nicht: den Punkt am Anfang des Namens entfernen oder es löschen
told-is-hard-link = ein harter Link (die Datei hat anderswo einen weiteren Namen), den nicht jeder lesen darf, deshalb liest nestd ihn nicht und druckt nicht danach: eine Kopie der Datei ablegen
told-hard-link = { $name } ist ein harter Link (die Datei hat anderswo einen weiteren Namen), den nicht jeder lesen darf, deshalb liest nestd ihn nicht und druckt nicht danach: eine Kopie der Datei ablegen
told-unreadable-list = { $name } ist unlesbar ({ $what }). Es mit den Teilen ablegen, die deshalb abgelehnt wurden.
told-is-no-file = { $what }, deshalb liest nestd es nicht: die Datei selbst an seine Stelle legen
told-a-symbolic-link = ein symbolischer Link
told-a-folder = ein Ordner
told-a-socket = ein Socket
told-a-named-pipe = eine benannte Pipe
told-a-device = ein Gerät
told-a-spreadsheet = eine Tabelle
told-a-foreign-list = eine Liste eines anderen Programms
told-a-document = ein Dokument
told-sheet-not-read = { $file } ({ $what }), was nestd nicht liest: als XLSX oder CSV speichern
told-document-not-read = { $file } ({ $what }), was nestd nicht liest: stattdessen die Dateien und ihre Anzahl in eine Liste schreiben (CSV oder XLSX)
told-one-list = { $names }: alle Zeilen in eine Liste schreiben

## What files wait, or came too late

told-ticket-names-missing = { $list } nennt { $names }, und diese Datei fehlt
told-ticket-names-missing-all = { $list } nennt { $names }, und diese Dateien fehlen
told-ticket-for-missing = { $ticket } ist für { $names }, und diese Datei fehlt
told-ticket-for-missing-all = { $ticket } ist für { $names }, und diese Dateien fehlen
told-list-names-refused = { $list } nennt { $names }, und diese Datei wurde abgelehnt: sie erneut ablegen
told-list-names-refused-all = { $list } nennt { $names }, und diese Dateien wurden abgelehnt: sie erneut ablegen
told-list-names-in-build = { $list } nennt { $names }, und dieses Teil ist schon in einem Baujob: soll keine weitere Datei dieses Namens gedruckt werden, die Angabe hier entfernen (`nestd edit` bestellt weitere Stück)
told-list-names-in-builds = { $list } nennt { $names }, und diese Teile sind schon in Baujobs: sollen keine weiteren Dateien dieser Namen gedruckt werden, die Angaben hier entfernen (`nestd edit` bestellt weitere Stück)
told-late-several = Es kam, nachdem sein Teil angenommen war, und kann mehrere Teile meinen: { $others }. Das gemeinte mit `nestd edit PART` ändern.
told-late-too-late = Es kam zu spät: { $name } ist mit { $n } Stück in Baujob { $build }. { $remedy }
told-late-published = Es kam zu spät: { $name } ist mit { $n } Stück in Baujob { $build }, ausgegeben { $time }. { $remedy }
told-late-order-more = { $more } weitere mit `nestd edit { $part } --copies { $wanted }` bestellen.
told-late-fewer = Es verlangt weniger: solange der Bauauftrag in der Warteschlange liegt, holt `nestd withdraw { $build }` ihn zurück, und dann ändert ihn `nestd edit { $part } --copies { $wanted }`.
told-late-drop-both = Was abweicht, kann neu bestellt werden: { $name } zusammen mit diesem Ticket ablegen, dann wird es noch einmal gedruckt.
told-late-refused = Es kam, nachdem sein Teil angenommen war: { $why }
told-late-no-date = Sein Termin ist hier keiner ({ $detail })

## Why a ticket or a list cannot be used

told-ticket-broken = das Ticket { $file } kann nicht gelesen werden: { $why }
told-ticket-broken-detail = das Ticket { $file } kann nicht gelesen werden (Einzelheit auf Englisch: { $detail })
told-two-tickets = es gibt zwei Tickets für ein Teil, { $first } und { $second }; eines liegen lassen
told-unchanged-for = { $why }, und das blieb { $secs } s lang so
told-copies-unknown-list = { $why }. Was damit bestellt wird, ist nicht sicher, deshalb wird es nicht gedruckt: es mit einer Liste, die eine Zeile dafür hat, oder mit eigenem Ticket erneut ablegen.
told-copies-unknown-ticket = { $why }. Was damit bestellt wird, ist nicht sicher, deshalb wird es nicht gedruckt: das Ticket berichtigen und beide erneut ablegen.
told-blocked-by-file = Daneben lag eine Datei, die vielleicht sagt, wie es gewünscht ist: { $why }. Das blieb { $secs } s lang so, deshalb wurde { $name } nicht ohne sie angenommen. Diese Datei berichtigen und beide erneut ablegen; sagt sie nichts zu dem Teil, es allein ablegen.
told-list-unreadable = Diese Auftragsliste kann nicht gelesen werden: { $why }. Sie berichtigen und mit ihren Dateien erneut ablegen.
told-list-no-files = Diese Auftragsliste nennt keine Dateien.
told-list-missing-files = Für { $missing } von { $rows } Zeilen dieser Auftragsliste kam in { $secs } s keine Datei: { $names }.
told-other-rows-served = Die anderen Zeilen sind erledigt.
told-list-drop-missing = Diese Dateien mit einer Liste für sie ablegen.
told-list-drop-into-order = Diese Dateien in { $order } ablegen: Jede wird genommen, wie ihre Zeile sagt.
told-file-never-came = { $list } nennt diese Datei, die nicht gekommen ist.
told-drop-missing-file = In den Ordner ihres Auftrags ablegen: Sie wird genommen, wie { $list } sagt.
told-place-taken = Teil { $part } gleichen Namens ist an seine Stelle getreten.
told-cancel-missing-file = Wo sie nicht gebraucht wird, nimmt `nestd cancel` mit der Nummer dieses Teils sie heraus.
told-file-and-row-missing = { $list } nennt diese Datei, die nicht gekommen ist, und ihre Zeile ist nicht zu gebrauchen: { $why }.
told-drop-with-copies = Die Datei mit einer Liste ablegen, die sagt, wie viele Kopien gebraucht werden.
told-ticket-without-part = Das ist ein Ticket für ein Teil { $name }, aber { $why }. Teil und Ticket zusammen ablegen; das Ticket heißt wie die ganze Teiledatei mit angehängtem .toml oder .json.
told-no-such-part-came = in { $secs } s kam kein solches Teil
told-several-parts-called = mehrere Teile hießen { $name }, deshalb galt es für keines
told-file-with-permissions = nestd kann diese Datei nicht lesen: { $why }. Sie mit Rechten erneut ablegen, mit denen nestd sie lesen darf.
told-this-is-symlink = Das ist ein symbolischer Link; nestd folgt Links nicht. Die Datei selbst ablegen.
told-this-is-folder = Das ist ein Ordner mit dem Namen eines Teils, Tickets oder einer Auftragsliste, oder er liegt zu tief. Ein Ordner ist ein Auftrag: ihm einen anderen Namen geben und ihn direkt in den Eingangsordner legen.
told-this-is-socket = Das ist ein Socket, keine Datei. Die Datei des Teils ablegen.
told-this-is-pipe = Das ist eine benannte Pipe, keine Datei. Die Datei des Teils ablegen.
told-this-is-device = Das ist ein Gerät, keine Datei. Die Datei des Teils ablegen.
told-one-order-list = Ein Ordner hat eine Auftragsliste, in diesem waren aber { $names }: alle Zeilen in eine Liste schreiben. Diese Liste mit den abgelehnten Teilen ablegen.
told-this-is-not-read = Das liest nestd nicht ({ $what }). Als XLSX oder CSV speichern und mit den Teilen ablegen.
told-this-is-document = Dieses Dokument kann sagen, wie viele gewünscht sind, und nestd liest es nicht. Die Dateien und ihre Anzahl in eine Liste schreiben (CSV oder XLSX) und diese mit den Teilen ablegen.
told-this-is-surplus = Das liest nestd nicht ({ $what }); für die Teile daneben gilt { $list }. Es ist nichts zu tun, außer es sagt etwas anderes: dann es unter diesem Namen als CSV speichern.
told-workbook-beside-list = Das ist eine Arbeitsmappe neben der Liste { $list }, die für die Teile gilt. Es ist nichts zu tun, außer die Mappe sagt etwas anderes: dann eine der beiden ablegen.
told-second-order-csv = Dieser Ordner hat eine weitere order.csv in anderer Groß- oder Kleinschreibung. Alle Zeilen in eine Liste schreiben.
told-control-in-order = { $name } heißt wie eine Steuerdatei, liegt aber in einem Auftragsordner. Eine Steuerdatei gilt für die ganze Maschine: eine leere Datei { $file } direkt in den Eingangsordner legen.
told-control-not-empty = { $name } heißt wie eine Steuerdatei, ist aber nicht leer ({ $bytes } Bytes), deshalb geschah nichts. Eine leere Datei dieses Namens in den Eingangsordner legen.
told-longer-than = es ist länger als { $bytes } Bytes
told-no-utf8 = es ist kein Text in UTF-8
told-copies-range = copies = { $copies }; erlaubt ist 1 bis { $most }
told-priority-range = priority = { $priority }; erlaubt ist 0 bis { $most }
told-clearance-range = clearance_mm = { $clearance }; erlaubt ist 0 bis { $most }
told-whole-number = { $word } = { $value }; es muss eine ganze Zahl wie 10 sein
told-a-number = { $word } = { $value }; es muss eine Zahl wie 2.5 sein
told-no-quotes = { $word } = { $value } ist Text; es ohne Anführungszeichen schreiben: { $word } = { $number }
told-number-without-quotes = { $word } = { $value }; es muss eine Zahl ohne Anführungszeichen sein, wie 10
told-date-format = due = { $value }; es muss ein Datum wie 2026-11-25 oder ein Zeitpunkt wie 2026-11-25T17:00:00Z sein
told-date-years = due = { $value }; es muss ein Datum wie 2026-11-25 oder ein Zeitpunkt wie 2026-11-25T17:00:00Z sein, in den Jahren { $first } bis { $last }
told-no-whole-number = { $word } = { $value } ist keine ganze Zahl
told-no-number = { $word } = { $value } ist keine Zahl
told-unit-word = unit = { $value }; erlaubt sind micron, mm, cm, inch, foot und m
told-date-of-list = due = { $value }; es muss ein Datum wie 2026-11-25 oder 25.11.2026 sein, auch mit Uhrzeit wie 17:00
told-two-dates = due = { $value } kann zweierlei heißen; es als 2026-11-25 schreiben
told-row-of = in der Zeile von { $name }: { $why }
told-row-of-detail = in der Zeile von { $name } (Einzelheit auf Englisch: { $detail })
told-row-cells = sie hat { $cells } Zellen für { $columns } Spalten
told-row-path = sie nennt einen Pfad; eine Liste gilt für die Dateien ihres eigenen Ordners
told-row-empty = ihre Zeile ist leer
told-sheets-empty = ihre Blätter sind leer
told-two-columns = sie hat zwei Spalten für { $column }
told-no-columns = keine ihrer Zeilen nennt die Spalten, mindestens file und copies; bekannt sind { $columns } und deren Wörter in anderen Sprachen
told-workbook-locked = sie hat ein Passwort oder ist von alter Art; sie ohne Passwort als XLSX oder als CSV speichern
told-workbook-damaged = als Arbeitsmappe ist sie beschädigt ({ $detail })
told-list-cannot-be-split = die Liste lässt sich nicht in Zeilen teilen; sie neu als UTF-8 speichern, mit Kopfzeile und Kommas

## Warnings and questions about a part

told-taken-without-list = Es wurde ohne seine Auftragsliste angenommen: { $why }.
told-column-ignored = Die Spalte { $name } seiner Auftragsliste kennt nestd nicht; sie wurde ignoriert.
told-columns-ignored = Die Spalten { $names } seiner Auftragsliste kennt nestd nicht; sie wurden ignoriert.
told-line-above-not-read = Die Zeile { $line } über der Tabelle seiner Auftragsliste wurde nicht gelesen.
told-priorities-low = Die höchste Priorität seiner Auftragsliste ist { $priority }, von 100 für das dringendste Teil: das ist weniger als die 50 eines Teils ohne Priorität. Das Teil mit `nestd edit PART --priority N` ändern, wo es dringender ist.
told-copies-question = Wie viele Stück? Als 1 Stück angenommen, denn { $why }. Ein Ticket mit `copies = N` sagt es.
told-copies-taken = Als 1 Stück angenommen, denn { $why }. Ein Ticket mit `copies = N` sagt es.
told-print-question = Soll es gedruckt werden? Es wartet auf Freigabe, denn { $why }.
told-row-without-copies = seine Zeile in { $list } nennt keine Stückzahl
told-in-folder-called = es liegt in einem Ordner namens { $name }
told-name-says = sein Name sagt { $words }
told-row-says = seine Zeile in { $list } sagt { $words }
told-name-unclear = sein Name sagt { $words }, und das ist keine klare Stückzahl von 1 bis { $most }
told-name-many = sein Name sagt { $words }, und das ist mehr, als ein Name allein bestellen darf
told-name-no-utf8 = sein Name ist kein Text in UTF-8, eine Zahl darin ist also nicht lesbar
told-name-of-part = { $file } (Teil { $part })
told-sync-conflict-part = sein Name sagt, dass ein Abgleichprogramm zwei Fassungen von { $who } fand
told-sync-conflict = sein Name sagt, dass ein Abgleichprogramm zwei Fassungen von { $name } fand
told-name-of-backup-part = sein Name ist der einer Sicherung von { $who }
told-name-of-backup = sein Name ist der einer Sicherung von { $name }
told-name-of-copy-part = sein Name ist der einer Kopie von { $who }
told-name-of-copy = sein Name ist der einer Kopie von { $name }
told-copy-came-first-part = { $who } heißt wie eine Kopie davon
told-copy-came-first = { $name } heißt wie eine Kopie davon
told-other-format-part = es kann { $who } in einem anderen Format sein
told-other-format = es kann { $name } in einem anderen Format sein
told-put-back-by-sync = es hat Ordner, Namen, Bytes und Zeit von Teil { $part }; vielleicht hat ein Abgleichprogramm zurückgelegt, was schon angenommen war
told-took-place = es trat an die Stelle der Teile { $names }, und nichts sagt, wie viele davon gewünscht sind
told-moved-namesake = Teil { $part } dieses Namens in seinem Auftrag wurde zu { $machine } verschoben, und dies ist vielleicht eine neuere Fassung
told-same-file-other-unit = Dieselbe Datei wie Teil { $part }, aber in einer anderen Einheit: es ist ein Teil anderer Größe.
told-same-file-more = Dieselbe Datei wie Teil { $part }: als weitere Stück angenommen.
told-same-file-refused = Es ist dieselbe Datei wie Teil { $part }, und diese Maschine nimmt keine Datei zweimal an. Sind weitere Stück gemeint, im Profil { $machine } duplicates = "warn" setzen, nestd neu laden und es zurückholen.
told-written-later = In diese Datei wurde nach der Annahme weitergeschrieben, deshalb wurde sie noch einmal ganz angenommen. Das zuerst Angenommene ist ein früheres Teil gleichen Namens: sind beide da, jenes stornieren.
