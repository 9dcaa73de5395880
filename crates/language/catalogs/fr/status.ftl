status-drop = { $machine } : déposer ici les fichiers { $formats }.
status-now = Maintenant : { $doing }.
status-paused = EN PAUSE, par { $by } depuis le { $time } : rien ne part.
status-no-printer = Aucune imprimante n’est en service : rien ne part.
status-being-read =
    { $files ->
        [one] { $files } fichier est en lecture.
       *[other] { $files } fichiers sont en lecture.
    }
status-open-build = Plateau ouvert : { $height } mm de haut, { $share } % de la hauteur du volume.
status-while-waiting = Pendant l’attente : { $night }.
status-fires = Il part { $when }.
status-held = Le plateau ouvert attend : { $why }.
status-last-build = Dernier plateau : { $build } le { $time }, { $height } mm.
status-waiting =
    { $copies ->
        [one] { $copies } exemplaire de { $parts } attend
       *[other] { $copies } exemplaires de { $parts } attendent
    }
status-stopped = { $machine } : nestd a été arrêté le { $time } : ce dossier n’est pas lu, et rien n’est préparé. Les fichiers déposés ici seront pris quand il tournera à nouveau.
status-until-then = { $waiting } d’ici là.
status-halted = { $machine } : ce dossier n’est pas lu, et rien n’est préparé, tant que ce n’est pas réparé. Ce qui est déposé ici reste ici.
status-written = Écrit le { $time }.
status-waits-to-begin = { $machine } : nestd attend avant de commencer ; ce qui est déposé ici attend.
status-does-not-run = { $machine } : nestd ne tourne pas ; ce qui est déposé ici attend.
status-node-gone = { $machine } : le nœud { $node } sur { $host } ne tourne pas depuis { $time }. Ce qui est déposé ici attend qu’il tourne à nouveau, ou qu’un autre nœud reprenne cette machine.
attention = ATTENTION : { $what }
attention-more = ATTENTION : et { $count } de plus ; `nestd status` dit tout.
status-stamp =
    Écrit le { $time }, et renouvelé au moins { $minutes ->
        [one] chaque minute
       *[other] toutes les { $minutes } minutes
    } tant que nestd tourne : si c’est plus ancien, nestd ne tourne pas.
question-yes = Elle attend un accord : { $question }.
question-yes-remedy = `nestd confirm { $part }` l’imprime telle quelle, `nestd cancel { $part }` la refuse.
question-original = Son original manque ou est endommagé, elle n’est donc pas imprimée.
question-original-remedy = Déposer { $name } encore une fois, ou l’annuler avec `nestd cancel { $part }`.
question-copies = Combien d’exemplaires ? Elle compte pour 1.
question-copies-remedy = `{ $command }` donne la réponse, et `nestd confirm { $part }` la laisse à 1.
material-awaited = Elle attend { $material } : { $machine } est chargée en { $loaded }.
material-awaited-none = Elle attend { $material } : aucun matériau n’est annoncé sur { $machine }.
material-elsewhere = { $material } est chargé sur { $machines }.
material-nowhere = { $material } n’est chargé sur aucune machine.
material-unknown = [materials] dans nestd.toml ne nomme pas { $material }, seulement { $known }.
material-remedy = `{ $load }` dit qu’il est chargé, `nestd move { $part } --to MACHINE` déplace la pièce, `nestd edit { $part } --material NAME` la corrige.
material-lot = { $material }, lot de poudre { $lot }
status-loaded = Chargé : { $material }.
status-question = Question : combien d’exemplaires ? La pièce { $part } ({ $name }) compte pour 1 ; répondre avec `{ $command }`.
status-questions-more =
    La même question se pose pour { $parts ->
        [one] { $parts } autre pièce
       *[other] { $parts } autres pièces
    }.
release-brief =
    { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }, { $height } sur { $limit } mm de haut, densité { $density } %, environ { $hours } h d’impression
release-made-again = Le plateau { $build } est préparé à nouveau : { $why }.
release-build = Plateau { $build } : { $content }.
release-could-begin = Sur { $printer }, il pourrait commencer le { $begins } et être déballé le { $ends }.
release-not-known = On ne sait pas quand { $printer } pourrait le commencer.
release-nothing-waits = Rien d’autre n’attend.
release-copies-wait =
    { $copies ->
        [one] { $copies } exemplaire attend
       *[other] { $copies } exemplaires attendent
    } le prochain plateau.
release-late-part = { $name } (échéance { $due })
release-late-part-of = { $name }, commande { $order } (échéance { $due })
release-none-late = Aucune pièce n’y serait en retard.
release-late = Serait en retard : { $names }.
