break-out-steps = Déballer pas à pas
pick-map = Plan de déballage
acts-print = Impression
acts-unpack = Déballage
acts-again = Réimprimer
nothing-in-it = Rien n’y est encore placé.
figure-high = de haut, sur { $volume }
figure-copies =
    { $count ->
        [one] exemplaire
       *[other] exemplaires
    }
figure-bad =
    { $count ->
        [one] mauvais exemplaire
       *[other] mauvais exemplaires
    }
figure-dense = de densité
figure-unpacked = déballage, d’après ce qu’on sait
what-became = Ce qu’il est devenu
outcomes = Résultats
file-build = Fichier du plateau, { $format }
file-build-for = ce que l’imprimante reçoit
file-report = Rapport, HTML
file-report-for = à envoyer : vue 3D, données et plan de déballage en un fichier
file-picture = Image, PNG
file-pick-csv = Plan de déballage, CSV
file-pick-csv-for = pour un tableur
file-pick-json = Plan de déballage, JSON
file-json = Plateau, JSON
file-json-for = tout ce qu’on en sait
file-search = Rapport de la recherche, JSON
file-not-kept = Son fichier n’est plus conservé ici : son imprimante l’a pris, ou il n’est pas encore créé.
files = Fichiers
build-file-of = fichier du plateau { $build } sur ce nœud
search-report-of = rapport de la recherche du plateau { $build } sur ce nœud
flush-machine = Lancer le plateau de { $machine } ?
nothing-to-build = Rien n’attend : il n’y a rien à préparer.
in-no-layout =
    { $copies ->
        [one] { $copies } exemplaire en attente n’est encore dans aucune disposition. La recherche finale essaie de le prendre aussi.
       *[other] { $copies } exemplaires en attente ne sont encore dans aucune disposition. La recherche finale essaie de les prendre aussi.
    }
flush-now = Lancer maintenant
unseen-flush-now = { $machine } : publier ce qui attend maintenant
not-now = Pas maintenant
in-layout-so-far = Déjà dans la disposition
in-layout = Dans la disposition
waiting-in-no-layout = En attente, dans aucune disposition
flush-title = Lancer le plateau de { $machine }
copies-of-parts =
    { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    } de { $parts ->
        [one] { $parts } pièce
       *[other] { $parts } pièces
    }
they-wait = En attente : { $waiting }.
layout-stands-dense = La disposition actuelle en contient { $copies }, avec { $height } de haut et une densité de { $density }.
layout-stands = La disposition actuelle en contient { $copies }, avec { $height } de haut.
flush-text = Un lancement cherche pendant { $secs } s, vérifie le plateau et le met dans la file d’attente ; il peut encore devenir plus bas. Les exemplaires sans place continuent d’attendre.
pick-map-of = Plan de déballage du plateau { $build }
pick-forecast = Une prévision : les places changent jusqu’à ce que le plateau soit publié. Ne pas s’en servir pour déballer.
made-by = Créé par nestd { $version }. Longueurs en mm.
parts-not-shown =
    { $parts ->
        [one] { $parts } pièce n’est pas montrée : l’original n’est plus conservé.
       *[other] { $parts } pièces ne sont pas montrées : les originaux ne sont plus conservés.
    }
seed = graine { $seed }
asked = { $clearance } demandé
picture-of-cake = Le plateau, vu de devant, un peu de droite et d’en haut
pick-axes = x depuis la gauche, y depuis l’avant, haut et bas depuis le fond.
pick-downwards = Les exemplaires qui partent vers le bas sortent quand on soulève ou retourne le gâteau.
listed-without-place =
    { $parts ->
        [one] { $parts } pièce est listée sans place : l’original n’est plus conservé.
       *[other] { $parts } pièces sont listées sans place : les originaux ne sont plus conservés.
    }
pick-sheet = Exemplaires : { $title }
pick-done = Fait
pick-proved-order = Chaque exemplaire sort en ligne droite sans toucher ceux qui suivent dans la liste : c’est vérifié sur les triangles. « Sortie » dit vers où.
pick-height-order = Par hauteur, de haut en bas ; il n’est pas dit ici si chacun sort sans toucher les autres.
pick-from-to = { $first } à { $last }
pick-from-down = À partir de { $height } mm, vers le bas
pick-no-originals = Originaux plus conservés
pick-plan = Ce qu’ils couvrent, vu d’en haut, avec leurs numéros
front = avant
name-of-order = { $name } (commande { $order })
picture-of-refused = La pièce telle que déposée ; là où sa surface n’est pas fermée, les arêtes sont rouges
picture-of-mended = La pièce telle que réparée ; les endroits réparés sont rouges
picture-of-part = La pièce telle que déposée
picture-so-far = état actuel
picture-published-last = dernier publié
height-not-known = hauteur pas encore connue
so-high = hauteur { $height }
picture-of-build = Plateau { $build }, { $what } : { $copies }, { $height }
colour-part = pièce
colour-order = commande
colour-due = échéance
colour-height = hauteur
colour-step = ordre de sortie
view-3d = Vue 3D
view-needs-script = La vue 3D a besoin de JavaScript.
view-needs-script-report = La vue 3D a besoin de JavaScript ; le plan de déballage a une image.
view-keys =
    Disposition de { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    } ; les flèches la tournent, + et - l’agrandissent ou la réduisent
view-hint = Pointer un exemplaire ou une ligne de la liste pour voir ce que c’est ; appuyer pour le garder choisi.
parts-by-order = Pièces par commande
no-order = Sans commande
colour-by = Couleur selon
layers-up-to = Couches jusqu’à
explode = Éclater
whole-view = Vue entière
event-taken = pris en charge
fired-and-nested =
    { $trigger }, placé { $count ->
        [one] une fois
       *[other] { $count } fois
    }
ago = il y a { $age }
time-by = { $time } par { $by }
on-its-way-to = { $printer }, en route vers { $other }
bound-text = { $bound } : aucun plateau de ces pièces n’est plus bas
clearance-proved = { $clearance } vérifié sur les triangles
clearance-no-two = vérifié : aucun n’est proche d’un autre
clearance-once-fired = vérifié après le départ
clearance-asked = { $asked } demandé, { $proved }
evaluations =
    { $count ->
        [one] { $count } évaluation
       *[other] { $count } évaluations
    }
cpu-secs = { $secs } s de CPU
wall-secs = { $secs } s réelles
bytes-and-hash = { $bytes } octets, BLAKE3 { $hash }
state-since = { $state } depuis { $time }
triangles = { $count } triangles
not-read-yet = pas encore lu
as-ticket-says = { $clearance }, d’après son ticket
way-up = haut
way-down = bas
way-right = droite
way-left = gauche
way-back = arrière
way-front = avant
mended-text = { $what } ; permis par { $by } ; BLAKE3 du maillage réparé { $hash }
