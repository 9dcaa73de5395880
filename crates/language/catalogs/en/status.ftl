status-drop = { $machine }: drop { $formats } files here.
status-now = Now: { $doing }.
status-paused = PAUSED by { $by } since { $time }: nothing is fired.
status-no-printer = No printer is in use: nothing is fired.
status-being-read =
    { $files ->
        [one] { $files } file is being read.
       *[other] { $files } files are being read.
    }
status-open-build = Open build: { $height } mm high, { $share } % of the volume's height.
status-while-waiting = While it waits: { $night }.
status-fires = It fires { $when }.
status-held = The open build waits: { $why }.
status-last-build = Last build: { $build } on { $time }, { $height } mm.
status-waiting =
    { $copies ->
        [one] { $copies } copy of { $parts } waits
       *[other] { $copies } copies of { $parts } wait
    }
status-stopped = { $machine }: nestd was stopped on { $time }: this folder is not scanned, and nothing is built. Files dropped here are taken when it runs again.
status-until-then = { $waiting } until then.
status-halted = { $machine }: this folder is not scanned, and nothing is built, until that is mended. What is dropped here stays here.
status-written = Written { $time }.
status-waits-to-begin = { $machine }: nestd waits before it begins; what is dropped here waits.
status-does-not-run = { $machine }: nestd does not run; what is dropped here waits.
status-node-gone = { $machine }: its node { $node } on { $host } has not run since { $time }. What is dropped here waits until it runs again, or until another node takes this machine over.
attention = ATTENTION: { $what }
attention-more = ATTENTION: and { $count } more; `nestd status` tells all.
status-stamp =
    Written { $time }, and renewed at least every { $minutes ->
        [one] { $minutes } minute
       *[other] { $minutes } minutes
    } while nestd runs: if this is older, nestd is not running.
question-yes = It waits for a yes: { $question }.
question-yes-remedy = `nestd confirm { $part }` prints it as it is, `nestd cancel { $part }` refuses it.
question-original = Its original is missing or damaged, so it is not printed.
question-original-remedy = Drop { $name } once more, or take it back with `nestd cancel { $part }`.
question-copies = How many copies? It is taken as 1.
question-copies-remedy = `{ $command }` answers it, and `nestd confirm { $part }` leaves it at 1.
material-awaited = It waits for { $material }: { $machine } has { $loaded } loaded.
material-awaited-none = It waits for { $material }: nothing is loaded on { $machine }, as far as anybody said.
material-elsewhere = { $material } is loaded on { $machines }.
material-nowhere = { $material } is loaded on no machine.
material-unknown = [materials] in nestd.toml does not name { $material }, only { $known }.
material-remedy = `{ $load }` says that it is loaded, `nestd move { $part } --to MACHINE` moves the part, `nestd edit { $part } --material NAME` corrects it.
material-lot = { $material }, lot { $lot }
status-loaded = Loaded: { $material }.
status-question = Question: How many copies? part { $part } ({ $name }) is taken as 1; answer with `{ $command }`.
status-questions-more =
    The same is asked of { $parts ->
        [one] { $parts } more part
       *[other] { $parts } more parts
    }.
release-brief =
    { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }, { $height } of { $limit } mm high, { $density } % dense, about { $hours } h of printing
release-made-again = Build { $build } is made again, for { $why }.
release-build = Build { $build }: { $content }.
release-could-begin = On { $printer } it could begin at { $begins } and be unpacked at { $ends }.
release-not-known = It is not known when { $printer } could begin with it.
release-nothing-waits = Nothing else waits.
release-copies-wait =
    { $copies ->
        [one] { $copies } copy waits
       *[other] { $copies } copies wait
    } for the next build.
release-late-part = { $name } (due { $due })
release-late-part-of = { $name } of { $order } (due { $due })
release-none-late = No part in it would be late.
release-late = Late would be { $names }.
