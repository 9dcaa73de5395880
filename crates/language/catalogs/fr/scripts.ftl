script-lost = Pas de connexion au parc depuis { $time }. Ce qui est affiché date d’avant.
script-changed = Le contenu de ce plateau a changé.
script-load-again = Recharger la vue 3D
script-too-large = { $name } est plus gros que ce que ce parc accepte ({ $size }).
script-sent-of = { $sent } sur { $all } envoyés
script-sent = Envoyé ; le parc l’enregistre.
script-answers = Le parc répond { $status }.
script-connection-lost = La connexion a été coupée. Renvoyer : ce qui a été ajouté ne l’est pas deux fois.
script-which-machine = Quelle machine ?
script-asking = demande quand ce serait terminé
script-no-answer = pas de réponse
script-done = fin vers { $time }
script-no-date-known = date inconnue
script-adds = { $done }, ajoute { $height } mm
script-one-late = une échéance serait en retard
script-several-late = { $count } échéances seraient en retard
script-copied = Copié
script-no-view-script = Pas de vue 3D : son script n’est pas arrivé.
script-no-view = Pas de vue 3D : { $why }.
script-last-out = sort en dernier
script-first-out = sort en premier
script-no-proved-order = ordre de sortie pas vérifié
script-what-has-no-order = ce qui est sans commande
script-part-not-here = une pièce qui n’est pas ici
script-chosen =
    Choisi : { $what }, { $count ->
        [one] { $count } exemplaire
       *[other] { $count } exemplaires
    }. « Tout montrer » y met fin.
script-show-all = Tout montrer
script-layer = { $height } mm, couche { $layer } sur { $layers }
script-copy-from-to = exemplaire { $copy }, de { $low } à { $top } mm
script-step = rang de sortie { $step }
script-simplified = (dessin simplifié)
script-missing =
    { $missing } sur { $count ->
        [one] { $count } exemplaire
       *[other] { $count } exemplaires
    } : pas montré, car l’original n’est plus conservé.
script-front = AVANT
script-soonest = au plus tôt
