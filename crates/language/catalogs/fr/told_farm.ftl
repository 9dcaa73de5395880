### Sentences of the farm, as they are stored in English: details of alerts, builds that failed, events, answers to commands.

## Errors of the operating system

told-os-gone = fichier ou dossier absent (erreur 2)
told-os-io = erreur d’entrée-sortie (erreur 5)
told-os-denied = permission refusée (erreur 13)
told-os-exists = le fichier existe déjà (erreur 17)
told-os-other-device = autre système de fichiers (erreur 18)
told-os-no-directory = ce n’est pas un dossier (erreur 20)
told-os-is-directory = c’est un dossier (erreur 21)
told-os-full = plus de place sur le disque (erreur 28)
told-os-read-only = système de fichiers en lecture seule (erreur 30)
told-os-not-connected = non connecté (erreur 107)
told-os-timed-out = délai de connexion dépassé (erreur 110)
told-os-host-down = l’hôte est arrêté (erreur 112)
told-os-stale = accès au fichier périmé (erreur 116)
told-os-quota = quota de disque dépassé (erreur 122)
told-os-other = erreur { $number } du système ({ $error })

## Folders

told-reading-path = lecture de { $path } : { $why }
told-listing-path = liste de { $path } : { $why }
told-creating-path = création de { $path } : { $why }
told-cannot-write = { $path } ne peut pas être écrit : { $why }
told-cannot-be-used = { $path } est inutilisable : { $why }
told-queue-unavailable = le dossier de la file d’attente { $path } est indisponible : { $why }
told-inbox-unavailable = le dossier de dépôt { $path } est indisponible : { $why }
told-queue-not-available = le dossier de la file d’attente n’est plus disponible
told-it-is-not-there = il n’est pas là
told-it-is-no-folder = ce n’est pas un dossier
told-it-cannot-be-listed = son contenu ne peut pas être listé
told-marker-empty = la marque .nestd-queue est vide
told-other-file-system = il est sur un autre système de fichiers qu’à la première fois ; le monter à nouveau, ou redémarrer nestd
told-file-system-changed = son système de fichiers a changé pendant la lecture
told-served-by-other = { $path } est servi par un autre nestd : processus { $pid } sur { $host } depuis { $since }, avec le dossier d’état { $state }. L’arrêter, ou donner à chaque parc ses propres dossiers
told-folder-replaced = { $path } n’est pas le dossier qui était là avant : sa marque { $marker } manque. Le monter à nouveau ; s’il a été remplacé ou vidé exprès : touch { $file }
told-holds-more-files = { $path } : contient plus de { $most } fichiers ; le reste attend
told-other-file-system-inside = { $path } : est un autre système de fichiers ; aucune pièce n’y est prise
told-recycle-bin = { $path } : est une corbeille d’après son nom, rien n’y est donc imprimé
told-folder-denied = { $path } : illisible : permission refusée
told-cannot-be-read-path = { $path } ne peut pas être lu
told-file-damaged-hash = { $path } est endommagé : ses octets ne correspondent pas à son empreinte

## Details of alerts

told-and-more = { $why } ; et { $more } de plus
told-and-more-comma = { $why }, et { $more } de plus
told-and-more-parts = { $why } et { $more } de plus
told-files-in =
    { $n ->
        [one] { $n } fichier (dossier : { $path })
       *[other] { $n } fichiers (dossier : { $path })
    }
told-files-beside = { $name } (dossier : { $path })
told-files-beside-more = { $name } et { $more } de plus (dossier : { $path })
told-in-claimed = { $files } dans son dossier .claimed
told-part-named = pièce { $part } ({ $file })
told-part-asks = pièce { $part } ({ $file }) : { $why }
told-build-named = plateau { $build }
told-build-why = plateau { $build } : { $why }
told-release-brief =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }, { $height } sur { $limit } mm de haut, densité { $density } %, environ { $hours } h d’impression
told-node-serves-it = le nœud { $node } la sert
told-node-is-gone = son nœud { $node } ne tourne pas
told-node-with-machines = { $node } sur { $host }, avec { $names }
told-gone-with-work =
    { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    } et { $builds ->
        [one] { $builds } plateau
       *[other] { $builds } plateaux
    } en cours
