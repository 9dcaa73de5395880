### Sentences about files, as they are stored in English: reading, meshes, sizes. Values named what, why, rest, remedy and formats are sentences themselves.
told-why-of = { $what } : { $why }
told-of-name = { $name } : { $why }
told-list = { $why }, { $rest }
told-lists = { $why } ; { $rest }
told-list-and = { $why }, et { $rest }
told-mesh-formats = STL, 3MF, OBJ ou PLY
told-package-formats = STL ou 3MF

## Why a file cannot be read

told-cannot-read-file = le fichier ne peut pas être lu
told-no-mesh-file = ce n’est pas un fichier { $formats } : { $what }
told-truncated = le fichier est tronqué : { $why }
told-truncated-detail = le fichier est tronqué (détail en anglais : { $detail })
told-invalid = ce n’est pas un fichier { $format } valide : { $why }
told-invalid-detail = ce n’est pas un fichier { $format } valide (détail en anglais : { $detail })
told-too-large = { $what } ; le maximum autorisé est { $limit } (limits.{ $key })
told-no-solid = { $name } n’est pas un solide : { $why }
told-no-triangles = le maillage n’a aucun triangle
told-no-volume = le maillage n’enferme aucun volume
told-vertex-not-finite = le sommet { $vertex } a une coordonnée qui n’est pas un nombre fini
told-triangle-not-finite = le triangle { $triangle } a une coordonnée qui n’est pas un nombre fini
told-bad-index = le triangle { $triangle } nomme le sommet { $vertex }, mais il n’y en a que { $vertices }
told-far-vertex = le sommet { $vertex } de { $name } est à plus de 1,05 km de l’origine

## What to do with a file that cannot be read

told-copy-whole-again = Copier à nouveau le fichier entier ; si l’original est coupé lui aussi, l’exporter à nouveau du logiciel de CAO.
told-export-binary = L’exporter à nouveau du logiciel de CAO, en binaire { $formats }.
told-make-smaller = La réduire, ou la déposer en plusieurs fichiers ; ou augmenter limits.{ $key } dans la configuration, recharger nestd et déposer à nouveau le fichier.
told-nothing-to-print-in-it = Il n’y a rien à imprimer dedans : exporter la pièce elle-même, en solide ou en maillage fermé.
told-no-thickness = Une surface sans épaisseur ne peut pas être imprimée : lui donner une épaisseur dans le logiciel de CAO et l’exporter à nouveau.
told-move-to-origin = Ramener la pièce à l’origine dans le logiciel de CAO, ou donner la bonne unité dans un ticket ; puis la déposer à nouveau.
told-export-part-as = Exporter la pièce du logiciel de CAO en { $formats }, et déposer ce fichier.
told-unpack-formats = La décompresser, et déposer les fichiers { $formats } qu’elle contient.
told-unpack-files = La décompresser, et déposer les fichiers qu’elle contient.
told-unpack-packages = Le décompresser, et déposer les paquets qu’il contient.
told-save-plain-text = L’enregistrer en texte simple (ASCII ou UTF-8), ou exporter la pièce en STL binaire.
told-no-shape-in-it = Il ne contient aucune forme à imprimer : déposer la pièce en { $formats }.
told-get-from-server = L’ouvrir dans un navigateur pour lire ce qu’a dit le serveur, s’y connecter, télécharger la pièce à nouveau et la déposer.
told-drop-right-extension = Déposer des fichiers { $formats } avec la bonne extension ; exporter les autres formats du logiciel de CAO.
told-copy-again-or-export = Le copier à nouveau ; si l’original est vide lui aussi, l’exporter à nouveau.
told-git-lfs-pull = Exécuter `git lfs pull`, puis le déposer.
told-drop-owner-file = Déposer le fichier auquel il appartient.
told-delete-colours = Le supprimer : le fichier OBJ est lu sans couleurs.
told-export-core = Exporter la pièce en 3MF simple (spécification de base) ou en STL.
told-export-from-slicer-or-cad = Exporter ce qui doit être imprimé du trancheur ou du logiciel de CAO en STL, et déposer ce fichier.
told-export-from-slicer = Exporter ce qui doit être imprimé du trancheur en STL, et déposer ce fichier.
told-beams-to-mesh = Convertir les poutres en maillage dans le logiciel de CAO, et l’exporter.
told-without-password = L’enregistrer sans mot de passe, et déposer ce fichier.
told-save-plain-threemf = L’ouvrir dans le logiciel qui l’a écrit, et l’enregistrer en 3MF simple.
told-cut-in-slicer = Le découper dans le trancheur (opération booléenne ; son export de l’objet en STL découpe aussi), regarder le résultat, et le déposer.
told-make-model-volume = Faire du volume à imprimer une pièce dans le trancheur, et l’exporter à nouveau.
told-same-unit = Donner la même unité dans les deux, ou déposer le paquet avec un ticket qui donne l’unité.
told-export-triangles = Exporter à nouveau la pièce avec des triangles seulement, ou en STL ou 3MF.
told-take-out-of-document = L’enlever du document du paquet, ou déposer le modèle lui-même avec un ticket ; puis déposer à nouveau.

