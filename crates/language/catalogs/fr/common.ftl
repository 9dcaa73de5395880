### Words of all pages: counts, dates, times.

## Dates

# A day near today: ven. 4 déc.
date-day =
    { $weekday } { $day ->
        [1] 1er
       *[other] { $day }
    } { $month }
# A day far from today: 4 déc. 2027.
date-year =
    { $day ->
        [1] 1er
       *[other] { $day }
    } { $month } { $year }
# octobre 2026.
date-month = { $month } { $year }
date-today = aujourd’hui
date-tomorrow = demain
date-yesterday = hier
# $day is one of the above; $clock is 05:49.
date-clock = { $day } { $clock }
# A time that nobody told.
about-time = vers { $time }
# On the axis of the board.
date-today-alone = Aujourd’hui
# In a sentence to a customer: vendredi 4 décembre; the sentences have the article.
date-long =
    { $weekday } { $day ->
        [1] 1er
       *[other] { $day }
    } { $month }
date-long-year =
    { $weekday } { $day ->
        [1] 1er
       *[other] { $day }
    } { $month } { $year }
weekday-long =
    { $weekday ->
        [1] lundi
        [2] mardi
        [3] mercredi
        [4] jeudi
        [5] vendredi
        [6] samedi
       *[7] dimanche
    }
weekday-short =
    { $weekday ->
        [1] lun.
        [2] mar.
        [3] mer.
        [4] jeu.
        [5] ven.
        [6] sam.
       *[7] dim.
    }
month-short =
    { $month ->
        [1] janv.
        [2] févr.
        [3] mars
        [4] avr.
        [5] mai
        [6] juin
        [7] juil.
        [8] août
        [9] sept.
        [10] oct.
        [11] nov.
       *[12] déc.
    }
month-long =
    { $month ->
        [1] janvier
        [2] février
        [3] mars
        [4] avril
        [5] mai
        [6] juin
        [7] juillet
        [8] août
        [9] septembre
        [10] octobre
        [11] novembre
       *[12] décembre
    }

## Durations

# $span is 3h 5m or 2d 2h, as it is written in all languages.
due-in = dans { $span }
due-overdue = dépassée de { $span }
# $delay is 40 min, 28 h, 3 days.
late-by = { $delay } de retard
delay-min = { $minutes } min
delay-hours = { $hours } h
delay-days =
    { $days ->
        [one] { $days } jour
       *[other] { $days } jours
    }

## Counts

count-copies =
    { $count ->
        [one] { $count } exemplaire
       *[other] { $count } exemplaires
    }
count-parts =
    { $count ->
        [one] { $count } pièce
       *[other] { $count } pièces
    }
count-files =
    { $count ->
        [one] { $count } fichier
       *[other] { $count } fichiers
    }
count-builds =
    { $count ->
        [one] { $count } plateau
       *[other] { $count } plateaux
    }
count-more-builds =
    { $count ->
        [one] { $count } autre plateau
       *[other] { $count } autres plateaux
    }

## Labels of fields: headings of tables and of facts

field-build = Plateau
field-part = Pièce
field-machine = Machine
field-state = État
field-state-in-the-ledger = État dans le registre
field-time = Heure
field-question = Question
field-reason = Raison
field-reason-or-warning = Raison ou avertissement
field-note = Note
field-height = Hauteur
field-machine-height = Hauteur machine
field-bound = Minimum
field-density = Densité
field-mean-density = Densité moyenne
field-used = Utilisé
field-machine-time = Temps machine
field-parts = Pièces
field-cake = Gâteau
field-failed = Échoués
field-powder = Poudre
field-price = Prix
field-currency = Monnaie
field-yield = Rendement
field-layers = Couches
field-layer = Couche
field-copies = Exemplaires
field-copies-here = Ex. ici
field-copies-waiting = Ex. en attente
field-of = Sur
field-lines = Lignes
field-wanted = Demandés
field-in-builds = En plateau
field-queued = En file
field-printing = En impression
field-printed = Imprimés
field-good = Bons
field-refused = Refusés
field-bad = Mauvais
field-bad-copies = Mauvais exemplaires
field-cancelled = Annulés
field-builds = Plateaux
field-volume = Volume
field-clearance = Espacement
field-proved = Vérifié
field-cpu = Temps CPU
field-wall-time = Temps réel
field-evaluations = Évaluations
field-seed = Graine
field-method = Méthode
field-search = Recherche
field-repeats = Répétitions
field-version = Version
field-fired-by = Déclencheur
field-opened = Ouverture
field-nesting = Placement
field-verified = Vérification
field-published = Publication
field-file = Fichier
field-file-or-reason = Fichier ou raison
field-content = Contenu
field-made = Création
field-name = Nom
field-order = Commande
field-e-mail = Adresse e-mail
field-customer = Client
field-material = Matériau
field-finishing = Finition
field-lot = Lot de poudre
field-loaded = Chargé
field-priority = Priorité
field-due = Échéance
field-claimed = Pris en charge
field-orientation = Orientation
field-size = Taille
field-warning = Avertissement
field-where = Où
field-origin-of-the-file-at = Origine du fichier à
field-turned = Tourné
field-break-out = Déballage
field-mended = Réparé
field-copy = Exemplaire
field-when = Moment
field-kind = Type
field-detail = Détail
field-told = Signalé
field-outcome = Résultat
field-by = Par
field-printer = Imprimante
field-free-from = Libre dès
field-since = Depuis
field-print-times = Temps d’impression
field-fires = Départ
field-begins = Début
field-unpacking = Déballage
field-closed = Clôture
field-to-send = À envoyer
field-done = Fin
field-order-or-part = Commande ou pièce
field-risk = Risque
field-taken = Pris
field-released = Accord
field-reference = Référence
field-withdrawn = Retrait
field-waiting = En attente
field-oldest = Le plus ancien
field-next-build = Prochain plateau
field-while-it-waits = Pendant l’attente
field-node = Nœud
field-host = Hôte
field-last-sign = Dernier signe
field-address = Adresse
field-machines = Machines
field-now = Maintenant
field-being-read = En lecture
field-last-published = Dernière publication
field-no = N°
field-top = Haut
field-bottom = Bas
field-x = x
field-y = y
field-way = Sortie

