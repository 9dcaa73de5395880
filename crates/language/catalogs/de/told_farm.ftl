### Sentences of the farm, as they are stored in English: details of alerts, builds that failed, events, answers to commands.

## Errors of the operating system

told-os-gone = Datei oder Ordner fehlt (Fehler 2)
told-os-io = Ein- oder Ausgabefehler (Fehler 5)
told-os-denied = keine Berechtigung (Fehler 13)
told-os-exists = die Datei gibt es schon (Fehler 17)
told-os-other-device = anderes Dateisystem (Fehler 18)
told-os-no-directory = kein Ordner (Fehler 20)
told-os-is-directory = es ist ein Ordner (Fehler 21)
told-os-full = kein Platz auf dem Laufwerk (Fehler 28)
told-os-read-only = Dateisystem nur lesbar (Fehler 30)
told-os-not-connected = nicht verbunden (Fehler 107)
told-os-timed-out = Zeitüberschreitung der Verbindung (Fehler 110)
told-os-host-down = der Rechner ist nicht erreichbar (Fehler 112)
told-os-stale = veralteter Dateizugriff (Fehler 116)
told-os-quota = Speicherkontingent erschöpft (Fehler 122)
told-os-other = Fehler { $number } des Betriebssystems ({ $error })

## Folders

told-reading-path = Lesen von { $path }: { $why }
told-listing-path = Auflisten von { $path }: { $why }
told-creating-path = Anlegen von { $path }: { $why }
told-cannot-write = { $path } kann nicht geschrieben werden: { $why }
told-cannot-be-used = { $path } ist nicht nutzbar: { $why }
told-queue-unavailable = der Warteschlangenordner { $path } ist nicht verfügbar: { $why }
told-inbox-unavailable = der Eingangsordner { $path } ist nicht verfügbar: { $why }
told-queue-not-available = der Warteschlangenordner ist nicht mehr verfügbar
told-it-is-not-there = er ist nicht da
told-it-is-no-folder = er ist kein Ordner
told-it-cannot-be-listed = sein Inhalt kann nicht aufgelistet werden
told-marker-empty = die Marke .nestd-queue ist leer
told-other-file-system = er liegt auf einem anderen Dateisystem als beim ersten Mal; ihn wieder einhängen oder nestd neu starten
told-file-system-changed = sein Dateisystem wechselte während des Auflistens
told-served-by-other = { $path } wird von einem anderen nestd bedient: Prozess { $pid } auf { $host } seit { $since }, mit dem state-Ordner { $state }. Diesen anhalten oder jeder Farm eigene Ordner geben
told-folder-replaced = { $path } ist nicht der Ordner, der vorher da war: die Marke { $marker } fehlt. Ihn wieder einhängen; wurde er mit Absicht ersetzt oder geleert: touch { $file }
told-holds-more-files = { $path }: enthält mehr als { $most } Dateien; der Rest wartet
told-other-file-system-inside = { $path }: ist ein anderes Dateisystem; von dort können keine Teile angenommen werden
told-recycle-bin = { $path }: ist dem Namen nach ein Papierkorb, deshalb wird nichts darin gedruckt
told-folder-denied = { $path }: kann nicht gelesen werden: keine Berechtigung
told-cannot-be-read-path = { $path } kann nicht gelesen werden
told-file-damaged-hash = { $path } ist beschädigt: der Inhalt passt nicht zur Prüfsumme

## Details of alerts

told-and-more = { $why }; und { $more } weitere
told-and-more-comma = { $why }, und { $more } weitere
told-and-more-parts = { $why } und { $more } weitere
told-files-in =
    { $n ->
        [one] { $n } Datei (Ordner: { $path })
       *[other] { $n } Dateien (Ordner: { $path })
    }
