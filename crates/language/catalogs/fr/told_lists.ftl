### Sentences about tickets, order lists and names, as they are stored in English.

## What a part waits for

told-waits-because = { $name } attend, car { $why }
told-stands-beside = { $name } est à côté de { $why }
told-list-cannot-be-read = { $name } ne peut pas être lu : { $why }
told-list-not-understood = { $name } n’est pas compris : { $why }
told-list-not-understood-detail = { $name } n’est pas compris (détail en anglais : { $detail })
told-list-above-not-understood = { $name }, dans un dossier au-dessus, n’est pas compris
told-list-above-names-it = { $name }, dans un dossier au-dessus, la nomme, mais une liste vaut pour les fichiers de son propre dossier
told-list-aside-names-it = { $name }, dans un autre dossier de la commande, la nomme, mais une liste vaut pour les fichiers de son propre dossier et au-dessous
told-list-above-not-read = { $name }, dans un dossier au-dessus, est une liste que nestd ne lit pas
told-in-no-row = { $name } n’est dans aucune des { $rows } lignes de { $list }
told-below-in-no-row = { $name } n’est dans aucune des { $rows } lignes de { $list }, dans un dossier au-dessus
told-beside-list-not-understood = { $name } est à côté de { $list }, qui n’est pas comprise : { $why }
told-beside-list-detail = { $name } est à côté de { $list }, qui n’est pas comprise (détail en anglais : { $detail })
told-came-after-row = { $name } est venue après que sa ligne dans { $list } a servi pour une pièce de ce nom prise avant
told-not-clear-in-list = { $name } n’est pas clair dans { $list } : { $why }
told-rows-add-up = { $rows } lignes sont pour { $name } ; si toutes sont voulues, les additionner ou donner à chacune son nom de fichier ou son dossier, sinon en laisser une
told-row-may-be-for = la ligne { $row } peut être pour { $name } ou pour { $other } ; écrire le nom entier
told-row-folder = la ligne { $row } peut être pour { $name } ou pour { $other } ; écrire aussi son dossier, comme ici
told-ticket-not-read = { $name } n’est pas lu : un ticket porte le nom entier du fichier de la pièce suivi de .toml
told-ticket-for-several = { $name } peut être pour plusieurs pièces : lui donner le nom entier du fichier de la pièce suivi de .toml
told-list-which = { $name } ({ $why })
told-is-hidden = caché, nestd ne le lit donc pas : enlever le point au début de son nom, ou le supprimer
told-is-hard-link = un lien physique (il a un autre nom ailleurs) que tout le monde ne peut pas lire, nestd ne le lit donc pas et n’imprime rien d’après lui : déposer une copie du fichier
told-hard-link = { $name } est un lien physique (il a un autre nom ailleurs) que tout le monde ne peut pas lire, nestd ne le lit donc pas et n’imprime rien d’après lui : déposer une copie du fichier
told-unreadable-list = { $name } est illisible ({ $what }). Le déposer avec les pièces refusées à cause de lui.
told-is-no-file = { $what }, nestd ne le lit donc pas : mettre le fichier lui-même à sa place
told-a-symbolic-link = un lien symbolique
told-a-folder = un dossier
told-a-socket = une socket
told-a-named-pipe = un tube nommé
told-a-device = un périphérique
told-a-spreadsheet = un tableur
told-a-foreign-list = une liste d’un autre logiciel
told-a-document = un document
told-sheet-not-read = { $file } ({ $what }), que nestd ne lit pas : l’enregistrer en XLSX ou CSV
told-document-not-read = { $file } ({ $what }), que nestd ne lit pas : écrire à la place les fichiers et leurs nombres dans une liste (CSV ou XLSX)
told-one-list = { $names } : mettre toutes les lignes dans une seule liste

## What files wait, or came too late

