labels-for = Pour
labels-of-bins = bacs : une par commande
labels-of-bags = sachets : une par pièce
label-sheet = Planche
labels-used = Étiquettes déjà prises sur la première planche
open-pdf = Ouvrir le PDF
labels-bins-bags = Étiquettes pour bacs et sachets
labels-bags = Étiquettes pour sachets
labels-of-build = Étiquettes du plateau { $build }
labels-of-order = Étiquettes de la commande { $order }
part-to-label = pièce à étiqueter
sheet-roll = Rouleau de 62 mm
# On the PDF, whose font has no narrow no-break space.
bin-with = Bac { $number } : { $content }
copies-of-build =
    { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    } du plateau { $build }
labels-lack = Aucune police de ce serveur n’a ces caractères : { $letters }.
labels-lack-remedy = Installer sur le serveur une police qui les a, par exemple fonts-noto-cjk ou fonts-ipafont-gothic sous Debian ; rien n’est à redémarrer.
labels-with-boxes = Imprimer des cases à leur place
copies-number-not-known = quantité inconnue
manufacturing-record = Dossier de fabrication
record-of-part = Dossier de fabrication de la pièce { $part }, { $name }
record-empty = Aucun exemplaire n’est encore dans un plateau vérifié.
labelled-text = { $label } : { $text }
turned-not = comme dans le fichier
turned-about = { $degrees }° autour de { $axis }
