machine-unavailable = indisponible : { $trouble }
machine-paused = mise en pause par { $by }
free-now = libre maintenant
build-is-proved =
    le plateau { $build } est vérifié ({ $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    })
build-awaits-yes =
    le plateau { $build } attend un accord ({ $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    })
build-is-searched =
    recherche en cours pour le plateau { $build } ({ $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    })
reading-files =
    lecture de { $files ->
        [one] { $files } fichier
       *[other] { $files } fichiers
    }
collecting-copies =
    collecte de { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
copies-await-material =
    { $copies ->
        [one] { $copies } exemplaire attend
       *[other] { $copies } exemplaires attendent
    } { $material }
copies-await-answer =
    { $copies ->
        [one] { $copies } exemplaire attend
       *[other] { $copies } exemplaires attendent
    } une réponse
print-times-set = { $per_mm } h par mm et { $hours } h, d’après les réglages
print-times-learned =
    { $per_mm } h par mm et { $hours } h, d’après { $prints ->
        [one] { $prints } impression
       *[other] { $prints } impressions
    }
printer-free-from = libre dès { $time }
printer-closed = fermé jusqu’à { $time }
printer-never-open = son calendrier ne rouvre plus
printer-ended = le plateau { $build } devrait être fini depuis { $until } environ : personne n’a signalé le résultat
printer-prints-estimated = imprime le plateau { $build } jusque vers { $until } (estimation)
printer-prints = imprime le plateau { $build } jusque vers { $until }
printer-cools-estimated = laisse refroidir le plateau { $build } jusque vers { $until } (estimation)
printer-cools = laisse refroidir le plateau { $build } jusque vers { $until }
printer-expects = le plateau { $build } est préparé pour elle
printer-queued-until = le plateau { $build } est dans sa file d’attente et pourrait commencer { $time }
printer-queued = le plateau { $build } est dans sa file d’attente
then-more-builds =
    puis { $count ->
        [one] { $count } autre plateau
       *[other] { $count } autres plateaux
    }
printer-down = hors service depuis { $since }, par { $by }
fires-when-full-or = quand il est plein, ou le { $at } si plus rien n’arrive (le { $latest } au plus tard), { $content } : { $why }
fires-when-full = quand il est plein, le { $latest } au plus tard, { $content } : { $why }
fires-due = une échéance approche
fires-due-of = échéance de { $name }
fires-at = à { $time }
fires-waited = attente assez longue
with-copies-high =
    avec { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }, hauteur { $height } mm
with-copies =
    avec { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
night-goes-on = se poursuit
night-stands-still = s’arrête : plus de temps rapporte trop peu
night-used-up = s’arrête : son temps est épuisé
night-given-up = recherche abandonnée
night-since-arrival = { $gain } depuis la dernière arrivée, { $state }
night-gain = { $gain } mm plus bas après { $secs } s de CPU
night-no-gain = pas plus bas après { $secs } s de CPU
held-queue-full = la file d’attente est pleine (queue_depth = { $depth }) : il part quand une imprimante prend un fichier, quand le résultat d’un plateau de la file est signalé, ou si on le lance
name-and-more = { $name } et { $count } de plus
risk-due-done = échéance { $due }, { $word }, fin vers { $done } : { $why }
risk-due = échéance { $due }, { $word } : { $why }
about-height = env. { $height }
plan-paused = { $machine } : rien ne part, la machine est en pause.
plan-unavailable = { $machine } : rien ne part, la machine est indisponible.
plan-no-printer = { $machine } : rien ne part et aucune impression ne commence tant qu’une imprimante n’est pas remise en service (nestd printer NAME up) : toutes sont hors service.
plan-nothing = { $machine } : rien n’attend et rien n’est en impression.
plan-done = { $machine } : si plus rien n’arrive, tout est terminé { $time }.
plan-unknown = { $machine } : on ne sait pas quand les plateaux seront terminés.
plan-unplanned =
    { $parts ->
        [one] { $parts } pièce ne peut encore aller dans aucun plateau : elle n’est pas lue, attend une réponse ou son matériau, ou son fichier manque.
       *[other] { $parts } pièces ne peuvent encore aller dans aucun plateau : elles ne sont pas lues, attendent une réponse ou leur matériau, ou leur fichier manque.
    }
plan-heights-usual = Les hauteurs marquées « env. » suivent la densité habituelle.
plan-heights-learned =
    Les hauteurs marquées « env. » suivent { $builds ->
        [one] le dernier plateau
       *[other] les { $builds } derniers plateaux
    }.
count-machines =
    { $count ->
        [one] { $count } machine
       *[other] { $count } machines
    }
count-copies-wait =
    { $count ->
        [one] { $count } exemplaire en attente
       *[other] { $count } exemplaires en attente
    }
count-builds-in-work =
    { $count ->
        [one] { $count } plateau en préparation
       *[other] { $count } plateaux en préparation
    }
halted = arrêté : le registre { $fault }
ledger-is-damaged = est endommagé
ledger-has-lost = a perdu des modifications
ledger-was-replaced = a été supprimé, remplacé ou écrasé
ledger-is-taken-over = est servi par un autre nestd à la place de celui-ci
silent-locked = { $by } empêche de modifier le registre : nestd attend que ce soit fini, ou arrêté
silent-disk = Si le disque du dossier d’état est plein, libérer de la place
silent-database = L’accès à la base de données est coupé ou lent, ou toutes les modifications attendent une connexion, que ses alertes nomment alors

## Why a part was refused

cause-format = son format n’est pas connu, ou le fichier est tronqué
cause-not-closed = la surface n’est pas fermée
cause-mendable = la surface n’est pas fermée, et peut être réparée
cause-too-large = la pièce ne tient pas dans la machine
cause-limit = le fichier dépasse une limite
cause-ticket = son ticket ou sa liste est faux, ou n’appartient à aucune pièce
cause-document = c’est un document, pas une pièce
cause-missing = son fichier n’est jamais arrivé
cause-duplicate = le même fichier a déjà été déposé
cause-unreadable = nestd n’a pas le droit de le lire, ou ce n’est pas un fichier
cause-failure = nestd n’a pas pu le traiter
cause-cancelled = quelqu’un l’a annulé
cause-replaced = une révision plus récente l’a remplacé
cause-other = refusé

## Alerts

alert-alone = { $headline }.
alert-detailed = { $headline } : { $detail }.
alert-quoted = { $headline }. Message du programme, en anglais : { $detail }.
alert-of = { $machine } : { $what }
