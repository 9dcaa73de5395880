status-drop = { $machine }: Dateien ({ $formats }) hier ablegen.
status-now = Jetzt: { $doing }.
status-paused = PAUSIERT von { $by } seit { $time }: nichts wird ausgelöst.
status-no-printer = Kein Drucker ist in Betrieb: nichts wird ausgelöst.
status-being-read =
    { $files ->
        [one] { $files } Datei wird eingelesen.
       *[other] { $files } Dateien werden eingelesen.
    }
status-open-build = Offener Baujob: { $height } mm hoch, { $share } % der Bauraumhöhe.
status-while-waiting = Beim Warten: { $night }.
status-fires = Er wird ausgelöst, { $when }.
status-held = Der offene Baujob wartet: { $why }.
status-last-build = Letzter Baujob: { $build }, { $time }, { $height } mm.
status-waiting =
    { $copies ->
        [one] { $copies } Stück ({ $parts }) wartet
       *[other] { $copies } Stück ({ $parts }) warten
    }
status-stopped = { $machine }: nestd wurde angehalten ({ $time }): dieser Ordner wird nicht durchsucht, und nichts wird gebaut. Hier abgelegte Dateien werden angenommen, wenn nestd wieder läuft.
status-until-then = Bis dahin: { $waiting }.
status-halted = { $machine }: dieser Ordner wird nicht durchsucht, und nichts wird gebaut, bis das behoben ist. Was hier abgelegt wird, bleibt hier.
status-written = Geschrieben { $time }.
status-waits-to-begin = { $machine }: nestd wartet auf den Start; was hier abgelegt wird, wartet.
status-does-not-run = { $machine }: nestd läuft nicht; was hier abgelegt wird, wartet.
status-node-gone = { $machine }: Der Knoten { $node } auf { $host } läuft seit { $time } nicht. Was hier abgelegt wird, wartet, bis er wieder läuft oder ein anderer Knoten diese Maschine übernimmt.
attention = ACHTUNG: { $what }
attention-more = ACHTUNG: und { $count } weitere; `nestd status` zeigt alles.
status-stamp =
    Geschrieben { $time }, und mindestens { $minutes ->
        [one] jede Minute
       *[other] alle { $minutes } Minuten
    } erneuert, solange nestd läuft: ist das hier älter, läuft nestd nicht.
question-yes = Es wartet auf Freigabe: { $question }.
question-yes-remedy = `nestd confirm { $part }` druckt es so, `nestd cancel { $part }` lehnt es ab.
question-original = Das Original fehlt oder ist beschädigt, deshalb wird es nicht gedruckt.
question-original-remedy = { $name } noch einmal ablegen oder mit `nestd cancel { $part }` zurückziehen.
question-copies = Wie viele Stück? Vorerst gilt 1.
question-copies-remedy = `{ $command }` beantwortet das, und `nestd confirm { $part }` lässt es bei 1.
material-awaited = Es wartet auf { $material }: auf { $machine } ist { $loaded } geladen.
material-awaited-none = Es wartet auf { $material }: für { $machine } ist kein geladener Werkstoff gemeldet.
material-elsewhere = { $material } ist geladen auf { $machines }.
material-nowhere = { $material } ist auf keiner Maschine geladen.
material-unknown = [materials] in nestd.toml nennt { $material } nicht, nur { $known }.
material-remedy = `{ $load }` meldet es als geladen, `nestd move { $part } --to MACHINE` verschiebt das Teil, `nestd edit { $part } --material NAME` berichtigt es.
material-lot = { $material }, Charge { $lot }
status-loaded = Geladen: { $material }.
status-question = Frage: Wie viele Stück? Für Teil { $part } ({ $name }) gilt vorerst 1; antworten mit `{ $command }`.
status-questions-more =
    Dieselbe Frage stellt sich bei { $parts ->
        [one] { $parts } weiteren Teil
       *[other] { $parts } weiteren Teilen
    }.
release-brief = { $copies } Stück, { $height } von { $limit } mm hoch, Packdichte { $density } %, etwa { $hours } h Druck
release-made-again = Baujob { $build } wird neu erstellt: { $why }.
release-build = Baujob { $build }: { $content }.
release-could-begin = Auf { $printer } könnte er { $begins } beginnen und { $ends } ausgepackt werden.
release-not-known = Es ist nicht bekannt, wann { $printer } damit beginnen könnte.
release-nothing-waits = Sonst wartet nichts.
release-copies-wait =
    { $copies ->
        [one] { $copies } Stück wartet
       *[other] { $copies } Stück warten
    } auf den nächsten Baujob.
release-late-part = { $name } (fällig { $due })
release-late-part-of = { $name } aus { $order } (fällig { $due })
release-none-late = Kein Teil darin wäre verspätet.
release-late = Verspätet wären { $names }.
