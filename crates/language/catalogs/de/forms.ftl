drop-time-needs-date = eine Uhrzeit braucht ihr Datum
no-whole-number = { $field }: „{ $text }“ ist keine ganze Zahl
files-of = Dateien: { $formats }
drop-copies = Stück je Datei; leer = wie der Name sagt (bracket_x10.stl), sonst 1
drop-due = Termin (Ende dieses Tages, wenn ohne Uhrzeit)
drop-more = Drehen, Priorität, Notiz
drop-orientation = Wie die Teile gedreht werden dürfen
orientation-machine = wie die Maschine erlaubt
drop-priority = Priorität, 0 bis 100; 100 muss in den nächsten Baujob
files-sent-to = Dateien, die an { $machine } gesendet werden
add-to = Zu { $machine } hinzufügen
orientation-free = free: beliebig
orientation-upright = upright: um die Senkrechte
orientation-axis = axis: in rechten Winkeln
orientation-fixed = fixed: wie in der Datei
form-not-of-farm = dieses Formular kommt von keiner Seite dieser Farm, wie sie jetzt ist: die Seite neu laden und noch einmal drücken
form-sent-otherwise = dieses Formular wurde schon mit anderem Inhalt gesendet: seine Seite neu laden und von dort senden
form-of-number = ein Formular mit dieser Nummer
form-sent-before = Dieses Formular wurde schon gesendet, { $time }, und wird kein zweites Mal ausgeführt. Um dasselbe noch einmal zu tun, seine Seite neu laden.
back = Zurück
add-files-to = Dateien zu { $machine } hinzufügen
add-files-text = Die Dateien kommen in den Eingangsordner von { $machine }, mit den Angaben von hier, als wären sie dorthin kopiert worden. Was sich nicht drucken lässt, wird dort abgelehnt, mit dem Grund.
no-orders-from-pages = Diese Farm nimmt keine Befehle von Seiten an; Dateien in den Eingangsordner { $folder } legen.
others-add-files = andere fügen gerade Dateien hinzu: gleich noch einmal versuchen
form-takes-files =
    ein Formular nimmt höchstens { $files ->
        [one] { $files } Datei
       *[other] { $files } Dateien
    }
no-file-chosen = keine Datei gewählt
files-were-added = Dateien hinzugefügt
file-is-there = { $file } ist im Eingangsordner von { $machine }.
file-not-added = Nicht hinzugefügt: { $why }.
file-is-taken-after = nestd nimmt eine Datei an, wenn sie sich { $secs } s lang nicht geändert hat; was sich nicht drucken lässt, wird mit dem Grund abgelehnt.
field-is-no-text = ein Feld des Formulars ist kein Text
undo = Rückgängig
done = Erledigt
refused = Abgelehnt
form-not-known-text = Dieses Formular wurde gesendet, dann wurde nestd beendet oder seine Datenbank fiel aus: es ist nicht bekannt, ob alles ausgeführt wurde. Erst nachsehen, dann die Seite neu laden und von dort noch einmal senden.
form-not-known = Nicht bekannt
such-order = dieser Befehl
takes-no-orders = diese Farm nimmt keine Befehle von Seiten an; siehe web.orders
not-answered-text = Der Dienst hat nicht geantwortet; der Befehl ist vermerkt und wird ausgeführt, sobald er läuft.
not-answered = Noch nicht beantwortet
refused-in-part = Zum Teil abgelehnt
it-is-done = Es ist erledigt.
there-is-no = nicht gefunden: { $what }
refused-but-done = Abgelehnt: { $refused }
done-all-the-same = Trotzdem erledigt: { $done }
not-understood = Diese Adresse oder dieses Formular ist nicht verständlich
correct-told = Meldung korrigieren
tell-printed = Ergebnis melden
it-prints = Druck läuft
print-again = Nachdrucken
withdraw = Aus der Warteschlange zurücknehmen
requeue = Denselben Baujob noch einmal
copies-again = Seine Stücke, in neuen Baujobs
reprint-build-text = Seine Stücke gelten als schlecht und warten wieder, ganz vorn, mit allem, was verlangt war. Sie kommen in neue Baujobs.
reprint-build = Jedes Stück nachdrucken
withdraw-text = Nur solange sein Drucker die Datei nicht abgeholt hat. Seine Stücke warten wieder, mit allem, was verlangt war. Die Maschine wird pausiert, bis jemand sie fortsetzt: so lassen sich die Stücke ändern oder stornieren.
is-taken-back = Er wird zurückgenommen.
take-back = Zurücknehmen
requeue-text = Derselbe geprüfte Baujob wird als neuer ausgegeben: dieselben Stücke am selben Platz. Stücke, die als gedruckt gelten, gelten dann als schlecht.
requeue-build = Diesen Baujob noch einmal ausgeben
second-file = Eine zweite Datei davon wurde in der Warteschlange gesehen: { $files }. Wird von dort gedruckt, die andere herausnehmen und melden, dass der Druck läuft.
second-file-unprinted = Niemand druckt die zweite Datei
print-failed = Der Druck von Baujob { $build } auf { $machine } ist fehlgeschlagen. Noch hat sich niemand darum gekümmert.
print-failed-why = Der Druck von Baujob { $build } auf { $machine } ist fehlgeschlagen: { $why }. Noch hat sich niemand darum gekümmert.
waits-for-yes = Wartet auf Freigabe
waits-for-yes-text = Er wartet auf Freigabe, bevor er ausgegeben wird.
publish-it = Freigeben
outcome-complete = vollständig
outcome-interrupted = unterbrochen: die Maschine blieb stehen
outcome-failed = fehlgeschlagen: nichts davon ist gut
the-print-is = Der Druck ist
keep-bad = Schlechte Stücke nicht nachdrucken
bad-copies-text = Schlechte Stücke warten wieder mit allem, was verlangt war; von einem fehlgeschlagenen Druck alle Stücke.
correct-outcome = Ergebnis korrigieren
tell-outcome = Ergebnis melden
unseen-build = (Baujob { $build })
build-named = Baujob { $build }
names-no-bad-copies = „{ $text }“ nennt keine schlechten Stücke: Teil = Stück angeben, zum Beispiel 7=2, 9=1
anyway = Aus der Warteschlange nehmen und trotzdem ausführen
files-are-read = Dateien davon werden gerade eingelesen: noch einmal senden, um zu stornieren, was daraus wird
cancelled-before = { $name } wurde storniert, bevor es angenommen war.
change-order = Auftrag ändern
move-to = Auf andere Maschine verschieben
change-order-text =
    Für { $parts ->
        [one] das { $parts } wartende Teil
       *[other] alle { $parts } wartenden Teile
    }. Ein leeres Feld ändert nichts.
