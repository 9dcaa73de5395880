a-number-of-orders = un nombre de commandes
a-state-of-order = un état de commande
order-named = commande nommée « { $order } »
first-orders =
    { $count ->
        [one] { $count } commande, la première de plusieurs
       *[other] { $count } commandes, les premières d’un plus grand nombre
    }
count-orders =
    { $count ->
        [one] { $count } commande
       *[other] { $count } commandes
    }
name-contains = Le nom contient
customer-contains = Le client contient
no-such-orders = Aucune commande de ce genre
no-such-orders-text = Ici viennent les fichiers d’un dossier au nom d’une commande, ou avec un ticket ou une liste qui en nomme une.
all-orders = Toutes les commandes
order-title = Commande { $order }
send-to-customer = À envoyer au client
copy-text = Copier
count-lines =
    { $count ->
        [one] { $count } ligne
       *[other] { $count } lignes
    }
lines-arrive =
    { $count ->
        [one] { $count } ligne de plus est venue par requête et sera là dans un instant.
       *[other] { $count } lignes de plus sont venues par requête et seront là dans un instant.
    }
where-copies-are = Où sont les exemplaires
copies-wait-for-build =
    { $count ->
        [one] { $count } exemplaire attend
       *[other] { $count } exemplaires attendent
    } un plateau.
order-in-no-build = Aucun exemplaire n’est encore dans un plateau.
what-happened-who = Ce qui s’est passé, et qui l’a fait
events = Événements
order-for = Pour { $customer }.
order-since = { $copies } ; depuis { $time }.
order-due = Échéance { $due }.
order-done = Fin { $time }
order-expected = Prévu { $time }
order-should-be-done = Devrait être fini depuis { $time }
order-closed = Close { $how }.
order-short-text = Tout n’est pas bon, ou ne le sera pas : déposer à nouveau ce qui a été refusé, ou accepter la commande telle quelle.
a-state-of-part = un état de pièce
the-number-of-part = le numéro d’une pièce
file-begins-with = Le fichier ou la commande commence par
parts-text = Pièces en lecture, en attente, dans un plateau en préparation, ou refusées ces 30 derniers jours. Demander les autres par état ou par nom.
next-parts = Les pièces d’avant
newest-parts =
    { $count ->
        [one] { $count } pièce, la plus récente de plusieurs
       *[other] { $count } pièces, les plus récentes d’un plus grand nombre
    }
no-parts = Aucune pièce.
part-title = Pièce { $part } : { $name }
part-of-order = Pièce de la commande { $order }.
where-its-copies-are = Où sont ses exemplaires
what-happened = Ce qui s’est passé
same-file = Le même fichier à d’autres moments
other-files = Autres fichiers de ce nom
part-number = Pièce { $part }
part-in-no-build = Dans aucun plateau : { $why }.
part-in-open-build =
    { $waiting ->
        [one] { $waiting } exemplaire attend
       *[other] { $waiting } exemplaires attendent
    } ; déjà dans le plateau ouvert { $build } : { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }.
part-waits =
    { $waiting ->
        [one] { $waiting } exemplaire attend
       *[other] { $waiting } exemplaires attendent
    }, encore dans aucun plateau.
search-for-text = Recherche : { $text }
nothing-found = Rien ne porte cela dans son nom.
search-help = Chercher un morceau quelconque du nom d’une pièce, d’un fichier, d’une commande, d’un client, d’un plateau ou d’une machine, en majuscules ou en minuscules ; de plusieurs mots, un nom doit contenir chacun. Un numéro trouve le plateau et la pièce qui le portent :
found-part = pièce { $part }, { $state } sur { $machine }
found-orders = commandes
found-customers = clients
count-customers =
    { $count ->
        [one] { $count } client
       *[other] { $count } clients
    }
found-builds = plateaux
found-machines = machines
found-parts = pièces
or-more = { $number } ou plus
more-not-shown = { $link } : { $what }, { $count } de plus.
show-more = Montrer plus
closed-by =
    { $time } par { $by }, avec { $accepted ->
        [one] { $accepted } exemplaire
       *[other] { $accepted } exemplaires
    } sur { $copies }
no-copies = aucun exemplaire
not-known = inconnu
not-known-taken-as-one = inconnu, compté comme 1
copies-not-known = inconnu ({ $copies })
lines-without-number =
    { $lines ->
        [one] quantité inconnue pour { $lines } ligne
       *[other] quantité inconnue pour { $lines } lignes
    }
waits-for-yes-to = Attend un accord : { $question }
waits-for-material = Attend que { $material } soit chargé sur { $machine }
in-build-state = { $copies } dans le plateau { $build } ({ $state })
none-in-build = aucun dans un plateau
and-more = et { $count } de plus
bad-copies-of = { $count } (n° { $numbers })
copies-good =
    { $count ->
        [one] { $count } bon
       *[other] { $count } bons
    }
copies-printed =
    { $count ->
        [one] { $count } sans doute imprimé
       *[other] { $count } sans doute imprimés
    }
copies-printing = { $count } en impression
copies-queued = { $count } dans la file d’attente
copies-in-build = { $count } dans un plateau
copies-waiting = { $count } en attente
copies-refused =
    { $count ->
        [one] { $count } refusé
       *[other] { $count } refusés
    }
copies-bad = { $count } mauvais
copies-withdrawn =
    { $count ->
        [one] { $count } retiré
       *[other] { $count } retirés
    }
copies-cancelled =
    { $count ->
        [one] { $count } annulé
       *[other] { $count } annulés
    }
note-refused =
    { $parts ->
        [one] { $parts } pièce n’est pas fabriquée
       *[other] { $parts } pièces ne sont pas fabriquées
    }
note-one-not-printed = la pièce n’est pas encore imprimée
note-none-printed = aucune des { $parts } pièces n’est encore imprimée
note-one-printed = la pièce est imprimée
note-all-printed = les { $parts } pièces sont toutes imprimées
note-one-should = elle devrait être imprimée
note-all-should = les { $parts } pièces devraient être imprimées
note-some-should = { $printed } pièces sur { $parts } devraient être imprimées
note-some-printed =
    { $printed ->
        [one] { $printed } pièce sur { $parts } est imprimée
       *[other] { $printed } pièces sur { $parts } sont imprimées
    }
note-complete = Votre commande { $order } est complète : { $printed }.
note-cancelled = Votre commande { $order } a été annulée.
note-closed =
    Votre commande { $order } est terminée avec { $accepted ->
        [one] { $accepted } pièce
       *[other] { $accepted } pièces
    } sur { $parts }.
note-order = Votre commande { $order } : { $how }.
note-all-expected = le tout est attendu pour le { $day }
note-rest-expected = le reste est attendu pour le { $day }
note-all-made = le tout est en production
note-rest-made = le reste est en production
note-all-not-known = leur date n’est pas encore connue
note-rest-not-known = la date du reste n’est pas encore connue
note-sorry = Nous sommes désolés : elle était prévue pour le { $day }.
note-and-expected = { $how }, { $expected }
note-and-refused = { $how } ; { $refused }
note-then-sorry = { $note } { $sorry }
finishing-done = Fait : { $done } sur { $steps }
finishing-by = fait : { $who }, { $when }
finishing-open = pas encore fait
finishing-is-done = C’est fait
finishing-not-yet = Pas encore fait
