drop-time-needs-date = a time of day needs its date
no-whole-number = { $field }: '{ $text }' is no whole number
files-of = Files: { $formats }
drop-copies = Copies of each file; empty = as its name says (bracket_x10.stl), else 1
drop-due = Due (the end of that day, unless with a time)
drop-more = Turning, priority, note
drop-orientation = How the parts may be turned
orientation-machine = as the machine allows
drop-priority = Priority, 0 to 100; 100 must be in the next build
files-sent-to = Files that are sent to { $machine }
add-to = Add to { $machine }
orientation-free = free: any way
orientation-upright = upright: about the vertical
orientation-axis = axis: in right angles
orientation-fixed = fixed: as in the file
form-not-of-farm = this form comes from no page of this farm as it is now: load the page again and press once more
form-sent-otherwise = this form was sent before, with something else in it: load its page again, and send it from there
form-of-number = form of that number
form-sent-before = This form was sent before, { $time }, and is not carried out a second time. To do the same once more, load its page again.
back = Back
add-files-to = Add files to { $machine }
add-files-text = The files go into the hot folder of { $machine }, with what you say here, as if they were copied there. What cannot be printed is refused there, with the reason.
no-orders-from-pages = This farm takes no orders from pages; put files into the hot folder { $folder }.
others-add-files = others are adding files just now: try again in a moment
form-takes-files =
    a form takes { $files ->
        [one] { $files } file
       *[other] { $files } files
    } at most
no-file-chosen = no file was chosen
files-were-added = Files were added
file-is-there = { $file } is in the hot folder of { $machine }.
file-not-added = Not added: { $why }.
file-is-taken-after = nestd takes it when it has not changed for { $secs } s; what cannot be printed is refused with the reason.
field-is-no-text = a field of the form is no text
undo = Undo
done = Done
refused = Refused
form-not-known-text = This form was sent, and then nestd ended or its ledger failed: it is not known whether all of it was done. Look before you send it once more, from its page, loaded again.
form-not-known = Not known
such-order = such order
takes-no-orders = this farm takes no orders from pages; see web.orders
not-answered-text = The daemon has not answered; the order is noted and is done when it runs.
not-answered = Not answered yet
refused-in-part = Refused in part
it-is-done = It is done.
there-is-no = there is no { $what }
refused-but-done = Refused: { $refused }
done-all-the-same = Done all the same: { $done }
not-understood = This address or this form cannot be understood
correct-told = Correct what was told
tell-printed = Tell how it printed
it-prints = It prints
print-again = Print again
withdraw = Take it back out of the queue
requeue = The same build once more
copies-again = Its copies, in new builds
reprint-build-text = Its copies count as bad and wait again, first in line, with all that was asked. They come in new builds.
reprint-build = Print every copy again
withdraw-text = Only while its printer has not taken its file. Its copies wait again, with all that was asked. The machine is paused, so that they can be changed or cancelled, until somebody resumes it.
is-taken-back = It is being taken back.
take-back = Take it back
requeue-text = The same proved build is issued as a new one: the same copies in the same places. Copies that count as printed count as bad then.
requeue-build = Issue this build once more
second-file = A second file of it was seen in the queue: { $files }. Where it is printed from there, take the other one out, and say that it prints.
second-file-unprinted = Nobody prints the second file
print-failed = The print of build { $build } on { $machine } failed. Nobody has seen to it yet.
print-failed-why = The print of build { $build } on { $machine } failed: { $why }. Nobody has seen to it yet.
waits-for-yes = Waits for a yes
waits-for-yes-text = It waits for a yes before it is published.
publish-it = Release it
outcome-complete = complete
outcome-interrupted = interrupted: the machine stopped
outcome-failed = failed: nothing of it is good
the-print-is = The print is
keep-bad = Do not print bad copies again
bad-copies-text = Bad copies wait again with all that was asked; of a failed print all copies do.
correct-outcome = Correct the outcome
tell-outcome = Tell the outcome
unseen-build = (build { $build })
build-named = build { $build }
names-no-bad-copies = '{ $text }' names no bad copies: say part = copies, for example 7=2, 9=1
anyway = Take it out of the queue and do it anyway
files-are-read = files of it are being read: ask again to cancel what they become
cancelled-before = { $name } was cancelled before it was taken.
change-order = Change the order
move-to = Move to another machine
change-order-text =
    For all { $parts ->
        [one] { $parts } waiting part
       *[other] { $parts } waiting parts
    }. An empty field changes nothing.
due-example-none = Due, for example 2026-11-25 (the end of that day) or 25.11.2026 17:00; none = no date
priority-range = Priority, 0 to 100
move-order-text =
    The { $parts ->
        [one] { $parts } waiting part
       *[other] { $parts } waiting parts
    } of this order move, and are read again there.
move-order = Move the order
reprint-order-text = Every printed copy of this order counts as bad and waits again, first in line, with all that was asked.
reprint-order = Print every printed copy again
accept-of = Accept { $copies } of { $all }
close-order-text = Closes the order as it is: what is good, printed or in a build is accepted.
close-cancels =
    { $copies ->
        [one] { $copies } waiting copy
       *[other] { $copies } waiting copies
    } will be cancelled.
close-asks-not =
    Nobody is asked any more for { $copies ->
        [one] { $copies } refused copy
       *[other] { $copies } refused copies
    }.
cancel-order-text =
    { $parts ->
        [one] { $parts } part waits
       *[other] { $parts } parts wait
    }. Copies that are in builds already stay there.
cancel-order = Cancel what waits
nothing-of-order-waits = nothing of this order waits any more
nothing-filled-in = nothing was filled in
edit = Edit
copies-wanted = Copies wanted in all, those in builds included
due-example = Due, for example 2026-11-25 (the end of that day) or 25.11.2026 17:00; empty = no date
no-copy-waits = No copy of it waits: more copies can be asked for, and another customer and other finishing steps named.
change = Change
move-part-text = All waiting parts of its file move, and are read again there.
move-part = Move
copies-that-are-bad = Copies that are bad
reprint-part-text = They wait again, first in line, with all that was asked. The copies of the newest build are taken first.
a-number-of-copies = a number of copies
part-named = part { $part }
a-priority = a priority
not-in-range = '{ $text }' is not { $what } from { $least } to { $most }
is-not-what = '{ $text }' is not { $what }
on-these-pages = On these pages: { $link }.
page-of-address = page of that address
guard-host = this farm does not answer to that name; see web.hosts
guard-role = this needs the role { $needed }, and you have { $own }
guard-other-site = to other sites' pages this farm answers only when a person follows a link, and orders are taken from its own pages
guard-other-page = orders are taken from this farm's own pages, and another site's page asks; behind a proxy its name must be in web.hosts

drop-formats = STL, 3MF, OBJ, PLY, CAMSPEC or ZIP