## What a file is in place of a part

told-file-is-empty = le fichier est vide
told-is-packed-amf = c’est un fichier AMF compressé
told-is-zip-named = c’est un paquet ZIP nommé `.{ $named }`
told-is-text = c’est du texte sans `solid`
told-is-no-obj-text = ce n’est pas du texte, comme l’est un fichier OBJ
told-no-ply-line = il ne commence pas par la ligne `ply`
told-first-bytes-no-extension = ses premiers octets ne sont pas connus, et son nom n’a pas d’extension
told-first-bytes-nor-name = ni ses premiers octets ni son extension `.{ $extension }` ne sont connus
told-is-lfs-pointer = c’est un pointeur Git LFS, pas le fichier lui-même
told-is-utf16 = c’est du texte en UTF-16
told-is-off = c’est un fichier OFF
told-is-appledouble = c’est un fichier annexe AppleDouble de macOS
told-is-step = c’est un fichier STEP
told-is-gltf = c’est un fichier glTF
told-is-xml = c’est du XML hors d’un paquet (AMF ?)
told-is-web-page = c’est une page web (HTML), pas la pièce elle-même
told-is-pdf = c’est un fichier PDF
told-is-picture = c’est une image
told-is-archive = c’est une archive compressée
told-is-cad = c’est un fichier de logiciel de CAO
told-is-colours = il contient les couleurs d’un fichier OBJ
told-is-for-printer = c’est un fichier pour imprimante, pas une pièce
told-is-document = il contient du texte, pas une forme
told-is-of-extension = { $what } (`.{ $extension }`)
told-is-zip-of-parts = c’est une archive ZIP qui contient des fichiers de pièces
told-is-package-in-package = c’est un paquet dans un paquet

## What is wrong in a file

