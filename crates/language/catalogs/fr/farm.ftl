why-below = La raison est indiquée plus bas
number-of = { $number } sur { $all }
figure-print = imprimantes en impression
figure-wait =
    { $count ->
        [one] exemplaire en attente
       *[other] exemplaires en attente
    }
figure-late =
    { $count ->
        [one] échéance en retard
       *[other] échéances en retard
    }
figure-tight =
    { $count ->
        [one] délai serré
       *[other] délais serrés
    }
risks = En retard, ou en risque de l’être
more-dates =
    { $count ->
        [one] { $count } autre échéance
       *[other] { $count } autres échéances
    }
due-done = échéance { $due }, fin vers { $done }
due-on = échéance { $due }
board = Planning
legend-solid = en impression
legend-outlined = en préparation, ou dans la file d’attente
legend-dashed = à venir, si plus rien n’arrive
legend-cool = refroidit
legend-closed = aucune impression ne commence
no-machine-text = Une machine est un fichier de quelques lignes : son volume, son espacement, ses imprimantes. { $command } l’écrit.
no-machine = Aucune machine n’est configurée sur ce nœud
no-machine-help = Comment ajouter une machine
nothing-came-drop = Déposer des fichiers { $formats } sur une machine ci-dessous, ou les copier dans son dossier de dépôt. Le parc les collecte, les place aussi bas que possible et met le plateau dans la file d’attente de l’imprimante.
nothing-came-copy = Déposer des fichiers { $formats } dans son dossier de dépôt. Le parc les collecte, les place aussi bas que possible et met le plateau dans la file d’attente de l’imprimante.
nothing-came-help = Comment les pièces arrivent
nothing-came = Rien n’est encore arrivé
machine-of-node =
    La machine { $machine } est servie par le nœud { $node } : { $parts ->
        [one] { $parts } pièce attend
       *[other] { $parts } pièces attendent
    }.
machine-is-gone =
    La machine { $machine } n’est plus configurée : { $parts ->
        [one] { $parts } pièce attend
       *[other] { $parts } pièces attendent
    }.
nodes-running =
    { $count ->
        [one] { $count } nœud
       *[other] { $count } nœuds
    }, { $running } en marche
nodes = Nœuds
daemon-silent = Le service tourne sur { $host }, mais n’a rien écrit dans le registre depuis { $age } : cette page peut dater d’autant. { $why }.
daemon-runs = Le service tourne sur { $host } depuis { $time } : { $activity }.
daemon-dead = Le service ne tourne pas ; son dernier signe de vie remonte à { $age }.
daemon-never-ran = Le service n’a pas encore tourné.
build-word = Plateau
next-build = Prochain
dates-kept = échéances tenues
dates-not-known = fin pas encore connue
about-mm = env. { $height } mm
since-time = depuis { $time }
until-time = jusqu’à { $time }
fires-begins = départ { $fires }, début { $begins }
begins-time = début { $time }
no-time-known = heure pas encore connue
build-on = Plateau { $build } sur { $printer }
build-number = Plateau { $build }
build-to-come-on = Un plateau à venir sur { $printer }
build-to-come = Un plateau à venir
all-dates-kept = ses échéances sont tenues
a-date-is-tight = une échéance a un délai serré
a-date-is-late = une échéance est en retard
began-time = commencé { $time }
fires-time = départ { $time }
printed-time = fin d’impression { $time }
unpacked-time = à déballer { $time }
add-files-here = Ajouter des fichiers{ $unseen }{ $soft }
unseen-to = pour { $machine }
or-drop-here = , ou les déposer ici
unseen-of = de { $name }
free-time = Libre dès { $time }
flush = Lancer
unseen-flush = { $machine } : voir ce qui serait préparé maintenant
pause = Mettre en pause
material-loaded = { $material } est chargé
load-text = Le prochain plateau est fait de ce qui est chargé. Les pièces d’un autre matériau attendent. Laisser vide si rien n’est chargé.
load = Dire ce qui est chargé
printer-down-text = Une imprimante hors service ne prend pas de plateaux. Ce qu’elle n’a pas pris va à une autre imprimante de la machine, s’il y en a une.
printer-down-do = Mettre l’imprimante hors service
printer-up-do = Remettre en service
printer-named = imprimante { $printer }
resume = Reprendre
say-yes = Donner l’accord : plateau { $build }
tell-how = Résultat plateau { $build }
builds-of = Plateaux de { $name }
later-builds-of = Plateaux suivants de { $name }
nothing-waits = Rien n’attend.
waiting-due =
    En attente : { $copies } de { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    }, première échéance { $due }
waiting =
    En attente : { $copies } de { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    }
it-waits = Il attend : { $why }
open-build = Plateau ouvert { $build } :
height-of = { $height } sur { $limit } mm
so-dense = densité { $density }
usual-density = (d’habitude : { $density })
height-used = Hauteur utilisée par le plateau ouvert de { $machine } : { $share } %
made-searched =
    Recherche en cours pour le plateau { $build } : { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
made-awaits =
    Le plateau { $build } est vérifié et attend un accord : { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
made-proved =
    Le plateau { $build } est vérifié et va dans la file d’attente : { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
spent-of = { $spent } sur { $limit } s
search-for = Recherche pour le plateau { $build }
last-published = Dernier publié : plateau { $build }
now = maintenant
fires-if = Départ { $time } si plus rien n’arrive : { $why }.
fires-at-time = Départ { $time } : { $why }.
paused-by = Mise en pause par { $by } depuis { $time } : rien ne part.
unavailable-since = Indisponible, depuis { $time } : { $trouble }
unavailable-for = Indisponible : { $trouble }
needs = À traiter
things-need =
    { $count ->
        [one] { $count } point à traiter
       *[other] { $count } points à traiter
    }
more-things =
    { $count ->
        [one] { $count } autre point
       *[other] { $count } autres points
    }
since-sentence = Depuis { $time }.
what-to-do = Que faire
its-queue = le dossier de sa file d’attente
its-inbox = son dossier de dépôt
its-errors = son dossier des erreurs
its-archive = son archive
failed-builds = Plateaux échoués
print-as-is = Imprimer tel quel
cancel = Annuler la pièce
add-files = Ajouter des fichiers
parts-that-wait = Les pièces en attente
order-of = commande { $order }
read-again = Relire
mend-and-print = Réparer et imprimer
all-refused = Tous les refusés
seen-to = Marquer comme vu
unseen-seen-to =  : les y laisser ({ $machine })
how-many = Combien d’exemplaires faut-il ? Ils comptent pour 1.
say-how-many = Dire combien
machine-named = machine { $machine }
node-of-machine-gone = { $machine } appartient au nœud { $node }, qui ne fonctionne pas. Rien n’a été fait : le démarrer, puis envoyer de nouveau.
node-does-not-answer = le nœud { $node } n’a pas répondu : { $why }. Envoyer de nouveau quand il répond : ce qu’il a déjà fait n’est pas fait deux fois
machine-just-moves = { $machine } passe en ce moment à un autre nœud : envoyer de nouveau dans un instant
nodes-are-busy = beaucoup de demandes attendent d’autres nœuds : réessayer dans un instant
