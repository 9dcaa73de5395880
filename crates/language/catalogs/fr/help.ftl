help-for = Aide : { $text }
chapter-named = chapitre { $name }
contents = Sommaire
in-this-chapter = Dans ce chapitre
chapter-before = Avant : { $title }
chapter-next = Suite : { $title }
search-book = Chercher dans le manuel
words-in-book = Mots du manuel
words-in-book-example = hot folder, paused, backup
no-section = Aucune section du manuel ne contient tous ces mots.
count-sections =
    { $count ->
        [one] { $count } section
       *[other] { $count } sections
    }
more-sections =
    { $count ->
        [one] { $count } autre section contient
       *[other] { $count } autres sections contiennent
    } ces mots : ajouter un mot.
help-in-english = Le manuel est en anglais.