told-bytes-long = il fait { $bytes } octets
told-separate-pieces = { $name } se compose de { $pieces } morceaux séparés
told-too-many-triangles = il a trop de triangles
told-too-many-vertices = il a trop de sommets
told-too-many-objects = il a trop d’objets
told-too-many-components = il a trop de composants
told-too-many-instances = il a trop d’instances de composants
told-too-many-items = il a trop d’éléments de fabrication
told-too-deep = ses composants sont imbriqués trop profondément
told-instances-triangles = toutes ses instances ensemble ont trop de triangles
told-has-triangles = il a { $count } triangles
told-unpacked-too-large = le paquet décompressé a trop d’octets
told-package-entries = le paquet a { $count } entrées
told-package-encrypted = le paquet est chiffré
told-package-damaged = le paquet ZIP est endommagé ({ $detail })
told-package-packed = le paquet est compressé d’une façon que 3MF n’autorise pas ({ $detail })
told-zip-end-missing = la fin du paquet ZIP manque
told-no-relationships = le paquet n’a pas de relations, donc pas de modèle 3D
told-no-model = le paquet n’a pas de modèle 3D
told-no-build-items = il n’a pas d’éléments de fabrication, donc rien à imprimer
told-no-item-to-print = aucun de ses éléments de fabrication n’est une pièce à imprimer
told-no-object = il n’y a pas d’objet { $object }
told-component-of-itself = l’objet { $object } est un composant de lui-même
told-beam-lattice = l’objet { $object } est un treillis de poutres : sa forme est en poutres, pas en triangles
told-extension-required = le fichier exige quelque chose qui n’est pas pris en charge ({ $what }) : { $name }
told-an-extension = une extension
told-encrypted-content = un contenu chiffré
told-negative-volume = { $name } a le volume négatif { $volume } : il est à découper, et nestd ne découpe pas
told-no-model-volume = { $name } n’a pas de volume de modèle, seulement { $left }
told-manifest-unit = son unité est { $unit }, et le manifeste dit { $other }
told-header-too-short = { $bytes } octets sont trop peu pour un en-tête STL binaire
told-only-triangles = le fichier n’a que { $present } triangles sur { $count }
told-second-stl = un second STL suit les { $count } triangles du premier
told-ascii-follows = un STL ASCII suit ses { $count } triangles
told-more-triangles-follow = { $count } triangles sont comptés, mais { $more } autres suivent
told-ends-within-facet = il finit au milieu de la facette { $number }
told-ends-within-vertex = il finit au milieu d’un sommet
told-ends-within-line = il finit au milieu de la ligne { $number }
told-ends-in-line = il finit à la ligne { $number }, avant { $wanted }
told-line-why = ligne { $number } : { $why }
told-facet-vertices = la facette { $number } a { $found } sommets au lieu de 3
told-expected-found = attendu : { $wanted }, trouvé : { $found }
told-unfinished-copy = c’est une copie inachevée, { $why }
told-ends-in-zeros = qui finit par des zéros
told-zeros-from = avec seulement des zéros à partir de l’octet { $at }
told-zeros-in-line = avec des zéros à la ligne { $number }
told-last-zeros = dont les { $run } derniers triangles sur { $count } sont des zéros
told-zeros-between = dont les triangles { $first } à { $last } sur { $count } sont des zéros
told-no-face = il n’a aucune face : des points et des lignes n’ont rien à imprimer
told-no-face-points = il n’a aucune face : des points n’ont rien à imprimer
told-free-form-surface = il contient une surface libre
told-free-form-curve = il contient une courbe libre
told-names-other-file = il nomme un autre fichier qui lui appartient
told-in-line = { $what } (ligne { $number })
told-ends-before-header = il finit avant son `end_header`
told-entries-of = il a { $count } entrées sur { $all } de l’élément { $name }

## Why a part cannot be printed on a machine

told-not-closed = { $name } : le maillage n’est pas fermé ({ $why }), on ne sait donc pas ce qui est à l’intérieur. Il n’est pas réparé, car { $rest }. Le réparer, ou mettre mesh_errors = "warn" dans la machine { $machine }.
told-mendable = { $name } : le maillage n’est pas fermé ({ $why }), on ne sait donc pas ce qui est à l’intérieur. Il peut être réparé : { $what }. { $remedy }
told-mend-remedy = `nestd mend { $part }` ou le bouton de sa page le fait réparer et imprimer.
told-mend-remedy-ticket = Un ticket avec mend = true le fait réparer et imprimer.
told-mend-holes =
    { $n ->
        [one] { $n } trou de { $mm } mm au plus fermé
       *[other] { $n } trous de { $mm } mm au plus fermés
    }
told-mend-added =
    { $n ->
        [one] { $n } triangle ajouté
       *[other] { $n } triangles ajoutés
    }
told-mend-turned =
    { $n ->
        [one] { $n } triangle retourné
       *[other] { $n } triangles retournés
    }
told-mend-left-out =
    { $n ->
        [one] { $n } triangle écarté
       *[other] { $n } triangles écartés
    }
told-mend-joined =
    { $n ->
        [one] { $n } sommet joint
       *[other] { $n } sommets joints
    }
