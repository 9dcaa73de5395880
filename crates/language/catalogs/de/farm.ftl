why-below = Der Grund steht unten
number-of = { $number } von { $all }
figure-print = Drucker drucken
figure-wait =
    { $count ->
        [one] Stück wartet
       *[other] Stück warten
    }
figure-late =
    { $count ->
        [one] Termin verspätet
       *[other] Termine verspätet
    }
figure-tight =
    { $count ->
        [one] Termin knapp
       *[other] Termine knapp
    }
risks = Verspätet oder gefährdet
more-dates =
    { $count ->
        [one] { $count } weiterer Termin
       *[other] { $count } weitere Termine
    }
due-done = fällig { $due }, fertig etwa { $done }
due-on = fällig { $due }
board = Plantafel
legend-solid = im Druck
legend-outlined = wird erstellt oder liegt in der Warteschlange
legend-dashed = kommt noch, wenn nichts mehr dazukommt
legend-cool = kühlt ab
legend-closed = kein Druckbeginn
no-machine-text = Eine Maschine ist eine Datei mit wenigen Zeilen: ihr Bauraum, ihr Abstand, ihre Drucker. { $command } schreibt sie.
no-machine = Auf diesem Knoten ist keine Maschine konfiguriert
no-machine-help = Wie man eine Maschine hinzufügt
nothing-came-drop = Dateien ({ $formats }) unten auf eine Maschine ziehen oder in ihren Eingangsordner kopieren. Die Farm sammelt sie, packt sie so niedrig wie möglich und legt den Baujob in die Warteschlange des Druckers.
nothing-came-copy = Dateien ({ $formats }) in den Eingangsordner der Maschine legen. Die Farm sammelt sie, packt sie so niedrig wie möglich und legt den Baujob in die Warteschlange des Druckers.
nothing-came-help = Wie Teile hereinkommen
nothing-came = Noch ist nichts gekommen
machine-of-node =
    Die Maschine { $machine } wird vom Knoten { $node } bedient: { $parts ->
        [one] { $parts } Teil wartet
       *[other] { $parts } Teile warten
    }.
machine-is-gone =
    Die Maschine { $machine } ist nicht mehr konfiguriert: { $parts ->
        [one] { $parts } Teil wartet
       *[other] { $parts } Teile warten
    }.
nodes-running =
    { $count } Knoten, { $running ->
        [one] { $running } läuft
       *[other] { $running } laufen
    }
nodes = Knoten
daemon-silent = Der Dienst läuft auf { $host }, hat aber seit { $age } nichts in die Datenbank geschrieben: so alt kann diese Seite sein. { $why }.
daemon-runs = Der Dienst läuft auf { $host } seit { $time }: { $activity }.
daemon-dead = Der Dienst läuft nicht; sein letztes Lebenszeichen ist { $age } her.
daemon-never-ran = Der Dienst ist noch nie gelaufen.
build-word = Baujob
next-build = Nächster
dates-kept = Termine eingehalten
dates-not-known = Fertigstellung noch nicht bekannt
about-mm = etwa { $height } mm
since-time = seit { $time }
until-time = bis { $time }
fires-begins = Auslösung { $fires }, Beginn { $begins }
begins-time = Beginn { $time }
no-time-known = noch keine Zeit bekannt
build-on = Baujob { $build } auf { $printer }
build-number = Baujob { $build }
build-to-come-on = Ein künftiger Baujob auf { $printer }
build-to-come = Ein künftiger Baujob
all-dates-kept = alle Termine werden eingehalten
a-date-is-tight = ein Termin ist knapp
a-date-is-late = ein Termin ist verspätet
began-time = begonnen { $time }
fires-time = Auslösung { $time }
printed-time = Druckende { $time }
unpacked-time = auszupacken { $time }
add-files-here = Dateien hinzufügen{ $unseen } { $soft }
unseen-to = zu { $machine }
or-drop-here = oder hier ablegen
unseen-of = von { $name }
free-time = Frei { $time }
flush = Auslösen
unseen-flush = { $machine }: zeigen, was jetzt gebaut würde
pause = Pausieren
material-loaded = { $material } ist geladen
load-text = Der nächste Baujob wird aus dem gemacht, was geladen ist. Teile aus anderem Werkstoff warten. Leer lassen, wenn nichts geladen ist.
load = Geladenes melden
printer-down-text = Ein Drucker außer Betrieb nimmt keine Baujobs. Was er nicht genommen hat, geht an einen anderen Drucker der Maschine, wenn es einen gibt.
printer-down-do = Drucker außer Betrieb nehmen
printer-up-do = Wieder in Betrieb nehmen
printer-named = Drucker { $printer }
resume = Fortsetzen
say-yes = Baujob { $build } freigeben
tell-how = Ergebnis Baujob { $build }
builds-of = Baujobs von { $name }
later-builds-of = Spätere Baujobs von { $name }
nothing-waits = Nichts wartet.
waiting-due =
    Wartet: { $copies } von { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teilen
    }, das erste fällig { $due }
