### Words of all pages: counts, dates, times.

## Dates

# A day near today: Fr 4. Dez.
date-day = { $weekday } { $day }. { $month }
# A day far from today: 4. Dez 2027.
date-year = { $day }. { $month } { $year }
# Oktober 2026.
date-month = { $month } { $year }
date-today = heute
date-tomorrow = morgen
date-yesterday = gestern
# $day is one of the above; $clock is 05:49.
date-clock = { $day } { $clock }
# A time that nobody told.
about-time = etwa { $time }
# On the axis of the board.
date-today-alone = Heute
# In a sentence to a customer: Freitag, 4. Dezember.
date-long = { $weekday }, { $day }. { $month }
date-long-year = { $weekday }, { $day }. { $month } { $year }
weekday-long =
    { $weekday ->
        [1] Montag
        [2] Dienstag
        [3] Mittwoch
        [4] Donnerstag
        [5] Freitag
        [6] Samstag
       *[7] Sonntag
    }
weekday-short =
    { $weekday ->
        [1] Mo
        [2] Di
        [3] Mi
        [4] Do
        [5] Fr
        [6] Sa
       *[7] So
    }
month-short =
    { $month ->
        [1] Jan
        [2] Feb
        [3] März
        [4] Apr
        [5] Mai
        [6] Juni
        [7] Juli
        [8] Aug
        [9] Sep
        [10] Okt
        [11] Nov
       *[12] Dez
    }
month-long =
    { $month ->
        [1] Januar
        [2] Februar
        [3] März
        [4] April
        [5] Mai
        [6] Juni
        [7] Juli
        [8] August
        [9] September
        [10] Oktober
        [11] November
       *[12] Dezember
    }

## Durations

# $span is 3h 5m or 2d 2h, as it is written in all languages.
due-in = noch { $span }
due-overdue = { $span } überfällig
# $delay is 40 min, 28 h, 3 Tage.
late-by = { $delay } verspätet
delay-min = { $minutes } min
delay-hours = { $hours } h
delay-days =
    { $days ->
        [one] { $days } Tag
       *[other] { $days } Tage
    }

## Counts

count-copies = { $count } Stück
count-parts =
    { $count ->
        [one] { $count } Teil
       *[other] { $count } Teile
    }
count-files =
    { $count ->
        [one] { $count } Datei
       *[other] { $count } Dateien
    }
count-builds =
    { $count ->
        [one] { $count } Baujob
       *[other] { $count } Baujobs
    }
count-more-builds =
    { $count ->
        [one] { $count } weiterer Baujob
       *[other] { $count } weitere Baujobs
    }

## Labels of fields: headings of tables and of facts