told-gone-with-lines =
    { $why }, et { $n ->
        [one] { $n } ligne commandée par programme
       *[other] { $n } lignes commandées par programme
    }
told-ended-during-search-more = nestd s’est arrêté { $times } fois pendant une recherche pour le plateau { $build } : la prochaine commence { $secs } s après un démarrage. Ses pièces sont { $names } et { $more } de plus ; `nestd cancel PART` en enlève une
told-ended-during-search = nestd s’est arrêté { $times } fois pendant une recherche pour le plateau { $build } : la prochaine commence { $secs } s après un démarrage. Ses pièces sont { $names } ; `nestd cancel PART` en enlève une
told-printer-configured-no-more = l’imprimante { $printer } n’est plus configurée, et { $file } est peut-être dans son dossier de file d’attente, comme plateau { $build }
told-step-obeying = exécution d’un fichier de commande
told-step-recording-drop = inscription d’un dépôt
told-step-recording-refusal = inscription d’un refus
told-step-late-ticket = application d’un ticket tardif
told-step-originals = reprise des originaux
told-step-command = ordre { $number }

## Files in a queue

told-queue-other-machine = { $file } est le plateau { $build } de { $machine } : le porter dans une file de { $machine }
told-queue-not-proved = { $file } n’est pas le fichier vérifié comme plateau { $build } : le retirer, regarder s’il a été imprimé, et signaler le résultat du plateau { $build }
told-queue-does-not-fit = { $file } ne convient pas ({ $detail }). `nestd withdraw { $build }` le retire, et ses exemplaires sont placés pour la machine telle qu’elle est
told-queue-second-on-way = { $file } est un second fichier du plateau { $build }, en cours de retrait d’une file : l’enlever
told-queue-second-lies-at = { $file } est un second fichier du plateau { $build }, qui est chez { $printer } : l’enlever
told-queue-second-taken-out = { $file } est un second fichier du plateau { $build }, qui a quitté la file de { $printer } : si l’autre est imprimé, enlever celui-ci ; s’il a seulement été déplacé, `nestd dismiss b{ $build }`
told-queue-failed-file = { $file } est le fichier du plateau { $build } ({ $what }) : l’enlever, sinon ses exemplaires seront imprimés une seconde fois
told-queue-failed-complete = { $file } est le fichier du plateau { $build } ({ $what }) : l’enlever, sinon ses exemplaires seront imprimés une seconde fois ; s’il a été imprimé quand même, `nestd outcome { $build } complete --correct` le dit
told-queue-failed-withdrawn = { $file } est le fichier du plateau { $build } ({ $what }) : l’enlever, sinon ses exemplaires seront imprimés une seconde fois ; s’il a été imprimé quand même, en enlever autant de ceux qui attendent avec `nestd cancel PART=N` (`nestd show b{ $build }` liste ses pièces)
told-queue-was-out-before = { $file } est le fichier du plateau { $build } ({ $what }), qui avait déjà quitté la file : l’enlever
told-word-printing = en impression
told-word-complete = réussi
told-word-interrupted = interrompu
told-word-failed = échoué
told-word-withdrawn = retiré
told-word-published = publié

## Builds that failed or went back

told-build-gave-up =
    plateau { $build } abandonné après { $n ->
        [one] { $n } essai manqué
       *[other] { $n } essais manqués
    } : { $why }
told-build-gave-up-detail =
    plateau { $build } abandonné après { $n ->
        [one] { $n } essai manqué
       *[other] { $n } essais manqués
    } (détail en anglais : { $detail })
told-gave-up =
    abandonné après { $n ->
        [one] { $n } essai manqué
       *[other] { $n } essais manqués
    } : { $why }
told-gave-up-detail =
    abandonné après { $n ->
        [one] { $n } essai manqué
       *[other] { $n } essais manqués
    } (détail en anglais : { $detail })