told-files-beside = { $name } (Ordner: { $path })
told-files-beside-more = { $name } und { $more } weitere (Ordner: { $path })
told-in-claimed = { $files } in seinem Ordner .claimed
told-part-named = Teil { $part } ({ $file })
told-part-asks = Teil { $part } ({ $file }): { $why }
told-build-named = Baujob { $build }
told-build-why = Baujob { $build }: { $why }
told-release-brief = { $n } Stück, { $height } von { $limit } mm hoch, Packdichte { $density } %, etwa { $hours } h Druck
told-node-serves-it = der Knoten { $node } bedient sie
told-node-is-gone = ihr Knoten { $node } läuft nicht
told-node-with-machines = { $node } auf { $host }, mit { $names }
told-gone-with-work =
    { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teile
    } und { $builds ->
        [one] { $builds } Baujob
       *[other] { $builds } Baujobs
    } in Arbeit
told-gone-with-lines =
    { $why }, und { $n ->
        [one] { $n } per Anfrage bestellte Position
       *[other] { $n } per Anfrage bestellte Positionen
    }
told-ended-during-search-more = nestd endete { $times } Mal während einer Suche für Baujob { $build }: die nächste Suche beginnt { $secs } s nach einem Start. Seine Teile sind { $names } und { $more } weitere; `nestd cancel PART` nimmt eines heraus
told-ended-during-search = nestd endete { $times } Mal während einer Suche für Baujob { $build }: die nächste Suche beginnt { $secs } s nach einem Start. Seine Teile sind { $names }; `nestd cancel PART` nimmt eines heraus
told-printer-configured-no-more = der Drucker { $printer } ist nicht mehr konfiguriert, und { $file } liegt vielleicht in seinem Warteschlangenordner, als Baujob { $build }
told-step-obeying = Ausführen einer Steuerdatei
told-step-recording-drop = Eintragen einer Annahme
told-step-recording-refusal = Eintragen einer Ablehnung
told-step-late-ticket = Anwenden eines späten Tickets
told-step-originals = Holen der Originale
told-step-command = Befehl { $number }

## Files in a queue

told-queue-other-machine = { $file } ist Baujob { $build } von { $machine }: es in eine Warteschlange von { $machine } bringen
told-queue-not-proved = { $file } ist nicht die Datei, die als Baujob { $build } geprüft wurde: sie herausnehmen, nachsehen, ob sie gedruckt wurde, und das Ergebnis von Baujob { $build } melden
told-queue-does-not-fit = { $file } passt nicht ({ $detail }). `nestd withdraw { $build }` nimmt sie heraus, und ihre Stücke werden für die Maschine gepackt, wie sie jetzt ist
told-queue-second-on-way = { $file } ist eine zweite Datei von Baujob { $build }, der gerade aus einer Warteschlange genommen wird: sie herausnehmen
told-queue-second-lies-at = { $file } ist eine zweite Datei von Baujob { $build }, der bei { $printer } liegt: sie herausnehmen
told-queue-second-taken-out = { $file } ist eine zweite Datei von Baujob { $build }, der aus der Warteschlange von { $printer } genommen wurde: wird jene gedruckt, diese herausnehmen; wurde sie nur verschoben, `nestd dismiss b{ $build }`
told-queue-failed-file = { $file } ist die Datei von Baujob { $build } ({ $what }): sie herausnehmen, sonst werden ihre Stücke ein zweites Mal gedruckt
told-queue-failed-complete = { $file } ist die Datei von Baujob { $build } ({ $what }): sie herausnehmen, sonst werden ihre Stücke ein zweites Mal gedruckt; wurde sie doch gedruckt, meldet das `nestd outcome { $build } complete --correct`
told-queue-failed-withdrawn = { $file } ist die Datei von Baujob { $build } ({ $what }): sie herausnehmen, sonst werden ihre Stücke ein zweites Mal gedruckt; wurde sie doch gedruckt, ebenso viele der wartenden mit `nestd cancel PART=N` herausnehmen (`nestd show b{ $build }` zeigt die Teile)
told-queue-was-out-before = { $file } ist die Datei von Baujob { $build } ({ $what }), die schon einmal aus der Warteschlange war: sie herausnehmen
told-word-printing = im Druck
told-word-complete = vollständig
told-word-interrupted = unterbrochen
told-word-failed = fehlgeschlagen
told-word-withdrawn = zurückgenommen
told-word-published = ausgegeben

## Builds that failed or went back

told-build-gave-up =
    Baujob { $build } nach { $n ->
        [one] { $n } Fehlversuch
       *[other] { $n } Fehlversuchen
    } aufgegeben: { $why }
