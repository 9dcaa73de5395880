### Sentences about files, as they are stored in English: reading, meshes, sizes. Values named what, why, rest, remedy and formats are sentences themselves.
told-why-of = { $what }: { $why }
told-of-name = { $name }: { $why }
told-list = { $why }, { $rest }
told-lists = { $why }; { $rest }
told-list-and = { $why }, und { $rest }
told-mesh-formats = STL, 3MF, OBJ oder PLY
told-package-formats = STL oder 3MF

## Why a file cannot be read

told-cannot-read-file = die Datei kann nicht gelesen werden
told-no-mesh-file = keine Datei des Formats { $formats }: { $what }
told-truncated = die Datei ist unvollständig: { $why }
told-truncated-detail = die Datei ist unvollständig (Einzelheit auf Englisch: { $detail })
told-invalid = keine gültige { $format }-Datei: { $why }
told-invalid-detail = keine gültige { $format }-Datei (Einzelheit auf Englisch: { $detail })
told-too-large = { $what }; erlaubt sind höchstens { $limit } (limits.{ $key })
told-no-solid = { $name } ist kein Volumenkörper: { $why }
told-no-triangles = das Netz hat keine Dreiecke
told-no-volume = das Netz schließt kein Volumen ein
told-vertex-not-finite = Eckpunkt { $vertex } hat eine Koordinate, die keine endliche Zahl ist
told-triangle-not-finite = Dreieck { $triangle } hat eine Koordinate, die keine endliche Zahl ist
told-bad-index = Dreieck { $triangle } nennt Eckpunkt { $vertex }, es gibt aber nur { $vertices }
told-far-vertex = Eckpunkt { $vertex } von { $name } liegt mehr als 1,05 km vom Ursprung entfernt

## What to do with a file that cannot be read

told-copy-whole-again = Die ganze Datei noch einmal kopieren; ist auch das Original abgeschnitten, sie aus dem CAD-Programm neu exportieren.
told-export-binary = Sie aus dem CAD-Programm neu exportieren, binär als { $formats }.
told-make-smaller = Sie verkleinern oder in mehreren Dateien ablegen; oder limits.{ $key } in der Konfiguration erhöhen, nestd neu laden und die Datei erneut ablegen.
told-nothing-to-print-in-it = Es ist nichts Druckbares darin: das Teil selbst exportieren, als Volumenkörper oder geschlossenes Netz.
told-no-thickness = Eine Fläche ohne Dicke ist nicht druckbar: ihr im CAD-Programm eine Dicke geben und neu exportieren.
told-move-to-origin = Das Teil im CAD-Programm zum Ursprung verschieben oder die richtige Einheit in einem Ticket angeben; dann erneut ablegen.
told-export-part-as = Das Teil aus dem CAD-Programm als { $formats } exportieren und das ablegen.
told-unpack-formats = Sie entpacken und die Dateien darin ({ $formats }) ablegen.
told-unpack-files = Sie entpacken und die Dateien darin ablegen.
told-unpack-packages = Es entpacken und die Pakete darin ablegen.
told-save-plain-text = Sie als reinen Text (ASCII oder UTF-8) speichern oder das Teil als binäres STL exportieren.
told-no-shape-in-it = Sie enthält keine druckbare Form: das Teil als { $formats } ablegen.
told-get-from-server = Die Datei im Browser öffnen und lesen, was der Server sagt; dort anmelden, das Teil noch einmal herunterladen und ablegen.
told-drop-right-extension = Dateien der Formate { $formats } mit der richtigen Endung ablegen; andere Formate aus dem CAD-Programm exportieren.
told-copy-again-or-export = Sie noch einmal kopieren; ist auch das Original leer, sie neu exportieren.
told-git-lfs-pull = `git lfs pull` ausführen und sie dann ablegen.
told-drop-owner-file = Die Datei ablegen, zu der sie gehört.
told-delete-colours = Sie löschen: die OBJ-Datei wird ohne Farben eingelesen.
told-export-core = Das Teil als einfaches 3MF (Kernspezifikation) oder als STL exportieren.
told-export-from-slicer-or-cad = Was gedruckt werden soll, aus dem Slicer oder CAD-Programm als STL exportieren und das ablegen.
told-export-from-slicer = Was gedruckt werden soll, aus dem Slicer als STL exportieren und das ablegen.
told-beams-to-mesh = Die Stäbe im CAD-Programm in ein Netz umwandeln und das exportieren.
told-without-password = Sie ohne Passwort speichern und das ablegen.
told-save-plain-threemf = Sie in dem Programm öffnen, das sie geschrieben hat, und als einfaches 3MF speichern.
told-cut-in-slicer = Es im Slicer ausschneiden (boolesche Operation; auch sein STL-Export des Objekts schneidet), das Ergebnis ansehen und das ablegen.
told-make-model-volume = Das Volumen, das gedruckt werden soll, im Slicer zu einem Teil machen und neu exportieren.
told-same-unit = In beiden dieselbe Einheit angeben oder das Paket mit einem Ticket ablegen, das die Einheit nennt.
told-export-triangles = Das Teil noch einmal nur mit Dreiecken exportieren, oder als STL oder 3MF.
told-take-out-of-document = Das aus dem Dokument des Pakets nehmen, oder das Modell selbst mit einem Ticket ablegen; dann erneut ablegen.

