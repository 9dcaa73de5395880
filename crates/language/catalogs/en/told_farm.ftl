### Sentences of the farm, as they are stored in English: details of alerts, builds that failed, events, answers to commands.

## Errors of the operating system

told-os-gone = No such file or directory (os error 2)
told-os-io = Input/output error (os error 5)
told-os-denied = Permission denied (os error 13)
told-os-exists = File exists (os error 17)
told-os-other-device = Invalid cross-device link (os error 18)
told-os-no-directory = Not a directory (os error 20)
told-os-is-directory = Is a directory (os error 21)
told-os-full = No space left on device (os error 28)
told-os-read-only = Read-only file system (os error 30)
told-os-not-connected = Transport endpoint is not connected (os error 107)
told-os-timed-out = Connection timed out (os error 110)
told-os-host-down = Host is down (os error 112)
told-os-stale = Stale file handle (os error 116)
told-os-quota = Disk quota exceeded (os error 122)
told-os-other = { $error } (os error { $number })

## Folders

told-reading-path = reading { $path }: { $why }
told-listing-path = listing { $path }: { $why }
told-creating-path = creating { $path }: { $why }
told-cannot-write = cannot write { $path }: { $why }
told-cannot-be-used = { $path } cannot be used: { $why }
told-queue-unavailable = the queue folder { $path } is unavailable: { $why }
told-inbox-unavailable = the hot folder { $path } is unavailable: { $why }
told-queue-not-available = the queue folder is not available any more
told-it-is-not-there = it is not there
told-it-is-no-folder = it is not a folder
told-it-cannot-be-listed = it cannot be listed
told-marker-empty = the marker .nestd-queue is empty
told-other-file-system = it is on another file system than when nestd first saw it; mount it again, or restart nestd
told-file-system-changed = its file system changed while it was listed
told-served-by-other = { $path } is served by another nestd: process { $pid } on { $host } since { $since }, with the state folder { $state }. Stop that one, or give each farm folders of its own
told-folder-replaced = { $path } is not the folder that was there before: its marker { $marker } is missing. Mount it again; if it was replaced or emptied on purpose: touch { $file }
told-holds-more-files = { $path }: holds more than { $most } files; the rest waits
told-other-file-system-inside = { $path }: is another file system; parts cannot be claimed from it
told-recycle-bin = { $path }: is a recycle bin by its name, so nothing in it is printed
told-folder-denied = { $path }: cannot be read: permission denied
told-cannot-be-read-path = { $path } cannot be read
told-file-damaged-hash = { $path } is damaged: its bytes do not match its hash

## Details of alerts

told-and-more = { $why }; and { $more } more
told-and-more-comma = { $why }, and { $more } more
told-and-more-parts = { $why } and { $more } more
told-files-in =
    { $n ->
        [one] { $n } file in { $path }
       *[other] { $n } files in { $path }
    }
told-files-beside = { $name } in { $path }
told-files-beside-more = { $name } and { $more } more in { $path }
told-in-claimed = { $files } in its .claimed folder
told-part-named = part { $part } ({ $file })
told-part-asks = part { $part } ({ $file }): { $why }
told-build-named = build { $build }
told-build-why = build { $build }: { $why }
told-release-brief =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }, { $height } of { $limit } mm high, { $density } % dense, about { $hours } h of printing
told-node-serves-it = the node { $node } serves it
told-node-is-gone = its node { $node } does not run
told-node-with-machines = { $node } on { $host }, with { $names }
told-gone-with-work =
    { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    } and { $builds ->
        [one] { $builds } build
       *[other] { $builds } builds
    } in work
told-gone-with-lines =
    { $why }, and { $n ->
        [one] { $n } line
       *[other] { $n } lines
    } ordered by request