told-build-gave-up-detail =
    Baujob { $build } nach { $n ->
        [one] { $n } Fehlversuch
       *[other] { $n } Fehlversuchen
    } aufgegeben (Einzelheit auf Englisch: { $detail })
told-gave-up =
    nach { $n ->
        [one] { $n } Fehlversuch
       *[other] { $n } Fehlversuchen
    } aufgegeben: { $why }
told-gave-up-detail =
    nach { $n ->
        [one] { $n } Fehlversuch
       *[other] { $n } Fehlversuchen
    } aufgegeben (Einzelheit auf Englisch: { $detail })
told-build-gave-up-stopped = Baujob { $build } nach { $attempts } Versuchen aufgegeben: nestd endete jedes Mal
told-gave-up-stopped = nach { $attempts } Versuchen aufgegeben: nestd endete jedes Mal
told-build-given-up = Baujob { $build } ist aufgegeben: { $why }
told-is-given-up = aufgegeben: { $why }
told-is-given-up-detail = aufgegeben (Einzelheit auf Englisch: { $detail })
told-no-copy-has-place = keines seiner Stücke hat in der Maschine Platz, wie sie jetzt ist
told-no-copy-left = keines seiner Stücke ist mehr darin
told-the-build-failed = der Baujob ist fehlgeschlagen
told-build-the-build-failed = Baujob { $build } ist fehlgeschlagen
told-proving = Prüfen des geschriebenen Baujobs: { $why }
told-not-proved = der geschriebene Baujob ist nicht nachgewiesen ({ $detail })
told-panicked = Absturz ({ $detail })
told-search-stopped = seine Suche wurde nach { $secs } s angehalten und geht von dem aus weiter, was sie gefunden hat
told-withdrawn-by = aus der Warteschlange zurückgenommen von { $by }
told-withdrawn-why = aus der Warteschlange zurückgenommen von { $by }: { $reason }
told-withdrawn-record = unberührt aus der Warteschlange zurückgenommen, wie sein Eintrag im Archiv sagt
told-put-back-from-backup = die Datenbank wurde aus einer Sicherung zurückgespielt
told-urgent-goes-with-it = Stücke höchster Priorität kommen mit
told-arrived-goes-with-it = neu angekommene Stücke kommen mit
told-printer-is-down = der Drucker { $printer } ist außer Betrieb
told-made-again = neu erstellt: { $why }
told-machine-changed = die Maschine hat sich seit der Prüfung geändert ({ $detail })
told-staged-removed = seine bereitgelegte Datei wurde entfernt
told-staged-other = seine bereitgelegte Datei ist nicht die geprüfte

## Copies that are not in the next build

told-left-open-build =
    { $n ->
        [one] { $n } Stück von { $who } hat
       *[other] { $n } Stück von { $who } haben
    } den offenen Baujob verlassen, zugunsten von { $others }. { $what } für den nächsten an erster Stelle.
told-left-open-build-alone =
    { $n ->
        [one] { $n } Stück von { $who } hat
       *[other] { $n } Stück von { $who } haben
    } den offenen Baujob verlassen. { $what } für den nächsten an erster Stelle.
told-cannot-be-in-next =
    { $n ->
        [one] { $n } Stück von { $who } kann
       *[other] { $n } Stück von { $who } können
    } nicht in den nächsten Baujob: { $why }. { $what } für den übernächsten an erster Stelle.
told-name-priority = { $file } (Teil { $part }, Priorität { $priority })
told-other-parts =
    { $others } und { $n ->
        [one] { $n } weiteren Teil
       *[other] { $n } weiteren Teilen
    }
told-it-is = Es ist
told-they-are = Sie sind
told-no-room-beside = neben { $others }, das vorgeht, ist kein Platz
told-no-room-beside-copies = neben seinen anderen Stücken ist kein Platz
told-no-place-found = im leeren Bauraum wurde kein Platz dafür gefunden
told-whole-volume-first = was vorgeht, füllt den ganzen Baujob

## Refusals that people or orders caused

