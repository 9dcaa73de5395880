mail-refused-subject = { $machine }: { $name } wurde abgelehnt
mail-refused = { $machine } nimmt die Datei { $name } nicht an:
mail-refused-of-order = { $machine } nimmt die Datei { $name } des Auftrags { $order } nicht an:
mail-refused-nameless-subject = { $machine }: eine Datei wurde abgelehnt
mail-refused-nameless = { $machine } nimmt eine abgelegte Datei nicht an:
mail-refused-several =
    { $count ->
        [one] { $machines }: { $count } Datei wurde abgelehnt
       *[other] { $machines }: { $count } Dateien wurden abgelehnt
    }
mail-at-risk-subject = { $machine }: ein Termin ist gefährdet
mail-at-risk-subject-order = Auftrag { $order } auf { $machine }: der Termin ist gefährdet
mail-at-risk = Auf { $machine } könnten Teile zu spät fertig werden:
mail-at-risk-several =
    { $count ->
        [one] { $machines }: { $count } Termin ist gefährdet
       *[other] { $machines }: { $count } Termine sind gefährdet
    }
mail-alerts-several =
    { $count ->
        [one] { $machines }: { $count } Sache braucht einen Menschen
       *[other] { $machines }: { $count } Sachen brauchen einen Menschen
    }
mail-dropped-subject = Nachrichten der Druckfarm konnten nicht zugestellt werden
mail-dropped = Nachrichten konnten nicht zugestellt werden und werden nicht noch einmal gesendet: { $what }.
mail-complete-subject = Ihr Auftrag { $order } ist fertig
mail-complete-several = Ihre Aufträge { $orders } sind fertig
mail-complete = Ihr Auftrag { $order } ist fertig. Alle Teile sind gedruckt:
mail-complete-line = { $copies } × { $name }
mail-complete-more =
    { $count ->
        [one] und { $count } weiteres Teil
       *[other] und { $count } weitere Teile
    }
mail-footer = Diese E-Mail schrieb nestd auf dem Server { $host }, wo es die Druckfarm betreibt. Das Dashboard der Farm sagt mehr.
mail-footer-customer = Diese E-Mail schrieb die Software der Druckfarm.
mail-trial-subject = Eine Test-E-Mail der Druckfarm
mail-trial = Dies ist ein Test. nestd auf dem Server { $host } kann Ihnen E-Mails über die Druckfarm senden.