told-build-gave-up-stopped = plateau { $build } abandonné après { $attempts } essais : nestd s’est arrêté à chaque fois
told-gave-up-stopped = abandonné après { $attempts } essais : nestd s’est arrêté à chaque fois
told-build-given-up = plateau { $build } abandonné : { $why }
told-is-given-up = abandonné : { $why }
told-is-given-up-detail = abandonné (détail en anglais : { $detail })
told-no-copy-has-place = aucun de ses exemplaires n’a de place dans la machine telle qu’elle est
told-no-copy-left = aucun de ses exemplaires n’y reste
told-the-build-failed = le plateau a échoué
told-build-the-build-failed = le plateau { $build } a échoué
told-proving = vérification du plateau écrit : { $why }
told-not-proved = le plateau écrit n’est pas vérifié ({ $detail })
told-panicked = plantage ({ $detail })
told-search-stopped = sa recherche a été arrêtée après { $secs } s, et reprend de ce qu’elle a trouvé
told-withdrawn-by = retiré de la file d’attente par { $by }
told-withdrawn-why = retiré de la file d’attente par { $by } : { $reason }
told-withdrawn-record = retiré intact de la file d’attente, comme le dit sa fiche dans l’archive
told-put-back-from-backup = le registre a été remis d’une sauvegarde
told-urgent-goes-with-it = des exemplaires de priorité maximale partent avec
told-arrived-goes-with-it = des exemplaires arrivés partent avec
told-printer-is-down = l’imprimante { $printer } est hors service
told-made-again = préparé à nouveau : { $why }
told-machine-changed = la machine a changé depuis la vérification ({ $detail })
told-staged-removed = son fichier préparé a été enlevé
told-staged-other = son fichier préparé n’est pas celui qui a été vérifié

## Copies that are not in the next build

told-left-open-build =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de { $who } hors du plateau ouvert, pour { $others }. { $what } en tête pour le prochain.
told-left-open-build-alone =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de { $who } hors du plateau ouvert. { $what } en tête pour le prochain.
told-cannot-be-in-next =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de { $who } hors du prochain plateau : { $why }. { $what } en tête pour le suivant.
told-name-priority = { $file } (pièce { $part }, priorité { $priority })
told-other-parts =
    { $others } et { $n ->
        [one] { $n } autre pièce
       *[other] { $n } autres pièces
    }
told-it-is = Il est
told-they-are = Ils sont
told-no-room-beside = il n’y a pas de place à côté de { $others }, qui passe avant
told-no-room-beside-copies = il n’y a pas de place à côté de ses autres exemplaires
told-no-place-found = aucune place n’a été trouvée dans le volume vide
told-whole-volume-first = ce qui passe avant a le volume de tout le plateau

## Refusals that people or orders caused

told-cancelled-by = Annulée par { $by }.
told-line-cancelled = Sa ligne a été annulée avant sa prise.
told-newer-revision = Une révision plus récente du même nom, la pièce { $part }, est venue pendant que celle-ci attendait, et a pris sa place. Si les deux sont voulues, reprendre celle-ci.
told-newer-revision-order = Une révision plus récente du même nom, la pièce { $part }, est venue pour la commande { $order } pendant que celle-ci attendait, et a pris sa place. Si les deux sont voulues, reprendre celle-ci.
told-after-the-backup = Elle est dans le dossier des erreurs : elle a été refusée ou annulée après la sauvegarde.
told-maybe-printed = Un fichier de la file d’attente contient le même fichier, elle est donc peut-être déjà imprimée.
told-taken-over-by-other = Un autre nestd a repris ce fichier pendant que celui-ci ne répondait pas, et l’imprime.
told-no-reason = aucune raison n’a été donnée

## What happened: parts and orders

