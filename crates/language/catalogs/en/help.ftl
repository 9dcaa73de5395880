help-for = Help: { $text }
chapter-named = chapter { $name }
contents = Contents
in-this-chapter = In this chapter
chapter-before = Before: { $title }
chapter-next = Next: { $title }
search-book = Search the book
words-in-book = Words in the book
words-in-book-example = hot folder, paused, backup
no-section = No section of the book has all of these words.
count-sections =
    { $count ->
        [one] { $count } section
       *[other] { $count } sections
    }
more-sections =
    { $count ->
        [one] { $count } section more has
       *[other] { $count } sections more have
    } these words: add a word.
help-in-english = The book is in English.