due-example-none = Termin, zum Beispiel 2026-11-25 (Ende dieses Tages) oder 25.11.2026 17:00; none = kein Termin
priority-range = Priorität, 0 bis 100
move-order-text =
    { $parts ->
        [one] Das { $parts } wartende Teil dieses Auftrags zieht um und wird
       *[other] Die { $parts } wartenden Teile dieses Auftrags ziehen um und werden
    } dort neu eingelesen.
move-order = Auftrag verschieben
reprint-order-text = Jedes gedruckte Stück dieses Auftrags gilt als schlecht und wartet wieder, ganz vorn, mit allem, was verlangt war.
reprint-order = Jedes gedruckte Stück nachdrucken
accept-of = { $copies } von { $all } akzeptieren
close-order-text = Schließt den Auftrag ab, wie er ist: was gut, gedruckt oder in einem Baujob ist, wird akzeptiert.
close-cancels =
    { $copies ->
        [one] { $copies } wartendes Stück wird
       *[other] { $copies } wartende Stück werden
    } storniert.
close-asks-not =
    Nach { $copies ->
        [one] { $copies } abgelehntem
       *[other] { $copies } abgelehnten
    } Stück wird niemand mehr gefragt.
cancel-order-text =
    { $parts ->
        [one] { $parts } Teil wartet
       *[other] { $parts } Teile warten
    }. Stücke, die schon in Baujobs sind, bleiben dort.
cancel-order = Wartende stornieren
nothing-of-order-waits = von diesem Auftrag wartet nichts mehr
nothing-filled-in = nichts ausgefüllt
edit = Ändern
copies-wanted = Stück insgesamt, einschließlich derer in Baujobs
due-example = Termin, zum Beispiel 2026-11-25 (Ende dieses Tages) oder 25.11.2026 17:00; leer = kein Termin
no-copy-waits = Kein Stück davon wartet: es können mehr Stücke verlangt, ein anderer Kunde und eine andere Nachbearbeitung genannt werden.
change = Übernehmen
move-part-text = Alle wartenden Teile seiner Datei ziehen um und werden dort neu eingelesen.
move-part = Verschieben
copies-that-are-bad = Schlechte Stücke
reprint-part-text = Sie warten wieder, ganz vorn, mit allem, was verlangt war. Die Stücke des neuesten Baujobs werden zuerst genommen.
a-number-of-copies = keine Stückzahl
part-named = Teil { $part }
a-priority = keine Priorität
not-in-range = „{ $text }“ ist { $what } von { $least } bis { $most }
is-not-what = „{ $text }“ ist { $what }
on-these-pages = Auf diesen Seiten: { $link }.
page-of-address = eine Seite mit dieser Adresse
guard-host = diese Farm antwortet nicht auf diesen Namen; siehe web.hosts
guard-role = dafür ist die Rolle { $needed } nötig, vorhanden ist { $own }
guard-other-site = Seiten anderer Websites antwortet diese Farm nur, wenn jemand einem Link folgt, und Befehle nimmt sie nur von ihren eigenen Seiten an
guard-other-page = Befehle werden nur von den eigenen Seiten dieser Farm angenommen, und hier fragt die Seite einer anderen Website; hinter einem Proxy muss dessen Name in web.hosts stehen

drop-formats = STL, 3MF, OBJ, PLY, CAMSPEC oder ZIP
