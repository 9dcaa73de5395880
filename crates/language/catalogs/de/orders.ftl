a-number-of-orders = keine Anzahl von Aufträgen
a-state-of-order = kein Status eines Auftrags
order-named = Auftrag „{ $order }“
first-orders =
    { $count ->
        [one] { $count } Auftrag, der erste
       *[other] { $count } Aufträge, die ersten
    } von mehr
count-orders =
    { $count ->
        [one] { $count } Auftrag
       *[other] { $count } Aufträge
    }
name-contains = Name enthält
customer-contains = Kunde enthält
no-such-orders = Keine solchen Aufträge
no-such-orders-text = Hier stehen Dateien, deren Ordner, Ticket oder Liste einen Auftrag nennt.
all-orders = Alle Aufträge
order-title = Auftrag { $order }
send-to-customer = Für den Kunden
copy-text = Kopieren
count-lines =
    { $count ->
        [one] { $count } Position
       *[other] { $count } Positionen
    }
lines-arrive =
    { $count ->
        [one] { $count } weitere Position kam per Anfrage und ist
       *[other] { $count } weitere Positionen kamen per Anfrage und sind
    } gleich hier.
where-copies-are = Wo die Stücke sind
copies-wait-for-build =
    { $count ->
        [one] { $count } Stück wartet
       *[other] { $count } Stück warten
    } auf einen Baujob.
order-in-no-build = Noch ist kein Stück davon in einem Baujob.
what-happened-who = Was geschah und wer es tat
events = Ereignisse
order-for = Für { $customer }.
order-since = { $copies }; seit { $time }.
order-due = Fällig { $due }.
order-done = Fertig { $time }
order-expected = Erwartet { $time }
order-should-be-done = Müsste fertig sein seit { $time }
order-closed = Abgeschlossen { $how }.
order-short-text = Nicht alles davon ist gut oder wird es: Abgelehntes erneut ablegen oder den Auftrag akzeptieren, wie er ist.
a-state-of-part = kein Status eines Teils
the-number-of-part = keine Nummer eines Teils
file-begins-with = Datei oder Auftrag beginnt mit
parts-text = Teile, die eingelesen werden, warten, in einem entstehenden Baujob sind oder in den letzten 30 Tagen abgelehnt wurden. Andere nach Status oder Name suchen.
next-parts = Die Teile davor
newest-parts =
    { $count ->
        [one] { $count } Teil, das neueste
       *[other] { $count } Teile, die neuesten
    } von mehr
no-parts = Keine Teile.
part-title = Teil { $part }: { $name }
part-of-order = Gehört zu Auftrag { $order }.
where-its-copies-are = Wo seine Stücke sind
what-happened = Was geschah
same-file = Dieselbe Datei zu anderen Zeiten
other-files = Andere Dateien dieses Namens
part-number = Teil { $part }
part-in-no-build = In keinem Baujob: { $why }.
part-in-open-build =
    { $waiting ->
        [one] { $waiting } Stück wartet
       *[other] { $waiting } Stück warten
    }; bisher im offenen Baujob { $build }: { $copies } Stück.
part-waits =
    { $waiting ->
        [one] { $waiting } Stück wartet
       *[other] { $waiting } Stück warten
    }, noch in keinem Baujob.
search-for-text = Suche: { $text }
nothing-found = Nichts hat das im Namen.
search-help = Nach einem beliebigen Ausschnitt des Namens von Teil, Datei, Auftrag, Kunde, Baujob oder Maschine suchen, groß oder klein geschrieben; bei mehreren Wörtern muss ein Name jedes enthalten. Eine Nummer findet den Baujob und das Teil dazu:
found-part = Teil { $part }, { $state } auf { $machine }
found-orders = Aufträge
found-customers = Kunden
count-customers =
    { $count ->
        [one] { $count } Kunde
       *[other] { $count } Kunden
    }
found-builds = Baujobs
found-machines = Maschinen
found-parts = Teile
or-more = { $number } oder mehr
more-not-shown = { $link }: { $what }, { $count } weitere.
show-more = Mehr anzeigen
closed-by = { $time } von { $by }, mit { $accepted } von { $copies } Stück
no-copies = keine
not-known = unbekannt
not-known-taken-as-one = unbekannt, als 1 genommen
copies-not-known = unbekannt ({ $copies })
lines-without-number =
    { $lines ->
        [one] Stückzahl von { $lines } Position unbekannt
       *[other] Stückzahl von { $lines } Positionen unbekannt
    }
waits-for-yes-to = Wartet auf Freigabe: { $question }
waits-for-material = Wartet, bis { $material } auf { $machine } geladen ist
in-build-state = { $copies } in Baujob { $build } ({ $state })
none-in-build = keine in einem Baujob
and-more = und { $count } weitere
bad-copies-of = { $count } (Nr. { $numbers })
copies-good = { $count } gut
copies-printed = { $count } wohl gedruckt
copies-printing = { $count } im Druck
copies-queued = { $count } in der Warteschlange
copies-in-build = { $count } in einem Baujob
copies-waiting = { $count } wartend
copies-refused = { $count } abgelehnt
copies-bad = { $count } schlecht
copies-withdrawn = { $count } zurückgenommen
copies-cancelled = { $count } storniert
note-refused =
    { $parts ->
        [one] { $parts } Teil wird nicht gefertigt
       *[other] { $parts } Teile werden nicht gefertigt
    }
note-one-not-printed = noch nicht gedruckt
note-none-printed = noch keines der { $parts } Teile ist gedruckt
note-one-printed = das Teil ist gedruckt
note-all-printed = alle { $parts } Teile sind gedruckt
note-one-should = es müsste inzwischen gedruckt sein
note-all-should = alle { $parts } Teile müssten inzwischen gedruckt sein
note-some-should = { $printed } von { $parts } Teilen müssten inzwischen gedruckt sein
note-some-printed =
    { $printed ->
        [one] { $printed } von { $parts } Teilen ist gedruckt
       *[other] { $printed } von { $parts } Teilen sind gedruckt
    }
note-complete = Ihr Auftrag { $order } ist vollständig: { $printed }.
note-cancelled = Ihr Auftrag { $order } wurde storniert.
note-closed =
    Ihr Auftrag { $order } ist abgeschlossen mit { $accepted } von { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teilen
    }.
note-order = Ihr Auftrag { $order }: { $how }.
note-all-expected = alles ist voraussichtlich am { $day } fertig
note-rest-expected = der Rest ist voraussichtlich am { $day } fertig
note-all-made = alles ist in Fertigung
note-rest-made = der Rest ist in Fertigung
note-all-not-known = ein Termin dafür ist noch nicht bekannt
note-rest-not-known = ein Termin für den Rest ist noch nicht bekannt
note-sorry = Wir bitten um Entschuldigung: der Termin war { $day }.
note-and-expected = { $how }, { $expected }
note-and-refused = { $how }; { $refused }
note-then-sorry = { $note } { $sorry }
finishing-done = Getan: { $done } von { $steps }
finishing-by = getan: { $who }, { $when }
finishing-open = noch nicht getan
finishing-is-done = Ist getan
finishing-not-yet = Noch nicht getan