told-ticket-names-missing = { $list } nomme { $names }, qui manque
told-ticket-names-missing-all = { $list } nomme { $names }, qui manquent
told-ticket-for-missing = { $ticket } est pour { $names }, qui manque
told-ticket-for-missing-all = { $ticket } est pour { $names }, qui manquent
told-list-names-refused = { $list } nomme { $names }, qui a été refusé : le déposer à nouveau
told-list-names-refused-all = { $list } nomme { $names }, qui ont été refusés : les déposer à nouveau
told-list-names-in-build = { $list } nomme { $names }, qui est déjà dans un plateau : si aucun autre fichier de ce nom n’est à imprimer, enlever ce qui est dit ici (`nestd edit` demande plus d’exemplaires)
told-list-names-in-builds = { $list } nomme { $names }, qui sont déjà dans des plateaux : si aucun autre fichier de ces noms n’est à imprimer, enlever ce qui est dit ici (`nestd edit` demande plus d’exemplaires)
told-late-several = Il est venu après la prise de sa pièce, et peut désigner plusieurs pièces : { $others }. Changer celle qui est voulue avec `nestd edit PART`.
told-late-too-late =
    Il est venu trop tard : { $name } est dans le plateau { $build } avec { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }. { $remedy }
told-late-published =
    Il est venu trop tard : { $name } est dans le plateau { $build }, publié le { $time }, avec { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }. { $remedy }
told-late-order-more = En demander { $more } de plus avec `nestd edit { $part } --copies { $wanted }`.
told-late-fewer = Il en demande moins : tant que la fabrication est dans la file, `nestd withdraw { $build }` la reprend, puis `nestd edit { $part } --copies { $wanted }` la change.
told-late-drop-both = Ce qui diffère peut être demandé à nouveau : déposer { $name } avec ce ticket, ce qui l’imprime encore une fois.
told-late-refused = Il est venu après la prise de sa pièce : { $why }
told-late-no-date = Son échéance n’en est pas une ici ({ $detail })

## Why a ticket or a list cannot be used