told-cancelled-by = Storniert von { $by }.
told-line-cancelled = Seine Position wurde vor der Annahme storniert.
told-newer-revision = Eine neuere Fassung gleichen Namens, Teil { $part }, kam, während dieses wartete, und trat an seine Stelle. Sind beide gewünscht, dieses zurückholen.
told-newer-revision-order = Eine neuere Fassung gleichen Namens, Teil { $part }, kam für den Auftrag { $order }, während dieses wartete, und trat an seine Stelle. Sind beide gewünscht, dieses zurückholen.
told-after-the-backup = Es liegt im Fehlerordner: es wurde nach der Sicherung abgelehnt oder storniert.
told-maybe-printed = Eine Datei in der Warteschlange enthält dieselbe Datei, es ist also vielleicht schon gedruckt.
told-taken-over-by-other = Ein anderer nestd hat diese Datei übernommen, während dieser nicht antwortete, und druckt sie.
told-no-reason = es wurde kein Grund genannt

## What happened: parts and orders

told-trigger-flush = von Hand
told-trigger-full = voll
told-trigger-fill = Füllung
told-trigger-copies = Stückzahl
told-trigger-max-wait = Wartezeit
told-trigger-due = Termin
told-trigger-at = Uhrzeit
told-ledger-query-failed = eine Abfrage der Datenbank ist fehlgeschlagen ({ $detail })
told-step-taking-in = Übernehmen eines Ergebnisses
told-step-new-configuration = Übernehmen der neuen Konfiguration (vorher gilt nichts davon)
told-process-named = Prozess { $pid } ({ $name })
told-another-process = ein anderer Prozess
told-put-back-in-time = sie wurde in ihrer Datei auf einen früheren Stand gebracht: sie zählt { $count } Änderungen, und dieser nestd hat { $seen } gesehen
told-record-of-build = laut dem Eintrag eines Baujobs
told-imported-record = aus seinem Eintrag im Archiv übernommen
told-imported-from-build = aus dem Eintrag eines Baujobs übernommen
told-replaces-part-all = es ersetzt Teil { $old }, eine frühere Fassung, mit allem, was damit verlangt war
told-replaces-refused = es ersetzt Teil { $old }, das abgelehnt wurde
told-replaces-refused-all = es ersetzt Teil { $old }, das abgelehnt wurde, mit allem, was damit verlangt war
told-replaces-refused-terms = es ersetzt Teil { $old }, das abgelehnt wurde, mit allem, was damit verlangt war, außer der Stückzahl
told-replaces-part-terms = es ersetzt Teil { $old }, einen früheren Stand, mit allem, was damit verlangt war, außer der Stückzahl
told-replaces-part-date = es ersetzt Teil { $old }, eine frühere Fassung, mit deren Termin und Notiz
told-more-wanted-record = { $more } mehr gewünscht, laut dem Eintrag eines Baujobs
told-published-after-backup = sein Baujob wurde nach der Sicherung ausgegeben
told-decided-since = Es wurde nach der Sicherung abgelehnt, storniert, zurückgeholt oder geändert.
told-decided-since-wanted = Es wurde nach der Sicherung abgelehnt, storniert, zurückgeholt oder geändert, und damals waren { $copies } Stück gewünscht.
told-decided-since-one = Es wurde nach der Sicherung abgelehnt, storniert, zurückgeholt oder geändert, und damals war 1 Stück gewünscht.
told-out-of-queue-said = nicht mehr in der Warteschlange, wie { $by } meldete
told-once-more-asked = Baujob { $build } noch einmal, verlangt von { $by }
told-requeue-word = noch einmal ausgegeben
told-same-dropped-again = dieselbe Datei wurde erneut abgelegt
told-taken-back = zurückgeholt
told-taken-back-mend = zurückgenommen; { $name } sagt, dass sein Netz ausgebessert werden darf
told-other-mending = sein Netz wird jetzt nicht so ausgebessert wie beim ersten Einlesen. `nestd confirm { $part }` lässt es neu einlesen und ausbessern.
told-told-at-break-out = beim Auspacken gemeldet
told-no-copy-waits-any-more = kein Stück wartet mehr
told-file-not-needed = seine Datei wird nicht mehr gebraucht
told-by-whom = von { $by }
told-has-seen-to-it = { $by } hat sich darum gekümmert
told-copies-instead = { $n } Stück statt { $before }
told-as-it-was-taken = { $n } Stück, wie angenommen
told-more-wanted-by = { $more } mehr gewünscht von { $by }
told-fewer-wanted-by = { $fewer } weniger gewünscht von { $by }
told-order-instead = Auftrag { $new } statt { $old }
told-customer-instead = Kunde { $new } statt { $old }
told-priority-instead = Priorität { $new } statt { $old }
told-due-instead = Termin { $new } statt { $old }
told-note-instead = Notiz { $new } statt { $old }
told-unit-instead = Einheit { $new } statt { $old }
told-moved-from-to = von { $from } nach { $to }
told-replaces-part = es ersetzt Teil { $old }, eine frühere Fassung
told-part-took-its-place = Teil { $new } gleichen Namens trat an seine Stelle
told-clock-set = um { $jump }; das Alter der Teile bleibt
told-put-back-from-build = { $n } Stück aus Baujob { $build } zurückgelegt von { $by }
told-not-wanted-again = { $n } Stück von Baujob { $build } nicht noch einmal gewünscht, wie { $by } meldete
told-printed-well-after-all = ein Stück in Baujob { $build } war doch gut gedruckt
told-not-taken-printer-first = nicht zurückgenommen: sein Drucker hat die Datei vorher abgeholt
told-not-taken-not-proved = nicht zurückgenommen: was in der Warteschlange liegt, ist nicht die geprüfte Datei
told-not-taken-second = nicht zurückgenommen: seine Stücke liegen in der Warteschlange als { $places }
told-back-in-queue-of = wieder in der Warteschlange von { $printer }
told-lies-in-queue-again = seine Datei liegt wieder in der Warteschlange von { $printer }
told-closed-order = { $by }: Auftrag { $name } { $what }
told-closed-with = mit { $accepted } von { $n } Stück abgeschlossen
told-closed-without-it = { $by }: sein Auftrag wurde ohne es abgeschlossen
told-step-done = { $by }: { $name } ist getan
told-step-not-done = { $by }: { $name } ist nicht getan
told-steps-open-again = weitere Stücke werden hergestellt: die Nachbearbeitung ist wieder offen