waiting =
    Wartet: { $copies } von { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teilen
    }
it-waits = Der Baujob wartet: { $why }
open-build = Offener Baujob { $build }:
height-of = { $height } von { $limit } mm
so-dense = Packdichte { $density }
usual-density = (üblich: { $density })
height-used = Vom offenen Baujob von { $machine } genutzte Höhe: { $share } %
made-searched = Die Anordnung von Baujob { $build } wird gesucht: { $copies } Stück
made-awaits = Baujob { $build } ist geprüft und wartet auf Freigabe: { $copies } Stück
made-proved = Baujob { $build } ist geprüft und kommt in die Warteschlange: { $copies } Stück
spent-of = { $spent } von { $limit } s
search-for = Suche für Baujob { $build }
last-published = Zuletzt ausgegeben: Baujob { $build }
now = jetzt
fires-if = Auslösung { $time }, wenn nichts mehr kommt: { $why }.
fires-at-time = Auslösung { $time }: { $why }.
paused-by = Pausiert von { $by } seit { $time }: nichts wird ausgelöst.
unavailable-since = Nicht verfügbar, seit { $time }: { $trouble }
unavailable-for = Nicht verfügbar: { $trouble }
needs = Hier wird jemand gebraucht
things-need =
    { $count ->
        [one] { $count } Sache braucht jemanden
       *[other] { $count } Sachen brauchen jemanden
    }
more-things =
    { $count ->
        [one] { $count } weitere Sache
       *[other] { $count } weitere Sachen
    }
since-sentence = Seit { $time }.
what-to-do = Was ist zu tun?
its-queue = sein Warteschlangenordner
its-inbox = ihr Eingangsordner
its-errors = ihr Fehlerordner
its-archive = ihr Archiv
failed-builds = Fehlgeschlagene Baujobs
print-as-is = So drucken
cancel = Teil stornieren
add-files = Dateien hinzufügen
parts-that-wait = Die wartenden Teile
order-of = Auftrag { $order }
read-again = Neu einlesen
mend-and-print = Ausbessern und drucken
all-refused = Alle abgelehnten
seen-to = Erledigt
unseen-seen-to = : dort liegen lassen ({ $machine })
how-many = Wie viele Stück werden gebraucht? Vorerst gilt jeweils 1.
say-how-many = Stückzahl angeben
machine-named = Maschine { $machine }
node-of-machine-gone = { $machine } gehört zum Knoten { $node }, der nicht läuft. Nichts wurde getan: ihn starten und dies noch einmal senden.
node-does-not-answer = der Knoten { $node } hat nicht geantwortet: { $why }. Noch einmal senden, wenn er antwortet: was er schon getan hat, tut er nicht zweimal
machine-just-moves = { $machine } wechselt gerade zu einem anderen Knoten: gleich noch einmal senden
nodes-are-busy = gerade warten viele Anfragen auf andere Knoten: gleich noch einmal versuchen