told-trigger-flush = lancement
told-trigger-full = plein
told-trigger-fill = remplissage
told-trigger-copies = nombre d’exemplaires
told-trigger-max-wait = attente maximale
told-trigger-due = échéance
told-trigger-at = heure fixée
told-ledger-query-failed = une requête du registre a échoué ({ $detail })
told-step-taking-in = reprise d’un résultat
told-step-new-configuration = reprise de la nouvelle configuration (rien n’en vaut avant)
told-process-named = processus { $pid } ({ $name })
told-another-process = un autre processus
told-put-back-in-time = il a été ramené à un état antérieur dans son fichier : il compte { $count } changements, et ce nestd en a vu { $seen }
told-record-of-build = d’après la fiche d’un plateau
told-imported-record = repris de sa fiche dans l’archive
told-imported-from-build = repris de la fiche d’un plateau
told-replaces-part-all = elle remplace la pièce { $old }, une révision antérieure, avec tout ce qui était demandé
told-replaces-refused = elle remplace la pièce { $old }, qui a été refusée
told-replaces-refused-all = elle remplace la pièce { $old }, qui a été refusée, avec tout ce qui était demandé avec elle
told-replaces-refused-terms = elle remplace la pièce { $old }, qui a été refusée, avec tout ce qui était demandé avec elle sauf le nombre d’exemplaires
told-replaces-part-terms = elle remplace la pièce { $old }, une révision antérieure, avec tout ce qui était demandé avec elle sauf le nombre d’exemplaires
told-replaces-part-date = elle remplace la pièce { $old }, une révision antérieure, avec son échéance et sa note
told-more-wanted-record = { $more } de plus, d’après la fiche d’un plateau
told-published-after-backup = son plateau a été publié après la sauvegarde
told-decided-since = Elle a été refusée, annulée, reprise ou modifiée après la sauvegarde.
told-decided-since-wanted = Elle a été refusée, annulée, reprise ou modifiée après la sauvegarde, et { $copies } exemplaires en étaient alors voulus.
told-decided-since-one = Elle a été refusée, annulée, reprise ou modifiée après la sauvegarde, et 1 exemplaire en était alors voulu.
told-out-of-queue-said = hors de la file, comme l’a dit { $by }
told-once-more-asked = le plateau { $build } encore une fois, demandé par { $by }
told-requeue-word = réémission
told-same-dropped-again = le même fichier a été déposé à nouveau
told-taken-back = reprise
told-taken-back-mend = reprise ; { $name } dit que son maillage peut être réparé
told-other-mending = son maillage n’est pas réparé comme à la première lecture. `nestd confirm { $part }` le fait relire et réparer de nouveau.
told-told-at-break-out = signalé au déballage
told-no-copy-waits-any-more = plus aucun exemplaire n’attend
told-file-not-needed = son fichier n’est plus nécessaire
told-by-whom = par { $by }
told-has-seen-to-it = { $by } s’en est occupé
told-copies-instead =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } au lieu de { $before }
told-as-it-was-taken =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }, comme à la prise
told-more-wanted-by = { $more } de plus, par { $by }
told-fewer-wanted-by = { $fewer } de moins, par { $by }
told-order-instead = commande { $new } au lieu de { $old }
told-customer-instead = client { $new } au lieu de { $old }
told-priority-instead = priorité { $new } au lieu de { $old }
told-due-instead = échéance { $new } au lieu de { $old }
told-note-instead = note { $new } au lieu de { $old }
told-unit-instead = unité { $new } au lieu de { $old }
told-moved-from-to = de { $from } à { $to }
told-replaces-part = elle remplace la pièce { $old }, une révision antérieure
told-part-took-its-place = la pièce { $new } du même nom a pris sa place
told-clock-set = de { $jump } ; l’âge des pièces est gardé
told-put-back-from-build =
    { $n ->
        [one] { $n } exemplaire remis
       *[other] { $n } exemplaires remis
    } du plateau { $build } par { $by }
told-not-wanted-again =
    { $n ->
        [one] { $n } exemplaire du plateau { $build } n’est plus voulu
       *[other] { $n } exemplaires du plateau { $build } ne sont plus voulus
    }, comme l’a dit { $by }
told-printed-well-after-all = un exemplaire du plateau { $build } était finalement bon
told-not-taken-printer-first = non retiré : son imprimante a pris le fichier avant
told-not-taken-not-proved = non retiré : ce qui est dans la file n’est pas le fichier vérifié
told-not-taken-second = non retiré : ses exemplaires sont dans la file sous { $places }
told-back-in-queue-of = de nouveau dans la file de { $printer }
told-lies-in-queue-again = son fichier est de nouveau dans la file de { $printer }
told-closed-order = { $by } : commande { $name } { $what }
told-closed-with =
    close avec { $accepted } sur { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }
told-closed-without-it = { $by } : sa commande a été close sans elle
told-step-done = { $by } : { $name } est fait
told-step-not-done = { $by } : { $name } n’est pas fait
told-steps-open-again = d’autres exemplaires sont fabriqués : ses étapes de finition sont de nouveau à faire

## Answers to what people say on pages

told-is-being-nested =
    le plateau { $build } est en placement avec { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    }