## Answers to what people say on pages

told-is-being-nested = Baujob { $build } wird mit { $n } Stück gepackt
told-nothing-waits-in = in { $machine } wartet nichts
told-is-paused = { $machine } ist pausiert
told-was-paused-already = { $machine } war schon pausiert
told-runs-again = { $machine } läuft wieder
told-was-not-paused = { $machine } war nicht pausiert
told-resume-first = { $machine } ist pausiert; sie zuerst fortsetzen
told-no-printer-in-use = kein Drucker von { $machine } ist in Betrieb; `nestd printer { $printer } up` nimmt einen wieder in Betrieb
told-copies-cancelled = { $n } Stück von Teil { $part } storniert
told-has-values-already = Teil { $part } hat diese Werte schon
told-part-changed = Teil { $part }: { $why }
told-part-moved = Teil { $part } nach { $machine } verschoben und dort neu eingelesen
told-parts-moved = Teile { $parts } nach { $machine } verschoben und dort neu eingelesen
told-part-is-for = Teil { $part } ist schon für { $machine }
told-printed-as-it-is = Teil { $part } wird so gedruckt
told-no-confirmation = Teil { $part } wartet auf keine Freigabe
told-part-mended = Teil { $part } wird neu eingelesen und sein Netz ausgebessert
told-nothing-to-mend = Teil { $part } wurde nicht wegen seines Netzes abgewiesen: `nestd retry { $part }` liest es neu ein, wie es ist
told-is-read-again = Teil { $part } wird neu eingelesen
told-part-is-cancelled = Teil { $part } ist storniert
told-no-such-part = es gibt kein Teil { $part }
told-no-such-machine = es gibt keine Maschine { $machine }
told-no-such-build = es gibt keinen Baujob { $build }
told-waits-for-its-file = Teil { $part } wartet auf seine Datei: sie noch einmal ablegen und den Befehl wiederholen, wenn sie eingelesen ist
told-ticket-of-part-unread = das Ticket von Teil { $part } war nicht lesbar: es berichtigen und beide erneut ablegen
told-refused-already = Teil { $part } ist schon abgelehnt oder storniert; `nestd show p{ $part }` sagt warum
told-built-already = Teil { $part } ist schon gebaut: alle seine Stücke sind in ausgegebenen Baujobs
told-build-is-told = Baujob { $build }: { $what }.
told-build-stays-told = Für Baujob { $build } bleibt es beim schon Gemeldeten: { $what }.
told-issued-once-more = Baujob { $build } wird als Baujob { $new } noch einmal ausgegeben.
told-is-released = Baujob { $build } ist freigegeben und geht in die Warteschlange.
told-was-released-before = Baujob { $build } war schon freigegeben.
told-failure-dismissed = Der fehlgeschlagene Druck von Baujob { $build } ist erledigt; seine Stücke bleiben, wie sie waren.
told-second-dismissed = Die zweite Datei von Baujob { $build } ist erledigt: was jetzt in einer Warteschlange liegt, ist die einzige.
told-now-down = Der Drucker { $printer } ist außer Betrieb: er bekommt keine Baujobs.
told-takes-again = Der Drucker { $printer } nimmt wieder Baujobs.
told-was-not-down = Der Drucker { $printer } war nicht außer Betrieb.
told-taken-back-unless = Baujob { $build } wird aus der Warteschlange von { $printer } zurückgenommen, falls der Drucker nicht schneller ist. Seine Seite sagt, was daraus wurde.
told-noted-taken-first = Notiert: die Datei von Baujob { $build } wird zuerst aus der Warteschlange von { $printer } genommen; dann geschieht es.
told-wait-again =
    { $n } Stück ({ $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teile
    }) { $what } wieder, an erster Stelle, mit allem, was verlangt war.
