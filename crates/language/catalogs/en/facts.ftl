machine-unavailable = unavailable: { $trouble }
machine-paused = paused by { $by }
free-now = free now
build-is-proved =
    build { $build } is proved ({ $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    })
build-awaits-yes =
    build { $build } waits for a yes ({ $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    })
build-is-searched =
    build { $build } is being searched ({ $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    })
reading-files =
    reading { $files ->
        [one] { $files } file
       *[other] { $files } files
    }
collecting-copies =
    collecting { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
copies-await-material =
    { $copies ->
        [one] { $copies } copy waits
       *[other] { $copies } copies wait
    } for { $material }
copies-await-answer =
    { $copies ->
        [one] { $copies } copy waits
       *[other] { $copies } copies wait
    } for an answer
print-times-set = { $per_mm } h per mm and { $hours } h, as set
print-times-learned =
    { $per_mm } h per mm and { $hours } h, from { $prints ->
        [one] { $prints } print
       *[other] { $prints } prints
    }
printer-free-from = free from { $time }
printer-closed = closed until { $time }
printer-never-open = its calendar is not open again
printer-ended = build { $build } should be done since about { $until }: nobody told how it printed
printer-prints-estimated = printing build { $build } until about { $until } (estimated)
printer-prints = printing build { $build } until about { $until }
printer-cools-estimated = cooling build { $build } until about { $until } (estimated)
printer-cools = cooling build { $build } until about { $until }
printer-expects = build { $build } is made for it
printer-queued-until = build { $build } lies in its queue and could begin { $time }
printer-queued = build { $build } lies in its queue
then-more-builds =
    then { $count ->
        [one] { $count } more build
       *[other] { $count } more builds
    }
printer-down = down since { $since } by { $by }
fires-when-full-or = when full, or at { $at } if nothing more arrives ({ $latest } at the latest), { $content }: { $why }
fires-when-full = when full, at the latest { $latest }, { $content }: { $why }
fires-due = a due date comes near
fires-due-of = deadline of { $name }
fires-at = at { $time }
fires-waited = waited long enough
with-copies-high =
    with { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }, { $height } mm high
with-copies =
    with { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
night-goes-on = goes on
night-stands-still = rests: more time gains too little
night-used-up = rests: its time is used up
night-given-up = given up
night-since-arrival = { $gain } since the last arrival, { $state }
night-gain = { $gain } mm lower after { $secs } CPU s
night-no-gain = not lower after { $secs } CPU s
held-queue-full = the queue is full (queue_depth = { $depth }): it fires when a printer takes a file, when the outcome of a build in the queue is told, or on a flush
name-and-more = { $name } and { $count } more
risk-due-done = due { $due }, { $word }, done about { $done }: { $why }
risk-due = due { $due }, { $word }: { $why }
about-height = about { $height }
plan-paused = Nothing of { $machine } fires: it is paused.
plan-unavailable = Nothing of { $machine } fires: it is unavailable.
plan-no-printer = Nothing of { $machine } fires or starts until one of its printers is in use again (nestd printer NAME up): all are down.
plan-nothing = Nothing waits for { $machine }, and nothing is printed.
plan-done = If nothing more arrives, all of { $machine } is done { $time }.
plan-unknown = It is not known when the builds of { $machine } are done.
plan-unplanned =
    { $parts ->
        [one] { $parts } part can be in no build yet: it is not read, waits for an answer or its material, or lacks its file.
       *[other] { $parts } parts can be in no build yet: they are not read, wait for an answer or their material, or lack their file.
    }
plan-heights-usual = Heights marked 'about' go by the usual density.
plan-heights-learned =
    Heights marked 'about' go by the last { $builds ->
        [one] build
       *[other] { $builds } builds
    }.
count-machines =
    { $count ->
        [one] { $count } machine
       *[other] { $count } machines
    }
count-copies-wait =
    { $count ->
        [one] { $count } copy waits
       *[other] { $count } copies wait
    }
count-builds-in-work =
    { $count ->
        [one] { $count } build in work
       *[other] { $count } builds in work
    }
halted = halted: the ledger { $fault }
ledger-is-damaged = is damaged
ledger-has-lost = has lost changes
ledger-was-replaced = was removed, replaced or overwritten
ledger-is-taken-over = is served by another nestd in place of this one
silent-locked = { $by } keeps the ledger from being changed: nestd waits until it has finished its change, or is ended
silent-disk = Where the disk of the state folder is full, free some room
silent-database = Its way to the database is cut or slow, or all changes wait for one connection, which its alerts then name

## Why a part was refused

cause-format = its format is not known, or the file is truncated
cause-not-closed = the surface is not closed
cause-mendable = the surface is not closed, and can be mended
cause-too-large = it does not fit into the machine
cause-limit = the file exceeds a limit
cause-ticket = its ticket or list is wrong, or belongs to no part
cause-document = it is a document, not a part
cause-missing = its file never came
cause-duplicate = the same file was dropped before
cause-unreadable = nestd may not read it, or it is no file
cause-failure = nestd could not process it
cause-cancelled = somebody cancelled it
cause-replaced = a newer revision took its place
cause-other = refused

## Alerts

alert-alone = { $headline }.
alert-detailed = { $headline }: { $detail }.
alert-quoted = { $headline }: { $detail }.
alert-of = { $machine }: { $what }