## What a file is in place of a part

told-file-is-empty = die Datei ist leer
told-is-packed-amf = sie ist eine gepackte AMF-Datei
told-is-zip-named = sie ist ein ZIP-Paket mit der Endung `.{ $named }`
told-is-text = sie ist Text ohne `solid`
told-is-no-obj-text = sie ist kein Text, wie es eine OBJ-Datei ist
told-no-ply-line = sie beginnt nicht mit der Zeile `ply`
told-first-bytes-no-extension = ihre ersten Bytes sind nicht bekannt, und ihr Name hat keine Endung
told-first-bytes-nor-name = weder ihre ersten Bytes noch ihre Endung `.{ $extension }` sind bekannt
told-is-lfs-pointer = sie ist ein Verweis von Git LFS, nicht die Datei selbst
told-is-utf16 = sie ist Text in UTF-16
told-is-off = sie ist eine OFF-Datei
told-is-appledouble = sie ist eine AppleDouble-Begleitdatei von macOS
told-is-step = sie ist eine STEP-Datei
told-is-gltf = sie ist eine glTF-Datei
told-is-xml = sie ist XML ohne Paket (AMF?)
told-is-web-page = sie ist eine Webseite (HTML), nicht das Teil selbst
told-is-pdf = sie ist eine PDF-Datei
told-is-picture = sie ist ein Bild
told-is-archive = sie ist ein Archiv
told-is-cad = sie ist eine Datei eines CAD-Programms
told-is-colours = sie enthält die Farben einer OBJ-Datei
told-is-for-printer = sie ist eine Datei für einen Drucker, kein Teil
told-is-document = sie enthält Text, keine Form
told-is-of-extension = { $what } (`.{ $extension }`)
told-is-zip-of-parts = sie ist ein ZIP-Archiv mit Teiledateien
told-is-package-in-package = sie ist ein Paket in einem Paket

## What is wrong in a file

