a-state-of-build = kein Status eines Baujobs
the-number-of-build = keine Nummer eines Baujobs
is-no-date = „{ $text }“ ist kein Datum wie 2026-11-20
csv-all-columns = CSV mit allen Spalten
next-builds = Die Baujobs, die danach kommen
all = alle
part-or-order = Teil oder Auftrag, ganzer Name
until = Bis
sorted-by-what = Sortiert nach
newest-first = neueste zuerst
show = Anzeigen
days =
    { $days ->
        [one] { $days } Tag
       *[other] { $days } Tage
    }
published-in-time = Was in dieser Zeit ausgegeben wurde
heights = Höhen
the-newest-first = die neuesten zuerst
sorted-by =
    sortiert nach { $sort ->
        [height] Höhe
        [density] Packdichte
        [copies] Stück
       *[machine] Maschine
    }
no-builds = Keine Baujobs
none-matches = Keiner entspricht dem, was oben verlangt ist.
all-builds = Alle Baujobs
is-no-month = „{ $text }“ ist kein Monat wie 2026-10
as-many-days = ebenso viele Tage des Monats { $month }
month-text = Liter der Teile sind ihr Volumen; Liter des Pulverkuchens sind Teile und Pulver bis zur Höhe jedes Baujobs. Maschinenzeit ist die Höhe mal die Stunden, die ein mm braucht. Ausbeute: gute Stücke unter denen, deren Ergebnis gemeldet wurde.
height-by-week = Höhe je Woche, mm
figure-builds =
    { $count ->
        [one] Baujob
       *[other] Baujobs
    }
figure-copies-made =
    { $count ->
       *[other] Stück
    }
figure-of-parts = Teile
figure-machine-time = Maschinenzeit
figure-yield = Ausbeute
figure-late-parts = verspätet
figure-failed =
    { $count ->
       *[other] fehlgeschlagen
    }
none = Keine.
link-on-machine = { $link } auf { $machine }
month-caption = In diesem Monat ausgegeben; klein zum Vergleich: { $before }
late = Verspätet
nothing-late = Nichts, was in diesem Monat fällig war, kam oder kommt zu spät.
late-text =
    { $parts ->
        [one] { $parts } Teil
       *[other] { $parts } Teile
    } aus { $orders ->
        [one] { $orders } Auftrag
       *[other] { $orders } Aufträgen
    } { $parts ->
        [one] kam nach dem Termin oder ist noch nicht gedruckt.
       *[other] kamen nach dem Termin oder sind noch nicht gedruckt.
    }
without-order = Ohne Auftrag
done-about-untold = fertig etwa { $time }, da niemand es gemeldet hat
done-at = fertig { $time }
chart-height = Höhe der Baujobs
chart-density = Packdichte
chart-used = Genutzter Anteil der Bauraumhöhe
more-machines =
    und { $count ->
        [one] { $count } weitere Maschine
       *[other] { $count } weitere Maschinen
    }, nur in der Tabelle
height-curve = Höhe während der Suche, mm über Sekunden
height-over-time = Höhe im Verlauf
all-machines = alle Maschinen

costs = Kosten
costs-by-order = Was jeder Auftrag trägt
costs-by-build = Was jeder Auftrag von jedem Baujob trägt
costs-text = Maschinenzeit und Pulver eines Baujobs werden nach dem Volumen der Teile geteilt; Liter und Stückzahlen gehören jedem Auftrag selbst. Schlechte Stücke trägt die Farm. Es gelten die Sätze, die galten, als der Baujob gemacht wurde. Pulver ist das frische Pulver, das die Baujobs brauchten.
no-prices = Nichts hat einen Preis. Die Sätze stehen unter `[costs]` in der Datei einer Maschine.
figure-cost = Kosten
order-costs = Er kostet bisher { $cost }.
farm-bears-bad-copies = schlechte Stücke: trägt die Farm
csv-by-order = CSV nach Aufträgen
csv-by-build = CSV nach Baujobs
this-month = Dieser Monat