told-waits = wartet
told-wait = warten
told-order-is-closed = Auftrag { $name } ist { $what }.

## What a command or a form is refused for

told-other-state = Baujob { $build }: { $what }, nicht { $rest }
told-word-open = offen
told-word-nesting = wird gepackt
told-word-verified = geprüft
told-word-claimed = wird eingelesen
told-word-waiting = wartet
told-word-batched = wird erstellt
told-word-built = gebaut
told-word-refused = abgelehnt
told-or-words = { $what } oder { $rest }
told-made-again-since = Baujob { $build } wurde inzwischen neu erstellt: ansehen, was er jetzt ist
told-not-released-made-again = Baujob { $build } ist nicht freigegeben: er wird neu erstellt ({ $detail })
told-file-not-in-queue = die Datei von Baujob { $build } ist nicht in der Warteschlange: sein Drucker hat sie abgeholt, oder sie ist unterwegs zu einem anderen
told-in-build-as-it-is = Teil { $part } hat Stücke in Baujob { $build } ({ $what }), der so gedruckt wird: warten, bis er ausgegeben ist, und den Befehl für die noch wartenden Stücke wiederholen. Gedruckte Stücke werden mit `nestd reprint { $part }=N` neu gemacht
told-only-refused-retried = Teil { $part }: { $what }; zurückholen lässt sich nur ein abgelehntes oder storniertes Teil
told-outcome-recorded = das Ergebnis von Baujob { $build } ist schon gemeldet ({ $what }); ist das falsch, `nestd outcome { $build } { $asked } --correct`
told-outcome-the-same = das Ergebnis von Baujob { $build } ist schon so gemeldet ({ $what }); nichts wurde geändert
told-outcome-the-same-bad = das Ergebnis von Baujob { $build } ist schon so gemeldet ({ $what }); nichts wurde geändert. Sind andere Exemplare schlecht, `nestd outcome { $build } { $asked } --correct --bad PART=N`
told-was-taken-back-untouched = die Datei von Baujob { $build } wurde unberührt aus der Warteschlange genommen: sie gilt nicht als gedruckt, und ihre Stücke werden neu gemacht. Hat doch jemand Stücke davon gedruckt, ebenso viele der wartenden mit `nestd cancel PART=N` herausnehmen; `nestd show b{ $build }` sagt wann, und zeigt die Teile
told-none-counts-as-printed = kein Stück davon gilt als gedruckt: `nestd show` sagt, was wartet, `nestd edit PART --copies N` bestellt mehr
told-copies-being-cancelled = Stücke von Teil { $part } werden gerade storniert; danach beginnt sein Baujob
told-can-be-cancelled = von Teil { $part } lassen sich { $n } Stück stornieren, nicht { $asked }; die anderen sind in Baujobs: `nestd show p{ $part }` zeigt sie
told-only-what-waits = Teil { $part }: { $what }; nur was wartet, lässt sich ändern; { $remedy }
told-retry-first = `nestd retry { $part }` holt es zuerst zurück
told-edit-orders-more = `nestd edit { $part } --copies N` bestellt mehr davon
told-lies-untouched = die Datei von Baujob { $build } liegt unberührt in der Warteschlange von { $printer }, als hätte sie niemand gedruckt. Prüfen, ob die Nummer stimmt. Stimmt sie, darauf bestehen ({ $insist }): nestd nimmt die Datei zuerst aus der Warteschlange, damit sie niemand ein zweites Mal druckt
told-lies-untouched-untold = die Datei von Baujob { $build } liegt unberührt in der Warteschlange, und niemand hat ein Ergebnis gemeldet. Wurde sie nicht gedruckt, sie zurücknehmen: `nestd withdraw { $build }`. Wurde sie gedruckt, zuerst das Ergebnis mit den schlechten Stücken melden: `nestd outcome { $build } complete --bad PART=N`
told-second-unseen = eine zweite Datei von Baujob { $build } wurde in der Warteschlange als { $places } gesehen, und nestd kann dort gerade nicht nachsehen. Selbst nachsehen und sie herausnehmen, wenn sie dort liegt. Hat sie niemand gedruckt: `nestd dismiss b{ $build }`, dann noch einmal sagen
told-second-gone = eine zweite Datei von Baujob { $build } lag in der Warteschlange als { $places } und ist weg. Wird oder wurde sie gedruckt, die Datei aus der Warteschlange von { $printer } nehmen und es noch einmal sagen. Hat sie niemand gedruckt: `nestd dismiss b{ $build }`, dann noch einmal sagen
told-lies-other-file = was in der Warteschlange von { $printer } als Datei von Baujob { $build } liegt, ist nicht die geprüfte Datei. Sie herausnehmen, nachsehen, ob sie gedruckt wurde, und es noch einmal melden
told-on-its-way = die Datei von Baujob { $build } ist unterwegs zu einem anderen Drucker: es noch einmal melden, wenn sie dort ist
told-being-taken-back = die Datei von Baujob { $build } wird gerade aus der Warteschlange genommen: `nestd show b{ $build }` sagt, was daraus wurde
told-no-such-order = es gibt keinen Auftrag { $name }; `nestd orders --all` zeigt alle
told-nothing-to-close = von Auftrag { $name } wartet nichts und nichts wurde abgelehnt, also ist nichts abzuschließen; `nestd show order { $name }` sagt, was daraus wurde
told-order-being-read = Dateien von Auftrag { $name } werden gerade angenommen und eingelesen; ihn gleich abschließen
told-printer-fallback-waits = Die Baujobs von { $machine } warten, bis ein Drucker in Betrieb ist.
told-not-taken-goes-to = Was er nicht abgeholt hat, geht an { $printer }.
told-copies-cancelled-of-order =
    { $n ->
        [one] { $n } wartendes Stück ist storniert.
       *[other] { $n } wartende Stücke sind storniert.
    }