## Words of states, as chips show them: of builds, machines, printers, copies, parts, orders and dates

state-complete = réussi
state-good = bon
state-kept = date tenue
state-on-time = à temps
state-done = terminée
state-runs = en marche
state-printing = en impression
state-should-be-printed = sans doute imprimé
state-cooling = refroidit
state-nesting = en placement
state-being-made = en préparation
state-being-read = en lecture
state-reading = en lecture
state-under-way = en cours
state-open = ouvert
state-waiting = en attente
state-collecting = en collecte
state-queued = plateau en file
state-in-the-queue = dans la file
state-at-the-printer = à l’imprimante
state-proved = vérifié
state-expecting = plateau prévu
state-in-a-build = dans un plateau
state-later = plus tard
state-free = libre
state-closed-now = fermé
state-withdrawn = retiré
state-cancelled = annulé
state-closed = close
state-stopped = arrêté
state-no-date = sans échéance
state-tight = délai serré
state-ended = impression finie
state-should-be-done = devrait être fini
state-waits-for-a-yes = attend un accord
state-paused = en pause
state-interrupted = interrompu
state-short = incomplète
state-missing = introuvable
state-is-to-be-repaired = à réparer
state-on-its-way-to-another-printer = change d’imprimante
state-being-taken-back = retrait en cours
state-overdue = date dépassée
state-late = en retard
state-failed = échoué
state-refused = refusé
state-bad = mauvais
state-down = hors service
state-unavailable = indisponible
state-does-not-answer = ne répond pas
details = Détails
close = Fermer
skip = Aller au contenu
pages = Navigation
nav-farm = Parc
nav-orders = Commandes
nav-history = Historique
nav-month = Mois
nav-help = Aide
search-farm = Chercher dans le parc
footer-lengths = . Longueurs en mm.
footer-json = Interface JSON
footer-metrics = Métriques
search-example = Pièce, plateau 3
search-key = Touche / pour chercher
search = Rechercher
to-the-farm = Vers le parc

## Titles of error pages

http-bad-request = Requête incorrecte
http-unauthorized = Identification requise
http-forbidden = Accès interdit
http-not-found = Introuvable
http-method-not-allowed = Méthode non autorisée
http-conflict = Conflit
http-payload-too-large = Envoi trop volumineux
http-misdirected-request = Requête mal adressée
http-unprocessable-entity = Requête impossible à traiter
http-too-many-requests = Trop de requêtes
http-internal-server-error = Erreur interne du serveur
http-service-unavailable = Service indisponible
http-error = Erreur

## States of builds as the ledger has them

ledger-open = ouvert
ledger-nesting = en placement
ledger-verified = vérifié
ledger-published = publié
ledger-printing = en impression
ledger-complete = réussi
ledger-interrupted = interrompu
ledger-failed = échoué
ledger-claimed = en lecture
ledger-waiting = en attente
ledger-batched = en préparation
ledger-built = fabriqué
ledger-refused = refusé

## What happened, as the list of events says it

event-in-a-build = dans un plateau
event-in-the-queue = dans la file
event-waiting = en attente
event-refused = refusé
event-open = ouvert
event-nesting = en placement
event-verified = vérifié
event-published = publié
event-printing = en impression
event-complete = réussi
event-interrupted = interrompu
event-failed = échoué
event-paused = mise en pause
event-resumed = fin de pause
event-unavailable = indisponible
event-available = disponible
event-adopted = reprise par un autre nœud
event-damaged = fichier endommagé
event-size-differs = taille différente
event-healed = fichier rétabli
event-at-risk = échéance en danger
event-attempt-failed = tentative échouée
event-proof-failed = vérification échouée
event-locked = pièces enchevêtrées
event-put-out = sorti du plateau
event-no-room = pas de place
event-clock-set = heure réglée
event-messages-dropped = messages abandonnés
event-put-back = remis en attente
event-copies-cancelled = exemplaires annulés
event-copies-wanted = exemplaires demandés
event-edited = modifié
event-moved = déplacé
event-loaded = chargé
event-confirmed = accord donné
event-finishing = finition
event-revised = remplacé
event-seen = marqué comme vu

## What fired a build

trigger-flush = lancement
trigger-full = plein
trigger-fill = remplissage
trigger-copies = nombre d’exemplaires
trigger-max-wait = attente maximale
trigger-due = échéance
trigger-at = heure fixée
trigger-withdrawn = retrait

turned-free = libre
turned-upright = debout
turned-axis = angles droits
turned-fixed = fixe

## Signs between words

sign-comma = ,{ " " }
sign-semicolon = { " " };{ " " }
sign-stop = .
sign-colon = { " " }:{ " " }

## The reason that lies beside a refused file

cause-and-reason = { $cause } (détail en anglais : { $reason })
reason-refused = { $name } a été refusé.
reason-file = Fichier : { $place }
reason-when = Date : { $time }
reason-part = Pièce { $part } de la machine { $machine }.
reason-retry = Pour la reprendre : nestd retry { $part }

# A build or a date with what is known of it.
job-described = { $name } : { $what }.
search-words-build = plateau plateaux
search-words-part = pièce pièces fichier fichiers
search-words-order = commande commandes
search-words-customer = client clients
search-words-machine = machines machine