told-nothing-waits-in = rien n’attend dans { $machine }
told-is-paused = { $machine } est en pause
told-was-paused-already = { $machine } était déjà en pause
told-runs-again = { $machine } marche à nouveau
told-was-not-paused = { $machine } n’était pas en pause
told-resume-first = { $machine } est en pause ; la reprendre d’abord
told-no-printer-in-use = aucune imprimante de { $machine } n’est en service ; `nestd printer { $printer } up` en remet une en service
told-copies-cancelled =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de la pièce { $part } annulés
told-has-values-already = la pièce { $part } a déjà ces valeurs
told-part-changed = pièce { $part } : { $why }
told-part-moved = pièce { $part } déplacée vers { $machine }, et relue là
told-parts-moved = pièces { $parts } déplacées vers { $machine }, et relues là
told-part-is-for = la pièce { $part } est déjà pour { $machine }
told-printed-as-it-is = la pièce { $part } est imprimée telle quelle
told-no-confirmation = la pièce { $part } n’attend aucun accord
told-part-mended = la pièce { $part } est relue, et son maillage réparé
told-nothing-to-mend = la pièce { $part } n’a pas été refusée à cause de son maillage : `nestd retry { $part }` la relit telle quelle
told-is-read-again = la pièce { $part } est relue
told-part-is-cancelled = la pièce { $part } est annulée
told-no-such-part = il n’y a pas de pièce { $part }
told-no-such-machine = il n’y a pas de machine { $machine }
told-no-such-build = il n’y a pas de plateau { $build }
told-waits-for-its-file = la pièce { $part } attend son fichier : le déposer encore, et redonner l’ordre quand il est lu
told-ticket-of-part-unread = le ticket de la pièce { $part } n’a pas pu être lu : le corriger et déposer les deux à nouveau
told-refused-already = la pièce { $part } est déjà refusée ou annulée ; `nestd show p{ $part }` dit pourquoi
told-built-already = la pièce { $part } est déjà faite : tous ses exemplaires sont dans des plateaux publiés
told-build-is-told = Plateau { $build } : { $what }.
told-build-stays-told = Pour le plateau { $build }, rien ne change, c’était déjà signalé ainsi : { $what }.
told-issued-once-more = Le plateau { $build } est réémis comme plateau { $new }.
told-is-released = L’accord est donné : le plateau { $build } va dans la file d’attente.
told-was-released-before = L’accord pour le plateau { $build } était déjà donné.
told-failure-dismissed = L’impression manquée du plateau { $build } est marquée comme vue ; ses exemplaires restent tels quels.
told-second-dismissed = Le second fichier du plateau { $build } est écarté : ce qui est dans une file est le seul.
told-now-down = L’imprimante { $printer } est hors service : elle ne reçoit aucun plateau.
told-takes-again = L’imprimante { $printer } reçoit à nouveau des plateaux.
told-was-not-down = L’imprimante { $printer } n’était pas hors service.
told-taken-back-unless = Le plateau { $build } est retiré de la file de { $printer }, sauf si l’imprimante est plus rapide. Sa page dit ce qu’il en est.
told-noted-taken-first = Noté : le fichier du plateau { $build } est d’abord retiré de la file de { $printer } ; puis c’est fait.
told-wait-again =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    } { $what } à nouveau, en tête, avec tout ce qui était demandé.
told-waits = attend
told-wait = attendent
told-order-is-closed = La commande { $name } est { $what }.

## What a command or a form is refused for

