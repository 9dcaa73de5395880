drop-time-needs-date = une heure a besoin de sa date
no-whole-number = { $field } : « { $text } » n’est pas un nombre entier
files-of = Fichiers : { $formats }
drop-copies = Exemplaires de chaque fichier ; vide = comme dit son nom (bracket_x10.stl), sinon 1
drop-due = Échéance (fin de ce jour, sauf heure indiquée)
drop-more = Rotation, priorité, note
drop-orientation = Comment les pièces peuvent être tournées
orientation-machine = comme la machine le permet
drop-priority = Priorité, 0 à 100 ; 100 doit aller dans le prochain plateau
files-sent-to = Fichiers envoyés à { $machine }
add-to = Ajouter à { $machine }
orientation-free = libre (free) : dans tous les sens
orientation-upright = debout (upright) : autour de la verticale
orientation-axis = angles droits (axis) : de 90° en 90°
orientation-fixed = fixe (fixed) : comme dans le fichier
form-not-of-farm = ce formulaire ne vient d’aucune page de cette ferme telle qu’elle est : recharger la page et appuyer encore une fois
form-sent-otherwise = ce formulaire a déjà été envoyé avec un autre contenu : recharger sa page, et l’envoyer de là
form-of-number = formulaire de ce numéro
form-sent-before = Ce formulaire a déjà été envoyé, { $time }, et n’est pas exécuté une deuxième fois. Pour refaire la même chose, recharger sa page.
back = Retour
add-files-to = Ajouter des fichiers à { $machine }
add-files-text = Les fichiers vont dans le dossier de dépôt de { $machine }, avec ce qui est indiqué ici, comme si on les y copiait. Ce qui ne peut pas être imprimé y est refusé, avec la raison.
no-orders-from-pages = Ce parc ne prend pas d’ordres des pages ; mettre les fichiers dans le dossier de dépôt { $folder }.
others-add-files = d’autres personnes ajoutent des fichiers en ce moment : réessayer dans un instant
form-takes-files =
    un formulaire prend { $files ->
        [one] { $files } fichier
       *[other] { $files } fichiers
    } au plus
no-file-chosen = aucun fichier n’a été choisi
files-were-added = Fichiers ajoutés
file-is-there = { $file } est dans le dossier de dépôt de { $machine }.
file-not-added = Pas ajouté : { $why }.
file-is-taken-after = nestd le prend quand il n’a pas changé pendant { $secs } s ; ce qui ne peut pas être imprimé est refusé avec la raison.
field-is-no-text = un champ du formulaire n’est pas du texte
undo = Défaire
done = C’est fait
refused = Refusé
form-not-known-text = Ce formulaire a été envoyé, puis nestd s’est arrêté ou son registre a fait défaut : on ne sait pas si tout a été fait. Vérifier avant de l’envoyer encore une fois, depuis sa page rechargée.
form-not-known = On ne sait pas
such-order = cet ordre
takes-no-orders = ce parc ne prend pas d’ordres des pages ; voir web.orders
not-answered-text = Le service n’a pas répondu ; l’ordre est noté et sera exécuté quand il tournera.
not-answered = Pas encore de réponse
refused-in-part = Refusé en partie
it-is-done = C’est fait.
there-is-no = introuvable : { $what }
refused-but-done = Refusé : { $refused }
done-all-the-same = Fait quand même : { $done }
not-understood = Cette adresse ou ce formulaire est incompréhensible
correct-told = Corriger ce qui est signalé
tell-printed = Signaler le résultat
it-prints = Impression commencée
print-again = Réimprimer
withdraw = Le retirer de la file d’attente
requeue = Le même plateau, encore une fois
copies-again = Ses exemplaires, dans de nouveaux plateaux
reprint-build-text = Ses exemplaires comptent comme mauvais et attendent à nouveau, les premiers de tous, avec tout ce qui était demandé. Ils viennent dans de nouveaux plateaux.
reprint-build = Réimprimer tous les exemplaires
withdraw-text = Seulement tant que son imprimante n’a pas pris son fichier. Ses exemplaires attendent à nouveau, avec tout ce qui était demandé. La machine est mise en pause, pour qu’on puisse les changer ou les annuler, jusqu’à ce que quelqu’un appuie sur Reprendre.
is-taken-back = Retrait en cours.
take-back = Retirer
requeue-text = Le même plateau vérifié est émis comme un nouveau : les mêmes exemplaires aux mêmes places. Les exemplaires comptés comme imprimés comptent alors comme mauvais.
requeue-build = Réémettre ce plateau
second-file = Un second fichier de ce plateau a été vu dans la file d’attente : { $files }. S’il est imprimé à partir de celui-là, enlever l’autre, et signaler que l’impression a commencé.
second-file-unprinted = Personne n’imprime le second fichier
print-failed = L’impression du plateau { $build } sur { $machine } a échoué. Personne ne s’en est encore occupé.
print-failed-why = L’impression du plateau { $build } sur { $machine } a échoué : { $why }. Personne ne s’en est encore occupé.
waits-for-yes = Attend un accord
waits-for-yes-text = Il attend un accord avant d’être publié.
publish-it = Autoriser
outcome-complete = réussie
outcome-interrupted = interrompue : la machine s’est arrêtée
outcome-failed = échouée : rien n’est bon
the-print-is = L’impression est
keep-bad = Ne pas réimprimer les mauvais exemplaires
bad-copies-text = Les mauvais exemplaires attendent à nouveau avec tout ce qui était demandé ; si l’impression a échoué, tous.
correct-outcome = Corriger le résultat
tell-outcome = Signaler le résultat
unseen-build = (plateau { $build })
build-named = plateau { $build }
names-no-bad-copies = « { $text } » ne désigne pas de mauvais exemplaires : écrire pièce = exemplaires, par exemple 7=2, 9=1
anyway = Le retirer de la file d’attente et continuer quand même
files-are-read = certains de ses fichiers sont en lecture : redemander pour annuler ce qu’ils deviennent
cancelled-before = { $name } a été annulé avant d’être pris.
change-order = Changer la commande
move-to = Déplacer vers une autre machine
change-order-text =
    Pour { $parts ->
        [one] { $parts } pièce en attente
       *[other] les { $parts } pièces en attente
    }. Un champ vide ne change rien.