told-mend-volume = de { $before } à { $now } cm³
told-mend-off = écart de { $mm } mm au plus avec la surface d’avant
told-not-mended-closed = il est fermé
told-not-mended-too-large = il a trop de triangles ou de trous
told-not-mended-ambiguous = on ne sait pas quels triangles vont ensemble là où plus de deux se rejoignent sur une arête
told-not-mended-one-sided = un morceau n’a qu’un seul côté
told-not-mended-large-hole = un trou large de { $mm } mm est trop grand pour savoir ce qui s’y trouvait
told-not-mended-opening = une ouverture large de { $mm } mm a des arêtes vives tout autour et peut être voulue
told-not-mended-crossing = ce qui fermerait ses trous traverserait sa surface
told-not-mended-doubt = la surface se courbe trop autour de ses trous pour savoir ce qui s’y trouvait
told-not-mended-sheet = un morceau est une feuille sans volume
told-not-mended-cavity = on ne sait pas si un morceau à l’intérieur d’un autre est une cavité
told-open-edges =
    { $n ->
        [one] { $n } arête ouverte
       *[other] { $n } arêtes ouvertes
    }
told-non-manifold-edges =
    { $n ->
        [one] { $n } arête de plus de deux triangles
       *[other] { $n } arêtes de plus de deux triangles
    }
told-inconsistent-edges =
    { $n ->
        [one] { $n } arête aux triangles de sens opposés
       *[other] { $n } arêtes aux triangles de sens opposés
    }
told-too-many-copies = Il demande { $copies } exemplaires ; un fichier peut en demander au plus { $limit } (limits.max_copies). Le déposer à nouveau avec moins, ou augmenter cette limite dans la configuration et recharger nestd.
told-needs-more-room = { $name } : demande { $x } x { $y } x { $z } mm dans sa meilleure orientation autorisée ({ $rule }) ; le volume de { $machine } est de { $a } x { $b } x { $c } mm. { $remedy }
told-larger-machine = La déposer pour une machine plus grande, ou la diviser ; si son ticket la tient droite ou fixe, une orientation plus libre peut convenir.
told-other-unit-fits = Lue en { $unit }, elle ferait { $x } x { $y } x { $z } mm et tiendrait : si c’est voulu, la déposer avec un ticket qui dit unit = "{ $unit }".
told-no-rotation = { $name } : aucune rotation ne respecte toutes ses règles d’orientation ({ $rule }). En enlever une de son ticket et déposer les deux à nouveau.
told-no-place-alone = Elle a été essayée et n’a pas trouvé de place dans le volume vide de { $machine }. La déposer pour une machine plus grande, ou avec une orientation plus libre ou un clearance_mm plus petit dans son ticket.
told-search-failed = La recherche a échoué sur elle ({ $detail }). La reprendre pour essayer encore ; si cela échoue aussi, l’exporter à nouveau.
told-reader-failed = La lecture a échoué ({ $detail }). L’exporter à nouveau, en { $formats } ; si cela échoue aussi, l’envoyer aux auteurs de nestd.
told-read-timeout = { $name } : sa lecture a arrêté nestd deux fois, puis un processus à part ne l’avait pas lu après { $minutes } minutes. L’exporter avec moins de triangles ou de morceaux et le déposer à nouveau.
told-read-crash = { $name } : sa lecture a arrêté nestd deux fois, puis un processus à part doté de { $bytes } octets de mémoire (limits.read_memory_bytes) a fini { $what }. L’exporter avec moins de triangles ou de morceaux et le déposer à nouveau, ou augmenter cette limite et reprendre la pièce.
told-by-signal = par le signal { $signal }
told-with-exit-code = avec le code { $code }
told-file-not-kept = Son fichier n’est plus conservé. Le déposer à nouveau.
told-file-not-here = Le fichier n’est pas ici, car nestd ne l’a plus en entier ({ $detail }).
told-size-differs = { $name } faisait { $before } mm à la première lecture, et fait { $now } mm maintenant
told-mend-differs = le maillage de { $name } n’est pas réparé comme à la première lecture
told-stored-missing = le fichier conservé de { $name } manque
told-stored-damaged = le fichier conservé de { $name } était endommagé et est mis de côté comme { $aside }

## Warnings about a file

