bins = Kisten
bin = Kiste
bin-not-found = Nicht gefunden
bin-in-cake = Im Pulverkuchen
break-out-title = Baujob { $build } auspacken
whole-pick-map = Der ganze Entnahmeplan, zum Drucken
on-other-screens = Auf anderen Bildschirmen
last-elsewhere =
    { $count ->
        [one] Das letzte Stück ist auf einem anderen Bildschirm
       *[other] Die letzten { $count } Stück sind auf anderen Bildschirmen
    }
said-before = { $who } hat das schon gemeldet, { $when }: { $word }. Haben Sie ein anderes Stück in der Hand?
said-already = Schon gemeldet
said-since = { $who } hat inzwischen gemeldet, { $when }: dieses Stück ist { $word }. Das bleibt so. Um etwas anderes zu melden, das Stück noch einmal ansehen.
not-recorded = Nicht eingetragen
no-copies-of-build = Das sind keine Stücke dieses Baujobs.
recorded-as =
    { $copies ->
        [one] { $copies } Stück ist
       *[other] { $copies } Stück sind
    } eingetragen: { $word }.
recorded-in-part = Zum Teil eingetragen
copy-is-said-before = { $copy }, ist { $word }, wie { $who } schon gemeldet hat. Das bleibt so.
nothing-to-undo-text = Jemand hat dazu inzwischen etwas anderes gemeldet oder es schon rückgängig gemacht.
nothing-to-undo = Nichts rückgängig zu machen
told-of =
    { $told } von { $copies } Stück
break-out-counts = { $told }: { $good } gut, { $bad } schlecht, { $missing } nicht gefunden, { $open } im Pulverkuchen.
copies-told = Stücke, zu denen etwas gemeldet ist
copy-of-all = Stück { $number } von { $all }
bin-number = Kiste { $number }
the-part = Das Teil { $name }
chosen-copy = Ausgewählt: Nummer { $number }, { $name }, Stück { $copy }.
comes-out-downwards = Es kommt heraus, wenn der Pulverkuchen angehoben oder gedreht wird.
looks-like = Sieht aus wie { $names }.
go-on-next = Weiter mit dem nächsten
later-next = Später: das nächste zeigen
on-screen-of = Es ist auf dem Bildschirm von { $name }.
have-in-hand = Ich habe es in der Hand
was-told-bad = Es wurde als schlecht gemeldet und wartet auf den Nachdruck.
copy-is-said = Es ist { $word }, gemeldet von { $who }, { $when }.
still-in-cake = Noch im Pulverkuchen
press-out = Entnommen
press-bad = Schlecht
press-missing = Nicht gefunden
place-of-copy = Oberkante { $top } mm, { $x } mm von links, { $y } mm von vorn.
place-not-known = Das Original ist nicht mehr aufbewahrt: der Platz ist nicht bekannt.
way-out = Entnahme: { $way }.
copy-number = Stück { $copy }.
still-in-cake-count = Noch im Pulverkuchen: { $copies } Stück
screen-of = auf dem Bildschirm von { $name }
all-out-good = Alle diese sind entnommen und gut
none-found = Keines davon wurde gefunden
told-bad = als schlecht gemeldet
the-end = Ende
cake-is-empty = Der Pulverkuchen ist leer
good-of-all =
    { $good } von { $copies } Stück { $good ->
        [one] ist
       *[other] sind
    } gut.
outcome-is-told = Das Ergebnis ist gemeldet.
tell-some-again = Melden: gedruckt, und diese Stücke nachdrucken
tell-all-good = Melden: gedruckt, alles gut
bad-wait-again = Stücke, die schlecht sind oder nicht gefunden wurden, warten wieder, ganz vorn, mit allem, was verlangt war.
name-and-copy = { $name }, Stück { $copy }
last-press-all = Zuletzt: { $copies } Stück, { $word }, von { $who }, { $when }.
last-press = Zuletzt: { $number } { $name }, Stück { $copy }, { $word }, von { $who }, { $when }.
undo-all = Alle { $count } rückgängig
copy-title = { $number }: { $name }, Stück { $copy }
published-build = ausgegebener Baujob { $build }: er kann ausgepackt werden, sobald er gedruckt ist
bin-no-order = kein Auftrag
mark-out = entnommen
mark-bad = entnommen und schlecht
mark-missing = nicht gefunden
mark-open = noch im Pulverkuchen
step-plan = Wo es steht, von oben
all-of-part-out = Alle { $count } dieses Teils hier: entnommen
all-of-order-out = Alle { $count } dieses Auftrags hier: entnommen
all-without-order-out = Alle { $count } ohne Auftrag hier: entnommen
your-name = Ihr Name
that-is-me = Das bin ich
who-works = Wer arbeitet hier? Der Name wird auf diesem Gerät einmal gefragt.
you-are = Sie sind { $name }.
somebody = jemand
