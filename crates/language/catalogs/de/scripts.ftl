script-lost = Keine Verbindung zur Farm seit { $time }. Was hier steht, ist von vorher.
script-changed = In diesem Baujob steht jetzt etwas anderes.
script-load-again = 3D-Ansicht neu laden
script-too-large = { $name } ist größer, als diese Farm annimmt ({ $size }).
script-sent-of = { $sent } von { $all } gesendet
script-sent = Gesendet; die Farm schreibt es auf.
script-answers = Die Farm antwortet { $status }.
script-connection-lost = Die Verbindung ist abgebrochen. Noch einmal senden: was hinzugefügt ist, kommt nicht doppelt hinzu.
script-which-machine = Welche Maschine?
script-asking = wird gefragt, wann sie fertig sein könnten
script-no-answer = keine Antwort
script-done = fertig etwa { $time }
script-no-date-known = kein Zeitpunkt bekannt
script-adds = { $done }, { $height } mm mehr Höhe
script-one-late = ein Termin würde sich verspäten
script-several-late = { $count } Termine würden sich verspäten
script-copied = Kopiert
script-no-view-script = Keine 3D-Ansicht: ihr Skript kam nicht an.
script-no-view = Keine 3D-Ansicht: { $why }.
script-last-out = zuletzt entnommen
script-first-out = zuerst entnommen
script-no-proved-order = keine nachgewiesene Reihenfolge der Entnahme
script-what-has-no-order = was keinen Auftrag hat
script-part-not-here = ein Teil, das nicht hier ist
script-chosen = Ausgewählt: { $what }, { $count } Stück. „Alles zeigen“ beendet das.
script-show-all = Alles zeigen
script-layer = { $height } mm, Schicht { $layer } von { $layers }
script-copy-from-to = Stück { $copy }, von { $low } bis { $top } mm
script-step = Entnahmeschritt { $step }
script-simplified = (vereinfacht gezeichnet)
script-missing =
    { $missing } von { $count ->
        [one] { $count } Stück ist
       *[other] { $count } Stück sind
    } nicht zu sehen: die Originale sind nicht mehr aufbewahrt.
script-front = VORN
script-soonest = am frühesten
