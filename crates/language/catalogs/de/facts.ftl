machine-unavailable = nicht verfügbar: { $trouble }
machine-paused = pausiert von { $by }
free-now = jetzt frei
build-is-proved = Baujob { $build } ist geprüft ({ $copies } Stück)
build-awaits-yes = Baujob { $build } wartet auf Freigabe ({ $copies } Stück)
build-is-searched = die Anordnung von Baujob { $build } wird gesucht ({ $copies } Stück)
reading-files =
    liest { $files ->
        [one] { $files } Datei
       *[other] { $files } Dateien
    } ein
collecting-copies = sammelt { $copies } Stück
copies-await-material = { $copies } Stück { $copies ->
        [one] wartet
       *[other] warten
    } auf { $material }
copies-await-answer = { $copies } Stück { $copies ->
        [one] wartet
       *[other] warten
    } auf eine Antwort
print-times-set = { $per_mm } h je mm und { $hours } h, wie eingestellt
print-times-learned =
    { $per_mm } h je mm und { $hours } h, aus { $prints ->
        [one] { $prints } Druck
       *[other] { $prints } Drucken
    }
printer-free-from = frei ab { $time }
printer-closed = geschlossen bis { $time }
printer-never-open = laut seinem Kalender nie wieder offen
printer-ended = Baujob { $build } müsste seit etwa { $until } fertig sein: niemand hat das Ergebnis gemeldet
printer-prints-estimated = druckt Baujob { $build } bis etwa { $until } (geschätzt)
printer-prints = druckt Baujob { $build } bis etwa { $until }
printer-cools-estimated = kühlt Baujob { $build } bis etwa { $until } ab (geschätzt)
printer-cools = kühlt Baujob { $build } bis etwa { $until } ab
printer-expects = Baujob { $build } wird für ihn erstellt
printer-queued-until = Baujob { $build } liegt in seiner Warteschlange und könnte { $time } beginnen
printer-queued = Baujob { $build } liegt in seiner Warteschlange
then-more-builds =
    danach { $count ->
        [one] { $count } weiterer Baujob
       *[other] { $count } weitere Baujobs
    }
printer-down = außer Betrieb seit { $since }, gemeldet von { $by }
fires-when-full-or = wenn er voll ist oder, falls nichts mehr kommt, { $at } (spätestens { $latest }), { $content }: { $why }
fires-when-full = wenn er voll ist, spätestens { $latest }, { $content }: { $why }
fires-due = ein Termin rückt näher
fires-due-of = Termin von { $name }
fires-at = um { $time }
fires-waited = lange genug gewartet
with-copies-high = mit { $copies } Stück, { $height } mm hoch
with-copies = mit { $copies } Stück
night-goes-on = läuft weiter
night-stands-still = ruht: mehr Zeit bringt zu wenig
night-used-up = ruht: die Zeit dafür ist aufgebraucht
night-given-up = aufgegeben
night-since-arrival = { $gain } seit dem letzten Eingang, { $state }
night-gain = { $gain } mm niedriger nach { $secs } s CPU-Zeit
night-no-gain = nicht niedriger nach { $secs } CPU-s
held-queue-full = die Warteschlange ist voll (queue_depth = { $depth }): er wird ausgelöst, wenn ein Drucker eine Datei abholt, wenn das Ergebnis eines Baujobs in der Warteschlange gemeldet wird oder wenn jemand ihn auslöst
name-and-more = { $name } und { $count } weitere
risk-due-done = fällig { $due }, { $word }, fertig etwa { $done }: { $why }
risk-due = fällig { $due }, { $word }: { $why }
about-height = etwa { $height }
plan-paused = Für { $machine } wird nichts ausgelöst: die Maschine ist pausiert.
plan-unavailable = Für { $machine } wird nichts ausgelöst: die Maschine ist nicht verfügbar.
plan-no-printer = Für { $machine } wird nichts ausgelöst und kein Druck begonnen, bis wieder ein Drucker in Betrieb ist (nestd printer NAME up): alle sind außer Betrieb.
plan-nothing = Für { $machine } wartet nichts, und nichts wird gedruckt.
plan-done = Wenn nichts mehr kommt, ist für { $machine } alles fertig: { $time }.
plan-unknown = Es ist nicht bekannt, wann die Baujobs von { $machine } fertig sind.
plan-unplanned =
    { $parts ->
        [one] { $parts } Teil kann noch in keinen Baujob: es ist nicht eingelesen, wartet auf eine Antwort oder seinen Werkstoff, oder seine Datei fehlt.
       *[other] { $parts } Teile können noch in keinen Baujob: sie sind nicht eingelesen, warten auf eine Antwort oder ihren Werkstoff, oder ihre Datei fehlt.
    }
plan-heights-usual = Höhen mit „etwa“ sind nach der üblichen Packdichte geschätzt.
plan-heights-learned =
    Höhen mit „etwa“ sind nach { $builds ->
        [one] dem letzten Baujob
       *[other] den letzten { $builds } Baujobs
    } geschätzt.
count-machines =
    { $count ->
        [one] { $count } Maschine
       *[other] { $count } Maschinen
    }
count-copies-wait =
    { $count ->
        [one] { $count } Stück wartet
       *[other] { $count } Stück warten
    }
count-builds-in-work =
    { $count ->
        [one] { $count } Baujob in Arbeit
       *[other] { $count } Baujobs in Arbeit
    }
halted = angehalten: die Datenbank { $fault }
ledger-is-damaged = ist beschädigt
ledger-has-lost = hat Änderungen verloren
ledger-was-replaced = wurde entfernt, ersetzt oder überschrieben
ledger-is-taken-over = wird an Stelle dieses nestd von einem anderen bedient
silent-locked = { $by } sperrt die Datenbank gegen Änderungen: nestd wartet, bis die Änderung dort fertig oder dieser Prozess beendet ist
silent-disk = Wenn das Laufwerk des state-Ordners voll ist, Platz schaffen
silent-database = Die Verbindung zur Datenbank ist unterbrochen oder langsam, oder alle Änderungen warten auf eine einzige Verbindung, die dann ein Alarm nennt

## Why a part was refused

cause-format = das Format ist unbekannt oder die Datei abgeschnitten
cause-not-closed = die Oberfläche ist nicht geschlossen
cause-mendable = die Oberfläche ist nicht geschlossen und kann ausgebessert werden
cause-too-large = es passt nicht in die Maschine
cause-limit = die Datei überschreitet eine Grenze
cause-ticket = das Ticket oder die Liste ist falsch oder gehört zu keinem Teil
cause-document = es ist ein Dokument und kein Teil
cause-missing = die Datei ist nie gekommen
cause-duplicate = dieselbe Datei wurde schon einmal abgelegt
cause-unreadable = nestd darf es nicht lesen, oder es ist keine Datei
cause-failure = nestd konnte es nicht verarbeiten
cause-cancelled = jemand hat es storniert
cause-replaced = eine neuere Fassung hat seinen Platz eingenommen
cause-other = abgelehnt

## Alerts

alert-alone = { $headline }.
alert-detailed = { $headline }: { $detail }.
alert-quoted = { $headline }. Meldung des Programms auf Englisch: { $detail }.
alert-of = { $machine }: { $what }
