a-state-of-build = un état de plateau
the-number-of-build = le numéro d’un plateau
is-no-date = « { $text } » n’est pas une date comme 2026-11-20
csv-all-columns = CSV avec toutes les colonnes
next-builds = Les plateaux suivants
all = tous
part-or-order = Pièce ou commande, nom entier
until = Jusqu’au
sorted-by-what = Trié par
newest-first = les plus récents d’abord
show = Afficher
days =
    { $days ->
        [one] { $days } jour
       *[other] { $days } jours
    }
published-in-time = Ce qui a été publié pendant cette période
heights = Hauteurs
the-newest-first = les plus récents d’abord
sorted-by =
    triés par { $sort ->
        [height] hauteur
        [density] densité
        [copies] nombre d’exemplaires
       *[machine] machine
    }
no-builds = Aucun plateau
none-matches = Aucun ne correspond à ce qui est demandé ci-dessus.
all-builds = Tous les plateaux
is-no-month = « { $text } » n’est pas un mois comme 2026-10
as-many-days = { $month }, même nombre de jours
month-text = Les litres de pièces sont leur volume ; les litres de gâteau sont les pièces et la poudre jusqu’à la hauteur de chaque plateau. Le temps machine est la hauteur fois les heures que prend un mm. Rendement : les bons exemplaires parmi ceux dont quelqu’un a signalé le résultat.
height-by-week = Hauteur par semaine, mm
figure-builds =
    { $count ->
        [one] plateau
       *[other] plateaux
    }
figure-copies-made =
    { $count ->
        [one] exemplaire
       *[other] exemplaires
    }
figure-of-parts = de pièces
figure-machine-time = de temps machine
figure-yield = de rendement
figure-late-parts = en retard
figure-failed =
    { $count ->
        [one] échoué
       *[other] échoués
    }
none = Aucun.
link-on-machine = { $link } sur { $machine }
month-caption = Publié ce mois-ci ; en petit, la valeur pour { $before }
late = En retard
nothing-late = Rien de ce qui était à rendre ce mois-ci n’est arrivé en retard, ni ne le sera.
late-text =
    { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    } de { $orders ->
        [one] { $orders } commande
       *[other] { $orders } commandes
    } : après l’échéance, ou pas encore imprimé.
without-order = Sans commande
done-about-untold = fin vers { $time }, personne n’ayant rien signalé
done-at = fin { $time }
chart-height = Hauteur des plateaux
chart-density = Densité
chart-used = Hauteur de machine utilisée
more-machines =
    et { $count ->
        [one] { $count } autre machine
       *[other] { $count } autres machines
    }, dans le tableau seulement
height-curve = Hauteur pendant la recherche, mm par seconde écoulée
height-over-time = Hauteur dans le temps
all-machines = toutes les machines

costs = Coûts
costs-by-order = Part de chaque commande
costs-by-build = Part de chaque commande dans chaque plateau
costs-text = Le temps machine et la poudre d'un plateau sont répartis selon le volume des pièces ; litres et exemplaires sont ceux de chaque commande. Les exemplaires ratés sont à la charge de l'atelier. Les tarifs sont ceux du moment où le plateau a été préparé. La poudre est la poudre neuve que les plateaux ont prise.
no-prices = Rien n'a de prix. Les tarifs sont dans `[costs]` du fichier d'une machine.
figure-cost = de coût
order-costs = Elle coûte { $cost } jusqu'ici.
farm-bears-bad-copies = exemplaires ratés : à la charge de l'atelier
csv-by-order = CSV par commande
csv-by-build = CSV par plateau
this-month = Ce mois