told-copies-not-asked =
    { $n ->
        [one] { $n } abgelehntes Stück wird nicht mehr verlangt.
       *[other] { $n } abgelehnte Stücke werden nicht mehr verlangt.
    }
told-to-be-taken-out = die Datei von Baujob { $build } sollte aus der Warteschlange genommen werden, damit seine Stücke nachgedruckt werden, aber { $why }: es wurde nichts geändert. { $remedy }
told-lies-under-its-name = was unter seinem Namen in der Warteschlange liegt, ist nicht die geprüfte Datei
told-copies-lie-as = seine Stücke liegen in der Warteschlange als { $places }
told-printer-took-first = sein Drucker hat sie vorher abgeholt
told-lies-elsewhere = sie liegt bei { $place }, nicht dort, wo sie ausgegeben wurde
told-take-out-look-say = Sie herausnehmen, nachsehen, ob sie gedruckt wurde, und es noch einmal melden
told-take-out-say = Sie herausnehmen und es noch einmal melden
told-say-when-known = Es noch einmal melden, wenn bekannt ist, wie der Druck ausging
told-say-once-more = Es noch einmal melden
told-published-in-no-queue = Baujob { $build } wird nicht zurückgenommen: er wurde in einem Warteschlangenordner ausgegeben, der zu keinem Drucker mehr gehört. Wird seine Datei nicht gedruckt, lässt `nestd outcome { $build } failed` seine Stücke wieder warten
told-configuration-nothing = nichts davon gilt ({ $detail })
told-no-answer-in-time = keine Antwort in der erlaubten Zeit
told-no-finishing-steps = Teil { $part } hat keine Nachbearbeitung; `nestd edit { $part } --finish '{ $name }'` gibt ihm diesen Schritt
told-no-such-step = Teil { $part } hat den Nachbearbeitungsschritt „{ $name }“ nicht, nur { $names }
told-step-not-printed = von Teil { $part } ist kein Stück gedruckt, also kann „{ $name }“ nicht getan sein