told-ended-during-search-more = nestd ended { $times } times during a search for build { $build }: the next search begins { $secs } s after a start. Its parts are { $names } and { $more } more; `nestd cancel PART` takes one out
told-ended-during-search = nestd ended { $times } times during a search for build { $build }: the next search begins { $secs } s after a start. Its parts are { $names }; `nestd cancel PART` takes one out
told-printer-configured-no-more = the printer { $printer } is configured no more, and { $file } may lie in its queue folder, as build { $build }
told-step-obeying = obeying a control file
told-step-recording-drop = recording a drop
told-step-recording-refusal = recording a refusal
told-step-late-ticket = applying a late ticket
told-step-originals = fetching originals
told-step-command = command { $number }

## Files in a queue

told-queue-other-machine = { $file } is build { $build } of { $machine }: take it to a queue of { $machine }
told-queue-not-proved = { $file } is not the file that was proved as build { $build }: take it out, look whether it was printed, and tell the outcome of build { $build }
told-queue-does-not-fit = { $file } does not fit, for { $detail }. `nestd withdraw { $build }` takes it out, and its copies are nested for the machine as it is now
told-queue-second-on-way = { $file } is a second file of build { $build }, which is on its way out of a queue: take it out
told-queue-second-lies-at = { $file } is a second file of build { $build }, which lies at { $printer }: take it out
told-queue-second-taken-out = { $file } is a second file of build { $build }, which was taken out of the queue of { $printer }: where that one is printed, take this one out; where it was only moved away, `nestd dismiss b{ $build }`
told-queue-failed-file = { $file } is the file of build { $build }, which is { $what }: take it out, or its copies are printed a second time
told-queue-failed-complete = { $file } is the file of build { $build }, which is { $what }: take it out, or its copies are printed a second time; where it was printed all the same, `nestd outcome { $build } complete --correct` says so
told-queue-failed-withdrawn = { $file } is the file of build { $build }, which is { $what }: take it out, or its copies are printed a second time; where it was printed all the same, take as many of those that wait out with `nestd cancel PART=N` (`nestd show b{ $build }` lists its parts)
told-queue-was-out-before = { $file } is the file of build { $build } ({ $what }), which was out of the queue before: take it out
told-word-printing = printing
told-word-complete = complete
told-word-interrupted = interrupted
told-word-failed = failed
told-word-withdrawn = withdrawn
told-word-published = published

## Builds that failed or went back

told-build-gave-up =
    build { $build } gave up after { $n ->
        [one] { $n } failed attempt
       *[other] { $n } failed attempts
    }: { $why }
told-build-gave-up-detail =
    build { $build } gave up after { $n ->
        [one] { $n } failed attempt
       *[other] { $n } failed attempts
    }: { $detail }
told-gave-up =
    gave up after { $n ->
        [one] { $n } failed attempt
       *[other] { $n } failed attempts
    }: { $why }
told-gave-up-detail =
    gave up after { $n ->
        [one] { $n } failed attempt
       *[other] { $n } failed attempts
    }: { $detail }
told-build-gave-up-stopped = build { $build } gave up after { $attempts } attempts: nestd stopped each time
told-gave-up-stopped = gave up after { $attempts } attempts: nestd stopped each time
told-build-given-up = build { $build } is given up: { $why }
told-is-given-up = is given up: { $why }
told-is-given-up-detail = is given up: { $detail }
told-no-copy-has-place = none of its copies has a place in the machine as it is now
told-no-copy-left = none of its copies is left in it
told-the-build-failed = the build failed
told-build-the-build-failed = build { $build } the build failed
told-proving = proving the written build: { $why }
told-not-proved = the written build is not proved: { $detail }
told-panicked = panicked: { $detail }
told-search-stopped = its search was stopped after { $secs } s, and goes on from what it has found
told-withdrawn-by = withdrawn from the queue by { $by }
told-withdrawn-why = withdrawn from the queue by { $by }: { $reason }
told-withdrawn-record = taken back out of the queue untouched, as its record in the archive says
told-put-back-from-backup = the ledger was put back from a backup
told-urgent-goes-with-it = copies of the highest priority go with it
told-arrived-goes-with-it = copies that arrived go with it
told-printer-is-down = the printer { $printer } is down
told-made-again = made again: { $why }
told-machine-changed = the machine has changed since it was proved: { $detail }
told-staged-removed = its staged file was removed
told-staged-other = its staged file is not the one that was proved