field-build = Baujob
field-part = Teil
field-machine = Maschine
field-state = Status
field-state-in-the-ledger = Status in der Datenbank
field-time = Zeit
field-question = Frage
field-reason = Grund
field-reason-or-warning = Grund oder Warnung
field-note = Notiz
field-height = Höhe
field-machine-height = Bauraumhöhe
field-bound = Untergrenze
field-density = Packdichte
field-mean-density = Mittlere Packdichte
field-used = Genutzt
field-machine-time = Maschinenzeit
field-parts = Teile
field-cake = Pulverkuchen
field-failed = Fehlgeschlagen
field-powder = Pulver
field-price = Preis
field-currency = Währung
field-yield = Ausbeute
field-layers = Schichten
field-layer = Schicht
field-copies = Stück
field-copies-here = Stück hier
field-copies-waiting = Stück wartend
field-of = Von
field-lines = Positionen
field-wanted = Bestellt
field-in-builds = In Baujobs
field-queued = In Warteschlange
field-printing = Im Druck
field-printed = Gedruckt
field-good = Gut
field-refused = Abgelehnt
field-bad = Schlecht
field-bad-copies = Schlechte Stücke
field-cancelled = Storniert
field-builds = Baujobs
field-volume = Volumen
field-clearance = Abstand
field-proved = Nachgewiesen
field-cpu = CPU-Zeit
field-wall-time = Laufzeit
field-evaluations = Bewertungen
field-seed = Startwert
field-method = Verfahren
field-search = Suche
field-repeats = Wiederholt
field-version = Version
field-fired-by = Auslöser
field-opened = Eröffnet
field-nesting = Ausgelöst
field-verified = Geprüft
field-published = Ausgegeben
field-file = Datei
field-file-or-reason = Datei oder Grund
field-content = Inhalt
field-made = Erstellt
field-name = Name
field-order = Auftrag
field-e-mail = E-Mail
field-customer = Kunde
field-material = Werkstoff
field-finishing = Nachbearbeitung
field-lot = Charge
field-loaded = Geladen
field-priority = Priorität
field-due = Fällig
field-claimed = Angenommen
field-orientation = Ausrichtung
field-size = Größe
field-warning = Warnung
field-where = Wo
field-origin-of-the-file-at = Ursprung der Datei bei
field-turned = Gedreht
field-break-out = Auspacken
field-mended = Repariert
field-copy = Stück
field-when = Zeitpunkt
field-kind = Art
field-detail = Einzelheiten
field-told = Gemeldet
field-outcome = Ergebnis
field-by = Wer
field-printer = Drucker
field-free-from = Frei ab
field-since = Seit
field-print-times = Druckdauer
field-fires = Auslösung
field-begins = Beginn
field-unpacking = Auspacken
field-closed = Abgeschlossen
field-to-send = Für den Kunden
field-done = Fertig
field-order-or-part = Auftrag oder Teil
field-risk = Risiko
field-taken = Abgeholt
field-released = Freigegeben
field-reference = Referenz
field-withdrawn = Zurückgenommen
field-waiting = Wartet
field-oldest = Ältestes
field-next-build = Nächster Baujob
field-while-it-waits = Beim Warten
field-node = Knoten
field-host = Rechner
field-last-sign = Letztes Zeichen
field-address = Adresse
field-machines = Maschinen
field-now = Jetzt
field-being-read = Wird eingelesen
field-last-published = Zuletzt ausgegeben
field-no = Nr.
field-top = Oben
field-bottom = Unten
field-x = x
field-y = y
field-way = Richtung

## Words of states, as chips show them: of builds, machines, printers, copies, parts, orders and dates

state-complete = vollständig
state-good = gut
state-kept = eingehalten
state-on-time = pünktlich
state-done = fertig
state-runs = läuft
state-printing = im Druck
state-should-be-printed = wohl gedruckt
state-cooling = kühlt ab
state-nesting = wird gepackt
state-being-made = wird erstellt
state-being-read = wird eingelesen
state-reading = liest ein
state-under-way = in Arbeit
state-open = offen
state-waiting = wartet
state-collecting = sammelt
state-queued = Baujob wartet
state-in-the-queue = in der Warteschlange
state-at-the-printer = beim Drucker
state-proved = geprüft
state-expecting = vorgemerkt
state-in-a-build = in einem Baujob
state-later = später
state-free = frei
state-closed-now = geschlossen
state-withdrawn = zurückgenommen
state-cancelled = storniert
state-closed = abgeschlossen
state-stopped = angehalten
state-no-date = kein Termin
state-tight = knapp
state-ended = beendet
state-should-be-done = müsste fertig sein
state-waits-for-a-yes = wartet auf Freigabe
state-paused = pausiert
state-interrupted = unterbrochen
state-short = unvollständig
state-missing = fehlt
state-is-to-be-repaired = muss repariert werden
state-on-its-way-to-another-printer = unterwegs zu anderem Drucker
state-being-taken-back = wird zurückgenommen
state-overdue = überfällig
state-late = verspätet
state-failed = fehlgeschlagen
state-refused = abgelehnt
state-bad = schlecht
state-down = außer Betrieb
state-unavailable = nicht verfügbar
state-does-not-answer = antwortet nicht
details = Einzelheiten
close = Schließen
skip = Zum Inhalt springen
pages = Seiten
nav-farm = Farm
nav-orders = Aufträge
nav-history = Verlauf
nav-month = Monat
nav-help = Hilfe
search-farm = Farm durchsuchen
footer-lengths = . Längen in mm.
footer-json = JSON-Schnittstelle
footer-metrics = Metriken
search-example = Teil, Auftrag, Baujob 3
search-key = Taste / zum Suchen
search = Suchen
to-the-farm = Zur Farm

