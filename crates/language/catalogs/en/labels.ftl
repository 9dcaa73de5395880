labels-for = For
labels-of-bins = bins: one for each order
labels-of-bags = bags: one for each part
label-sheet = Sheet
labels-used = Labels used up on the first sheet
open-pdf = Open the PDF
labels-bins-bags = Labels for bins and bags
labels-bags = Labels for bags
labels-of-build = Labels of build { $build }
labels-of-order = Labels of order { $order }
part-to-label = part to label
sheet-roll = Roll of 62 mm
bin-with = Bin { $number }: { $content }
copies-of-build =
    { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    } of build { $build }
labels-lack = No font of this server has these letters: { $letters }.
labels-lack-remedy = Install a font that has them on the server, such as fonts-noto-cjk or fonts-ipafont-gothic on Debian; nothing needs to be restarted.
labels-with-boxes = Print boxes in their place
copies-number-not-known = number of copies not known
manufacturing-record = Manufacturing record
record-of-part = Record of part { $part }, { $name }
record-empty = No copy of it stands in a proved build yet.
labelled-text = { $label }: { $text }
turned-not = as in the file
turned-about = { $degrees }° about { $axis }