## Copies that are not in the next build

told-left-open-build =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of { $who } left the open build for { $others }. { $what } first in line for the next one.
told-left-open-build-alone =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of { $who } left the open build. { $what } first in line for the next one.
told-cannot-be-in-next =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of { $who } cannot be in the next build: { $why }. { $what } first in line for the one after it.
told-name-priority = { $file } (part { $part }, priority { $priority })
told-other-parts =
    { $others } and { $n ->
        [one] { $n } other part
       *[other] { $n } other parts
    }
told-it-is = It is
told-they-are = They are
told-no-room-beside = there is no room beside { $others }, which goes first
told-no-room-beside-copies = there is no room beside its other copies
told-no-place-found = no place was found for it in the empty build volume
told-whole-volume-first = what goes first has the volume of the whole build

## Refusals that people or orders caused

told-cancelled-by = Cancelled by { $by }.
told-line-cancelled = Its line was cancelled before it was taken.
told-newer-revision = A newer revision, part { $part }, of the same name came while this one waited, and took its place. Where both are wanted, take this one back.
told-newer-revision-order = A newer revision, part { $part }, of the same name came for order { $order } while this one waited, and took its place. Where both are wanted, take this one back.
told-after-the-backup = It lies in the error folder: it was refused or cancelled after the backup was made.
told-maybe-printed = A build file in the queue holds the same file, so it may be printed already.
told-taken-over-by-other = Another nestd has taken over this file while this one did not answer, and prints it.
told-no-reason = no reason was given

## What happened: parts and orders

told-trigger-flush = flush
told-trigger-full = full
told-trigger-fill = fill
told-trigger-copies = copies
told-trigger-max-wait = max_wait
told-trigger-due = due
told-trigger-at = at
told-ledger-query-failed = a query of the ledger failed: { $detail }
told-step-taking-in = taking in what a job has done
told-step-new-configuration = taking over the new configuration (nothing of it applies before that)
told-process-named = process { $pid } ({ $name })
told-another-process = another process
told-put-back-in-time = it was put back to an earlier time inside its file: it counts { $count } changes, and this nestd has seen { $seen }
told-record-of-build = according to the record of a build
told-imported-record = imported from its record in the archive
told-imported-from-build = imported from the record of a build
told-replaces-part-all = it replaces part { $old }, an earlier revision, with all that was asked with it
told-replaces-refused = it replaces part { $old }, which was refused
told-replaces-refused-all = it replaces part { $old }, which was refused, with all that was asked with it
told-replaces-refused-terms = it replaces part { $old }, which was refused, with all that was asked with it but the copies
told-replaces-part-terms = it replaces part { $old }, an earlier revision, with all that was asked with it but the copies
told-replaces-part-date = it replaces part { $old }, an earlier revision, with its due date and its note
told-more-wanted-record = { $more } more wanted, according to the record of a build
told-published-after-backup = its build was published after the backup was made
told-decided-since = It was refused, cancelled, taken back or changed after the backup was made.
told-decided-since-wanted = It was refused, cancelled, taken back or changed after the backup was made, and { $copies } copies of it were wanted then.
told-decided-since-one = It was refused, cancelled, taken back or changed after the backup was made, and 1 copy of it was wanted then.
told-out-of-queue-said = out of the queue, as { $by } said
told-once-more-asked = build { $build } once more, asked for by { $by }
told-requeue-word = requeue
told-same-dropped-again = the same file was dropped again
told-taken-back = taken back
told-taken-back-mend = taken back; { $name } says that its mesh may be mended
told-other-mending = its mesh is not mended now as it was when it was first read. `nestd confirm { $part }` has it read and mended anew.
told-told-at-break-out = told when it was broken out
told-no-copy-waits-any-more = no copy waits any more
told-file-not-needed = its file is not needed any more
told-by-whom = by { $by }
told-has-seen-to-it = { $by } has seen to it
told-copies-instead =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } instead of { $before }
told-as-it-was-taken =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }, as it was taken
told-more-wanted-by = { $more } more wanted by { $by }
told-fewer-wanted-by = { $fewer } fewer wanted by { $by }
told-order-instead = order { $new } instead of { $old }
told-customer-instead = customer { $new } instead of { $old }
told-priority-instead = priority { $new } instead of { $old }
told-due-instead = due { $new } instead of { $old }
told-note-instead = note { $new } instead of { $old }
told-unit-instead = unit { $new } instead of { $old }
told-moved-from-to = from { $from } to { $to }
told-replaces-part = it replaces part { $old }, an earlier revision
told-part-took-its-place = part { $new } of the same name took its place
told-clock-set = by { $jump }; the ages of parts are kept
told-put-back-from-build =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } put back from build { $build } by { $by }
told-not-wanted-again =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of build { $build } not wanted again, as { $by } said
told-printed-well-after-all = a copy in build { $build } was printed well after all
told-not-taken-printer-first = not taken back: its printer took the file first
told-not-taken-not-proved = not taken back: what lies in the queue is not the file that was proved
told-not-taken-second = not taken back: its copies lie in the queue as { $places }
told-back-in-queue-of = back in the queue of { $printer }
told-lies-in-queue-again = its file lies in the queue of { $printer } again
told-closed-order = { $by }: order { $name } { $what }
told-closed-with =
    closed with { $accepted } of { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }
told-closed-without-it = { $by }: its order was closed without it
told-step-done = { $by }: { $name } is done
told-step-not-done = { $by }: { $name } is not done
told-steps-open-again = more copies are made: its finishing steps are open again

## Answers to what people say on pages

told-is-being-nested =
    build { $build } is being nested with { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }
told-nothing-waits-in = nothing waits in { $machine }
told-is-paused = { $machine } is paused
told-was-paused-already = { $machine } was paused already
told-runs-again = { $machine } runs again
told-was-not-paused = { $machine } was not paused
told-resume-first = { $machine } is paused; resume it first
told-no-printer-in-use = no printer of { $machine } is in use; `nestd printer { $printer } up` puts one into use again
told-copies-cancelled =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of part { $part } cancelled
told-has-values-already = part { $part } has these values already
told-part-changed = part { $part }: { $why }
told-part-moved = part { $part } moved to { $machine }, and read again there
told-parts-moved = parts { $parts } moved to { $machine }, and read again there
told-part-is-for = part { $part } is for { $machine } already
told-printed-as-it-is = part { $part } is printed as it is
told-no-confirmation = part { $part } waits for no confirmation
told-part-mended = part { $part } is read again, and its mesh is mended
told-nothing-to-mend = part { $part } was not refused because of its mesh: `nestd retry { $part }` reads it again as it is
told-is-read-again = part { $part } is read again
told-part-is-cancelled = part { $part } is cancelled
told-no-such-part = there is no part { $part }
told-no-such-machine = there is no machine { $machine }
told-no-such-build = there is no build { $build }
told-waits-for-its-file = part { $part } waits for its file: drop that once more, and give the command again when it is read
told-ticket-of-part-unread = the ticket of part { $part } could not be read: mend it and drop both again
told-refused-already = part { $part } is refused or cancelled already; `nestd show p{ $part }` says why
told-built-already = part { $part } is built already: all its copies are in published builds
told-build-is-told = Build { $build } is { $what }.
told-build-stays-told = Build { $build } stays { $what }, as it was told before.
told-issued-once-more = Build { $build } is issued once more as build { $new }.
told-is-released = Build { $build } is released and goes to the queue.
told-was-released-before = Build { $build } was released before.
told-failure-dismissed = The failed print of build { $build } is dismissed; its copies are as they were.
told-second-dismissed = The second file of build { $build } is dismissed: what lies in a queue now is its only one.
told-now-down = The printer { $printer } is down: it is given no builds.
told-takes-again = The printer { $printer } takes builds again.
told-was-not-down = The printer { $printer } was not down.
told-taken-back-unless = Build { $build } is taken back out of the queue of { $printer }, unless the printer is first. Its page says what became of it.
told-noted-taken-first = Noted: the file of build { $build } is taken out of the queue of { $printer } first; then it is done.
told-wait-again =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    } { $what } again, first in line, with all that was asked.
told-waits = waits
told-wait = wait
told-order-is-closed = Order { $name } is { $what }.