## Why a due date is at risk

risk-passed = dieser Termin ist vorbei
risk-too-long = der Druck dauert dafür zu lange
risk-left-out = findet im nächsten Baujob keinen Platz neben dem, was vorgeht
risk-awaits-fire = der Baujob wird nicht vor { $time } ausgelöst
risk-printers-busy = die Drucker sind bis { $time } belegt
risk-no-begin = kein Drucker beginnt einen Druck
risk-printer-closed = der Drucker beginnt keinen Druck vor { $time }
risk-awaits-release = der Baujob wartet auf Freigabe
risk-awaits-answer = wartet auf eine Antwort
risk-awaits-material = der Werkstoff ist auf der Maschine nicht geladen
risk-file-missing = die Datei ist beschädigt oder wird gerade geholt
risk-not-read = die Datei ist noch nicht eingelesen
risk-paused = die Maschine ist pausiert
risk-unavailable = die Maschine ist nicht verfügbar
risk-no-printer = kein Drucker der Maschine ist in Betrieb
told-at-risk-one = { $name } ist fällig { $due }: { $why }
told-at-risk-one-of = { $name } von { $names } ist fällig { $due }: { $why }
told-at-risk = { $names } sind fällig { $due }: { $why }
told-at-risk-of = { $names } von { $name } sind fällig { $due }: { $why }
told-at-risk-more = { $names } und { $more } weitere sind fällig { $due }: { $why }
told-at-risk-more-of = { $names } und { $more } weitere von { $name } sind fällig { $due }: { $why }
told-machine-not-configured = seine Maschine ist nicht konfiguriert

## What is loaded

told-loaded-before = { $material } war schon auf { $machine } geladen
told-nothing-loaded-before = Auf { $machine } war schon nichts geladen
told-loaded-now = { $material } ist jetzt auf { $machine } geladen: der nächste Baujob wird daraus
told-nothing-loaded-now = Auf { $machine } ist jetzt nichts geladen: Teile mit Angabe des Werkstoffs warten
told-others-wait =
    { $parts ->
        [one] { $parts } Teil dort wartet
       *[other] { $parts } Teile dort warten
    } auf einen anderen Werkstoff; `nestd status` sagt, auf welchen
told-fired-of-other = Baujob { $build } wurde vorher ausgelöst und ist aus { $material }: ihn zuerst drucken oder zurückziehen
told-material-not-named = [materials] in nestd.toml nennt „{ $material }“ nicht, nur { $names }: einen von diesen verwenden, oder ihn dort ergänzen und nestd neu laden
told-no-machine-here = hier gibt es keine Maschine „{ $machine }“
told-part-not-loaded = Teil { $part } ist aus { $material }, das auf { $machine } nicht geladen ist; `nestd machine load { $machine } '{ $material }'` meldet es als geladen
