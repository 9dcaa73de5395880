help-for = Hilfe: { $text }
chapter-named = Kapitel { $name }
contents = Inhalt
in-this-chapter = In diesem Kapitel
chapter-before = Zurück: { $title }
chapter-next = Weiter: { $title }
search-book = Im Buch suchen
words-in-book = Wörter im Buch
words-in-book-example = hot folder, paused, backup
no-section = Kein Abschnitt des Buchs enthält alle diese Wörter.
count-sections =
    { $count ->
        [one] { $count } Abschnitt
       *[other] { $count } Abschnitte
    }
more-sections =
    { $count ->
        [one] { $count } weiterer Abschnitt enthält
       *[other] { $count } weitere Abschnitte enthalten
    } diese Wörter: ein Wort hinzufügen.
help-in-english = Das Handbuch ist auf Englisch.