told-ticket-broken = le ticket { $file } ne peut pas être lu : { $why }
told-ticket-broken-detail = le ticket { $file } ne peut pas être lu (détail en anglais : { $detail })
told-two-tickets = il y a deux tickets pour une pièce, { $first } et { $second } ; en laisser un
told-unchanged-for = { $why }, et cela n’a pas changé pendant { $secs } s
told-copies-unknown-list = { $why }. Ce qui est demandé avec elle n’est pas certain, elle n’est donc pas imprimée : la déposer à nouveau avec une liste qui a une ligne pour elle, ou avec son propre ticket.
told-copies-unknown-ticket = { $why }. Ce qui est demandé avec elle n’est pas certain, elle n’est donc pas imprimée : corriger le ticket et déposer les deux à nouveau.
told-blocked-by-file = À côté se trouvait un fichier qui dit peut-être comment elle est voulue : { $why }. Cela n’a pas changé pendant { $secs } s, { $name } n’a donc pas été pris sans lui. Corriger ce fichier et déposer les deux à nouveau ; s’il ne dit rien de la pièce, la déposer seule.
told-list-unreadable = Cette liste de commande ne peut pas être lue : { $why }. La corriger et la déposer à nouveau avec ses fichiers.
told-list-no-files = Cette liste de commande ne nomme aucun fichier.
told-list-missing-files = Aucun fichier n’est venu en { $secs } s pour { $missing } lignes sur { $rows } de cette liste de commande : { $names }.
told-other-rows-served = Les autres lignes sont servies.
told-list-drop-missing = Déposer ces fichiers avec une liste pour eux.
told-list-drop-into-order = Déposer ces fichiers dans { $order } : chacun est pris comme sa ligne le dit.
told-file-never-came = { $list } nomme ce fichier, qui n’est pas arrivé.
told-drop-missing-file = Le déposer dans le dossier de sa commande : il est pris comme { $list } le dit.
told-place-taken = La pièce { $part } du même nom a pris sa place.
told-cancel-missing-file = S’il n’est pas voulu, `nestd cancel` avec le numéro de cette pièce le retire.
told-file-and-row-missing = { $list } nomme ce fichier, qui n’est pas arrivé, et sa ligne est inutilisable : { $why }.
told-drop-with-copies = Déposer le fichier avec une liste qui dit combien d’exemplaires sont voulus.
told-ticket-without-part = C’est un ticket pour une pièce { $name }, mais { $why }. Déposer la pièce et le ticket ensemble, le ticket portant le nom entier du fichier de la pièce suivi de .toml ou .json.
told-no-such-part-came = aucune n’est venue en { $secs } s
told-several-parts-called = plusieurs pièces s’appelaient { $name }, il n’a donc servi pour aucune
told-file-with-permissions = nestd ne peut pas lire ce fichier : { $why }. Le déposer à nouveau avec des droits qui permettent à nestd de le lire.
told-this-is-symlink = C’est un lien symbolique ; nestd ne suit pas les liens. Déposer le fichier lui-même.
told-this-is-folder = C’est un dossier au nom d’une pièce, d’un ticket ou d’une liste de commande, ou trop profond. Un dossier est une commande : lui donner un autre nom et le déposer directement dans le dossier de dépôt.
told-this-is-socket = C’est une socket, pas un fichier. Déposer le fichier de la pièce.
told-this-is-pipe = C’est un tube nommé, pas un fichier. Déposer le fichier de la pièce.
told-this-is-device = C’est un périphérique, pas un fichier. Déposer le fichier de la pièce.
told-one-order-list = Un dossier a une liste de commande, mais celui-ci en avait plusieurs, { $names } : mettre toutes les lignes dans une seule liste. Déposer cette liste avec les pièces refusées.
told-this-is-not-read = nestd ne lit pas ceci ({ $what }). L’enregistrer en XLSX ou CSV, et le déposer avec les pièces.
told-this-is-document = Ce document peut dire combien de pièces sont voulues, et nestd ne le lit pas. Écrire les fichiers et leurs nombres dans une liste (CSV ou XLSX), et la déposer avec les pièces.
told-this-is-surplus = nestd ne lit pas ceci ({ $what }) ; les pièces à côté suivent { $list }. Il n’y a rien à faire, sauf s’il dit autre chose : l’enregistrer alors en CSV sous ce nom.
told-workbook-beside-list = C’est un classeur à côté de la liste { $list }, que suivent les pièces. Il n’y a rien à faire, sauf si le classeur dit autre chose : déposer alors l’un des deux.
told-second-order-csv = Ce dossier a un autre order.csv, à la casse différente. Mettre toutes les lignes dans une seule liste.
told-control-in-order = { $name } porte le nom d’un fichier de commande de nestd, mais est dans un dossier de commande client. Il vaut pour toute la machine : mettre un fichier vide { $file } directement dans le dossier de dépôt.
told-control-not-empty = { $name } porte le nom d’un fichier de commande de nestd, mais n’est pas vide ({ $bytes } octets), rien n’a donc été fait. Mettre un fichier vide de ce nom dans le dossier de dépôt.
told-longer-than = il dépasse { $bytes } octets
told-no-utf8 = ce n’est pas du texte en UTF-8
told-copies-range = copies = { $copies } ; il faut de 1 à { $most }
told-priority-range = priority = { $priority } ; il faut de 0 à { $most }
told-clearance-range = clearance_mm = { $clearance } ; il faut de 0 à { $most }
told-whole-number = { $word } = { $value } ; il faut un nombre entier comme 10
told-a-number = { $word } = { $value } ; il faut un nombre comme 2.5
told-no-quotes = { $word } = { $value } est du texte ; l’écrire sans guillemets : { $word } = { $number }
told-number-without-quotes = { $word } = { $value } ; il faut un nombre sans guillemets, comme 10
told-date-format = due = { $value } ; il faut une date comme 2026-11-25 ou un instant comme 2026-11-25T17:00:00Z
told-date-years = due = { $value } ; il faut une date comme 2026-11-25 ou un instant comme 2026-11-25T17:00:00Z, dans les années { $first } à { $last }
told-no-whole-number = { $word } = { $value } n’est pas un nombre entier
told-no-number = { $word } = { $value } n’est pas un nombre
told-unit-word = unit = { $value } ; il faut micron, mm, cm, inch, foot ou m
told-date-of-list = due = { $value } ; il faut une date comme 2026-11-25 ou 25.11.2026, au besoin avec une heure comme 17:00
told-two-dates = due = { $value } peut être deux dates ; l’écrire 2026-11-25
told-row-of = dans la ligne de { $name } : { $why }
told-row-of-detail = dans la ligne de { $name } (détail en anglais : { $detail })
told-row-cells = elle a { $cells } cellules pour { $columns } colonnes
told-row-path = elle nomme un chemin ; une liste vaut pour les fichiers de son propre dossier
told-row-empty = sa ligne est vide
told-sheets-empty = ses feuilles sont vides
told-two-columns = elle a deux colonnes pour { $column }
told-no-columns = aucune de ses lignes ne nomme ses colonnes, au moins file et copies ; sont connues { $columns }, et leurs mots dans d’autres langues
told-workbook-locked = elle a un mot de passe, ou est d’un ancien type ; l’enregistrer sans mot de passe en XLSX, ou en CSV
told-workbook-damaged = comme classeur, elle est endommagée ({ $detail })
told-list-cannot-be-split = la liste ne se divise pas en lignes ; l’enregistrer à nouveau en UTF-8, avec un en-tête et des virgules