told-mesh-not-closed = Le maillage n’est pas fermé : { $why }.
told-mended-by = Le maillage a été réparé, avec l’accord de : { $who } ({ $what }).
told-mended-by-person = Le maillage a été réparé, avec l’accord de { $name } : { $what }.
told-mend-by-ticket = son ticket
told-mend-by-setting = mesh_errors de sa machine
told-far-from-origin = Ses coordonnées sont si loin de l’origine du fichier que les nombres de 32 bits y sont espacés de { $step } mm : ses détails peuvent s’écarter d’autant. La ramener à l’origine dans le logiciel de CAO et l’exporter à nouveau.
told-turned-inside-out = la surface était retournée et a été remise à l’endroit
told-suspicious-size = taille suspecte : la plus grande dimension est de { $size } mm, lue en { $unit } (autres unités, en anglais : { $detail })
told-no-endsolid = le fichier n’a pas de `endsolid` : sa fin manque peut-être
told-several-solids = le fichier contient { $solids } solides ; ils forment une pièce de { $facets } triangles
told-objects-one-part = le fichier contient { $objects } objets ; ils forment une pièce
told-bytes-ignored =
    { $n ->
        [one] { $n } octet après le dernier triangle est ignoré
       *[other] { $n } octets après le dernier triangle sont ignorés
    }
told-duplicate-pieces = des morceaux en double sont au même endroit : un de chaque est gardé, { $left } triangles sont écartés
told-ticket-unit-used = l’unité { $unit } du ticket remplace { $other } du fichier
told-left-out-volumes = écarté, car ce n’est pas un volume de modèle : { $names }
told-slice-stack = le fichier contient aussi cette pièce en pile de tranches, ignorée : ses triangles ne sont peut-être qu’une approximation
told-left-out-unprintable =
    { $n ->
        [one] { $n } élément de fabrication est marqué non imprimable et écarté
       *[other] { $n } éléments de fabrication sont marqués non imprimables et écartés
    }
told-left-out-helpers =
    { $n ->
        [one] { $n } élément de fabrication est un support ou une aide, pas une pièce, et est écarté
       *[other] { $n } éléments de fabrication sont des supports ou des aides, pas des pièces, et sont écartés
    }
told-items-touch = { $why }, et chaque élément serait une pièce à part, placée n’importe où (déposer joint ce qui va ensemble, en un seul objet ou en STL)
told-items-stacked =
    { $n ->
        [one] { $stacked } élément de fabrication sur { $n } est
       *[other] { $stacked } éléments de fabrication sur { $n } sont
    } au même endroit
told-item-touches = dans le fichier, elle touche ou traverse { $name }
told-too-many-items-to-see = le fichier a trop d’éléments de fabrication pour voir s’ils se touchent

## What a person must confirm

told-is-speck = elle fait { $x } x { $y } x { $z } mm, moins de { $least } mm
told-is-speck-inches = elle fait { $x } x { $y } x { $z } mm, moins de { $least } mm ; lue en pouces plutôt qu’en millimètres, elle ferait { $a } x { $b } x { $c } mm
told-is-thin = elle fait { $x } x { $y } x { $z } mm, moins qu’une couche de { $layer } mm

## Why a ZIP archive was not unpacked

told-archive-cannot = Cette archive ne peut pas être décompressée : { $detail }. La refaire en fichier ZIP ordinaire sans mot de passe, ou la décompresser et déposer le dossier.
told-archive-twice = Cette archive nomme deux fois un fichier. La décompresser, et déposer le dossier.
told-archive-names-twice = Cette archive nomme deux fois « { $name } ». La décompresser, et déposer le dossier.
told-archive-too-large = Cette archive décompressée dépasse la limite (`max_unpacked_bytes` = { $limit }, et { $times } fois sa taille par fichier). La décompresser, et déposer le dossier.
told-archive-entries = Cette archive a { $entries } entrées ; la limite est { $limit } (`max_entries`). La décompresser, et déposer le dossier.
told-archive-in-archive = Cette archive en contient une autre, « { $name } ». Décompresser les deux, et déposer le dossier.
told-archive-empty = Cette archive ne contient aucun fichier. Y mettre les pièces, et la déposer à nouveau.
told-archive-outside = Cette archive nomme un fichier hors d’elle, « { $name } ». La décompresser, et déposer les fichiers voulus.
told-archive-link = Cette archive nomme un lien, « { $name } ». La décompresser, et déposer les fichiers voulus.