## Titles of error pages

http-bad-request = Fehlerhafte Anfrage
http-unauthorized = Nicht angemeldet
http-forbidden = Nicht erlaubt
http-not-found = Nicht gefunden
http-method-not-allowed = Methode nicht erlaubt
http-conflict = Konflikt
http-payload-too-large = Anfrage zu groß
http-misdirected-request = Fehlgeleitete Anfrage
http-unprocessable-entity = Nicht verarbeitbar
http-too-many-requests = Zu viele Anfragen
http-internal-server-error = Interner Serverfehler
http-service-unavailable = Dienst nicht verfügbar
http-error = Fehler

## States of builds as the ledger has them

ledger-open = offen
ledger-nesting = wird gepackt
ledger-verified = geprüft
ledger-published = ausgegeben
ledger-printing = im Druck
ledger-complete = vollständig
ledger-interrupted = unterbrochen
ledger-failed = fehlgeschlagen
ledger-claimed = wird eingelesen
ledger-waiting = wartet
ledger-batched = wird erstellt
ledger-built = gebaut
ledger-refused = abgelehnt

## What happened, as the list of events says it

event-in-a-build = in einem Baujob
event-in-the-queue = in der Warteschlange
event-waiting = wartet
event-refused = abgelehnt
event-open = offen
event-nesting = wird gepackt
event-verified = geprüft
event-published = ausgegeben
event-printing = im Druck
event-complete = vollständig
event-interrupted = unterbrochen
event-failed = fehlgeschlagen
event-paused = pausiert
event-resumed = fortgesetzt
event-unavailable = nicht verfügbar
event-available = verfügbar
event-adopted = übernommen
event-damaged = beschädigt
event-size-differs = andere Größe
event-healed = ersetzt
event-at-risk = gefährdet
event-attempt-failed = Versuch fehlgeschlagen
event-proof-failed = Prüfung fehlgeschlagen
event-locked = verhakt
event-put-out = herausgenommen
event-no-room = kein Platz
event-clock-set = Uhr gestellt
event-messages-dropped = Nachrichten verworfen
event-put-back = wartet wieder
event-copies-cancelled = Stücke storniert
event-copies-wanted = mehr Stücke
event-edited = geändert
event-moved = verschoben
event-loaded = geladen
event-confirmed = freigegeben
event-finishing = Nachbearbeitung
event-revised = neue Fassung
event-seen = erledigt

## What fired a build

trigger-flush = von Hand
trigger-full = voll
trigger-fill = Füllung
trigger-copies = Stückzahl
trigger-max-wait = Wartezeit
trigger-due = Termin
trigger-at = Uhrzeit
trigger-withdrawn = Rücknahme

turned-free = frei
turned-upright = aufrecht
turned-axis = achsparallel
turned-fixed = fest

## Signs between words

sign-comma = ,{ " " }
sign-semicolon = ;{ " " }
sign-stop = .
sign-colon = :{ " " }

## The reason that lies beside a refused file

cause-and-reason = { $cause } (Einzelheit auf Englisch: { $reason })
reason-refused = { $name } wurde abgelehnt.
reason-file = Datei: { $place }
reason-when = Zeit: { $time }
reason-part = Teil { $part } der Maschine { $machine }.
reason-retry = Zurückholen: nestd retry { $part }

# A build or a date with what is known of it.
job-described = { $name }: { $what }.
search-words-build = Baujob Baujobs
search-words-part = Teil Teile Datei Dateien
search-words-order = Auftrag Aufträge
search-words-customer = Kunde Kunden
search-words-machine = Maschine Maschinen