told-other-state = plateau { $build } : { $what }, pas { $rest }
told-word-open = ouvert
told-word-nesting = en placement
told-word-verified = vérifié
told-word-claimed = en lecture
told-word-waiting = en attente
told-word-batched = en préparation
told-word-built = fabriqué
told-word-refused = refusé
told-or-words = { $what } ou { $rest }
told-made-again-since = le plateau { $build } a été refait depuis : regarder ce qu’il est maintenant
told-not-released-made-again = l’accord pour le plateau { $build } n’est pas donné : il est préparé à nouveau ({ $detail })
told-file-not-in-queue = le fichier du plateau { $build } n’est pas dans la file : son imprimante l’a pris, ou il va vers une autre
told-in-build-as-it-is = la pièce { $part } a des exemplaires dans le plateau { $build } ({ $what }), imprimé tel quel : attendre qu’il soit publié, et redonner l’ordre pour les exemplaires qui attendent encore. Les exemplaires imprimés se refont avec `nestd reprint { $part }=N`
told-only-refused-retried = pièce { $part } : { $what } ; seule une pièce refusée ou annulée se reprend
told-outcome-recorded = le résultat du plateau { $build } est déjà signalé ({ $what }) ; si c’est faux, `nestd outcome { $build } { $asked } --correct`
told-outcome-the-same = le résultat du plateau { $build } est déjà signalé ainsi ({ $what }) ; rien n’a été changé
told-outcome-the-same-bad = le résultat du plateau { $build } est déjà signalé ainsi ({ $what }) ; rien n’a été changé. Si d’autres exemplaires sont mauvais, `nestd outcome { $build } { $asked } --correct --bad PART=N`
told-was-taken-back-untouched = le fichier du plateau { $build } a été retiré intact de la file : il ne compte pas comme imprimé, et ses exemplaires sont refaits. Si quelqu’un en a imprimé quand même, enlever autant de ceux qui attendent avec `nestd cancel PART=N` ; `nestd show b{ $build }` dit quand, et liste ses pièces
told-none-counts-as-printed = aucun exemplaire ne compte comme imprimé : `nestd show` dit ce qui attend, `nestd edit PART --copies N` en demande plus
told-copies-being-cancelled = des exemplaires de la pièce { $part } sont en cours d’annulation, son plateau commence ensuite
told-can-be-cancelled =
    { $n ->
        [one] { $n } exemplaire
       *[other] { $n } exemplaires
    } de la pièce { $part } peuvent être annulés, pas { $asked } ; les autres sont dans des plateaux : `nestd show p{ $part }` les liste
told-only-what-waits = pièce { $part } : { $what } ; seul ce qui attend peut être changé ; { $remedy }
told-retry-first = `nestd retry { $part }` la reprend d’abord
told-edit-orders-more = `nestd edit { $part } --copies N` en demande plus
told-lies-untouched = le fichier du plateau { $build } est intact dans la file de { $printer }, comme si personne ne l’avait imprimé. Vérifier le numéro. S’il est juste, insister ({ $insist }) : nestd retire d’abord le fichier de la file, pour que personne ne l’imprime une seconde fois
told-lies-untouched-untold = le fichier du plateau { $build } est intact dans la file, et personne n’a signalé le résultat. S’il n’a pas été imprimé, le retirer : `nestd withdraw { $build }`. Sinon, signaler d’abord le résultat avec les mauvais exemplaires : `nestd outcome { $build } complete --bad PART=N`
told-second-unseen = un second fichier du plateau { $build } a été vu dans la file ({ $places }), et nestd ne peut pas y regarder en ce moment. Aller voir, et le retirer s’il s’y trouve. Si personne ne l’a imprimé : `nestd dismiss b{ $build }`, puis le redire
told-second-gone = un second fichier du plateau { $build } se trouvait dans la file ({ $places }) et n’y est plus. S’il est ou a été imprimé, retirer le fichier de la file de { $printer } et le redire. Si personne ne l’a imprimé : `nestd dismiss b{ $build }`, puis le redire
told-lies-other-file = ce qui est dans la file de { $printer } comme fichier du plateau { $build } n’est pas le fichier vérifié. Le retirer de la file, regarder s’il a été imprimé, et le redire
told-on-its-way = le fichier du plateau { $build } va vers une autre imprimante : le redire quand il y est
told-being-taken-back = le fichier du plateau { $build } est en cours de retrait : `nestd show b{ $build }` dit ce qu’il en est
told-no-such-order = il n’y a pas de commande { $name } ; `nestd orders --all` les liste
told-nothing-to-close = rien de la commande { $name } n’attend ni n’a été refusé, il n’y a donc rien à clore ; `nestd show order { $name }` dit ce qu’il en est
told-order-being-read = des fichiers de la commande { $name } sont en cours de prise et de lecture ; la clore dans un instant
told-printer-fallback-waits = Les plateaux de { $machine } attendent qu’une imprimante soit en service.
told-not-taken-goes-to = Ce qu’elle n’a pas pris va à { $printer }.
told-copies-cancelled-of-order =
    { $n ->
        [one] { $n } exemplaire en attente est annulé.
       *[other] { $n } exemplaires en attente sont annulés.
    }