told-bytes-long = sie ist { $bytes } Bytes lang
told-separate-pieces = { $name } besteht aus { $pieces } getrennten Stücken
told-too-many-triangles = sie hat zu viele Dreiecke
told-too-many-vertices = sie hat zu viele Eckpunkte
told-too-many-objects = sie hat zu viele Objekte
told-too-many-components = sie hat zu viele Komponenten
told-too-many-instances = sie hat zu viele Instanzen von Komponenten
told-too-many-items = sie hat zu viele Build-Einträge
told-too-deep = ihre Komponenten sind zu tief verschachtelt
told-instances-triangles = alle ihre Instanzen zusammen haben zu viele Dreiecke
told-has-triangles = sie hat { $count } Dreiecke
told-unpacked-too-large = das entpackte Paket hat zu viele Bytes
told-package-entries = das Paket hat { $count } Einträge
told-package-encrypted = das Paket ist verschlüsselt
told-package-damaged = das ZIP-Paket ist beschädigt ({ $detail })
told-package-packed = das Paket ist auf eine Art gepackt, die 3MF nicht erlaubt ({ $detail })
told-zip-end-missing = das Ende des ZIP-Pakets fehlt
told-no-relationships = das Paket hat keine Beziehungen, also kein 3D-Modell
told-no-model = das Paket hat kein 3D-Modell
told-no-build-items = sie hat keine Build-Einträge, also nichts zu drucken
told-no-item-to-print = keiner ihrer Build-Einträge ist ein druckbares Teil
told-no-object = es gibt kein Objekt { $object }
told-component-of-itself = Objekt { $object } ist eine Komponente seiner selbst
told-beam-lattice = Objekt { $object } ist ein Stabgitter: seine Form steckt in Stäben, nicht in Dreiecken
told-extension-required = die Datei verlangt etwas, das nicht unterstützt wird ({ $what }): { $name }
told-an-extension = eine Erweiterung
told-encrypted-content = verschlüsselter Inhalt
told-negative-volume = { $name } hat das negative Volumen { $volume }: es ist auszuschneiden, und nestd schneidet nicht
told-no-model-volume = { $name } hat kein Modellvolumen, nur { $left }
told-manifest-unit = ihre Einheit ist { $unit }, und das Manifest sagt { $other }
told-header-too-short = { $bytes } Bytes sind zu wenig für einen binären STL-Kopf
told-only-triangles = nur { $present } von { $count } Dreiecken sind in der Datei
told-second-stl = auf die { $count } Dreiecke des ersten STL folgt ein zweites
told-ascii-follows = auf ihre { $count } Dreiecke folgt ein ASCII-STL
told-more-triangles-follow = { $count } Dreiecke sind gezählt, aber { $more } weitere folgen
told-ends-within-facet = sie endet mitten in Facette { $number }
told-ends-within-vertex = sie endet mitten in einem Eckpunkt
told-ends-within-line = sie endet mitten in Zeile { $number }
told-ends-in-line = sie endet in Zeile { $number }, vor { $wanted }
told-line-why = Zeile { $number }: { $why }
told-facet-vertices = Facette { $number } hat { $found } Eckpunkte statt 3
told-expected-found = erwartet war { $wanted }, gefunden wurde { $found }
told-unfinished-copy = sie ist eine unfertige Kopie, { $why }
told-ends-in-zeros = die mit Nullen endet
told-zeros-from = mit lauter Nullen ab Byte { $at }
told-zeros-in-line = mit Nullen in Zeile { $number }
told-last-zeros = deren letzte { $run } von { $count } Dreiecken Nullen sind
told-zeros-between = deren Dreiecke { $first } bis { $last } von { $count } Nullen sind
told-no-face = sie enthält keine Fläche: an Punkten und Linien ist nichts zu drucken
told-no-face-points = sie enthält keine Fläche: an Punkten ist nichts zu drucken
told-free-form-surface = sie enthält eine Freiformfläche
told-free-form-curve = sie enthält eine Freiformkurve
told-names-other-file = sie nennt eine weitere Datei, die dazugehört
told-in-line = { $what } (Zeile { $number })
told-ends-before-header = sie endet vor ihrem `end_header`
told-entries-of = sie hat { $count } von { $all } Einträgen des Elements { $name }

## Why a part cannot be printed on a machine

told-not-closed = { $name }: das Netz ist nicht geschlossen ({ $why }); es ist nicht bekannt, was innen ist. Es wird nicht ausgebessert, denn { $rest }. Es reparieren oder in der Maschine { $machine } mesh_errors = "warn" setzen.
told-mendable = { $name }: das Netz ist nicht geschlossen ({ $why }); es ist nicht bekannt, was innen ist. Es kann ausgebessert werden: { $what }. { $remedy }
told-mend-remedy = `nestd mend { $part }` oder der Knopf auf seiner Seite lässt es ausbessern und drucken.
told-mend-remedy-ticket = Ein Ticket mit mend = true lässt es ausbessern und drucken.
told-mend-holes =
    { $n ->
        [one] { $n } Loch von höchstens { $mm } mm geschlossen
       *[other] { $n } Löcher von höchstens { $mm } mm geschlossen
    }
told-mend-added =
    { $n ->
        [one] { $n } Dreieck ergänzt
       *[other] { $n } Dreiecke ergänzt
    }
told-mend-turned =
    { $n ->
        [one] { $n } Dreieck gewendet
       *[other] { $n } Dreiecke gewendet
    }
told-mend-left-out =
    { $n ->
        [one] { $n } Dreieck weggelassen
       *[other] { $n } Dreiecke weggelassen
    }
told-mend-joined =
    { $n ->
        [one] { $n } Ecke verbunden
       *[other] { $n } Ecken verbunden
    }
