mail-refused-subject = { $machine } : { $name } a été refusé
mail-refused = { $machine } n’accepte pas le fichier { $name } :
mail-refused-of-order = { $machine } n’accepte pas le fichier { $name } de la commande { $order } :
mail-refused-nameless-subject = { $machine } : un fichier a été refusé
mail-refused-nameless = { $machine } n’accepte pas un fichier déposé :
mail-refused-several =
    { $count ->
        [one] { $machines } : { $count } fichier a été refusé
       *[other] { $machines } : { $count } fichiers ont été refusés
    }
mail-at-risk-subject = { $machine } : une échéance est menacée
mail-at-risk-subject-order = Commande { $order } sur { $machine } : l’échéance est menacée
mail-at-risk = Sur { $machine }, des pièces risquent d’être en retard :
mail-at-risk-several =
    { $count ->
        [one] { $machines } : { $count } échéance est menacée
       *[other] { $machines } : { $count } échéances sont menacées
    }
mail-alerts-several =
    { $count ->
        [one] { $machines } : { $count } point demande quelqu’un
       *[other] { $machines } : { $count } points demandent quelqu’un
    }
mail-dropped-subject = Des messages du parc d’impression n’ont pas pu être remis
mail-dropped = Des messages n’ont pas pu être remis et ne seront pas renvoyés : { $what }.
mail-complete-subject = Votre commande { $order } est terminée
mail-complete-several = Vos commandes { $orders } sont terminées
mail-complete = Votre commande { $order } est terminée. Toutes ses pièces sont imprimées :
mail-complete-line = { $copies } × { $name }
mail-complete-more =
    { $count ->
        [one] et { $count } autre pièce
       *[other] et { $count } autres pièces
    }
mail-footer = Ce message a été écrit par nestd sur le serveur { $host }, où il gère le parc d’impression. Le tableau de bord du parc en dit plus.
mail-footer-customer = Ce message a été écrit par le logiciel du parc d’impression.
mail-trial-subject = Un message d’essai du parc d’impression
mail-trial = Ceci est un essai. nestd sur le serveur { $host } peut vous envoyer des messages sur le parc d’impression.
