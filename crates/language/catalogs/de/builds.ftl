break-out-steps = Schritt für Schritt auspacken
pick-map = Entnahmeplan
acts-print = Druck
acts-unpack = Auspacken
acts-again = Noch einmal drucken
nothing-in-it = Noch steht nichts darin.
figure-high = hoch, von { $volume }
figure-copies =
    { $count ->
       *[other] Stück
    }
figure-bad =
    { $count ->
        [one] schlechtes Stück
       *[other] schlechte Stücke
    }
figure-dense = Packdichte
figure-unpacked = auszupacken, soweit bekannt
what-became = Was daraus wurde
outcomes = Ergebnisse
file-build = Baujob-Datei, { $format }
file-build-for = was der Drucker bekommt
file-report = Bericht, HTML
file-report-for = zum Mailen: 3D-Ansicht, Angaben und Entnahmeplan in einer Datei
file-picture = Bild, PNG
file-pick-csv = Entnahmeplan, CSV
file-pick-csv-for = für eine Tabellenkalkulation
file-pick-json = Entnahmeplan, JSON
file-json = Baujob, JSON
file-json-for = alles, was über ihn bekannt ist
file-search = Bericht der Suche, JSON
file-not-kept = Die Baujob-Datei liegt hier nicht mehr: der Drucker hat sie abgeholt, oder sie wurde noch nicht erstellt.
files = Dateien
build-file-of = Baujob-Datei von Baujob { $build } auf diesem Knoten
search-report-of = Bericht der Suche für Baujob { $build } auf diesem Knoten
flush-machine = Baujob von { $machine } auslösen?
nothing-to-build = Für die Maschine wartet nichts: es gibt nichts zu bauen.
in-no-layout =
    { $copies ->
        [one] { $copies } wartendes Stück steht noch in keiner Anordnung.
       *[other] { $copies } wartende Stück stehen noch in keiner Anordnung.
    } Die letzte Suche versucht, auch dafür Platz zu finden.
flush-now = Jetzt auslösen
unseen-flush-now = { $machine }: ausgeben, was jetzt wartet
not-now = Jetzt nicht
in-layout-so-far = Bisher in der Anordnung
in-layout = In der Anordnung
waiting-in-no-layout = Wartet, in keiner Anordnung
flush-title = Baujob von { $machine } auslösen
copies-of-parts =
    { $copies } Stück von { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teilen
    }
they-wait = Wartet: { $waiting }.
layout-stands-dense = Die bisherige Anordnung enthält { $copies } davon und ist { $height } hoch, Packdichte { $density }.
layout-stands = Die bisherige Anordnung enthält { $copies } davon und ist { $height } hoch.
flush-text = Nach dem Auslösen wird { $secs } s lang gesucht, der Baujob geprüft und in die Warteschlange gelegt; er kann dabei niedriger werden. Stücke, die keinen Platz finden, warten weiter.
pick-map-of = Entnahmeplan von Baujob { $build }
pick-forecast = Eine Vorschau: was wo steht, ändert sich, bis der Baujob ausgegeben ist. Nicht zum Auspacken.
made-by = Erstellt von nestd { $version }. Längen in mm.
parts-not-shown =
    { $parts ->
        [one] { $parts } Teil ist
       *[other] { $parts } Teile sind
    } nicht zu sehen: die Originale sind nicht mehr aufbewahrt.
seed = Startwert { $seed }
asked = { $clearance } verlangt
picture-of-cake = Der Baujob von vorn gesehen, etwas von rechts und von oben
pick-axes = x von links, y von vorn, oben und unten vom Boden aus.
pick-downwards = Stücke, die nach unten gehen, kommen heraus, wenn der Pulverkuchen angehoben oder gedreht wird.
listed-without-place =
    { $parts ->
        [one] { $parts } Teil ist
       *[other] { $parts } Teile sind
    } ohne Platz aufgeführt: die Originale sind nicht mehr aufbewahrt.
pick-sheet = Stücke: { $title }
pick-done = Erledigt
pick-proved-order = Jedes Stück kommt geradlinig an allen vorbei, die nach ihm stehen, wie an den Dreiecken nachgewiesen; die Richtung sagt, wohin.
pick-height-order = Nach Höhe, von oben nach unten; ob jedes an den anderen vorbeikommt, ist hier nicht gesagt.
pick-from-to = { $first } bis { $last }
pick-from-down = Von { $height } mm abwärts
pick-no-originals = Originale nicht mehr aufbewahrt
pick-plan = Was sie bedecken, von oben, mit ihren Nummern
front = vorn
name-of-order = { $name } (Auftrag { $order })
picture-of-refused = Das Teil, wie es abgelegt wurde; wo die Oberfläche nicht geschlossen ist, sind die Kanten rot
picture-of-mended = Das Teil, wie es ausgebessert ist; die ausgebesserten Stellen sind rot
picture-of-part = Das Teil, wie es abgelegt wurde
picture-so-far = bisher
picture-published-last = zuletzt ausgegeben
height-not-known = Höhe noch nicht bekannt
so-high = { $height } hoch
picture-of-build = Baujob { $build }, { $what }: { $copies }, { $height }
colour-part = Teil
colour-order = Auftrag
colour-due = Termin
colour-height = Höhe
colour-step = Entnahmeschritt
view-3d = 3D-Ansicht
view-needs-script = Die 3D-Ansicht braucht JavaScript.
view-needs-script-report = Die 3D-Ansicht braucht JavaScript; der Entnahmeplan hat ein Bild.
view-keys = Anordnung mit { $copies } Stück; Pfeiltasten drehen sie, + und - zoomen
view-hint = Auf ein Stück oder auf eine Zeile der Liste zeigen, um zu sehen, was es ist; drücken, um es ausgewählt zu lassen.
parts-by-order = Teile nach Auftrag
no-order = Kein Auftrag
colour-by = Farbe nach
layers-up-to = Schichten bis
explode = Auseinanderziehen
whole-view = Gesamtansicht
event-taken = angenommen
fired-and-nested =
    { $trigger }, { $count ->
        [one] einmal
       *[other] { $count }-mal
    } gepackt
ago = vor { $age }
time-by = { $time } von { $by }
on-its-way-to = { $printer }, unterwegs zu { $other }
bound-text = { $bound }: kein Baujob mit diesen Teilen ist niedriger
clearance-proved = { $clearance } an den Dreiecken nachgewiesen
clearance-no-two = nachgewiesen: keine zwei sind sich nahe
clearance-once-fired = wird nach dem Auslösen nachgewiesen
clearance-asked = { $asked } verlangt, { $proved }
evaluations =
    { $count ->
        [one] { $count } Bewertung
       *[other] { $count } Bewertungen
    }
cpu-secs = { $secs } s CPU-Zeit
wall-secs = { $secs } s Laufzeit
bytes-and-hash = { $bytes } Bytes, BLAKE3 { $hash }
state-since = { $state } seit { $time }
triangles = { $count } Dreiecke
not-read-yet = noch nicht eingelesen
as-ticket-says = { $clearance }, laut Ticket
way-up = oben
way-down = unten
way-right = rechts
way-left = links
way-back = hinten
way-front = vorn
mended-text = { $what }; erlaubt von { $by }; BLAKE3 des reparierten Netzes { $hash }