told-copies-not-asked =
    { $n ->
        [one] { $n } exemplaire refusé n’est plus demandé.
       *[other] { $n } exemplaires refusés ne sont plus demandés.
    }
told-to-be-taken-out = le fichier du plateau { $build } devait être retiré de la file, car ses exemplaires sont à réimprimer, mais { $why } : rien n’a été changé. { $remedy }
told-lies-under-its-name = ce qui est dans la file sous son nom n’est pas le fichier vérifié
told-copies-lie-as = ses exemplaires sont dans la file sous { $places }
told-printer-took-first = son imprimante l’a pris avant
told-lies-elsewhere = il est à { $place }, et pas là où il a été publié
told-take-out-look-say = Le retirer de la file, regarder s’il a été imprimé, et le redire
told-take-out-say = Le retirer de la file, et le redire
told-say-when-known = Le redire quand on sait comment il est imprimé
told-say-once-more = Le redire
told-published-in-no-queue = le plateau { $build } n’est pas retiré : il a été publié dans un dossier de file qui n’est plus à aucune imprimante. Si son fichier n’est pas imprimé, `nestd outcome { $build } failed` remet ses exemplaires en attente
told-configuration-nothing = rien n’en est appliqué ({ $detail })
told-no-answer-in-time = pas de réponse à temps
told-no-finishing-steps = la pièce { $part } n’a pas d’étape de finition ; `nestd edit { $part } --finish '{ $name }'` lui donne celle-ci
told-no-such-step = la pièce { $part } n’a pas d’étape de finition « { $name } », seulement { $names }
told-step-not-printed = aucun exemplaire de la pièce { $part } n’est imprimé, donc « { $name } » ne peut pas être fait

## Why a due date is at risk

risk-passed = cette date est passée
risk-too-long = son impression est trop longue pour cela
risk-left-out = pas de place dans le prochain plateau à côté de ce qui passe avant
risk-awaits-fire = son plateau ne part pas avant { $time }
risk-printers-busy = les imprimantes sont occupées jusqu’à { $time }
risk-no-begin = aucune imprimante ne commence d’impression
risk-printer-closed = l’imprimante ne commence aucune impression avant { $time }
risk-awaits-release = son plateau attend un accord
risk-awaits-answer = une réponse est attendue
risk-awaits-material = son matériau n’est pas chargé sur la machine
risk-file-missing = son fichier est endommagé ou en cours de récupération
risk-not-read = son fichier n’est pas encore lu
risk-paused = la machine est en pause
risk-unavailable = la machine est indisponible
risk-no-printer = aucune imprimante de la machine n’est en service
told-at-risk-one = { $name }, échéance { $due } : { $why }
told-at-risk-one-of = { $name } de { $names }, échéance { $due } : { $why }
told-at-risk = { $names }, échéance { $due } : { $why }
told-at-risk-of = { $names } de { $name }, échéance { $due } : { $why }
told-at-risk-more = { $names } et { $more } de plus, échéance { $due } : { $why }
told-at-risk-more-of = { $names } et { $more } de plus de { $name }, échéance { $due } : { $why }
told-machine-not-configured = sa machine n’est pas configurée

## What is loaded

told-loaded-before = { $material } était déjà chargé sur { $machine }
told-nothing-loaded-before = Rien n’était déjà chargé sur { $machine }
told-loaded-now = { $material } est maintenant chargé sur { $machine } : son prochain plateau en est fait
told-nothing-loaded-now = Rien n’est maintenant chargé sur { $machine } : les pièces qui nomment leur matériau attendent
told-others-wait =
    { $parts ->
        [one] { $parts } pièce y attend
       *[other] { $parts } pièces y attendent
    } un autre matériau ; `nestd status` dit lequel
told-fired-of-other = Le plateau { $build } a été lancé avant et est en { $material } : l’imprimer d’abord, ou le retirer
told-material-not-named = [materials] dans nestd.toml ne nomme pas « { $material } », seulement { $names } : utiliser un de ceux-ci, ou l’y ajouter et recharger nestd
told-no-machine-here = il n’y a pas de machine « { $machine } » ici
told-part-not-loaded = la pièce { $part } est en { $material }, qui n’est pas chargé sur { $machine } ; `nestd machine load { $machine } '{ $material }'` dit qu’il l’est