told-mend-volume = Volumen { $before } -> { $now } cm³
told-mend-off = höchstens { $mm } mm neben der vorigen Oberfläche
told-not-mended-closed = es ist geschlossen
told-not-mended-too-large = es hat zu viele Dreiecke oder Löcher
told-not-mended-ambiguous = wo sich mehr als zwei Dreiecke in einer Kante treffen, ist nicht bekannt, welche zusammengehören
told-not-mended-one-sided = ein Stück davon hat nur eine Seite
told-not-mended-large-hole = ein Loch von { $mm } mm ist zu groß, um zu wissen, was dort war
told-not-mended-opening = eine Öffnung von { $mm } mm hat ringsum scharfe Kanten und kann gewollt sein
told-not-mended-crossing = was seine Löcher schlösse, ginge durch seine Oberfläche
told-not-mended-doubt = die Oberfläche biegt sich um seine Löcher zu stark, um zu wissen, was dort war
told-not-mended-sheet = ein Stück davon ist eine Fläche ohne Volumen
told-not-mended-cavity = ob ein Stück in einem anderen ein Hohlraum ist, ist nicht bekannt
told-open-edges =
    { $n ->
        [one] { $n } offene Kante
       *[other] { $n } offene Kanten
    }
told-non-manifold-edges =
    { $n ->
        [one] { $n } Kante mit mehr als zwei Dreiecken
       *[other] { $n } Kanten mit mehr als zwei Dreiecken
    }
told-inconsistent-edges =
    { $n ->
        [one] { $n } Kante mit gegensinnigen Dreiecken
       *[other] { $n } Kanten mit gegensinnigen Dreiecken
    }
told-too-many-copies = Sie verlangt { $copies } Stück; eine Datei darf höchstens { $limit } verlangen (limits.max_copies). Sie mit weniger erneut ablegen, oder diese Grenze in der Konfiguration erhöhen und nestd neu laden.
told-needs-more-room = { $name }: braucht in der günstigsten erlaubten Lage ({ $rule }) { $x } x { $y } x { $z } mm; der Bauraum von { $machine } hat { $a } x { $b } x { $c } mm. { $remedy }
told-larger-machine = Es für eine größere Maschine ablegen oder teilen; hält sein Ticket es aufrecht oder fest, passt vielleicht eine freiere Ausrichtung.
told-other-unit-fits = In { $unit } gelesen wäre es { $x } x { $y } x { $z } mm und würde passen: ist das gemeint, es mit einem Ticket ablegen, in dem unit = "{ $unit }" steht.
told-no-rotation = { $name }: keine Drehung erfüllt alle Regeln der Ausrichtung ({ $rule }). Eine davon aus dem Ticket nehmen und beide erneut ablegen.
told-no-place-alone = Es wurde versucht, fand aber im leeren Bauraum von { $machine } keinen Platz. Es für eine größere Maschine ablegen, oder mit freierer Ausrichtung oder kleinerem clearance_mm im Ticket.
told-search-failed = Die Suche ist an ihm gescheitert ({ $detail }). Es zurückholen, um es noch einmal zu versuchen; scheitert auch das, es neu exportieren.
told-reader-failed = Das Einlesen ist an ihr gescheitert ({ $detail }). Sie neu exportieren, als { $formats }; scheitert auch das, sie den Entwicklern von nestd schicken.
told-read-timeout = { $name }: das Einlesen hat nestd zweimal beendet, und dann war ein eigener Prozess nach { $minutes } Minuten nicht fertig. Sie mit weniger Dreiecken oder Stücken exportieren und erneut ablegen.
told-read-crash = { $name }: das Einlesen hat nestd zweimal beendet, und dann endete ein eigener Prozess mit { $bytes } Bytes Speicher (limits.read_memory_bytes) { $what }. Die Datei mit weniger Dreiecken oder Stücken exportieren und erneut ablegen, oder diese Grenze erhöhen und das Teil zurückholen.
told-by-signal = durch Signal { $signal }
told-with-exit-code = mit dem Code { $code }
told-file-not-kept = Seine Datei wird nicht mehr aufbewahrt. Sie erneut ablegen.
told-file-not-here = Die Datei ist nicht hier, denn nestd hat sie nicht mehr vollständig ({ $detail }).
told-size-differs = { $name } war beim ersten Einlesen { $before } mm groß und ist jetzt { $now } mm groß
told-mend-differs = das Netz von { $name } wird jetzt nicht so ausgebessert wie beim ersten Einlesen
told-stored-missing = die gespeicherte Datei von { $name } fehlt
told-stored-damaged = die gespeicherte Datei von { $name } war beschädigt und liegt jetzt als { $aside } beiseite

## Warnings about a file