due-example-none = Échéance, par exemple 2026-11-25 (fin de ce jour) ou 25.11.2026 17:00 ; none = sans échéance
priority-range = Priorité, 0 à 100
move-order-text =
    { $parts ->
        [one] { $parts } pièce en attente de cette commande est déplacée, et relue sur l’autre machine.
       *[other] Les { $parts } pièces en attente de cette commande sont déplacées, et relues sur l’autre machine.
    }
move-order = Déplacer la commande
reprint-order-text = Chaque exemplaire imprimé de cette commande compte comme mauvais et attend à nouveau, le premier de tous, avec tout ce qui était demandé.
reprint-order = Réimprimer tous les exemplaires imprimés
accept-of = Accepter { $copies } sur { $all }
close-order-text = Clôt la commande telle quelle : ce qui est bon, imprimé ou dans un plateau est accepté.
close-cancels =
    { $copies ->
        [one] { $copies } exemplaire en attente sera annulé.
       *[other] { $copies } exemplaires en attente seront annulés.
    }
close-asks-not =
    On ne demande plus rien pour { $copies ->
        [one] { $copies } exemplaire refusé
       *[other] { $copies } exemplaires refusés
    }.
cancel-order-text =
    { $parts ->
        [one] { $parts } pièce attend
       *[other] { $parts } pièces attendent
    }. Les exemplaires déjà dans des plateaux y restent.
cancel-order = Annuler ce qui attend
nothing-of-order-waits = plus rien de cette commande n’attend
nothing-filled-in = rien n’a été rempli
edit = Modifier
copies-wanted = Exemplaires demandés en tout, ceux des plateaux compris
due-example = Échéance, par exemple 2026-11-25 (fin de ce jour) ou 25.11.2026 17:00 ; vide = sans échéance
no-copy-waits = Aucun exemplaire n’attend : on peut en demander plus, nommer un autre client et d’autres finitions.
change = Changer
move-part-text = Toutes les pièces en attente de son fichier sont déplacées, et relues sur l’autre machine.
move-part = Déplacer
copies-that-are-bad = Exemplaires mauvais
reprint-part-text = Ils attendent à nouveau, les premiers de tous, avec tout ce qui était demandé. Les exemplaires du plateau le plus récent sont pris d’abord.
a-number-of-copies = un nombre d’exemplaires
part-named = pièce { $part }
a-priority = une priorité
not-in-range = « { $text } » n’est pas { $what } entre { $least } et { $most }
is-not-what = « { $text } » n’est pas { $what }
on-these-pages = Sur ces pages : { $link }.
page-of-address = page à cette adresse
guard-host = ce parc ne répond pas à ce nom ; voir web.hosts
guard-role = il faut le rôle { $needed }, et vous avez { $own }
guard-other-site = aux pages d’autres sites, ce parc ne répond que si une personne suit un lien, et il ne prend d’ordres que de ses propres pages
guard-other-page = ce parc ne prend d’ordres que de ses propres pages, et la demande vient de la page d’un autre site ; derrière un proxy, son nom doit être dans web.hosts

drop-formats = STL, 3MF, OBJ, PLY, CAMSPEC ou ZIP