## What a command or a form is refused for

told-other-state = build { $build } is { $what }, not { $rest }
told-word-open = open
told-word-nesting = nesting
told-word-verified = verified
told-word-claimed = claimed
told-word-waiting = waiting
told-word-batched = batched
told-word-built = built
told-word-refused = refused
told-or-words = { $what } or { $rest }
told-made-again-since = build { $build } was made again since you looked at it: look at what it is now
told-not-released-made-again = build { $build } is not released: it is made again, for { $detail }
told-file-not-in-queue = the file of build { $build } is not in the queue: its printer took it, or it is on its way to another printer
told-in-build-as-it-is = part { $part } has copies in build { $build }, which is { $what } and is printed as it is: wait until it is published, and give the command again for the copies that still wait. Printed copies are made anew with `nestd reprint { $part }=N`
told-only-refused-retried = part { $part } is { $what }; only a part that is refused or cancelled can be retried
told-outcome-recorded = the outcome of build { $build } is recorded as { $what } already; if that is wrong, say `nestd outcome { $build } { $asked } --correct`
told-outcome-the-same = the outcome of build { $build } is recorded as { $what } already, so nothing was changed
told-outcome-the-same-bad = the outcome of build { $build } is recorded as { $what } already, so nothing was changed; if other copies of it are bad, say `nestd outcome { $build } { $asked } --correct --bad PART=N`
told-was-taken-back-untouched = the file of build { $build } was taken back out of the queue untouched: it does not count as printed, and its copies are made again. If somebody printed copies of its file all the same, take as many of those that wait out with `nestd cancel PART=N`; `nestd show b{ $build }` tells when, and lists its parts
told-none-counts-as-printed = no copy of it counts as printed: `nestd show` says what waits, `nestd edit PART --copies N` orders more
told-copies-being-cancelled = copies of part { $part } are being cancelled, and its build begins after that
told-can-be-cancelled =
    { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    } of part { $part } can be cancelled, not { $asked }; the others are in builds: `nestd show p{ $part }` lists them
told-only-what-waits = part { $part } is { $what }, and only what waits can be changed; { $remedy }
told-retry-first = `nestd retry { $part }` takes it back first
told-edit-orders-more = `nestd edit { $part } --copies N` orders more of it
told-lies-untouched = the file of build { $build } lies untouched in the queue of { $printer }, as if nobody had printed it. Look whether the number is right. If it is, insist ({ $insist }): nestd takes the file out of the queue first, so that nobody prints it a second time
told-lies-untouched-untold = the file of build { $build } lies untouched in the queue, and nobody told how it was printed. If it was not printed, take it back: `nestd withdraw { $build }`. If it was, tell its outcome first with the copies that are bad: `nestd outcome { $build } complete --bad PART=N`
told-second-unseen = a second file of build { $build } was seen in the queue as { $places }, and nestd cannot look there now. Look yourself: take it out if it lies there. Where nobody printed it, `nestd dismiss b{ $build }`, and say it again
told-second-gone = a second file of build { $build } lay in the queue as { $places }, and is gone. Where that one is or was printed, take the file in the queue of { $printer } out and say it again. Where nobody printed it, `nestd dismiss b{ $build }`, and say it again
told-lies-other-file = what lies in the queue of { $printer } as the file of build { $build } is not the file that was proved. Take it out of the queue, look whether it was printed, and say it again
told-on-its-way = the file of build { $build } is on its way to another printer: say it again when it is there
told-being-taken-back = the file of build { $build } is being taken back out of the queue: `nestd show b{ $build }` says what became of it
told-no-such-order = there is no order { $name }; `nestd orders --all` lists them
told-nothing-to-close = nothing of order { $name } waits or was refused, so there is nothing to close; `nestd show order { $name }` says what became of it
told-order-being-read = files of order { $name } are being taken and read; close it in a moment
told-printer-fallback-waits = The builds of { $machine } wait until a printer of it is up.
told-not-taken-goes-to = What it has not taken goes to { $printer }.
told-copies-cancelled-of-order =
    { $n ->
        [one] { $n } copy that waits is cancelled.
       *[other] { $n } copies that wait are cancelled.
    }