told-mesh-not-closed = Das Netz ist nicht geschlossen: { $why }.
told-mended-by = Das Netz wurde ausgebessert, wie { $who } es erlaubt: { $what }.
told-mended-by-person = Das Netz wurde ausgebessert, wie { $name } es erlaubt: { $what }.
told-mend-by-ticket = sein Ticket
told-mend-by-setting = mesh_errors seiner Maschine
told-far-from-origin = Seine Koordinaten liegen so weit vom Ursprung der Datei, dass 32-Bit-Zahlen dort { $step } mm auseinander liegen: seine Einzelheiten können um so viel abweichen. Es im CAD-Programm zum Ursprung verschieben und neu exportieren.
told-turned-inside-out = die Oberfläche war umgestülpt und wurde gewendet
told-suspicious-size = auffällige Größe: die größte Ausdehnung ist { $size } mm, gelesen in { $unit } (andere Einheiten, auf Englisch: { $detail })
told-no-endsolid = der Datei fehlt `endsolid`: vielleicht fehlt ihr Ende
told-several-solids = die Datei enthält { $solids } Körper; sie sind ein Teil aus { $facets } Dreiecken
told-objects-one-part = die Datei enthält { $objects } Objekte; sie sind ein Teil
told-bytes-ignored =
    { $n ->
        [one] { $n } Byte hinter dem letzten Dreieck wird ignoriert
       *[other] { $n } Bytes hinter dem letzten Dreieck werden ignoriert
    }
told-duplicate-pieces = doppelte Stücke liegen am selben Ort: je eines bleibt, { $left } Dreiecke entfallen
told-ticket-unit-used = statt der Einheit { $other } der Datei gilt { $unit } aus dem Ticket
told-left-out-volumes = weggelassen, da kein Modellvolumen: { $names }
told-slice-stack = die Datei enthält dieses Teil auch als Schichtstapel, der ignoriert wird: die Dreiecke sind vielleicht nur eine Näherung
told-left-out-unprintable =
    { $n ->
        [one] { $n } Build-Eintrag ist als nicht druckbar markiert und entfällt
       *[other] { $n } Build-Einträge sind als nicht druckbar markiert und entfallen
    }
told-left-out-helpers =
    { $n ->
        [one] { $n } Build-Eintrag ist Stützstruktur oder Hilfsobjekt, kein Teil, und entfällt
       *[other] { $n } Build-Einträge sind Stützstrukturen oder Hilfsobjekte, keine Teile, und entfallen
    }
told-items-touch = { $why }, und jeder Eintrag wäre ein eigenes Teil an beliebigem Ort (was zusammengehört, verbunden ablegen, als ein Objekt oder als STL)
told-items-stacked =
    { $stacked } von { $n ->
        [one] { $n } Build-Eintrag liegt
       *[other] { $n } Build-Einträgen liegen
    } an einem Ort
told-item-touches = in der Datei berührt oder durchdringt es { $name }
told-too-many-items-to-see = die Datei hat zu viele Build-Einträge, um zu sehen, ob sie sich berühren

## What a person must confirm

told-is-speck = es ist { $x } x { $y } x { $z } mm groß, kleiner als { $least } mm
told-is-speck-inches = es ist { $x } x { $y } x { $z } mm groß, kleiner als { $least } mm; in Zoll statt Millimetern gelesen wäre es { $a } x { $b } x { $c } mm groß
told-is-thin = es ist { $x } x { $y } x { $z } mm groß, dünner als eine Schicht von { $layer } mm

## Why a ZIP archive was not unpacked

told-archive-cannot = Dieses Archiv kann nicht entpackt werden: { $detail }. Es noch einmal als gewöhnliche ZIP-Datei ohne Kennwort packen, oder es entpacken und den Ordner ablegen.
told-archive-twice = Dieses Archiv nennt eine Datei zweimal. Es entpacken und den Ordner ablegen.
told-archive-names-twice = Dieses Archiv nennt „{ $name }“ zweimal. Es entpacken und den Ordner ablegen.
told-archive-too-large = Dieses Archiv ist entpackt größer als erlaubt (`max_unpacked_bytes` = { $limit }, und das { $times }-fache seiner Größe je Datei). Es entpacken und den Ordner ablegen.
told-archive-entries = Dieses Archiv hat { $entries } Einträge; erlaubt sind { $limit } (`max_entries`). Es entpacken und den Ordner ablegen.
told-archive-in-archive = Dieses Archiv enthält ein weiteres Archiv, „{ $name }“. Beide entpacken und den Ordner ablegen.
told-archive-empty = Dieses Archiv enthält keine Datei. Die Teile hineinpacken und es erneut ablegen.
told-archive-outside = Dieses Archiv nennt eine Datei außerhalb, „{ $name }“. Es entpacken und die gemeinten Dateien ablegen.
told-archive-link = Dieses Archiv nennt eine Verknüpfung, „{ $name }“. Es entpacken und die gemeinten Dateien ablegen.