## Warnings and questions about a part

told-taken-without-list = Elle a été prise sans sa liste de commande : { $why }.
told-column-ignored = La colonne { $name } de sa liste de commande est inconnue de nestd et a été ignorée.
told-columns-ignored = Les colonnes { $names } de sa liste de commande sont inconnues de nestd et ont été ignorées.
told-line-above-not-read = La ligne { $line } au-dessus du tableau de sa liste de commande n’a pas été lue.
told-priorities-low = La plus haute priorité de sa liste de commande est { $priority }, sur 100 pour la pièce la plus urgente : c’est moins que les 50 d’une pièce sans priorité. Changer la pièce avec `nestd edit PART --priority N` là où elle est plus urgente.
told-copies-question = Combien d’exemplaires ? Pris comme 1 exemplaire, car { $why }. Un ticket avec `copies = N` le dit.
told-copies-taken = Pris comme 1 exemplaire, car { $why }. Un ticket avec `copies = N` le dit.
told-print-question = Faut-il l’imprimer ? Elle attend un accord, car { $why }.
told-row-without-copies = sa ligne dans { $list } ne donne pas le nombre d’exemplaires
told-in-folder-called = elle est dans un dossier nommé { $name }
told-name-says = son nom dit { $words }
told-row-says = sa ligne dans { $list } dit { $words }
told-name-unclear = son nom dit { $words }, ce qui n’est pas un nombre clair d’exemplaires de 1 à { $most }
told-name-many = son nom dit { $words }, ce qui est plus qu’un nom seul ne peut demander
told-name-no-utf8 = son nom n’est pas du texte en UTF-8, un nombre n’y est donc pas lisible
told-name-of-part = { $file } (pièce { $part })
told-sync-conflict-part = son nom dit qu’un logiciel de synchronisation a trouvé deux versions de { $who }
told-sync-conflict = son nom dit qu’un logiciel de synchronisation a trouvé deux versions de { $name }
told-name-of-backup-part = son nom est celui d’une sauvegarde de { $who }
told-name-of-backup = son nom est celui d’une sauvegarde de { $name }
told-name-of-copy-part = son nom est celui d’une copie de { $who }
told-name-of-copy = son nom est celui d’une copie de { $name }
told-copy-came-first-part = { $who } porte le nom d’une copie d’elle
told-copy-came-first = { $name } porte le nom d’une copie d’elle
told-other-format-part = c’est peut-être { $who } dans un autre format
told-other-format = c’est peut-être { $name } dans un autre format
told-put-back-by-sync = elle a le dossier, le nom, les octets et l’heure de la pièce { $part } ; un logiciel de synchronisation a peut-être remis ce qui était déjà pris
told-took-place = elle a pris la place des pièces { $names }, et rien ne dit combien sont voulues
told-moved-namesake = la pièce { $part } de ce nom dans sa commande est passée à { $machine }, et celle-ci est peut-être plus récente
told-same-file-other-unit = Le même fichier que la pièce { $part }, mais dans une autre unité : c’est une pièce d’une autre taille.
told-same-file-more = Le même fichier que la pièce { $part } : pris comme exemplaires de plus.
told-same-file-refused = C’est le même fichier que la pièce { $part }, et cette machine ne prend aucun fichier deux fois. Si plus d’exemplaires sont voulus, mettre duplicates = "warn" dans le profil { $machine }, recharger nestd et la reprendre.
told-written-later = On a encore écrit dans ce fichier après sa prise, il a donc été pris encore une fois, entier. Ce qui a été pris d’abord est une pièce antérieure du même nom : si les deux sont là, annuler celle-là.