told-copies-not-asked =
    { $n ->
        [one] { $n } copy that was refused is not asked for any more.
       *[other] { $n } copies that were refused are not asked for any more.
    }
told-to-be-taken-out = the file of build { $build } was to be taken out of the queue, for its copies are to be printed again, but { $why }: nothing was changed. { $remedy }
told-lies-under-its-name = what lies in the queue under its name is not the file that was proved
told-copies-lie-as = its copies lie in the queue as { $places }
told-printer-took-first = its printer took it first
told-lies-elsewhere = it lies at { $place }, and not where it was published
told-take-out-look-say = Take that out of the queue, look whether it was printed, and say it once more
told-take-out-say = Take that out of the queue, and say it once more
told-say-when-known = Say it once more when it is known how it is printed
told-say-once-more = Say it once more
told-published-in-no-queue = build { $build } is not taken back: it was published in a queue folder that is no printer's any more. Where its file is not printed, `nestd outcome { $build } failed` has its copies wait again
told-configuration-nothing = nothing of it applies: { $detail }
told-no-answer-in-time = it did not answer in time
told-no-finishing-steps = part { $part } has no finishing steps; `nestd edit { $part } --finish '{ $name }'` gives it this one
told-no-such-step = part { $part } has no finishing step '{ $name }', only { $names }
told-step-not-printed = no copy of part { $part } is printed, so '{ $name }' cannot be done

## Why a due date is at risk

risk-passed = that date has passed
risk-too-long = its print takes too long for that
risk-left-out = it finds no place in the next build beside what goes first
risk-awaits-fire = its build does not fire before { $time }
risk-printers-busy = the printers are busy until { $time }
risk-no-begin = no printer begins a print
risk-printer-closed = the printer begins no print before { $time }
risk-awaits-release = its build waits for a person's yes
risk-awaits-answer = it waits for a person's answer
risk-awaits-material = its material is not loaded on the machine
risk-file-missing = its file is damaged or being fetched
risk-not-read = its file is not read yet
risk-paused = the machine is paused
risk-unavailable = the machine is unavailable
risk-no-printer = no printer of the machine is in use
told-at-risk-one = { $name } is due { $due }: { $why }
told-at-risk-one-of = { $name } of { $names } is due { $due }: { $why }
told-at-risk = { $names } are due { $due }: { $why }
told-at-risk-of = { $names } of { $name } are due { $due }: { $why }
told-at-risk-more = { $names } and { $more } more are due { $due }: { $why }
told-at-risk-more-of = { $names } and { $more } more of { $name } are due { $due }: { $why }
told-machine-not-configured = its machine is not configured

## What is loaded

told-loaded-before = { $material } was loaded on { $machine } before
told-nothing-loaded-before = Nothing was loaded on { $machine } before
told-loaded-now = { $material } is loaded on { $machine } now: its next build is made of that
told-nothing-loaded-now = Nothing is loaded on { $machine } now: parts that say their material wait
told-others-wait =
    { $parts ->
        [one] { $parts } part there waits
       *[other] { $parts } parts there wait
    } for another material; `nestd status` says for which
told-fired-of-other = Build { $build } fired before and is of { $material }: print it first, or withdraw it
told-material-not-named = [materials] in nestd.toml does not name '{ $material }', only { $names }: use one of these, or add it there and reload nestd
told-no-machine-here = there is no machine '{ $machine }' here
told-part-not-loaded = part { $part } is of { $material }, which is not loaded on { $machine }; `nestd machine load { $machine } '{ $material }'` says that it is
