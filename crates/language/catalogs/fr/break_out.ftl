bins = Bacs
bin = Bac
bin-not-found = Introuvables
bin-in-cake = Dans le gâteau
break-out-title = Déballer le plateau { $build }
whole-pick-map = Tout le plan de déballage, à imprimer
on-other-screens = Sur d’autres écrans
last-elsewhere =
    { $count ->
        [one] Le dernier exemplaire est sur un autre écran
       *[other] Les { $count } derniers exemplaires sont sur d’autres écrans
    }
said-before = { $who } l’a déjà signalé, { $when } : { $word }. Est-ce un autre exemplaire que vous avez en main ?
said-already = Déjà signalé
said-since = { $who } a signalé entre-temps, { $when }, que cet exemplaire est { $word }. Cela reste. Revenir à l’exemplaire pour dire autre chose.
not-recorded = Pas enregistré
no-copies-of-build = Ce ne sont pas des exemplaires de ce plateau.
recorded-as =
    { $copies ->
        [one] { $copies } exemplaire enregistré
       *[other] { $copies } exemplaires enregistrés
    } : { $word }.
recorded-in-part = Enregistré en partie
copy-is-said-before = { $copy } est { $word }, comme { $who } l’a déjà signalé. Cela reste.
nothing-to-undo-text = Quelqu’un en a dit autre chose depuis, ou l’a déjà défait.
nothing-to-undo = Rien à défaire
told-of =
    { $told } sur { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
break-out-counts = { $told } : bons { $good }, mauvais { $bad }, introuvables { $missing }, dans le gâteau { $open }.
copies-told = Exemplaires déjà signalés
copy-of-all = Exemplaire { $number } sur { $all }
bin-number = Bac { $number }
the-part = La pièce { $name }
chosen-copy = Choisi : numéro { $number }, { $name }, exemplaire { $copy }.
comes-out-downwards = Il sort quand on soulève ou retourne le gâteau.
looks-like = Ressemble à { $names }.
go-on-next = Continuer avec le suivant
later-next = Plus tard : montrer le suivant
on-screen-of = Il est affiché chez { $name }.
have-in-hand = Je l’ai en main
was-told-bad = Il a été signalé mauvais, et attend d’être réimprimé.
copy-is-said = Il est { $word }, comme { $who } l’a signalé, { $when }.
still-in-cake = Il est encore dans le gâteau
press-out = Sorti
press-bad = Mauvais
press-missing = Introuvable
place-of-copy = Haut à { $top } mm, { $x } mm depuis la gauche, { $y } mm depuis l’avant.
place-not-known = Son original n’est plus conservé : sa place n’est pas connue.
way-out = Sortie : { $way }.
copy-number = Exemplaire { $copy }.
still-in-cake-count =
    Encore dans le gâteau : { $copies ->
        [one] { $copies } exemplaire
       *[other] { $copies } exemplaires
    }
screen-of = affiché chez { $name }
all-out-good = Tous ceux-ci sont sortis et bons
none-found = Aucun de ceux-ci n’a été trouvé
told-bad = signalé mauvais
the-end = Fin
cake-is-empty = Le gâteau est vide
good-of-all =
    { $good ->
        [one] { $good } exemplaire bon
       *[other] { $good } exemplaires bons
    } sur { $copies }.
outcome-is-told = Le résultat est signalé.
tell-some-again = Signaler : imprimé, et ceux-ci à refaire
tell-all-good = Signaler : imprimé, tout est bon
bad-wait-again = Les exemplaires mauvais ou introuvables attendent à nouveau, les premiers de tous, avec tout ce qui était demandé.
name-and-copy = { $name }, exemplaire { $copy }
last-press-all = Dernier appui : { $copies } exemplaires, { $word }, par { $who }, { $when }.
last-press = Dernier appui : { $number } { $name }, exemplaire { $copy }, { $word }, par { $who }, { $when }.
undo-all = Défaire les { $count }
copy-title = { $number } : { $name }, exemplaire { $copy }
published-build = plateau publié { $build } ; on peut le déballer une fois imprimé
bin-no-order = sans commande
mark-out = sorti
mark-bad = sorti et mauvais
mark-missing = introuvable
mark-open = encore dans le gâteau
step-plan = Où il se trouve, vu d’en haut
all-of-part-out = Les { $count } de cette pièce ici : sortis
all-of-order-out = Les { $count } de cette commande ici : sortis
all-without-order-out = Les { $count } sans commande ici : sortis
your-name = Votre nom
that-is-me = C’est moi
who-works = Qui travaille ici ? Le nom est demandé une seule fois sur cet appareil.
you-are = Vous êtes { $name }.
somebody = quelqu’un
